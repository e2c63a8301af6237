"""Hazard sensitivity: whether agents move away from a perceived fire, and how soon.

A decision is exposed if the agent perceives a fire before the decision. Distances to fires are straight lines
(Euclidean). A step leads away if the distance to the nearest perceived fire grows. Every move on the grid makes the
distance to a fire larger or smaller.
"""

import math
from dataclasses import dataclass

import numpy as np

from analysis.arrays import STAY, BoolArray, FloatArray, IntArray
from analysis.formulas import mean, ratio, restricted_mean
from analysis.grid.distances import to_fires, to_nearest_agent, to_nearest_place
from analysis.grid.grid_run import GridRun
from analysis.grid.moved import beyond_moved, in_sight
from analysis.grid.walker import asked_ways, beyond_blind, legal_moves, moves_to
from analysis.measure import Measure, Null, share

_ROUNDS = 50
_CLOSE = 1e-12
_STEEPEST = 20.0


def conditional_logit(options: FloatArray, offered: BoolArray, chosen: IntArray) -> FloatArray:
    """Return the maximum likelihood estimate of each covariate's log odds per unit, (c,), by Newton's method.

    The probability of an offered option is proportional to exp(beta . covariates). A covariate that never differs
    between the options of a choice gets NaN. All covariates get NaN if their effects cannot be told apart, or if they
    predict every choice perfectly, since the likelihood then has no maximum. Source: McFadden 1974.

    Args:
        options: covariates of every option, (n, k, c); any finite value for an option that was not offered.
        offered: whether the option was offered, (n, k).
        chosen: index of the chosen option, (n,).
    """
    beta = np.full(options.shape[2], np.nan)
    if not len(chosen):
        return beta
    centred = options - options[np.arange(len(chosen)), chosen][:, None]
    centred = np.where(offered[:, :, None], centred, 0.0)
    varies = np.any(centred != 0, axis=(0, 1))
    if varies.any():
        beta[varies] = _newton(centred[:, :, varies], offered)
    return beta


def _newton(relative: FloatArray, offered: BoolArray) -> FloatArray:
    """Return the maximum likelihood estimates, (c,).

    Args:
        relative: covariates of each option minus those of the chosen option, (n, k, c).
        offered: whether each option was possible, (n, k).
    """
    covariates = relative.shape[2]
    beta, failed = np.zeros(covariates), np.full(covariates, np.nan)
    for _ in range(_ROUNDS):
        weights = np.where(offered, np.exp(relative @ beta), 0.0)
        weights /= weights.sum(axis=1, keepdims=True)
        expected = (weights[:, :, None] * relative).sum(axis=1)
        weighted = (weights[:, :, None] * relative).reshape(-1, covariates)
        information = weighted.T @ relative.reshape(-1, covariates) - expected.T @ expected
        if np.linalg.matrix_rank(information, tol=1e-9) < covariates:
            return failed
        step = np.linalg.solve(information, -expected.sum(axis=0))
        beta = beta + step
        if np.abs(beta).max() > _STEEPEST:
            return failed
        if np.abs(step).max() < _CLOSE:
            return beta
    return failed


NAME = "hazard"

_IGNORES = "goes and stays without regard to fires, whatever its habits"
_BLIND = "draws each step independently, without regard to fires"
_UNBIASED = "draws each step independently, with equal directions, and stays with any probability"
_AWAY = "steps away from fires {more|less}"
_TWIN = "its value in the same run with agents that are not told of fires"

