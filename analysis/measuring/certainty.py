"""Computes the certainty of decisions from the log-probabilities that `model.logprobs` records.

With log-probabilities, `steps.parquet` has three more columns. `probability` is the share of the chosen label in the
total probability of the declared labels. `entropy` is the entropy of the probabilities of the declared labels, in bits.
`covered` is the total probability of the declared labels. The columns are empty if no single token decides: for a
number, for a label that occurs several times or never in the reply, and for labels with a common beginning.
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
"""The key of the correct decision in the records of a world."""


def keeps_logprobs(folder: RunFolder) -> bool:
    """Return whether the log-probabilities of a run were recorded."""
    return folder.recorded_config()["model"].get("logprobs") is not None


def columns_of(runs: Iterable[RunFolder]) -> list[pa.Schema]:
    """Return the columns of certainty, if the log-probabilities of any of the runs were recorded."""
    return [COLUMNS] if any(map(keeps_logprobs, runs)) else []


def probabilities_of(folder: RunFolder, records: Records) -> Probabilities | None:
    """Return the token probabilities of a run's decisions; None if they were not recorded."""
    if not keeps_logprobs(folder):
        return None
    columns, declared = records.decisions(), folder.declared
    asked = zip(columns["step"], columns["agent"], columns["kind"], strict=True)
    size = len(columns["step"])
    certainties: list[Certainty | None] = [None] * size
    for number, call in with_calls(zip(asked, range(size), strict=True), folder.calls()):
        certainties[number] = None if call is None else _of(call, columns["action"][number], folder)
    knows = TRUTH in declared.streams.get("steps", {})
    return Probabilities(
        told=objects(certainties),
        truth=objects(records.columns([TRUTH])[TRUTH] if knows else [None] * size),
        knows_truth=knows,
    )


def with_certainty(steps: pa.Table, probabilities: Probabilities | None) -> pa.Table:
    """Add the columns of certainty to the steps of a run, if its probabilities are known."""
    if probabilities is None:
        return steps
    for field in COLUMNS:
        values = [None if certainty is None else getattr(certainty, field.name) for certainty in probabilities.told]
        steps = steps.append_column(field, pa.array(values, type=field.type))
    return steps


def _of(call: Call, action: object, folder: RunFolder) -> Certainty | None:
    actions = folder.declared.actions.get(call.kind)
    if actions is None or not call.logprobs or action not in actions.labels:
        return None
    return certainty_of(call.text, call.logprobs, str(action), actions.labels, Sampling.of(call.parameters))
