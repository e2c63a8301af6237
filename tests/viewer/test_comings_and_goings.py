"""Sweeps of worlds in which agents come and go: recorded, verified, forked, measured, and shown."""

import pytest

from commands import foundry, succeeds
from foundry.records import GridStep
from foundry.storing.store import SweepFolder
from foundry.viewer.grid.grid_view import AWAY, GridView

SMALL = ("world.half_size=4", "world.agents=5", "world.steps=12", "world.food.share=1", "world.energy.start=30")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Return a run of each of two policies that have children and kill one another."""
    cwd = tmp_path_factory.mktemp("living")
    models = "model=scripted/forager,scripted/fighter"
    succeeds("-m", "world=survival", models, "seed=0", *SMALL, "output.dir=lives", "analyze=false", cwd=cwd)
    return SweepFolder.open(cwd / "lives")


@pytest.fixture
def view(sweep: SweepFolder) -> GridView:
    grid_view = GridView(sweep.runs()[0])
    grid_view.steps.grow()
    return grid_view


@pytest.mark.slow
def test_a_run_in_which_agents_are_born_is_verified_and_continued(sweep: SweepFolder):
    cwd = sweep.path.parent
    assert "2 identical" in foundry("verify", str(sweep.path), cwd=cwd).stdout
    run = sweep.runs()[0].path
    forked = ("fork", str(run), "--at", "6", "-m", "model=scripted/sharer")
    succeeds(*forked, f"output.dir={cwd / 'on'}", "analyze=false", cwd=cwd)
    before, after = ((path / "steps.jsonl").read_bytes() for path in (run, SweepFolder.open(cwd / "on").runs()[0].path))
    shared = before[: before.index(b'{"step":6,')]
    assert after.startswith(shared) and after != before


def test_frames_tell_who_is_away_food_by_step_and_ways_from_birth(view: GridView):
    frames = view.frames(1, view.done)
    assert view.agents == 60 and len(frames["flags"]) == view.done * 60
    there = [
        sum(not flags & AWAY for flags in frames["flags"][step * 60 : step * 60 + 60]) for step in range(view.done)
    ]
    lines = [line.step for line in view.read_steps(1, view.done, GridStep)]
    assert there == [lines.count(step) for step in range(1, view.done + 1)] and there[-1] > there[0] == 5
    whole, late = view.frames(1, view.done)["food"], view.frames(5, view.done)["food"]
    assert len(whole) == view.done + 1 and len(whole[0]) == 3 * 81, "all cells at the start"
    assert late[0] == [number for changes in whole[:5] for number in changes] and late[1:] == whole[5:]
    tracks = dict(view.all_tracks())
    born = next(agent for agent in range(5, 60) if not tracks[agent]["flags"][-1] & AWAY)
    assert tracks[born] == view.track(born)
    early = tracks[born]["flags"].index(next(flags for flags in tracks[born]["flags"] if not flags & AWAY))
    assert early > 0 and set(tracks[born]["x"][:early]) == {tracks[born]["x"][early]}
    assert len(tracks[born]["x"]) == view.done + 1
