"""The world of a probe: recorded moments of another world, each asked several times, none leading to another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from foundry.declared import Actions
from foundry.errors import InputError, RecordError
from foundry.records import Record, RoundStep
from foundry.worlds.base import Answer, Question, Recorded, Redrawing, Scenario, World
from foundry.worlds.probe.editing import UNEDITED, find_edit
from foundry.worlds.probe.moments import Kept, Moment, Moments, played, questions_of, read_moments, read_past

APART = 1 << 16
"""What `Question.again` rises by from one repeat to the next: more than any world asks the same in a step."""


NO_PICTURES = "A probe has no pictures: draw the runs that its moments come from."
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
        self._edit = find_edit(edit["name"], source)
        self._sha256, self._kept = moments, kept

    def start(self, seed: int) -> ProbeWorld:
        """Return the moments of the runs with this seed."""
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

    def redraw(self, recorded: Recorded) -> Redrawing:
        """Refuse: moments of several runs are no picture."""
        raise InputError(NO_PICTURES)

    def count_calls(self) -> int:
        """Return how many calls an episode makes, at most."""
        return self.moments().most() * self.repeats

    def count_moments(self, seed: int) -> int:
        """Return in how many moments of the runs with a seed it asks."""
        return len({put.moment for put in self._put(seed)})

    def asked_at(self, moment: Moment) -> Question | None:
        """Return what is asked in a moment; None where the edit changes nothing in it."""
        seed = self.moments().runs[moment.run].seed
        return self._changed(self._asked(seed), self._around(seed), moment)

    def drawn_at(self, moment: Moment) -> bytes:
        """Return the state of the world in a moment as a PNG, before anything was answered in it."""
        source, past = self.moments().runs[moment.run], self._places()["past"].replace("{run}", moment.run)
        wanted = moment.step, moment.agent, moment.kind
        for world, pending in played(self.source, source.seed, read_past(past, source.sha256)):
            if any(question.asked == wanted for question in pending):
                return world.draw()
        raise RecordError(
            f"World '{self.source.name}' no longer asks what it was recorded to ask: the run ends before."
        )

    def moments(self) -> Moments:
        """Return the moments of all seeds."""
        return read_moments(self._places()["moments"], self._sha256)

    def _put(self, seed: int) -> Iterator[Put]:
        """Yield what is asked, by step."""
        asked, around = self._asked(seed), self._around(seed)
        for moment in sorted(asked, key=lambda one: (one.step, one)):
            changed = self._changed(asked, around, moment)
            if changed is not None:
                for repeat in range(self.repeats):
                    yield Put(moment, repeat, replace(changed, again=changed.again + repeat * APART))

    def _around(self, seed: int) -> Mapping[Moment, Question]:
        """Return what an edit that looks around may look at: the moments of a seed and of the next one."""
        return {**self._asked(seed), **self._asked(self._after(seed))} if self._edit.looks_around else {}

    def _changed(
        self, asked: Mapping[Moment, Question], around: Mapping[Moment, Question], moment: Moment
    ) -> Question | None:
        if self._edit is UNEDITED:
            return asked[moment]
        return self._edit.applied(asked[moment], [other for at, other in around.items() if at != moment])

    def _asked(self, seed: int) -> Mapping[Moment, Question]:
        places = self._places()
        return questions_of(Kept(places["moments"], self._sha256, places["past"], seed, self.source))

    def _after(self, seed: int) -> int:
        """Return the seed after this one, after the last one the first."""
        seeds = sorted({one.seed for one in self.moments().runs.values()})
        return next((one for one in seeds if one > seed), seeds[0])

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
        questions = self._round()
        if len(answers) != len(questions):
            raise ValueError(f"{len(answers)} answers for {len(questions)} pending questions")
        self._completed += 1
        return [self._record(one, answer) for one, answer in zip(questions, answers, strict=True)]

    def _round(self) -> Sequence[Put]:
        return self._put[ROUND * self._completed : ROUND * (self._completed + 1)]

    def draw(self) -> bytes:
        """Refuse: moments of several runs are no picture."""
        raise InputError(NO_PICTURES)

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
