"""Workers share what they know of a server: in one process with a clock that is set, and as processes."""

import contextlib
import itertools

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from commands import SMALL, shared, started, succeeds, wait_until
from foundry.models.answers.opening import open_answers
from foundry.models.base import Reply
from foundry.models.serving import InFlight
from foundry.models.wrappers.climbing import Sums
from foundry.models.wrappers.limited import Limit
from foundry.running.build import model_stack
from foundry.running.sharing import PATIENCE_S, SILENT_S, Group, Part, Shared, divided
from models.slot_servers import Timed
from ollama_cases import held
from ollama_server import OllamaServer
from own_backend import Paid

BOUNDS = InFlight(min=1, max=64, initial=8)
MODEL = '{"name": "llama3.2"}'


def worker(name: str, workers: int = 2, **settings) -> tuple[Shared, Limit]:
    shared = Shared(name, workers, **settings)
    return shared, shared.maker(MODEL)(BOUNDS)


def told(*workers: Shared) -> dict[str, dict]:
    return {f"0-{n}": msgspec.json.decode(msgspec.json.encode(shared.report())) for n, shared in enumerate(workers)}


@given(st.integers(1, 600), st.dictionaries(st.sampled_from("abcdefghi"), st.integers(0, 500), min_size=1))
def test_a_limit_is_divided_by_what_each_wants_and_nobody_is_left_without(total, wanted):
    shares = divided(total, wanted)
    assert shares.keys() == wanted.keys() and min(shares.values()) >= 1
    assert sum(shares.values()) <= max(total, len(wanted))
    if sum(wanted.values()) <= total:
        assert all(shares[worker] >= wanted[worker] for worker in wanted)
    assert divided(16, {"a": 2, "b": 40, "c": 40}) == {"a": 2, "b": 7, "c": 7}


@pytest.mark.parametrize(("in_flight", "parts"), [(0, (4, 4)), (30, (7, 1))])
def test_each_worker_waits_with_its_part_until_one_leads_and_has_heard_of_it(in_flight, parts):
    (shared, first), (two, second) = worker("0-0"), worker("0-1")
    first.in_flight = in_flight
    two.exchange(told(shared, two))
    assert (first.allowed, second.allowed, second.is_shared) == (4, 4, True)
    shared.exchange(told(shared, two))
    two.exchange(told(shared, two))
    assert sum(shared.report()[key].total for key in shared.report()) == 8
    assert (first.allowed, second.allowed) == parts and first.is_shared and second.is_shared


def test_a_worker_without_others_begins_where_the_settings_say():
    now = [0.0]
    alone, limit = worker("0-0", clock=lambda: now[0])
    alone.exchange(told(alone))
    assert (limit.allowed, limit.is_shared) == (4, True)
    now[0] += PATIENCE_S
    alone.exchange(told(alone))
    assert (limit.allowed, limit.is_shared) == (BOUNDS.initial, False)


def test_what_was_refused_while_a_worker_had_not_heard_of_a_lower_limit_does_not_lower_it_again():
    def parts(calls: float, refused: float, allowed: int) -> dict[str, Part]:
        return {name: Part(Sums(calls=calls, refused=refused), 40, allowed, 0, {}) for name in ("0-0", "0-1")}

    group = Group(BOUNDS, 32)
    for calls, refused in ((0.0, 0.0), (20.0, 40.0)):
        group.take(parts(calls, refused, 16))
    assert group.total == 16
    group.take(parts(40.0, 80.0, 16))
    assert group.total == 16
    group.take(parts(60.0, 120.0, 8))
    assert group.total == 8


def test_when_the_leader_falls_silent_the_next_one_goes_on_from_its_limit():
    now = [0.0]
    (shared, _), (two, second) = worker("0-0"), worker("0-1", clock=lambda: now[0])
    shared.exchange(told(shared, two))
    last = told(shared)
    two.exchange(last)
    assert second.is_shared
    now[0] += SILENT_S
    two.exchange(last)
    assert (second.allowed, second.is_shared) == (8, False)


def test_a_worker_that_still_reports_is_not_silent():
    now = [0.0]
    (shared, limit), (two, second) = worker("0-0"), worker("0-1", clock=lambda: now[0])
    for _ in range(3):
        limit.note_reply(Reply(text=""), 0.0)
        two.exchange(told(shared))
        now[0] += SILENT_S
    assert second.is_shared


def test_workers_that_never_hear_of_each_other_divide_the_bounds_as_do_those_of_other_versions():
    shared, limit = worker("0-0", 4, apart=True)
    assert limit.bounds == InFlight(min=1, max=16, initial=2)
    shared.exchange(told(shared))
    assert (limit.allowed, limit.is_shared) == (2, False)
    alone, limit = worker("0-0", 1)
    alone.exchange({"0-1": {"server": {"sums": "many"}}})
    assert not limit.is_shared


