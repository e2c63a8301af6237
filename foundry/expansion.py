"""Expands composed configurations to a list of runs, without files or models."""

import base64
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from foundry.declared import Declared
from foundry.errors import InputError
from foundry.naming import with_first_names
from foundry.texts import visible

SEED_KEYS = ("seed", "sampling_seed")
"""The settings for which a command line may give a range of numbers, such as `seed=0-9`."""
FORMAT, DEFAULT_SPACE = "format", "spread"
"""The setting `format`, and the space of formats for a number without a space: `format=3` means `format=spread/3`."""

IDENTITY_KEYS = ("world", "prompt", "model", "sampling_seed", "seed", "fork")
"""The keys of a configuration that define a run, except `model.server`, which says how to reach a model."""

_RANGE = re.compile(r"(\d+)-(\d+)")
_MAX_RANGE = 1_000_000
LONGEST_NAME, LONGEST_SHOWN = 240, 40
"""Maximum number of characters in the name of a world, model or prompt, and in a name that an error shows."""


@dataclass(frozen=True)
class Condition:
    """The settings of a group of runs that differ only in their seed.

    Attributes:
        factors: values of the swept settings.
        config: composed configuration, without `seed`.
        declared: declaration of its world's records; None if it was not requested or not recorded.
    """

    factors: Mapping[str, Any]
    config: Mapping[str, Any]
    seeds: tuple[int, ...]
    declared: Declared | None = None


@dataclass(frozen=True)
class Run:
    """One episode: a condition (its index in the sweep) with a seed."""

    id: str
    condition: int
    seed: int


@dataclass(frozen=True)
class SweepCommand:
    """A command that added runs to a sweep.

    Attributes:
        when: its time, ISO 8601 in UTC; None if not recorded.
        runs: number of runs that it added.
    """

    overrides: tuple[str, ...]
    when: str | None
    runs: int


@dataclass(frozen=True)
class Sweep:
    """All conditions with their seeds.

    Attributes:
        asked: overrides of the user's first command.
        conditions: conditions in the order of the grid; later additions are last.
        runs: runs in the order in which they start.
        history: the commands that made the sweep; empty before the sweep has a folder.
    """

    asked: tuple[str, ...]
    conditions: tuple[Condition, ...]
    runs: tuple[Run, ...]
    history: tuple[SweepCommand, ...] = ()

    @property
    def definition(self) -> str:
        """Hash of everything that affects the files of the sweep."""
        record = [condition.config.get("record") for condition in self.conditions]
        return _digest({"runs": sorted(run.id for run in self.runs), "record": record}).hex()

    def model_names(self) -> list[str]:
        """Return the models' names in the order of their first runs, on which the models' colours in plots depend."""
        first = dict.fromkeys(run.condition for run in self.runs)
        return list(dict.fromkeys(str(self.conditions[number].config["model"]["name"]) for number in first))

    def config(self, run: Run) -> dict[str, Any]:
        """Return the whole configuration of a run, with its seed."""
        return {**self.conditions[run.condition].config, "seed": run.seed}


def expand_ranges(override: str) -> str:
    """Expand ranges of seeds and draws of formats in an override: `seed=0-2,7` becomes `seed=0,1,2,7`."""
    key, equals, value = override.partition("=")
    if key == FORMAT:
        return named_formats(override)
    if not equals or key.lstrip("+") not in SEED_KEYS or not _RANGE.search(value):
        return override
    items = [item for part in value.strip("[]").split(",") for item in _expand_item(key, part.strip())]
    return f"{key}={','.join(items)}"


def named_formats(override: str) -> str:
    """Put the default space of formats before numbers: `format=none,0-1` becomes `format=none,spread/0,spread/1`."""
    key, equals, value = override.partition("=")
    if not equals or key != FORMAT:
        return override
    items = [item for part in value.strip("[]").split(",") for item in _drawn_formats(part.strip())]
    return f"{key}={','.join(items)}"


