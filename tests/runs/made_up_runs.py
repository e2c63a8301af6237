"""Writes sweeps of 2D runs whose every record is known, as a run would write them, without any world or model."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from declared_forms import GRID
from foundry.declared import Declared
from foundry.expansion import Condition, expand
from foundry.records import Agent, Call, Counts, GridStep, Message, Outcome, RunSummary
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder

AGENTS, STEPS = 4, 6
GENDERS = ("female", "male")
HOSTILE = (
    '<script>window.hacked = 1</script><img src=x onerror="window.hacked = 1"> </script> javascript:alert(1) '
    "\u202egnirts desrever \u0627\u0644\u0633\u0644\u0627\u0645 \U0001f525\U0001f469\u200d\U0001f692 nul:\x00: "
    f"{'w' * 3000}"
)
"""What a model might write: markup, handlers, turned and right-to-left text, emoji, a null byte, an endless word."""


def world(**changes: Any) -> dict[str, Any]:
    return {
        "name": "made_up", "half_size": 5, "agents": AGENTS, "steps": STEPS, "communication_distance": 3,
        "places": [{"name": "cafe", "type": "cafe", "center": [-3, 0], "extent": [1, 1], "capacity": 1}],
        "fires": [{"name": "fire1", "start": 5, "position": [3, 3], "intensity": 0.8, "radius": 2}],
        "personas": {"gender": {"female": 0.5, "male": 0.5}},
    } | changes  # fmt: skip


def sweep(
    path: Path, *, models: Sequence[str] = ("first", "second"), seeds: Sequence[int] = (0, 1), **changes: Any
) -> SweepFolder:
    return sweep_in(path, world(**changes), GRID, models, seeds)


def sweep_in(
    path: Path,
    world: Mapping[str, Any],
    declared: Declared,
    models: Sequence[str],
    seeds: Sequence[int],
    prompt: str = "paper",
) -> SweepFolder:
    configs = [
        {"world": world, "model": {"name": model}, "prompt": {"name": prompt}, "sampling_seed": None}
        for model in models
    ]
    conditions = [Condition({"model": config["model"]["name"]}, config, tuple(seeds), declared) for config in configs]
    return SweepFolder.create(path, expand(["-m", f"model={','.join(models)}"], conditions), {}, [])


def step(number: int, agent: int, **changes: Any) -> GridStep:
    """Agents stand in a row and walk to the right; agent 1 speaks to agent 2 at every second step."""
    speaks = agent == 1 and number % 2 == 0
    fields: dict[str, Any] = {
        "step": number, "agent": agent, "x": number - 5, "y": agent, "x_next": number - 4, "y_next": agent,
        "place": "cafe" if number < 4 and agent < 2 else None, "fires": (),
        "neighbours": {1: (2,), 2: (1,)}.get(agent, ()),
        "message": f"hello from step {number}" if speaks else None, "action": "move", "direction": "right",
        "moved": True,
        "memory": f"I was at {number}", "reasoning": "because", "message_reasoning": "", "outcome": Outcome.CHOSEN,
        "message_outcome": Outcome.CHOSEN,
    }  # fmt: skip
    return GridStep(**(fields | changes))


def call(record: GridStep, kind: str, text: str, more: str) -> Call:
    persona = GENDERS[record.agent % 2]
    prompt = f"You are Agent {record.agent} ({persona}) at step {record.step}. Agent 9 (male) is near. {kind}?{more}"
    return answered(record.step, record.agent, kind, prompt, text)


def answered(step: int, agent: int, kind: str, prompt: str, text: str) -> Call:
    return Call(
        step=step, agent=agent, kind=kind, model="first", digest=None, key="k", seed=7,
        messages=[{"role": "user", "content": prompt}], parameters={"temperature": 0}, text=text, thinking=None,
        ending="stop", prompt_tokens=10, output_tokens=5, timings={"total": 0.5}, attempts=(), host=None, cached=False,
    )  # fmt: skip


Change = Callable[[int, int], dict[str, Any]]


@dataclass
class Playing:
    folder: RunFolder
    change: Change = lambda number, agent: {}
    reply: str = '{"action": "move"}'
    more: str = ""
    """What each prompt ends with."""

    def __post_init__(self) -> None:
        self.writer = RunWriter(self.folder, msgspec.json.encode(self.folder.config()).decode())  # JSON is YAML too

    def play(self, first: int, last: int) -> None:
        agents = self.folder.config()["world"]["agents"]
        if first == 1:
            self.writer.append([Agent(agent=agent, persona={"gender": GENDERS[agent % 2]}) for agent in range(agents)])
        for number in range(first, last + 1):
            records = [step(number, agent, **self.change(number, agent)) for agent in range(agents)]
            for kind in ("message", "action"):
                self.writer.append_calls([call(record, kind, f"{kind}: {self.reply}", self.more) for record in records])
            heard = [(record, other) for record in records if record.message is not None for other in record.neighbours]
            self.writer.append(
                [
                    Message(step=number, sender=step_record.agent, recipient=other, text=str(step_record.message))
                    for step_record, other in heard
                ]
            )
            self.writer.append(records)

    def end(self, error: str | None = None) -> None:
        self.writer.close()
        write_run_summary(self.folder, summary(self.folder, self.writer.counts, error))


def summary(folder: RunFolder, counts: Counts, error: str | None, **changes: Any) -> RunSummary:
    config = folder.config()
    ended = RunSummary(
        run=folder.id, status="failed" if error else "complete", world=config["world"]["name"],
        model=config["model"]["name"], prompt=config["prompt"]["name"], seed=config["seed"],
        sampling_seed=config["sampling_seed"], foundry_version="0", python_version="3", packages={}, git_commit=None,
        model_digest=None, server_version=None, counts=counts, started="", ended="", duration_s=1.0, error=error,
        error_type="BackendError" if error else None, traceback=None, records_sha256={},
    )  # fmt: skip
    return msgspec.structs.replace(ended, **changes)


COUNTS = Counts(calls=12, cached=3, retries=2, prompt_tokens=4000, output_tokens=700, model_s=3.5)


def write_records(folder: RunFolder, status: str, **streams: Sequence[Any]) -> None:
    """Write a run's files; status `unfinished` leaves `run.json` away."""
    folder.path.mkdir(parents=True)
    digests = {}
    for name, records in streams.items():
        content = b"".join(msgspec.json.encode(record) + b"\n" for record in records)
        folder.stream_path(name).write_bytes(content)
        digests[f"{name}.jsonl"] = hashlib.sha256(content).hexdigest()
    if status != "unfinished":
        error = None if status == "complete" else "the server went away"
        times = {"started": "2026-01-01T00:00:00Z", "ended": "2026-01-01T00:00:01Z"}
        write_run_summary(folder, summary(folder, COUNTS, error, status=status, records_sha256=digests, **times))


