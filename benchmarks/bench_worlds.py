"""Agent decisions a second and core of every world that names its baselines, beside the 2D world in the same run."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import yaml
from measuring import at_least, print_table, print_title

from foundry import paths
from foundry.composing.compose import compose
from foundry.composing.preflight import scenario_of
from foundry.conformance.playing import request_of
from foundry.models.base import Model, ModelInfo, RunContext
from foundry.running.build import build
from foundry.worlds.base import Answer, Scenario

REFERENCE = ("cafe_library", "scripted/random")
GOAL = 1_000
MEASURED_S = 1.0
"""CPU seconds of each measurement; an episode is left where they are over."""
REPEATS = 3


@dataclass(frozen=True)
class Played:
    """Decisions that were made, and the CPU seconds that the world and the policy took for them."""

    decisions: int
    cpu_s: float

    @property
    def per_s(self) -> float:
        """Decisions a second."""
        return self.decisions / self.cpu_s


def worlds() -> Iterator[tuple[str, Sequence[str]]]:
    """Yield the worlds that say which policies play them, and these."""
    for file in sorted((paths.conf_dir() / "world").glob("*.yaml")):
        named = yaml.safe_load(file.read_text(encoding="utf-8")).get("baselines")
        if named:
            yield file.stem, named


def fastest(world: str, model: str) -> Played:
    """Return the best of some measurements of a world at its default size, played by a policy."""
    composed = compose([f"world={world}", f"model={model}"])
    assert composed is not None
    config = composed.conditions[0].config
    scenario, policy = scenario_of(config), build(config["model"])
    play(scenario, policy, 0, MEASURED_S / 10)
    return max((play(scenario, policy, seed, MEASURED_S) for seed in range(REPEATS)), key=lambda one: one.per_s)


def play(scenario: Scenario, model: Model, seed: int, most_s: float) -> Played:
    """Play episodes from this seed on until the time is over, without prompts, store and cache."""
    decisions, began = 0, time.process_time()
    while time.process_time() - began < most_s:
        placed = model.in_run(RunContext(seed, seed, scenario.personas(seed), ModelInfo(model.name)))
        decisions += episode(scenario, placed, seed, began + most_s)
        seed += 1
    return Played(decisions, time.process_time() - began)


def episode(scenario: Scenario, model: Model, seed: int, ends: float) -> int:
    """Play one episode, at most until the clock of the process says so; return its decisions."""
    world, decisions = scenario.start(seed), 0
    while not world.finished and time.process_time() < ends:
        asked = world.pending()
        replies = [model.reply(request_of(question, seed)) for question in asked]  # type: ignore[attr-defined]
        world.advance([Answer(reply.text, reply.ending) for reply in replies])
        decisions += len(asked)
    return decisions


def main() -> None:
    """Measure and print."""
    print_title(
        "Worlds and scripted policies",
        "One core, no prompts, no store, no cache; each world at its default size.",
        f"Best of {REPEATS} of {MEASURED_S:g} s of CPU.",
    )
    reference = fastest(*REFERENCE)
    pairs = [REFERENCE, *((world, model) for world, models in worlds() for model in models)]
    found = [
        (world, model, reference if (world, model) == REFERENCE else fastest(world, model)) for world, model in pairs
    ]
    rows = [
        [world, model, f"{one.decisions:,}", f"{one.per_s:,.0f}", f"{one.per_s / reference.per_s:.2f}",
         *at_least(one.per_s, GOAL, "/s")]
        for world, model, one in found
    ]  # fmt: skip
    print_table(["world", "policy", "decisions", "decisions/s", "of the 2D world", "goal", ""], rows)


if __name__ == "__main__":
    main()
