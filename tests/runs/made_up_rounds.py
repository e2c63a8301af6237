"""Writes sweeps of runs without any space whose every record is known; their world can be built, to draw them again."""

import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import msgspec
from PIL import Image, ImageDraw

from foundry.declared import Actions
from foundry.records import Agent, Call, Message, Outcome, Record, RoundStep
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import RunFolder, SweepFolder
from foundry.worlds.base import Question, Recorded, Redrawing, Scenario, World
from made_up_runs import GENDERS, answered, summary, sweep_in

AGENTS, STEPS = 5, 12
TALK, GO, PAY = "talk", "go", "pay"
TARGET = "made_up_rounds.Bar"


class BarStep(RoundStep, frozen=True, kw_only=True):
    crowd: int
    reasoning: str = ""
    seats: tuple[int, ...] = ()


class Evening(Record, frozen=True, kw_only=True):
    stream: ClassVar[str] = "evenings"

    step: int
    crowd: int
    weather: str


class House(Record, frozen=True, kw_only=True):
    stream: ClassVar[str] = "house"

    seats: int
    name: str


class Bar(Scenario):
    form = "rounds"
    kinds = (TALK, GO, PAY)
    records = (BarStep, Message, Agent, Evening, House)

    def __init__(self, *, name: str, agents: int, steps: int) -> None:
        self.name, self.agents, self.steps = name, agents, steps

    def actions(self) -> Mapping[str, Actions]:
        return {
            GO: Actions(labels=("stay at home", "go", "go late"), idle="stay at home"),
            PAY: Actions(low=0, high=10, whole=False),
        }

    def start(self, seed: int) -> World:
        raise NotImplementedError("its records are made up")

    def redraw(self, recorded: Recorded) -> Redrawing:
        return BarPictures(msgspec.json.Decoder(BarStep).decode_lines(recorded.steps), self.agents)

    def wordy_answer(self, question: Question, characters: int) -> str:
        raise NotImplementedError("nobody asks")

    def count_calls(self) -> int:
        return 3 * self.agents * self.steps


class BarPictures(Redrawing):
    def __init__(self, steps: Sequence[BarStep], agents: int) -> None:
        self.done = {(step.step, step.agent): step.action for step in steps if step.kind == GO}
        self.agents = agents

    def draw(self, step: int) -> bytes:
        picture = Image.new("RGB", (60 * self.agents, 120), "white")
        pen = ImageDraw.Draw(picture)
        for agent in range(self.agents):
            colour = {"go": "#e69f00", "go late": "#009e73"}.get(str(self.done.get((step, agent))), "#888888")
            pen.rectangle((60 * agent + 8, 30, 60 * agent + 52, 110), fill=colour)
        pen.text((8, 8), f"after step {step}", fill="black")
        content = io.BytesIO()
        picture.save(content, "PNG")
        return content.getvalue()


def sweep(
    path: Path,
    *,
    models: Sequence[str] = ("first", "second"),
    seeds: Sequence[int] = (0,),
    world: Mapping[str, Any] | None = None,
    scenario: Scenario | None = None,
    agents: int = AGENTS,
    steps: int = STEPS,
) -> SweepFolder:
    settings = {"_target_": TARGET, "name": "bar", "agents": agents, "steps": steps} | dict(world or {})
    known = scenario or Bar(name="bar", agents=agents, steps=steps)
    return sweep_in(path, settings, known.declared(), models, seeds, "bar")


Change = Callable[[int, int, str], dict[str, Any]]


def same(step: int, agent: int, kind: str) -> dict[str, Any]:
    return {}


def otherwise(step: int, agent: int, kind: str) -> dict[str, Any]:
    """From step 4 on agent 2 goes late; at step 6 agent 1 says something else."""
    if (agent, kind) == (2, GO) and step >= 4:
        return {"action": "go late"}
    return {"message": "something else"} if (step, agent, kind) == (6, 1, TALK) else {}


def line(step: int, agent: int, kind: str, **changes: Any) -> BarStep:
    """Agents go every second step in turn; agent 3 cannot be read at step 5; agent 1 speaks at even steps."""
    fields: dict[str, Any] = {"step": step, "agent": agent, "kind": kind, "outcome": Outcome.CHOSEN, "crowd": step % 4}
    if kind == TALK:
        says = agent == 1 and step % 2 == 0
        fields |= {"action": None, "message": f"hello from step {step}" if says else None}
    elif kind == GO:
        goes = (step + agent) % 2 == 0
        fields |= {"action": "go" if goes else "stay at home", "utility": 1.5 * goes - agent / 10 * (step % 3)}
        fields |= {"reasoning": "It was full last time, so that most others will stay at home now; I go, I think."}
    else:
        fields |= {"action": (step * 7 + agent * 3) % 101 / 10, "seats": (agent, step)}
    if (step, agent, kind) == (5, 3, GO):
        fields |= {"action": None, "outcome": Outcome.UNREADABLE, "utility": 0.0}
    if (step, agent, kind) == (7, 0, PAY):
        fields |= {"outcome": Outcome.REPAIRED}
    return BarStep(**(fields | changes))


def call(record: BarStep, reply: str) -> Call:
    prompt = f"You are guest {record.agent} on evening {record.step}. {record.kind}?"
    return answered(record.step, record.agent, record.kind, prompt, reply)


class Playing:
    def __init__(self, folder: RunFolder, change: Change = same, reply: str = '{"action": "go"}') -> None:
        self.folder, self.change, self.reply = folder, change, reply
        self.writer = RunWriter(folder, msgspec.json.encode(folder.config()).decode())

    def begin(self) -> None:
        agents = self.folder.config()["world"]["agents"]
        self.writer.append([Agent(agent=agent, persona={"gender": GENDERS[agent % 2]}) for agent in range(agents)])
        self.writer.append([House(seats=3, name="El <b>Farol</b>")])

    def play(self, first: int, last: int) -> None:
        agents = self.folder.config()["world"]["agents"]
        if first == 1:
            self.begin()
        for step in range(first, last + 1):
            for kind in (TALK, GO, PAY):
                lines = [line(step, agent, kind, **self.change(step, agent, kind)) for agent in range(agents)]
                self.writer.append_calls([call(line, f"{kind}: {self.reply}") for line in lines])
                heard = [line for line in lines if line.message is not None]
                self.writer.append(
                    [
                        Message(step=step, sender=bar_step.agent, recipient=0, text=str(bar_step.message))
                        for bar_step in heard
                    ]
                )
                self.writer.append(lines)
            self.writer.append([Evening(step=step, crowd=step % 4, weather="rain" if step % 3 else "sun")])

    def end(self, error: str | None = None) -> None:
        self.writer.close()
        digests = self.writer.digests()
        write_run_summary(self.folder, summary(self.folder, self.writer.counts, error, records_sha256=digests))


def whole_run(folder: RunFolder, change: Change = same, reply: str = '{"action": "go"}') -> None:
    playing = Playing(folder, change, reply)
    playing.play(1, folder.config()["world"]["steps"])
    playing.end()


class Undrawn(Bar):
    redraw = Scenario.redraw


class Spoilt(Bar):
    def redraw(self, recorded: Recorded) -> Redrawing:
        return {}["seat"]