@pytest.mark.parametrize(("slots", "told_of"), [(16, True), (16, False), (64, False)])
def test_what_two_workers_saw_leads_to_the_limit_of_the_server_and_not_to_twice_that(slots, told_of):
    server, group = Timed(slots=slots, tells_queue=told_of), Group(BOUNDS, 2)

    class Half:
        """Two workers with half of the calls each; one reads both reports after every tenth answer."""

        limit = 2

        def look(self, sums: Sums) -> None:
            if sums.calls % 10 == 0:
                half = Sums(*(value / 2 for value in msgspec.structs.astuple(sums)))
                half.clock_s = sums.clock_s
                group.take({name: Part(half, 40, 1, 1, {}) for name in ("0-0", "0-1")})
                self.limit = group.total

    half = Half()
    server.serve(2000, half)
    before = server.sums.copy()
    server.serve(2000, half)
    later = server.sums - before
    assert server.rate(2000) >= 0.9 * slots
    assert later.in_flight_s / later.clock_s <= 1.6 * slots
    assert set(group.shares) == {"0-0", "0-1"} and abs(group.shares["0-0"] - group.shares["0-1"]) <= 1


def test_what_a_worker_did_before_it_was_first_seen_does_not_count():
    group = Group(BOUNDS, 8)
    idle, busy = (Part(Sums(*[value] * 12), 8, 4, 4, {}) for value in (0.0, 1e6))
    for parts in ({"0-0": idle, "0-1": idle}, {"0-0": idle, "0-1": idle}, {"0-0": idle, "0-2": busy}):
        group.take(parts)
    assert group.total == 8


@pytest.mark.parametrize(("in_process", "made"), [(False, 1), (True, 0)])
def test_a_model_that_answers_within_its_worker_has_a_limit_of_its_own(in_process, made, tmp_path):
    model = Paid("paid")
    model.in_process = in_process
    shared = Shared("0-0", 2)
    with contextlib.closing(open_answers(str(tmp_path / "answers.sqlite"))) as answers:
        model_stack(model, lambda: answers, limit=shared.maker(MODEL))
    assert len(shared.limits) == made


@pytest.mark.parametrize(("open_runs", "least", "most"), [(2, 5, 64), (1, 1, 2)])
def test_where_a_server_has_room_more_runs_are_opened_than_said_unless_one_was_said(
    open_runs, least, most, workspace, monkeypatch
):
    """Each of the runs has two agents, which are asked at once and answered after the worker saw room several times."""
    monkeypatch.setattr("foundry.running.lane.REPORT_EVERY_S", 0.01)
    have_room, rooms = Shared.have_room, itertools.count()

    def look(worker: Shared) -> bool:
        room = have_room(worker)
        if room and next(rooms) >= 5 and server.counts.in_flight >= least:
            server.free()
        return room

    monkeypatch.setattr(Shared, "have_room", look)
    asked = ("-m", "seed=0-11", "world.agents=2", "world.steps=2", "analyze=false", f"runner.open_runs={open_runs}")
    limit = "model.server.in_flight={min: 64, max: 64, initial: 64}"
    with OllamaServer(held) as server:
        succeeds(*asked, limit, cwd=workspace, OLLAMA_HOST=server.url)
    assert least <= server.counts.most_in_flight <= most


NEVER_ALONE = "from foundry.running import sharing\nsharing.PATIENCE_S = sharing.SILENT_S = float('inf')\n"
"""Workers take no other to be gone, however busy the machine is."""


@pytest.mark.slow
def test_two_workers_together_keep_to_the_limit_of_one_server(workspace):
    (workspace / "sitecustomize.py").write_text(NEVER_ALONE)
    limit = "model.server.in_flight={min: 4, max: 4, initial: 4}"
    asked = ("-m", "seed=0-3", *SMALL, limit, "runner.workers=2", "runner.open_runs=1", "output.dir=sweep")
    to = {"PYTHONPATH": str(workspace)}
    with OllamaServer(held) as server, started(*asked, cwd=workspace, OLLAMA_HOST=server.url, **to) as process:
        wait_until(lambda: shared(workspace / "sweep") == [2, 2], "they share the limit", process)
        wait_until(lambda: server.counts.in_flight >= 4, "as many calls as allowed are in flight", process)
        server.free()
        output, _ = process.communicate()
    assert process.returncode == 0, output
    assert 4 <= server.counts.most_in_flight <= 6
