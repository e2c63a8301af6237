"""Finds the analysis of a form of records: its arrays, figures and words.

The analysis of a form is in `analysis/<form>/`, or in your own `forms/<form>.py`. A form without an analysis of its own
gets the analysis `any`, which can read every form.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from analysis.arrays import BoolArray, IntArray
from foundry.declared import Declared
from foundry.errors import InputError, RecordError
from foundry.naming import in_room
from foundry.own_code import OwnModule, own_folders, own_modules, refuse_shipped_name
from foundry.records import Message, RunSummary
from foundry.storing.store import RunFolder

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa  # type: ignore[import-untyped]

    from analysis.figures.shown import ShownGroup
    from analysis.labelling import Labelling
    from analysis.measuring.events import Event
    from analysis.plots import Picture

ANY = "any"
"""Name of the analysis that can read runs of every form, because it uses only the keys that all forms share."""


class NoDecisionsError(RecordError):
    """foundry 0.1 recorded the run, its lines are not decisions, and its world declares no schema for them."""


class Records(Protocol):
    """The lines of one run."""

    @property
    def messages(self) -> list[Message]:
        """The delivered messages."""

    def rows(self) -> list[dict[str, Any]]:
        """Return the decisions as rows of a table."""

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return some keys of the decisions, as columns."""

    def decisions(self) -> dict[str, list[Any]]:
        """Return the keys that all forms share, such as `step`, `agent` and `action`, as columns."""

    def arrays(self, folder: RunFolder) -> Any:
        """Return a complete run as arrays, in the class that `FormAnalysis.run` names.

        Raises:
            NoDecisionsError: the world has no schema, and the lines are not decisions.
            RecordError: the lines do not make a complete run.
        """


@dataclass(frozen=True)
class Decisions:
    """The decisions of a run in one kind of call.

    Attributes:
        choice: index of the choice, by step and agent, (T, N); if an agent may be asked several times in a step, also
            by repetition, (T, N, R).
        readable: whether the decision is readable, in the same shape.
    """

    choice: IntArray
    readable: BoolArray


@dataclass(frozen=True)
class RunTable:
    """A table of single runs for the report; each row begins with the id of a run."""

    title: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int


class Figures(Protocol):
    """Collects the facts that figures show, run by run, so that no run stays in memory."""

    def add(self, shown: ShownGroup, run: Any, seed: int) -> None:
        """Collect from a run what the figures need."""

    def pictures(self, order: Sequence[ShownGroup]) -> list[Picture]:
        """Return the plots, with the groups in the given order."""

    def tables(self, order: Sequence[ShownGroup]) -> list[RunTable]:
        """Return the tables, with the groups in the given order."""


def _nothing(*_: Any) -> tuple[str, ...]:
    return ()


def _no_doubts(_: Sequence[Labelling]) -> Mapping[str, str]:
    return {}


@dataclass(frozen=True)
class Words:
    """Words that summaries and tables use for runs of one form.

    Attributes:
        unread: effect of unreadable replies, as the end of a sentence that begins with "the others".
        notes: returns notes for readers of the tables, from the table of runs and the labels of messages.
        methods: returns sentences for the methods section, from the labels of messages.
        limits: returns limitations of the study, from the labels of messages.
        doubts: returns, by signature, the reason why none of its measures can be trusted, from the labels of messages.
    """

    unread: str = "decide nothing"
    notes: Callable[[pd.DataFrame, Sequence[Labelling]], Sequence[str]] = _nothing
    methods: Callable[[Sequence[Labelling]], Sequence[str]] = _nothing
    limits: Callable[[Sequence[Labelling]], Sequence[str]] = _nothing
    doubts: Callable[[Sequence[Labelling]], Mapping[str, str]] = _no_doubts


def _no_events(_: Any) -> tuple[Event, ...]:
    return ()


def _as_it_is(run: Any, _: Labelling) -> Any:
    return run


def _no_fixtures(_: RunFolder) -> dict[str, pd.DataFrame]:
    return {}


