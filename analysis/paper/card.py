"""Writes a card about one model: for each of its worlds, every measure beside other models and known values."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.any.label_signature import UNCORRECTED
from analysis.figures.members import Member, members, shown_groups
from analysis.labelling import Reading
from analysis.load import is_probe, runs_by_id
from analysis.measuring.memory import open_memory
from analysis.measuring.runs import RunResult, measure_runs, sources_of
from analysis.pipeline import opened
from analysis.prose import percent
from analysis.report.grids import grid_of
from analysis.report.templating import rendered
from analysis.signatures import describe, readings
from analysis.stats.factors import MODEL
from analysis.stats.family import NO_BEHAVIOUR
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison, compare
from analysis.tables.groups import group_columns, group_keys
from analysis.tables.signature_table import build_table
from analysis.tables.table import Table
from analysis.tables.texts import escaped, mean_cell, number, shown_measures, to_markdown
from analysis.validation.facts import facts_of
from foundry.errors import not_found
from foundry.records import RunSummary
from foundry.storing.determinism import repeats_of
from foundry.storing.store import SweepFolder, ensure_writable

READING = (
    "Means over seeds with their 95 % intervals; n is given if some seeds have no value. The card tests no "
    "differences; the tables of each sweep contain the tests.",
    "Null: the value by chance alone, from the definition of the measure; if the definition gives none, the mean of "
    "the blind policy, which is then named in brackets. Best: the mean of the scripted policy that is best in this "
    "world. To run these policies, use foundry analyze DIR --baselines. A hyphen means that a value is unknown.",
)
"""The notes at the end of a model's card."""
PROBES = " Probes are not shown, because they have tables of their own."
"""The note on a model's card if some of the sweeps are probes."""
_UNKNOWN = "-"


@dataclass(frozen=True)
class Setting:
    """The table of a model in one world, with a title that names the world and the swept settings."""

    title: str
    table: Table


@dataclass(frozen=True)
class Card:
    """A card about a model.

    Attributes:
        facts: one row per sweep with weights, version, runs, unreadable decisions, and determinism of the server.
        settings: one table per world.
    """

    model: str
    facts: Table
    settings: tuple[Setting, ...]

    def html(self) -> str:
        """Return the card as HTML."""
        tables = [(setting.title, grid_of(setting.table)) for setting in self.settings]
        content = {"title": self.model, "reading": READING, "facts": grid_of(self.facts), "tables": tables}
        return rendered("card.html", content)

    def markdown(self) -> str:
        """Return the card as Markdown."""
        parts = [f"# {escaped(self.model)}\n", *(f"{escaped(text)}\n" for text in READING), to_markdown(self.facts)]
        parts += [f"## {escaped(setting.title)}\n\n{to_markdown(setting.table)}" for setting in self.settings]
        return "\n".join(parts)


def card(model: str, dirs: Sequence[Path]) -> Card:
    """Return the card of a model that ran in some sweeps.

    Raises:
        InputError: a folder is not a sweep, two folders contain the same run, or the model ran in none of them.
        RecordError: a recorded file is damaged.
    """
    measured = [_measured(sweep) for sweep in opened(dirs)]
    having = [sweep for sweep in measured if model in sweep.models.values()]
    if not having:
        models = {name for sweep in measured for name in sweep.models.values()}
        raise not_found("Model", model, models, "Name a model that ran in these sweeps.")
    whole = [sweep for sweep in having if not is_probe(sweep.folder)]
    columns = ("sweep", "weights", "foundry", "server repeats", "runs", "complete", "unreadable decisions")
    caption = f"Sweeps with runs of the model. A hyphen means unknown.{'' if len(whole) == len(having) else PROBES}"
    facts = Table("facts", caption, columns, tuple(_facts(sweep, model) for sweep in having), labels=4)
    return Card(model, facts, tuple(setting for sweep in whole for setting in _settings(sweep, model, len(having) > 1)))


@dataclass(frozen=True)
class _Measured:
    folder: SweepFolder
    compared: Comparison
    first: Mapping[Group, RunResult]
    members: tuple[Member, ...]
    readings: Mapping[str, Reading]

    @property
    def name(self) -> str:
        """The name of the sweep's folder."""
        return self.folder.path.resolve().name

    @property
    def models(self) -> dict[Group, str]:
        """For each group of runs, the name of its model."""
        return {group: str(run.keys["model"]) for group, run in self.first.items()}


