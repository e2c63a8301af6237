"""Composes a probe from recorded sweeps and a command line: its moments, models, prompts and edits."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import msgspec

from foundry.certainty import NEUTRAL, OPEN, Sampling
from foundry.composing.compose import Composed
from foundry.composing.defaults import Defaults
from foundry.composing.preflight import scenario_of
from foundry.composing.recorded import compose_recorded, without_format
from foundry.errors import InputError
from foundry.expansion import FORMAT, Condition, Sweep, expand, overridden, settings_key
from foundry.naming import format_of
from foundry.probing.drawing import Past, drawn, listed, moments_and_past, strata_of
from foundry.running.recorded import excerpts, first_difference
from foundry.storing.store import PROBE, RunFolder, SweepFolder, with_moments, without_servers
from foundry.texts import counted
from foundry.worlds.base import Scenario
from foundry.worlds.probe.editing import NONE, find_edits
from foundry.worlds.probe.moments import Moment, Moments, by_run, questions_at
from foundry.worlds.probe.probe_world import ProbeScenario
from foundry.worlds.probe.quantities import check_path, moves_of, split

OWN = {"edit": NONE, "sweep_over": "", "repeats": "10", "moments": "300", "moments_seed": "0", "window": "5"}
"""The settings that only a probe has, with their defaults."""
_KEPT = ("world", "layout", "scene", "task", "seed")
"""Settings that the recorded moments determine, so that a probe must not override them."""


@dataclass(frozen=True)
class Probe:
    """A probe that is ready to run.

    Attributes:
        composed: conditions and settings.
        moments: content of `moments.json`.
        past: recorded calls of each run with moments, up to its last moment.
        asked: text that states the number of moments, runs and calls.
    """

    composed: Composed
    moments: bytes
    past: Mapping[str, Past]
    asked: str

    def keep(self, folder: SweepFolder) -> None:
        """Write the moments into the probe's folder."""
        folder.write_moments(self.moments, {run: past.calls for run, past in self.past.items()})

    def placed(self, scratch: Path, sweep: Sweep) -> Sweep:
        """Write the moments into an empty folder; return a sweep that reads them there."""
        self.keep(SweepFolder(scratch, sweep, {}, []))
        return with_moments(sweep, scratch)


@dataclass(frozen=True)
class _ProbeArguments:
    edits: tuple[str, ...]
    moves: tuple[str, ...]
    moments: str
    repeats: int
    moments_seed: int
    window: int

    @classmethod
    def of(cls, arguments: Sequence[str]) -> "_ProbeArguments":
        given = dict(argument.split("=", 1) for argument in arguments if argument.partition("=")[0] in OWN)
        values = {**OWN, **given}
        edits = [name.strip() for name in values["edit"].strip("[]").split(",")]
        least = {"repeats": 1, "moments_seed": 0, "window": 0}
        numbers = {key: _number(key, values[key], at_least) for key, at_least in least.items()}
        # Edited moments are compared with unedited ones.
        moves = moves_of(values["sweep_over"]) if values["sweep_over"] else ()
        names = tuple(dict.fromkeys([NONE, *edits, *moves]))
        return cls(names, tuple(moves), moments=values["moments"], **numbers)


def _with_none(override: str) -> str:
    """Add `none`, the unchanged prompt, to an override of `format`: foundry compares formats with this prompt."""
    key, _, value = override.partition("=")
    names = [name.strip() for name in value.strip("[]").split(",")]
    return override if key != FORMAT or NONE in names else f"{key}={','.join([NONE, *names])}"


def _check_moves(names: Sequence[str], scenario: Scenario, moments: Iterable[Moment], past: Mapping[str, Past]) -> None:
    questions = (
        question
        for run, mine in by_run(moments).items()
        for question in questions_at(scenario, past[run].seed, past[run].said(), mine)
    )
    path, _ = split(names[0])
    check_path(path, scenario.form, questions, [split(name)[1] for name in names])


