"""Adds conditions and seeds to a recorded sweep; recorded runs never change."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from foundry.canary import listed
from foundry.errors import InputError, RecordError
from foundry.expansion import Condition, Sweep, SweepCommand, expand, identity, leaves, settings_key
from foundry.storing.run_files import PROBE
from foundry.texts import counted, visible

_NAMED = ("world", "model", "prompt")
_SWEPT = (*_NAMED, "sampling_seed")
"""Parts of a condition whose settings may have several values in a sweep."""
_PARTS = (*_SWEPT, "fork", "record")
_SHOWN, _LONGEST = 3, 60
"""Maximum number of differences that an error lists, and maximum length of a value, characters."""


@dataclass(frozen=True)
class Growth:
    """A recorded sweep and a request for more runs.

    Attributes:
        asked: the requested sweep; some of its runs may already be recorded.
        sweep: both sweeps together; the recorded conditions come first, in their order.
    """

    there: Sweep
    asked: Sweep
    sweep: Sweep

    @cached_property
    def new(self) -> frozenset[str]:
        """Ids of the requested runs that the recorded sweep does not contain yet."""
        return frozenset(run.id for run in self.sweep.runs) - {run.id for run in self.there.runs}

    def recorded(self, when: str) -> Sweep:
        """Return the sweep with old and new runs; its history has the request and its time (ISO 8601, UTC)."""
        return replace(
            self.sweep, history=(*self.there.history, SweepCommand(tuple(self.asked.asked), when, len(self.new)))
        )

    def notes(self, name: object) -> list[str]:
        """Return the lines that the user sees before the added runs begin; `name` is the name of the sweep's folder."""
        if not self.new:
            return []
        return [f"{name} has {counted(len(self.there.runs), 'run')}; the command adds {counted(len(self.new), 'run')}"]


def growth(there: Sweep, asked: Sweep) -> Growth:
    """Add the runs of a request to a recorded sweep.

    A world, model or prompt with a recorded name must have the recorded settings. Only the settings that have several
    values in the sweep or in the request may differ.

    Raises:
        InputError: settings differ, or a probe and whole runs would be mixed.
        RecordError: a requested run was recorded under another id.
    """
    _check_kind(there, asked)
    _check_agrees(there, asked)
    conditions = list(there.conditions)
    places = {_key(condition): number for number, condition in reversed(list(enumerate(conditions)))}
    for condition in asked.conditions:
        place = places.setdefault(_key(condition), len(conditions))
        if place == len(conditions):
            conditions.append(condition)
        else:
            known = conditions[place]
            conditions[place] = replace(known, seeds=tuple(dict.fromkeys((*known.seeds, *condition.seeds))))
    sweep = expand(there.asked, conditions, there.runs)
    ids = {run.id for run in sweep.runs}
    other = [run.id for run in asked.runs if run.id not in ids]
    if other:
        raise RecordError(
            f"Run {other[0]} was recorded under a different id, so the sweep cannot grow. Use a new output.dir."
        )
    return Growth(there, asked, sweep)


def check_declared(there: Sweep, now: Sweep) -> None:
    """Raise an error if a world of the sweep now declares other records than when the sweep began."""
    declared = {run.id: now.conditions[run.condition].declared for run in now.runs}
    for run in there.runs:
        then = there.conditions[run.condition]
        if run.id in declared and then.declared not in (None, declared[run.id]):
            raise InputError(
                f"The records of world '{then.config['world']['name']}' have changed since this sweep began. Restore "
                "the first version of the world and try again, or start a new sweep in another output.dir."
            )


def check_digests(there: Iterable[Mapping[str, Any]], models: Iterable[Mapping[str, Any]]) -> None:
    """Raise an error if a model of the sweep now has other weights than when the sweep began."""
    before = {model["name"]: model for model in there}
    for model in models:
        begun = before.get(model["name"])
        if begun is not None and not same_weights(begun, model):
            raise InputError(
                f"Model '{model['name']}' changed since this sweep began (digest {begun['digest'][:12]} then, "
                f"{model['digest'][:12]} now). Restore the first weights and try again, or start a new sweep "
                "in another output.dir."
            )


