"""The server of the page: whom it lets in, and what it takes."""

import asyncio
import http.client
from collections.abc import Iterator
from contextlib import closing
from urllib.parse import urlsplit

import pytest

from foundry.commands.view import terms_for
from foundry.errors import Interrupted
from foundry.models.base import ChatMessage, Request
from foundry.models.human.desk import Desk
from foundry.viewer.http import running
from foundry.viewer.people.people_server import PeopleServer
from sittings import Person


def request(key: str = "k", step: int = 1) -> Request:
    messages = (ChatMessage("user", f"prompt {key}"),)
    return Request(messages=messages, seed=0, kind="act", observation={}, step=step, agent=0, key=key)


def test_people_are_told_under_which_name_their_answers_are_kept():
    assert "You answer as human/a. Your answers are recorded under this name, with" in terms_for(["human/a"], "out")
    several = terms_for(["human/a", "human/b"], "out")
    assert "human/a and human/b. Your answers are recorded under the name shown with each question" in several


@pytest.fixture
def desk() -> Desk:
    return Desk()


@pytest.fixture
def person(desk: Desk) -> Iterator[Person]:
    with running(PeopleServer(desk, "told", leave=desk.leave)) as server:
        yield Person(server.url)


def status(url: str, path: str, method: str = "GET", **headers: str) -> int:
    parts = urlsplit(url)
    with closing(http.client.HTTPConnection(parts.hostname or "", parts.port or 0)) as connection:
        connection.request(method, path, headers=headers)
        return connection.getresponse().status


def test_without_the_token_or_under_another_name_nothing_is_there_nor_any_file_outside_the_page(person: Person):
    token = urlsplit(person.url).path
    assert status(person.url, f"{token}now") == 200
    assert status(person.url, "/now") == 404
    assert status(person.url, f"{token[:-2]}x/now") == 404
    assert status(person.url, "/", "POST") == 404
    assert len(token) > 20
    assert status(person.url, f"{token}now", Host="example.org") == 403
    assert status(person.url, f"{token}../server.py") == 409
    assert {name: status(person.url, f"{token}{name}") for name in ("", "people.js", "dom.js", "app.js")} == {
        "": 200, "people.js": 200, "dom.js": 200, "app.js": 409,
    }  # fmt: skip


def test_no_question_is_shown_before_the_person_agreed(desk: Desk, person: Person):
    async def ask() -> str:
        asking = asyncio.create_task(desk.ask("ana", request(), None))
        await asyncio.sleep(0)
        standing = await asyncio.to_thread(person.now)
        assert (standing["waiting"], standing["question"], standing["told"]) == (1, None, "told")
        assert await asyncio.to_thread(person.post, "answer", {"number": 1, "text": "early"}) == 409
        await asyncio.to_thread(person.post, "agree")
        await asyncio.to_thread(person.post, "answer", {"number": 1, "text": "now"})
        return (await asking).text

    assert asyncio.run(ask()) == "now"


@pytest.mark.parametrize(
    "given", [{"number": 2, "text": "x"}, {"number": 1, "text": " "}, {"number": 1}, {"number": 1, "text": 3}, [], {}]
)
def test_what_is_no_answer_to_the_question_that_is_shown_is_refused(desk: Desk, person: Person, given: object):
    async def ask() -> str:
        asking = asyncio.create_task(desk.ask("ana", request(), None))
        await asyncio.sleep(0)
        desk.agree()
        assert await asyncio.to_thread(person.post, "answer", given) == 409
        assert await asyncio.to_thread(person.post, "answer", {"number": 1, "text": "good"}) == 200
        assert await asyncio.to_thread(person.post, "answer", {"number": 1, "text": "twice"}) == 409
        return (await asking).text

    assert asyncio.run(ask()) == "good"


def test_an_answer_too_long_to_be_one_and_what_a_foreign_page_sends_are_refused(person: Person, desk: Desk):
    address = f"{urlsplit(person.url).path}answer"
    assert status(person.url, address, "POST", **{"Content-Length": str((1 << 20) + 1)}) == 409
    assert status(person.url, address, "POST", **{"Content-Length": "-1"}) == 409
    assert status(person.url, address, "POST", **{"Content-Length": "9" * 5_000}) == 409
    token = urlsplit(person.url).path
    for origin in ("http://evil.example", "null"):
        assert status(person.url, f"{token}agree", "POST", Origin=origin, **{"Content-Length": "0"}) == 409
    assert not desk.standing().agreed
    assert status(person.url, f"{token}now?after={'9' * 5_000}") == 200


def test_who_leaves_leaves_all_questions_open_and_is_asked_none_again(desk: Desk, person: Person):
    async def ask() -> list[type]:
        asking = [asyncio.create_task(desk.ask("ana", request(key), None)) for key in "ab"]
        await asyncio.sleep(0)
        await asyncio.to_thread(person.post, "leave")
        found = await asyncio.gather(*asking, desk.ask("ana", request("c"), None), return_exceptions=True)
        return [type(one) for one in found]

    assert asyncio.run(ask()) == [Interrupted] * 3
    assert person.now()["over"]


def shown(desk: Desk, asked: list[tuple[str, Request]]) -> list[str]:
    """Return the prompts in the order in which they are shown."""

    async def ask() -> list[str]:
        asking = [asyncio.create_task(desk.ask(person, request, None)) for person, request in asked]
        await asyncio.sleep(0)
        desk.agree()
        found = []
        for _ in asked:
            question = desk.standing().question
            found.append(question.messages[0].content)
            desk.answer(question.number, "x")
        await asyncio.gather(*asking)
        return found

    return asyncio.run(ask())


def test_questions_come_by_step_or_blind_by_what_tells_nothing_and_person_after_person():
    asked = [("ben", request("a", 1)), ("ana", request("z", 1)), ("ana", request("b", 2))]
    assert shown(Desk(), asked) == ["prompt z", "prompt b", "prompt a"]
    assert shown(Desk(blind=True), asked) == ["prompt b", "prompt z", "prompt a"]


def test_the_seconds_of_an_answer_begin_when_its_question_is_shown():
    now = [1.0]
    desk = Desk(clock=lambda: now[0])

    async def ask() -> tuple[float, float]:
        desk.agree()
        asking = [asyncio.create_task(desk.ask("ana", request(key), None)) for key in "ab"]
        await asyncio.sleep(0)
        now[0] = 6.0
        desk.answer(1, "x")
        now[0] = 8.0
        desk.answer(2, "x")
        first, second = await asyncio.gather(*asking)
        return first.timings["latency"], second.timings["latency"]

    assert asyncio.run(ask()) == (5.0, 2.0)
