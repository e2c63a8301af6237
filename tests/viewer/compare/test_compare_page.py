"""Runs side by side in a real browser: what differs word by word, over time, on the map."""

from pathlib import Path
from typing import Any

import pytest

import commands
from foundry.palette import COLOURS, DARK_COLOURS, look
from foundry.storing.store import SweepFolder
from foundry.viewer.server import ViewServer, serving
from made_up_runs import Playing, otherwise, sweep, whole_run
from viewer_pages import go, shown

pytestmark = pytest.mark.browser

DIFFERENCE = "([before, after]) => Foundry.words.difference(before, after)"


@pytest.fixture
def compared(page: Any, server: ViewServer, made_up: SweepFolder) -> Any:
    """Two models at step 4, where agent 1 says something else."""
    runs = made_up.runs()
    go(page, server.url, f"compare/made-up/{runs[0].id}/{runs[2].id}?step=4&agent=1")
    page.wait_for_selector("[data-text=message]")
    page.wait_for_selector(".chip")
    return page


DIFFERENCES: list[tuple[str, str, list[list[str]]]] = [
    ("", "", []),
    ("a b", "a b", [["same", "a b"]]),
    ("", "a", [["new", "a"]]),
    ("I go left now", "I go right now", [["same", "I go "], ["gone", "left"], ["new", "right"], ["same", " now"]]),
    ("x go left y", "x stay there y", [["same", "x "], ["gone", "go left"], ["new", "stay there"], ["same", " y"]]),
    ("one two three", "two three", [["gone", "one "], ["same", "two three"]]),
    ("火事だ", "火事か", [["same", "火事"], ["gone", "だ"], ["new", "か"]]),
]


def test_texts_differ_by_words_and_a_difference_holds_both_whole_however_long_they_are(compared: Any):
    for before, after, parts in DIFFERENCES:
        assert compared.evaluate(DIFFERENCE, [before, after]) == parts
    before = " ".join(f"{number % 7}\n{number % 11}" for number in range(4000))
    for after in (before.replace("3", "5"), before[:9000] + "new" + before[9000:], before.replace(" ", "x ")):
        parts = compared.evaluate(DIFFERENCE, [before, after])
        assert "".join(text for kind, text in parts if kind != "new") == before
        assert "".join(text for kind, text in parts if kind != "gone") == after
        assert len(parts) < 4000


def test_the_page_opens_at_the_first_parting_with_both_replies_and_ways_to_the_next(
    page: Any, server: ViewServer, made_up: SweepFolder
):
    first, _, second, _ = made_up.runs()
    go(page, server.url, f"compare/made-up/{first.id}/{second.id}")
    page.wait_for_selector(".chip")
    page.wait_for_function("() => Foundry.page.agent === 3")
    page.wait_for_selector("[data-text='action: reply']")
    assert page.text_content(".sentence") == "Step 3: agent 3, with the same prompt: first went right; second went up."
    assert page.locator("[data-text='action: reply'] pre").count() == 2
    assert page.locator(".chip").all_text_contents() == [f"step {step} · agent 3" for step in (3, 4, 5, 6)]
    page.click(".chip >> nth=2")
    page.wait_for_function("() => document.querySelector('.sentence').textContent.startsWith('Step 5: agent 3')")
    assert page.text_content(".paired") == "same world: made_up · same seed: 0 · same prompt: paper"
    page.click("a.seed")
    page.wait_for_function("() => Foundry.page.runs?.every((run) => run.about.seed === 1)")
    assert page.evaluate("() => [Foundry.page.clock.step, Foundry.page.agent]") == [5, 3], "the moment is kept"


