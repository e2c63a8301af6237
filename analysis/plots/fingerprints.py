"""Draws the fingerprints: a heatmap of the standardised means of all groups, and a tree of similar groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.arrays import FloatArray
from analysis.plots import style
from analysis.plots.labels import wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

COLOURS = "PuOr_r"
_ON_LINE: Any = {
    "ha": "center",
    "va": "center",
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.8},
}
LIMIT = 2.5
"""The colour scale shows standardised values from -LIMIT to LIMIT."""


@dataclass(frozen=True)
class Merge:
    """A merge of two branches of a dendrogram.

    Attributes:
        left: position of the left branch among the columns, from 0.
        right: position of the right branch.
        left_height: distance at which the left branch begins.
        right_height: distance at which the right branch begins.
        height: distance at which both branches merge.
        support: share of resamples of the seeds in which the same groups merge; NaN if unknown.
    """

    left: float
    right: float
    left_height: float
    right_height: float
    height: float
    support: float


@dataclass(frozen=True)
class FingerprintMap:
    """The standardised measures of the groups.

    Attributes:
        labels: names of the groups, in the order of the dendrogram.
        z: standardised means, (measures, groups); NaN where undefined.
        merges: the merges of the dendrogram, lowest first; empty with fewer than two groups.
    """

    labels: tuple[str, ...]
    measures: tuple[str, ...]
    z: FloatArray
    merges: tuple[Merge, ...]


def draw_fingerprint(ax: Axes, fingerprint: FingerprintMap) -> AxesImage:
    """Draw the heatmap with a row per measure and a column per group; a dash marks undefined values.

    Returns:
        The image, for its colour bar.
    """
    image = ax.imshow(fingerprint.z, cmap=COLOURS, vmin=-LIMIT, vmax=LIMIT, aspect="auto", interpolation="nearest")
    ax.set_facecolor("#EEEEEE")
    for row, column in np.argwhere(np.isnan(fingerprint.z)):
        ax.text(column, row, "–", ha="center", va="center", color="#666666", size=7)
    ax.set_xticks(range(len(fingerprint.labels)), [wrapped(label) for label in fingerprint.labels], rotation=90)
    ax.set_yticks(range(len(fingerprint.measures)), fingerprint.measures)
    ax.grid(False)
    ax.set_xticks(np.arange(len(fingerprint.labels) + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(len(fingerprint.measures) + 1) - 0.5, minor=True)
    ax.grid(True, which="minor", axis="both", color="white", linewidth=0.6)
    ax.tick_params(which="both", length=0)
    ax.spines[:].set_visible(False)
    return image


def draw_dendrogram(ax: Axes, merges: Sequence[Merge], groups: int) -> Axes:
    """Draw the dendrogram above the columns of the groups, with the support of each merge in per cent."""
    top = max((merge.height for merge in merges), default=1.0) or 1.0
    for merge in merges:
        ax.plot(
            [merge.left, merge.left, merge.right, merge.right],
            [merge.left_height, merge.height, merge.height, merge.right_height],
            color=style.DARK,
            linewidth=1.0,
        )
        if not np.isnan(merge.support):
            middle = (merge.left + merge.right) / 2
            ax.text(middle, merge.height, f"{100 * merge.support:.0f}", size=7, **_ON_LINE)
    ax.set_xlim(-0.5, groups - 0.5)
    ax.set_ylim(0, 1.25 * top)
    ax.axis("off")
    return ax
