"""A group as tables and plots show it."""

from dataclasses import dataclass

from analysis.plots import style
from analysis.prose import group_label


@dataclass(frozen=True)
class ShownGroup:
    """A group with its name, marker and colour in plots.

    Attributes:
        index: index of its marker and colour: the index of its model among the models, or among the baselines. Further
            groups of a model have indices from `palette.LOOKS` on.
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
    """Return the sentence with which captions begin if a plot shows only runs of one seed."""
    return f"Runs with seed {seed}, which is always the lowest seed of the sweep."
