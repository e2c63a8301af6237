"""Movement: in which directions agents move, and whether they approach places, other agents and fires."""

import math
from collections.abc import Callable

import numpy as np

from analysis.arrays import STAY, BoolArray, FloatArray, IntArray
from analysis.formulas import divergence, entropy, mean, normalised_entropy, ratio, variety
from analysis.grid.distances import to_fires, to_nearest_agent, to_nearest_place
from analysis.grid.grid_run import CHOICES, HEADINGS, GridRun
from analysis.grid.moved import beyond_moved
from analysis.grid.walker import beyond_blind, direction_shares, legal_moves, moves_to
from analysis.measure import Measure, Null, share

NAME = "movement"

WAYS = CHOICES[STAY + 1 :]
"""The directions."""

_ALIKE = "draws each step independently, all directions alike, away from edges and walls"
_BLIND = "draws each step independently, without regard to {}"

MEASURES = {
    "variety": share(
        "Pairs of moves in different directions (share)",
        Null(0.75, _ALIKE),
        says="has agents that move in {more|less} varied directions",
    ),
    "alignment": Measure("Similarity of the directions of two moves (mean cosine)", -1, 1, Null(0, _ALIKE)),
    "direction_entropy": share("Entropy of directions moved (of its maximum)"),
    "direction_bits": Measure("Entropy of directions moved (bits)", 0, 2),
    "direction_kl": Measure("Divergence of the directions moved from equal shares (bits)", 0, 2),
    "walker_kl": Measure("Divergence of the directions moved from those of a random walker (bits)", 0),
    "resultant_length": share("Mean resultant length of moves"),
    "mean_direction": Measure("Mean direction of moves (degrees from right)", -180, 180),
    "share_*": share("Moves * (share of moves)"),
    "walker_share_*": share("Moves * that a random walker would make in the same states (share)"),
    "asked_entropy": share("Entropy of requested directions (of its maximum)"),
    "asked_bits": Measure("Entropy of requested directions (bits)", 0, 2),
    "asked_kl": Measure("Divergence of the requested directions from equal shares (bits)", 0, 2),
    "asked_resultant_length": share("Mean resultant length of requested moves"),
    "asked_mean_direction": Measure("Mean direction of requested moves (degrees from right)", -180, 180),
    "asked_share_*": share("Requested moves * (share)"),
    "drift_place": Measure("Drift to the nearest place (cells per step)", -1, 1),
    "drift_agent": Measure("Drift to the nearest agent (cells per step)", -1, 1),
    "drift_place_beyond_moved": Measure(
        "Drift to the nearest place, minus that to moved places (cells per step)",
        -4,
        4,
        Null(0, "goes and stays without regard to places, whatever its habits"),
    ),
    "drift_place_beyond_blind": Measure(
        "Drift to the nearest place, minus that of an agent that ignores places (cells per step)",
        -2,
        2,
        Null(0, _BLIND.format("places")),
    ),
    "drift_agent_beyond_blind": Measure(
        "Drift to the nearest agent, minus that of an agent that ignores others (cells per step)",
        -2,
        2,
        Null(0, _BLIND.format("others")),
    ),
    "drift_fire": Measure("Drift to the nearest fire (cells per step)", -1, 1),
}

HEADLINE = (
    "variety",
    "alignment",
    "drift_place_beyond_moved",
    "drift_place_beyond_blind",
    "drift_agent_beyond_blind",
)


