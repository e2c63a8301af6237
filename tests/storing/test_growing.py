"""A recorded sweep that grows: pure, and in `sweep.yaml`, which is read as YAML reads it however it is written."""

import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace as changed

from declared_forms import GRID
from foundry.declared import Declared
from foundry.errors import InputError, RecordError
from foundry.expansion import Condition, Sweep, expand
from foundry.storing import store
from foundry.storing.growing import growth
from foundry.storing.run_files import PROBE, claimed
from foundry.storing.store import SweepFolder
from foundry.storing.sweep_file import check_shape, sweep_content, sweep_from, sweep_text


def condition(name: str = "a", *, seeds: tuple[int, ...] = (0, 1), steps: object = 3, **changes: object) -> Condition:
    config = {
        "world": {"name": "w", "steps": steps},
        "model": {"name": name},
        "prompt": {"name": "paper"},
        "sampling_seed": None,
        "record": {"frames": False},
        **changes,
    }
    return Condition(factors={}, config=config, seeds=seeds)


def sweep(*conditions: Condition) -> Sweep:
    return expand(["-m"], conditions)


def refusal(there: Sweep, asked: Sweep) -> str:
    with pytest.raises(InputError) as raised:
        growth(there, asked)
    return str(raised.value)


def test_seeds_and_models_are_added_behind_what_is_there():
    there = sweep(condition("b"))
    found = growth(there, sweep(condition("a"), condition("b", seeds=(3, 1))))
    assert [(condition.config["model"]["name"], condition.seeds) for condition in found.sweep.conditions] == [
        ("b", (0, 1, 3)),
        ("a", (0, 1)),
    ]
    assert found.sweep.runs[:2] == there.runs and len(found.new) == 3
    assert [run.condition for run in found.sweep.runs] == [0, 0, 0, 1, 1]


def test_runs_that_are_there_keep_the_ids_that_they_were_recorded_with():
    there = sweep(condition(seeds=(0,)))
    renamed = replace(there, runs=(replace(there.runs[0], id="an-older-id"),))
    assert [run.id for run in growth(renamed, sweep(condition(seeds=(5,)))).sweep.runs][:1] == ["an-older-id"]
    with pytest.raises(RecordError, match="under a different id"):
        growth(renamed, there)


def test_seeds_are_added_to_the_first_of_conditions_that_decide_the_same_runs():
    one, other = (replace(condition(record={"frames": every}), factors={"record.frames": every}) for every in (1, 5))
    found = growth(sweep(one, other), sweep(replace(other, seeds=(7,))))
    assert {run.condition for run in found.sweep.runs} == {0} and len(found.sweep.runs) == 3


def test_what_is_there_already_adds_nothing():
    there = sweep(condition("a"), condition("b"))
    found = growth(there, sweep(condition("b", seeds=(1,))))
    assert (found.sweep, found.new, found.notes("s")) == (there, frozenset(), [])


def test_how_a_model_is_reached_is_no_difference():
    near, far = ({"name": "a", "server": {"hosts": hosts}} for hosts in ("near", "far"))
    assert growth(sweep(condition(model=near)), sweep(condition(model=far))).new == frozenset()


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (condition(steps=4), "world.steps was 3 and is 4 now"),
        (condition(steps=4, seeds=(7,)), "world.steps was 3 and is 4 now"),
        (condition("other", steps=4), "settings of world 'w' would differ"),
        (condition(prompt={"name": "paper", "wording": "new"}), 'prompt.wording was not set and is "new" now'),
        (condition(sampling_seed=1), "sampling_seed was null and is 1 now"),
        (condition(record={"frames": 5}), "record.frames was false and is 5 now"),
        (condition(fork={"run": "r"}), 'settings would differ: fork.run was not set and is "r" now'),
    ],
)
def test_a_condition_that_is_set_otherwise_is_refused_with_the_difference(asked: Condition, said: str):
    assert said in refusal(sweep(condition()), sweep(asked))


