"""The groups as tables and plots show them: names, places among the others, which are baselines."""

from dataclasses import dataclass

from analysis.plots import style
from analysis.prose import group_label


@dataclass(frozen=True)
class Shown:
    """A group.

    Attributes:
        group: the values of the columns that tell groups apart.
        index: of its looks: the place of its model among those of its kind, baselines or not, and from `palette.LOOKS`
            on that of a further group of the model.
        baseline: whether it is there to be compared with only.
    """

    group: tuple[str, ...]
    index: int
    baseline: bool

    @property
    def label(self) -> str:
        """Its name."""
        return group_label(self.group)

    @property
    def colour(self) -> str:
        """Its colour."""
        return style.colour(self.index, baseline=self.baseline)


def example_caption(seed: int) -> str:
    """Return what is said of pictures of single runs, all of one seed."""
    return f"Seed {seed}: the lowest of the sweep, settled before anything was run."
