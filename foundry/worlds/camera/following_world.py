"""The 3D world in which the agent follows a route in words, which foundry makes from the scene."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from foundry import seeding
from foundry.errors import InputError
from foundry.records import CameraStep, Pose, Record, SeenImage
from foundry.worlds.camera.camera_world import CameraWorld
from foundry.worlds.camera.loading.scene import FloatArray
from foundry.worlds.camera.surroundings import Target, make_pose
from foundry.worlds.camera.things import ThingsScenario
from foundry.worlds.camera.told_route import (
    ASIDE_M,
    GRAINS,
    MEASURED_ASIDE_M,
    FollowEpisode,
    Leg,
    legs_of,
    straightened,
    told,
)


@dataclass(frozen=True)
class Errand:
    """A route and its description.

    Attributes:
        target: thing at the end of the route.
        facing: angles to the target's middle at the end, from the heading and from the horizon, degrees.
        instruction: the route in words, by language.
    """

    target: Target
    start: Pose
    legs: list[Leg]
    facing: tuple[float, float]
    instruction: dict[str, str]


class FollowScenario(ThingsScenario):
    """A 3D world in which the agent follows a route in words.

    Description:
        The seed chooses an object and a start at random, such that the shortest route is within the limits of `way`.
        The route is straightened into legs and described: only the goal (`coarse`), turns with the things in view
        (`medium`), or every turn and length (`fine`). The agent moves and sees as in `CameraScenario`.

    Observation:
        The keys of `foundry.worlds.camera.camera_world`, and `instruction`: the route in words, `{english, japanese}`.
        In the task, the English text replaces `{instruction}`.

    Questions:
        One `move` question per step.

    Actions:
        The actions of `CameraScenario`.

    Termination:
        Terminated when the agent chooses to stay at the goal, that is, within the radius of the thing and with it in
        view. Truncated after `steps` decisions.

    Source:
        Anderson et al. 2018, Vision-and-Language Navigation; Krantz et al. 2020 for continuous scenes. foundry makes
        routes and words from the scene.
    """

    records: ClassVar[tuple[type[Record], ...]] = (CameraStep, FollowEpisode, SeenImage)

    def __init__(self, *, grain: str, way: Mapping[str, Any], things: Mapping[str, Any], **settings: Any) -> None:
        if grain not in GRAINS:
            raise InputError(f"world.grain={grain} is not one of: {', '.join(GRAINS)}.")
        self.grain = grain
        super().__init__(way=way, things=things, **settings)
        self._latest: tuple[int, Errand] | None = None

    def start(self, seed: int) -> "FollowWorld":
        """Return a fresh episode; the route's target and start are drawn with the seed."""
        return FollowWorld(self, self.errand(seed))

    def errand(self, seed: int) -> Errand:
        """Return the route of the run with this seed; the latest route is cached.

        Raises:
            InputError: the scene has no route of this length.
        """
        if self._latest is None or self._latest[0] != seed:
            streams = (seeding.stream(seed, name) for name in ("target", "start"))
            self._latest = (seed, self._told(*self.draw_way(*streams)))
        return self._latest[1]

    def _told(self, target: Target, start: Pose) -> Errand:
        points = self._straight(self.surroundings.way(start, target).points)
        legs = legs_of(self.things, start, points, target.name)
        heading = start.yaw + sum(leg.turn for leg in legs)
        facing = self.things.direction(target.name, make_pose(np.array(legs[-1].end), heading, 0.0))
        return Errand(target, start, legs, facing, told(self.grain, target.name, legs, facing))

    def _straight(self, points: FloatArray) -> FloatArray:
        """Return the points (k, 3) at the ends of the legs; the body can walk each leg."""
        if self.grain != GRAINS[-1]:
            return straightened(points, ASIDE_M, lambda *_: True)
        collider, body = self.surroundings.collider, self.surroundings.body
        return straightened(points, MEASURED_ASIDE_M, lambda here, there: collider.walkable(here, there, body))


class FollowWorld(CameraWorld):
    """One episode with a route in words."""

    def __init__(self, scenario: FollowScenario, errand: Errand) -> None:
        super().__init__(scenario, errand.target, errand.start)
        self._errand, self._grain = errand, scenario.grain

    def opening(self) -> Sequence[Record]:
        """Return the facts of the episode, including the route and its words."""
        errand = self._errand
        return [
            FollowEpisode(
                **self._facts(),
                grain=self._grain,
                instruction=errand.instruction,
                legs=errand.legs,
                facing=errand.facing,
            )
        ]

    def _observed(self) -> dict[str, Any]:
        return {**super()._observed(), "instruction": self._errand.instruction}

    def _task(self) -> str:
        return super()._task().replace("{instruction}", self._errand.instruction["english"])
