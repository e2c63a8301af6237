"""Viewpoint sensitivity: how much the decisions of an agent of a 3D world depend on its image."""

import math

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.camera.camera_run import STILL_M, CameraRun, command_kinds
from analysis.camera.signatures.recognition import VISIBLE_PX
from analysis.formulas import entropy, mean
from analysis.measure import Measure, Null, share
from foundry.records import COMMAND_KINDS

NAME = "viewpoint"

_BLIND = "draws its decisions one by one, without regard to the image"

MEASURES = {
    "view_change": share("Other decision with another view of the same place (share of pairs)"),
    "same_view_change": share("Other decision with the same view (share of pairs)"),
    "view_effect": Measure(
        "Other decision for another view, beyond that for the same one",
        -2,
        2,
        Null(0, _BLIND),
        says="decides {more|less} by what it sees",
    ),
    "visible_information": Measure(
        "What the target in view tells of the decision (bits, beyond chance)", -1, 1, Null(0, _BLIND)
    ),
    "bearing_information": Measure(
        "What the side of the goal tells of the decision (bits, beyond chance)", -2, 2, Null(0, _BLIND)
    ),
    "approach_visible": share("Decisions that approach, target in view (share)"),
    "approach_hidden": share("Decisions that approach, target not in view (share)"),
    "approach_contrast": Measure("Approach with the target in view against without", -1, 1),
}

HEADLINE = ("view_effect", "visible_information", "bearing_information")

SAME_PLACE_M = 0.05
"""Metres up to which two feet stand at the same place."""

SAME_VIEW_DEG, OTHER_VIEW_DEG = 1.0, 15.0
"""Degrees up to which two views of a place are the same, and from which they are different ones."""


def measure(run: CameraRun) -> dict[str, float]:
    """Return how the decisions of a run depend on the view.

    A decision is its kind of command (`command_kinds`). Two views of the same place (feet up to SAME_PLACE_M
    apart) differ by the greater one of their differences in yaw and pitch. The target is in view with VISIBLE_PX
    pixels or more. Decisions that do not count are left out everywhere.

    - view_change: pairs of decisions of different kinds / pairs of decisions at the same place with views
      OTHER_VIEW_DEG apart or more; 0..1, the dispersion of decisions over views. NaN without such pairs.
    - same_view_change: the same for views up to SAME_VIEW_DEG apart: what varies without the view, by sampling or by
      what came before. NaN without such pairs.
    - view_effect: the same difference beyond chance: of each pair whether the kinds differ, less the chance of that for
      a second decision drawn from the decisions from there to the end of the run; mean over the pairs of one second
      decision, then over those; of other views less that of the same ones; -2..2. 0 for decisions drawn one by one
      without regard to the image, up to 1/n for n decisions; view_change - same_view_change is not, for two views are
      the same after a stay and differ after a turn, whatever the agent sees. NaN without pairs of either sort.
    - visible_information: mutual information of the kind of command and of whether the target is in view, bits, less
      its expectation if the same kinds came in any order; -1..1. NaN when the target is always or never in view, and
      without a target. Source: Vinh, Epps and Bailey 2010.
    - bearing_information: the same of the kind of command and the side on which the goal lies: ahead, left, behind or
      right by quarters of the circle around the heading, as the crow flies; -2..2. The goal is the end of the
      shortest path. NaN when it is always on one side, and without such a path.
    - approach_visible, approach_hidden: decisions after which the geodesic distance to the goal is less by STILL_M or
      more / decisions with the distances known, with the target in view and without; 0..1. NaN without any.
    - approach_contrast: approach_visible - approach_hidden; -1..1. NaN as either. Above 0 for who goes ahead without
      looking, since what is in view lies ahead.

    Denominators: n_decisions, n_other_pairs, n_same_pairs, n_visible, n_hidden (decisions with distances known).
    Source: the definitions are this project's own; Vinh, Epps and Bailey 2010 for the information by chance.
    """
    kinds, counted = command_kinds(run), run.counted
    visible = run.target_px >= VISIBLE_PX
    side = _sides(run)
    informed = counted if run.has_target else np.zeros_like(counted)
    return {
        **_changes(run, kinds),
        "visible_information": information(kinds[informed], visible[informed].astype(np.int64)),
        "bearing_information": information(kinds[counted], side[counted]) if len(side) else math.nan,
        **_approaches(run, visible),
        "n_decisions": float(counted.sum()),
    }


