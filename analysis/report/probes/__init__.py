"""One page about a probe: what each model did in the same moments."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from analysis.report import Report, check_out, write_page
from analysis.report.probes.probe_moments import Looked
from analysis.report.templating import rendered
from foundry.storing.store import SweepFolder


def write_probe_report(
    folder: SweepFolder,
    looked: Looked,
    out: Path | None = None,
    family: Sequence[str] = (),
    *,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
) -> Report:
    """Analyse a probe and write its page.

    Args:
        folder: the probe.
        looked: shows its moments.
        out: the page; by default `report.html` in its folder.
        family: the models and edits that were declared beforehand; nothing: all.
        only: answers that are taken, as KEY=VALUE[,VALUE...].
        without: answers that are left out, in the same way.

    Raises:
        InputError: what is declared or filtered is not in the probe, or the page cannot be written.
        RecordError: a recorded file is damaged.
    """
    from analysis.probes import analyze_probe
    from analysis.report.probes.probe_sections import content

    check_out(out)
    found = analyze_probe(folder, family, only=only, without=without, plots=False)
    path, pictures = out or folder.report_file, found.path / "plots"
    write_page(path, rendered("probe.html", content(folder, found, looked, pictures)))
    return Report(path, len(folder.runs()), pictures)