def test_a_moment_shows_texts_that_differ_with_the_words_marked_and_a_prompt_by_its_sections(compared: Any):
    message = compared.locator("details[data-text=message]")
    message.locator("summary").click()
    assert message.locator("mark").all_text_contents() == ["hello from step 4", "something else"]
    assert compared.locator("[data-text=memory]").count() == 0, "what is the same is not shown"
    prompt = "You are one.\n\n=== YOUR STATE ===\nx: 1\n\n## Your task\nGo.\n=== NOT A HEADING"
    assert compared.evaluate("text => Foundry.words.sections(text)", prompt) == [
        ["", "You are one.\n"],
        ["=== YOUR STATE ===", "x: 1\n"],
        ["## Your task", "Go.\n=== NOT A HEADING"],
    ]
    names = compared.evaluate("""() => {
      const calls = [["a", ""], ["b", "why b"], ["c", "why c"]]
        .map(([text, thinking]) => ({kind: "say", text, thinking}));
      const texts = new Foundry.Texts(["first"]);
      texts.show([{records: [], calls}], null);
      return [...texts.replies.querySelectorAll("[data-text]")].map((one) => one.dataset.text);
    }""")
    assert names == ["say: reply", "say (2): reply", "say (3): reply"]


def test_numbers_by_step_of_all_runs_stand_under_the_clock_those_first_that_part_most(compared: Any):
    lane = compared.locator("[data-lane='reach if every message warned (share)']")
    lane.wait_for()
    assert "step 4: first 0, second 0" in lane.text_content()
    lane.scroll_into_view_if_needed()
    box = lane.locator("canvas").bounding_box()
    compared.mouse.move(box["x"] + box["width"] * 0.25, box["y"] + 10)
    compared.wait_for_function("() => document.querySelector('.where').textContent === 'step 2 of 6'")
    compared.wait_for_function("() => document.querySelector('.lane').textContent.includes('step 2:')")
    lanes = compared.locator(".over-time > div > .lane").evaluate_all("(all) => all.map((one) => one.dataset.lane)")
    assert (lanes[0], len(lanes)) == ("moved (agents)", 3), "those that part most; others are under more"


LOOK = "({colour, marker, dashes}) => ({colour, marker, dashes})"


def looks_of(told: list[dict[str, Any]]) -> list[Any]:
    return [(one["colour"], [tuple(corner) for corner in one["marker"]], tuple(one["dashes"])) for one in told]


def test_pages_have_the_looks_of_the_plots_and_runs_those_of_their_models_wherever_they_stand(
    page: Any, server: ViewServer, made_up: SweepFolder
):
    go(page, server.url, "sweep/made-up")
    told = page.evaluate(f"() => Array.from({{length: 30}}, (_, place) => Foundry.looks.look(place)).map({LOOK})")
    plotted = [look(place) for place in range(30)]
    assert looks_of(told) == [(look.colour, list(look.marker or ()), look.dashes) for look in plotted]
    first, again, second, _ = made_up.runs()
    go(page, server.url, f"compare/made-up/{second.id}/{first.id}/{again.id}")
    looks = looks_of(page.evaluate(f"() => Foundry.looks.ofRuns(Foundry.page.runs).map({LOOK})"))
    assert [colour for colour, _, _ in looks] == [look(place).colour for place in (1, 0, 0)]
    assert len({(str(marker), dashes) for _, marker, dashes in looks}) == 3


FILL = "() => getComputedStyle(document.body.appendChild(Foundry.looks.mark(Foundry.looks.look(0))).firstChild).fill"


def test_a_dark_page_shows_models_in_colours_for_dark_backgrounds(page: Any, server: ViewServer, made_up: SweepFolder):
    go(page, server.url, "sweep/made-up")
    for scheme, colours in (("light", COLOURS), ("dark", DARK_COLOURS)):
        page.emulate_media(color_scheme=scheme)
        assert page.evaluate("() => Foundry.looks.look(0).colour") == colours[0]
        assert page.evaluate(FILL) == f"rgb{tuple(bytes.fromhex(colours[0][1:]))}"


