"""Writes and reads `sweep.yaml`, also of version 0.1, with the user's overrides, the conditions and the runs."""

import copy
import datetime
import io
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, TypeAlias

import msgspec
import yaml

from foundry.declared import Actions, Declared, keys_of
from foundry.expansion import Condition, Run, Sweep, SweepCommand, check_names, models_in
from foundry.naming import present
from foundry.records import COMMAND_KINDS, Agent, CameraEpisode, CameraStep, GridStep, Message, SeenImage
from foundry.storing.plain import load_plain

UNSAID = "any"
"""The form of records without a declaration; foundry only reads the keys that all steps have."""
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_OLD_FORMS = {
    "foundry.worlds.grid.grid_world.GridScenario": Declared(
        form="grid",
        actions={"action": Actions(labels=("stay", "up", "down", "left", "right"), idle="stay")},
        streams=keys_of((GridStep, Message, Agent)),
    ),
    "foundry.worlds.camera.camera_world.CameraScenario": Declared(
        form="camera",
        actions={"move": Actions(labels=COMMAND_KINDS, idle=COMMAND_KINDS[0])},
        streams=keys_of((CameraStep, CameraEpisode, SeenImage)),
    ),
}
Number: TypeAlias = Annotated[int, msgspec.Meta(ge=0)]
_INTEGERS = range(-(2**63), 2**64)
"""The integers that JSON records can contain."""
_ENCODE = msgspec.json.Encoder().encode
_RUNS = "\nruns:\n"
_RUN_ID = re.compile(r"[a-z0-9][a-z0-9-]{0,99}")
_RUN_LINES = re.compile(r'(?:- \{"id":"[\w-]+","condition":\d+,"seed":\d+\}\n)*')
_SEEDS = re.compile(r"(?<=\n  seeds:)(?:\n  - (?:0|[1-9]\d{0,17}))+(?=\n(?!  - ))")
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def declared_before(config: Mapping[str, Any]) -> Declared:
    """Return the declaration of records for a configuration of version 0.1, which names only the class of its world."""
    return _OLD_FORMS.get(present(config["world"].get("_target_")), Declared(form=UNSAID))


def recorded_declaration(condition: Mapping[str, Any]) -> Declared | None:
    """Return the declaration of records in a condition of `sweep.yaml`; None for version 0.1, which wrote none.

    Raises:
        ValueError: the declaration is malformed, or its form differs from the form of the world's class.
    """
    if "declared" not in condition:
        return None
    try:
        declared = msgspec.convert(condition["declared"], Declared)
    except msgspec.ValidationError as error:
        raise ValueError(f"declared: {error}") from error
    for name in (declared.form, *declared.streams):
        if not _NAME.fullmatch(name) or name == "calls":
            raise ValueError(f"declared: {name!r} is not a valid name of a form or a record file")
    shipped = declared_before(condition["config"]).form
    if shipped not in (UNSAID, declared.form):
        target = condition["config"]["world"]["_target_"]
        raise ValueError(
            f"declared: the form is {declared.form!r}, but the records of {target} have the form {shipped!r}"
        )
    return declared


class _Named(msgspec.Struct):
    name: str
    target: str | None = msgspec.field(default=None, name="_target_")


class _Record(msgspec.Struct):
    frames: bool | Number = False


class _Past(msgspec.Struct):
    before: Number | None
    prompt: _Named
    seed: Number


class _Fork(msgspec.Struct):
    sweep: str
    run: str
    at: Number
    records_sha256: dict[str, str]
    past: list[_Past]


class _Config(msgspec.Struct):
    world: _Named
    model: _Named
    prompt: _Named
    sampling_seed: Number | None
    record: _Record | msgspec.UnsetType = msgspec.UNSET
    fork: _Fork | msgspec.UnsetType = msgspec.UNSET
    baselines: list[str] | msgspec.UnsetType = msgspec.UNSET


class _Condition(msgspec.Struct):
    factors: dict[str, Any]
    seeds: list[Number]
    config: _Config
    declared: Declared | msgspec.UnsetType = msgspec.UNSET


class _Run(msgspec.Struct):
    id: str
    condition: int
    seed: Number


class _Cache(msgspec.Struct):
    path: str | None


class _Settings(msgspec.Struct):
    cache: _Cache | msgspec.UnsetType = msgspec.UNSET
    runner: dict[str, Any] | msgspec.UnsetType = msgspec.UNSET
    record: _Record | msgspec.UnsetType = msgspec.UNSET


class _Model(msgspec.Struct):
    name: str
    digest: str | None
    server_version: str | None = None
    weights: str | None = None
    remote: str | None = None


class _Asked(msgspec.Struct):
    asked: list[str]
    when: str | None
    runs: Number


class _Content(msgspec.Struct):
    asked: list[str]
    models: list[_Model]
    settings: _Settings
    conditions: list[_Condition]
    runs: list[_Run]
    history: list[_Asked] | msgspec.UnsetType = msgspec.UNSET
    plan: str | msgspec.UnsetType = msgspec.UNSET


class _Server(msgspec.Struct):
    workers: Annotated[int, msgspec.Meta(ge=1)] | None = None
    base_url: str | list[str] | None = None
    hosts: str | list[str] | None = None
    api_key_env: str | None = None


class _Part(msgspec.Struct):
    name: str = ""
    server: _Server | None = None


