"""The results of the analysis for each group of runs, which the page of a sweep shows above its runs."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from foundry.errors import RecordError
from foundry.records import NOT_JSON
from foundry.storing.preregistration import preregistration_of
from foundry.storing.store import SweepFolder
from foundry.texts import from_cell
from foundry.viewer.signature_table import SignatureTable

_T = TypeVar("_T")
NO_BEHAVIOUR = ("failure", "cost")
"""Names of the signatures about failures and cost, which do not describe the behaviour of agents."""
_OF_THE_MEASURE = ("measure", "baseline", "runs", "n", "mean", "sd", "low", "high", "interval", "note", "filter")


class Group(msgspec.Struct):
    """A group of runs that the analysis compared with other groups.

    Attributes:
        values: values that the runs of the group share, one text per column, as in a model and a world.
        baseline: whether its runs are scripted baselines, which are in a sweep of their own.
        measures: mean, lower and upper end of the interval, and number of seeds, by measure; None if not computed.
    """

    values: list[str]
    baseline: bool
    measures: dict[str, tuple[float | None, float | None, float | None, int]] = msgspec.field(default_factory=dict)


class Moment(msgspec.Struct):
    """A question that two runs decided differently (an entry of `findings.json`)."""

    level_run: str
    reference_run: str
    seed: int
    step: int
    agent: int


class Finding(msgspec.Struct):
    """A finding of the analysis (an entry of `findings.json`)."""

    sentence: str
    measure: str
    label: str
    standing: str
    moments: list[Moment]


class _Overview(msgspec.Struct):
    matrix: dict[str, Any] | None = None
    furthest: list[dict[str, Any]] = msgspec.field(default_factory=list)
    labels: dict[str, str] = msgspec.field(default_factory=dict)


class Summary(msgspec.Struct):
    """Results of the analysis: the compared groups of runs, and the findings about these groups.

    Attributes:
        columns: names of the values that define a group.
        groups: the groups, in the order of the analysis.
        group_of: for each run of the sweep, the index of its group; None if the run was not analysed.
        part: the part of the runs that was analysed; "" for all runs.
        findings: the findings, the most important first. Their moments are only those of runs of this sweep.
        matrix: the table of models by worlds in `overview.json`, or None.
        furthest: the runs of this sweep that `overview.json` lists as far from the mean of their group.
        labels: the title of each of the measures, if the analysis wrote it.
    """

    columns: list[str] = msgspec.field(default_factory=list)
    groups: list[Group] = msgspec.field(default_factory=list)
    group_of: list[int | None] = msgspec.field(default_factory=list)
    part: str = ""
    findings: list[Finding] = msgspec.field(default_factory=list)
    matrix: dict[str, Any] | None = None
    furthest: list[dict[str, Any]] = msgspec.field(default_factory=list)
    labels: dict[str, str] = msgspec.field(default_factory=dict)


def claimed_measures(sweep: SweepFolder, measures: Sequence[str]) -> list[str]:
    """Return the names in `measures` of measures on which claims rest; measures of success come first.

    Claims rest on the declared measures. Without a declaration, they rest on the headline measures of the contrasts;
    without contrasts, on the first measure of each signature.
    """
    planned = preregistration_of(sweep.path)
    if planned is not None:
        names = [measure.name for measure in planned[0].measures]
    else:
        rows = _rows(sweep.analysis_dir / "contrasts.csv")
        names = [row["measure"] for row in rows if row.get("headline") == "True"] or _first_of_each_signature(measures)
    there = [name for name in dict.fromkeys(names) if name in measures]
    return sorted(there, key=lambda name: name.partition(".")[2] != "success")


def _first_of_each_signature(measures: Sequence[str]) -> list[str]:
    first = {name.partition(".")[0]: name for name in reversed(measures)}
    return [name for signature, name in reversed(first.items()) if signature not in NO_BEHAVIOUR]


def summary_of(sweep: SweepFolder, measures: Sequence[str], table: SignatureTable) -> Summary:
    """Return the groups of the analysis with these measures; no group if there is no analysis."""
    rows = _rows(sweep.analysis_dir / "comparison.csv")
    if not rows:
        return Summary()
    columns = [name for name in rows[0] if name not in _OF_THE_MEASURE]
    wanted, groups = set(measures), dict[tuple[str, ...], Group]()
    for row in rows:
        key = tuple(row[name] for name in columns)
        group = groups.setdefault(key, Group(list(key), row["baseline"] == "True"))
        if row["measure"] in wanted and row["mean"]:
            low, high = _number(row["low"]), _number(row["high"])
            group.measures[row["measure"]] = _number(row["mean"]), low, high, int(row["n"])
    places = {key: place for place, (key, group) in enumerate(groups.items()) if not group.baseline}
    runs = [run.id for run in sweep.sweep.runs]
    known = set(table.names())
    columns_of_text = [table.texts(name, runs) if name in known else [""] * len(runs) for name in columns]
    group_of = [places.get(key) for key in zip(*columns_of_text, strict=True)]
    findings = _written(sweep.analysis_dir / "findings.json", list[Finding]) or []
    here = set(runs)
    for finding in findings:
        finding.moments = [
            moment for moment in finding.moments if moment.level_run in here and moment.reference_run in here
        ]
    overview = _overview_of(sweep)
    furthest = [moment for moment in overview.furthest if moment["run"] in here]
    part = rows[0].get("filter") or ""
    labels = {name: overview.labels[name] for name in measures if name in overview.labels}
    return Summary(columns, list(groups.values()), group_of, part, findings, overview.matrix, furthest, labels)


def label_of(sweep: SweepFolder, measure: str) -> str:
    """Return the title of a measure; "" if the analysis did not write it."""
    return _overview_of(sweep).labels.get(measure, "")


def _overview_of(sweep: SweepFolder) -> _Overview:
    return _written(sweep.analysis_dir / "overview.json", _Overview) or _Overview()


def _written(path: Path, kind: type[_T]) -> _T | None:
    """Return the content of a file of the analysis, or None if there is no such file."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except FileNotFoundError:
        return None
    except NOT_JSON as error:
        raise RecordError(f"{path} cannot be read ({error}). Use foundry analyze to write it again.") from error


def _rows(path: Path) -> list[dict[str, str]]:
    """Return the rows of a table of the analysis; none if there is no such file."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file, restval="")
            names = reader.fieldnames or ()
            return [{from_cell(name): from_cell(row[name]) for name in names} for row in reader]
    except FileNotFoundError:
        return []


def _number(text: str) -> float | None:
    return float(text) if text else None
