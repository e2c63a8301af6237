"""What `sweep.yaml` holds is read as YAML reads it, however it is written."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from foundry.expansion import Condition, expand
from foundry.storing.sweep_file import check_shape, sweep_content, sweep_from, sweep_text

TEXTS = st.one_of(
    st.text(max_size=12), st.sampled_from(["\n  seeds:\n  - 1\n", "x\n  seeds:\n  - 3\nruns:\n", "seeds: - 1"])
)


def condition(number: int, task: str, seeds: tuple[int, ...]) -> Condition:
    world: dict[str, Any] = {"name": f"w{number}", "task": task, "seeds": [1, 2], "more": {"seeds": [3]}}
    config = {"world": world, "model": {"name": "m"}, "prompt": {"name": "p"}, "sampling_seed": None}
    return Condition(factors={}, config=config, seeds=seeds, declared=None)


@given(
    asked=st.lists(TEXTS, max_size=2),
    tasks=st.lists(TEXTS, min_size=1, max_size=3),
    seeds=st.lists(st.integers(0, 2**40), min_size=1, max_size=4, unique=True),
)
def test_it_is_read_as_yaml_reads_it(asked: list[str], tasks: list[str], seeds: list[int]) -> None:
    sweep = expand(asked, [condition(number, task, tuple(seeds)) for number, task in enumerate(tasks)])
    text = sweep_text(sweep, {}, [], None)
    assert sweep_content(text, "sweep.yaml") == yaml.safe_load(text)
    assert sweep_from(sweep_content(text, "sweep.yaml")).runs == sweep.runs


@pytest.mark.parametrize("part", ["world", "model", "prompt"])
def test_a_class_that_is_no_text_is_another_shape(part: str) -> None:
    config = {one: {"name": one, "_target_": f"foundry.{one}"} for one in ("world", "model", "prompt")}
    condition = {"factors": {}, "seeds": [0], "config": config | {"sampling_seed": None}}
    content = {"asked": [], "models": [], "settings": {}, "conditions": [condition], "runs": []}
    check_shape(content)
    config[part]["_target_"] = [1]
    condition["config"] = config | {"sampling_seed": None}
    with pytest.raises(ValueError, match="_target_"):
        check_shape(content)


@pytest.mark.parametrize("seeds", [" [0, 1]", "\n    - 0\n    - 1", "\n  - 0\n  - 010", "\n  - 0 # first\n  - 1", ""])
def test_seeds_that_are_written_otherwise_are_read_all_the_same(seeds: str) -> None:
    text = f"conditions:\n- factors: {{}}\n  seeds:{seeds}\n  config: {{}}\nasked: []\nruns:\n"
    text += '- {"id":"a","condition":0,"seed":0}\n'
    assert sweep_content(text, "sweep.yaml") == yaml.safe_load(text)