def measure(run: GridRun) -> dict[str, float]:
    """Return the movement of a run, over the counted decisions of all agents.

    Measures of executed moves, which also depend on the world; NaN without moves:

    - variety: pairs of moves in different directions / pairs of moves, pooled over agents; 0..1. Equally likely,
      independent directions give 3/4 for any number of moves; an entropy would fall with fewer moves. variety is lower
      if agents keep a direction, because the moves of a pair then depend on each other. variety is also lower if walls
      or edges block some directions more often, as in a corridor. NaN below two moves. Source: Simpson 1949.
    - alignment: cosine of the angle between two moves, as mean over all pairs of moves; -1..1 (one direction). Equally
      likely, independent directions give 0; agents that keep a direction are above 0. alignment is the unbiased square
      of the resultant length, (n R^2 - 1) / (n - 1). NaN below two moves.
    - direction_bits: entropy of the four directions, bits; 0..2. direction_entropy: direction_bits / 2; 0..1. With
      fewer than about 30 moves, both measures are too low on average. Edges limit the moves, so compare both measures
      with a random walker in the same states, not with their maximum.
    - direction_kl: divergence from the uniform distribution, 2 - direction_bits, bits; 0..2.
    - walker_kl: Kullback-Leibler divergence from walker_share_*, bits; from 0.
    - resultant_length: length of the mean of the moves, as unit vectors; 0 (they cancel out)..1 (one direction).
      mean_direction: direction of this mean, degrees, counter-clockwise from right (up is 90); -180..180. NaN if the
      moves cancel out. The tables average and subtract it as a plain number, although -180 and 180 are the same
      direction. So compare share_<direction> between runs instead. Source: Mardia and Jupp 2000.
    - share_<direction>: moves in this direction / moves; 0..1.

    The same measures of requested moves, executed or blocked, which depend only on the model: asked_bits,
    asked_entropy, asked_kl, asked_resultant_length, asked_mean_direction, asked_share_<direction>.

    Measures of the states before the decisions, and of changes of distance. Changes are in cells per step; a negative
    value is an approach, and a step without a move counts as 0.

    - walker_share_<direction>: share of this direction for a random walker with equally likely legal moves; 0..1. The
      share is the mean over states of 1 / number of legal moves if the direction is legal, else 0.
    - drift_place: change of the distance to the nearest place, in moves (0 inside a place); -1..1. NaN without places.
    - drift_agent: change of the distance to the nearest other agent, in moves; -1..1. The other agent's position before
      the step counts, since the agent cannot know the next one. Steps of a lone agent are left out. NaN with one agent.
    - drift_place_beyond_blind, drift_agent_beyond_blind: the change by requested legal moves minus its expectation for
      a blind agent (`walker`); cells per step. The blind agent stays whenever the agent stayed, and otherwise draws
      legal directions by their shares in the run. The measures are 0 for an agent that draws each step independently,
      whatever direction it prefers, but not for an agent that keeps its direction.
    - drift_place_beyond_moved: drift_place_beyond_blind minus its mean over moved places (`analysis.grid.moved`), which
      it replaces if the world draws positions. 0 for every policy that ignores places, whatever its habits.
    - drift_fire: change of the distance to the nearest burning fire, in moves, whether the fire is perceived or not;
      -1..1. Over the steps in which a fire burns; NaN without such steps.

    Denominators: n_moves, n_asked, n_decisions, n_burning (decisions while a fire burns).
    """
    counted = run.counted
    made = _by_direction(run.choice[run.moved & counted])
    asked = _by_direction(run.choice[counted])
    null = direction_shares(legal_moves(run.x[:-1][counted], run.y[:-1][counted], run.world))
    return {
        "variety": variety(made),
        "alignment": _alignment(made),
        **_directions(made),
        "walker_kl": divergence(made, null) if made.sum() else math.nan,
        **{f"asked_{name.removeprefix('direction_')}": value for name, value in _directions(asked).items()},
        **{f"walker_share_{name}": float(value) for name, value in zip(WAYS, null, strict=True)},
        **_drifts(run),
        "n_moves": float(made.sum()),
        "n_asked": float(asked.sum()),
        "n_decisions": float(counted.sum()),
    }


def _by_direction(choices: IntArray) -> IntArray:
    return np.bincount(choices, minlength=len(CHOICES))[STAY + 1 : len(CHOICES)]


def _directions(counts: IntArray) -> dict[str, float]:
    """Return the measures that depend only on the number of moves up, down, left and right (4,)."""
    total, (right, up) = int(counts.sum()), _sum(counts)
    return {
        "direction_entropy": normalised_entropy(counts),
        "direction_bits": entropy(counts),
        "direction_kl": divergence(counts, np.ones(len(counts))),
        "resultant_length": ratio(math.hypot(right, up), total),
        "mean_direction": math.degrees(math.atan2(up, right)) if right or up else math.nan,
        **{f"share_{name}": ratio(int(count), total) for name, count in zip(WAYS, counts, strict=True)},
    }


