"""One recorded run of any form as arrays, from which signatures for all forms are computed.

In the shapes of arrays, K is the number of decisions, in recorded order (by step). N is the number of agents, and M the
number of delivered messages.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from analysis.arrays import BoolArray, Decisions, FloatArray, IntArray, TextArray
from foundry.declared import Declared
from foundry.records import Counts


@dataclass(frozen=True, eq=False)
class LabelledTexts:
    """The n texts of a run that can get a label with C choices.

    Attributes:
        surrogate: 1 for the choice of the rule or the model, 0 for all others, (n, C); None without a rule or model.
        truth: share of the people who chose each choice, (n, C); NaN for texts that nobody labelled.
        weight: number of texts that each text labelled by people represents, (n,).
        counted: whether the text's decision was readable, (n,).
        is_corrected: whether people labelled a sample, so that shares are corrected by it.
    """

    surrogate: FloatArray | None
    truth: FloatArray
    weight: FloatArray
    counted: BoolArray
    is_corrected: bool


@dataclass(frozen=True, eq=False)
class Probabilities:
    """The probabilities of the K decisions of a run, from the tokens of the replies.

    Attributes:
        told: `foundry.certainty.Certainty` of each decision, (K,); None where no single token decides.
        truth: the right decision at each decision, (K,); None where there is none.
        knows_truth: whether the world says which decisions are right.
    """

    told: TextArray
    truth: TextArray
    knows_truth: bool


@dataclass(frozen=True, eq=False)
class AnyRun(Decisions):
    """One complete run.

    Attributes:
        step: 1-based step, ascending, (K,).
        agent: agent id, (K,).
        kind: kind of the question, (K,).
        action: the chosen label, (K,); None without a decision, or if the action is a number.
        number: the chosen number, (K,); NaN without a decision, or if the action is a label.
        outcome: outcome of the call, index into OUTCOMES, (K,).
        utility: payoff of the agent, (K,); NaN where none is recorded.
        said: the message, or None, (K,).
        deliveries: rows (step, sender, recipient) of delivered messages, (M, 3).
        agents: number of agents, N: the greatest id in any record, plus one.
        personas: attribute to value by agent id, N of them; empty for an agent without a persona.
        totals: totals of calls and tokens; None where unknown.
        wall_s: seconds from start to end; NaN where unknown.
        readable_only: whether measures leave out unreadable decisions.
        labels: the texts with their labels, by the name of a user-defined label.
        probabilities: token probabilities of the decisions; None if the log has no log-probabilities.
    """

    id: str
    declared: Declared
    step: IntArray
    agent: IntArray
    kind: TextArray
    action: TextArray
    number: FloatArray
    outcome: IntArray
    utility: FloatArray
    said: TextArray
    deliveries: IntArray
    agents: int
    personas: tuple[Mapping[str, str], ...]
    totals: Counts | None = None
    wall_s: float = math.nan
    world: Mapping[str, Any] = field(default_factory=dict)
    readable_only: bool = False
    labels: Mapping[str, LabelledTexts] = field(default_factory=dict)
    probabilities: Probabilities | None = None

    @property
    def decisions(self) -> int:
        """Number of decisions, K."""
        return len(self.step)

    @property
    def all_readable(self) -> bool:
        """True if every decision and every text with a label is readable."""
        return super().all_readable and all(bool(texts.counted.all()) for texts in self.labels.values())

    @property
    def talks(self) -> bool:
        """True if agents of the world can send messages, or if the world declares no records."""
        streams = self.declared.streams
        return not streams or "messages" in streams or "message" in streams.get("steps", {})