def test_a_long_difference_is_cut():
    options = {"name": "w", **{f"option_{number}": number for number in range(9)}}
    assert "; and 7 more. Use" in refusal(sweep(condition()), sweep(condition(world=options)))
    wording = {"name": "paper", "wording": "\u202e" + "x" * 99}
    assert '"\\u202e' + "x" * 50 + "... now" in refusal(sweep(condition()), sweep(condition(prompt=wording)))


@pytest.mark.parametrize("swept", ["there", "asked"])
def test_a_setting_of_which_there_are_several_values_may_have_one_more(swept: str):
    several, one = sweep(condition(steps=3), condition(steps=4)), sweep(condition(steps=3))
    more = {"there": sweep(condition(steps=5)), "asked": sweep(condition(steps=3), condition(steps=5))}[swept]
    assert len(growth(several if swept == "there" else one, more).new) == 2


def test_several_values_of_one_setting_excuse_no_other():
    there = sweep(condition(steps=3), condition(steps=4))
    asked = sweep(condition(world={"name": "w", "steps": 5, "agents": 9}))
    assert "world.agents was not set and is 9 now" in refusal(there, asked)


@pytest.mark.parametrize(("part", "path"), [("record", "record.frames"), ("fork", "fork.run")])
def test_several_values_of_what_is_recorded_or_continued_excuse_no_further_one(part: str, path: str):
    key = path.partition(".")[2]
    one, other, third = ({part: {key: value, "also": min(value, 2)}} for value in (1, 2, 3))
    there = sweep(condition("a", **one), condition("b", **other))
    assert growth(there, sweep(condition("c", **other))).new
    for asked in (sweep(condition("c", **third)), sweep(condition("c", **one), condition("d", **third))):
        told = refusal(there, asked)
        assert f"would differ: {path} was 2 and is 3 now. Use" in told and "ask for both values" not in told


def test_worlds_whose_settings_follow_the_seed_grow_by_seeds():
    there = sweep(*(condition(steps=seed, seeds=(seed,)) for seed in range(3)))
    assert len(growth(there, sweep(condition(steps=7, seeds=(7,)))).new) == 1


def test_the_file_keeps_what_was_asked_and_when(tmp_path: Path):
    models = [{"name": "a", "digest": "d1", "server_version": None}]
    SweepFolder.create(tmp_path / "s", sweep(condition()), {"view": None}, models)
    more = expand(["-m", "model=b"], [condition("b"), condition()])
    SweepFolder.create(tmp_path / "s", more, {"view": 1}, [{"name": "b", "digest": "d2", "server_version": None}])
    found = SweepFolder.open(tmp_path / "s")
    assert [(asked.overrides, asked.runs) for asked in found.sweep.history] == [(("-m",), 2), (("-m", "model=b"), 2)]
    assert all(asked.when and asked.when.endswith("+00:00") for asked in found.sweep.history)
    assert found.settings == {"view": None}
    assert [model["digest"] for model in found.models] == ["d1", "d2"]


OTHER, D = changed(GRID, form="other"), "d" * 64


@pytest.mark.parametrize(("then", "now"), [(None, GRID), (GRID, GRID), (GRID, OTHER), (GRID, None)])
def test_a_sweep_goes_on_only_with_worlds_that_say_of_its_records_what_they_said(
    then: Declared | None, now: Declared | None, tmp_path: Path
):
    SweepFolder.create(tmp_path / "s", sweep(replace(condition(), declared=then)), {}, [])
    asked = sweep(replace(condition(seeds=(0, 7)), declared=now), replace(condition("b"), declared=OTHER))
    same = then in (None, now)
    with nullcontext() if same else pytest.raises(InputError, match="records of world 'w' have changed"):
        SweepFolder.create(tmp_path / "s", asked, {}, [])
    assert len(SweepFolder.open(tmp_path / "s").runs()) == (5 if same else 2)