def _alignment(counts: IntArray) -> float:
    total, (right, up) = int(counts.sum()), _sum(counts)
    return ratio(right**2 + up**2 - total, total * (total - 1))


def _sum(counts: IntArray) -> list[int]:
    """Return how far all moves together lead to the right and up, from the numbers of moves up, down, left, right."""
    sums: list[int] = (counts[:, None] * HEADINGS[STAY + 1 :]).sum(axis=0).tolist()
    return sums


def _drifts(run: GridRun) -> dict[str, float]:
    counted = run.counted
    fire, burning = _fire_changes(run)
    place, agent = (changes[counted] for changes in (_place_changes(run), _agent_changes(run)))
    legal = legal_moves(run.x[:-1][counted], run.y[:-1][counted], run.world)
    more = beyond_blind(run, run.choice[counted], legal)

    def beyond(changes: FloatArray) -> float:
        # The first column is the actual step, the others are the four directions.
        weighted = (more * changes[:, 1:]).sum(axis=1)
        return mean(weighted[~np.isnan(weighted)])

    return {
        "drift_place": mean(place[:, 0]),
        "drift_agent": mean(agent[~np.isnan(agent[:, 0]), 0]),
        **_place_drift(run, lambda moved: beyond(_place_changes(moved)[counted])),
        "drift_agent_beyond_blind": beyond(agent),
        "drift_fire": mean(fire[counted & burning]),
        "n_burning": float((counted & burning).sum()),
    }


def _place_drift(run: GridRun, drift: Callable[[GridRun], float]) -> dict[str, float]:
    """Return how much more agents drift towards places than expected by chance.

    If the world draws positions, chance is the drift towards places at other positions, else the blind agent's drift.
    """
    if run.world.draw_positions:
        return {"drift_place_beyond_moved": float(beyond_moved(run, lambda moved: np.array([drift(moved)]))[0])}
    return {"drift_place_beyond_blind": drift(run)}


def _place_changes(run: GridRun) -> FloatArray:
    """Return how much the distance to the nearest place changes, (T, N, 5).

    The last axis has the change in this step, then the changes if the agent went up, down, left or right.
    """
    before = to_nearest_place(run.world, run.x[:-1], run.y[:-1])
    return np.asarray(to_nearest_place(run.world, *_ends(run)) - before[..., None])


def _agent_changes(run: GridRun) -> FloatArray:
    """Return how much the distance to the nearest agent changes, (T, N, 5).

    The last axis has the change in this step, then the changes if the agent went up, down, left or right.
    """
    steps, agents = run.choice.shape
    x, y = (
        np.concatenate([at[:-1, :, None], to], axis=2).reshape(steps * agents, -1)
        for at, to in zip((run.x, run.y), _ends(run), strict=True)
    )
    standing_x, standing_y = (np.repeat(at[:-1], agents, axis=0) for at in (run.x, run.y))
    there = None if run.present is None else np.repeat(run.present, agents, axis=0)
    distances = to_nearest_agent(x, y, standing_x, standing_y, np.tile(np.arange(agents), steps), there)
    return np.asarray(distances[:, 1:] - distances[:, :1]).reshape(steps, agents, -1)


def _ends(run: GridRun) -> tuple[IntArray, IntArray]:
    """Return each agent's column and row after its actual step, then after a move in each direction, (T, N, 5) each."""
    to_x, to_y = moves_to(run.x[:-1], run.y[:-1])
    return (
        np.concatenate([run.x[1:, :, None], to_x], axis=2),
        np.concatenate([run.y[1:, :, None], to_y], axis=2),
    )


def _fire_changes(run: GridRun) -> tuple[FloatArray, BoolArray]:
    """Return the change of the distance to the nearest burning fire, (T, N), and whether any fire burns, (T, 1)."""
    starts = np.array([fire.start for fire in run.world.fires], dtype=np.int64)
    burning: BoolArray = np.less_equal(starts, np.arange(1, run.steps + 1)[:, None])
    distances = to_fires(run.world, run.x, run.y, straight=False)
    before, after = (
        np.where(burning[:, None], part, np.inf).min(axis=2, initial=np.inf) for part in (distances[:-1], distances[1:])
    )
    lit = np.asarray(burning.any(axis=1))[:, None]
    return np.subtract(after, before, out=np.full(before.shape, np.nan), where=lit), lit