def _drawn_formats(item: str) -> list[str]:
    space, slash, draws = item.rpartition("/")
    if not re.fullmatch(r"\d+(-\d+)?", draws):
        return [item]
    return [f"{space if slash else DEFAULT_SPACE}/{draw}" for draw in _expand_item(FORMAT, draws)]


def overridden(overrides: Iterable[str]) -> set[str]:
    """Return the keys that overrides set."""
    return {override.lstrip("+~").partition("=")[0] for override in overrides}


def has_range(override: str) -> bool:
    """Return whether an override such as `seed=0-9` or `seed=1,4` gives several seeds."""
    key, equals, value = override.partition("=")
    return bool(equals) and key.lstrip("+") in SEED_KEYS and ("," in value or bool(_RANGE.search(value)))


def _expand_item(key: str, item: str) -> list[str]:
    match = _RANGE.fullmatch(item)
    if match is None:
        return [item]
    first, last = int(match[1]), int(match[2])
    if last < first:
        raise InputError(f"{key}={item} begins with the larger number: write {key}={last}-{first}.")
    if last - first >= _MAX_RANGE:
        raise InputError(f"{key}={item} names more than {_MAX_RANGE:,} seeds: write a shorter range.")
    return [str(number) for number in range(first, last + 1)]


def expand(asked: Sequence[str], conditions: Iterable[Condition], there: Iterable[Run] = ()) -> Sweep:
    """Return the sweep of these conditions, with each run once and the runs of a model together.

    Args:
        asked: overrides of the user.
        conditions: conditions in the order of the grid.
        there: recorded runs of these conditions, which keep their ids.
    """
    points = tuple(conditions)
    check_names(points)
    known = {(run.condition, run.seed): run for run in there}
    runs: dict[str, Run] = {}
    for index in _by_model(points):
        digest = _digest(identity(points[index].config))
        for seed in points[index].seeds:
            run = known.get((index, seed)) or Run(_run_id(points[index].config, digest, seed), index, seed)
            runs.setdefault(run.id, run)
    return Sweep(asked=tuple(asked), conditions=points, runs=tuple(runs.values()))


def check_names(conditions: Iterable[Condition]) -> None:
    """Raise InputError for names of worlds, models or prompts that are too long or contain control characters."""
    named = {
        (role, str(condition.config[role]["name"])) for condition in conditions for role in ("world", "model", "prompt")
    }
    for role, name in sorted(named):
        if len(name) > LONGEST_NAME or visible(name) != name or "\n" in name or "\t" in name:
            shown = name if len(name) <= LONGEST_SHOWN else name[:LONGEST_SHOWN] + "..."
            raise InputError(
                f"{role}.name={shown!r} is not a valid name: use at most {LONGEST_NAME} characters without control "
                "characters."
            )


def calls_seed(config: Mapping[str, Any]) -> int:
    """Return the seed from which sampling seeds of a run's calls are derived: `sampling_seed`, else `seed`."""
    sampling = config["sampling_seed"]
    return int(config["seed"] if sampling is None else sampling)


LATER = frozenset({"logprobs"})
"""Settings of models that later versions added; run ids ignore them while they are null, so old ids stay valid."""


