"""Tables on the origin of a study: models, settings, versions, times, costs, and the outcome of every run."""

import math
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from urllib.parse import quote

from analysis.figures.members import Member
from analysis.figures.shown import ShownGroup
from analysis.prose import percent
from analysis.report.grids import Cell, Grid, grid
from analysis.report.material import Material
from analysis.tables.texts import alike
from foundry.canary import Canary, Distance
from foundry.records import reused_share
from foundry.storing.determinism import Repeats, model_repeats
from foundry.storing.store import SweepCommand, SweepFolder, leaves

_HOW_REACHED = ("server", "name", "_target_")
"""Settings of a model that are not shown, because they do not affect its answers."""


def link(member: Member, base: Path) -> Cell:
    """Return the id of a run; on a page in the folder `base`, it links to the run's folder."""
    if not member.folder.path.exists():
        return Cell(member.folder.id)
    return Cell(member.folder.id, address(member.folder.path, base) + "/")


def address(path: Path, base: Path) -> str:
    """Return the link to a file or a folder from a page in the folder `base`."""
    return quote(Path(os.path.relpath(path, base)).as_posix())


def commands_of(sweeps: Iterable[SweepFolder]) -> list[tuple[str, str, str]]:
    """Return a row per command that added runs to a sweep: the sweep's name, the command, and what it added.

    The third text is the number of runs with the date; it is empty if the sweep has only one command.
    """
    return [
        (sweep.path.resolve().name, " ".join(("foundry", *asked.overrides)), _added(asked) if len(history) > 1 else "")
        for sweep in sweeps
        for history in [sweep.sweep.history]
        for asked in history
    ]


def _added(asked: SweepCommand) -> str:
    return f"{asked.runs} runs" + (f", {asked.when.partition('T')[0]}" if asked.when else "")


def models_grid(material: Material) -> Grid:
    """Return the models with their digests and settings."""
    digests = {str(model["name"]): model for sweep in (*material.sweeps, *material.beside) for model in sweep.models}
    rows: dict[tuple[str, ...], int] = {}
    for member in material.members:
        config = member.folder.config()["model"]
        name = str(config["name"])
        deciding = {key: value for key, value in config.items() if key not in _HOW_REACHED}
        settings = ", ".join(f"{path}={value}" for path, value in leaves(deciding) if path)
        known = digests.get(name, {})
        digest = _unique(
            member.summary.model_digest
            for member in material.members
            if member.summary and member.summary.model == name
        )
        row = (name, digest or known.get("digest") or "none", known.get("server_version") or "-", settings)
        rows[row] = rows.get(row, 0) + 1
    columns = ("model", "digest", "server version", "settings", "runs")
    return grid("Models, with digest and settings.", columns, [(*row, n) for row, n in rows.items()], labels=4)


def _unique(values: Iterable[str | None]) -> str:
    return ", ".join(dict.fromkeys(value for value in values if value))


def versions_grid(material: Material) -> Grid:
    """Return the software versions of the runs."""
    counted: Counter[tuple[str, str]] = Counter()
    for member in material.members:
        if member.summary is not None:
            summary = member.summary
            every = {
                "foundry": summary.foundry_version,
                "Python": summary.python_version,
                "commit": summary.git_commit or "none",
            }
            every["readers of replies"] = str(summary.readers)
            counted.update((every | summary.packages).items())
    rows = [(name, version, runs) for (name, version), runs in counted.items()]
    return grid("Software of the runs.", ("software", "version", "runs"), rows, labels=2)


def canary_grid(material: Material) -> Grid | None:
    """Return a row for each canary of a model (answers that identify its weights); None without canaries."""
    first: dict[str, Canary] = {}
    rows: Counter[tuple[str, ...]] = Counter()
    for member in material.members:
        for canary in member.summary.canaries if member.summary is not None else ():
            begun = first.setdefault(canary.model, canary)
            from_first = Distance.between(begun.signs, canary.signs)
            sweep, verdict = member.folder.path.resolve().parent.parent.name, canary.verdict or "not asked"
            rows[canary.model, sweep, canary.short, verdict, f"{from_first.verdict}: {from_first}"] += 1
    columns = ("model", "sweep", "canary", "during the sweep", "compared with the model's first row", "runs")
    caption = (
        "Canaries: hashes of the answers to a few short greedy calls, which identify a model's weights. Equal canaries "
        "mean equal answers."
    )
    return grid(caption, columns, [(*row, n) for row, n in rows.items()], labels=2) if rows else None


def determinism_grid(sweeps: Iterable[SweepFolder]) -> Grid | None:
    """Return a table: how often a server gave the same reply to a repeated call. None if this was not measured."""
    results = [result for sweep in sweeps for result in model_repeats(sweep)]
    rows = [(result.name, *_repeated(result.repeats)) for result in results if result.repeats is not None]
    if not rows:
        return None
    columns = ("model", "texts alone", "decisions alone", "texts under load", "decisions under load", "at once", "when")
    caption = (
        "Does a server repeat its replies? At the end of the sweep, foundry repeated recorded calls: first one at a "
        "time (alone), then many at once (under load). The columns count the calls that returned the same text, and "
        "those calls for decisions that returned the same decision."
    )
    return grid(caption, columns, rows)


def _repeated(repeats: Repeats) -> tuple[str, ...]:
    scores = [str(share) for score in (repeats.alone, repeats.loaded) for share in (score.texts, score.decisions)]
    return (*scores, str(repeats.at_once), repeats.measured[:19].replace("T", " "))


