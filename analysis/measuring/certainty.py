"""How sure a model was of its decisions, by the log-probabilities of the tokens that decide.

Columns of `steps.parquet`, where `model.logprobs` kept them: `probability` of what was decided, and `entropy` over what
could be decided, both among the declared labels alone; `covered` is the probability that these have together. They are
empty where one token does not decide: a number, a label that is not in the reply once, labels that begin alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import pyarrow as pa  # type: ignore[import-untyped]

from analysis.form import Records
from foundry.canary import TokenLogprobs
from foundry.records import Call
from foundry.storing.matching import with_calls
from foundry.storing.store import RunFolder

COLUMNS = pa.schema({"probability": pa.float64(), "entropy": pa.float64(), "covered": pa.float64()})


@dataclass(frozen=True)
class Certainty:
    """Of one decision: see the columns above; the entropy is in bits."""

    probability: float
    entropy: float
    covered: float


def certainty_of(text: str, tokens: Sequence[TokenLogprobs], decided: str, labels: Sequence[str]) -> Certainty | None:
    """Return how sure a reply was of what it decided; None where no one token decides that."""
    place = _place(text, tokens, decided)
    if place is None:
        return None
    before, token = place
    shares = _shares(before, token.top, labels)
    covered = math.fsum(shares.values())
    if not shares.get(decided):
        return None
    shares = {label: share / covered for label, share in shares.items() if share}
    entropy = -math.fsum(share * math.log2(share) for share in shares.values())
    return Certainty(shares[decided], max(0.0, entropy), min(1.0, covered))


def _place(text: str, tokens: Sequence[TokenLogprobs], decided: str) -> tuple[str, TokenLogprobs] | None:
    """Return the token in which a decision begins, and what it holds before that; the decision stands there once."""
    whole = "".join(token.token for token in tokens)
    quoted = f'"{decided}"'
    at = text.find(quoted) + 1 if text.count(quoted) == 1 else text.find(decided)
    shift = whole.find(text)
    if shift < 0 or at < 0 or (text.count(quoted) != 1 and text.count(decided) != 1):
        return None
    at, begin = at + shift, 0
    for token in tokens:
        if at < begin + len(token.token):
            return token.token[: at - begin], token
        begin += len(token.token)
    return None


def _shares(before: str, top: Mapping[str, float], labels: Sequence[str]) -> dict[str, float]:
    """Return the probability of each label by the tokens that can begin it; none where a token begins several."""
    shares = dict.fromkeys(labels, 0.0)
    for token, logprob in top.items():
        rest = token.removeprefix(before)
        if not token.startswith(before) or not rest:
            continue
        begun = [label for label in labels if label.startswith(rest) or _is_followed(rest, label)]
        if len(begun) > 1:
            return {}
        for label in begun:
            shares[label] += math.exp(logprob)
    return shares


def _is_followed(rest: str, label: str) -> bool:
    """Return whether a token holds a whole label and the mark that ends it."""
    return rest.startswith(label) and not rest[len(label)].isalnum()


def keeps_logprobs(folder: RunFolder) -> bool:
    """Return whether the log of a run keeps log-probabilities."""
    return folder.recorded_config()["model"].get("logprobs") is not None


def columns_of(runs: Iterable[RunFolder]) -> list[pa.Schema]:
    """Return the columns above, where the log of one of these runs keeps log-probabilities."""
    return [COLUMNS] if any(map(keeps_logprobs, runs)) else []


def with_certainty(steps: pa.Table, folder: RunFolder, records: Records) -> pa.Table:
    """Return the steps of a run with the columns above, where its log keeps log-probabilities."""
    if not keeps_logprobs(folder):
        return steps
    columns = records.decisions()
    asked = zip(columns["step"], columns["agent"], columns["kind"], strict=True)
    rows: list[Certainty | None] = [None] * steps.num_rows
    for number, call in with_calls(zip(asked, range(steps.num_rows), strict=True), folder.calls()):
        rows[number] = None if call is None else _of(call, columns["action"][number], folder)
    for field in COLUMNS:
        values = [None if row is None else getattr(row, field.name) for row in rows]
        steps = steps.append_column(field, pa.array(values, type=field.type))
    return steps


def _of(call: Call, action: object, folder: RunFolder) -> Certainty | None:
    actions = folder.declared.actions.get(call.kind)
    if actions is None or not call.logprobs or action not in actions.labels:
        return None
    return certainty_of(call.text, call.logprobs, str(action), actions.labels)
