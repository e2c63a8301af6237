"""Commands that write files for other people and programs: report and export."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.analyzing import margins_of
from foundry.commands.application import LOOK, app
from foundry.commands.options import (
    Family,
    Folder,
    Labeller,
    Margins,
    Mine,
    Only,
    Trusted,
    WhoLabels,
    Without,
    folder_argument,
)
from foundry.commands.printing import for_screen, say
from foundry.commands.showing import probe_in
from foundry.errors import InputError
from foundry.running.cores import multiply_in_one_thread
from foundry.storing.preregistration import preregistration_of
from foundry.storing.store import SweepFolder
from foundry.texts import counted

if TYPE_CHECKING:
    from foundry.exporting.writing import Measured, Scores


@app.command(rich_help_panel=LOOK)
def report(
    folders: Annotated[list[Path], folder_argument("Sweeps' folders; with --model also bundles.")],
    model: Annotated[
        str | None,
        typer.Option(help="Write a page about this model, compared with chance, the best policy and other models."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="File of the page; default: report.html in the folder, report_with_B.html in the first of the folders "
            "A and B, or card-MODEL.html here."
        ),
    ] = None,
    labeller: WhoLabels = Labeller.RULE,
    family: Family = None,
    margin: Margins = None,
    only: Only = None,
    without: Without = None,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Write one page with the findings of sweeps or of a probe.

    The page is one file that needs no network.

    foundry report --model qwen3:4b outputs/pilot published.tar.zst: write a page about one model, and its text as .md
    """
    asked = {"labelled_by_model": labeller is Labeller.MODEL, "margins": margins_of(margin or [])}
    options = {**asked, "only": only or (), "without": without or ()}
    if model is None:
        _report(folders, out, family or (), trust_targets or (), options)
    elif any(options.values()) or family or trust_targets:
        raise InputError(
            "A page about a model uses whole sweeps and tests nothing, so with --model only --out is allowed."
        )
    else:
        _card(model, folders, out)


def _report(
    folders: Sequence[Path], out: Path | None, family: Sequence[str], trusted: Sequence[str], options: dict[str, Any]
) -> None:
    multiply_in_one_thread()
    from analysis.report import write_report

    probe = probe_in(folders, options)
    if probe is not None:
        from analysis.report.probes.probe_sections import write_probe_report
        from foundry.probing.seen import SeenProbe

        filters = {name: options[name] for name in ("only", "without")}
        written = write_probe_report(probe, SeenProbe(probe, trusted), out, family, **filters)
    else:
        written = write_report(folders, out, family=family or None, **options)
    runs = counted(written.runs, "run")
    if written.complete < written.runs:
        runs = f"{counted(written.complete, 'complete run')} of {written.runs}"
    again = "".join(f"; go on with: foundry resume {folder.path}" for folder in written.unfinished)
    print(f"report of {runs} in {written.path}; its pictures in {written.pictures}{again}")


def _card(model: str, folders: Sequence[Path], out: Path | None) -> None:

    from analysis.paper.card import card as card_of

    page = out or Path(f"card-{re.sub(r'[^A-Za-z0-9.-]+', '_', model)}.html")
    with _unpacked(folders) as sweeps:
        made = card_of(model, sweeps)
    text = page.with_suffix(".md")
    if text == page:
        raise InputError(
            f"--out {page} would be both the page and its text: give the page another name, such as {page.stem}.html."
        )
    for path, content in ((page, made.html()), (text, made.markdown())):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content, encoding="utf-8", newline="\n")
        except OSError as error:
            raise InputError(f"'{path}' cannot be written ({error.strerror}). Name another file with --out.") from error
    print(f"card of {model} in {counted(len(made.settings), 'setting')}: {page}, {text}")


@contextmanager
def _unpacked(paths: Sequence[Path]) -> Iterator[list[Path]]:
    """Yield the folders of sweeps; a bundle is unpacked into a temporary folder."""
    from foundry.trust.unbundling import unpack_bundle

    with TemporaryDirectory(prefix="foundry-card-") as name:
        folders = []
        for place, path in enumerate(paths):
            folder = Path(name) / str(place) / path.name.partition(".")[0] if path.is_file() else path
            if path.is_file():
                unpack_bundle(path, folder)
            folders.append(folder)
        yield folders


class Format(StrEnum):
    """The formats of an export."""

    INSPECT = "inspect"
    EEE = "eee"


@app.command(rich_help_panel=LOOK)
def export(
    what: Annotated[Format, typer.Argument(help="inspect: logs of Inspect; eee: records of Every Eval Ever.")],
    folder: Folder,
    out: Annotated[
        Path | None, typer.Argument(help="A new or an empty folder; default: analysis/export in the sweep.")
    ] = None,
    family: Family = None,
    config_dir: Mine = None,
) -> None:
    """Write a sweep for Inspect or Every Eval Ever.

    An export has one file per condition, with runs, calls and declared measures. It leaves out servers and paths of
    this machine.
    """
    from foundry.exporting.writing import write

    sweep = SweepFolder.open(folder)
    written = write(what.value, sweep, out, scores_of(sweep, family))
    for note in written.notes:
        print(for_screen(note))
    say(for_screen(f"{counted(len(written.files), 'file')} with {counted(written.runs, 'run')} in {written.path}"))


def scores_of(sweep: SweepFolder, family: Sequence[str] | None) -> Scores:
    """Return the values of the declared measures, for each run.

    The option --family names these measures; without it, the preregistration names them.

    A probe has no such measures, because its choices are compared by moment.
    """
    import pandas as pd

    from analysis.load import is_probe
    from analysis.measuring.runs import Source, measure_run
    from analysis.pipeline import check_declared
    from analysis.stats.family import declared_measures
    from analysis.tables.comparison import compare
    from analysis.tables.signature_table import build_table
    from foundry.exporting.writing import Mean, Scores

    if is_probe(sweep):
        if family:
            raise InputError(f"'{sweep.path}' is a probe, which has no measures to export. Leave out --family.")
        return Scores((), {}, {})
    check_declared([sweep], family, None)
    runs, source = sweep.runs(), Source(sweep, sweep.path.name)
    table = build_table([measure_run(run, source).without_steps() for run in runs])
    compared = compare(table, pd.DataFrame({"condition": [run.run.condition for run in runs]}))
    planned = preregistration_of(sweep.path)
    asked = family or (None if planned is None else [measure.name for measure in planned[0].measures])
    names = declared_measures(asked, table.measures, table.present)
    means: dict[int, dict[str, Mean]] = {}
    for (name, (condition,)), estimate in compared.estimates.items():
        if name in names:
            means.setdefault(int(condition), {})[name] = Mean(
                estimate.n, estimate.mean, estimate.sd, estimate.low, estimate.high, estimate.interval
            )
    rows = zip(table.frame["run"], table.present, table.frame[list(names)].to_dict("records"), strict=True)
    of_runs = {run: {name: row[name] for name in names if name in present} for run, present, row in rows}
    return Scores(tuple(map(_measured, names)), of_runs, means)


def _measured(name: str) -> Measured:
    from analysis.signatures import describe
    from foundry.exporting.writing import Measured

    measure = describe(name)
    return Measured(name, measure.label, measure.low, measure.high, str(measure.null or ""), measure.better)
