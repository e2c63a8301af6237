"""Compares models with known results of their worlds: scripted policies, values from formulas, published figures."""

import difflib
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import pandas as pd
import yaml

from analysis.measuring.runs import RunResult
from analysis.stats.factors import MODEL, Factor, context_of, find_factors
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.groups import group_keys
from analysis.tables.table import Table
from analysis.tables.texts import number, text_rows_by_measure, without_empty
from analysis.validation.facts import ClosedForm, Facts, Published, facts_of, read_yaml
from foundry.own_code import own_folders
from foundry.paths import conf_dir

COLUMNS = (
    "world", "measure", "better", "model", "prompt", "settings", "n", "mean", "low", "high", "random",
    "best_policy", "best", "closed_forms", "published_model", "published", "published_certain", "source", "differs",
)  # fmt: skip
_ALIKE = 0.6
"""Minimum similarity of two names that count as the same, 0..1."""
_SIZE = re.compile(r"(?<![a-z0-9.])(?:\d+x)?\d+(?:\.\d+)?[bm](?![a-z0-9])")
_MOST_TOLD = 3
"""At most this number of changed settings are listed; if more have changed, only their number is given."""
_LONGEST = 30
"""Maximum number of characters of a setting; of a longer one, only the first and the last are shown."""
_LEFT_OUT = frozenset(("_target_", "name"))


