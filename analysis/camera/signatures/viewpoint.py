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

_BLIND = "draws its decisions independently, without regard to the image"

MEASURES = {
    "view_change": share("Different decision with another view of the same place (share of pairs)"),
    "same_view_change": share("Different decision with the same view (share of pairs)"),
    "view_effect": Measure(
        "Different decision for another view, beyond that for the same view",
        -2,
        2,
        Null(0, _BLIND),
        says="depends {more|less} on the image",
    ),
    "visible_information": Measure(
        "Information of the target's visibility about the decision (bits, beyond chance)", -1, 1, Null(0, _BLIND)
    ),
    "bearing_information": Measure(
        "Information of the goal's side about the decision (bits, beyond chance)", -2, 2, Null(0, _BLIND)
    ),
    "approach_visible": share("Decisions that approach, target in view (share)"),
    "approach_hidden": share("Decisions that approach, target not in view (share)"),
    "approach_contrast": Measure("Approach with the target in view, minus approach without it", -1, 1),
}

HEADLINE = ("view_effect", "visible_information", "bearing_information")

SAME_PLACE_M = 0.05
"""Maximum distance between two positions of the foot that count as one place, metres."""

SAME_VIEW_DEG, OTHER_VIEW_DEG = 1.0, 15.0
"""Angles between two views, degrees: up to the first, the views count as equal; from the second, as different."""


def measure(run: CameraRun) -> dict[str, float]:
    """Return how much the decisions of a run depend on the view.

    A decision is its kind of command (`command_kinds`). Two views are of one place if the feet are at most SAME_PLACE_M
    apart. Two views differ by their difference in yaw or in pitch, whichever is larger. The target is in view with
    VISIBLE_PX pixels or more. Uncounted decisions are left out everywhere.

    - view_change: among pairs at one place with views at least OTHER_VIEW_DEG apart: pairs of different kinds / pairs;
      0..1. This is the dispersion of decisions over views. NaN without such pairs.
    - same_view_change: such a share for views at most SAME_VIEW_DEG apart; 0..1. This variation comes from sampling or
      history, not from the view. NaN without such pairs.
    - view_effect: mean excess of different kinds over chance for pairs with different views, minus that mean for pairs
      with equal views; -2..2. Chance draws the second decision of a pair from the rest of the run. The mean is over the
      pairs of one second decision, then over second decisions. n independent decisions that ignore the image give 0, up
      to 1/n. view_change - same_view_change would not, because views are equal after a stay and differ after a turn.
      NaN unless pairs of both sorts occur.
    - visible_information: mutual information of command kind and visibility of the target, bits, minus its mean over
      all orders of the kinds; -1..1. NaN if the target is always or never in view, and without a target. Source: Vinh,
      Epps and Bailey 2010.
    - bearing_information: mutual information of command kind and the goal's side, minus its mean in this way; -2..2.
      The side is the quarter around the heading, in a straight line: ahead, left, behind or right. The goal is the end
      of the shortest path. NaN if the goal is always on one side, and without such a path.
    - approach_visible, approach_hidden: decisions that reduce the geodesic distance to the goal by at least STILL_M /
      decisions with known distances; 0..1. The first counts decisions with the target in view, the second those
      without. NaN without such decisions.
    - approach_contrast: approach_visible - approach_hidden; -1..1. NaN if either is NaN. The measure is above 0 even
      for an agent that goes ahead without looking, because things in view are ahead.

    Denominators: n_decisions, n_other_pairs, n_same_pairs, n_visible, n_hidden (decisions with known distances).
    Source: the definitions are new in foundry; Vinh, Epps and Bailey 2010 for the information expected by chance.
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
    """Return the mean over all keys of the mean of the values with this key; NaN without values."""
    counts = np.bincount(key)
    seen = counts > 0
    return mean(np.bincount(key, weights=values)[seen] / counts[seen])


def _shares_to_come(kind: IntArray) -> FloatArray:
    """Return, for each decision, the share of each kind from this decision to the last one, (n, kinds).

    The path until a decision determines its pairs with earlier ones. So if a blind agent's decisions come in random
    order, this share is the chance that the second decision of a pair has the kind of the first.
    """
    flags = kind[:, None] == np.arange(len(COMMAND_KINDS))
    return np.asarray(flags[::-1].cumsum(axis=0)[::-1] / np.arange(len(kind), 0, -1)[:, None])


def _turned(yaw: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    """Return the differences of pairs of headings, degrees, 0..180."""
    return np.asarray(np.abs((yaw[first] - yaw[second] + 180) % 360 - 180))


def _sides(run: CameraRun) -> IntArray:
    """Return the side of the goal before each decision: 0 ahead, 1 left, 2 behind, 3 right, (T,).

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
    """Return the mutual information of two lists of categories (n,), minus its mean over all orders of one list, bits.

    It is NaN if `second` does not vary. Source: Vinh, Epps and Bailey 2010.
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
    """Return the mean mutual information of two lists of categories over all orders of one list, bits.

    Over all orders, the count of a pair of categories is hypergeometric. Source: Vinh, Epps and Bailey 2010, equation
    24a.

    Args:
        rows: count of each category in the first list, above 0, (a,).
        columns: count of each category in the second list, above 0, (b,), with the same sum.
    """
    from scipy.special import gammaln

    def log_ways(whole: FloatArray | int, part: FloatArray | int) -> FloatArray:
        return np.asarray(gammaln(whole + 1) - gammaln(part + 1) - gammaln(whole - part + 1))

    total, information = int(rows.sum()), 0.0
    for row in rows.tolist():
        for column in columns.tolist():
            cell = np.arange(max(1, row + column - total), min(row, column) + 1, dtype=np.float64)
            chance = np.exp(log_ways(column, cell) + log_ways(total - column, row - cell) - log_ways(total, row))
            information += float((chance * cell / total * np.log2(total * cell / (row * column))).sum())
    return information