@pytest.mark.parametrize(("then", "now"), [(None, D), (D, D), (D, None), (D, "e" * 64)])
def test_a_sweep_goes_on_only_with_weights_that_are_not_known_to_be_others(
    then: str | None, now: str | None, tmp_path: Path
):
    SweepFolder.create(tmp_path / "s", sweep(condition()), {}, [{"name": "a", "digest": then, "server_version": None}])
    models = [{"name": name, "digest": digest, "server_version": None} for name, digest in (("a", now), ("b", "f"))]
    same = None in (then, now) or then == now
    told = r"\(digest d{12} then, e{12} now\). Restore the first weights"
    with nullcontext() if same else pytest.raises(InputError, match=told):
        SweepFolder.create(tmp_path / "s", sweep(condition("b")), {}, models)
    assert len(SweepFolder.open(tmp_path / "s").runs()) == (4 if same else 2)


def test_probes_and_whole_runs_are_not_in_one_sweep():
    whole, probe = sweep(condition()), sweep(condition(world={"_target_": PROBE, "name": "p"}))
    assert "contains a sweep of whole runs, and a probe cannot be added to it" in refusal(whole, probe)
    assert "contains a probe, and whole runs cannot be added to it" in refusal(probe, whole)


def test_a_file_without_a_history_has_one_entry(tmp_path: Path):
    SweepFolder.create(tmp_path / "s", sweep(condition()), {}, [])
    file = tmp_path / "s" / "sweep.yaml"
    text = file.read_text()
    start, end = text.index("history:"), text.index("definition:")
    file.write_text(text[:start] + text[end:])
    (only,) = SweepFolder.open(tmp_path / "s").sweep.history
    assert (only.overrides, only.when, only.runs) == (("-m",), None, 2)


def test_what_adds_nothing_leaves_the_file_as_it_is(tmp_path: Path):
    SweepFolder.create(tmp_path / "s", sweep(condition()), {}, [])
    before = (tmp_path / "s" / "sweep.yaml").stat()
    SweepFolder.create(tmp_path / "s", sweep(condition(seeds=(1,))), {}, [])
    assert (tmp_path / "s" / "sweep.yaml").stat().st_ino == before.st_ino


def test_one_that_grows_a_sweep_waits_for_another_that_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    SweepFolder.create(tmp_path / "s", sweep(condition()), {}, [])
    comes = threading.Event()

    def coming(path: Path, wait_s: float = 0.0) -> AbstractContextManager[bool]:
        comes.set()
        return claimed(path, wait_s)

    monkeypatch.setattr(store, "claimed", coming)
    with ThreadPoolExecutor(1) as pool:
        with claimed(tmp_path / "s" / "locks" / "sweep.lock"):
            grown = pool.submit(SweepFolder.create, tmp_path / "s", sweep(condition("b")), {}, [])
            comes.wait()
        assert grown.result().sweep == sweep(condition("b"))


def test_one_that_waited_in_vain_for_another_that_grows_the_sweep_adds_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(store, "WAIT_S", 0.0)
    SweepFolder.create(tmp_path / "s", sweep(condition()), {}, [])
    before = (tmp_path / "s" / "sweep.yaml").read_bytes()
    with claimed(tmp_path / "s" / "locks" / "sweep.lock") as mine, pytest.raises(InputError, match="Try again"):
        assert mine
        SweepFolder.create(tmp_path / "s", sweep(condition("b")), {}, [])
    assert (tmp_path / "s" / "sweep.yaml").read_bytes() == before