def identity(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings that define a run, from which its id is computed."""
    settings = {key: config[key] for key in IDENTITY_KEYS if key in config}
    if isinstance(settings.get("model"), Mapping):
        settings["model"] = without_servers(settings["model"])
    if "fork" in settings:
        settings["fork"] = {key: value for key, value in settings["fork"].items() if key != "sweep"}
    return {key: with_first_names(value) for key, value in settings.items()}


def without_servers(part: Mapping[str, Any]) -> dict[str, Any]:
    """Return a model's configuration without `server`, also in its members."""
    return _changed(part, lambda settings: {key: value for key, value in settings.items() if _decides(key, value)})


def _decides(key: str, value: Any) -> bool:
    return key != "server" and not (key in LATER and value is None)


def models_in(model: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the configurations of a model and of all its members."""
    models: list[Mapping[str, Any]] = []

    def noted(part_of: Mapping[str, Any]) -> dict[str, Any]:
        models.append(part_of)
        return dict(part_of)

    _changed(model, noted)
    return models


def is_served(model: Mapping[str, Any]) -> bool:
    """Return whether a server answers for a model or for one of its members."""
    return any("server" in config for config in models_in(model))


def _changed(model: Mapping[str, Any], change: Callable[[Mapping[str, Any]], dict[str, Any]]) -> dict[str, Any]:
    """Apply a change to a model's configuration, and to the configuration of each member (a part with a `_target_`)."""
    return change({key: _changed_within(value, change) for key, value in model.items()})


def _changed_within(value: Any, change: Callable[[Mapping[str, Any]], dict[str, Any]]) -> Any:
    if isinstance(value, Mapping):
        inner = {key: _changed_within(part, change) for key, part in value.items()}
        return change(inner) if "_target_" in inner else inner
    return [_changed_within(part, change) for part in value] if isinstance(value, list | tuple) else value


def settings_key(part: Mapping[str, Any]) -> str:
    """Return a text that is the same for equal configurations."""
    return json.dumps(part, sort_keys=True, default=str)


def loaded_key(model: Mapping[str, Any]) -> str:
    """Return a text that is the same for models that differ only in their schemas, which a server loads only once."""
    return settings_key(_changed(model, _without_schemas))


def sent_key(model: Mapping[str, Any]) -> str:
    """Return a text that is the same for models that send equal calls; `schemas` only counts if `format` is set."""
    return settings_key(
        _changed(model, lambda settings: dict(settings) if settings.get("format") else _without_schemas(settings))
    )


def _without_schemas(model: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in model.items() if key != "schemas"}


def dotted(part: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield each setting by its dotted key, such as `world.agents`; a list or an empty mapping is one value."""
    for name, value in part.items():
        if isinstance(value, Mapping) and value:
            yield from dotted(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the path of each setting and of each item of a list, with the value as JSON."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from leaves(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, Sequence) and not isinstance(value, str) and value:
        for index, inner in enumerate(value):
            yield from leaves(inner, f"{path}[{index}]")
    else:
        yield path, json.dumps(value, ensure_ascii=False)


def with_hosts(sweep: Sweep, hosts: str, key: str = "hosts") -> Sweep:
    """Return the sweep with other server addresses for its models; the run ids do not change."""

    def moved(model: Mapping[str, Any]) -> dict[str, Any]:
        server = model.get("server")
        if not isinstance(server, Mapping) or key not in server:
            return dict(model)
        return {**model, "server": {**server, key: hosts}}

    configs = (
        {**condition.config, "model": _changed(condition.config["model"], moved)} for condition in sweep.conditions
    )
    pairs = zip(sweep.conditions, configs, strict=True)
    return replace(sweep, conditions=tuple(replace(condition, config=config) for condition, config in pairs))


def _by_model(conditions: Sequence[Condition]) -> list[int]:
    """Return the indices of the conditions, sorted by model; models that differ only in schemas are neighbours."""
    first: dict[str, int] = {}
    models = [condition.config["model"] for condition in conditions]
    keys = [(loaded_key(model), settings_key(model)) for model in models]
    for index, key in enumerate(keys):
        for part in key:
            first.setdefault(part, index)
    return sorted(range(len(keys)), key=lambda index: [first[part] for part in keys[index]])


def _digest(value: Any) -> bytes:
    text = json.dumps(value, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).digest()


def _run_id(config: Mapping[str, Any], condition_digest: bytes, seed: int) -> str:
    digest = hashlib.sha256(condition_digest + str(seed).encode()).digest()[:8]
    short = base64.b32encode(digest).decode().rstrip("=").lower()[:12]
    return f"{slug(str(config['model']['name']))}-s{seed}-{short}"


def slug(name: str) -> str:
    """Return a short name of lower-case letters, digits and hyphens, which any file system accepts."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[-24:].strip("-") or "model"
