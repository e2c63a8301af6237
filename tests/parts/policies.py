"""Scripted models that misbehave, for tests; configured through `_target_` like anybody's own parts."""

import io
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from PIL import Image

from foundry.models.base import Reply, Request, ScriptedModel
from foundry.worlds.any.any_policies import Stay
from foundry.worlds.grid.grid_policies import act
from foundry.worlds.rounds.reading import deciding

DOOMED = ("world=fate", "prompt=terse", "model=own", "++world.personas={fate: {doomed: 1, blessed: 3}}")
"""The overrides for a policy of `write_fate`, one agent of which may be doomed by its persona."""


def write_fate(folder: Path, policy: str) -> None:
    """Write a world of one agent, its prompt and a policy of this module into the folder `mine`."""
    for part, text in {
        "prompt/terse": "_target_: foundry.prompts.prompt.Prompt\nname: terse\n"
        "templates: {message: 'Say?', action: 'Act?'}\n",
        "world/fate": "defaults: [cafe_library, _self_]\nname: fate\nagents: 1\nsteps: 2\n",
        "model/own": f"_target_: policies.{policy}\nname: own\n",
    }.items():
        file = folder / "mine" / f"{part}.yaml"
        file.parent.mkdir(parents=True)
        file.write_text(text)


def is_doomed(request: Request) -> bool:
    return request.kind == "action" and request.observation["persona"]["fate"] == "doomed"


class Deadly(Stay):
    """Kills its own process when the persona of an agent is `doomed`."""

    def reply(self, request: Request) -> Reply:
        if is_doomed(request):
            os._exit(9)
        return super().reply(request)


class Faulty(Stay):
    """Has a bug that shows when the persona of an agent is `doomed`."""

    def reply(self, request: Request) -> Reply:
        if is_doomed(request):
            raise ZeroDivisionError("a bug")
        return super().reply(request)


class Left(Stay):
    def reply(self, request: Request) -> Reply:
        return Reply(text=act("left", reasoning="As ever.")) if request.kind == "action" else super().reply(request)


class Bracketed(Stay):
    """Goes left where the headings of its prompt stand in brackets, right where its lists have stars, else it stays."""

    def reply(self, request: Request) -> Reply:
        if request.kind != "action":
            return super().reply(request)
        text = request.messages[0].content
        return Reply(text=act("left" if "\n[" in text else "right" if "\n* " in text else "stay", reasoning="So."))


class Forward(Stay):
    def move(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return "Move forward 1 m."


class Brighter(Stay):
    """Turns to the brighter half of what it sees in 3D; goes forward where both are alike."""

    def reply(self, request: Request) -> Reply:
        with Image.open(io.BytesIO(request.messages[-1].images[-1])) as image:
            light = np.asarray(image.convert("L"), np.int64)
        half = light.shape[1] // 2
        left, right = light[:, :half].sum(), light[:, -half:].sum()
        return Reply(
            text=f"Turn {'left' if left > right else 'right'} 30 degrees." if left != right else "Move forward."
        )


class Dread(Stay):
    """Goes left where the first fire is at most 4 cells away, by the words of its prompt; else it stays."""

    def reply(self, request: Request) -> Reply:
        if request.kind != "action":
            return super().reply(request)
        told = re.search(r"Your distance: ([\d.]+)", request.messages[0].content)
        return Reply(text=act("left" if told and float(told[1]) <= 4.5 else "stay", reasoning="It is near."))


class Follower(ScriptedModel):
    """Goes to the bar where the last evening that it is told of was not crowded, or it is told of none."""

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        past = observation["evenings"]
        return deciding("go" if not past or past[-1]["went"] <= observation["places"] else "stay")