def same_weights(then: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    """Return whether two recorded models may have the same weights; other facts about the server do not count.

    Results of canary calls do not count either, because these calls are made again before any other call.
    """
    identities = [line.get("weights") or line["digest"] for line in (then, now)]
    identities_listed = [identity and listed(identity) for identity in identities]
    return None in identities_listed or identities_listed[0] == identities_listed[1] or then["digest"] == now["digest"]


def _key(condition: Condition) -> str:
    return settings_key(identity(condition.config))


def _check_kind(there: Sweep, asked: Sweep) -> None:

    kinds = [
        {condition.config["world"].get("_target_") == PROBE for condition in sweep.conditions}
        for sweep in (there, asked)
    ]
    if kinds[0] != kinds[1]:
        known, other = ("a probe", "whole runs") if True in kinds[0] else ("a sweep of whole runs", "a probe")
        raise InputError(f"The folder contains {known}, and {other} cannot be added to it. Use another output.dir.")


def _check_agrees(there: Sweep, asked: Sweep) -> None:
    recorded, now = (_settings(sweep.conditions) for sweep in (there, asked))
    for part in _PARTS:
        for name in (name_of_part for name_of_part in now[part] if name_of_part in recorded[part]):
            _check_part(part, name, recorded[part][name], now[part][name])


def _settings(conditions: Sequence[Condition]) -> dict[str, dict[str, list[dict[str, str]]]]:
    """Return all different settings by part (such as "world"), name and path (such as "fires.0.distance").

    A part that has no name, such as sampling_seed, has the name "".
    """
    settings: dict[str, dict[str, dict[str, Any]]] = {part: defaultdict(dict) for part in _PARTS}
    for condition in conditions:
        parts = {**identity(condition.config), "record": condition.config.get("record")}
        for part in _PARTS:
            value = {part: parts[part]} if part in parts else {}
            name = str(condition.config[part]["name"]) if part in _NAMED else ""
            settings[part][name].setdefault(settings_key(value), value)
    return {
        part: {name: _as_leaves(variants.values()) for name, variants in of.items()} for part, of in settings.items()
    }


def _as_leaves(variants: Iterable[Mapping[str, Any]]) -> list[dict[str, str]]:
    return [dict(leaves(value)) if value else {} for value in variants]


def _check_part(part: str, name: str, recorded: list[dict[str, str]], now: list[dict[str, str]]) -> None:
    """Raise an error if a setting differs from the record, unless the sweep or the request has several values of it."""
    swept = {*_varying(recorded), *_varying(now)} if part in _SWEPT else set()
    known = [_without(values, swept) for values in recorded]
    for values in (_without(values, swept) for values in now):
        if values not in known:
            closest = min((list(_differences(other, values)) for other in known), key=len)
            raise _contradiction(part, name, closest)


def _varying(variants: Sequence[Mapping[str, str]]) -> set[str]:
    paths = dict.fromkeys(path for variant in variants for path in variant)
    return {path for path in paths if len({variant.get(path) for variant in variants}) > 1}


def _without(settings: Mapping[str, str], paths: set[str]) -> dict[str, str]:
    return {path: value for path, value in settings.items() if path not in paths}


def _differences(there: Mapping[str, str], now: Mapping[str, str]) -> Iterator[tuple[str, str | None, str | None]]:
    for path in dict.fromkeys((*there, *now)):
        if there.get(path) != now.get(path):
            yield path, there.get(path), now.get(path)


def _contradiction(part: str, name: str, values_by_place: Sequence[tuple[str, str | None, str | None]]) -> InputError:
    ways = "; ".join(
        f"{path} was {_value(then)} and is {_value(now)} now" for path, then, now in values_by_place[:_SHOWN]
    )
    more = f"; and {len(values_by_place) - _SHOWN} more" if len(values_by_place) > _SHOWN else ""
    whose = f"of {part} '{name}' " if name else ""
    both = f", ask for both values of {values_by_place[0][0]}," if part in _SWEPT else ""
    return InputError(
        f"The sweep cannot grow, since settings {whose}would differ: {ways}{more}. Use the settings of the "
        f"sweep{both} or use another output.dir."
    )


def _value(value: str | None) -> str:
    if value is None:
        return "not set"
    shown = visible(value)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - 3]}..."
