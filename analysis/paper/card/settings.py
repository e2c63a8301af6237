"""One world that a model was in: its measures beside null, best policy and the other models."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from analysis.paper.card.reading import Found
from analysis.signatures import describe
from analysis.stats.factors import MODEL
from analysis.stats.family import NO_BEHAVIOUR
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.table import Table
from analysis.tables.texts import mean_cell, number, shown_measures
from analysis.validation.facts import facts_of

_UNKNOWN = "-"


@dataclass(frozen=True)
class Setting:
    """A world and whatever else was swept, and the table of a model in it."""

    title: str
    table: Table


def settings_of(found: Found, model: str, *, several: bool) -> Iterator[Setting]:
    """Yield the worlds of a sweep that a model was in.

    Args:
        found: the sweep.
        model: the model.
        several: whether the name of the sweep is to be told.
    """
    for group, run in found.first.items():
        if run.keys["model"] == model:
            where = [f"world {run.keys['world']}", f"prompt {run.keys['prompt']}"]
            where += [f"{name} {run.factors[name]}" for name in run.factors]
            where += [found.name] if several else []
            yield Setting(", ".join(where), _table(found, group))


def _table(found: Found, group: Group) -> Table:
    """Return the measures of a group beside what it is held against."""
    compared, run = found.compared, found.first[group]
    beside = _beside(found, group)
    facts = facts_of(str(run.keys["world"]))
    by_model = {str(found.first[one].keys["model"]): one for one in (group, *beside)}
    policies = {str(found.first[one].keys["model"]) for one in beside}
    chance = facts.random if facts is not None and facts.random in policies else ""
    best = (facts.best or "") if facts is not None else ""
    names = [_name(found, one) for one in beside]
    rows = tuple(
        (
            f"{measure}: {describe(measure, compared.runs.get(group)).label}",
            _cell(compared, measure, group),
            _null(compared, measure, chance, group, by_model),
            _mean(compared, measure, by_model[best]) if best in by_model else _UNKNOWN,
            *(_cell(compared, measure, one) for one in beside),
        )
        for measure in shown_measures(compared)
        if (measure, group) in compared.estimates
    )
    best_name = f"best ({best})" if best in by_model else "best"
    columns = ("measure", str(run.keys["model"]), "null", best_name, *names)
    seeds = len(compared.values[group])
    return Table("card", f"{seeds} seed{'s' if seeds != 1 else ''}.", columns, rows, labels=1)


def _beside(found: Found, group: Group) -> Sequence[Group]:
    """Return the other groups of the same world: models in the same settings, then baselines."""
    compared, world = found.compared, found.first[group].config["world"]
    others = [one for one in compared.groups if one != group and found.first[one].config["world"] == world]
    at = compared.group_columns.index(MODEL)
    alike = [one for one in others if one not in compared.baselines and _without(one, at) == _without(group, at)]
    return [*alike, *(one for one in others if one in compared.baselines)]


def _without(group: Group, at: int) -> Group:
    return (*group[:at], *group[at + 1 :])


def _name(found: Found, group: Group) -> str:
    return str(found.first[group].keys["model"]) + (" (baseline)" if group in found.compared.baselines else "")


def _null(compared: Comparison, measure: str, chance: str, group: Group, by_model: dict[str, Group]) -> str:
    null = describe(measure, compared.runs.get(group)).null
    if null is not None:
        return number(null.value)
    if not chance or measure.partition(".")[0] in NO_BEHAVIOUR:
        return _UNKNOWN
    mean = _mean(compared, measure, by_model[chance])
    return mean if mean == _UNKNOWN else f"{mean} ({chance})"


def _mean(compared: Comparison, measure: str, group: Group) -> str:
    found = compared.estimates.get((measure, group))
    return _UNKNOWN if found is None else number(found.mean)


def _cell(compared: Comparison, measure: str, group: Group) -> str:
    return mean_cell(compared.estimates.get((measure, group)), len(compared.values[group])) or _UNKNOWN
