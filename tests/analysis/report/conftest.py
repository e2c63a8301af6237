"""A sweep with all that can go wrong with names and runs, and the page that is made of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from analysis.report import render
from analysis.report.material import Material, gather
from foundry.records import Counts, RunSummary
from foundry.storing.determinism import write_repeats
from foundry.storing.store import RunFolder, SweepFolder
from repeated import repeats
from report_pages import narrowed

HOSTILE = "<script>document.title='owned'</script>&\"'"
LONG = "hf.co/someone/some-model-Instruct-GGUF:Q4_K_M"
CAUSE = "the server said <img src=x onerror=document.title='owned'> & closed"
SHOWN = ("idle_rate.", "warning.")
"""The signatures that the pages of tests show: drawing all of them takes long."""


def change(folder: RunFolder, **values: Any) -> None:
    """Write a run's summary anew."""
    file = folder.path / "run.json"
    summary = msgspec.json.decode(file.read_bytes(), type=RunSummary)
    file.write_bytes(msgspec.json.encode(msgspec.structs.replace(summary, **values)))


@pytest.fixture(scope="session")
def hostile_sweep(
    tmp_path_factory: pytest.TempPathFactory,
    write_sweep: Callable[..., SweepFolder],
    make_condition: Callable[..., Any],
    make_habits: Callable[..., Any],
) -> SweepFolder:
    """Two models over six seeds with a baseline; one run failed, one is missing."""
    path = tmp_path_factory.mktemp("report") / "sweep"
    habits = {LONG: make_habits(speak=0.7, move=0.5)}
    folder = write_sweep(path, [make_condition(model, range(6)) for model in (HOSTILE, LONG)], habits)
    write_sweep(folder.baselines_dir, [make_condition("scripted/stay", range(6))])
    runs = folder.runs()
    counts = Counts(calls=300, steps=150, outcomes={"chosen": 140, "unreadable": 10}, model_s=1.5)
    for run in runs:
        change(run, counts=counts, model_digest="f00d" * 16)
    change(runs[1], status="failed", error=CAUSE, error_type="TransientError")
    write_repeats(folder, [repeats(LONG, alone=10, loaded=8), repeats(HOSTILE, alone=10, loaded=10)])
    for file in runs[8].path.iterdir():
        file.unlink()
    runs[8].path.rmdir()
    return folder


@pytest.fixture(scope="session")
def five_models(
    tmp_path_factory: pytest.TempPathFactory,
    write_sweep: Callable[..., SweepFolder],
    make_condition: Callable[..., Any],
    make_habits: Callable[..., Any],
) -> Path:
    """The page of five models with long names over ten seeds, with every signature."""
    names = [f"hf.co/someone/some-model-{size}B-Instruct-GGUF:Q4_K_M" for size in (1, 4, 8, 14, 32)]
    conditions = [make_condition(name, range(10)) for name in names]
    habits = {name: make_habits(speak=0.2 * place, move=0.9 - 0.2 * place) for place, name in enumerate(names)}
    folder = write_sweep(tmp_path_factory.mktemp("five") / "sweep", conditions, habits)
    page = render(gather([folder.path]), folder.path, folder.analysis_dir / "plots")
    folder.report_file.write_text(page, encoding="utf-8")
    return folder.report_file


@pytest.fixture(scope="session")
def hostile(hostile_sweep: SweepFolder) -> Material:
    """What the report of that sweep is made of."""
    return gather([hostile_sweep.path])


@pytest.fixture(scope="session")
def narrow(hostile: Material) -> Material:
    """The same with a few signatures alone."""
    return narrowed(hostile, SHOWN)


@pytest.fixture(scope="session")
def page_file(hostile_sweep: SweepFolder, narrow: Material) -> Path:
    """The page of that sweep."""
    page = render(narrow, hostile_sweep.path, hostile_sweep.analysis_dir / "plots")
    hostile_sweep.report_file.write_text(page, encoding="utf-8")
    return hostile_sweep.report_file
