from pathlib import Path
from typing import Any

import pytest

import viewer_pages
from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from foundry.viewer.export import Exported, export
from made_up_runs import STEPS, sweep

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def exported(made_up: SweepFolder, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return export(made_up.path, tmp_path_factory.mktemp("export") / "page")


def go(page: Any, exported: Exported, address: str) -> None:
    viewer_pages.go(page, exported.page.as_uri(), address)


def test_the_exported_page_works_without_a_server_and_never_runs_what_a_model_wrote(
    page: Any, exported: Exported, made_up: SweepFolder
):
    go(page, exported, "")
    page.wait_for_selector("[data-sort='idle_rate.share']")
    page.click(f"[data-run='{made_up.runs()[0].id}'] a")
    page.wait_for_function("() => document.querySelector('.where')?.textContent.startsWith('step 1 of')")
    page.wait_for_function("() => Foundry.page.data.marked === 6")
    page.keyboard.press("x")
    page.keyboard.press("x")
    page.keyboard.press("]")
    page.wait_for_selector("details[data-kind=action] .prompt")
    assert page.text_content(".where") == f"step 4 of {STEPS}"
    assert "You are Agent 0 (female) at step 4" in page.text_content("details[data-kind=action] .prompt")
    go(page, exported, f"run/made-up/{made_up.runs()[1].id}?step=2&agent=1")
    page.wait_for_selector("details[data-kind=action] .reply", state="attached")
    assert "<script>window.hacked" in page.text_content("details[data-kind=action] .reply")
    assert page.evaluate("() => window.hacked") is None
    runs = made_up.runs()
    go(page, exported, f"compare/made-up/{runs[0].id}/{runs[2].id}")
    page.wait_for_selector(".chip[aria-pressed=true]")
    assert page.text_content(".sentence").startswith("Step 3: agent 3, with the same prompt: ")


def test_an_export_says_what_it_wrote(exported: Exported):
    files = [path for path in exported.page.parent.rglob("*") if path.is_file()]
    assert (exported.runs, exported.files) == (4, len(files))
    assert (exported.page.parent / "files" / "made-up" / "report.html").is_file()


def test_an_export_overwrites_nothing(tmp_path: Path):
    made = sweep(tmp_path / "sweep")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="Name a new or an empty folder"):
        export(made.path, tmp_path / "out")
    with pytest.raises(InputError, match="no sweep.yaml"):
        export(tmp_path / "out", tmp_path / "new")
    assert not (tmp_path / "new").exists()
