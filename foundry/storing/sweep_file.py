"""The content of `sweep.yaml`: a sweep as asked and as expanded."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import yaml

from foundry.expansion import Asked, Condition, Run, Sweep, check_names
from foundry.storing.declaration import recorded_declaration
from foundry.storing.plain import load_plain
from foundry.storing.sweep_shape import check_shape

_ENCODE = msgspec.json.Encoder().encode
_RUNS = "\nruns:\n"
_RUN_ID = re.compile(r"[a-z0-9][a-z0-9-]{0,99}")
_RUN_LINES = re.compile(r'(?:- \{"id":"[\w-]+","condition":\d+,"seed":\d+\}\n)*')
_SEEDS = re.compile(r"(?<=\n  seeds:)(?:\n  - (?:0|[1-9]\d{0,17}))+(?=\n(?!  - ))")
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def to_yaml(value: Any) -> str:
    """Return the value as block-style YAML, keys in their order, non-ASCII text as it is."""
    return str(yaml.dump(value, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110))


def sweep_text(sweep: Sweep, settings: Mapping[str, Any], models: Sequence[Mapping[str, Any]], plan: str | None) -> str:
    """Return the content of `sweep.yaml`; `plan` is the SHA-256 of what was declared before it began."""
    head = {
        "asked": list(sweep.asked),
        "history": [{"asked": list(one.overrides), "when": one.when, "runs": one.runs} for one in sweep.history],
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
    # One JSON object a line is YAML too, and many times faster to write than nested blocks.
    text.write("runs:\n")
    for run in sweep.runs:
        line = {"id": run.id, "condition": run.condition, "seed": run.seed}
        text.write(f"- {_ENCODE(line).decode()}\n")
    return text.getvalue()


def sweep_content(text: str, where: object) -> Any:
    """Return what `sweep.yaml` holds; its runs and seeds, which may be very many, are read without the help of YAML.

    Args:
        text: the content of the file.
        where: what an error calls it.

    Raises:
        RecordError: it is no YAML of plain values, or too much of it.
    """
    head, found, runs = text.rpartition(_RUNS)
    if not found or not _RUN_LINES.fullmatch(runs):
        return load_plain(text, where)
    lines = runs.replace("- {", "{")
    return _head_content(head + "\n", where) | {"runs": msgspec.json.Decoder(dict[str, Any]).decode_lines(lines)}


def _head_content(head: str, where: object) -> Any:
    """Return what is above the runs; the seeds, a line each, are read as the numbers that they are."""
    seeds = [list(map(int, block.split("\n  - ")[1:])) for block in _SEEDS.findall(head)]
    content = load_plain(_SEEDS.sub(" []", head), where)
    conditions = content.get("conditions") if isinstance(content, Mapping) else None
    if not isinstance(conditions, list) or [_seeds_of(one) for one in conditions] != [[]] * len(seeds):
        return load_plain(head, where)  # something else looked like seeds, or these are written otherwise
    for condition, found in zip(conditions, seeds, strict=True):
        condition["seeds"] = found
    return content


def _seeds_of(condition: Any) -> Any:
    return condition.get("seeds") if isinstance(condition, Mapping) else None


def sweep_from(content: Mapping[str, Any]) -> Sweep:
    """Return the sweep that `sweep.yaml` describes.

    Raises:
        InputError: a part has a name that no table can show.
        ValueError: a part has another shape, or a run has a name that is no run's, which might lead elsewhere, or no
            condition.
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
            raise ValueError(f"{run.id!r} is no id of a run")
        if run.condition not in range(len(conditions)):
            raise ValueError(f"run {run.id} has no condition")
    asked = tuple(content["asked"])
    history = tuple(Asked(tuple(one["asked"]), one["when"], one["runs"]) for one in content.get("history") or ())
    return Sweep(asked, conditions, runs, history or (Asked(asked, None, len(runs)),))
