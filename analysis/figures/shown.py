"""The groups of tables and plots: names, order, baselines."""

from dataclasses import dataclass

from analysis.plots import style
from analysis.prose import group_label


@dataclass(frozen=True)
class Shown:
    """A group.

    Attributes:
        index: index of its look: the index of its model among models, or among baselines. Further groups of a model
            have indices from `palette.LOOKS` on.
    """

    group: tuple[str, ...]
    index: int
    baseline: bool

    @property
    def label(self) -> str:
        """Name of the group."""
        return group_label(self.group)

    @property
    def colour(self) -> str:
        """Colour of the group."""
        return style.colour(self.index, baseline=self.baseline)


def example_caption(seed: int) -> str:
    """Return the caption of plots of single runs, which are all of one seed."""
    return f"Seed {seed}: the lowest of the sweep, chosen before any run."
