"""`view=live` from the command line: a page while the sweep runs, and the same records."""

from __future__ import annotations

from pathlib import Path

import pytest

from commands import records
from foundry.cli import run

SHORT = ("model=scripted/avoid", "seed=3", "world.agents=3", "world.steps=4", "analyze=false")


@pytest.mark.slow
def test_a_watched_run_has_the_records_of_one_that_is_not(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run([*SHORT, "output.dir=plain"]) == 0
    capsys.readouterr()
    assert run([*SHORT, "output.dir=watched", "view=live"]) == 0
    assert "watch at http://127.0.0.1:" in capsys.readouterr().out
    assert records(Path("watched")) == records(Path("plain"))


def test_another_view_is_refused_before_anything_is_written(workspace: Path, capsys: pytest.CaptureFixture[str]):
    assert run([*SHORT, "output.dir=there", "view=lve"]) == 2
    assert "view=lve is neither null nor live" in capsys.readouterr().err
    assert not Path("there").exists()
