"""What the analysis knows of a form: how its records become arrays, and what is shown and said of its runs.

It is found by the form's name: in `analysis/<form>/`, in a user's own `forms/<form>.py`, else that of any form.
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

    from analysis.figures.shown import Shown
    from analysis.labelling import Labelling
    from analysis.measuring.events import Event
    from analysis.plots import Picture

ANY = "any"
"""The form whose code reads runs of all others, by the keys that all have."""


class NoDecisionsError(RecordError):
    """The lines of a run are no decisions, and its world of 0.1 declares none."""


class Records(Protocol):
    """The lines of one run."""

    @property
    def messages(self) -> list[Message]:
        """The deliveries."""

    def rows(self) -> list[dict[str, Any]]:
        """Return the decisions as rows of a table."""

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return the decisions by column."""

    def decisions(self) -> dict[str, list[Any]]:
        """Return the keys that all forms have, by column: `step`, `agent`, `kind`, `action`, `outcome` and others."""

    def arrays(self, folder: RunFolder) -> Any:
        """Return a complete run as arrays, as the form's `run`.

        Raises:
            NoDecisionsError: nobody said what the lines are, and they are no decisions.
            RecordError: the lines do not make up a run.
        """


@dataclass(frozen=True)
class Decisions:
    """The decisions in one kind of call of a run.

    Attributes:
        choice: index of the choice, by step and agent, (T, N); by how often it was asked before in the step, too, where
            that may be more than once, (T, N, R).
        readable: whether it could be read, of the same shape.
    """

    choice: IntArray
    readable: BoolArray


@dataclass(frozen=True)
class RunTable:
    """Rows about single runs, for the report; the first text of each row is a run's id."""

    title: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int


class Figures(Protocol):
    """Gathers the shown facts of runs, so no run stays in memory."""

    def add(self, shown: Shown, run: Any, seed: int) -> None:
        """Take the shown facts of a run of a group."""

    def pictures(self, order: Sequence[Shown]) -> list[Picture]:
        """Return the pictures, the groups in this order."""

    def tables(self, order: Sequence[Shown]) -> list[RunTable]:
        """Return the tables."""


def _nothing(*_: Any) -> tuple[str, ...]:
    return ()


def _no_doubts(_: Sequence[Labelling]) -> Mapping[str, str]:
    return {}


@dataclass(frozen=True)
class Words:
    """The words about runs of a form.

    Attributes:
        unread: what becomes of replies that could not be read, after "the others".
        notes: what a reader of the tables must know, from the table of runs and who labelled the messages.
        methods: sentences for the paragraph on methods, from who labelled the messages.
        limits: what a reader must know before any number, from who labelled the messages.
        doubts: by signature why none of its measures can be trusted, from who labelled the messages.
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
    """The pairs of runs whose worlds differ in one setting alone.

    Attributes:
        setting: the setting of the world.
        told: its value in the runs that are held against others; also where a world does not say.
        measures: the name of the difference, by the measure, both as columns.
    """

    setting: str
    told: Any
    measures: Mapping[str, str]


@dataclass(frozen=True)
class FormAnalysis:
    """The analysis of a form; all but the name is optional.

    Attributes:
        name: the form.
        run: the class of its runs as arrays; what a function takes says whether it measures them. By default that of
            any form.
        read: reads the lines of a run, the torn last one of a run that has not ended left out. By default that of any
            form.
        schema: the columns of `steps.parquet` behind `run`; by default those of any form.
        labelled: returns a run with its messages labelled; as it is by default.
        decided: what was decided in a run, by kind of call, for test-retest consistency; by default the actions.
        crop: draws what surrounded an agent of a run when it decided in a step, as SVG of a page. None by default.
        figures: gathers what is shown of runs; is told the seed whose runs are shown one by one. None by default.
        words: what is said of them.
        fixtures: returns a table of each kind of thing in the world of a run, such as `fires`; none by default.
        twin: which runs are the null of others; none by default.
        events: the events of a run, beside replies that cannot be read and failures, which runs of every form have.
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
    """Return the analysis of a form: the shipped one, the user's, or else that for any form.

    Raises:
        InputError: the user's own cannot be used, or has the name of a shipped one; names its file.
    """
    return _form_of(name, own_folders())


def forms_of(folders: Iterable[RunFolder]) -> list[FormAnalysis]:
    """Return the forms of these runs, in the order of their first run."""
    return [form_of(name) for name in dict.fromkeys(folder.declared.form for folder in folders)]


@cache
def _form_of(name: str, _folders: tuple[Path, ...]) -> FormAnalysis:
    return _own(name) or shipped(name) or replace(_any(), name=name)


def shipped(name: str) -> FormAnalysis | None:
    """Return the analysis from the package's room of this name; None without such a room."""
    found = in_room(f"analysis.{name}", "ANALYSIS")
    return found if isinstance(found, FormAnalysis) else None


def _any() -> FormAnalysis:
    found = shipped(ANY)
    assert found is not None, "the package has a room for any form"
    return found


def _own(name: str) -> FormAnalysis | None:
    module = next((module for module in own_modules("forms") if module.name == name), None)
    analysis = analysis_in(module) if module else None
    if module and analysis and shipped(name):
        refuse_shipped_name(f"ANALYSIS in {module.origin}", name, {name: Path(__file__).with_name(name)})
    return analysis


def analysis_in(module: OwnModule) -> FormAnalysis | None:
    """Return the analysis from a user's module; None if the module has none.

    Raises:
        InputError: it cannot be imported, or says something else.
    """
    found = getattr(module.load(), "ANALYSIS", None)
    if found is not None and not isinstance(found, FormAnalysis):
        raise InputError(f"{module.origin}: ANALYSIS is no analysis.form.FormAnalysis.")
    return found