MEASURES = {
    "exposure": share("Decisions with a fire in sight (share)"),
    "away": share("Steps away from a fire in sight (share)"),
    "away_moving": share("Moves away from a fire in sight (share of moves)"),
    "walker_away": share("Steps of a random walker away from a fire in sight (share)"),
    "away_beyond_moved": Measure(
        "Steps away from a fire, minus steps away from moved fires (share)", -2, 2, Null(0, _IGNORES), says=_AWAY
    ),
    "away_beyond_untold": Measure(
        f"Steps away from a fire, minus {_TWIN} (share)", -2, 2, Null(0, _IGNORES), says=_AWAY
    ),
    "away_beyond_blind": Measure(
        "Steps away from a fire, minus those of an agent that ignores fires (share)", -1, 1, Null(0, _BLIND), says=_AWAY
    ),
    "difference_walker_moving": Measure(
        "Moves away from a fire, minus those of a random walker (share)", -1, 1, Null(0, _UNBIASED)
    ),
    "difference_matched": Measure(
        "Steps away from a fire, minus those before it burned (share)", -1, 1, Null(0, _UNBIASED)
    ),
    "log_risk_ratio": Measure("Steps away from a fire / those before it burned (log ratio)", null=Null(0, _UNBIASED)),
    "log_odds_ratio": Measure(
        "Odds of a step away from a fire / odds before it burned (log ratio)", null=Null(0, _UNBIASED)
    ),
    "distance_change": Measure("Change of the distance to a fire in sight (cells per step)", -1, 1),
    "distance_beyond_moved": Measure(
        "Change of the distance to a fire, minus that to moved fires (cells per step)", -4, 4, Null(0, _IGNORES)
    ),
    "distance_beyond_untold": Measure(
        f"Change of the distance to a fire, minus {_TWIN} (cells per step)", -4, 4, Null(0, _IGNORES)
    ),
    "distance_beyond_blind": Measure(
        "Change of the distance to a fire, minus that of an agent that ignores fires (cells per step)",
        -2,
        2,
        Null(0, _BLIND),
    ),
    "beta_fire": Measure("Effect of one more cell of distance to the fire (log odds)", null=Null(0, _UNBIASED)),
    "beta_place": Measure("Effect of one more cell of distance to the nearest place (log odds)"),
    "beta_agent": Measure("Effect of one more cell of distance to the nearest agent (log odds)"),
    "latency": Measure("Decisions until the first step away (restricted mean)", low=0),
}

HEADLINE = (
    "away_beyond_moved",
    "away_beyond_untold",
    "away_beyond_blind",
    "distance_beyond_moved",
    "distance_beyond_untold",
    "distance_beyond_blind",
    "exposure",
)

FEWEST_CHOICES = 30
"""The coefficients beta_fire, beta_place and beta_agent need at least this number of moves, by a rule of thumb."""


@dataclass(frozen=True)
class _Exposed:
    """The E counted decisions before which an agent perceived a fire, by step, then agent; arrays are (E,).

    Attributes:
        step: 0-based step.
        nearest: index of the nearest perceived fire; the first, if tied.
        before: distance to this fire before the step, cells.
        change: change of the distance to the nearest perceived fire, cells.
    """

    step: IntArray
    agent: IntArray
    nearest: IntArray
    before: FloatArray
    change: FloatArray


@dataclass(frozen=True)
class _Options:
    """The results of the moves up, down, left and right at each of E decisions of agents that perceive a fire, (E, 4).

    Attributes:
        x: column after the move.
        y: row after the move.
        change: change of the distance to the nearest perceived fire, cells.
    """

    x: IntArray
    y: IntArray
    legal: BoolArray
    change: FloatArray

    @property
    def walker_away(self) -> FloatArray:
        """Of the legal moves, the share that lead away from the fire, (E,); NaN without a legal move."""
        count = self.legal.sum(axis=1)
        away = ((self.change > 0) & self.legal).sum(axis=1)
        return np.asarray(np.divide(away, count, out=np.full(len(count), np.nan), where=count > 0))


def applies(run: GridRun) -> bool:
    """Return true if no fire of the world spreads: the distance to a spreading fire is not recorded."""
    return not run.world.spreads


