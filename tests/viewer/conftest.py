from collections.abc import Iterator
from typing import Any

import pytest

from browser import browser_page, put_aside, taken_up
from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer, serving
from made_up_runs import Playing, whole_sweep


@pytest.fixture(scope="session")
def made_up(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Two models and two seeds: mishaps; hostile texts; another way; a failed run. Read only."""
    made = whole_sweep(tmp_path_factory.mktemp("viewer") / "made up")
    failed = Playing(made.runs()[3])
    failed.play(1, 2)
    failed.end("the server is gone <b>for good</b>")
    made.analysis_dir.mkdir()
    rows = [f"{run.id},{value}" for run, value in zip(made.runs(), ("0.25", "1e-3", "", "nan"), strict=True)]
    made.signatures_path.write_text("run,idle_rate.share\n" + "\n".join(rows) + "\n", encoding="utf-8")
    made.report_file.write_text("<!doctype html><title>report</title>", encoding="utf-8")
    return made


@pytest.fixture(scope="session")
def server(made_up: SweepFolder) -> Iterator[ViewServer]:
    with serving(made_up.path) as running:
        yield running


@pytest.fixture(scope="session")
def shared_page() -> Iterator[Any]:
    with browser_page() as page, put_aside():
        yield page


@pytest.fixture
def page(shared_page: Any) -> Iterator[Any]:
    """One page for all tests that need no console of their own: a new one costs more than most tests."""
    with taken_up():
        yield shared_page
        shared_page.evaluate("() => window.Foundry?.page?.dispose?.()")
        shared_page.goto("about:blank")  # nothing is asked of a server that ends before the page does
        shared_page.set_viewport_size({"width": 1280, "height": 900})
        shared_page.emulate_media(color_scheme="light")
