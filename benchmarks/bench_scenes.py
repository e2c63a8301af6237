"""Measures scenes: time to load, frames per second (baseline: bare VTK), two workers, moves, and a run in `kibo`.

You can name the paths of further scenes; their moves are timed too.
"""

import statistics
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from loky import ProcessPoolExecutor
from measuring import at_least, at_most, cost_of, print_table, print_title, run_sweep, scratch

from foundry import paths
from foundry.running.cores import share_cores

SCENES = ("kibo", "office", "gallery")
SIZE = (512, 384)
FRAMES = 40
WORKERS = 2
TURNS = 15
WALKS, MOVES = 6, 25
START = {"kibo": (4.0, 20.1, 1.36), "office": (2.0, 5.0, 1.6), "gallery": (3.0, 2.0, 1.6)}


def rate(draw: Callable[[int], Any], frames: int = FRAMES) -> float:
    """Return frames per second of a drawing function, after a warm-up."""
    for number in range(5):
        draw(number)
    started = time.perf_counter()
    for number in range(frames):
        draw(number)
    return frames / (time.perf_counter() - started)


def foundry_view(name: str) -> Callable[[int], Any]:
    from foundry.worlds.camera.eye.rendering import renderer_for
    from foundry.worlds.camera.loading.stage import load_scene

    scene = load_scene(paths.assets_dir() / f"{name}.usdz")
    renderer = renderer_for(scene, width=SIZE[0], height=SIZE[1], fov_deg=70)
    eye = np.array(START[name])
    return lambda number: renderer.view(eye, 3.0 * number, 0.0)


def bare_vtk(name: str) -> Callable[[int], Any]:
    """Return a loop that only aims the camera and renders the same actors; it does not read the picture."""
    from foundry.worlds.camera.eye.rendering import direction, renderer_for
    from foundry.worlds.camera.loading.stage import load_scene

    foundry_view(name)(0)  # sets the lens
    scene = load_scene(paths.assets_dir() / f"{name}.usdz")
    renderer = renderer_for(scene, width=SIZE[0], height=SIZE[1], fov_deg=70)._view.renderer
    eye = np.array(START[name])
    lens, window = renderer.GetActiveCamera(), renderer.GetRenderWindow()

    def draw(number: int) -> None:
        lens.SetPosition(*eye)
        lens.SetFocalPoint(*(eye + direction(3.0 * number, 0.0)))
        window.SwapBuffersOn()  # as VTK does unless told otherwise; without, nothing waits for the picture
        window.Render()
        window.SwapBuffersOff()

    return draw


def worker_rate(name: str) -> float:
    share_cores(WORKERS)  # as foundry's workers do
    return rate(foundry_view(name))


def two_workers(name: str) -> float:
    """Return the sum of the frame rates of two processes that draw at the same time."""
    pools = [ProcessPoolExecutor(max_workers=1) for _ in range(WORKERS)]
    try:
        return sum(future.result() for future in [pool.submit(worker_rate, name) for pool in pools])
    finally:
        for pool in pools:
            pool.shutdown(kill_workers=True)


def load_seconds(name: str) -> float:
    from foundry.worlds.camera.loading.stage import load_scene

    started = time.perf_counter()
    load_scene(paths.assets_dir() / f"{name}.usdz")
    return time.perf_counter() - started


def move_seconds(scene: Path) -> float:
    """Return the mean time of a move in a random walk with sliding along walls."""
    from foundry.worlds.camera.body.collision import Body, Collider
    from foundry.worlds.camera.body.navigation import Navigator
    from foundry.worlds.camera.loading.stage import load_scene

    place, body, rng = load_scene(scene), Body(0.25, 1.75, 0.25), np.random.default_rng(9)
    navigator = Navigator(Collider(place), body)
    spent = 0.0
    for _ in range(WALKS):
        foot = navigator.random_foot(rng, place.bounds[:, :2], clearance_m=0.35)
        for turn, distance in rng.uniform((0, 0), (360, 3), (MOVES, 2)):
            started = time.perf_counter()
            foot = navigator.collider.move(foot, turn, distance, body, slide=True).foot
            spent += time.perf_counter() - started
    return spent / (WALKS * MOVES)


