"""Put different language models into the same small world and measure how differently they behave.

The public names of foundry are for programs and notebooks; Python imports each name at its first use. See
`docs/python.md`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from foundry.version import __version__ as __version__

if TYPE_CHECKING:
    from analysis.any.any_run import AnyRun
    from analysis.camera.camera_run import CameraRun
    from analysis.form import FormAnalysis
    from analysis.grid.grid_run import GridRun
    from analysis.load import Loaded, load
    from analysis.measure import Measure, Null, share
    from analysis.measuring.events import Event
    from analysis.pipeline import Analysis, analyze
    from analysis.rounds.rounds_run import RoundsRun
    from foundry.calling import Ran, run, sweep
    from foundry.conformance.checking import check
    from foundry.conformance.playing import Finding
    from foundry.declared import Actions, Declared
    from foundry.errors import FoundryError, InputError, RequestError, ServerError, TransientError
    from foundry.models.base import Model, Reply, Request, ScriptedModel
    from foundry.prompts.prompt import Prompt
    from foundry.records import Agent, Message, Outcome, Record, RoundStep
    from foundry.seeding import stream
    from foundry.viewer.any.any_view import AnyView
    from foundry.viewer.forms import FormView
    from foundry.worlds.base import Answer, Question, Recorded, Redrawing, Scenario, World
    from foundry.worlds.probe.editing import observing
    from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
    from foundry.worlds.rounds.table import Decision, Table

__all__ = [
    "Actions", "Agent", "Analysis", "Answer", "AnyRun", "AnyView", "CameraRun", "Decision", "Declared", "Event",
    "Finding", "FormAnalysis", "FormView", "FoundryError", "GridRun", "InputError", "Loaded", "Measure", "Message",
    "Model", "Null", "Outcome", "Play", "Prompt", "Question", "Ran", "Record", "Recorded", "Redrawing", "Reply",
    "Request", "RequestError", "RoundStep", "RoundsRun", "RoundsScenario", "Scenario", "ScriptedModel", "ServerError",
    "Table", "TransientError", "World", "analyze", "check", "load", "observing", "run", "share", "stream", "sweep",
]  # fmt: skip

_PLACES = {
    "analysis.any.any_run": ("AnyRun",),
    "analysis.camera.camera_run": ("CameraRun",),
    "analysis.form": ("FormAnalysis",),
    "analysis.grid.grid_run": ("GridRun",),
    "analysis.measure": ("Measure", "Null", "share"),
    "analysis.measuring.events": ("Event",),
    "analysis.rounds.rounds_run": ("RoundsRun",),
    "foundry.viewer.any.any_view": ("AnyView",),
    "foundry.viewer.forms": ("FormView",),
    "foundry.worlds.probe.editing": ("observing",),
    "analysis.load": ("Loaded", "load"),
    "analysis.pipeline": ("Analysis", "analyze"),
    "foundry.calling": ("Ran", "run", "sweep"),
    "foundry.conformance.checking": ("check",),
    "foundry.conformance.playing": ("Finding",),
    "foundry.declared": ("Actions", "Declared"),
    "foundry.errors": ("FoundryError", "InputError", "RequestError", "ServerError", "TransientError"),
    "foundry.models.base": ("Model", "Reply", "Request", "ScriptedModel"),
    "foundry.prompts.prompt": ("Prompt",),
    "foundry.records": ("Agent", "Message", "Outcome", "Record", "RoundStep"),
    "foundry.seeding": ("stream",),
    "foundry.worlds.base": ("Answer", "Question", "Recorded", "Redrawing", "Scenario", "World"),
    "foundry.worlds.rounds.table": ("Decision", "Table"),
    "foundry.worlds.rounds.rounds_world": ("Play", "RoundsScenario"),
}


def __getattr__(name: str) -> Any:
    """Import a public name of foundry when a program first uses it."""
    module = next((place for place, names in _PLACES.items() if name in names), None)
    if module is None:
        raise AttributeError(f"module 'foundry' has no attribute '{name}'")
    from foundry.own_code import ours

    value = getattr(ours(module), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
