"""The world of a probe: recorded moments of another world, each asked several times, none leading to another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from foundry.declared import Actions
from foundry.errors import InputError
from foundry.records import Record, RoundStep
from foundry.worlds.base import Answer, Question, Scenario, World
from foundry.worlds.probe.editing import UNEDITED, find_edit
from foundry.worlds.probe.moments import Kept, Moment, questions_of, read_moments

APART = 1 << 16
"""What `Question.again` rises by from one repeat to the next: more than any world asks the same in a step."""


ROUND = 64
"""Questions that are asked at once; a worker plays several runs, so that a server is never idle between rounds."""


class ProbeStep(RoundStep, frozen=True, kw_only=True):
    """One decision in a recorded moment (`steps.jsonl`).

    Attributes:
        run: the run that the moment comes from.
        again: how often the agent was asked this before in the step.
        repeat: which asking of the moment it is, from 0.
    """

    run: str
    again: int
    repeat: int


@dataclass(frozen=True)
class Put:
    """A question with the moment and the repeat that it is."""

    moment: Moment
    repeat: int
    question: Question


class ProbeScenario(Scenario):
    """Recorded moments of a world.

    Description:
        The moments of recorded runs, made again by playing their world with their answers. One episode holds those of
        the runs with its seed; nothing that is answered changes what is asked next.

    Observation:
        That of the world in that moment, changed by the edit.

    Questions:
        Each moment in which the edit changes something, `repeats` times, many at once.

    Actions:
        Those of the world, read by the world.

    Termination:
        When all is answered.
    """

    form: ClassVar[str] = "probe"
    records: ClassVar[tuple[type[Record], ...]] = (ProbeStep,)

    def __init__(
        self,
        *,
        name: str,
        source: Scenario,
        edit: Mapping[str, Any],
        repeats: int,
        moments: str,
        kept: Mapping[str, str] | None = None,
    ) -> None:
        """Set what is asked.

        Args:
            name: name of the world.
            source: the world that was recorded.
            edit: what is changed; its `name` is looked up.
            repeats: how often each moment is asked.
            moments: SHA-256 of the file of moments.
            kept: where the moments (`moments`) and the answers of each run (`past`, with `{run}`) are; None before the
                probe has a folder.

        Raises:
            InputError: there is no such edit, or the world does not say how a reply is read.
        """
        if isinstance(source, ProbeScenario):
            raise InputError(
                f"World '{source.name}' is that of a probe itself: probe the world that its moments are of."
            )
        if type(source).read is Scenario.read:
            raise InputError(f"World '{source.name}' cannot be probed: its Scenario does not say how a reply is read.")
        self.name, self.source, self.repeats = name, source, repeats
        self.kinds = source.kinds  # type: ignore[misc]  # every probe has those of its world
        self.shows_images = source.shows_images  # type: ignore[misc]
        self._edit = find_edit(edit["name"], source.form)
        self._sha256, self._kept = moments, kept

    def start(self, seed: int) -> ProbeWorld:
        """Return the moments of the runs with this seed.

        Raises:
            RecordError: they cannot be made again.
        """
        return ProbeWorld(self.source, list(self._put(seed)))

    def actions(self) -> Mapping[str, Actions]:
        """Return what can be decided in the world."""
        return self.source.actions()

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        """Return the persona of every agent of the world."""
        return self.source.personas(seed)

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return what the world does."""
        return self.source.wordy_answer(question, characters)

    def count_calls(self) -> int:
        """Return how many calls an episode makes, at most."""
        return read_moments(self._places()["moments"], self._sha256).most() * self.repeats

    def _put(self, seed: int) -> Iterator[Put]:
        """Yield what is asked, by step."""
        kept = self._places()
        asked = questions_of(Kept(kept["moments"], self._sha256, kept["past"], seed, self.source))
        for moment in sorted(asked, key=lambda one: (one.step, one)):
            changed = asked[moment] if self._edit is UNEDITED else self._edit.applied(asked[moment])
            if changed is not None:
                for repeat in range(self.repeats):
                    yield Put(moment, repeat, replace(changed, again=changed.again + repeat * APART))

    def _places(self) -> Mapping[str, str]:
        if self._kept is None:
            raise InputError(f"World '{self.name}' is in the folder of a probe alone: begin one with foundry probe.")
        return self._kept


class ProbeWorld(World):
    """The moments of one seed, a round of questions after the other, so that a sweep can be stopped between them."""

    def __init__(self, source: Scenario, put: Sequence[Put]) -> None:
        """Set what is asked."""
        self._source, self._put, self._completed = source, put, 0

    @property
    def finished(self) -> bool:
        """Whether all is answered, or nothing asked."""
        return not self._round()

    @property
    def step(self) -> int:
        """Number of completed rounds."""
        return self._completed

    def pending(self) -> Sequence[Question]:
        """Return the questions of a round."""
        return [one.question for one in self._round()]

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Return what was decided in each moment of the round."""
        if self.finished:
            raise ValueError("the episode is over")
        asked = self._round()
        if len(answers) != len(asked):
            raise ValueError(f"{len(answers)} answers for {len(asked)} pending questions")
        self._completed += 1
        return [self._record(one, answer) for one, answer in zip(asked, answers, strict=True)]

    def _round(self) -> Sequence[Put]:
        return self._put[ROUND * self._completed : ROUND * (self._completed + 1)]

    def draw(self) -> bytes:
        """Refuse: moments of several runs are no picture.

        Raises:
            InputError: always.
        """
        raise InputError("A probe has no pictures: draw the runs that its moments come from.")

    def _record(self, put: Put, answer: Answer) -> ProbeStep:
        reading = self._source.read(put.question, answer)
        moment = put.moment
        return ProbeStep(
            step=moment.step,
            agent=moment.agent,
            kind=moment.kind,
            action=reading.action,
            outcome=reading.outcome,
            message=reading.message,
            run=moment.run,
            again=moment.again,
            repeat=put.repeat,
        )