def print_moves(others: Sequence[str]) -> float:
    """Print the time of a move in shipped and other scenes; return the worst ratio to the time of a picture."""
    rows, worst = [], 0.0
    for name in SCENES:
        seconds, picture = move_seconds(paths.assets_dir() / f"{name}.usdz"), 1 / rate(foundry_view(name))
        worst = max(worst, seconds / picture)
        rows.append([name, f"{1e3 * seconds:.1f}", f"{1e3 * picture:.1f}", f"{seconds / picture:.2f}"])
    rows += [[Path(other).stem, f"{1e3 * move_seconds(Path(other)):.1f}", "", ""] for other in others]
    print_table(["scene", "ms a move", "ms a picture", "ratio"], rows)
    return worst


def run_seconds() -> float:
    """Return the time of twenty scripted decisions in `kibo`, with composing, checking and recording."""
    overrides = ("world=kibo", "model=scripted/wander", "world.steps=20", "runner.workers=1")
    with scratch() as folder:
        return run_sweep(folder / "sweep", *overrides).whole.wall_s


def first_opening(name: str) -> tuple[float, float]:
    """Return the seconds to prepare a scene, and the seconds until a new page shows it for the first time."""
    from bench_viewer import browser

    from foundry.viewer.forms import prepare
    from foundry.viewer.server import serving

    with scratch() as folder:
        made = run_sweep(folder / "sweep", f"world={name}", "model=scripted/wander", "world.steps=3").folder
        prepared = cost_of(lambda: prepare(made)).wall_s
        with browser() as page, serving(made.path) as server:
            started = time.perf_counter()
            page.goto(f"{server.url}#/run/{server.resources.catalog.overview()[0]['id']}/{made.runs()[0].id}")
            page.get_by_role("button", name="Whole scene").click()
            page.wait_for_function("() => Foundry.page?.scene.mounted")
            return prepared, time.perf_counter() - started


def main() -> None:
    print_title(
        "Scenes",
        f"{SIZE[0]} x {SIZE[1]} pixels, software drawing, {FRAMES} frames in a turn, {TURNS} turns each, one",
        "after the other. Rates are the best of them; ratios, the median over turns, are to a loop that only has VTK",
        "render the same actors and reads nothing back.",
    )
    rows, worst = [], float("inf")
    for name in SCENES:
        loaded = load_seconds(name)
        turns = [(rate(bare_vtk(name)), rate(foundry_view(name))) for _ in range(TURNS)]
        bare, ours = (max(column) for column in zip(*turns, strict=True))
        ratio = statistics.median(own / alone for alone, own in turns)
        worst = min(worst, ratio)
        both = two_workers(name)
        rows.append([name, f"{loaded:.2f}", f"{bare:.0f}", f"{ours:.0f}", f"{ratio:.2f}", f"{both:.0f}"])
    columns = ["scene", "load s", "bare VTK frames/s", "foundry frames/s", "ratio", "two workers together, frames/s"]
    print_table(columns, rows)
    moving, seconds = print_moves(sys.argv[1:]), run_seconds()
    opened = [(name, *first_opening(name)) for name in SCENES]
    print_table(["scene", "prepared, s", "shown, s"], [[name, f"{a:.2f}", f"{b:.2f}"] for name, a, b in opened])
    slowest = max(shown for _, _, shown in opened)
    judged = [
        ["time of a move over time of a picture, worst scene", f"{moving:.2f}", *at_most(moving, 1, "")],
        ["frames/s over frames/s of bare VTK, worst scene", f"{worst:.2f}", *at_least(worst, 0.9, "")],
        ["a prepared scene, first shown, slowest", f"{slowest:.2f} s", *at_most(slowest, 3, "s")],
        ["20 decisions in kibo, all in", f"{seconds:.1f} s", *at_most(seconds, 10, "s")],
    ]
    print_table(["foundry", "measured", "target", ""], judged)


if __name__ == "__main__":
    main()
