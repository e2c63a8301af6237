"""A sweep's folder that came from someone: what is no file or folder of its own is refused, unread and unwritten."""

import os
import shutil
import socket
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import pytest

from commands import refusal, statuses, succeeds
from every_command import COMMANDS, words
from foundry.errors import RecordError
from foundry.storing.store import SweepFolder, sweeps_in

SMALL = ("world.agents=2", "world.steps=2", "record.frames=1", "analyze=false")
SECRET = "the only copy\n"


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("links")
    succeeds("model=scripted/herd", *SMALL, "output.dir=out", cwd=folder)
    return folder / "out"


@pytest.fixture
def sweep(played: Path, tmp_path: Path) -> Path:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "secret").write_text(SECRET)
    return Path(shutil.copytree(played, tmp_path / "out"))


def run_folder(sweep: Path) -> Path:
    (run,) = (sweep / "runs").iterdir()
    return run


def put(place: Path, make: Callable[[Path], object]) -> None:
    if place.is_dir():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    place.parent.mkdir(exist_ok=True)
    make(place)


ALL = {
    **COMMANDS,
    "plan": "plan model=scripted/herd output.dir=out",
    "power": "plan --pilot out",
    "replayed": f"model=replay/out {' '.join(SMALL)} output.dir=again",
}
READERS = [name for name in COMMANDS if name != "resume"]
"""Commands that read all that was recorded; `resume` begins anew the runs that have not ended."""


def check_refused(names: Iterable[str], sweep: Path) -> None:
    """Run commands and check that each says what is refused, and that nothing else was read or written."""
    for name in names:
        assert "is refused: it is a" in refusal(*words(ALL[name], run_folder(sweep)), cwd=sweep.parent)
        check_untouched(sweep.parent / "elsewhere")
        assert not any((sweep.parent / made).exists() for made in ("out.tar.zst", "forked", "again"))


def check_untouched(elsewhere: Path) -> None:
    assert [file.name for file in elsewhere.iterdir()] == ["secret"]
    assert (elsewhere / "secret").read_text() == SECRET


def test_a_run_that_is_a_link_is_refused_by_every_command(sweep: Path):
    run = run_folder(sweep)
    run.rename(sweep.parent / "moved")
    run.symlink_to(sweep.parent / "moved")
    check_refused(ALL, sweep)


FILES = ("messages.jsonl", "calls.jsonl.zst", "config.yaml", "run.json", "frames")


@pytest.mark.parametrize(
    ("name", "kind", "names"),
    [
        ("steps.jsonl", "link", READERS),
        ("steps.jsonl", "pipe", ("verify", "analyze")),
        *((name, "link", ("verify", "bundle", "view")) for name in FILES),
        ("frames/step_0001.png", "link", ("verify", "bundle")),
    ],
)
def test_no_file_of_a_run_may_be_a_link_or_a_pipe(name: str, kind: str, names: Sequence[str], sweep: Path):
    makers = {"link": lambda place: place.symlink_to(sweep.parent / "elsewhere" / "secret"), "pipe": os.mkfifo}
    put(run_folder(sweep) / name, makers[kind])
    check_refused(names, sweep)


PLACES = ("sweep.yaml", "runs", "analysis", "progress", "locks", "origins", "viewer", "baselines", "scenes.json")
INNER = ("analysis/signatures.csv", "analysis/plots", "analysis/replay", "progress/0-0.json", "origins/a-at2.jsonl.zst")


@pytest.mark.parametrize("name", [*PLACES, *INNER, "report.html"])
def test_nothing_beside_the_runs_may_be_a_link(name: str, sweep: Path):
    run = run_folder(sweep)
    put(sweep / name, lambda place: place.symlink_to(sweep.parent / "elsewhere"))
    if run.exists():
        (run / "run.json").unlink()
    check_refused(("resume", "analyze"), sweep)


def test_a_socket_and_a_device_are_refused(sweep: Path, monkeypatch: pytest.MonkeyPatch):
    place = run_folder(sweep) / "steps.jsonl"
    monkeypatch.chdir(place.parent)  # the name of a socket is short
    with socket.socket(socket.AF_UNIX) as listening:
        put(place, lambda place: listening.bind(place.name))
        check_refused(["verify"], sweep)
    put(place, lambda place: place.symlink_to("/dev/zero"))
    check_refused(["analyze"], sweep)


def test_the_folder_of_a_sweep_may_be_a_link_and_its_baselines_may_not(sweep: Path):
    sweep.rename(sweep.parent / "data")
    sweep.symlink_to(sweep.parent / "data")
    (run_folder(sweep) / "run.json").unlink()
    for command in ("resume", "verify", "bundle"):
        succeeds(*COMMANDS[command].split(), cwd=sweep.parent)
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
    succeeds("resume", "out", cwd=sweep.parent)
    check_untouched(elsewhere)
    assert (run / "steps.jsonl").read_bytes() == steps
    assert (run / "frames").is_dir() and not any(file.is_symlink() for file in run.iterdir())
