"""A sweep with all that can go wrong with names and runs, and what its report is made of."""

from typing import Any

import msgspec
import pytest

from analysis.report.material import Material, gather
from foundry.records import Counts, RunSummary
from foundry.storing.determinism import write_repeats
from foundry.storing.store import RunFolder, SweepFolder
from repeated import repeats
from walkers import Habits, make_condition, write_sweep

HOSTILE = "<script>document.title='owned'</script>&\"'"
LONG = "hf.co/someone/some-model-Instruct-GGUF:Q4_K_M"
CAUSE = "the server said <img src=x onerror=document.title='owned'> & closed"


def change(folder: RunFolder, **values: Any) -> None:
    file = folder.path / "run.json"
    summary = msgspec.json.decode(file.read_bytes(), type=RunSummary)
    file.write_bytes(msgspec.json.encode(msgspec.structs.replace(summary, **values)))


@pytest.fixture(scope="session")
def hostile_sweep(tmp_path_factory) -> SweepFolder:
    """Two models over six seeds with a baseline; one run failed, one is missing."""
    path = tmp_path_factory.mktemp("report") / "sweep"
    habits = {LONG: Habits(speak=0.7, move=0.5)}
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
def hostile(hostile_sweep) -> Material:
    return gather([hostile_sweep.path])