def cost_grid(material: Material) -> Grid:
    """Return the cost of each group."""
    tokens = ("prompt tokens", "output tokens", "reused")
    columns = ("group", "calls", "from the cache", "retries", *tokens, "model s", "wall s")
    counts, model_s, wall_s = zip(*(_cost(material.of(shown)) for shown in material.shown), strict=True)
    rows = [
        (shown.label, *own, *seconds)
        for shown, own, *seconds in zip(material.shown, counts, alike(model_s), alike(wall_s), strict=True)
    ]
    caption = (
        "Calls, tokens and seconds of each group, including failed runs. The model seconds of a cached answer "
        "belong to the original call. The wall seconds of runs that overlap are added up. Reused: the share of prompt "
        "tokens that servers read from their prompt caches, if they report it."
    )
    return grid(caption, columns, rows)


def _cost(mine: Sequence[Member]) -> tuple[tuple[str, ...], float, float]:
    """Return calls and tokens as texts, then the seconds of the model's calls and the wall seconds of the runs."""
    summaries = [member.summary for member in mine if member.summary is not None]
    counts = [summary.counts for summary in summaries]
    totals = [
        sum(getattr(count, name) for count in counts)
        for name in ("calls", "cached", "retries", "prompt_tokens", "output_tokens")
    ]
    reused = reused_share(counts)
    timed = [count.model_s for count in counts]
    model_s = math.nan if None in timed else sum(filter(None, timed))
    cells = (*(f"{total:,}" for total in totals), "" if reused is None else f"{reused:.0%}")
    return cells, model_s, sum(summary.duration_s for summary in summaries)


def configs(material: Material) -> list[tuple[str, str]]:
    """Return, for every condition, its swept settings, and a text with one line for each of all its settings."""
    return [
        (
            ", ".join(f"{key}={value}" for key, value in condition.factors.items()) or "the only condition",
            "\n".join(f"{path}={value}" for path, value in leaves(condition.config)),
        )
        for sweep in (*material.sweeps, *material.beside)
        for condition in sweep.sweep.conditions
    ]


def ledger_grid(material: Material) -> Grid:
    """Return the number of runs of each group by status, such as complete or failed, and its unreadable decisions."""
    rows = [_ledger(shown, material.of(shown)) for shown in material.shown]
    columns = ("group", "runs", "complete", "failed", "missing", "decisions", "unreadable", "unreadable (share)")
    return grid("Runs of each group by status, and the unreadable decisions of these runs.", columns, rows)


def _ledger(shown: ShownGroup, mine: Sequence[Member]) -> tuple[str, ...]:
    complete, failed = sum(member.complete for member in mine), sum(member.failed for member in mine)
    decisions, unreadable = sum(member.decisions for member in mine), sum(member.unreadable for member in mine)
    share = percent(unreadable / decisions) if decisions else "-"
    counts = (len(mine), complete, failed, len(mine) - complete - failed, decisions, unreadable)
    return (shown.label, *(f"{count:,}" for count in counts), share)


def failures_grid(material: Material, base: Path) -> Grid | None:
    """Return the failed runs with the causes; None if no run failed."""
    rows = [
        (
            link(member, base),
            member.shown.label,
            str(member.seed),
            str(member.summary.counts.steps),
            member.summary.error_type or "",
            member.summary.error or "",
        )
        for member in material.members
        if member.failed and member.summary is not None
    ]
    if not rows:
        return None
    columns = ("run", "group", "seed", "records", "error", "cause")
    return grid("Failed runs, and why they failed.", columns, rows, labels=2)


def runs_grid(material: Material, base: Path) -> Grid:
    """Return a row for every run: status, counts, time, and the place of its first unreadable decision."""
    wall_s = alike([math.nan if member.summary is None else member.summary.duration_s for member in material.members])
    rows = [
        (link(member, base), member.shown.label, *_run(member, material), seconds)
        for member, seconds in zip(material.members, wall_s, strict=True)
    ]
    columns = ("run", "group", "seed", "status", "calls", "decisions", "unreadable", "first unreadable", "wall s")
    return grid("Every run. The id of a run links to its folder.", columns, rows, labels=2)


def _run(member: Member, material: Material) -> tuple[str, ...]:
    doubt = material.examples.doubts.get(member.folder.id)
    summary = member.summary
    return (
        str(member.seed),
        member.status,
        str(summary.counts.calls) if summary else "-",
        str(member.decisions),
        str(member.unreadable),
        f"step {doubt[0]}, agent {doubt[1]}" if doubt else "-",
    )


def period(material: Material) -> str:
    """Return the start of the first run and the end of the last run, as text."""
    summaries = [member.summary for member in material.members if member.summary is not None]
    if not summaries:
        return "no run has ended"
    first, last = (
        min(summary.started or summary.ended for summary in summaries),
        max(summary.ended for summary in summaries),
    )
    return f"{first[:19].replace('T', ' ')} to {last[:19].replace('T', ' ')} UTC"


def world_differences(sweeps: Sequence[SweepFolder]) -> list[tuple[str, ...]]:
    """Return a row for each setting that differs between the worlds: its path, then its values in each sweep."""
    by_sweep = [_world_values(sweep) for sweep in sweeps]
    paths = dict.fromkeys(path for values in by_sweep for path in values)
    differing = [path for path in paths if len({tuple(values.get(path, ())) for values in by_sweep}) > 1]
    return [(path, *(" or ".join(values.get(path, ["none"])) for values in by_sweep)) for path in differing]


def _world_values(sweep: SweepFolder) -> dict[str, list[str]]:
    values: dict[str, set[str]] = {}
    for condition in sweep.sweep.conditions:
        for path, value in leaves(condition.config["world"]):
            values.setdefault(path, set()).add(value)
    return {path: sorted(values) for path, values in values.items()}
