"""`foundry check edit=` finds what an edit of one's own does wrong."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from commands import foundry, refusal
from foundry.conformance.checking import CHECKS
from foundry.conformance.edits import EditCase
from foundry.conformance.playing import Status, WorldCase, examine
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question
from foundry.worlds.probe.editing import Edit, observing
from small_worlds import grid

_numbers: Iterator[int] = iter(range(10**6))
PROMPT = Prompt("own", dict.fromkeys(("message", "action"), "You are at {{ x }}."))
_SIDES = {"left": "right", "right": "left"}


def broken(change: Callable[[Question], Question | None], leaves: str = "cause", **said: Any) -> dict[str, str]:
    """Return the notes of the checks that an edit fails, by their names."""
    case = EditCase(Edit("own", leaves, change, **said), WorldCase(partial(grid, steps=2), lambda: PROMPT))
    findings = examine("edit", CHECKS["edit"], case)
    return {finding.check: finding.note for finding in findings if finding.status is Status.FAILED}


def emptied(question: Question) -> Question:
    question.observation["neighbours"].clear()
    return observing(question, neighbours=[1])


def mirrored(question: Question) -> Question:
    return observing(question, x=-question.observation["x"])


def test_what_holds_passes():
    assert broken(lambda question: observing(question, half_size=3)) == {}
    assert broken(mirrored, "equivariance", expected=lambda one: _SIDES.get(one, one)) == {}


@pytest.mark.parametrize(
    ("change", "check"),
    [
        (lambda one: replace(one, step=one.step + 1), "asks the same"),
        (lambda one: replace(one, agent=7), "asks the same"),
        (lambda one: replace(one, observation={**one.observation, "more": 1}), "keeps what templates name"),
        (lambda one: observing(one, x={1, 2}), "keeps what templates name"),
        (lambda one: replace(one, images=(b"",)), "keeps what templates name"),
        (emptied, "leaves its input as it is"),
        (lambda one: observing(one, x=next(_numbers)), "changes the same every time"),
    ],
)
def test_what_is_wrong_is_found(change: Callable[[Question], Question], check: str):
    assert check in broken(change)


@pytest.mark.parametrize("moved", [{"right": "left"}, {"left": "up", "up": "right", "right": "left"}])
def test_expected_actions_are_held_against_what_is_seen(moved: dict[str, str]):
    found = broken(mirrored, "equivariance", expected=lambda one: moved.get(one, one))
    assert set(found) == {"expects one action for each"}


@pytest.mark.slow
def test_an_edit_of_ones_own_is_checked_by_name(tmp_path: Path):
    (tmp_path / "mine" / "edits").mkdir(parents=True)
    changing = "def edit(question):\n    question.observation['half_size'] = 3\n    return question\n"
    own = f"NAME, LEAVES = 'alone', 'cause'\n{changing}"
    (tmp_path / "mine" / "edits" / "alone.py").write_text(own)
    done = foundry("check", "edit=alone", "world.agents=2", "world.steps=1", "--config-dir", "mine", cwd=tmp_path)
    assert done.returncode == 2 and "edit alone" in done.stdout and "leaves its input" in done.stdout
    (tmp_path / "mine" / "edits" / "looking_glass.py").write_text(own.replace("alone", "mirror"))
    assert "looking_glass.py has the name 'mirror' of a shipped part" in refusal(
        "check", "edit=mirror", "--config-dir", "mine", cwd=tmp_path
    )
    (tmp_path / "mine" / "edits" / "looking_glass.py").unlink()
    assert "Did you mean 'alone'?" in refusal("check", "edit=alon", "--config-dir", "mine", cwd=tmp_path)
