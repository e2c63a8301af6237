"""A recorded sweep whose moments are probed: a fire that everyone perceives from step 3 on, and nothing remembered."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from analysis.probes.probe_tables import analyze_probe
from commands import foundry, succeeds
from foundry.storing.notes import notes_of
from foundry.storing.store import RunFolder, SweepFolder

PARTS = Path(__file__).parents[1] / "parts"
FIRE = "world.fires=[{name: great, start: 3, position: [0, 0], intensity: 1.0, radius: 1000}]"
WORLD = (
    "world.agents=4", "world.steps=7", "world.communication_distance=12", FIRE,
    "world.history={memory: 0, messages: 0}",
)  # fmt: skip
HERD_AND_AVOID = "model=scripted/herd,scripted/avoid"
MOMENTS, REPEATS = 18, 4
QUIET = ("analyze=false", "runner.workers=1")


def done(*arguments: str, cwd: Path, **variables: str) -> str:
    found = succeeds(*arguments, cwd=cwd, PYTHONPATH=str(PARTS), **variables)
    return found.stdout


def refused(*arguments: str, cwd: Path) -> str:
    """Run a command that is refused in one line; returns the line."""
    finished = foundry(*arguments, cwd=cwd, PYTHONPATH=str(PARTS))
    assert (finished.returncode, finished.stdout, finished.stderr.count("\n")) == (2, "", 1), (
        finished.stdout + finished.stderr
    )
    return finished.stderr


def write_models(folder: Path, **targets: str) -> None:
    models = folder / "mine" / "model"
    models.mkdir(parents=True)
    for name, target in targets.items():
        (models / f"{name}.yaml").write_text(f"_target_: {target}\nname: {name}\n")


def runs(path: Path) -> list[RunFolder]:
    return SweepFolder.open(path).runs()


def lines(run: RunFolder) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = msgspec.json.Decoder().decode_lines(run.steps_bytes())
    return found


def moments(folder: Path) -> list[Any]:
    found: list[Any] = msgspec.json.decode(SweepFolder.open(folder).moments_file.read_bytes())["moments"]
    return found


def note(folder: Path, number: int, text: str, **keys: Any) -> bytes:
    """Return what the page sends of a moment."""
    run, step, agent = moments(folder)[number][:3]
    of_moment = {"run": run, "step": step, "agent": agent, "moment": number}
    return msgspec.json.encode({"who": "Ada", "text": text, "tags": ["odd"], **of_moment, **keys})


def noted(folder: Path) -> list[tuple[str, int | None, int | None, int | None, str]]:
    return [(note.run, note.step, note.agent, note.moment, note.text) for note in notes_of(folder).notes]


@pytest.fixture(scope="session")
def pilot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pilot")
    done("-m", HERD_AND_AVOID, "seed=0-2", *WORLD, *QUIET, "output.dir=pilot", cwd=folder)
    return folder / "pilot"


@pytest.fixture(scope="session")
def probed(pilot: Path) -> Path:
    """Five models in moments of two, without the fire and in a mirror, too; `other` is random by another name."""
    write_models(pilot.parent, left="policies.Left", other="foundry.worlds.any.any_policies.Random")
    models = f"{HERD_AND_AVOID},scripted/random,left,other"
    settings = (f"moments={MOMENTS}", "moments_seed=3", f"repeats={REPEATS}", "edit=no_fire,mirror", *QUIET)
    told = done(
        "probe", "pilot", "--config-dir", "mine", "-m", models, *settings, "output.dir=probed", cwd=pilot.parent
    )
    assert "18 moments of 6 runs, 15 conditions, 4 repeats: at most 1,080 calls" in told
    analyze_probe(SweepFolder.open(pilot.parent / "probed"), plots=False)
    return pilot.parent / "probed"


@pytest.fixture(scope="session")
def report(probed: Path) -> Path:
    text = done("report", "probed", "--out", "page.html", cwd=probed.parent)
    assert "report of 45 runs in page.html" in text
    return probed.parent / "page.html"
