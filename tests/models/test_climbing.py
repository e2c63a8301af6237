"""The climb, in a time that only its servers' events move on."""

import math

import pytest

from foundry.models.serving import InFlight
from foundry.models.wrappers.climbing import Climb, Measured, Sums
from foundry.models.wrappers.limited import climb_within
from models.slot_servers import Timed


def climb(initial: int = 4, **changes: int) -> Climb:
    return Climb(**{"least": 1, "most": 512, "initial": initial, **changes})


def batched(batch: int) -> float:
    """A full batch of 256 takes each of its calls three times as long."""
    return 1 + 2 * batch / 256


SERVERS = {
    "one slot, told": (dict(slots=1, tells_queue=True), 1, 1500),
    "4 slots, told": (dict(slots=4, tells_queue=True), 5, 1500),
    "16 slots, told": (dict(slots=16, tells_queue=True), 17, 2500),
    "16 slots, told, much that is no queue": (dict(slots=16, tells_queue=True, overhead=0.5), 25, 2500),
    "16 slots, silent": (dict(slots=16), 17, 2500),
    "16 slots, silent of tokens too": (dict(slots=16, tells_tokens=False), 17, 4000),
    "64 slots whose batches slow down": (dict(slots=64, slowdown=batched), 64, 4000),
    "256 slots whose batches slow down": (dict(slots=256, slowdown=batched), 256, 5000),
    "no slots, slower beyond 24": (dict(slots=1000, slowdown=lambda batch: max(1, (batch / 24) ** 1.5)), 24, 3000),
}


@pytest.mark.parametrize("name", SERVERS)
def test_in_the_long_run_the_throughput_is_nearly_the_best_with_little_more_in_flight(name):
    settings, best, calls = SERVERS[name]
    ideal = Timed(**settings, seed=9)
    ideal.serve(1500, fixed=best)
    server, found = Timed(**settings, seed=1), climb(initial=8 if settings.get("tells_queue") else 4)
    server.serve(calls // 2, found)
    before = server.sums.copy()
    server.serve(calls // 2, found)
    later = server.sums - before
    assert server.rate(calls // 2) >= 0.9 * ideal.rate(1000)
    assert later.in_flight_s / later.clock_s <= 1.6 * best + 1
    assert server.most_queued <= 512


@pytest.mark.parametrize("seed", range(5))
def test_of_eight_calls_in_flight_to_a_single_slot_two_are_left_after_few_answers(seed: int):
    server, found = Timed(slots=1, tells_queue=True, seed=seed), climb(initial=8)
    server.serve(16, found)
    assert found.limit == 2
    server.serve(300, found)
    assert found.limit <= 3


def test_from_the_slots_that_a_server_tells_only_refusals_lower_the_limit_and_it_comes_back():
    in_flight = InFlight(min=1, max=512, initial=16).from_slots(8)
    server = Timed(slots=8, spread=1.2, tells_queue=True, overhead=1.0)  # such as a long way to the server
    climb = climb_within(in_flight, in_flight.initial, known=False)
    limits = set()
    for _ in range(3000):
        server.serve(1, climb)
        limits.add(climb.limit)
    assert limits == {9}
    server.sums.refused += 100
    climb.look(server.sums)
    assert climb.limit == 4
    server.serve(3000, climb)
    assert climb.limit == 9


@pytest.mark.parametrize(("before", "after"), [(16, 4), (4, 16)])
@pytest.mark.parametrize("told", [True, False])
def test_a_server_whose_slots_change_is_followed(before, after, told):
    server, found = Timed(slots=before, changes={1000: after}, tells_queue=told), climb(initial=8)
    server.serve(3500, found)
    server.serve(500, found)
    assert server.rate(500) >= 0.8 * after
    assert found.limit <= 2.5 * after


def test_a_limit_on_the_calls_per_second_is_approached_and_little_is_refused():
    server, found = Timed(slots=1000, per_unit=50), climb()
    server.serve(2000, found)
    server.refused = 0
    server.serve(2000, found)
    assert server.rate(2000) >= 0.8 * 50
    assert server.refused <= 0.15 * 2000


def test_the_limit_falls_to_its_half_when_most_is_refused_and_stays_where_little_is():
    found, sums = climb(initial=64), Sums(calls=20.0)
    found.look(sums)
    sums.refused = 40.0
    found.look(sums)
    assert found.limit == 32
    found, sums = climb(initial=64), Sums()
    for calls in range(1, 60):
        sums.calls, sums.refused = float(calls), 3.0
        found.look(sums)
    assert found.limit == 64


def test_the_limit_never_leaves_its_bounds_and_is_fixed_where_they_are_one_number():
    narrow = climb(initial=4, least=3, most=6)
    server = Timed(slots=100)
    limits = set()
    for _ in range(400):
        server.serve(1, narrow)
        limits.add(narrow.limit)
    assert limits <= {3, 4, 5, 6} and 6 in limits
    for _ in range(20):
        server.sums.refused += 100
        narrow.look(server.sums)
    assert narrow.limit == 3
    server, fixed = Timed(slots=4, tells_queue=True), climb(initial=9, least=9, most=9)
    server.serve(500, fixed)
    assert fixed.limit == 9


def test_nothing_is_learnt_where_too_few_calls_are_there_to_reach_the_limit():
    server, found = Timed(slots=100, runs=1), climb(initial=32)
    server.serve(2000, found)
    assert found.limit == 32


def test_a_limit_that_was_found_before_does_not_grow_at_once():
    known, unknown = (Climb(least=1, most=512, initial=16, known=is_known) for is_known in (True, False))
    Timed(slots=16).serve(100, known)
    Timed(slots=16).serve(100, unknown)
    assert (known.limit, unknown.limit) == (16, 64)


def test_the_sums_of_two_workers_say_what_one_worker_with_both_their_calls_would():
    one, two = Timed(slots=8, seed=1), Timed(slots=8, seed=2)
    one.serve(300, fixed=8)
    two.serve(300, fixed=8)
    both = one.sums + two.sums
    found = Measured.of(both, 2)
    assert found.calls == 600 and math.isclose(found.in_flight, 16)
    assert (both - two.sums).work == pytest.approx(one.sums.work)