def measure(run: GridRun) -> dict[str, float]:
    """Return the hazard sensitivity of a run, over the counted decisions of all agents.

    All measures but exposure are NaN without exposed decisions. Show n_exposed with them, because agents that avoid
    fires see few fires.

    - exposure: exposed decisions / decisions; 0..1.
    - away: exposed decisions after which the distance has grown / exposed decisions; 0..1. away_moving: `away` among
      the exposed decisions with a move; NaN without a move.
    - walker_away: expected value of `away` for a random walker with equally likely legal moves; 0..1. The value is the
      mean over exposed decisions of (legal moves that lead away / legal moves). NaN without legal moves.
    - away_beyond_blind: (requested legal moves away - their expected number for a blind agent, `analysis.grid.walker`)
      / exposed decisions; -1..1. The blind agent stays whenever the agent stayed, and otherwise draws legal directions
      by their shares in the run. The measure is 0 for an agent that draws each step independently, whatever direction
      it prefers, but not for an agent that keeps its direction. Decisions to stay are in the denominator. If the world
      draws positions, away_beyond_moved takes its place.
    - away_beyond_moved: away_beyond_blind minus its mean over moved fires (`analysis.grid.moved`); -2..2. 0 for every
      policy that ignores fires, whatever its habits.
    - away_beyond_untold: away_beyond_blind minus its value in the twin run, if the sweep has one; -2..2. Agents of the
      twin run are not told of fires. 0 for every policy that ignores fires. `analysis.measuring.twins` adds this
      measure and distance_beyond_untold.
    - difference_walker_moving: away_moving minus its expectation for a random walker at the same decisions; -1..1. NaN
      without a move. The measure is not 0 for an agent that ignores fires but prefers a direction.
    - difference_matched: share of steps away at the exposed decisions with a control, minus this share at their
      controls; -1..1. The controls of an exposed decision are counted decisions of all agents before its nearest
      perceived fire burns. At a control, the agent is as far from the later fire as at the exposed decision, in whole
      cells (rounded down), and no other fire is in sight. All controls of a decision together count as one decision.
      Controls of the same agent alone would be biased: an agent that is at that distance again later went away less
      often than others. NaN without controls, for example if the fire burns early or if nobody came so near before.
    - log_odds_ratio: ln((a + .5) (d + .5) / ((b + .5) (c + .5))). a and b are the exposed decisions away and not away,
      c and d the controls away and not away; 0: no difference. log_risk_ratio: ln((a + .5) / (a + b + .5)) - ln((c +
      .5) / (c + d + .5)). NaN without controls. Both measures are imprecise with few controls. Source: Haldane 1956,
      Anscombe 1956; Walter 1975.
    - distance_change: mean change of the distance to the nearest perceived fire, cells per step; -1..1. The measure is
      above 0 for a blind agent, because more directions lead away from a nearby fire than towards it.
    - distance_beyond_blind: mean change of the distance by requested legal moves, minus its expectation for the blind
      agent; cells per step. distance_beyond_blind is 0 for the same agents as away_beyond_blind. distance_beyond_moved
      is distance_beyond_blind minus its mean over moved fires.
    - beta_fire, beta_place, beta_agent: step selection. A conditional logit explains which of the legal directions an
      agent requests, at exposed decisions that request one; occupied cells count as legal. Its covariates are the
      changes of the distance to the nearest perceived fire (Euclidean), to the nearest place and to the nearest other
      agent (both in moves). Each beta is in log odds per cell; above 0 for steps away from the object. Without places,
      or with one agent, the covariate is left out. NaN below FEWEST_CHOICES such decisions, or if the likelihood has no
      maximum. Source: McFadden 1974; Fortin et al. 2005.
    - latency: restricted mean number of exposed decisions up to an agent's first step away, counted from 1; 1..T.
      Agents that never step away are censored at their last exposed decision. latency is the area under the
      Kaplan-Meier curve from 0 to T. Agents that seldom move have a high latency, whatever the reason.

    Denominators: n_decisions, n_exposed, n_exposed_moves, n_matched (exposed decisions with a control), n_controls,
    n_choices (of the fit, even if too few), n_exposed_agents.
    """
    run = in_sight(run)
    exposed = _exposed(run)
    return _measures(run, exposed, _options(run, exposed))


