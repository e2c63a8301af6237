"""Hydra's own launchers start a job for each run; the records are those of the plain command."""

from __future__ import annotations

from pathlib import Path

import pytest

from commands import SMALL, calls, foundry, records, started, statuses

pytestmark = pytest.mark.cluster
SWEEP = ("-m", "model=scripted/random,scripted/herd", "seed=0", *SMALL)
LAUNCHERS = {
    "hydra_submitit_launcher": ("hydra/launcher=submitit_local", "hydra.launcher.submitit_folder=jobs"),
    "hydra_joblib_launcher": ("hydra/launcher=joblib", "hydra.launcher.n_jobs=2"),
}


@pytest.mark.parametrize("plugin", LAUNCHERS)
def test_a_launcher_of_hydra_runs_the_same_sweep(plugin: str, tmp_path: Path):
    pytest.importorskip(f"hydra_plugins.{plugin}", reason=f"pip install {plugin.replace('_', '-')}")
    assert foundry(*SWEEP, "output.dir=plain", cwd=tmp_path).returncode == 0
    with started(*SWEEP, "output.dir=launched", *LAUNCHERS[plugin], cwd=tmp_path) as process:
        output, _ = process.communicate()
    assert process.returncode == 0, output
    assert statuses(tmp_path / "launched") == ["complete"] * 2
    assert records(tmp_path / "launched") == records(tmp_path / "plain")
    assert calls(tmp_path / "launched") == calls(tmp_path / "plain")
