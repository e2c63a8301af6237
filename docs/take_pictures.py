"""Makes the pictures of the documents and the example report, `python docs/take_pictures.py`, from runs that it plays.

It needs Chromium, and playwright to drive it.
"""

import contextlib
import io
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from foundry.storing.store import SweepFolder
from foundry.viewer.server import serving

IMAGES = Path(__file__).resolve().parent / "images"
EXAMPLE = IMAGES.parent / "example_report.html"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
READY = "() => ['[data-text]', '.verdict b', '[data-lane]'].every((one) => document.querySelector(one))"


def foundry(*arguments: str, folder: Path | None = None) -> None:
    """Run the command in a folder, as a user would."""
    subprocess.run([sys.executable, "-m", "foundry", *arguments], check=True, cwd=folder)


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
    with serving(compared) as server, opened(1440, 900) as page:
        page.goto(f"{server.url}#/compare/compared/{runs}")
        page.wait_for_function(READY)
        keep(page.screenshot(), "compare.png")


def take_report(folder: Path) -> None:
    """Write the example report; take its first screen and its pictures of the world."""
    models = "model=scripted/random,scripted/avoid,scripted/herd"
    foundry("-m", models, "seed=0-19", "output.dir=example", "analyze=false", folder=folder)
    foundry("analyze", "example", "--baselines", folder=folder)
    foundry("report", "example", folder=folder)
    shutil.copyfile(folder / "example" / "report.html", EXAMPLE)
    with opened(1180, 1150) as page:
        page.goto(EXAMPLE.as_uri())
        keep(page.screenshot(), "report.png")
        page.locator("#world > summary").click()
        keep(page.locator("#world .figures").screenshot(), "report_plots.png")


@contextlib.contextmanager
def opened(width: int, height: int) -> Iterator[Page]:
    """Open a browser with an empty page of a size in pixels."""
    with sync_playwright() as playwright:
        found = next(filter(None, map(shutil.which, BROWSERS)))
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(0)
        yield page
        browser.close()


def keep(screenshot: bytes, name: str) -> None:
    """Keep a screenshot as a PNG of the 256 colours that cover its colours best: rare ones of marks stay apart."""
    picture = Image.open(io.BytesIO(screenshot)).convert("RGB")
    found = picture.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=8, dither=Image.Dither.NONE)
    found.save(IMAGES / name, optimize=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        for take in (take_grid, take_overview, take_comparison, take_report):
            take(Path(scratch))
