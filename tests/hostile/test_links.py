"""A sweep's folder that came from someone: what is no file or folder of its own is refused, unread and unwritten."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from commands import foundry, statuses
from foundry.errors import RecordError
from foundry.storing.store import SweepFolder, sweeps_in

SMALL = ("world.agents=2", "world.steps=2", "record.frames=1", "analyze=false")
SECRET = "the only copy\n"


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small sweep with pictures."""
    folder = tmp_path_factory.mktemp("links")
    done = foundry("model=scripted/herd", *SMALL, "output.dir=out", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.fixture
def sweep(played: Path, tmp_path: Path) -> Path:
    """A copy of it, beside what is none of its business."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "secret").write_text(SECRET)
    return Path(shutil.copytree(played, tmp_path / "out"))


def run_folder(sweep: Path) -> Path:
    (run,) = (sweep / "runs").iterdir()
    return run


def put(place: Path, make: Callable[[Path], object]) -> None:
    """Put something in the place of what is there."""
    if place.is_dir():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    place.parent.mkdir(exist_ok=True)
    make(place)


def commands(sweep: Path) -> dict[str, tuple[str, ...]]:
    """Return every command that reads a sweep's folder."""
    run = str(run_folder(sweep))
    return {
        "status": ("status", "out"),
        "verify": ("verify", "out", "--workers", "1"),
        "diff": ("diff", run, run),
        "fork": ("fork", run, "--at", "2", "analyze=false", "output.dir=forked"),
        "bundle": ("bundle", "out", "out.tar.zst"),
        "analyze": ("analyze", "out"),
        "report": ("report", "out"),
        "view": ("view", "out", "--export", "page"),
        "replay": ("replay", run, "--steps", "1"),
        "resume": ("resume", "out"),
        "label": ("label", "out", "--model", "scripted/stay"),
        "plan": ("plan", "model=scripted/herd", "output.dir=out"),
        "power": ("plan", "--pilot", "out"),
        "probe": ("probe", "out", "moments=1", "repeats=1", "model=scripted/stay", "output.dir=again"),
        "replayed": ("model=replay/out", *SMALL, "output.dir=again"),
    }


def check_refused(command: tuple[str, ...], sweep: Path) -> None:
    """Run a command and check that it says what is refused, and that nothing else was read or written."""
    done = foundry(*command, cwd=sweep.parent)
    assert done.returncode == 2 and "is refused: it is a" in done.stderr, (command, done.stdout, done.stderr)
    assert done.stderr.count("\n") == 1
    elsewhere = sweep.parent / "elsewhere"
    assert [file.name for file in elsewhere.iterdir()] == ["secret"]
    assert (elsewhere / "secret").read_text() == SECRET
    assert not any((sweep.parent / made).exists() for made in ("out.tar.zst", "forked", "again"))


COMMANDS = [
    "status", "verify", "diff", "fork", "bundle", "analyze", "report", "view", "replay", "resume", "label", "probe"
]  # fmt: skip
READERS = [one for one in COMMANDS if one != "resume"]
"""Commands that read what was recorded; `resume` begins anew the runs that have not ended."""


@pytest.mark.parametrize("command", [*COMMANDS, "plan", "power", "replayed"])
def test_a_run_that_is_a_link_is_refused_by_every_command(command: str, sweep: Path):
    asked = commands(sweep)[command]
    run = run_folder(sweep)
    run.rename(sweep.parent / "moved")
    run.symlink_to(sweep.parent / "moved")
    check_refused(asked, sweep)


@pytest.mark.parametrize("command", READERS)
@pytest.mark.parametrize("kind", ["link", "pipe"])
def test_steps_that_are_a_link_or_a_pipe_are_refused_by_every_command_that_reads_them(
    command: str, kind: str, sweep: Path
):
    makers = {"link": lambda place: place.symlink_to(sweep.parent / "elsewhere" / "secret"), "pipe": os.mkfifo}
    put(run_folder(sweep) / "steps.jsonl", makers[kind])
    check_refused(commands(sweep)[command], sweep)


FILES = (
    "steps.jsonl",
    "messages.jsonl",
    "calls.jsonl.zst",
    "config.yaml",
    "run.json",
    "frames/step_0001.png",
    "frames",
)


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("command", ["verify", "bundle", "status", "probe", "view"])
def test_no_file_of_a_run_may_be_a_link(name: str, command: str, sweep: Path):
    if "/" in name and command in ("status", "probe", "view"):
        pytest.skip("it reads no picture")
    put(run_folder(sweep) / name, lambda place: place.symlink_to(sweep.parent / "elsewhere" / "secret"))
    check_refused(commands(sweep)[command], sweep)


PLACES = ("sweep.yaml", "runs", "analysis", "progress", "locks", "origins", "viewer", "baselines", "scenes.json")
INNER = ("analysis/signatures.csv", "analysis/plots", "analysis/replay", "progress/0-0.json", "origins/a-at2.jsonl.zst")


@pytest.mark.parametrize("name", [*PLACES, *INNER, "report.html"])
def test_nothing_beside_the_runs_may_be_a_link(name: str, sweep: Path):
    run = run_folder(sweep)
    put(sweep / name, lambda place: place.symlink_to(sweep.parent / "elsewhere"))
    if run.exists():
        (run / "run.json").unlink()
    for command in (("resume", "out"), ("analyze", "out")):
        check_refused(command, sweep)


def test_a_socket_and_a_device_are_refused(sweep: Path, monkeypatch: pytest.MonkeyPatch):
    place = run_folder(sweep) / "steps.jsonl"
    monkeypatch.chdir(place.parent)  # the name of a socket is short
    with socket.socket(socket.AF_UNIX) as listening:
        put(place, lambda place: listening.bind(place.name))
        check_refused(commands(sweep)["verify"], sweep)
    put(place, lambda place: place.symlink_to("/dev/zero"))
    check_refused(commands(sweep)["analyze"], sweep)


def test_the_folder_of_a_sweep_may_be_a_link_and_its_baselines_may_not(sweep: Path):
    sweep.rename(sweep.parent / "data")
    sweep.symlink_to(sweep.parent / "data")
    (run_folder(sweep) / "run.json").unlink()
    for command in ("resume", "verify", "bundle"):
        done = foundry(*commands(sweep)[command], cwd=sweep.parent)
        assert done.returncode == 0, done.stderr
    assert statuses(sweep) == ["complete"]
    (sweep / "baselines").symlink_to(sweep.parent / "data")
    assert set(sweeps_in(sweep.parent)) == {sweep, sweep.parent / "data"}
    with pytest.raises(RecordError, match="baselines' is refused"):
        SweepFolder.open(sweep)


def test_nothing_is_written_where_a_link_in_its_place_leads(sweep: Path):
    run, elsewhere = run_folder(sweep), sweep.parent / "elsewhere"
    steps = (run / "steps.jsonl").read_bytes()
    for name in ("steps.jsonl", "calls.jsonl.zst", "config.yaml"):
        put(run / name, lambda place: place.symlink_to(elsewhere / "secret"))
    put(run / "frames", lambda place: place.symlink_to(elsewhere))
    (run / "run.json").unlink()
    assert foundry("resume", "out", cwd=sweep.parent).returncode == 0
    assert [file.name for file in elsewhere.iterdir()] == ["secret"]
    assert (elsewhere / "secret").read_text() == SECRET and (run / "steps.jsonl").read_bytes() == steps
    assert (run / "frames").is_dir() and not any(file.is_symlink() for file in run.iterdir())
