"""Selects answers of a probe by their properties, such as the edit or the stratum of the moment."""

from collections.abc import Iterable, Mapping, Set
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import msgspec
import pandas as pd

from analysis.filtering import Filter, value_text
from analysis.probes.choices import NONE, Answers, MomentKey, ProbeCondition
from foundry.errors import InputError, RecordError, not_found
from foundry.records import NOT_JSON

_KEY = [name for name in MomentKey._fields if name != "seed"]
_REFERENCES = ("edit", "format")
"""For these keys, results are compared with the value `none`, so the filter `only` never removes answers with it."""
Values: TypeAlias = Mapping[str, Set[str]]
"""The values of an answer that a filter may name, by key."""
Strata: TypeAlias = Mapping[tuple[str, int, int, str, int], Mapping[str, str | bool]]
"""The strata of each moment, by its run, step, agent, kind and `again`."""


class _Moments(msgspec.Struct):
    """Content of `moments.json`: run, step, agent, kind and `again` of each moment, and its strata."""

    moments: list[tuple[str, int, int, str, int]]
    strata: list[dict[str, str | bool]] = []


def strata_of(file: Path) -> Strata:
    """Read the strata of the moments of a probe.

    Raises:
        RecordError: the file cannot be read.
    """
    try:
        drawn = msgspec.json.decode(file.read_bytes(), type=_Moments)
    except (OSError, *NOT_JSON) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error
    return dict(zip(drawn.moments, drawn.strata, strict=False))


def with_strata(moments: pd.DataFrame, strata: Strata) -> pd.DataFrame:
    """Add a column for each stratum to a table of moments."""
    names = list(dict.fromkeys(name for values in strata.values() for name in values))
    if not names:
        return moments
    columns = pd.DataFrame([{**dict(zip(_KEY, key, strict=True)), **values} for key, values in strata.items()])
    joined = moments.merge(columns, on=_KEY, how="left", validate="many_to_one")
    first = [*MomentKey._fields, *names]
    return joined[[*first, *(name for name in moments.columns if name not in first)]]


def narrowed(answers: Answers, strata: Strata, chosen: Filter) -> Answers:
    """Return the answers that a filter selects.

    A filter may name `model`, `prompt`, `sampling_seed`, `edit`, `format`, a field of `MomentKey` such as `kind`, or a
    stratum. `only` also keeps the references: answers without an edit, and to the unchanged prompt.

    Raises:
        InputError: no answer has such a key or value, or no answer is left.
    """
    if not chosen:
        return answers
    values = {
        (asked, key): _values(answers, asked, key, strata)
        for asked, moments in answers.chosen.items()
        for key in moments
    }
    _check(values.values(), chosen)
    left = {
        asked: taken
        for asked, moments in answers.chosen.items()
        if (taken := {key: counts for key, counts in moments.items() if _takes(chosen, values[asked, key])})
    }
    if not left:
        raise InputError(f"The filter {chosen} selects none of {answers.count:,} answers: remove a part of it.")
    edits, formats, subjects = ({asked[at] for asked in left} for at in (1, 2, 0))
    return replace(
        answers,
        chosen=left,
        changes={name: change for name, change in answers.changes.items() if name in edits},
        formats=tuple(name for name in answers.formats if name in formats),
        names={subject: name for subject, name in answers.names.items() if subject in subjects},
    )


def _values(answers: Answers, asked: ProbeCondition, key: MomentKey, strata: Strata) -> Values:
    model, prompt, sampling_seed = asked.subject
    moment = {**strata.get(key[1:], {}), **key._asdict()}
    return {name: {value_text(value)} for name, value in moment.items()} | {
        "model": {model, answers.names[asked.subject]},
        "prompt": {prompt},
        "sampling_seed": {sampling_seed or value_text(None)},
        "edit": {asked.edit},
        "format": {asked.format},
    }


def _check(values: Iterable[Values], chosen: Filter) -> None:
    """Raise InputError if the filter names a key or value that no answer has."""
    available: dict[str, set[str]] = {}
    for own in values:
        for key, texts in own.items():
            available.setdefault(key, set()).update(texts)
    for key, asked in (*chosen.only.items(), *chosen.without.items()):
        if key not in available:
            raise not_found("Key of a probe", key, available)
        for value in asked:
            if value not in available[key]:
                raise not_found(key.capitalize(), value, available[key])


def _takes(chosen: Filter, values: Values) -> bool:
    return all(
        values.get(key, set()) & set(asked) or (key in _REFERENCES and NONE in values[key])
        for key, asked in chosen.only.items()
    ) and not any(values.get(key, set()) & set(asked) for key, asked in chosen.without.items())
