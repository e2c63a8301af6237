"""Plays episodes of shipped worlds in the test's own process and keeps what they record."""

import asyncio
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import msgspec

from foundry.composing.compose import Composed, compose
from foundry.composing.preflight import declare, prompt_of, scenario_of
from foundry.episode import Asker, play
from foundry.expansion import expand
from foundry.records import Call, CameraEpisode, CameraStep, Record, SeenImage
from foundry.running.build import build
from foundry.storing.run_writer import RunWriter, write_run_summary
from foundry.storing.store import SweepFolder
from made_up_runs import summary


@dataclass
class PlayedEpisode:
    records: list[Record] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    frames: dict[int, bytes] = field(default_factory=dict)

    def append(self, records: Sequence[Record]) -> None:
        self.records += records

    def append_calls(self, calls: Sequence[Call]) -> None:
        self.calls += calls

    def frame(self, step: int, png: bytes) -> None:
        assert step not in self.frames, "a step is drawn once, however many rounds of questions it has"
        self.frames[step] = png

    @property
    def steps(self) -> list[CameraStep]:
        return [record for record in self.records if isinstance(record, CameraStep)]

    @property
    def images(self) -> list[SeenImage]:
        return [record for record in self.records if isinstance(record, SeenImage)]

    @property
    def opening(self) -> CameraEpisode:
        return next(record for record in self.records if isinstance(record, CameraEpisode))

    def lines(self) -> list[bytes]:
        return [msgspec.json.encode(record) for record in self.records if not isinstance(record, SeenImage)]


ROOM = Path(__file__).parents[1] / "data" / "room.usda"
"""Two walls and a floor of 4 m, in which 3D worlds are tried that need no shipped scene."""
SCENES = frozenset(("kibo", "kibo_paper", "office", "gallery"))
SMALL_PICTURES = ("world.camera.width=128", "world.camera.height=96")


def composed(world: str, policy: str, *overrides: str) -> Composed:
    """Return the composed configuration of a shipped world and a scripted policy, the test's own to change."""
    composed = _composed(world, policy, (*(SMALL_PICTURES if world in SCENES else ()), *overrides))
    return replace(composed, conditions=deepcopy(composed.conditions))


@cache
def _composed(world: str, policy: str, overrides: tuple[str, ...]) -> Composed:
    found = compose([f"world={world}", f"model=scripted/{policy}", *overrides])
    assert found is not None
    return found


async def play_through(composed: Composed, seed: int, episode: PlayedEpisode, *, frame_every: int = 0) -> None:
    config = composed.conditions[0].config
    asker = Asker.create(build(config["model"]), prompt_of(config), digest=None, seed=seed)
    await play(scenario_of(config).start(seed), asker, episode, frame_every=frame_every)


def episode(world: str, policy: str, *, seed: int, steps: int | None = None) -> PlayedEpisode:
    recording = PlayedEpisode()
    overrides = [] if steps is None else [f"world.steps={steps}"]
    asyncio.run(play_through(composed(world, policy, *overrides), seed, recording))
    return recording


async def recorded(path: Path, compositions: Sequence[Composed]) -> SweepFolder:
    sweep = SweepFolder.create(path, declare(expand([], [composed.conditions[0] for composed in compositions])), {}, [])
    for run, composed in zip(sweep.runs(), compositions, strict=True):
        writer = RunWriter(run, msgspec.json.encode(run.config()).decode())
        recording = PlayedEpisode()
        await play_through(composed, run.config()["seed"], recording)
        writer.append(recording.records)
        writer.append_calls(recording.calls)
        writer.close()
        write_run_summary(run, summary(run, writer.counts, None))
    return sweep
