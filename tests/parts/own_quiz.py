"""A world of a user's own that knows what is right: it asks whether numbers are even, and records the `truth`."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from foundry.declared import Actions
from foundry.records import Outcome, Record, RoundStep
from foundry.worlds.base import Answer, Question, Recorded, Redrawing, Scenario, World

YES, NO = "yes", "no"
PROMPT = """\
_target_: foundry.prompts.prompt.Prompt
name: quiz
templates:
  even: "Is {{ number }} even? yes or no, as JSON."
"""


class Asked(RoundStep, frozen=True, kw_only=True):
    """An answer and the right one."""

    truth: str


class Quiz(Scenario):
    """Numbers from 1 on."""

    form: ClassVar[str] = "quiz"
    kinds: ClassVar[tuple[str, ...]] = ("even",)
    records: ClassVar[tuple[type[Record], ...]] = (Asked,)

    def __init__(self, name: str, steps: int) -> None:
        self.name, self.steps = name, steps

    def start(self, seed: int) -> World:
        return QuizWorld(self.steps)

    def actions(self) -> dict[str, Actions]:
        return {"even": Actions(labels=(YES, NO))}

    def count_calls(self) -> int:
        return self.steps

    def redraw(self, recorded: Recorded) -> Redrawing:
        raise NotImplementedError


class QuizWorld(World):
    """Asks one number after another."""

    def __init__(self, steps: int) -> None:
        self._steps, self._completed = steps, 0

    @property
    def finished(self) -> bool:
        return self._completed == self._steps

    @property
    def step(self) -> int:
        return self._completed

    def pending(self) -> list[Question]:
        number = self._completed + 1
        return [] if self.finished else [Question(number, 0, "even", {"number": number}, options=(YES, NO))]

    def advance(self, answers: Sequence[Answer]) -> list[Record]:
        self._completed += 1
        action = next((label for label in (YES, NO) if f'"{label}"' in answers[0].text), None)
        outcome, truth = Outcome.CHOSEN if action else Outcome.UNREADABLE, NO if self._completed % 2 else YES
        return [Asked(step=self._completed, agent=0, kind="even", action=action, outcome=outcome, truth=truth)]

    def draw(self) -> bytes:
        return b""


def write_quiz(folder: Path) -> None:
    """Write the world and its prompt into a folder `mine`, as a user has them."""
    mine = folder / "mine"
    for group, text in (("world", "_target_: quiz.Quiz\nname: quiz\nsteps: 5\n"), ("prompt", PROMPT)):
        (mine / group).mkdir(parents=True)
        (mine / group / "quiz.yaml").write_text(text, encoding="utf-8")
    shutil.copyfile(__file__, mine / "quiz.py")
