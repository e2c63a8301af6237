"""Writes a report: one HTML page about one or several sweeps, which a browser shows without a network."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from foundry.errors import InputError
from foundry.storing.store import SweepFolder, write_atomically

if TYPE_CHECKING:
    from analysis.load import Folders
    from analysis.report.material import Material


@dataclass(frozen=True)
class Report:
    """A written report.

    Attributes:
        path: the page.
        runs: number of its runs.
        complete: number of its complete runs.
        pictures: the folder of its pictures.
        unfinished: the sweeps, without baselines, that have runs without a complete end.
    """

    path: Path
    runs: int
    complete: int
    pictures: Path
    unfinished: tuple[SweepFolder, ...]


def write_report(dirs: Folders, out: Path | None = None, **options: Any) -> Report:
    """Analyse the sweeps if necessary, and write the page.

    Args:
        dirs: folder of a sweep, or folders of several.
        out: the page; by default `report.html` in the folder of the sweep, or, for several,
            `report_with_<others>.html` in the folder of the first.
        **options: options of `analysis.analyze` that affect the numbers: `labelled_by_model`, `family`, `margins`,
            `only`, `without`.

    Raises:
        InputError: as for `analysis.analyze`; or the page cannot be written.
        RecordError: a recorded file is damaged.
    """
    from analysis.report.material import gather

    check_out(out)
    material = gather(dirs, **options)
    path = material.sweeps[0].report_file_with(material.sweeps[1:]) if out is None else out
    folder = material.analysis.path / "plots"
    write_page(path, render(material, path.resolve().parent, folder))
    missing = {member.folder.id for member in material.members if not member.complete and not member.shown.baseline}
    unfinished = tuple(sweep for sweep in material.sweeps if any(run.id in missing for run in sweep.runs()))
    complete = sum(member.complete for member in material.members)
    return Report(path, len(material.members), complete, folder, unfinished)


def check_out(out: Path | None) -> None:
    """Raise an InputError if the path of the page is a folder."""
    if out is not None and out.is_dir():
        raise InputError(f"--out '{out}' is a folder: name a file, such as {out / 'report.html'}.")


def write_page(path: Path, page: str) -> None:
    """Write a page, or raise an InputError if this is impossible."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, page.encode("utf-8"))
    except OSError as error:
        raise InputError(
            f"Cannot write '{path}' ({error.strerror}): fix this, or name another file with --out."
        ) from error


def render(material: Material, base: Path, folder: Path) -> str:
    """Return the page as HTML, with links relative to its folder `base`; write its pictures into `folder`."""
    from analysis.report.templating import rendered

    return rendered("report.html", _content(material, base, folder))


def _content(material: Material, base: Path, folder: Path) -> dict[str, Any]:
    from analysis.figures.pictures import fingerprint_picture
    from analysis.paper.methods import bibtex, methods
    from analysis.report import cards, limits, overview, provenance, sections
    from analysis.report.grids import grid, grid_of
    from analysis.tables.equal_chances import equal_chances_table
    from analysis.tables.texts import CONTRASTED
    from analysis.tables.thresholds import thresholds_table
    from analysis.validation.known_values import validation_table

    names = [sweep.path.resolve().name for sweep in material.sweeps]
    differing = provenance.world_differences(material.sweeps)
    known = validation_table(material.analysis.validation)
    chances = equal_chances_table(material.analysis.equal_chances)
    prevailing = thresholds_table(material.analysis.thresholds)
    fingerprint = filter(None, [fingerprint_picture(material.analysis.fingerprint)])
    return {
        "title": ", ".join(names),
        "facts": overview.facts(material),
        "warnings": overview.warnings(material),
        "cards": cards.cards(material, base),
        "width": cards.WIDTH,
        "overview": overview.matrix(material),
        "claims": overview.claims(material),
        "asked": provenance.commands_of(material.sweeps),
        "worlds": grid("Settings that differ between the worlds of the sweeps.", ("setting", *names), differing)
        if differing
        else None,
        "several": len(names) > 1,
        "summary": material.analysis.summary,
        "limits": limits.limits(material),
        "models": provenance.models_grid(material),
        "versions": provenance.versions_grid(material),
        "canaries": provenance.canary_grid(material),
        "determinism": provenance.determinism_grid((*material.sweeps, *material.beside)),
        "costs": provenance.cost_grid(material),
        "period": provenance.period(material),
        "configs": provenance.configs(material),
        "ledger": provenance.ledger_grid(material),
        "failures": provenance.failures_grid(material, base),
        "runs": provenance.runs_grid(material, base),
        "comparison": sections.comparison_grid(material),
        "values": sections.values_grid(material, base),
        "contrasts": sections.contrast_grids(material),
        "contrasted": CONTRASTED,
        "known": grid_of(known) if known.rows else None,
        "variance": sections.variance_grid(material),
        "energy": sections.energy_grid(material),
        "retest": sections.retest_grid(material),
        "equal_chances": grid_of(chances) if chances.rows else None,
        "thresholds": grid_of(prevailing) if prevailing.rows else None,
        "fingerprint_shapes": sections.shapes(fingerprint, folder, base),
        "world_shapes": sections.shapes(material.examples.pictures[: sections.MOST_OF_WORLDS], folder, base),
        "run_grids": sections.run_grids(material, base),
        "sections": sections.signature_sections(material),
        "methods": methods(material.basis),
        "references": bibtex(material.basis),
    }