def _number(key: str, text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise InputError(f"{key} must be a whole number from {least}; got {text!r}.")
    return int(text)


def compose_probe(
    sweeps: Sequence[SweepFolder], arguments: Sequence[str], defaults: Defaults | None = None
) -> Probe | None:
    """Compose a probe of the moments of recorded sweeps.

    Args:
        sweeps: one or more sweeps of the same world.
        arguments: overrides as for a sweep, and the settings in `OWN`, such as `edit=`.
        defaults: the user's defaults.

    Returns:
        The probe, or None if the command line contained a flag that Hydra answers itself.

    Raises:
        InputError: a setting is invalid, or there are no moments.
    """
    asked = _ProbeArguments.of(arguments)
    overrides = [_with_none(argument) for argument in arguments if argument.partition("=")[0] not in OWN]
    runs = _runs(sweeps)
    config = _source_config(runs, overridden(overrides))
    composed = compose_recorded(config, [*overrides, "record.frames=false"], defaults)
    if composed is None:
        return None
    scenario = scenario_of(config)
    edits = [edit.described(scenario) for name in asked.edits for edit in find_edits(name, scenario)]
    recorded = {run.id: Past.of(run) for run in runs}
    moments, past = _moments(asked, recorded, scenario)
    if asked.moves:
        _check_moves(asked.moves, scenario, moments.moments, past)
    content = msgspec.json.format(msgspec.json.encode(moments), indent=1) + b"\n"
    seeds = tuple(sorted({source.seed for source in past.values()}))
    conditions = [
        _condition(condition, edit, asked.repeats, hashlib.sha256(content).hexdigest(), seeds)
        for condition in composed.conditions
        for edit in edits
    ]
    names = [sweep.path.resolve().name for sweep in sweeps]
    settings = {**composed.settings, "analyze": bool(composed.settings["analyze"])}
    composed = replace(
        composed,
        asked=("probe", *names, *composed.chosen, *arguments),
        conditions=tuple(conditions),
        settings=settings,
    )
    return Probe(composed, content, past, _size_line(len(moments.moments), len(past), conditions, asked.repeats))


def _size_line(moments: int, runs: int, conditions: Sequence[Condition], repeats: int) -> str:
    calls = counted(moments * len(conditions) * repeats, "call")
    asked = f"{counted(len(conditions), 'condition')}, {counted(repeats, 'repeat')}"
    names_sampling = any("sampling" in condition.config["world"] for condition in conditions)
    once = ", one for all repeats where probabilities suffice" if names_sampling else ""
    return (
        f"{counted(moments, 'moment')} of {counted(runs, 'run')}, {asked}: at most {calls}, "
        f"fewer if an edit does not change every moment{once}"
    )


def _runs(sweeps: Sequence[SweepFolder]) -> list[RunFolder]:
    """Return the complete runs, because moments of a failed run would not represent a whole run."""
    runs = {run.id: run for sweep in sweeps for run in sweep.runs()}
    complete = [run for run in runs.values() if run.is_complete]
    if not complete:
        raise InputError(f"'{sweeps[0].path}' contains no complete run. Continue it first with foundry resume.")
    return complete


def _source_config(runs: Sequence[RunFolder], given: set[str]) -> dict[str, Any]:
    """Return the recorded configuration to which the overrides apply.

    Raises:
        InputError: an override would change the moments, or the runs differ in a setting that no override sets.
    """
    for key in sorted(given):
        if key.partition(".")[0] in _KEPT:
            raise InputError(f"A probe asks in recorded moments, which {key}= would change. Leave it out.")
    configs = [run.config() for run in runs]
    if runs[0].declared.form == ProbeScenario.form:
        raise InputError("This sweep is itself a probe. Name the sweep of its moments.")
    for key in ("world", "model", "prompt", "sampling_seed"):
        recorded_configs = (
            config[key] if key == "sampling_seed" else without_format(config[key], key, given) for config in configs
        )
        recorded = {settings_key({key: config}): config for config in recorded_configs}
        if key not in given and len(recorded) > 1:
            raise _several(key, list(recorded.values()))
    return {key: value for key, value in configs[0].items() if key != "fork"}


def _several(key: str, recorded: Sequence[Any]) -> InputError:
    names = list(dict.fromkeys(str(model["name"] if isinstance(model, Mapping) else model) for model in recorded))
    formats = list(dict.fromkeys(format_of(value) for value in recorded)) if key == "prompt" else []
    if len(names) == 1 and len(formats) > 1:
        key, names = FORMAT, formats
    elif len(names) == 1:
        names = [_unlike(names[0], recorded[0], recorded[1])]
    hint = "name a sweep with only one world" if key == "world" else f"choose one with {key}="
    return InputError(f"The recorded runs have several {key.replace('_', ' ')}s ({', '.join(names)}): {hint}.")


def _unlike(name: str, first: Mapping[str, Any], second: Mapping[str, Any]) -> str:
    difference = first_difference(without_servers(first), without_servers(second))
    if difference is None:
        return name
    first_value, other = excerpts(*difference[1:])
    return f"{name} with {difference[0]} {first_value} and {other}"


def _moments(
    asked: _ProbeArguments, recorded: Mapping[str, Past], scenario: Scenario
) -> tuple[Moments, dict[str, Past]]:
    if not asked.moments.isdecimal():
        given = listed(Path(asked.moments), recorded)
        return moments_and_past(given.moments, recorded, given.strata)
    strata = strata_of(scenario, recorded)
    moments = drawn(recorded, _number("moments", asked.moments, 1), asked.moments_seed, asked.window, strata)
    if not moments:
        raise InputError("The recorded runs contain no question.")
    return moments_and_past(moments, recorded, [strata[moment] for moment in moments] if strata else ())


def _condition(
    condition: Condition, edit: Mapping[str, Any], repeats: int, moments: str, seeds: tuple[int, ...]
) -> Condition:
    source = condition.config["world"]
    world = {
        "_target_": PROBE,
        "name": f"probe of {source['name']}",
        "source": source,
        "edit": dict(edit),
        "repeats": repeats,
        "moments": moments,
        **_sampling_of(condition.config["model"]),
    }
    return Condition({**condition.factors, "edit": edit["name"]}, {**condition.config, "world": world}, seeds)


def _sampling_of(model: Mapping[str, Any]) -> dict[str, Any]:
    """Return the setting `sampling`; return {} if this model's log-probabilities cannot replace repeated calls."""
    options = {**(model.get("options") or {}), **(model.get("extra") or {})}
    named = {key: options[key] for key in ("temperature", *OPEN, *NEUTRAL) if options.get(key) is not None}
    return {"sampling": named} if model.get("logprobs") and Sampling.of(named) else {}


@dataclass(frozen=True)
class PlannedEdit:
    """The numbers of moments, conditions and calls that a probe plans for one edit.

    Attributes:
        moments: number of moments that the edit changes.
        conditions: number of combinations of model, prompt and format that are asked in them.
    """

    edit: str
    moments: int
    conditions: int
    calls: int


def planned(probe: Probe, scratch: Path) -> Sequence[PlannedEdit]:
    """Count the questions of a probe, edit by edit.

    Args:
        probe: the probe.
        scratch: an empty folder.

    Raises:
        RecordError: the questions of its moments cannot be rebuilt.
    """
    sweep = probe.placed(scratch, expand(probe.composed.asked, probe.composed.conditions))
    by_edit: dict[str, list[Condition]] = {}
    for condition in sweep.conditions:
        by_edit.setdefault(condition.config["world"]["edit"]["name"], []).append(condition)
    return [_planned(edit, conditions) for edit, conditions in by_edit.items()]


def _planned(edit: str, conditions: Sequence[Condition]) -> PlannedEdit:
    scenario = cast(ProbeScenario, scenario_of(conditions[0].config))
    moments = sum(scenario.count_moments(seed) for seed in conditions[0].seeds)
    return PlannedEdit(edit, moments, len(conditions), moments * len(conditions) * scenario.repeats)
