"""Makes the three pictures of the README, `python docs/take_pictures.py`, from runs that it plays.

It needs Chromium, and playwright to drive it.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from foundry.storing.store import SweepFolder
from foundry.viewer.server import serving

IMAGES = Path(__file__).resolve().parent / "images"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
COLOURS = 128
COMPARED_STEP, COMPARED_AGENT = 12, 14
READY = "() => document.querySelectorAll('.column .reply').length === 4 && document.querySelector('.verdict .go')"


def foundry(*arguments: str) -> None:
    """Run the command, as a user would."""
    subprocess.run([sys.executable, "-m", "foundry", *arguments], check=True)


def take_grid(folder: Path) -> None:
    """Take a frame of a 2D run."""
    run = folder / "grid"
    foundry("model=scripted/echo", "seed=0", "world.steps=30", f"output.dir={run}", "analyze=false")
    foundry("replay", str(run), "--steps", "12", "--out", str(folder))
    shutil.copyfile(folder / "step_0012.png", IMAGES / "grid.png")


def take_overview(folder: Path) -> None:
    """Take an overview of a 3D run, with what the model sees in its corner."""
    run = folder / "camera"
    foundry("world=kibo", "model=scripted/oracle", "seed=0", f"output.dir={run}", "analyze=false")
    foundry("replay", str(run), "--steps", "5", "--out", str(folder))
    Image.open(folder / "step_0005.png").save(IMAGES / "overview.jpg", quality=90)


def take_comparison(folder: Path) -> None:
    """Take the page that shows two runs side by side."""
    compared = folder / "compared"
    models = "model=scripted/avoid,scripted/herd"
    foundry("-m", models, "seed=0", "world.agents=20", "world.steps=30", f"output.dir={compared}", "analyze=false")
    runs = "/".join(run.id for run in SweepFolder.open(compared).runs())
    with serving(compared) as server, sync_playwright() as playwright:
        found = next(filter(None, map(shutil.which, BROWSERS)))
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1180, "height": 760})
        page.goto(f"{server.url}#/compare/compared/{runs}?step={COMPARED_STEP}&agent={COMPARED_AGENT}")
        page.wait_for_function(READY)
        taken = Image.open(io.BytesIO(page.screenshot(full_page=True))).convert("RGB")
        browser.close()
    taken.quantize(COLOURS, dither=Image.Dither.NONE).save(IMAGES / "compare.png", optimize=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        for take in (take_grid, take_overview, take_comparison):
            take(Path(scratch))
