"""The origin of a study: models, settings, versions, times, costs, and the end of every run."""

import math
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from analysis.figures.members import Member
from analysis.figures.shown import Shown
from analysis.prose import percent
from analysis.report.grids import Cell, Grid, grid
from analysis.report.material import Material
from analysis.tables.texts import alike
from foundry.canary import Canary, Distance
from foundry.records import reused_share
from foundry.storing.determinism import Repeats, told_of
from foundry.storing.store import Asked, SweepFolder, leaves

_HOW_REACHED = ("server", "name", "_target_")
"""Settings of a model that do not affect its answers."""


def link(member: Member, base: Path) -> Cell:
    """Return a run's id with a link to its folder, for a page in the folder `base`."""
    if not member.folder.path.exists():
        return Cell(member.folder.id)
    return Cell(member.folder.id, address(member.folder.path, base) + "/")


def address(path: Path, base: Path) -> str:
    """Return the address of a file or a folder on a page in the folder `base`."""
    return quote(Path(os.path.relpath(path, base)).as_posix())


def asked(found: Material) -> list[tuple[str, str, str]]:
    """Return the commands of each sweep."""
    return commands_of(found.sweeps)


def commands_of(sweeps: Iterable[SweepFolder]) -> list[tuple[str, str, str]]:
    """Return, for each sweep, its name and its commands; if it was extended, also what was added and when."""
    return [
        (sweep.path.resolve().name, " ".join(("foundry", *one.overrides)), _added(one) if len(history) > 1 else "")
        for sweep in sweeps
        for history in [sweep.sweep.history]
        for one in history
    ]


def _added(one: Asked) -> str:
    return f"{one.runs} runs" + (f", {one.when.partition('T')[0]}" if one.when else "")


def models_grid(found: Material) -> Grid:
    """Return the models with their digests and settings."""
    digests = {str(model["name"]): model for sweep in (*found.sweeps, *found.beside) for model in sweep.models}
    rows: dict[tuple[str, ...], int] = {}
    for member in found.members:
        config = member.folder.config()["model"]
        name = str(config["name"])
        kept = {key: value for key, value in config.items() if key not in _HOW_REACHED}
        settings = ", ".join(f"{path}={value}" for path, value in leaves(kept) if path)
        known = digests.get(name, {})
        digest = _unique(one.summary.model_digest for one in found.members if one.summary and one.summary.model == name)
        row = (name, digest or known.get("digest") or "none", known.get("server_version") or "-", settings)
        rows[row] = rows.get(row, 0) + 1
    columns = ("model", "digest", "server version", "settings", "runs")
    return grid("The models, as their servers named them.", columns, [(*row, n) for row, n in rows.items()], labels=4)


def _unique(values: Iterable[str | None]) -> str:
    return ", ".join(dict.fromkeys(value for value in values if value))


def versions_grid(found: Material) -> Grid:
    """Return the software versions of the runs."""
    counted: Counter[tuple[str, str]] = Counter()
    for member in found.members:
        if member.summary is not None:
            one = member.summary
            every = {"foundry": one.foundry_version, "Python": one.python_version, "commit": one.git_commit or "none"}
            every["readers of replies"] = str(one.readers)
            counted.update((every | one.packages).items())
    rows = [(name, version, runs) for (name, version), runs in counted.items()]
    return grid("Software of the runs.", ("software", "version", "runs"), rows, labels=2)


def canary_grid(found: Material) -> Grid | None:
    """Return the canaries of the models; None if no canary was recorded."""
    first: dict[str, Canary] = {}
    rows: Counter[tuple[str, ...]] = Counter()
    for member in found.members:
        for canary in member.summary.canaries if member.summary is not None else ():
            begun = first.setdefault(canary.model, canary)
            from_first = Distance.between(begun.signs, canary.signs)
            sweep, verdict = member.folder.path.resolve().parent.parent.name, canary.verdict or "not asked"
            rows[canary.model, sweep, canary.short, verdict, f"{from_first.verdict}: {from_first}"] += 1
    columns = ("model", "sweep", "canary", "during the sweep", "compared with the model's first row", "runs")
    caption = "Identity of the weights, according to a few short greedy calls. Equal canaries mean equal texts."
    return grid(caption, columns, [(*row, n) for row, n in rows.items()], labels=2) if rows else None


def determinism_grid(found: Material) -> Grid | None:
    """Return the determinism of the servers; None if it was not measured."""
    return determinism_of((*found.sweeps, *found.beside))


def determinism_of(sweeps: Iterable[SweepFolder]) -> Grid | None:
    """Return the determinism of the servers of sweeps; None if it was not measured."""
    told = [one for sweep in sweeps for one in told_of(sweep)]
    rows = [(one.name, *_repeated(one.repeats)) for one in told if one.repeats is not None]
    if not rows:
        return None
    columns = ("model", "texts alone", "decisions alone", "texts under load", "decisions under load", "at once", "when")
    caption = (
        "Recorded calls, repeated at the end of the sweep: first one at a time, then under load. The columns count "
        "the calls that returned the same text, and the calls for decisions that returned the same decision."
    )
    return grid(caption, columns, rows)