def _measures(run: GridRun, exposed: _Exposed, options: _Options) -> dict[str, float]:
    away = exposed.change > 0
    moved = run.moved[exposed.step, exposed.agent]
    walker = options.walker_away
    choice = run.choice[exposed.step, exposed.agent]
    return {
        "exposure": ratio(len(away), int(run.counted.sum())),
        "away": mean(away),
        "away_moving": mean(away[moved]),
        "walker_away": mean(walker),
        **_beyond(run),
        "difference_walker_moving": mean(away[moved]) - mean(walker[moved]),
        **_matched(run, exposed),
        "distance_change": mean(exposed.change),
        **_selection(run, exposed, options, np.flatnonzero(asked_ways(choice, options.legal).any(axis=1))),
        **_latency(exposed, run.steps),
        "n_decisions": float(run.counted.sum()),
        "n_exposed": float(len(away)),
        "n_exposed_moves": float(moved.sum()),
    }


def _beyond(run: GridRun) -> dict[str, float]:
    """Return how much more agents move away from fires than expected by chance.

    If the world draws positions, chance is the same run with other positions of the fires, else the blind agent.
    """
    null, observed = (
        ("moved", beyond_moved(run, _beyond_blind)) if run.world.draw_positions else ("blind", _beyond_blind(run))
    )
    return {f"away_beyond_{null}": float(observed[0]), f"distance_beyond_{null}": float(observed[1])}


def _beyond_blind(run: GridRun) -> FloatArray:
    """Return the values of away_beyond_blind and distance_beyond_blind, (2,)."""
    exposed = _exposed(run)
    options = _options(run, exposed)
    more = beyond_blind(run, run.choice[exposed.step, exposed.agent], options.legal)
    return np.array([mean((more * (options.change > 0)).sum(axis=1)), mean((more * options.change).sum(axis=1))])


def _exposed(run: GridRun) -> _Exposed:
    step, agent = np.nonzero(run.perceived & run.counted)
    seen = run.fires[step, agent]
    before = np.where(seen, to_fires(run.world, run.x[step, agent], run.y[step, agent]), np.inf)
    nearest = before.argmin(axis=1) if before.shape[1] else np.zeros(0, dtype=np.int64)
    after = _near_perceived(run, seen, run.x[step + 1, agent], run.y[step + 1, agent])
    least = before.min(axis=1, initial=np.inf)
    return _Exposed(step, agent, nearest, least, after - least)


def _near_perceived(run: GridRun, seen: BoolArray, x: IntArray, y: IntArray) -> FloatArray:
    """Return the distance from each cell (x, y) to the nearest fire that the agent perceived, in the shape of x and y.

    `seen`, (E, F), says which fires each agent perceived.
    """
    masks = seen if x.ndim == 1 else seen[:, None]
    return np.asarray(np.where(masks, to_fires(run.world, x, y), np.inf).min(axis=-1, initial=np.inf))


def _options(run: GridRun, exposed: _Exposed) -> _Options:
    x, y = run.x[exposed.step, exposed.agent], run.y[exposed.step, exposed.agent]
    to_x, to_y = moves_to(x, y)
    seen = run.fires[exposed.step, exposed.agent]
    change = _near_perceived(run, seen, to_x, to_y) - exposed.before[:, None]
    return _Options(to_x, to_y, legal_moves(x, y, run.world), change)


