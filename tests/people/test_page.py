"""The page of `foundry play` in a real browser, by the keyboard alone."""

import asyncio
import base64
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

import axe
from browser import browser_page
from foundry.models.base import ChatMessage, Request
from foundry.models.human.desk import Desk, seated
from foundry.models.human.human_model import HumanModel
from foundry.viewer.http import running
from foundry.viewer.people.people_server import PeopleServer

pytestmark = pytest.mark.browser
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQAAAABJRU5ErkJggg=="
)
ACT = {
    "type": "object",
    "properties": {
        "action": {"type": "string", "enum": ["move", "stay"]},
        "amount": {"type": "integer", "minimum": 0, "maximum": 9},
        "direction": {"type": "string", "enum": ["up", "down"]},
        "memory": {"type": "string"},
    },
    "required": ["action", "memory"],
}
PROMPT = "You are Agent 3.\n=== NEARBY ===\nAgent <b>4</b>\n## Decide\nMove or stay."


@dataclass
class Sitting:
    """Questions that wait at a desk, each with what came of it, and where their page is."""

    url: str = ""
    texts: list[str] = field(default_factory=list)
    answered: threading.Semaphore = field(default_factory=lambda: threading.Semaphore(0))

    def wait(self) -> str:
        self.answered.acquire()
        return self.texts[-1]


def request(number: int, kind: str) -> Request:
    images = (PIXEL,) if kind == "look" else ()
    messages = (ChatMessage("user", PROMPT, images),)
    return Request(messages=messages, seed=number, kind=kind, observation={}, step=number, agent=0, key=str(number))


async def ask(sitting: Sitting, kinds: tuple[str, ...]) -> None:
    model = HumanModel(
        person="ana", name="human/ana", schemas={"act": ACT, "judge": {"type": "string", "enum": ["yes", "no"]}}
    )

    async def one(number: int, kind: str) -> None:
        sitting.texts.append((await model.ask(request(number, kind))).text)
        sitting.answered.release()

    await asyncio.gather(*(one(*pair) for pair in enumerate(kinds)), return_exceptions=True)


@pytest.fixture
def sitting() -> Iterator[Sitting]:
    desk, sitting = Desk(), Sitting()

    def work() -> None:
        with seated(desk):
            asyncio.run(ask(sitting, ("act", "act", "look", "judge")))

    thread = threading.Thread(target=work)
    with running(PeopleServer(desk, "You answer as ana.", leave=desk.leave)) as server:
        sitting.url = server.url
        thread.start()
        yield sitting
        desk.leave()
        thread.join()


def begin(page: Any, sitting: Sitting) -> None:
    page.goto(sitting.url)
    page.wait_for_selector(".consent button")
    assert page.locator(".prompt").count() == 0
    page.keyboard.press("Enter")
    page.wait_for_selector(".answer")


def press(page: Any, *keys: str) -> None:
    for key in keys:
        page.keyboard.press(key)


def shown(page: Any, number: int) -> None:
    page.wait_for_function("n => document.querySelector('#standing').textContent.includes(`${n} answered`)", arg=number)


def test_a_person_answers_by_keys_takes_back_and_looks_at_a_picture(sitting: Sitting):
    with browser_page() as page:
        begin(page, sitting)
        assert page.locator(".prompt h2").all_text_contents() == ["NEARBY", "Decide"]
        assert "Agent <b>4</b>" in page.text_content(".prompt")
        press(page, "Enter")
        assert "Please choose: action" in page.text_content(".warning")
        press(page, "2", "Escape")
        assert "You have not chosen anything yet" in page.text_content(".preview")
        press(page, "1", "4", "3", "Enter")
        assert "These fields are empty: amount. Press Enter again" in page.text_content(".warning")
        press(page, "Enter")
        assert sitting.wait() == '{"action":"move","direction":"up","memory":""}'
        shown(page, 1)
        press(page, "2", "Tab", "Tab", "7", "Tab")
        page.keyboard.type("1 fire")
        press(page, "Enter")
        assert "These fields are empty: direction. Press Enter again" in page.text_content(".warning")
        press(page, "Enter")
        assert sitting.wait() == '{"action":"stay","amount":7,"memory":"1 fire"}'
        page.wait_for_selector(".prompt img")
        assert page.evaluate("() => document.querySelector('.prompt img').naturalWidth") == 1
        press(page, "Enter")
        assert "Press Enter again" in page.text_content(".warning")
        page.keyboard.type("turn left")
        press(page, "Enter")
        assert sitting.wait() == "turn left"
        shown(page, 3)
        press(page, "2", "1", "Enter")
        assert sitting.wait() == "yes"
        page.wait_for_selector("text=That is all for now")


def test_what_is_left_open_is_sent_on_second_thought_and_then_at_once_until_the_page_ends_the_sitting(sitting: Sitting):
    with browser_page() as page:
        begin(page, sitting)
        press(page, "1", "Enter")
        assert "These fields are empty: amount, direction." in page.text_content(".warning")
        press(page, "3")
        assert page.locator(".warning:visible").count() == 0
        press(page, "3", "Enter", "Enter")
        assert sitting.wait() == '{"action":"move","memory":""}'
        shown(page, 1)
        press(page, "1", "Enter")
        assert sitting.wait() == '{"action":"move","memory":""}'
        page.click("#leave")
        page.wait_for_selector("text=That is all for now")
        assert len(sitting.texts) == 2, "what is not answered stays open"


def test_nothing_is_wrong_with_the_page_and_on_a_phone_the_answer_is_in_sight(sitting: Sitting):
    with browser_page() as page:
        page.goto(sitting.url)
        page.wait_for_selector(".consent button")
        axe.check(page)
        begin(page, sitting)
        axe.check(page)
        page.set_viewport_size({"width": 400, "height": 800})
        for tones in ("light", "dark"):
            page.emulate_media(color_scheme=tones)
            assert page.evaluate("() => document.documentElement.scrollWidth") == 400
            box = page.locator(".answer [type=submit]").bounding_box()
            assert box["y"] + box["height"] <= 800