def validation_frame(results: Sequence[RunResult], groups: pd.DataFrame, compared: Comparison) -> pd.DataFrame:
    """Return a table with a row per group of runs, if theory gives a result for their world; the columns are COLUMNS.

    `random` and `best` are the means of the policies `Facts.random` and `Facts.best` in this world, for example from
    `foundry analyze --baselines`; NaN without such runs. `settings` lists the swept settings of the world other than
    the model. `published` is the figure that `nearest` returns.

    Args:
        results: the runs.
        groups: the columns that define the groups, one row per run.
        compared: the groups with their estimates.
    """
    first: dict[Group, RunResult] = {}
    for key, result in zip(group_keys(groups), results, strict=True):
        first.setdefault(key, result)
    worlds = {result.keys["world"] for result in first.values()}
    known = {world: facts_of(world) for world in worlds}
    swept = {world: _swept(world, first, compared) for world in worlds}
    rows = [
        _row(group, first, compared, facts, swept[first[group].keys["world"]])
        for group in compared.groups
        if group not in compared.baselines
        and (facts := known[first[group].keys["world"]]) is not None
        and (facts.score, group) in compared.estimates
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _row(
    group: Group,
    first: Mapping[Group, RunResult],
    compared: Comparison,
    facts: Facts,
    swept: Sequence[Factor],
) -> dict[str, Any]:
    run = first[group]
    estimate = compared.estimates[facts.score, group]
    means = {
        result.keys["model"]: compared.estimates[facts.score, other].mean
        for other, result in first.items()
        if result.config["world"] == run.config["world"] and (facts.score, other) in compared.estimates
    }
    near = nearest(run.keys["model"], facts.published)
    return {
        "world": facts.world,
        "measure": facts.score,
        "better": facts.better,
        "model": run.keys["model"],
        "prompt": run.keys["prompt"],
        "settings": context_of(compared.group_columns, group, swept, MODEL),
        "n": estimate.n,
        "mean": estimate.mean,
        "low": estimate.low,
        "high": estimate.high,
        "random": means.get(facts.random, math.nan),
        "best_policy": facts.best or "",
        "best": means.get(facts.best or "", math.nan),
        "closed_forms": "; ".join(
            f"{closed_form.name} {number(closed_form.value)}{elsewhere(closed_form, run.config['world'], facts.world)}"
            for closed_form in facts.closed_forms
            if closed_form.column == facts.score
        ),
        "published_model": near.model if near else "",
        "published": near.value if near else math.nan,
        "published_certain": near.certain if near else "",
        "source": near.source if near else "; ".join(dict.fromkeys(published.source for published in facts.published)),
        "differs": "; ".join(filter(None, (facts.differs, changed(run.config["world"], facts.world)))),
    }


def _swept(world: str, first: Mapping[Group, RunResult], compared: Comparison) -> tuple[Factor, ...]:
    """Return the settings that differ between the groups of a world, baselines left out."""
    own = [group for group in compared.groups if group not in compared.baselines]
    own = [group for group in own if first[group].keys["world"] == world]
    return find_factors(compared.group_columns, own)


def nearest(model: str, published: Sequence[Published]) -> Published | None:
    """Return the published value of the model with the same size and the most similar name; None without such a model.

    If a name states no size, only one published value may have this name.
    """
    size, name = _size(model), _plain(model)
    of_this_size = {_plain(row.model): row for row in published if size and _size(row.model) == size}
    close = difflib.get_close_matches(name, of_this_size, n=1, cutoff=_ALIKE)
    if close:
        return of_this_size[close[0]]
    of_this_name = [row for row in published if _plain(row.model) == name and "" in (size, _size(row.model))]
    return of_this_name[0] if len(of_this_name) == 1 else None


def _size(model: str) -> str:
    """Return the number of parameters in a model's name, such as `72b` or `8x7b`; "" if it has none."""
    size = _SIZE.search(model.casefold())
    return size[0] if size else ""


def _plain(name: str) -> str:
    """Return a model's name without its server, its size and its quantisation."""
    own = _SIZE.sub("", name.rpartition("/")[2].casefold())
    return re.sub(r"[^a-z0-9]", "", re.sub(r"-(?:instruct|it|q\d).*", "", own).removesuffix(":latest"))


def changed(settings: Mapping[str, Any], world: str) -> str:
    """Return how the settings of a world differ from its file, such as `agents=12, not 10`; empty if they do not."""
    usual = _settings_of(world)
    changes = [f"{key}={own}, not {value}" for key, value, own in _differing(usual, settings)]
    return f"{len(changes)} settings changed" if len(changes) > _MOST_TOLD else "; ".join(changes)


def elsewhere(form: ClosedForm, settings: Mapping[str, Any], world: str) -> str:
    """Return the settings for which a value holds, such as ` (at agents=10)`; "" if the run has the same settings."""
    usual = _settings_of(world)
    for override in form.overrides:
        path, _, value = override.partition("=")
        part, *keys = path.split(".")
        if part == "world":
            usual = _with(usual, keys, yaml.safe_load(value))
    changes = [f"{key}={value}" for key, value, _ in _differing(usual, settings)]
    if not changes:
        return ""
    if len(changes) > _MOST_TOLD:
        return f" (where {len(changes)} settings differ from the run's)"
    return f" (at {', '.join(changes)})"


def _with(settings: Any, keys: Sequence[str], value: Any) -> Any:
    """Return the settings with one of them changed as by an override; in a mapping, only the named keys change."""
    known = settings if isinstance(settings, Mapping) else {}
    if keys:
        return {**known, keys[0]: _with(known.get(keys[0]), keys[1:], value)}
    return {**known, **value} if isinstance(value, Mapping) else value


def _differing(
    usual: Mapping[str, Any], settings: Mapping[str, Any], above: str = ""
) -> Iterator[tuple[str, str, str]]:
    """Yield each setting that differs: its path, its usual value and its actual value; a list counts as one setting."""
    for key in (key for key in usual if key in settings and f"{above}{key}" not in _LEFT_OUT):
        value, own = usual[key], settings[key]
        if isinstance(value, Mapping) and isinstance(own, Mapping):
            yield from _differing(value, own, f"{above}{key}.")
        elif value != own and "${" not in str(value):
            yield f"{above}{key}", _short(value), _short(own)


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _LONGEST else f"{text[0]}...{text[-1]}"


def _settings_of(world: str) -> dict[str, Any]:
    """Return the settings in the file of a world; none if it has no file."""
    places = [folder / "world" / f"{world}.yaml" for folder in (conf_dir(), *own_folders())]
    file = next((place for place in places if place.is_file()), None)
    content: Mapping[str, Any] = read_yaml(file) if file else {}
    own: Mapping[str, Any] = content.get("world", content)
    return dict(own)


def validation_table(frame: pd.DataFrame) -> Table:
    """Return the rows of `validation_frame` as a readable table."""
    columns = (
        "world", "model", "settings", "measure", "found", "n", "random", "best policy", "closed forms", "published",
        "differs",
    )  # fmt: skip
    caption = (
        "The score of each world next to known results: mean over seeds with its 95 % interval. Random and best: "
        "means of a policy that ignores its observations, and of the best scripted policy, in the same world. Closed "
        "forms: values that follow from a formula, with the settings for which they hold if these differ from the "
        "settings of the sweep. Published: the value of the model of equal size with the most similar name. The "
        "published study has other prompts, so only the order of magnitude is comparable."
    )
    rows = text_rows_by_measure(frame, ("random", "best"), {"mean": ("low", "high")})
    return without_empty(Table("validation", caption, columns, tuple(map(_text_row, rows)), labels=4))


def _text_row(row: Mapping[Any, Any]) -> tuple[str, ...]:
    of = f"({row['published_model']}, {row['source']})"
    return (
        row["world"],
        row["model"],
        row["settings"],
        row["measure"],
        row["mean"],
        str(row["n"]),
        row["random"],
        f"{row['best']} ({row['best_policy']})" if row["best_policy"] else "-",
        row["closed_forms"] or "-",
        f"{number(row['published'])} {of}" if row["published_model"] else "-",
        row["differs"] or "-",
    )
