"""Heterogeneity: lasting differences between the decisions of agents, beyond chance."""

from analysis.any.any_run import AnyRun
from analysis.any.decided import decided
from analysis.any.deviations import ALIKE, lasting
from analysis.measure import Measure, Null, share

NAME = "heterogeneity"

PRIMARY = False

MEASURES = {
    "beyond_shuffled": Measure(
        "Lasting differences between agents, beyond shuffled ones (share)",
        null=Null(0, ALIKE),
        says="has agents that differ {more|less} from each other",
    ),
    "p": share("Shuffles in which agents differ as much (share)"),
}

HEADLINE = ("beyond_shuffled",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return how far the agents of a run differ lastingly in their counted actions.

    An action is one column a label, 1 where it was decided, or a number. Each is held against the actions of the
    other agents at the same moment, so what all do alike at a step, whatever the reason, is no difference. A moment
    is a step; where most agents decide alone in their step, as in turns, a third of the run.

    What lasts is told from what comes and goes by two whole stretches: the first and the last third of the steps. A
    shuffled agent is the first third of one agent put together with the last third of another. A third keeps its
    order, so that habits from step to step are in shuffled agents as in real ones, and the third between is as long
    as the habits may be.

    - beyond_shuffled: variance between agents of their mean action over both thirds, less its mean over all shuffles,
      twice; that is the covariance of the thirds between agents (ddof 1). It is a share of the variance of actions at
      a moment, half the mean square of the difference between two agents, for labels the share of pairs of agents
      that differ. 0: agents alike; 1: each always does its own thing; below 0 only by chance or where agents swap
      ways. Agents that are asked different kinds of questions are not compared; kinds together weigh by their
      decisions. Whatever lasts counts, be it a persona, a model, a place or a habit longer than a third of the run.
    - p: share of the shuffles, the run as it is among them, whose sum of products of the thirds is as great: of all
      N! for up to six agents, else of 1,000, 999 of them random; 0..1. The least it can be is 1/N!.

    NaN with fewer than two steps, or two agents that act in both thirds at moments with others; where all always act
    alike. Where all agents decide at all steps the share is exactly unbiased and within -1..1; where chance says who
    does it is nearly so, and may leave these bounds when decisions are few.
    Denominator: n_agents, those compared.

    Source: Snedecor and Cochran 1967 for the variance between groups; Pitman 1937 for the shuffles; the thirds and
    the comparison at one moment are this project's own.
    """
    found = lasting(decided(run), run.agents)
    return {"beyond_shuffled": found.share, "p": found.p, "n_agents": float(found.agents)}
