"""Heterogeneity: how far agents differ from each other throughout a run, beyond chance."""

from analysis.any.any_run import AnyRun
from analysis.any.decided import decided
from analysis.any.deviations import ALIKE, lasting
from analysis.measure import Measure, Null, share

NAME = "heterogeneity"

PRIMARY = False

MEASURES = {
    "beyond_shuffled": Measure(
        "Lasting differences between agents, minus those of shuffled agents (share)",
        null=Null(0, ALIKE),
        says="has agents that differ {more|less} from each other",
    ),
    "p": share("Shuffles in which agents differ as much (share)"),
}

HEADLINE = ("beyond_shuffled",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return how far agents differ from each other in their counted actions through a whole run.

    An action that is a label becomes a column per possible label, with 1 for the chosen one; a number is one column.
    Each action is compared with the other agents' actions at the same moment, so common behaviour cancels out. A moment
    is a step. If agents mostly decide alone in a step, as in turns, a moment is a third of the run.

    Lasting differences show in both the first and the last third of the steps. A shuffled agent joins the first third
    of one agent with the last third of another. The order of actions within each third stays, so shuffled agents have
    the habits of real agents from step to step. The test is right if habits last no longer than the middle third.

    - beyond_shuffled: covariance between the agents' mean actions in the two thirds (ddof 1). This is the variance
      between agents, minus its mean over all shuffles. The measure is a share of the variance of actions at a moment.
      That variance is half the mean squared difference between two agents, or for labels the share of pairs of agents
      that differ. 0: agents are alike; 1: each agent always acts in a way of its own. Values below 0 arise by chance,
      or from agents that swap habits. Only agents that are asked the same kinds of questions are compared; each kind
      weighs by its number of decisions. Every lasting difference counts, such as a persona, a model, a place, or a
      habit that lasts more than a third of the run.
    - p: share of shuffles, the actual run included, in which the sum of the products of the two thirds is at least as
      large as in the actual run; 0..1. Up to six agents, all N! shuffles are taken; else 999 random ones and the actual
      run. The smallest possible p is 1/N!.

    NaN with fewer than two steps, with fewer than two agents that act at moments with others in both thirds, or if all
    agents always act alike. If all agents decide at every step, the share is unbiased and within -1..1. If the deciding
    agents are chosen at random, it is nearly unbiased; with few decisions it may fall outside these bounds.
    Denominator: n_agents, the compared agents.

    Source: Snedecor and Cochran 1967 for the variance between groups; Pitman 1937 for the shuffles. The thirds and the
    comparison within a moment are new in foundry.
    """
    differences = lasting(decided(run), run.agents)
    return {"beyond_shuffled": differences.share, "p": differences.p, "n_agents": float(differences.agents)}