def _measured(sweep: SweepFolder) -> _Measured:
    sources = sources_of([sweep], [sweep.path.name], labelled_by_model=False)
    ensure_writable(sweep.analysis_dir)
    with open_memory(sweep.analysis_dir / "measured.sqlite") as memory:
        results = [result.without_steps() for result in measure_runs(sources, memory)]
    table = build_table(results)
    groups = group_columns(results, table)
    compared = compare(table, groups)
    first: dict[Group, RunResult] = {}
    for key, result in zip(group_keys(groups), results, strict=True):
        first.setdefault(key, result)
    folders = runs_by_id([source.folder for source in sources])
    own = tuple(members(table.frame, groups, shown_groups(compared), folders))
    return _Measured(sweep, compared, first, own, readings([source.labelling for source in sources], table.measures))


def _facts(sweep: _Measured, model: str) -> tuple[str, ...]:
    own = [member for member in sweep.members if str(member.folder.config()["model"]["name"]) == model]
    summaries = [member.summary for member in own if member.summary is not None]
    decisions = sum(member.decisions for member in own)
    return (
        sweep.name,
        _unique(_weights(summary, model) for summary in summaries),
        _unique(summary.foundry_version for summary in summaries),
        _unique(f"{repeats.least} calls exactly" for repeats in repeats_of(sweep.folder) if repeats.of == model),
        str(len(own)),
        str(sum(member.complete for member in own)),
        percent(sum(member.unreadable for member in own) / decisions) if decisions else _UNKNOWN,
    )


def _weights(summary: RunSummary, model: str) -> str:
    canaries = (f"canary {canary.short}" for canary in summary.canaries if canary.model == model)
    return ", ".join(filter(None, ((summary.model_digest or "")[:12], *canaries)))


def _unique(texts: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(filter(None, texts))) or _UNKNOWN


def _settings(sweep: _Measured, model: str, several: bool) -> Iterator[Setting]:
    """Yield a table for each world of a model; its title names the sweep if there are several."""
    for group, run in sweep.first.items():
        if sweep.models[group] == model:
            where = [f"{name} {run.keys[name]}" for name in ("world", "prompt")]
            where += [f"{name} {value}" for name, value in run.factors.items()]
            yield Setting(", ".join([*where, *([sweep.name] if several else [])]), _table(sweep, group))


def _table(sweep: _Measured, group: Group) -> Table:
    compared, models = sweep.compared, sweep.models
    beside = _beside(sweep, group)
    facts = facts_of(str(sweep.first[group].keys["world"]))
    policies = {models[other]: other for other in beside}
    chance = policies.get(facts.random or "") if facts is not None else None
    best = {models[group]: group, **policies}.get(facts.best or "") if facts is not None else None

    def mean(measure: str, other: Group | None) -> str:
        estimate = None if other is None else compared.estimates.get((measure, other))
        return _UNKNOWN if estimate is None else number(estimate.mean)

    def cell(measure: str, other: Group) -> str:
        text = mean_cell(compared.estimates.get((measure, other)), len(compared.values[other])) or _UNKNOWN
        without = mean(f"{measure}{UNCORRECTED}", other)
        return text if without == _UNKNOWN else f"{text} (uncorrected {without})"

    def name(measure: str) -> str:
        label = describe(measure, compared.runs.get(group)).label
        reading = f", {sweep.readings[measure].text}" if measure in sweep.readings else ""
        return f"{measure}: {label}{reading}"

    def null(measure: str) -> str:
        stated = describe(measure, compared.runs.get(group)).null
        if stated is not None:
            return number(stated.value)
        by_chance = _UNKNOWN if measure.partition(".")[0] in NO_BEHAVIOUR else mean(measure, chance)
        return by_chance if by_chance == _UNKNOWN or chance is None else f"{by_chance} ({models[chance]})"

    rows = tuple(
        (
            name(measure),
            cell(measure, group),
            null(measure),
            mean(measure, best),
            *(cell(measure, other) for other in beside),
        )
        for measure in shown_measures(compared)
        if (measure, group) in compared.estimates
    )
    names = [models[other] + (" (baseline)" if other in compared.baselines else "") for other in beside]
    columns = ("measure", models[group], "null", "best" if best is None else f"best ({models[best]})", *names)
    seeds = len(compared.values[group])
    return Table("card", f"{seeds} seed{'s' if seeds != 1 else ''}.", columns, rows, labels=1)


def _beside(sweep: _Measured, group: Group) -> Sequence[Group]:
    """Return the groups that a card shows beside a group: other models in the same setting, then baselines."""
    compared, world = sweep.compared, sweep.first[group].config["world"]
    others = [other for other in compared.groups if other != group and sweep.first[other].config["world"] == world]
    at = compared.group_columns.index(MODEL)
    alike = [
        other
        for other in others
        if other not in compared.baselines and (*other[:at], *other[at + 1 :]) == (*group[:at], *group[at + 1 :])
    ]
    return [*alike, *(other for other in others if other in compared.baselines)]
