"""Commands about recorded runs: verify, diff, bundle, unbundle and fork."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from foundry.commands.application import EXIT_FAILED, EXIT_OK, OVERRIDES, RUN, TRUST, app
from foundry.commands.options import (
    AsJson,
    Folder,
    Mine,
    Noted,
    OneRun,
    Overrides,
    Trusted,
    TrustedServers,
    folder_argument,
    given,
)
from foundry.commands.printing import console, for_screen, is_verbose, only_json, print_json, say_notes, with_bar
from foundry.storing.store import find_run, runs_at
from foundry.texts import counted

if TYPE_CHECKING:
    from foundry.trust.comparing import Drift
    from foundry.trust.verifying import Verdict, VerifiedRun


@app.command(rich_help_panel=TRUST)
def verify(
    path: Annotated[Path, folder_argument("A sweep's folder, or a run's.", "DIR|RUN")],
    frames: Annotated[
        bool, typer.Option("--frames", help="Also draw the stored frames again, and compare them.")
    ] = False,
    workers: Annotated[int | None, typer.Option(help="Number of processes; default: one per core.", min=1)] = None,
    json: AsJson = False,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Play recorded runs again from their recorded answers, and compare every byte.

    Needs no server. The exit code is 3 if a record differs, or needs another version of foundry or another renderer.
    The exit code is also 3 if a bundled run is missing, or if a model's weights differ between runs.
    """
    import joblib

    from foundry.trust.summaries import weights_apart
    from foundry.trust.unknown import check_sweep_targets
    from foundry.trust.verifying import Verdict
    from foundry.trust.verifying import verify as verify_runs

    folder, runs = runs_at(path)
    check_sweep_targets(folder.sweep, folder.settings, trust_targets or ())
    with only_json(json):
        verified = verify_runs(folder, runs, workers=min(workers or joblib.cpu_count(), len(runs)), frames=frames)
        results = sorted(with_bar(verified, "verifying", len(runs)), key=lambda result: result.run)
    counts = {verdict: sum(result.verdict == verdict for result in results) for verdict in Verdict}
    apart = list(weights_apart(runs))
    if json:
        print_json({"sweep": folder.path, "verdicts": counts, "runs": results, "weights": apart})
    else:
        _say_verified(results, counts)
        for line in apart:
            print(for_screen(line))
    failed = (Verdict.DIFFERS, Verdict.READ_OTHERWISE, Verdict.DRAWN_OTHERWISE, Verdict.MISSING)
    if apart or any(counts[verdict] for verdict in failed):
        raise typer.Exit(EXIT_FAILED)


def _say_verified(results: Sequence[VerifiedRun], counts: Mapping[Verdict, int]) -> None:
    for verified in results:
        if verified.difference is not None:
            print(for_screen(f"{verified.run} differs: {verified.difference.line()}"))
        elif verified.note:
            print(for_screen(f"{verified.run} {verified.note}"))
        elif is_verbose():
            print(
                for_screen(f"{verified.run} {verified.verdict}: {verified.lines:,} lines, {verified.calls:,} questions")
            )
    verdicts = [f"{count} {verdict}" for verdict, count in counts.items() if count]
    lines, calls = sum(result.lines for result in results), sum(result.calls for result in results)
    print(f"{counted(len(results), 'run')}: {', '.join(verdicts)}; {lines:,} lines and {calls:,} questions compared")


_ROWS = 20
"""Maximum number of rows (steps) in the table that compares two runs."""


@app.command(rich_help_panel=TRUST)
def diff(one: OneRun, other: OneRun, json: AsJson = False, config_dir: Mine = None) -> None:
    """Show the first difference of two runs, and how far they are apart at each step after it.

    Compares questions, answers and states.
    """
    from foundry.running.recorded import excerpts
    from foundry.trust.comparing import compare

    left, right = find_run(one), find_run(other)
    parting = compare(left, right)
    if json:
        print_json({"runs": [left.id, right.id], **vars(parting)})
        return
    for what, difference in (("question", parting.question), ("answer", parting.answer), ("state", parting.state)):
        print(for_screen(f"first differing {what}: {'none' if difference is None else difference.where()}"))
        if difference is not None:
            first, second = excerpts(difference.recorded, difference.now)
            print(for_screen(f"  first run:  {first}\n  second run: {second}"))
    _print_drift(parting.drift)