def test_a_run_that_failed_early_hides_no_difference_of_the_others_and_no_text(page: Any, tmp_path: Path):
    made = sweep(tmp_path / "short", models=("first", "second", "third"), seeds=(0,))
    first, second, third = made.runs()
    failed = Playing(first)
    failed.play(1, 1)
    failed.end("the server is gone")
    whole_run(second)
    whole_run(third, otherwise)
    with shown(page, made, f"compare/short/{first.id}/{second.id}/{third.id}?step=4&agent=1"):
        page.wait_for_selector("[data-text=message]")
        assert page.text_content("h1") == "first · second · third" and page.locator(".panel").count() == 3
        told = "second said “hello from step 4” and went right; third said “something else” and went right."
        assert page.text_content(".sentence").endswith(f"first made no decision; {told}")
        assert "No decision at this step: first." in page.text_content(".replies")
        page.click("[data-text=message] summary")
        assert page.locator("[data-text=message] mark").all_text_contents() == ["hello from step 4", "something else"]


def test_an_agent_of_one_run_only_decides_no_differently(compared: Any):
    assert compared.evaluate(DIFFERING, [1, 3]) == []
    assert compared.evaluate(DIFFERING, [2, 1, 2]) == [1]


DIFFERING = """(counts) => Foundry.difference.differingAgents(counts.map((agents, place) => (
  {done: 1, about: {agents}, load: () => null, form: {same: (chunk, about, step, agent) => agent && place}})), 1)"""
"""Agents that act differently, of runs with these numbers of agents: all but agent 0 act in their own way."""


def test_what_runs_differ_in_beside_the_model_is_named(page: Any, server: ViewServer, made_up: SweepFolder):
    first, other_seed, *_ = made_up.runs()
    go(page, server.url, f"compare/made-up/{first.id}/{other_seed.id}")
    assert page.text_content("p.warning") == "Different seed: 0, 1"


def test_both_runs_are_on_one_map_with_trails_and_heat_of_the_chosen_steps(compared: Any):
    compared.check("text=all on one map")
    compared.wait_for_function("() => Foundry.page.overlay.spots?.length === 8")
    assert compared.locator(".panels").is_hidden(), "one map instead of all"
    assert compared.locator(".overlay .waits").count() == 0, "what is there is not pale"
    first, second = compared.evaluate("() => [3, 7].map((at) => Foundry.page.overlay.spots[at])")
    assert compared.locator(".overlay .note >> text=The map does not show").count() == 0
    assert compared.evaluate("() => Foundry.page.overlay.labels.length") > 0, "places of one world are drawn"
    assert second[0] == first[0], "at step 4 agent 3 stands where it stands in the other run"
    assert compared.input_value("[aria-label='To step']") == "6", "the last step that there is"
    compared.select_option("[aria-label='Steps drawn as']", "-1")
    compared.fill("[aria-label='To step']", "2")
    compared.press("[aria-label='To step']", "Enter")
    compared.wait_for_function("() => Foundry.page.overlay.ways.every((way) => [...way.keys()].join() === '1,2')")
    compared.wait_for_function(
        "() => document.querySelector('.overlay [role=status]').textContent === 'darkest: 2 visits of a cell'"
    )
    compared.select_option("[aria-label='Steps drawn as']", "-2")
    compared.click("text=what the marks mean")
    assert "inner ring: perceives a fire" in compared.text_content(".map-legend")


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Two runs of a world that draws its places and fires for each seed."""
    folder = tmp_path_factory.mktemp("drawn")
    small = ("world=cafe_library_drawn", "world.agents=4", "world.steps=3", "analyze=false", "output.dir=out")
    done = commands.foundry("-m", "model=scripted/random", "seed=0,1", *small, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return SweepFolder.open(folder / "out")


def test_one_map_of_runs_whose_positions_were_drawn_shows_those_of_none(drawn: SweepFolder, page: Any):
    first, second = drawn.runs()
    with serving(drawn.path) as served:
        go(page, served.url, f"compare/out/{first.id}/{second.id}?step=2")
        page.check("text=all on one map")
        page.wait_for_function("() => Foundry.page.overlay.spots?.length === 8")
        shown = page.evaluate("() => [Foundry.page.overlay.labels.map((one) => one.text), Foundry.page.overlay.flames]")
        assert shown == [[], []]
        assert "The map does not show places or fires, because they differ" in page.text_content(".overlay")
