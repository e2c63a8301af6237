"""Answers that wait for a confirmation, over both kinds of cache, with several processes' views of one."""

import asyncio
from dataclasses import replace
from typing import Any

import pytest

from databases import Store
from foundry.errors import ModelChangedError
from foundry.models.answers.unconfirmed import Unconfirmed
from foundry.models.base import Model, ModelInfo, Reply, Request
from foundry.models.wrappers.confirmed import ConfirmedModel
from models.asking import make_request

HOST, OTHER_HOST = "http://one:1", "http://two:2"
FIRST = ModelInfo("m", digest="d4" * 32, states={HOST: "monday"})
SECOND = replace(FIRST, digest="ff" * 32)
WRITTEN_ANEW = replace(FIRST, states={HOST: "tuesday"})


def reply(text: str, host: str | None = HOST, version: str | None = None) -> Reply:
    return Reply(text=text, host=host, server_version=version)


@pytest.fixture
def views(store: Store):
    """Open as many views of the cache as asked for, each as a process of its own would."""
    opened = []

    def view(info: ModelInfo | None = FIRST, **settings) -> Unconfirmed:
        opened.append(store.open())
        return Unconfirmed(opened[-1], info, **settings)

    yield view
    for answers in opened:
        answers.close()


def test_an_answer_is_used_before_it_is_confirmed_and_by_other_processes_too(views):
    one, two = views(), views()
    one.keep({"k": reply("left")}, "m")
    assert two.find(["k"]) == {"k": reply("left")}
    assert one.any_used and two.any_used


def test_one_confirmation_holds_for_all_processes(views):
    one, two = views(), views()
    one.keep({"k": reply("left")}, "m")
    two.find(["k"])
    two.settle(two.moment(), FIRST)
    one.settle(one.moment(), FIRST)
    assert not one.any_used and not two.any_used
    assert views().find(["k"]) != {} and not views(SECOND).any_used
    third = views()
    third.find(["k"])
    assert not third.any_used


def test_what_came_after_the_server_was_asked_stays_unconfirmed(views):
    one = views()
    one.keep({"early": reply("left")}, "m")
    moment = one.moment()
    one.keep({"late": reply("right")}, "m")
    one.settle(moment, FIRST)
    assert one.any_used
    with pytest.raises(ModelChangedError, match="ffffffffffff now") as changed:
        one.settle(one.moment(), SECOND)
    assert (changed.value.keys, changed.value.removed) == ({"late"}, 1)
    assert views().find(["early", "late"]).keys() == {"early"}


def test_what_others_left_unconfirmed_is_removed_with_the_own(views):
    views().keep({"left behind": reply("left")}, "m")
    one = views()
    one.keep({"k": reply("right")}, "m")
    with pytest.raises(ModelChangedError) as changed:
        one.settle(one.moment(), SECOND)
    assert changed.value.removed == 2
    assert views().find(["left behind", "k"]) == {}


def test_whoever_used_an_answer_that_another_process_removed_is_told_even_if_the_weights_are_back(views):
    one, two, third = views(), views(), views()
    one.keep({"k": reply("left")}, "m")
    two.find(["k"])
    with pytest.raises(ModelChangedError):
        one.settle(one.moment(), SECOND)
    with pytest.raises(ModelChangedError, match="another process found different weights") as changed:
        two.settle(two.moment(), FIRST)
    assert changed.value.keys == {"k"}
    third.keep({"k": reply("right")}, "m")
    with pytest.raises(ModelChangedError):  # which of the two removed it cannot be told, so it is asked again
        third.settle(third.moment(), FIRST)
    begun_later = views()
    begun_later.keep({"k": reply("right")}, "m")
    begun_later.settle(begun_later.moment(), FIRST)
    assert views().find(["k"]) == {"k": reply("right")}


