"""Configurations of the user's own folder and of a record: what grows without bound is refused, nothing runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from commands import foundry
from foundry.storing.store import SweepFolder

LAUGHS = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12)
)
BOMBS = {
    "laughs": (LAUGHS, "more than"),
    "deep": ("a: " + "[" * 20_000 + "]" * 20_000, "nests deeper"),
    "itself": ("a: &a [*a]\n", "holds itself"),
    "code": ("x: !!python/object/apply:os.system [touch canary]\n", "cannot be read"),
    "binary": ("\x00\x01", "cannot be read"),
}  # fmt: skip
SMALL = ("model=scripted/random", "world.agents=2", "world.steps=2", "output.dir=out", "analyze=false")


@pytest.mark.parametrize("name", BOMBS)
def test_a_bomb_in_a_folder_of_configurations_is_refused_before_it_grows(name: str, tmp_path: Path):
    text, expected = BOMBS[name]
    (tmp_path / "mine" / "model").mkdir(parents=True)
    (tmp_path / "mine" / "model" / "bomb.yaml").write_text(text)
    done = foundry("--config-dir", "mine", "model=bomb", cwd=tmp_path)
    assert done.returncode == 2 and "bomb.yaml" in done.stderr and expected in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "outputs").exists()


def test_a_file_that_includes_itself_by_way_of_another_is_refused_in_one_line(tmp_path: Path):
    (tmp_path / "mine" / "model").mkdir(parents=True)
    (tmp_path / "mine" / "model" / "here.yaml").write_text("defaults: [there]\n")
    (tmp_path / "mine" / "model" / "there.yaml").write_text("defaults: [here]\n")
    done = foundry("--config-dir", "mine", "model=here", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1) and "includes itself" in done.stderr


@pytest.mark.parametrize(
    "part", ["world", *(pytest.param(one, marks=pytest.mark.exhaustive) for one in ("model", "prompt", "runner"))]
)
def test_nothing_that_a_record_names_is_run(part: str, tmp_path: Path):
    assert foundry(*SMALL, cwd=tmp_path).returncode == 0
    file, canary = tmp_path / "out" / "sweep.yaml", tmp_path / "canary"
    (run,) = SweepFolder.open(tmp_path / "out").runs()
    own = {"runner": "foundry.running.local.LocalRunner"}.get(part) or run.config()[part]["_target_"]
    text = file.read_text()
    assert f"_target_: {own}\n" in text
    file.write_text(text.replace(f"_target_: {own}\n", "_target_: pathlib.Path.touch\n").replace(own, "os.system"))
    (run.path / "run.json").unlink()
    where = str(run.path)
    for command in (("verify", "out"), ("status", "out"), ("replay", where), ("fork", where, "--at", "1")):
        done = foundry(*command, cwd=tmp_path)
        assert "Traceback" not in done.stderr
        builds_it = command[0] != "status" and part != "runner" and (command[0] != "replay" or part == "world")
        assert done.returncode == 2 or not builds_it
    assert foundry("resume", "out", cwd=tmp_path).returncode == 2
    assert not canary.exists() and not run.ended
