"""Movement: the directions that agents take, and the things that they approach."""

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

_ALIKE = "draws each step anew, all ways alike, away from edges and walls"
_BLIND = "draws each step anew, without regard to {}"

MEASURES = {
    "variety": share(
        "Pairs of moves in different directions (share)",
        Null(0.75, _ALIKE),
        says="has agents that move in {more|less} different directions",
    ),
    "alignment": Measure("Likeness of the directions of two moves (mean cosine)", -1, 1, Null(0, _ALIKE)),
    "direction_entropy": share("Entropy of directions moved (of its maximum)"),
    "direction_bits": Measure("Entropy of directions moved (bits)", 0, 2),
    "direction_kl": Measure("Directions moved, divergence from uniform (bits)", 0, 2),
    "walker_kl": Measure("Directions moved, divergence from a walker's (bits)", 0),
    "resultant_length": share("Mean resultant length of moves"),
    "mean_direction": Measure("Mean direction of moves (degrees from right)", -180, 180),
    "share_*": share("Moves * (share of moves)"),
    "walker_share_*": share("Moves * of a walker in the same states (share)"),
    "asked_entropy": share("Entropy of directions asked for (of its maximum)"),
    "asked_bits": Measure("Entropy of directions asked for (bits)", 0, 2),
    "asked_kl": Measure("Directions asked for, divergence from uniform (bits)", 0, 2),
    "asked_resultant_length": share("Mean resultant length of moves asked for"),
    "asked_mean_direction": Measure("Mean direction of moves asked for (degrees from right)", -180, 180),
    "asked_share_*": share("Moves * asked for (share)"),
    "drift_place": Measure("Drift to the nearest place (cells per step)", -1, 1),
    "drift_agent": Measure("Drift to the nearest agent (cells per step)", -1, 1),
    "drift_place_beyond_moved": Measure(
        "Drift to the nearest place, beyond that to moved places (cells per step)",
        -4,
        4,
        Null(0, "goes and stays without regard to places, whatever its habits"),
    ),
    "drift_place_beyond_blind": Measure(
        "Drift to the nearest place, against an agent without habits (cells per step)",
        -2,
        2,
        Null(0, _BLIND.format("places")),
    ),
    "drift_agent_beyond_blind": Measure(
        "Drift to the nearest agent, against an agent without habits (cells per step)",
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
    """Return the movement preference of a run, over the counted decisions of all agents together.

    Over the moves made, which tell of the world, too; NaN without any:

    - variety: pairs of moves in different directions / pairs of moves, of all agents together; 0..1. 3/4 where all
      ways are alike and each step is drawn anew, however few the moves are, while entropies come out the lower the
      fewer there are. Less where agents keep to a way, for then the moves of a pair are no separate draws, and where
      walls or edges close some ways more often, as in a corridor. NaN below two moves. Source: Simpson 1949.
    - alignment: mean cosine of the angle between the moves of a pair; -1..1 (one way), 0 where all ways are alike and
      each step is drawn anew, more where agents keep to a way: the square of the resultant length without its bias,
      (n R^2 - 1) / (n - 1). NaN below two moves.
    - direction_bits: entropy of the four directions, bits; 0..2. direction_entropy: the same / 2; 0..1. Biased low
      below about 30 moves; edges change what is possible, so the null is a walker in the same states, not 1.
    - direction_kl: divergence from the uniform distribution, 2 - direction_bits, bits; 0..2.
    - walker_kl: Kullback-Leibler divergence from walker_share_*, bits; 0 up.
    - resultant_length: length of the mean unit vector; 0 (balanced)..1 (one direction). mean_direction: its direction,
      degrees, counter-clockwise from right (up is 90); -180..180. NaN when the moves cancel out. Source: Mardia and
      Jupp 2000.
    - share_<direction>: moves in this direction / moves; 0..1.

    Over the moves asked for, made or blocked, which tell of the model: asked_bits, asked_entropy, asked_kl,
    asked_resultant_length, asked_mean_direction, asked_share_<direction>.

    Of the states before the decisions, and the way the distance changes by them (cells per step, negative: approach;
    a step without a move changes nothing):

    - walker_share_<direction>: mean over the states of 1 / number of legal moves where this one is legal, else 0: the
      directions of a walker that makes any legal move as likely; 0..1.
    - drift_place: change of the fewest moves into any place (0 inside one); -1..1. NaN without places.
    - drift_agent: change of the fewest moves to where the nearest other agent stood before the step, since where it
      goes is not known to the agent; -1..1. Steps of an agent that is alone are left out. NaN with one agent.
    - drift_place_beyond_blind, drift_agent_beyond_blind: the same of the legal ways asked for, less what is expected of
      a blind agent (`walker`), which stays where the agent stayed and else asks for the legal ways by their shares in
      the run; cells per step. 0 for who draws each step anew, preferring a way or not; not 0 for who keeps to a way.
    - drift_place_beyond_moved: where the world draws positions, in place of drift_place_beyond_blind: the same less its
      mean over moved places (`analysis.grid.moved`). 0 for every policy that ignores places, whatever its habits.
    - drift_fire: change of the fewest moves to the nearest burning fire, perceived or not, over the steps with one;
      -1..1. NaN when none burns.

    Denominators: n_moves, n_asked, n_decisions, n_burning (decisions while a fire burns).
    """
    counted = run.counted
    made = _by_direction(run.choice[run.moved & counted])
    asked = _by_direction(run.choice[counted])
    null = direction_shares(legal_moves(run.x[:-1][counted], run.y[:-1][counted], run.world))
    found = _directions(made)
    return {
        "variety": variety(made),
        "alignment": alignment(made),
        **found,
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
    """Return what can be said of moves by direction; counts of up, down, left, right (4,)."""
    total = int(counts.sum())
    return {
        "direction_entropy": normalised_entropy(counts),
        "direction_bits": entropy(counts),
        "direction_kl": divergence(counts, np.ones(len(counts))),
        "resultant_length": resultant_length(counts),
        "mean_direction": mean_direction(counts),
        **{f"share_{name}": ratio(int(count), total) for name, count in zip(WAYS, counts, strict=True)},
    }


def alignment(counts: IntArray) -> float:
    """Return the mean cosine between the moves of a pair, -1..1; counts of up, down, left, right (4,)."""
    total, (right, up) = int(counts.sum()), _sum(counts)
    return ratio(right**2 + up**2 - total, total * (total - 1))


def resultant_length(counts: IntArray) -> float:
    """Return the length of the mean unit vector, 0..1; counts of up, down, left, right (4,)."""
    return ratio(math.hypot(*_sum(counts)), float(counts.sum()))


def mean_direction(counts: IntArray) -> float:
    """Return the direction of the mean vector, degrees counter-clockwise from right; NaN when it has no length."""
    right, up = _sum(counts)
    return math.degrees(math.atan2(up, right)) if right or up else math.nan


def _sum(counts: IntArray) -> list[int]:
    sums: list[int] = (counts[:, None] * HEADINGS[STAY + 1 :]).sum(axis=0).tolist()
    return sums


def _drifts(run: GridRun) -> dict[str, float]:
    counted = run.counted
    fire, burning = _fire_changes(run)
    place, agent = (changes[counted] for changes in (_place_changes(run), _agent_changes(run)))
    legal = legal_moves(run.x[:-1][counted], run.y[:-1][counted], run.world)
    more = beyond_blind(run, run.choice[counted], legal)

    def beyond(changes: FloatArray) -> float:
        # The first column is what the agent did, the others are what each way would have done.
        found = (more * changes[:, 1:]).sum(axis=1)
        return mean(found[~np.isnan(found)])

    return {
        "drift_place": mean(place[:, 0]),
        "drift_agent": mean(agent[~np.isnan(agent[:, 0]), 0]),
        **_place_drift(run, lambda moved: beyond(_place_changes(moved)[counted])),
        "drift_agent_beyond_blind": beyond(agent),
        "drift_fire": mean(fire[counted & burning]),
        "n_burning": float((counted & burning).sum()),
    }


def _place_drift(run: GridRun, drift: Callable[[GridRun], float]) -> dict[str, float]:
    """Return the drift to places beyond the null: that of moved places where there are such draws."""
    if run.world.draw_positions:
        return {"drift_place_beyond_moved": float(beyond_moved(run, lambda moved: np.array([drift(moved)]))[0])}
    return {"drift_place_beyond_blind": drift(run)}


def _place_changes(run: GridRun) -> FloatArray:
    """Return the changes of the distance to the nearest place by the step and by each way, (T, N, 5)."""
    before = to_nearest_place(run.world, run.x[:-1], run.y[:-1])
    return np.asarray(to_nearest_place(run.world, *_ends(run)) - before[..., None])


def _agent_changes(run: GridRun) -> FloatArray:
    """Return the changes of the distance to where the nearest other agent stood, by step and each way, (T, N, 5)."""
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
    """Return columns and rows of where each step led, and of where each of the four ways would have, (T, N, 5) each."""
    to_x, to_y = moves_to(run.x[:-1], run.y[:-1])
    return (
        np.concatenate([run.x[1:, :, None], to_x], axis=2),
        np.concatenate([run.y[1:, :, None], to_y], axis=2),
    )


def _fire_changes(run: GridRun) -> tuple[FloatArray, BoolArray]:
    """Return the changes of the distance to the nearest burning fire, (T, N), and whether there is one, (T, 1)."""
    starts = np.array([fire.start for fire in run.world.fires], dtype=np.int64)
    burning: BoolArray = np.less_equal(starts, np.arange(1, run.steps + 1)[:, None])
    distances = to_fires(run.world, run.x, run.y, straight=False)
    before, after = (
        np.where(burning[:, None], part, np.inf).min(axis=2, initial=np.inf) for part in (distances[:-1], distances[1:])
    )
    lit = np.asarray(burning.any(axis=1))[:, None]
    return np.subtract(after, before, out=np.full(before.shape, np.nan), where=lit), lit
