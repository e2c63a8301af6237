"""The page on which people label, in a real browser: by keys, by touch, two people at once, and when it is killed."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import axe
from browser import browser_page
from commands import started, succeeds
from foundry.labels.definition import label_named
from foundry.labels.desk import LabelDesk
from foundry.labels.folder import LabelFolder
from foundry.labels.sampling import Sample, SampledText, Stratum
from foundry.storing.store import SweepFolder
from foundry.viewer.http import running
from foundry.viewer.people.label_server import LabelServer

pytestmark = pytest.mark.browser
TEXTS = 12
WARNING = label_named("warning")


@pytest.fixture
def folder(tmp_path: Path) -> LabelFolder:
    return LabelFolder(tmp_path / "warning", "warning")


@pytest.fixture
def server(folder: LabelFolder) -> Iterator[LabelServer]:
    drawn = tuple(
        SampledText(
            item=f"qwen-s{number}/1/0/message", stratum=0, text=f"fire <b>{number}</b>\nnear me",
            context={"fires": ("f1",)}, run=f"qwen-s{number}", seed=number, step=1, agent=0, kind="message",
        )
        for number in range(TEXTS)
    )  # fmt: skip
    strata = (Stratum(draw=0, model="qwen", says="yes", size=TEXTS, probability=1.0),)
    sample = Sample(label="warning", question_sha256=WARNING.question_sha256, seed=0, strata=strata, drawn=drawn)
    with running(LabelServer(LabelDesk(folder, WARNING, sample), "label: warning")) as server:
        yield server


def begin(page: Any, url: str, person: str, done: int = 0) -> None:
    page.goto(url)
    page.get_by_label("Your name here").fill(person)
    page.keyboard.press("Enter")
    wait(page, done)


def wait(page: Any, done: int) -> None:
    page.wait_for_function("n => document.querySelector('#progress').textContent.includes(`: ${n} of`)", arg=done)


def end(page: Any) -> None:
    page.get_by_role("button", name="End for today").click()
    page.wait_for_selector("text=That is all for now")


def heard(page: Any) -> str:
    return str(page.get_by_role("status").inner_text())


def test_a_person_labels_by_keys_takes_one_label_back_and_reads_no_name_of_a_model(
    server: LabelServer, folder: LabelFolder
):
    with browser_page() as page:
        page.goto(server.url)
        page.get_by_label("Your name here").fill("no name")
        page.keyboard.press("Enter")
        assert "'no name' is not a valid name" in page.locator(".warning").inner_text()
        axe.check(page)
        begin(page, server.url, "ana")
        assert (
            "fire <b>" in page.locator(".text").inner_text() and "called: f1." in page.locator(".question").inner_text()
        )
        assert "qwen" not in page.content()
        axe.check(page)
        assert heard(page).startswith("Text 1 of 12: fire <b>")
        for done in range(8):
            page.keyboard.press("ynu"[done % 3])
            wait(page, done + 1)
        text = page.locator(".text").inner_text()
        assert heard(page).startswith("Your label no is saved. Text 9 of 12: fire <b>")
        page.keyboard.press("Backspace")
        wait(page, 7)
        assert heard(page).startswith("Your last label is removed. Text 8 of 12: fire <b>")
        assert page.locator(".text").inner_text() != text, "the text of the label that was taken back is shown again"
        page.keyboard.press("y")
        wait(page, 8)
        assert page.locator(".text").inner_text() == text
        end(page)
    given = list(folder.labels_by("ana").values())
    assert (len(given), given.count("yes"), given.count("no"), given.count("unclear")) == (8, 4, 2, 2)
    assert server.ended.is_set()


def test_labels_by_touch_on_a_small_screen_and_all_texts_end_with_thanks(server: LabelServer, folder: LabelFolder):
    with browser_page(width=390, height=844, touch=True) as page:
        begin(page, server.url, "ben")
        for done in range(TEXTS):
            page.get_by_role("button", name="no", exact=False).first.tap()
            wait(page, done + 1)
            if done == 10:
                page.get_by_role("button", name="Undo my last label").tap()
                wait(page, done)
                page.get_by_role("button", name="yes").tap()
                wait(page, done + 1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), "nothing is cut off at the side"
        page.wait_for_selector("text=All texts are labelled")
    assert sorted(set(folder.labels_by("ben").values())) == ["no", "yes"] and len(folder.labels_by("ben")) == TEXTS


def test_the_command_goes_on_until_everybody_who_opened_the_page_has_ended_for_today(
    server: LabelServer, folder: LabelFolder
):
    with browser_page() as ana, browser_page() as ben:
        begin(ana, server.url, "ana")
        begin(ben, server.url, "ben")
        end(ana)
        axe.check(ana)
        ana.keyboard.press("y")
        ben.keyboard.press("n")
        wait(ben, 1)
        assert not server.ended.is_set(), "ben still labels"
        ana.get_by_role("button", name="Go on").click()
        wait(ana, 0)
        end(ben)
        assert not server.ended.is_set(), "ana came back"
        end(ana)
        assert server.ended.is_set()
        assert ana.get_by_role("button", name="Go on").count() == 0, "nobody is there any more"
    assert (list(folder.labels_by("ana").values()), list(folder.labels_by("ben").values())) == ([], ["no"])


def test_killing_the_command_loses_no_label_that_the_page_confirmed(tmp_path: Path):
    command = ("model=scripted/avoid", "seed=0", "world.agents=5", "world.steps=6", "analyze=false", "output.dir=talk")
    succeeds("-m", *command, cwd=tmp_path)
    asking = ("play", "talk", "--label", "contradiction", "--per-model", "20", "--no-browser", "--port", "0")
    with started(*asking, cwd=tmp_path) as process, browser_page(allowed_errors=("ERR_CONNECTION_REFUSED",)) as page:
        assert process.stdout is not None
        begin(page, next(line for line in process.stdout if "label at" in line).split()[2], "ana")
        page.keyboard.press("y")
        page.wait_for_function("() => !document.querySelector('#progress').textContent.includes(': 0 of')")
        confirmed = int(page.locator("#progress").inner_text().split()[1])
        process.kill()
        process.wait()
        page.keyboard.press("y")
        page.wait_for_selector("text=The command that served this page has ended")
    kept = LabelFolder.of(SweepFolder.open(tmp_path / "talk"), "contradiction").labels_by("ana")
    assert list(kept.values()) == ["yes"] * confirmed and confirmed > 0