def _repeated(one: Repeats) -> tuple[str, ...]:
    scores = [str(share) for score in (one.alone, one.loaded) for share in (score.texts, score.decisions)]
    return (*scores, str(one.at_once), one.measured[:19].replace("T", " "))


def cost_grid(found: Material) -> Grid:
    """Return the cost of each group."""
    tokens = ("prompt tokens", "output tokens", "reused")
    columns = ("group", "calls", "from the cache", "retries", *tokens, "model s", "wall s")
    costs = [_cost(found.of(shown)) for shown in found.shown]
    seconds = (alike([getattr(one, name) for one in costs]) for name in ("model_s", "wall_s"))
    rows = [
        (shown.label, *one.counts, model_s, wall_s)
        for shown, one, model_s, wall_s in zip(found.shown, costs, *seconds, strict=True)
    ]
    caption = (
        "Calls, tokens and seconds, including failed runs. For a cached answer, model seconds are the seconds of "
        "the original call. Wall seconds are the sum over all runs, although runs overlap. Reused is the share of "
        "prompt tokens that servers read from their prompt caches, if they report it."
    )
    return grid(caption, columns, rows)


@dataclass(frozen=True)
class _Cost:
    """The cost of a group: calls and tokens as texts, and seconds."""

    counts: tuple[str, ...]
    model_s: float
    wall_s: float


def _cost(mine: Sequence[Member]) -> _Cost:
    summaries = [member.summary for member in mine if member.summary is not None]
    counts = [summary.counts for summary in summaries]
    totals = [
        sum(getattr(one, name) for one in counts)
        for name in ("calls", "cached", "retries", "prompt_tokens", "output_tokens")
    ]
    reused = reused_share(counts)
    timed = [one.model_s for one in counts]
    model_s = math.nan if None in timed else sum(filter(None, timed))
    told = (*(f"{total:,}" for total in totals), "" if reused is None else f"{reused:.0%}")
    return _Cost(told, model_s, sum(one.duration_s for one in summaries))


def configs(found: Material) -> list[tuple[str, str]]:
    """Return the configuration of every condition: its swept settings, and all settings, one per line."""
    return [
        (
            ", ".join(f"{key}={value}" for key, value in condition.factors.items()) or "the only condition",
            "\n".join(f"{path}={value}" for path, value in leaves(condition.config)),
        )
        for sweep in (*found.sweeps, *found.beside)
        for condition in sweep.sweep.conditions
    ]


def ledger_grid(found: Material) -> Grid:
    """Return the outcomes of the runs of each group."""
    rows = [_ledger(shown, found.of(shown)) for shown in found.shown]
    columns = ("group", "runs", "complete", "failed", "missing", "decisions", "unreadable", "unreadable (share)")
    return grid("Runs by outcome, and unreadable decisions.", columns, rows)


def _ledger(shown: Shown, mine: Sequence[Member]) -> tuple[str, ...]:
    complete, failed = sum(one.complete for one in mine), sum(one.failed for one in mine)
    decisions, unreadable = sum(one.decisions for one in mine), sum(one.unreadable for one in mine)
    share = percent(unreadable / decisions) if decisions else "-"
    counts = (len(mine), complete, failed, len(mine) - complete - failed, decisions, unreadable)
    return (shown.label, *(f"{count:,}" for count in counts), share)


def failures_grid(found: Material, base: Path) -> Grid | None:
    """Return why runs failed; None without failures."""
    rows = [
        (
            link(member, base),
            member.shown.label,
            str(member.seed),
            str(member.summary.counts.steps),
            member.summary.error_type or "",
            member.summary.error or "",
        )
        for member in found.members
        if member.failed and member.summary is not None
    ]
    if not rows:
        return None
    columns = ("run", "group", "seed", "records", "error", "cause")
    return grid("Failed runs, and why they failed.", columns, rows, labels=2)


def runs_grid(found: Material, base: Path) -> Grid:
    """Return every run, with its first unreadable decision."""
    wall_s = alike([math.nan if one.summary is None else one.summary.duration_s for one in found.members])
    rows = [
        (link(member, base), member.shown.label, *_run(member, found), seconds)
        for member, seconds in zip(found.members, wall_s, strict=True)
    ]
    columns = ("run", "group", "seed", "status", "calls", "decisions", "unreadable", "first unreadable", "wall s")
    return grid("Every run. The id of a run links to its folder.", columns, rows, labels=2)


def _run(member: Member, found: Material) -> tuple[str, ...]:
    doubt = found.examples.doubts.get(member.folder.id)
    summary = member.summary
    return (
        str(member.seed),
        member.status,
        str(summary.counts.calls) if summary else "-",
        str(member.decisions),
        str(member.unreadable),
        f"step {doubt[0]}, agent {doubt[1]}" if doubt else "-",
    )


def period(found: Material) -> str:
    """Return the start of the first run and the end of the last one."""
    summaries = [member.summary for member in found.members if member.summary is not None]
    if not summaries:
        return "no run has ended"
    first, last = min(one.started or one.ended for one in summaries), max(one.ended for one in summaries)
    return f"{first[:19].replace('T', ' ')} to {last[:19].replace('T', ' ')} UTC"