def _contrast(total: int, away: int, control: float) -> dict[str, float]:
    """Compare how often agents moved away from a fire that they perceived with how often they did so before the fire.

    A decision is exposed if the agent perceives the fire. Its controls are similar decisions before the fire.

    Half a case is added to each count in the logarithms (Haldane 1956, Anscombe 1956; for risks Walter 1975). So the
    logarithms are defined for all counts, and their bias is of second order. The mean of plain ratios would be above 1
    even without a difference.

    Args:
        total: number of exposed decisions with controls; as many decisions stand for the controls.
        away: number of those after which the distance has grown.
        control: the same number for the controls, which are weighted.
    """
    if not total:
        return dict.fromkeys(("difference_matched", "log_risk_ratio", "log_odds_ratio"), math.nan)
    return {
        "difference_matched": away / total - control / total,
        "log_risk_ratio": math.log((away + 0.5) / (total + 0.5)) - math.log((control + 0.5) / (total + 0.5)),
        "log_odds_ratio": math.log((away + 0.5) / (total - away + 0.5))
        - math.log((control + 0.5) / (total - control + 0.5)),
    }


def _matched(run: GridRun, exposed: _Exposed) -> dict[str, float]:
    distances = to_fires(run.world, run.x, run.y)
    starts = np.array([fire.start for fire in run.world.fires])
    early = np.arange(1, run.steps + 1)[:, None] < starts
    free = early[:, None] & (run.counted & ~run.perceived)[:, :, None]
    cells = int(distances.max(initial=0)) + 1

    def stratum(fires: IntArray, at: FloatArray) -> IntArray:
        return fires * cells + np.floor(at).astype(np.int64)

    size = len(starts) * cells
    keys = stratum(np.nonzero(free)[2], distances[:-1][free])
    grew = (distances[1:] > distances[:-1])[free]
    controls, away = np.bincount(keys, minlength=size), np.bincount(keys, weights=grew, minlength=size)
    mine = stratum(exposed.nearest, exposed.before)
    matched = controls[mine] > 0
    total, left = int(matched.sum()), int((exposed.change > 0)[matched].sum())
    return {
        **_contrast(total, left, float((away[mine][matched] / controls[mine][matched]).sum())),
        "n_matched": float(total),
        "n_controls": float(controls[np.unique(mine)].sum()),
    }


def _selection(run: GridRun, exposed: _Exposed, options: _Options, rows: IntArray) -> dict[str, float]:
    """Return coefficients that say how the distances to fire, places and agents change which move an agent chooses.

    `rows` are the exposed decisions that request a move.
    """
    names = ("beta_fire", "beta_place", "beta_agent")
    if len(rows) < FEWEST_CHOICES:
        return {**dict.fromkeys(names, math.nan), "n_choices": float(len(rows))}
    step, agent = exposed.step[rows], exposed.agent[rows]
    to_x, to_y = options.x[rows], options.y[rows]
    x, y = run.x[step, agent][:, None], run.y[step, agent][:, None]
    place = to_nearest_place(run.world, to_x, to_y) - to_nearest_place(run.world, x, y)
    others = run.x[step], run.y[step]
    there = None if run.present is None else run.present[step]
    other = to_nearest_agent(to_x, to_y, *others, agent, there) - to_nearest_agent(x, y, *others, agent, there)
    covariates: FloatArray = np.nan_to_num(np.stack([options.change[rows], place, other], axis=2))
    beta = conditional_logit(covariates, options.legal[rows], run.choice[step, agent] - STAY - 1)
    return {**dict(zip(names, beta.tolist(), strict=True)), "n_choices": float(len(rows))}


def _latency(exposed: _Exposed, steps: int) -> dict[str, float]:
    agents = np.unique(exposed.agent)
    away = [exposed.change[exposed.agent == agent] > 0 for agent in agents]
    observed = np.array([bool(flags.any()) for flags in away], dtype=np.bool_)
    times = np.array([flags.argmax() + 1 if flags.any() else len(flags) for flags in away], dtype=np.int64)
    return {"latency": restricted_mean(times, observed, steps), "n_exposed_agents": float(len(agents))}