@pytest.mark.parametrize("name", ["a", "b"])
def test_two_that_begin_one_sweep_at_once_both_have_it(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    first, second = sweep(condition("a")), sweep(condition(name))

    def just_begun(path: Path, wait_s: float = 0.0) -> AbstractContextManager[bool]:
        monkeypatch.setattr(store, "claimed", claimed)
        SweepFolder.create(tmp_path / "s", first, {}, [])
        return claimed(path, wait_s)

    monkeypatch.setattr(store, "claimed", just_begun)
    assert SweepFolder.create(tmp_path / "s", second, {}, []).sweep == second
    asked = {run.id for run in (*first.runs, *second.runs)}
    assert {run.id for run in SweepFolder.open(tmp_path / "s").runs()} == asked


def test_what_another_that_begins_the_same_sweep_writes_meanwhile_is_not_foreign(tmp_path: Path):
    (tmp_path / "s" / "locks").mkdir(parents=True)
    for name in (".probe.7", ".sweep.yaml.7.8.tmp", ".multirun.yaml.7.8.tmp"):
        (tmp_path / "s" / name).touch()
    SweepFolder.create(tmp_path / "s", sweep(condition()), {}, [])
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / ".git").mkdir()
    with pytest.raises(InputError, match="files that are not a sweep"):
        SweepFolder.create(tmp_path / "other", sweep(condition()), {}, [])


def test_a_command_that_ends_leaves_the_locks_of_one_by_which_the_sweep_grew_meanwhile(tmp_path: Path):
    first = SweepFolder.create(tmp_path / "s", sweep(condition(seeds=(0,))), {}, [])
    first.start_progress()
    more = SweepFolder.create(tmp_path / "s", sweep(condition(seeds=(1,))), {}, [])
    for run in first.runs():
        run.path.mkdir(parents=True)
        (run.path / "run.json").write_text("{}")
    (begun,) = more.runs()
    with begun.claim() as mine:
        assert mine
        first.end_progress()
        with begun.claim() as again:
            assert not again


TEXTS = st.one_of(
    st.text(max_size=12), st.sampled_from(["\n  seeds:\n  - 1\n", "x\n  seeds:\n  - 3\nruns:\n", "seeds: - 1"])
)


def with_task(number: int, task: str, seeds: tuple[int, ...]) -> Condition:
    world: dict[str, Any] = {"name": f"w{number}", "task": task, "seeds": [1, 2], "more": {"seeds": [3]}}
    config = {"world": world, "model": {"name": "m"}, "prompt": {"name": "p"}, "sampling_seed": None}
    return Condition(factors={}, config=config, seeds=seeds, declared=None)


@given(
    asked=st.lists(TEXTS, max_size=2),
    tasks=st.lists(TEXTS, min_size=1, max_size=3),
    seeds=st.lists(st.integers(0, 2**40), min_size=1, max_size=4, unique=True),
)
def test_it_is_read_as_yaml_reads_it(asked: list[str], tasks: list[str], seeds: list[int]) -> None:
    sweep = expand(asked, [with_task(number, task, tuple(seeds)) for number, task in enumerate(tasks)])
    text = sweep_text(sweep, {}, [], None)
    assert sweep_content(text, "sweep.yaml") == yaml.safe_load(text)
    assert sweep_from(sweep_content(text, "sweep.yaml")).runs == sweep.runs


@pytest.mark.parametrize("part", ["world", "model", "prompt"])
def test_a_class_that_is_no_text_is_another_shape(part: str) -> None:
    config = {one: {"name": one, "_target_": f"foundry.{one}"} for one in ("world", "model", "prompt")}
    conditions = [{"factors": {}, "seeds": [0], "config": {**config, "sampling_seed": None}}]
    content = {"asked": [], "models": [], "settings": {}, "conditions": conditions, "runs": []}
    check_shape(content)
    config[part]["_target_"] = [1]
    with pytest.raises(ValueError, match="_target_"):
        check_shape(content)


@pytest.mark.parametrize("seeds", [" [0, 1]", "\n    - 0\n    - 1", "\n  - 0\n  - 010", "\n  - 0 # first\n  - 1", ""])
def test_seeds_that_are_written_otherwise_are_read_all_the_same(seeds: str) -> None:
    text = f"conditions:\n- factors: {{}}\n  seeds:{seeds}\n  config: {{}}\nasked: []\nruns:\n"
    text += '- {"id":"a","condition":0,"seed":0}\n'
    assert sweep_content(text, "sweep.yaml") == yaml.safe_load(text)
