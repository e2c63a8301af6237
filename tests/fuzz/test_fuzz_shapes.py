"""A sweep whose settings have shapes that nothing writes is used, or refused in one line; never a traceback."""

import datetime
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import yaml

from commands import foundry, succeeds
from every_command import COMMANDS, words
from foundry.storing.store import SweepFolder, to_yaml
from json_parts import places, put

SMALL = ("world.agents=2", "world.steps=3", "record.frames=2", "analyze=false")
MIXES = "mix/scripted/herd@50%+scripted/stay@50%"
ODD: tuple[Any, ...] = (
    *(None, True, 3, -1, 2**70, 0.5, float("nan"), "", "text", "${oc.env:HOME}", "../x", "???", [], [1], ["a"], [[]]),
    *({}, {"a": 1}, {1: 2}, {"_target_": "os.system"}, {"name": []}, datetime.date(2026, 1, 1), b"bytes"),
)  # fmt: skip
QUICK = ("status", "verify", "resume", "fork", "bundle", "view", "replay", "label", "diff")
ALL = (*QUICK, "analyze", "report")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Forks with two models, so that every block a sweep can have is there."""
    folder = tmp_path_factory.mktemp("shapes")
    succeeds("model=scripted/herd", *SMALL, "output.dir=origin", cwd=folder)
    (run,) = SweepFolder.open(folder / "origin").runs()
    fork = ("fork", str(run.path), "--at", "2", "-m", f"model=scripted/herd,{MIXES}", "analyze=false")
    succeeds(*fork, "output.dir=out", cwd=folder)
    return folder / "out"


def fuzz(sweep: Path, number: int, names: Sequence[str]) -> dict[str, int]:
    """Change one part after the other and run a command on it; returns how often each was refused."""
    run = sorted(path.name for path in (sweep / "runs").iterdir())[0]
    files = {
        "sweep.yaml": yaml.safe_load((sweep / "sweep.yaml").read_text()),
        f"runs/{run}/run.json": msgspec.json.decode((sweep / "runs" / run / "run.json").read_bytes()),
        f"runs/{run}/config.yaml": yaml.safe_load((sweep / "runs" / run / "config.yaml").read_text()),
    }
    # Only models read the texts of prompts and schemas.
    known = {name: list(places(content, skip=("schemas", "template"))) for name, content in files.items()}
    rng, refused = np.random.default_rng(5), dict.fromkeys(names, 0)
    for turn in range(number):
        name = "sweep.yaml" if turn % 4 else list(files)[1 + turn // 4 % 2]
        path, value = known[name][rng.integers(len(known[name]))], ODD[rng.integers(len(ODD))]
        command = names[rng.integers(len(names))]
        with tempfile.TemporaryDirectory() as scratch:
            out = Path(shutil.copytree(sweep, Path(scratch) / "out"))
            content = put(files[name], path, value)
            (out / name).write_text(to_text(name, content), encoding="utf-8")
            if turn % 3 == 0:
                (out / "runs" / run / "run.json").unlink()
            case = f"{command}: {name} {path} = {value!r}"
            try:
                done = foundry(*words(COMMANDS[command], out / "runs" / run), cwd=Path(scratch))
            except Exception as error:
                raise AssertionError(case) from error
        assert done.returncode in (0, 2, 3), f"{case}: {done.returncode} {done.stderr}"
        assert "Traceback" not in done.stderr, f"{case}: {done.stderr}"
        assert done.returncode != 2 or done.stderr.count("\n") == 1, f"{case}: {done.stderr}"
        refused[command] += done.returncode != 0
    return refused


def to_text(name: str, content: Any) -> str:
    if name.endswith(".yaml"):
        return to_yaml(content)
    return msgspec.json.encode(content, enc_hook=str).decode() if content != 2**70 else str(2**70)


AT_LENGTH = (pytest.mark.exhaustive, pytest.mark.timeout(3600))


@pytest.mark.parametrize(
    ("number", "names"),
    [
        pytest.param(20, QUICK, marks=pytest.mark.slow, id="a few"),
        pytest.param(1_500, ALL, marks=AT_LENGTH, id="at length"),
    ],
)
def test_settings_of_odd_shapes_are_used_or_refused_in_one_line(number: int, names: Sequence[str], sweep: Path):
    refused = fuzz(sweep, number, names)
    assert sum(refused.values()) > number / 4
    assert all(refused.values()) or names is QUICK
