"""A card of one model: every world that it was in, each measure beside null, best policy and the other models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.load import is_probe
from analysis.paper.card.reading import Found, read_sweep
from analysis.paper.card.settings import Setting, settings_of
from analysis.pipeline import opened
from analysis.report import rendered
from analysis.report.grids import grid_of
from analysis.tables.table import Table
from analysis.tables.texts import escaped, to_markdown
from foundry.errors import not_found

READING = (
    "Means over seeds with their 95 % intervals, n where not every seed has a value. Nothing here is tested: the "
    "tables of each sweep say which differences are claimed.",
    "Null is what chance alone gives, as the measure states it, or else the mean of the policy in brackets, which "
    "looks at nothing; best is the mean of the scripted policy that is best at the world's score. Policies are there "
    "where they were run on the same world (foundry analyze DIR --baselines). A hyphen is what is not known.",
)
"""How a card is to be read."""
PROBES = " A probe has no table here: its moments are no course of a run, and its own tables compare them."
"""What is said where one of the sweeps is a probe."""


@dataclass(frozen=True)
class Card:
    """What is known of a model.

    Attributes:
        model: its name.
        facts: a row a sweep: weights, versions, runs, unread decisions, whether its server repeats itself.
        settings: the worlds that it was in.
    """

    model: str
    facts: Table
    settings: tuple[Setting, ...]

    def html(self) -> str:
        """Return the page."""
        tables = [(one.title, grid_of(one.table)) for one in self.settings]
        content = {"model": self.model, "reading": READING, "facts": grid_of(self.facts), "tables": tables}
        return rendered("card.html", content)

    def markdown(self) -> str:
        """Return the same as Markdown."""
        parts = [f"# {escaped(self.model)}\n", *(f"{escaped(one)}\n" for one in READING), to_markdown(self.facts)]
        parts += [f"## {escaped(one.title)}\n\n{to_markdown(one.table)}" for one in self.settings]
        return "\n".join(parts)


def card(model: str, dirs: Sequence[Path]) -> Card:
    """Return the card of a model from the folders of sweeps.

    Raises:
        InputError: a folder is no sweep's, or holds runs of another, or no run of any is the model's.
        RecordError: a recorded file is damaged.
    """
    found = [read_sweep(sweep) for sweep in opened(dirs)]
    having = [one for one in found if model in one.models]
    if not having:
        raise not_found("Model", model, {name for one in found for name in one.models}, "Name one that ran in them.")
    whole = [one for one in having if not is_probe(one.sweep)]
    settings = tuple(setting for one in whole for setting in settings_of(one, model, several=len(having) > 1))
    return Card(model, _facts(having, model, "" if len(whole) == len(having) else PROBES), settings)


def _facts(having: Sequence[Found], model: str, probes: str) -> Table:
    columns = ("sweep", "weights", "foundry", "server repeats itself", "runs", "complete", "unread decisions")
    rows = tuple(one.facts(model) for one in having)
    caption = f"Where it was run. A hyphen is what is not known.{probes}"
    return Table("facts", caption, columns, rows, labels=4)
