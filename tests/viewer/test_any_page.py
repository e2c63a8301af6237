"""The page of a run whose form nobody knows more of than all forms share, in a real browser."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import foundry
import made_up_rounds as rounds
import viewer_pages
from foundry.storing.store import SweepFolder
from foundry.viewer.export import export
from foundry.viewer.server import ViewServer, serving
from made_up_rounds import STEPS, Playing

pytestmark = pytest.mark.browser

TRUSTED = ("made_up_rounds",)
LOADED = "steps => Foundry.page.lanes?.run.loaded === steps"
CELL = """([agent, step]) => {
  const {lanes} = Foundry.page, scale = devicePixelRatio;
  const x = lanes.left(step) + 0.2 * lanes.column, y = (agent + 0.3) * lanes.lane;
  return [...lanes.canvas.getContext('2d').getImageData(x * scale, y * scale, 1, 1).data.slice(0, 3)].join();
}"""
TONES = """([agent, step]) => {
  const {lanes} = Foundry.page, scale = devicePixelRatio, found = [];
  const x = Math.round(lanes.left(step) * scale), y = Math.round((agent + 0.5) * lanes.lane * scale);
  const {data} = lanes.canvas.getContext('2d').getImageData(x, y, Math.round(lanes.column * scale), 4);
  for (let at = 0; at < data.length; at += 4) found.push([...data.slice(at, at + 3)].join());
  return found;
}"""
TONE = """name => {
  const pen = document.createElement('canvas').getContext('2d');
  pen.fillStyle = Foundry.dom.color(name);
  pen.fillRect(0, 0, 1, 1);
  return [...pen.getImageData(0, 0, 1, 1).data.slice(0, 3)].join();
}"""
SCORED = """() => {
  const {data, curves} = Foundry.page;
  const score = {value: 2.5, known: 'best 3', measure: 'own.score', label: 'Own score (points)', mean: 2, runs: 3};
  data.analysis = {...data.analysis, score};
  data.readers.forEach((one) => one());
  curves.draw();
  return [curves.title.textContent, curves.known.textContent, document.querySelector('.heading .score').textContent];
}"""
ORANGE = "230,159,0"


@pytest.fixture(scope="module")
def bar(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    made = rounds.sweep(tmp_path_factory.mktemp("bar") / "bar")
    first, second = made.runs()
    rounds.whole_run(first)
    rounds.whole_run(second, rounds.otherwise)
    return made


@pytest.fixture(scope="module")
def served(bar: SweepFolder) -> Iterator[ViewServer]:
    with serving(bar.path, trusted=TRUSTED) as server:
        yield server


def go(page: Any, server: ViewServer, bar: SweepFolder, rest: str = "", index: int = 0) -> None:
    viewer_pages.go(page, server.url, f"run/bar/{bar.runs()[index].id}{rest}")
    page.wait_for_function(LOADED, arg=STEPS)


def painted(page: Any) -> None:
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_agents_are_lanes_coloured_by_action_and_a_cell_leads_to_its_decision(
    page: Any, served: ViewServer, bar: SweepFolder
):
    go(page, served, bar, "?step=8")
    painted(page)
    cells = {place: page.evaluate(CELL, list(place)) for place in ((0, 2), (0, 3), (1, 3))}
    assert cells == {
        (0, 2): ORANGE, (0, 3): page.evaluate(TONE, "soft"), (1, 3): ORANGE,
    }  # fmt: skip
    assert {page.evaluate(TONE, "bad"), page.evaluate(TONE, "paper")} <= set(page.evaluate(TONES, [3, 5])), "hatched"
    legend = page.text_content(".lanes-box .legend >> nth=0")
    assert "stay at home 50 %" in legend and "go late 0 %" in legend and "unreadable 2 %" in legend
    assert page.get_attribute("canvas.lanes", "aria-label") == "5 agents. Step 8: 3 go, 2 stay at home."
    go(page, served, bar, "?step=8")
    painted(page)
    box = page.locator("canvas.lanes").bounding_box()
    x, y = page.evaluate("() => [Foundry.page.lanes.left(5) + 4, 3.5 * Foundry.page.lanes.lane]")
    page.mouse.move(box["x"] + x, box["y"] + y)
    assert page.get_attribute("canvas.lanes", "title") == "agent 3, step 5: unreadable"
    page.mouse.click(box["x"] + x, box["y"] + y)
    page.wait_for_selector(".inspector .is-unreadable")
    assert page.input_value("[aria-label=Agent]") == "3"
    assert page.text_content(".where") == f"step 5 of {STEPS}"
    assert "gender: male" in page.text_content(".persona")
    assert page.locator("details[data-kind=go]").get_attribute("open") is not None, "the call that failed is open"
    assert page.locator("details[data-kind=pay]").get_attribute("open") is None
    assert "You are guest 3 on evening 5." in page.locator("details[data-kind=go] .prompt").text_content()


def test_the_step_is_a_table_with_the_worlds_own_keys_and_streams(page: Any, served: ViewServer, bar: SweepFolder):
    go(page, served, bar, "?step=3&agent=1")
    page.click("summary >> text=decisions of step 3")
    page.wait_for_selector("tr.chosen")
    heads = page.locator("details.lines-box >> nth=0").locator("thead th").all_text_contents()
    assert heads == ["agent", "kind", "action", "outcome", "utility", "crowd", "reasoning", "seats"]
    assert page.locator(".lines tr[data-agent]").count() == 15
    page.wait_for_selector("[aria-label='Lines of evenings'] td")
    assert page.locator("[aria-label='Lines of evenings'] td").all_text_contents() == ["3", "sun"]
    assert page.locator("[aria-label='Lines of house'] td").all_text_contents() == ["3", "El <b>Farol</b>"]
    page.click("tr[data-agent='2'] button >> nth=0")
    assert page.input_value("[aria-label=Agent]") == "2"


def test_numbers_that_the_world_writes_are_lines_below_the_lanes(page: Any, served: ViewServer, bar: SweepFolder):
    go(page, served, bar, "?step=7")
    page.wait_for_selector("canvas.curves[aria-label='Step 7: crowd 3']")
    assert page.evaluate(SCORED) == [
        "evenings over time", "Score 2.5. Known scores: best 3.",
        " · score 2.5 Own score (points) own.score · model's mean 2, 3 seeds ",
    ]  # fmt: skip
    lanes, curves = (page.locator(f"canvas.{name}").bounding_box() for name in ("lanes", "curves"))
    assert curves["x"] == lanes["x"] and curves["width"] == pytest.approx(lanes["width"], abs=1), "column below column"
    page.select_option("[aria-label='Numbers over time']", "1")
    page.wait_for_function("() => document.querySelectorAll('.lanes-box')[1].textContent.startsWith('crowd over time')")


def test_a_game_without_a_picture_of_its_own_shows_its_lanes_once(page: Any, workspace: Path):
    ran = foundry.run("world=public_goods", "model=scripted/random", "world.steps=3", "output.dir=game")
    (run,) = SweepFolder.open(ran.path).runs()
    exported = export(ran.path, Path("page").absolute())
    with serving(ran.path) as server:
        for address in (server.url, exported.page.as_uri()):
            viewer_pages.go(page, address, f"run/game/{run.id}?step=3")
            page.wait_for_function(LOADED, arg=3)
            page.wait_for_function("() => Foundry.page.picture.there")
            assert page.locator("canvas.lanes:visible").count() == 1 and page.is_hidden(".picture")
            assert page.evaluate("() => document.documentElement.scrollHeight <= innerHeight"), "it fits the screen"
        page.goto("about:blank")


def test_keys_lead_to_failures_and_messages_of_all_agents_or_of_one(page: Any, served: ViewServer, bar: SweepFolder):
    go(page, served, bar)
    page.wait_for_function("() => Foundry.page.data.marked === 12")
    for key, step in (("x", 5), ("x", 7), ("Shift+X", 5), ("m", 6), ("Home", 1)):
        page.keyboard.press(key)
        assert page.text_content(".where") == f"step {step} of {STEPS}", key
    page.keyboard.press("]")
    page.wait_for_function("() => Foundry.page.ownMarks")
    page.keyboard.press("x")
    assert page.text_content(".where") == f"step 7 of {STEPS}", "agent 0 is repaired at step 7 and fails nowhere"


def test_runs_side_by_side_show_where_they_part(page: Any, served: ViewServer, bar: SweepFolder):
    runs = "/".join(run.id for run in bar.runs())
    viewer_pages.go(page, served.url, f"compare/bar/{runs}")
    page.wait_for_function("() => document.querySelector('.sentence').textContent.startsWith('Step 4: agent 2, ')")
    page.wait_for_function("() => document.querySelectorAll('.column')[1]?.textContent.includes('go late')")
    page.wait_for_function(
        "() => [...document.querySelectorAll('.picture img')].every((one) => one.naturalWidth === 300)"
    )
    assert page.locator(".panel canvas.lanes").count() == 2


def test_a_run_is_followed_while_it_is_written(page: Any, tmp_path: Path):
    made = rounds.sweep(tmp_path / "grows", models=("first",))
    with serving(made.path, trusted=TRUSTED) as server:
        page.goto(f"{server.url}#/run/grows/{made.runs()[0].id}")
        page.wait_for_function("() => document.querySelector('.where')?.textContent === 'no step yet'")
        playing = Playing(made.runs()[0])
        playing.play(1, 4)
        page.wait_for_function("() => document.querySelector('.where').textContent === 'after step 4 of 4'")
        page.wait_for_function(LOADED, arg=4)
        assert page.locator("[aria-label=Agent] option").count() == 6
        playing.play(5, 6)
        playing.end("the server is gone")
        page.wait_for_selector(".state .is-failed")
        page.wait_for_function(LOADED, arg=6)
        page.wait_for_function("() => Foundry.page.curves.loaded === 6")
        page.wait_for_selector(".picture img[alt='The world after step 6']")
        page.goto("about:blank")


def test_a_world_that_is_not_trusted_is_not_built_and_the_page_says_so(page: Any, bar: SweepFolder, tmp_path: Path):
    with serving(bar.path) as server:
        go(page, server, bar, "?step=8")
        page.wait_for_selector("text=allow it with --trust-targets made_up_rounds")
        assert page.is_hidden(".picture img")
        exported = export(bar.path, tmp_path / "page")
        viewer_pages.go(page, exported.page.as_uri(), f"run/bar/{bar.runs()[0].id}?step=4")
        page.wait_for_selector("text=There is no picture after step 4")
        page.goto("about:blank")