def check_shape(content: Any) -> None:
    """Check that the content of `sweep.yaml` has the expected keys and types.

    Raises:
        ValueError: it has not, or it contains a value that no record can contain.
    """
    try:
        msgspec.convert(content, _Content)
        # Only the largest seed is checked: seeds are non-negative integers, and there may be very many.
        few = [{**condition, "seeds": [max(condition["seeds"], default=0)]} for condition in content["conditions"]]
        _check_plain([content["settings"], *few], set())
        for condition in content["conditions"]:
            for model in models_in(condition["config"]["model"]):
                msgspec.convert(model, _Part)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def _check_plain(value: Any, seen: set[int]) -> None:
    """Raise an error if JSON cannot represent a value. A value that several YAML aliases repeat is checked once."""
    if isinstance(value, dict | list):
        if id(value) in seen:
            return
        seen.add(id(value))
        inner = value if isinstance(value, list) else [*_names(value), *value.values()]
        for part in inner:
            _check_plain(part, seen)
    elif isinstance(value, bytes | set | datetime.date) or (isinstance(value, int) and value not in _INTEGERS):
        raise ValueError(f"{str(value)[:40]} is not a valid value of a setting")


def _names(value: dict[Any, Any]) -> list[str]:
    odd = [key for key in value if not isinstance(key, str)]
    if odd:
        raise ValueError(f"{odd[0]!r} is not a valid name of a setting")
    return list(value)


def to_yaml(value: Any) -> str:
    """Return a value as YAML in block style; the order of keys and non-ASCII characters are kept."""
    return str(yaml.dump(value, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110))


def sweep_text(sweep: Sweep, settings: Mapping[str, Any], models: Sequence[Mapping[str, Any]], plan: str | None) -> str:
    """Return the content of `sweep.yaml`; `plan` is the SHA-256 of the plan that was declared before the sweep."""
    head = {
        "asked": list(sweep.asked),
        "history": [
            {"asked": list(asked.overrides), "when": asked.when, "runs": asked.runs} for asked in sweep.history
        ],
        "definition": sweep.definition,
        **({} if plan is None else {"plan": plan}),
        "models": [dict(model) for model in models],
        "settings": dict(settings),
        "conditions": [
            {
                "factors": dict(condition.factors),
                "seeds": list(condition.seeds),
                "config": dict(condition.config),
                **({} if condition.declared is None else {"declared": msgspec.to_builtins(condition.declared)}),
            }
            for condition in sweep.conditions
        ],
    }
    text = io.StringIO()
    text.write(to_yaml(head))
    # JSON objects, one on each line, are also valid YAML, and foundry writes them many times faster than YAML blocks.
    text.write("runs:\n")
    for run in sweep.runs:
        line = {"id": run.id, "condition": run.condition, "seed": run.seed}
        text.write(f"- {_ENCODE(line).decode()}\n")
    return text.getvalue()


def sweep_content(text: str, where: object) -> Any:
    """Parse the text of `sweep.yaml`; errors begin with its name, `where`.

    Runs and seeds are read without a YAML parser, since there may be very many.
    """
    head, body, runs = text.rpartition(_RUNS)
    if not body or not _RUN_LINES.fullmatch(runs):
        return load_plain(text, where)
    lines = runs.replace("- {", "{")
    content = copy.deepcopy(_head_content(head + "\n", where))
    return content | {"runs": msgspec.json.Decoder(dict[str, Any]).decode_lines(lines)}


@lru_cache(maxsize=4)
def _head_content(head: str, where: object) -> Any:
    """Parse the part of `sweep.yaml` before the runs, but its lists of seeds without a YAML parser, which is slow."""
    seeds = [list(map(int, block.split("\n  - ")[1:])) for block in _SEEDS.findall(head)]
    content = load_plain(_SEEDS.sub(" []", head), where)
    conditions = content.get("conditions") if isinstance(content, Mapping) else None
    if not isinstance(conditions, list) or [_seeds_of(condition) for condition in conditions] != [[]] * len(seeds):
        return load_plain(head, where)  # another part looks like seeds, or the seeds have another layout
    for condition, own_seeds in zip(conditions, seeds, strict=True):
        condition["seeds"] = own_seeds
    return content


def _seeds_of(condition: Any) -> Any:
    return condition.get("seeds") if isinstance(condition, Mapping) else None


def sweep_from(content: Mapping[str, Any]) -> Sweep:
    """Return the sweep that the content of `sweep.yaml` describes.

    Raises:
        InputError: a world, model or prompt has a name that tables cannot show.
        ValueError: the content is malformed, or a run has no condition or an id that is not the name of a folder.
    """
    check_shape(content)
    conditions = tuple(
        Condition(entry["factors"], entry["config"], tuple(entry["seeds"]), recorded_declaration(entry))
        for entry in content["conditions"]
    )
    runs = tuple(Run(entry["id"], entry["condition"], entry["seed"]) for entry in content["runs"])
    check_names(conditions)
    if not runs:
        raise ValueError("it has no runs")
    for run in runs:
        if not _RUN_ID.fullmatch(run.id):
            raise ValueError(f"{run.id!r} is not a valid id of a run")
        if run.condition not in range(len(conditions)):
            raise ValueError(f"run {run.id} has no condition")
    overrides = tuple(content["asked"])
    history = tuple(
        SweepCommand(tuple(entry["asked"]), entry["when"], entry["runs"]) for entry in content.get("history") or ()
    )
    return Sweep(overrides, conditions, runs, history or (SweepCommand(overrides, None, len(runs)),))
