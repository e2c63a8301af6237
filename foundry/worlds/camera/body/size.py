"""The body that moves through a scene."""

from __future__ import annotations

import math
from dataclasses import dataclass

from foundry.errors import InputError

RISE_M = 1e-3
"""By how much a step may be higher than the step height: models are seldom exact."""


@dataclass(frozen=True, slots=True)
class Body:
    """A vertical capsule that stands on its foot and walks over what is not higher than a step.

    It is tested as the cylinder around the capsule, from the step height up: exact beside walls and
    edges, and never closer to anything than the capsule may come. The steepest slope it climbs rises
    by the step height over its radius.

    Attributes:
        radius_m: metres.
        height_m: from the foot to the top of the head, metres.
        step_m: what it climbs up or down at once, and what is too low to stop it, metres.
    """

    radius_m: float
    height_m: float
    step_m: float = 0.25

    def __post_init__(self) -> None:
        if not (0 < self.radius_m < math.inf and 0 <= self.step_m < self.height_m < math.inf):
            raise InputError(
                f"A body of radius {self.radius_m}, height {self.height_m} and step height {self.step_m} m "
                "can not move. Give it a radius above 0 and a height above its step height, in metres."
            )

    def span(self, foot_z: float) -> tuple[float, float]:
        """Return the heights between which surfaces stop a body whose foot is at `foot_z`."""
        return foot_z + self.step_m + RISE_M, foot_z + self.height_m

    def stride(self, foot_z: float) -> tuple[float, float]:
        """Return the heights between which a floor can be stepped on from `foot_z`."""
        return foot_z - self.step_m - RISE_M, foot_z + self.step_m + RISE_M
