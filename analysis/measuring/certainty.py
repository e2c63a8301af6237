"""What the log-probabilities of a run tell of its decisions, where `model.logprobs` kept them.

`steps.parquet` has three more columns then: `probability` of what was decided, and `entropy` over what could be
decided, bits, both among the declared labels alone; `covered` is the probability that these have together. They are
empty where one token does not decide: a number, a label that is not in the reply once, labels that begin alike.
"""

from collections.abc import Iterable

import pyarrow as pa  # type: ignore[import-untyped]

from analysis.any.any_arrays import objects
from analysis.any.any_run import Probabilities
from analysis.form import Records
from foundry.certainty import Certainty, Sampling, certainty_of
from foundry.records import Call
from foundry.storing.matching import with_calls
from foundry.storing.store import RunFolder

COLUMNS = pa.schema({"probability": pa.float64(), "entropy": pa.float64(), "covered": pa.float64()})
TRUTH = "truth"
"""The key under which a world records the right decision beside each of its steps."""


def keeps_logprobs(folder: RunFolder) -> bool:
    """Return whether the log of a run keeps log-probabilities."""
    return folder.recorded_config()["model"].get("logprobs") is not None


def columns_of(runs: Iterable[RunFolder]) -> list[pa.Schema]:
    """Return the columns above, where the log of one of these runs keeps log-probabilities."""
    return [COLUMNS] if any(map(keeps_logprobs, runs)) else []


def probabilities_of(folder: RunFolder, records: Records) -> Probabilities | None:
    """Return what the tokens of a run tell of its decisions; None where its log keeps no log-probabilities."""
    if not keeps_logprobs(folder):
        return None
    columns, declared = records.decisions(), folder.declared
    asked = zip(columns["step"], columns["agent"], columns["kind"], strict=True)
    size = len(columns["step"])
    told: list[Certainty | None] = [None] * size
    for number, call in with_calls(zip(asked, range(size), strict=True), folder.calls()):
        told[number] = None if call is None else _of(call, columns["action"][number], folder)
    knows = TRUTH in declared.streams.get("steps", {})
    return Probabilities(
        told=objects(told),
        truth=objects(records.columns([TRUTH])[TRUTH] if knows else [None] * size),
        knows_truth=knows,
    )


def with_certainty(steps: pa.Table, probabilities: Probabilities | None) -> pa.Table:
    """Return the steps of a run with the columns above, where its log keeps log-probabilities."""
    if probabilities is None:
        return steps
    for field in COLUMNS:
        values = [None if one is None else getattr(one, field.name) for one in probabilities.told]
        steps = steps.append_column(field, pa.array(values, type=field.type))
    return steps


def _of(call: Call, action: object, folder: RunFolder) -> Certainty | None:
    actions = folder.declared.actions.get(call.kind)
    if actions is None or not call.logprobs or action not in actions.labels:
        return None
    return certainty_of(call.text, call.logprobs, str(action), actions.labels, Sampling.of(call.parameters))