def _print_drift(drift: Sequence[Drift]) -> None:
    """Print a table with a row per step, from the first step that differs to the last; of many steps, every k-th."""
    from foundry.display import frame_table

    first = next((number for number, row in enumerate(drift) if _is_apart(row)), None)
    if first is None:
        print(f"decisions, places and utilities are equal in all {len(drift)} steps that both runs have")
        return
    rows = drift[first:]
    stride = -(-len(rows) // _ROWS)
    rows = rows[len(rows) % stride - 1 if len(rows) % stride else stride - 1 :: stride]
    columns = {name: cells for name, cells in _cells(rows).items() if any(cells)}
    console().print(frame_table(zip(*columns.values(), strict=True), list(columns)))


def _is_apart(row: Drift) -> bool:
    return any(value > 0 for value in (row.acted, row.elsewhere, row.utility))


def _cells(rows: Sequence[Drift]) -> dict[str, list[str]]:
    """Return the columns of the table as texts; a column that the form of the runs lacks has only empty cells."""

    def column(name: str, form: str) -> list[str]:
        values = [getattr(row, name) for row in rows]
        return ["" if value != value else format(value, form) for value in values]

    return {
        "step": column("step", "d"),
        "agents": column("agents", "d"),
        "acted differently": column("acted", ".0%"),
        "elsewhere": column("elsewhere", ".0%"),
        "mean distance": column("distance", ".2f"),
        "mean turn": column("turned", ".1f"),
        "mean difference of utility": column("utility", ".2f"),
    }


@app.command(rich_help_panel=TRUST)
def bundle(
    folder: Folder,
    out: Annotated[Path, typer.Argument(metavar="FILE", help="The file to write, such as pilot.tar.zst.")],
    notes: Noted = False,
    config_dir: Mine = None,
) -> None:
    """Pack a sweep into one file for a reviewer.

    The file contains records, answers, images, scenes and digests. Addresses of servers and paths of this machine are
    left out. The same sweep always gives the same bytes.
    """
    from foundry.trust.bundling import write_bundle

    manifest = write_bundle(folder, out, notes=notes)
    size = sum(file.size for file in manifest.files)
    packed = f"{counted(manifest.runs, 'run')}, {counted(len(manifest.files), 'file')}"
    print(f"{packed}, {size:,} bytes, {out.stat().st_size:,} packed: {out}")
    say_notes([folder], taken=notes)


@app.command(rich_help_panel=TRUST)
def unbundle(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A bundle.")],
    folder: Annotated[Path | None, folder_argument("A new folder; default: the name of the bundle.")] = None,
    limit: Annotated[float, typer.Option(help="Maximum size of the unpacked files, GiB.", min=0.0)] = 16.0,
    config_dir: Mine = None,
) -> None:
    """Unpack a bundle, and check the name, size and digest of every file.

    foundry verify and foundry analyze can then read the folder.
    """
    from foundry.trust.unbundling import GIB, unpack_bundle

    target = folder or Path(file.name.removesuffix(".zst").removesuffix(".tar"))
    manifest = unpack_bundle(file, target, limit=int(limit * GIB))
    unpacked = f"{counted(manifest.runs, 'run')}, {counted(len(manifest.files), 'file')}"
    print(f"{unpacked} in {target}; check them with: foundry verify {target}")


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def fork(
    run: OneRun,
    overrides: Overrides = None,
    *,
    at: Annotated[int, typer.Option(help="The first step that is played again, at least 2.")],
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Continue a recorded run from a step with another model, prompt or world.

    The new runs share all earlier steps with the recorded run.

    foundry fork outputs/pilot/runs/<run> --at 20 -m model=qwen3:4b,llama3.2 sampling_seed=0-4
    """
    from foundry.commands.sweeps import run_composed, say_defaults
    from foundry.composing.defaults import read_defaults
    from foundry.trust.forking import compose_fork, keep_origin
    from foundry.trust.unknown import check_models, check_sweep_targets

    origin, (folder, _) = find_run(run), runs_at(run)
    check_sweep_targets(folder.sweep, folder.settings, trust_targets or ())
    arguments = given(overrides, config_dir)
    composed = compose_fork(origin, folder.path.resolve().name, at, arguments, read_defaults())
    if composed is None:
        raise typer.Exit(EXIT_OK)
    say_defaults(composed)
    if not trust_servers:
        models = [condition.config["model"] for condition in composed.conditions]
        check_models(models, typed=arguments, recorded=[origin.config()["model"]])
    raise typer.Exit(run_composed(composed, lambda new: keep_origin(new, origin, at)))
