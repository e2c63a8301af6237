"""Moments are drawn evenly over what tells them apart, and one at most of an agent in a window."""

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import msgspec
import pytest

from foundry.errors import InputError
from foundry.probing.drawing import Past, drawn, listed, moments_and_past, strata_of
from foundry.records import Attempt, Call
from foundry.storing.run_writer import RunWriter
from foundry.worlds.probe.moments import Moment
from made_up_runs import sweep
from small_worlds import HELLO, greeted, grid


def call(step: int, agent: int, kind: str = "action", text: str = "") -> Call:
    return Call(
        step=step, agent=agent, kind=kind, model="m", digest=None, key="", seed=0, messages=[], parameters={},
        text=text, thinking=None, ending="stop", prompt_tokens=None, output_tokens=None, timings={}, attempts=(),
        host=None, cached=False,
    )  # fmt: skip


def runs(count: int, steps: int, agents: int) -> dict[str, Past]:
    calls = [call(step, agent) for step in range(1, steps + 1) for agent in range(agents)]
    return {f"run{number}": Past(number, calls) for number in range(count)}


def told(recorded: Mapping[str, Past], is_rare: Any) -> dict[Moment, dict[str, str | bool]]:
    return {moment: {"fire": is_rare(moment)} for run, past in recorded.items() for moment in past.moments(run)}


def test_what_is_rare_is_drawn_as_often_as_what_is_not_as_long_as_there_is_any():
    recorded = runs(4, steps=40, agents=10)
    strata = told(recorded, lambda one: one.step > 35)
    moments = drawn(recorded, 64, 0, 5, strata)
    assert len(moments) == 64 and Counter(strata[moment]["fire"] for moment in moments) == {True: 32, False: 32}
    assert set(Counter(moment.run for moment in moments).values()) == {16}
    early = Counter((moment.step - 1) // 5 for moment in moments if not strata[moment]["fire"])
    assert set(early) == set(range(7)) and max(early.values()) - min(early.values()) <= 4
    assert Counter(strata[moment]["fire"] for moment in drawn(recorded, 64, 0, 5, {}))[True] < 16


@pytest.mark.parametrize(("window", "most"), [(5, 4), (1, 20), (0, 20), (20, 1), (7, 3)])
def test_an_agent_gives_one_moment_in_a_window(window: int, most: int):
    recorded = runs(2, steps=20, agents=3)
    moments = drawn(recorded, 1000, 0, window, {})
    assert set(Counter((moment.run, moment.agent) for moment in moments).values()) == {most} and len(
        set(moments)
    ) == len(moments)
    if window:
        assert set(Counter((moment.run, moment.agent, (moment.step - 1) // window) for moment in moments).values()) == {
            1
        }


def test_the_same_seed_draws_the_same_and_without_a_window_all_kinds_of_a_step():
    recorded = runs(2, steps=20, agents=5)
    first, again, other = (drawn(recorded, 10, seed, 5, {}) for seed in (1, 1, 2))
    assert first == sorted(again) == drawn(dict(reversed(recorded.items())), 10, 1, 5, {}) != other
    recorded = {"run": Past(0, [call(1, 0), call(1, 0, "message"), call(1, 0)])}
    assert len(drawn(recorded, 9, 0, 0, {})) == 3 and len(drawn(recorded, 9, 0, 1, {})) == 1


def test_no_recorded_moment_is_more_likely_than_another():
    calls = [call(step, agent, kind) for step in (1, 2, 3, 4) for agent in (0, 1, 2) for kind in ("action", "message")]
    recorded = {run: Past(0, calls) for run in ("a", "b")}
    found = Counter(moment for seed in range(960) for moment in drawn(recorded, 1, seed, 2, {}))
    assert len(found) == 48 and min(found.values()) >= 10 and max(found.values()) <= 40


def test_what_is_taken_of_a_recorded_run_does_not_tell_how_its_calls_were_sent(tmp_path: Path):
    (run,) = sweep(tmp_path / "sweep", models=("first",), seeds=(3,)).runs()
    attempts = (Attempt(error="gone", elapsed_s=0.1, busy=False),)
    sent = {"host": "http://gpu", "attempts": attempts, "served_model": "m", "server_version": "v"}
    writer = RunWriter(run, "")
    writer.append_calls([msgspec.structs.replace(call(1, agent, text=HELLO), **sent) for agent in (0, 1)])
    writer.close()
    assert Past.of(run) == Past(3, [call(1, agent, text=HELLO) for agent in (0, 1)])


OTHERWISE = "was drawn from runs with other answers"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda content: content["runs"]["run1"].update(sha256="0" * 64), OTHERWISE),
        (lambda content: content["runs"]["run1"].update(seed=9), OTHERWISE),
        (lambda content: content["runs"].pop("run1"), OTHERWISE),
        (lambda content: content["moments"].reverse(), OTHERWISE),
        (lambda content: content["moments"].insert(0, content["moments"][0]), OTHERWISE),
        (lambda content: content["moments"][-1].__setitem__(0, "nobody"), "Run 'nobody'"),
        (lambda content: content["runs"].update(nobody=content["runs"].pop("run0")), OTHERWISE),
        (lambda content: content["moments"].clear(), "lists no moment"),
    ],
)
def test_a_file_lists_moments_of_the_recorded_runs_and_is_refused_where_it_is_of_others(
    change: Callable[[dict[str, Any]], object], said: str, tmp_path: Path
):
    recorded, file = runs(2, steps=4, agents=2), tmp_path / "moments.json"
    moments, past = moments_and_past(drawn(recorded, 8, 0, 1, {}), recorded)
    assert {run: max(call.step for call in past.calls) for run, past in past.items()} == {
        run: max(moment.step for moment in moments.moments if moment.run == run) for run in past
    }
    file.write_bytes(msgspec.json.encode(moments))
    assert listed(file, recorded) == moments
    content = msgspec.json.decode(file.read_bytes())
    change(content)
    file.write_bytes(msgspec.json.encode(content))
    with pytest.raises(InputError, match=said):
        listed(file, recorded)


def test_every_recorded_moment_is_told_apart_by_what_its_agent_perceived():
    fire = {"name": "great", "start": 2, "position": [0, 0], "intensity": 0.5, "radius": 50}
    small = grid(half_size=2, fires=[fire])
    pairs = greeted(small)
    past = Past(4, [call(*one.asked, text) for one, text in pairs])
    found = strata_of(small, {"run": past})
    assert list(found) == list(past.moments("run")) and len(found) == len(pairs) == 12
    for (question, _), strata in zip(pairs, found.values(), strict=True):
        x, y = question.observation["x"], question.observation["y"]
        assert strata == {
            "fire": question.step >= 2,
            "message": (question.step, question.kind) != (1, "message"),
            "wall": 2 in (abs(x), abs(y)),
        }
    assert {strata["wall"] for strata in found.values()} == {True, False}