def _changes(run: CameraRun, kinds: IntArray) -> dict[str, float]:
    """Return the measures over pairs of decisions at one place."""
    first, second = np.triu_indices(int(run.counted.sum()), k=1)
    foot, kind = run.foot[:-1][run.counted], kinds[run.counted]
    here = np.linalg.norm(foot[first] - foot[second], axis=1) <= SAME_PLACE_M
    turned = _turned(run.yaw[:-1][run.counted], first, second)
    tilted = np.abs(run.pitch[:-1][run.counted][first] - run.pitch[:-1][run.counted][second])
    apart, changed = np.maximum(turned, tilted), kind[first] != kind[second]
    other, same = here & (apart >= OTHER_VIEW_DEG), here & (apart <= SAME_VIEW_DEG)
    beyond = changed - (1 - _shares_to_come(kind)[second, kind[first]])
    return {
        "view_change": mean(changed[other]),
        "same_view_change": mean(changed[same]),
        "view_effect": _mean_by(second[other], beyond[other]) - _mean_by(second[same], beyond[same]),
        "n_other_pairs": float(other.sum()),
        "n_same_pairs": float(same.sum()),
    }


def _mean_by(key: IntArray, values: FloatArray) -> float:
    """Return the mean of values (n,) by key (n,), then over the keys; NaN of nothing."""
    counts = np.bincount(key)
    kept = counts > 0
    return mean(np.bincount(key, weights=values)[kept] / counts[kept])


def _shares_to_come(kind: IntArray) -> FloatArray:
    """Return the share of each kind among the decisions from each one on, (n, kinds); kind (n,).

    Which decisions make a pair is settled before its second one, by where the agent went and how it turned until then.
    So the second one's chance to be of the first one's kind, were it blind, is this share, not that of the whole run.
    """
    flags = kind[:, None] == np.arange(len(COMMAND_KINDS))
    return np.asarray(flags[::-1].cumsum(axis=0)[::-1] / np.arange(len(kind), 0, -1)[:, None])


def _turned(yaw: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    """Return how far apart pairs of headings are, degrees, 0..180."""
    return np.asarray(np.abs((yaw[first] - yaw[second] + 180) % 360 - 180))


def _sides(run: CameraRun) -> IntArray:
    """Return on which side the goal lies before each decision, 0 ahead, 1 left, 2 behind, 3 right, (T,).

    Empty without a goal.
    """
    if not run.has_target or not run.episode.shortest_path:
        return np.zeros(0, dtype=np.int64)
    way = np.array(run.episode.shortest_path[-1])[:2] - run.foot[:-1, :2]
    bearing = np.degrees(np.arctan2(way[:, 1], way[:, 0])) - run.yaw[:-1]
    return np.asarray(np.floor((bearing + 45) % 360 / 90).astype(np.int64) % 4)


def _approaches(run: CameraRun, visible: BoolArray) -> dict[str, float]:
    nearer = np.diff(run.distance) <= -STILL_M
    known = run.counted & ~np.isnan(np.diff(run.distance)) & run.has_target
    with_view, without = nearer[known & visible], nearer[known & ~visible]
    return {
        "approach_visible": mean(with_view),
        "approach_hidden": mean(without),
        "approach_contrast": mean(with_view) - mean(without),
        "n_visible": float(len(with_view)),
        "n_hidden": float(len(without)),
    }


def information(first: IntArray, second: IntArray) -> float:
    """Return the mutual information of two rows of categories (n,), bits, beyond that of the same rows in any order.

    NaN when `second` does not vary. Source: Vinh, Epps and Bailey 2010.
    """
    values, conditions = np.unique(second, return_inverse=True)
    kinds, actions = np.unique(first, return_inverse=True)
    if len(values) < 2:
        return math.nan
    joint = np.zeros((len(kinds), len(values)), dtype=np.int64)
    np.add.at(joint, (actions, conditions), 1)
    rows, columns = joint.sum(axis=1), joint.sum(axis=0)
    return entropy(columns) + entropy(rows) - entropy(joint) - chance_information(rows, columns)


def chance_information(rows: IntArray, columns: IntArray) -> float:
    """Return the mean mutual information over all orders of two rows of categories, bits.

    Each cell of the table is then hypergeometric. Source: Vinh, Epps and Bailey 2010, equation 24a.

    Args:
        rows: how often each category of the one occurs, above 0, (a,).
        columns: how often each of the other does, above 0, (b,); as many in all.
    """
    from scipy.special import gammaln

    def log_ways(whole: FloatArray | int, part: FloatArray | int) -> FloatArray:
        return np.asarray(gammaln(whole + 1) - gammaln(part + 1) - gammaln(whole - part + 1))

    total, found = int(rows.sum()), 0.0
    for row in rows.tolist():
        for column in columns.tolist():
            cell = np.arange(max(1, row + column - total), min(row, column) + 1, dtype=np.float64)
            chance = np.exp(log_ways(column, cell) + log_ways(total - column, row - cell) - log_ways(total, row))
            found += float((chance * cell / total * np.log2(total * cell / (row * column))).sum())
    return found