def whole_run(
    folder: RunFolder, change: Change = lambda number, agent: {}, reply: str = '{"action": "move"}', more: str = ""
) -> None:
    playing = Playing(folder, change, reply, more)
    playing.play(1, folder.config()["world"]["steps"])
    playing.end()


def mishaps(number: int, agent: int) -> dict[str, Any]:
    """Agent 2 is repaired at step 3, agent 0 cannot be read at step 4 and stays."""
    if (number, agent) == (3, 2):
        return {"outcome": Outcome.REPAIRED}
    if (number, agent) == (4, 0):
        stay = {"action": "stay", "direction": None, "moved": False}
        return {"outcome": Outcome.UNREADABLE, "memory": "", "reasoning": "", **stay}
    return {}


def otherwise(number: int, agent: int) -> dict[str, Any]:
    """From step 3 on, agent 3 goes up; at step 4, agent 1 says something else."""
    if agent == 3 and number >= 3:
        return {"direction": "up"}
    return {"message": "something else"} if (number, agent) == (4, 1) else {}


def whole_sweep(path: Path) -> SweepFolder:
    """Write two models and two seeds: whole runs with mishaps, another way, a failure, and one that never began."""
    made = sweep(path)
    first, second, third, _ = made.runs()
    whole_run(first, mishaps)
    whole_run(second, reply=HOSTILE, change=lambda number, agent: {"message": HOSTILE} if agent == 1 else {})
    whole_run(third, otherwise)
    return made
