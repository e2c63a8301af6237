"""Things that people look up in a sweep, each walked with as many clicks and keys as docs/view.md says."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from viewer.usable.conftest import Forms
from viewer_pages import PLAYER_READY, go

pytestmark = pytest.mark.browser

DOCUMENT = Path(__file__).parents[3] / "docs" / "view.md"
ROWS = "tbody tr[data-run]"


def told() -> dict[str, int]:
    """Return how many clicks and keys the document says each task takes."""
    _, section = DOCUMENT.read_text(encoding="utf-8").split("## Tasks and clicks\n")
    lines = [line.strip("| ").split(" | ") for line in section.split("\n## ")[0].splitlines() if line.startswith("| ")]
    return {task: int(now) for task, now in lines[1:]}


@dataclass
class Hand:
    page: Any
    count: int = field(default=0)

    def click(self, selector: str, **where: Any) -> None:
        self.count += 1
        self.page.click(selector, **where)

    def press(self, key: str) -> None:
        self.count += 1
        self.page.keyboard.press(key)

    def choose(self, selector: str, label: str) -> None:
        self.count += 1
        self.page.select_option(selector, label=label)

    def write(self, selector: str, text: str) -> None:
        self.count += 1
        self.page.fill(selector, text)

    def sees(self, condition: str, wanted: object = None) -> None:
        self.page.wait_for_function(condition, arg=wanted)


def open_sweep(hand: Hand, forms: Forms, name: str = "grid") -> None:
    """Show a sweep: `found` is as the command leaves it, `grid` has known mishaps."""
    go(hand.page, forms.server.url, f"sweep/{name}")
    hand.page.wait_for_selector(ROWS)


def nobody_warned(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click(".matrix tbody th button >> nth=0")
    hand.click(".strips button >> text=social_reach")
    hand.sees("() => document.querySelector('th[aria-sort=ascending]')?.textContent.includes('social_reach')")
    heads = hand.page.locator("table.runs:not(.matrix *) thead tr").last.locator("th").all_text_contents()
    place = next(index for index, head in enumerate(heads) if "social_reach" in head)
    assert hand.page.locator(f"{ROWS} >> nth=0").locator("> *").nth(place).text_content() == "0"


def parting(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click("text=Compare the models on a seed")
    hand.page.wait_for_selector(".replies mark")


def leaving_soonest(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click("text=Compare the models on a seed")
    hand.page.wait_for_selector("[data-lane='distance to the nearest fire (cells)']", state="attached")
    assert hand.page.locator(".over-time .legend span").count() >= 2


def failed_reply(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.click(f"{ROWS} a >> nth=0")
    hand.sees("() => Foundry.page?.data?.marked === 6")
    hand.press("x")  # one that was repaired
    hand.press("x")
    hand.click(".inspector .go >> nth=0")
    hand.page.wait_for_selector(".inspector .is-unreadable")
    assert hand.page.locator("details[data-kind=action][open] .reply").count() == 1


def said_anywhere(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.write(".find input", "hello")
    hand.press("Enter")
    hand.click(".find .found a >> nth=0")
    hand.page.wait_for_selector(".inspector .quote >> text=hello")


def means(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.page.wait_for_selector(".matrix td small >> text=[")
    assert hand.page.locator(".matrix tbody th button").count() == 2
    assert "Click a model to see its measures" in hand.page.text_content(".matrix caption")


def rows_of_a_model(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.choose("[data-filter=model]", "scripted/herd")
    with hand.page.expect_download() as saved:
        hand.click("button:text-is('CSV')")
    lines = Path(saved.value.path()).read_text(encoding="utf-8").splitlines()
    assert len(lines) == 3 and all("scripted/herd" in line for line in lines[1:])


def back_to_the_list(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.choose("[data-filter=model]", "scripted/herd")
    hand.click("[data-sort=seed]")
    hand.click(f"{ROWS} a >> nth=0")
    hand.page.wait_for_function(PLAYER_READY)
    hand.click("#crumbs a")
    hand.page.wait_for_selector("th[aria-sort=ascending] [data-sort=seed]")
    assert hand.page.locator(ROWS).count() == 2


def where_all_stood(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click("text=Compare the models on a seed")
    hand.click(".choices input")
    hand.choose("[aria-label='Steps drawn as']", "heat map of all")
    hand.sees("() => Foundry.page.overlay.ways.every((way) => way.size === 12)")


def when_it_ends(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "growing")
    hand.click("text=live progress")
    hand.page.wait_for_selector(".live")


def unreadable_replies(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.click(".look-at .unread button >> text=first: 1 of 96 replies")
    hand.page.wait_for_selector(".find .found a >> text=first · made_up · seed 0 · step 4 · agent 0")
    assert hand.page.locator(".find .found a").count() == 1


def seed_by_seed(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click(".matrix tbody th button >> nth=0")
    hand.click(".strips button >> text=idle_rate")
    hand.page.wait_for_selector(".strips tr:has-text('idle_rate') .strip .seed", state="attached")
    hand.page.wait_for_selector("th[aria-sort=ascending] [data-sort^='idle_rate.']")


def worst_world(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.page.wait_for_selector(".matrix tr:has-text('first') td:has-text('0.25') .worst")
    assert hand.page.locator(".matrix .worst").count() == 1


def costs(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.page.wait_for_selector(".matrix td small >> text=[")
    heads = hand.page.locator(".matrix thead th").all_text_contents()
    cells = hand.page.locator(".matrix tbody tr").first.locator("> *").all_text_contents()
    assert dict(zip(heads, cells, strict=True))["calls"] == "384"
    assert {"readable replies", "tokens", "time"} <= set(heads)


def a_figure(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.click(".gallery summary")
    with hand.page.expect_popup() as opened:
        hand.click(".gallery a[href$='action.svg']")
    assert opened.value.url.endswith("action.svg")
    opened.value.close()


def most_messages(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click("[data-sort=messages]")
    hand.click("[data-sort=messages]")
    hand.page.wait_for_selector("th[aria-sort=descending] [data-sort=messages]")


def who_speaks(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.choose("[aria-label='Where to search']", "messages")
    hand.page.wait_for_selector(".speakers button")


def why_it_failed(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.page.wait_for_selector(".look-at .failures >> text=the server is gone")
    hand.page.wait_for_selector(".look-at .again >> text=foundry resume")


def the_address(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.click(".matrix tbody th button >> nth=0")
    assert hand.page.url.endswith("?open=first")


def prompts(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.choose("[aria-label='Where to search']", "prompts")
    hand.write("[data-find=agent]", "1")
    hand.click(".find .found a >> nth=0")
    hand.page.wait_for_selector(".inspector .quote")


def heard_before_it_fled(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms)
    hand.click(f"{ROWS} a >> nth=0")
    hand.sees("() => Foundry.page?.player?.timeline.written.length === 2")
    left = hand.page.evaluate(
        "() => Foundry.page.player.timeline.written.find(({event}) => event.event === 'fled').from"
    )
    hand.click(".marks", position={"x": left + 8, "y": 8})
    hand.page.wait_for_selector(".told li >> text=step 4, agent 1: hello from step 4")
    assert hand.page.text_content(".where") == "step 5 of 6"
    assert hand.page.input_value("[aria-label=Agent]") == "2"


def best_moment(hand: Hand, forms: Forms) -> None:
    open_sweep(hand, forms, "found")
    hand.click(".look-at .findings a >> nth=0")
    hand.page.wait_for_selector(".replies mark")


TASKS: dict[str, Callable[[Hand, Forms], None]] = {
    "find the runs in which nobody was warned": nobody_warned,
    "find the first step in which two models decide differently, and the reason": parting,
    "see which model leaves the fire first, for a seed": leaving_soonest,
    "read the raw reply of a failed decision that comes after a repaired decision": failed_reply,
    "find who said a certain word, in any run": said_anywhere,
    "see the mean of each model with its interval": means,
    "save the table of one model's runs as CSV": rows_of_a_model,
    "filter and sort the runs, open a run, and return to the list": back_to_the_list,
    "see where all agents were, for all models": where_all_stood,
    "see what a sweep is doing, and when it will end": when_it_ends,
    "read all unreadable replies of a model": unreadable_replies,
    "see the moment that shows a difference most clearly": best_moment,
    "read the prompts of an agent": prompts,
    "read what an agent heard before it fled": heard_before_it_fled,
    "see the idle rate of a model for each seed": seed_by_seed,
    "see in which world a model does worst": worst_world,
    "see the calls, tokens and hours of a model": costs,
    "save a figure as SVG": a_figure,
    "share the present view, with the measures of a model": the_address,
    "find the run with the most messages": most_messages,
    "see which agent speaks most": who_speaks,
    "see why a run failed, and the command that plays it again": why_it_failed,
}


@pytest.mark.parametrize("task", TASKS)
def test_a_task_takes_as_many_clicks_and_keys_as_the_document_says(page: Any, forms: Forms, task: str):
    hand = Hand(page)
    TASKS[task](hand, forms)
    assert hand.count == told()[task]


def test_the_document_tells_these_tasks_and_no_others():
    assert list(told()) == list(TASKS)