def test_an_unconfirmed_answer_of_another_server_or_of_weights_written_anew_is_as_good_as_absent(views):
    views().keep({"k": reply("left")}, "m")
    elsewhere = views(replace(FIRST, states={OTHER_HOST: "monday"}))
    anew = views(WRITTEN_ANEW)
    assert elsewhere.find(["k"]) == anew.find(["k"]) == {}
    both = views(replace(FIRST, states={OTHER_HOST: "monday", HOST: "monday"}))
    assert both.find(["k"]) == {"k": reply("left")}


def test_an_answer_that_replaces_an_unconfirmed_one_waits_for_its_own_servers_confirmation(views):
    views().keep({"k": reply("left")}, "m")
    anew = views(WRITTEN_ANEW)
    anew.keep({"k": reply("right")}, "m")
    first = views()
    first.settle(first.moment(), FIRST)
    assert first.find(["k"]) == {}
    anew.settle(anew.moment(), WRITTEN_ANEW)
    assert first.find(["k"]) == {"k": reply("right")}


def test_nothing_is_kept_or_used_once_the_server_is_known_to_be_another(views):
    one, two = views(), views()
    one.keep({"k": reply("left")}, "m")
    with pytest.raises(ModelChangedError):
        one.settle(one.moment(), WRITTEN_ANEW)
    with pytest.raises(ModelChangedError):
        one.keep({"late": reply("right")}, "m")
    two.keep({"late": reply("right")}, "m")
    with pytest.raises(ModelChangedError):
        one.find(["late"])


def test_answers_of_a_model_that_cannot_change_are_confirmed_at_once(views):
    local = views(None)
    local.keep({"k": reply("left")}, "m")
    assert not local.any_used and views().find(["k"]) == {"k": reply("left")}


def test_replies_that_name_other_weights_are_refused_also_when_they_come_from_the_cache(views):
    def told(reply: Reply) -> dict[str, str]:
        return {"fingerprint": reply.server_version} if reply.server_version else {}

    views().keep({"k": reply("left", version="fp_1"), "l": reply("right")}, "m")
    one = views(weights_of=told)
    one.check(reply("up", OTHER_HOST, "fp_1"))
    one.check(reply("up", version="fp_2"))
    assert one.find(["l"]).keys() == {"l"}
    with pytest.raises(ModelChangedError, match="replies first reported fingerprint 'fp_2', and now report 'fp_1'"):
        one.find(["k"])


class Steady(Model):
    """Answers over a connection that stays open; counts how often its server is asked what it is."""

    name = "m"
    info, inspected = FIRST, 0

    def parameters(self) -> dict[str, Any]:
        return {}

    async def ask(self, request: Request) -> Reply:
        return reply("left")

    async def inspect(self) -> ModelInfo:
        self.inspected += 1
        return self.info


def test_weights_replaced_behind_a_connection_that_stays_open_are_noticed_after_a_minute(views):
    inner, now, inspected = Steady(), [0.0], []
    model = ConfirmedModel(inner, views(), FIRST, clock=lambda: now[0])

    def ask(after_s: float) -> None:
        now[0] += after_s
        asyncio.run(model.ask(make_request()))
        inspected.append(inner.inspected)

    for after_s in (0, 59, 1, 0, 59, 61, 60):
        ask(after_s)
    assert inspected == [1, 1, 2, 2, 2, 3, 4]
    inner.info = SECOND
    ask(59)
    with pytest.raises(ModelChangedError, match="ffffffffffff now"):
        ask(1)


class Forgetful(Steady):
    """Opens a connection for each call."""

    opened = 0

    @property
    def connections(self) -> int:
        return self.opened

    async def ask(self, request: Request) -> Reply:
        self.opened += 1
        return reply("left")


def test_a_server_that_opens_a_connection_for_each_call_is_not_asked_after_each(views):
    inner = Forgetful()
    model = ConfirmedModel(inner, views(), FIRST, clock=lambda: 0.0)
    asyncio.run(model.ask_all([make_request()] * 400))
    assert 32 < inner.inspected <= 32 + 400 // 20 + 2
