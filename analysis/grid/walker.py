"""Two imagined agents that perceive nothing; several signatures compare runs with their expected behaviour.

The random walker never stays: at every step it makes one of the legal moves, each equally likely. The blind agent stays
whenever the run's agent stayed. When the run's agent moved, the blind agent draws a legal direction, with the
frequencies that directions have in the run. The blind agent therefore prefers the same directions as the run's agents.
"""

from functools import lru_cache

import numpy as np

from analysis.arrays import STAY, BoolArray, FloatArray, IntArray
from analysis.grid.grid_run import CHOICES, HEADINGS, GridRun, GridSettings

_CELLS_AT_ONCE = 2**17


def moves_to(x: IntArray, y: IntArray) -> tuple[IntArray, IntArray]:
    """Return the columns and the rows of the cells up, down, left and right, even beyond the edge, (..., 4) each."""
    ways = HEADINGS[STAY + 1 :]
    return x[..., None] + ways[:, 0], y[..., None] + ways[:, 1]


def legal_moves(x: IntArray, y: IntArray, world: GridSettings) -> BoolArray:
    """Return which of the moves up, down, left and right stay on the grid and hit no wall, (..., 4)."""
    (to_x, to_y), half = moves_to(x, y), world.half_size
    inside = np.asarray((np.abs(to_x) <= half) & (np.abs(to_y) <= half))
    if world.walls:
        inside &= world.free()[np.clip(to_x, -half, half) + half, np.clip(to_y, -half, half) + half]
    return inside


def _blind_chances(run: GridRun, legal: BoolArray) -> FloatArray:
    """Return the probabilities of up, down, left and right for an agent that moves but perceives nothing, (E, 4).

    The probabilities are proportional to how often all agents request each direction, in counted decisions in cells
    with four legal moves. Half a move is added to each direction (Jeffreys' prior), so that no legal direction is
    impossible. An illegal move has probability 0.

    Args:
        run: the run.
        legal: which moves are legal, by decision, (E, 4).
    """
    free = legal_moves(run.x[:-1], run.y[:-1], run.world).all(axis=2)
    asked = np.bincount(run.choice[run.counted & free], minlength=len(CHOICES))[STAY + 1 : len(CHOICES)] + 0.5
    chances = np.where(legal, asked, 0.0)
    total = chances.sum(axis=1, keepdims=True)
    return np.asarray(np.divide(chances, total, out=np.zeros_like(chances), where=total > 0))


def beyond_blind(run: GridRun, choice: IntArray, legal: BoolArray) -> FloatArray:
    """Return, for each move, whether it was requested (1 or 0) minus the blind agent's probability of it, (E, 4).

    All four values are 0 for a decision that requests no legal move. A move into an occupied cell counts as legal, even
    if it is not executed.

    Args:
        run: the run.
        choice: requested action, by decision, (E,).
        legal: which moves are legal, by decision, (E, 4).
    """
    asked = asked_ways(choice, legal)
    return asked - np.where(asked.any(axis=1, keepdims=True), _blind_chances(run, legal), 0.0)


def asked_ways(choice: IntArray, legal: BoolArray) -> BoolArray:
    """Return whether each of the moves up, down, left and right was requested and is legal, (E, 4)."""
    return np.asarray((choice[:, None] == np.arange(STAY + 1, len(CHOICES))) & legal)


def direction_shares(legal: BoolArray) -> FloatArray:
    """Return the random walker's expected share of the moves up, down, left and right, (4,); NaN without legal moves.

    Args:
        legal: which moves are legal, by state, (S, 4); in each state, the legal moves are equally likely.
    """
    able = legal[legal.any(axis=1)]
    if not len(able):
        return np.full(legal.shape[1], np.nan)
    return np.asarray((able / able.sum(axis=1, keepdims=True)).mean(axis=0))


def expected_cells(x: IntArray, y: IntArray, moves: IntArray, half_size: int) -> FloatArray:
    """Return the expected number of different cells that a random walker visits, its start included, (N,).

    Args:
        x: columns of the starts, (N,).
        y: rows of the starts, (N,).
        moves: number of moves from each start, (N,).
        half_size: number of cells from the centre of the grid to its edge.
    """
    side, horizon = 2 * half_size + 1, int(moves.max(initial=0))
    if side == 1:
        return np.ones(len(x))
    # An edge that the walker cannot reach does not matter, so a small grid can stand for a large one.
    table_side = min(side, 2 * horizon + 1)
    column, row = (_in_table(at + half_size, side, table_side, horizon) for at in (x, y))
    return np.asarray(_cells_table(table_side, horizon)[moves, column, row])


def _in_table(at: IntArray, side: int, table_side: int, horizon: int) -> IntArray:
    if side == table_side:
        return at
    return np.minimum(at, horizon) + np.maximum(horizon - (side - 1 - at), 0)


@lru_cache(maxsize=8)
def _cells_table(side: int, horizon: int) -> FloatArray:
    """Return the expected number of different visited cells, by number of moves and start, (horizon + 1, side, side).

    The number is the sum over all cells of the probability that the walker visits the cell by then. Each probability
    solves an absorbing Markov chain. By the eight symmetries of the square, an eighth of the cells suffices.
    """
    middle = (side + 1) // 2
    targets = [(a, b) for a in range(middle) for b in range(a, middle)]
    size = max(1, _CELLS_AT_ONCE // side**2)
    table = np.zeros((horizon + 1, side, side))
    for start in range(0, len(targets), size):
        table += _reaching(np.array(targets[start : start + size]), side, horizon)
    table = table + table[:, ::-1]
    table = table + table[:, :, ::-1]
    return np.asarray(table + table.transpose(0, 2, 1))


def _reaching(targets: IntArray, side: int, horizon: int) -> FloatArray:
    """Return how many of the given cells a random walker visits on average, by number of moves and cell of the start.

    Each visited cell counts with its weight.

    The weight of a cell is the number of its images under the symmetries of the square, divided by eight.

    Args:
        targets: the cells, (k, 2).
        side: number of cells along each axis.
        horizon: largest number of moves.
    """
    a, b = targets.T
    images = np.where(a == b, 4, 8) // np.where(b == side // 2, 2, 1)
    images = np.where((a == b) & (b == side // 2), 1, images)
    ways = np.full((side, side), 4.0)
    ways[[0, -1]] -= 1
    ways[:, [0, -1]] -= 1
    # A grid with its border is one row of numbers; infinitely many ways keep the border at 0.
    width = side + 2
    bordered = np.pad(ways, 1, constant_values=np.inf).ravel()
    index, place = np.arange(len(targets)), (a + 1) * width + b + 1
    reached, following = np.zeros((2, len(targets), width * width))
    reaching = np.zeros((horizon + 1, width * width))
    for moves in range(horizon + 1):
        # Rows of the grid that are more moves away have probability 0.
        low, high = width * max(1, int(a.min()) + 1 - moves), width * min(side + 1, int(a.max()) + 2 + moves)
        if moves:
            near = following[:, low:high]
            np.add(reached[:, low + width : high + width], reached[:, low - width : high - width], out=near)
            near += reached[:, low + 1 : high + 1]
            near += reached[:, low - 1 : high - 1]
            np.divide(near, bordered[low:high], out=reached[:, low:high])
        reached[index, place] = 1.0
        reaching[moves, low:high] = np.einsum("k,kn->n", images / 8, reached[:, low:high])
    return reaching.reshape(-1, width, width)[:, 1:-1, 1:-1]
