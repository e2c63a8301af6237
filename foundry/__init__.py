"""Put different language models into the same small world and measure how differently they behave.

The names below are what programs and notebooks use; each is imported when it is first asked for. See `docs/python.md`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from foundry.version import __version__ as __version__

if TYPE_CHECKING:
    from analysis.load import Loaded, load
    from analysis.pipeline import Analysis, analyze
    from foundry.calling import Ran, run, sweep
    from foundry.conformance.checking import check
    from foundry.conformance.playing import Finding
    from foundry.declared import Actions, Declared
    from foundry.errors import FoundryError, InputError
    from foundry.models.base import Model, Reply, Request
    from foundry.models.scripted.policy import ScriptedModel
    from foundry.prompts.prompt import Prompt
    from foundry.records import Agent, Message, Outcome, Record, RoundStep
    from foundry.seeding import stream
    from foundry.worlds.base import Answer, Question, Recorded, Redrawing, Scenario, World
    from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
    from foundry.worlds.rounds.table import Decision, Table

__all__ = [
    "Actions",
    "Agent",
    "Analysis",
    "Answer",
    "Decision",
    "Declared",
    "Finding",
    "FoundryError",
    "InputError",
    "Loaded",
    "Message",
    "Model",
    "Outcome",
    "Play",
    "Prompt",
    "Question",
    "Ran",
    "Record",
    "Recorded",
    "Redrawing",
    "Reply",
    "Request",
    "RoundStep",
    "RoundsScenario",
    "Scenario",
    "ScriptedModel",
    "Table",
    "World",
    "analyze",
    "check",
    "load",
    "run",
    "stream",
    "sweep",
]

_PLACES = {
    "analysis.load": ("Loaded", "load"),
    "analysis.pipeline": ("Analysis", "analyze"),
    "foundry.calling": ("Ran", "run", "sweep"),
    "foundry.conformance.checking": ("check",),
    "foundry.conformance.playing": ("Finding",),
    "foundry.declared": ("Actions", "Declared"),
    "foundry.errors": ("FoundryError", "InputError"),
    "foundry.models.base": ("Model", "Reply", "Request"),
    "foundry.models.scripted.policy": ("ScriptedModel",),
    "foundry.prompts.prompt": ("Prompt",),
    "foundry.records": ("Agent", "Message", "Outcome", "Record", "RoundStep"),
    "foundry.seeding": ("stream",),
    "foundry.worlds.base": ("Answer", "Question", "Recorded", "Redrawing", "Scenario", "World"),
    "foundry.worlds.rounds.table": ("Decision", "Table"),
    "foundry.worlds.rounds.rounds_world": ("Play", "RoundsScenario"),
}


def __getattr__(name: str) -> Any:
    """Import one of the names above when it is first asked for."""
    module = next((place for place, names in _PLACES.items() if name in names), None)
    if module is None:
        raise AttributeError(f"module 'foundry' has no attribute '{name}'")
    from foundry.own_code import ours

    found = getattr(ours(module), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