def _schema_of_any(declared: Declared) -> pa.Schema:
    return _any().schema(declared)


@dataclass(frozen=True)
class Twin:
    """Says which runs form pairs that differ in one setting only, the run and its twin.

    Attributes:
        told: value of the setting in the runs that are compared with their twins; it is also the default.
        measures: for each measure, the column of its difference from the twin.
    """

    setting: str
    told: Any
    measures: Mapping[str, str]


@dataclass(frozen=True)
class FormAnalysis:
    """The analysis of runs of one form; every attribute but the name is optional.

    Attributes:
        run: class of its runs as arrays; signatures annotate their argument with it. Defaults to the class of any form.
        read: reads the lines of a run, without the incomplete last line of an unfinished run. Defaults to the reader of
            any form.
        schema: columns of `steps.parquet` after `run`; defaults to the columns of any form.
        labelled: returns a run with labelled messages; by default, the unchanged run.
        decided: returns the decisions of a run, by kind of call, for test-retest consistency; by default the actions.
        crop: draws the surroundings of an agent at a decision, as SVG for a page. None by default.
        figures: collects the content of plots, given the seed of the example runs. None by default.
        words: texts about its runs.
        fixtures: returns a table for each kind of thing in the world of a run, such as `fires`; none by default.
        twin: describes pairs of runs to compare; none by default.
        events: returns the events of a run, without unreadable replies and failures, which all forms have.
    """

    name: str
    run: type = field(default_factory=lambda: _any().run)
    read: Callable[[RunFolder, RunSummary | None], Records] = field(default_factory=lambda: _any().read)
    schema: Callable[[Declared], pa.Schema] = _schema_of_any
    labelled: Callable[[Any, Labelling], Any] = _as_it_is
    decided: Callable[[Any], Mapping[str, Decisions]] | None = None
    crop: Callable[[Any, int, int], str] | None = None
    figures: Callable[[int], Figures] | None = None
    words: Words = field(default_factory=Words)
    fixtures: Callable[[RunFolder], Mapping[str, pd.DataFrame]] = _no_fixtures
    twin: Twin | None = None
    events: Callable[[Any], Iterable[Event]] = _no_events


def form_of(name: str) -> FormAnalysis:
    """Return the analysis of a form: the shipped one; if there is none, the user's own; without both, `any`.

    Raises:
        InputError: the user's own analysis cannot be used, or has the name of a shipped one.
    """
    return _form_of(name, own_folders())


def forms_of(folders: Iterable[RunFolder]) -> list[FormAnalysis]:
    """Return the analyses of the runs' forms, each form once, in the order in which the forms first occur."""
    return [form_of(name) for name in dict.fromkeys(folder.declared.form for folder in folders)]


@cache
def _form_of(name: str, _folders: tuple[Path, ...]) -> FormAnalysis:
    return _own(name) or shipped(name) or replace(_any(), name=name)


def shipped(name: str) -> FormAnalysis | None:
    """Return the shipped analysis of a form, or None."""
    analysis = in_room(f"analysis.{name}", "ANALYSIS")
    return analysis if isinstance(analysis, FormAnalysis) else None


def _any() -> FormAnalysis:
    analysis = shipped(ANY)
    assert analysis is not None, "the package has a room for any form"
    return analysis


def _own(name: str) -> FormAnalysis | None:
    module = next((module for module in own_modules("forms") if module.name == name), None)
    analysis = analysis_in(module) if module else None
    if module and analysis and shipped(name):
        refuse_shipped_name(f"ANALYSIS in {module.origin}", name, {name: Path(__file__).with_name(name)})
    return analysis


def analysis_in(module: OwnModule) -> FormAnalysis | None:
    """Return the analysis in a user's module, or None.

    Raises:
        InputError: the module cannot be imported, or its ANALYSIS is not a FormAnalysis.
    """
    analysis = getattr(module.load(), "ANALYSIS", None)
    if analysis is not None and not isinstance(analysis, FormAnalysis):
        raise InputError(f"{module.origin}: ANALYSIS must be an analysis.form.FormAnalysis.")
    return analysis
