"""Which answers of a probe an analysis takes, where it is not all of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import replace
from typing import TypeAlias

from analysis.filtering import Filter, value_text
from analysis.probes.choices import NONE, Answers, Asked, Chosen, MomentKey
from analysis.probes.strata import Strata
from foundry.errors import InputError, not_found

_REFERENCES = ("edit", "format")
"""The keys whose `none` all else is compared with, so that `only` keeps it."""

Values: TypeAlias = Mapping[str, Set[str]]
"""What a filter may name, by key."""


def narrowed(answers: Answers, strata: Strata, chosen: Filter) -> Answers:
    """Return the answers that a filter takes.

    A key is `model`, `prompt`, `sampling_seed`, `edit`, `format`, a part of the moment's key such as `kind` or `seed`,
    or one of the strata. `only` keeps moments that are not edited and prompts as they are written.

    Raises:
        InputError: no answer has such a key or value, or none is left.
    """
    if not chosen:
        return answers
    _check(answers, strata, chosen)
    left: dict[Asked, Chosen] = {}
    for asked, moments in answers.chosen.items():
        whose = _of_asked(answers, asked)
        taken = {key: counts for key, counts in moments.items() if _takes(chosen, {**_of(key, strata), **whose})}
        if taken:
            left[asked] = taken
    if not left:
        raise InputError(f"{chosen} leaves none of {counted_answers(answers):,} answers: leave out a filter.")
    return replace(
        answers,
        chosen=left,
        changes={name: change for name, change in answers.changes.items() if name in {asked.edit for asked in left}},
        formats=tuple(name for name in answers.formats if name in {asked.format for asked in left}),
        names={
            subject: name for subject, name in answers.names.items() if subject in {asked.subject for asked in left}
        },
    )


def counted_answers(answers: Answers) -> int:
    """Return how many answers there are."""
    return sum(counts.total() for moments in answers.chosen.values() for counts in moments.values())


def _check(answers: Answers, strata: Strata, chosen: Filter) -> None:
    """Refuse keys and values that no answer has."""
    available: dict[str, set[str]] = {}
    for values in _every(answers, strata):
        for key, texts in values.items():
            available.setdefault(key, set()).update(texts)
    for key, asked in (*chosen.only.items(), *chosen.without.items()):
        if key not in available:
            raise not_found("Key of a probe", key, available)
        for value in asked:
            if value not in available[key]:
                raise not_found(key.capitalize(), value, available[key])


def _every(answers: Answers, strata: Strata) -> Iterator[Values]:
    for asked, moments in answers.chosen.items():
        yield _of_asked(answers, asked)
        yield from (_of(key, strata) for key in moments)


def _of_asked(answers: Answers, asked: Asked) -> Values:
    model, prompt, sampling_seed = asked.subject
    return {
        "model": {model, answers.names[asked.subject]},
        "prompt": {prompt},
        "sampling_seed": {sampling_seed or value_text(None)},
        "edit": {asked.edit},
        "format": {asked.format},
    }


def _of(key: MomentKey, strata: Strata) -> Values:
    told = {**strata.get(key[1:], {}), **key._asdict()}
    return {name: {value_text(value)} for name, value in told.items()}


def _takes(chosen: Filter, values: Values) -> bool:
    return all(
        values.get(key, set()) & set(asked) or (key in _REFERENCES and NONE in values[key])
        for key, asked in chosen.only.items()
    ) and not any(values.get(key, set()) & set(asked) for key, asked in chosen.without.items())
