"""Writes runs of a world of no shipped form, line by line, without any world or model."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from foundry.declared import Actions, Declared
from foundry.expansion import Condition, expand
from foundry.records import Agent, Message
from foundry.storing.store import RunFolder, SweepFolder
from made_up_runs import write_records

STREAMS = {
    "steps": {
        "step": "integer", "agent": "integer", "kind": "text", "action": "other?", "outcome": "label",
        "utility": "number?", "message": "text?", "thoughts": "text", "mood": "label", "crowd": "integer",
        "wants in": "flag?",
    },
    "messages": {"step": "integer", "sender": "integer", "recipient": "integer", "text": "text"},
    "agents": {"agent": "integer", "persona": "other"},
}  # fmt: skip
BAR = Declared(
    form="ring",
    actions={"choice": Actions(labels=("go", "stay"), idle="stay"), "bid": Actions(low=0, high=10)},
    streams=STREAMS,
)


def line(step: int, agent: int, /, **changes: Any) -> dict[str, Any]:
    return {
        "step": step, "agent": agent, "kind": "choice", "action": "go", "outcome": "chosen", "utility": 1,
        "message": None, "thoughts": "hm", "mood": "calm", "crowd": 3, "wants in": None,
    } | changes  # fmt: skip


def any_folder(
    path: Path,
    lines: Sequence[Mapping[str, Any]],
    *,
    declared: Declared | None = BAR,
    messages: Sequence[Message] = (),
    personas: Sequence[Agent] = (),
    ended: bool = True,
) -> RunFolder:
    config = {"world": {"name": "bar", "_target_": "own.Bar"}, "model": {"name": "m"}, "prompt": {"name": "p"}}
    condition = Condition(factors={}, config={**config, "sampling_seed": None}, seeds=(0,), declared=declared)
    folder = SweepFolder.create(path, expand(["-m"], [condition]), {}, []).runs()[0]
    files = {"steps": lines, "messages": messages, **({"agents": personas} if personas else {})}
    write_records(folder, "complete" if ended else "unfinished", **files)
    return folder
