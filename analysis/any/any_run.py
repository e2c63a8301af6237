"""One recorded run of any form as arrays, the input of signatures of all forms.

K decisions in the order of the records, which is that of the steps; N agents; M deliveries.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from analysis.arrays import BoolArray, Decisions, FloatArray, IntArray, TextArray
from analysis.costs import RunCost
from foundry.declared import Declared


@dataclass(frozen=True, eq=False)
class LabelledTexts:
    """The n texts of a run that a label with C choices is about.

    Attributes:
        surrogate: 1 for the choice of the rule or the model, 0 for all others, (n, C); None where neither is there.
        truth: share of the people who chose each choice, (n, C); NaN where nobody labelled.
        weight: texts that each labelled text stands for, (n,).
        counted: texts of decisions that could be read, (n,).
        is_corrected: whether labels of people correct the shares.
    """

    surrogate: FloatArray | None
    truth: FloatArray
    weight: FloatArray
    counted: BoolArray
    is_corrected: bool


@dataclass(frozen=True, eq=False)
class Probabilities:
    """What the tokens of replies tell of the K decisions of a run.

    Attributes:
        told: a `foundry.certainty.Certainty` of each, (K,); None where no one token decides.
        truth: the right decision, (K,); None where there is none.
        knows_truth: whether the world says which decisions are right.
    """

    told: TextArray
    truth: TextArray
    knows_truth: bool


@dataclass(frozen=True, eq=False)
class AnyRun(Decisions):
    """One complete run.

    Attributes:
        id: the run's id.
        declared: what its world says of its records.
        step: 1-based step, never falling, (K,).
        agent: agent id, (K,).
        kind: of the question that decided, (K,).
        action: the label that was decided, (K,); None where nothing was, or the action is a number.
        number: the number that was decided, (K,); NaN where nothing was, or the action is a label.
        outcome: of the call, index into OUTCOMES, (K,).
        utility: what the agent got, (K,); NaN where nothing is said of it.
        said: the message, or None, (K,).
        deliveries: rows (step, sender, recipient) of delivered messages, (M, 3).
        agents: number of agents, N: the greatest id that occurs anywhere, and one.
        personas: attribute to value by agent id, N of them; empty where an agent has none.
        cost: what the run took, or None where that is unknown.
        world: the settings of its world.
        readable_only: whether the decisions that could not be read are left out of all that is counted.
        labels: the texts that labels of one's own are about, by label.
        probabilities: what the tokens of replies tell of the decisions; None where the log keeps no log-probabilities.
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
    cost: RunCost | None = None
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
        """Whether every decision and every labelled text could be read, so that leaving out others changes nothing."""
        return super().all_readable and all(bool(texts.counted.all()) for texts in self.labels.values())

    @property
    def talks(self) -> bool:
        """True if its world can send messages, or declares nothing."""
        streams = self.declared.streams
        return not streams or "messages" in streams or "message" in streams.get("steps", {})
