"""Everything that was said in words is found in all runs of a sweep."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from foundry.viewer.resources import Resources
from foundry.viewer.search import Query, TextSearch
from foundry.viewer.server import serving
from made_up_runs import sweep, whole_run, whole_sweep
from viewer_pages import go


def texts(number: int, agent: int) -> dict[str, Any]:
    if (number, agent) == (3, 1):
        return {"memory": "the Café is burning", "message": "図書館へ逃げて", "reasoning": "smoke everywhere"}
    return {}


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    """Two runs of three, and the index of their texts. Read only."""
    found = sweep(tmp_path_factory.mktemp("texts") / "texts", models=("first",), seeds=(0, 1, 2))
    whole_run(found.runs()[0], texts, reply="I choose the north door")
    whole_run(found.runs()[1])
    return found


@pytest.fixture(scope="module")
def search(played: SweepFolder) -> Iterator[TextSearch]:
    search = TextSearch(played)
    indexed(search)
    yield search
    search.close()


@pytest.fixture
def made(played: SweepFolder, search: TextSearch, tmp_path: Path) -> SweepFolder:
    return SweepFolder.open(shutil.copytree(played.path, tmp_path / "texts"))


def indexed(search: TextSearch) -> None:
    search.find(Query("every", "begin"))
    assert search._thread is not None
    search._thread.join()


@pytest.mark.parametrize(
    ("kind", "words", "steps"),
    [
        ("every", "cafe burning", [3]),
        ("memory", "burn*", [3]),
        ("every", "burn", []),
        ("message", "図書館", [3]),
        ("message", "館書図", []),
        ("reasoning", "smoke", [3]),
        ("every", '"is the"', []),
        ("prompt", '"Agent 2 (female) at step 5"', [5, 5]),
        ("every", 'café OR "', []),
    ],
)
def test_words_are_found_where_they_stand(
    search: TextSearch, played: SweepFolder, kind: str, words: str, steps: list[int]
):
    first = played.runs()[0].id
    hits = [hit for hit in search.find(Query(kind, words))["hits"] if hit[0] == first]
    assert [hit[1] for hit in hits] == steps


def test_a_hit_says_who_and_shows_the_words(search: TextSearch, played: SweepFolder):
    found = search.find(Query("memory", "burning"))
    assert found["hits"] == [[played.runs()[0].id, 3, 1, "memory", "the Café is burning"]]
    assert (found["count"], found["indexed"], found["runs"]) == (1, 2, 2)
    assert (found["in_runs"], found["agents"]) == ({played.runs()[0].id: 1}, [(1, 1)])
    replies = search.find(Query("reply", "north"))
    assert (len(replies["hits"]), replies["count"]) == (48, 48)
    late = Query("reply", "north", agent=1, first=5, last=6)
    assert {tuple(hit[1:3]) for hit in search.find(late)["hits"]} == {(5, 1), (6, 1)}
    assert search.find(replace(late, outcome="repaired"))["count"] == 0
    every = search.find(Query("every", agent=1))
    more = search.find(Query("every", agent=1, skip=len(every["hits"])))
    assert len(every["hits"]) + len(more["hits"]) == every["count"] > 50


def test_the_unreadable_replies_of_a_model_are_found_without_a_word(tmp_path: Path):
    made = whole_sweep(tmp_path / "made-up")
    resources = Resources(made.path)
    search = {"kind": "unreadable", "runs": "wA=="}

    def ask(**changes: str) -> dict[str, Any]:
        address = f"sweep/made-up/search/{json.dumps(search | changes)}"
        while (answer := json.loads(resources.get(address).content))["indexed"] < answer["runs"]:
            pass
        return answer

    unread = [made.runs()[0].id, 4, 0, "unreadable", 'action: {"action": "move"}']
    assert ask()["hits"] == [unread] and ask(words="action")["hits"] == [unread]
    assert ask(runs="MA==")["count"] == ask(outcome="empty")["count"] == ask(words="nowhere")["count"] == 0
    assert unread in ask(kind="reply", words='"action move"')["hits"]
    resources.close()


def test_a_run_that_ends_later_is_found_too_and_one_started_anew_once(made: SweepFolder):
    search = TextSearch(made)
    whole_run(made.runs()[2], reply="late answer")
    indexed(search)
    assert search.find(Query("reply", "late"))["count"] == 48
    search.close()
    shutil.rmtree(made.runs()[2].path)
    whole_run(made.runs()[2], reply="other answer")
    again = TextSearch(made)
    indexed(again)
    assert [again.find(Query("reply", word))["count"] for word in ("late", "other")] == [0, 48]
    again.close()


def test_records_stay_as_they_are_and_the_index_may_be_deleted(made: SweepFolder):
    assert {path.name for path in made.path.iterdir()} - {"runs", "sweep.yaml", "locks"} == {"viewer"}
    shutil.rmtree(made.search_file.parent)
    again = TextSearch(made)
    indexed(again)
    assert again.find(Query("memory", "burning"))["count"] == 1
    again.close()


def test_a_run_that_cannot_be_read_is_named_and_the_others_are_searched(made: SweepFolder):
    shutil.rmtree(made.search_file.parent)
    damaged = made.runs()[0].stream_path("steps")
    damaged.write_bytes(b'{"step": 1, "agent": ' + damaged.read_bytes())
    search = TextSearch(made)
    indexed(search)
    found = search.find(Query("reply", "action"))
    assert {hit[0] for hit in found["hits"]} == {made.runs()[1].id}
    assert [str(damaged) in why for why in found["unread"]] == [True]
    search.close()


@pytest.mark.parametrize(("kind", "words"), [("thought", "fire"), ("every", "*"), ("every", '""')])
def test_what_cannot_be_searched_is_told(search: TextSearch, kind: str, words: str):
    with pytest.raises(InputError, match="Texts of kind 'thought' do not exist|contains no word to search for"):
        search.find(Query(kind, words))


@pytest.mark.browser
def test_a_hit_is_a_link_to_its_moment_and_runs_that_end_meanwhile_are_searched_too(page: Any, made: SweepFolder):
    with serving(made.path) as server:
        go(page, server.url, "sweep/texts")
        page.fill("[aria-label='Filter and search']", "burning")
        page.keyboard.press("Enter")
        page.click(".find .found a")
        page.wait_for_selector(".player")
        assert page.text_content(".where") == "step 3 of 6"
        assert page.input_value("[aria-label=Agent]") == "1"
        page.go_back()
        page.wait_for_selector(".find .found a")
        assert page.input_value("[aria-label='Filter and search']") == "burning"
        go(page, server.url, "sweep/texts?status=complete&find=north")
        page.wait_for_selector("text=48 found in 1 runs")
        whole_run(made.runs()[2], reply="to the north")
        page.evaluate("() => Foundry.page.load()")
        page.wait_for_selector("text=96 found in 2 runs")
        page.goto("about:blank")
