"""The world of a probe: it asks the questions in recorded moments of another world, several times and independently."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from foundry.certainty import Sampling, foreseen
from foundry.declared import Actions
from foundry.errors import InputError, RecordError
from foundry.records import Record, RoundStep
from foundry.worlds.base import Answer, Question, Recorded, Redrawing, Scenario, World
from foundry.worlds.probe.editing import UNEDITED, find_edit
from foundry.worlds.probe.moments import Moment, MomentFiles, Moments, played, questions_of, read_moments, read_past

APART = 1 << 16
"""Each repeat of a question adds this number to `Question.again`; the counts of a world itself are smaller."""

NO_PICTURES = "A probe has no pictures. Draw the runs of its moments instead."
ROUND = 64
"""Number of questions that are asked at the same time."""


class ProbeStep(RoundStep, frozen=True, kw_only=True):
    """One decision in a recorded moment (`steps.jsonl`).

    Attributes:
        run: run of the moment.
        again: number of earlier questions of this kind to the agent in the step.
        repeat: number of the repeat, from 0.
    """

    run: str
    again: int
    repeat: int


@dataclass(frozen=True)
class RepeatedQuestion:
    """A moment's question with the number of its repeat; a probe asks each question several times."""

    moment: Moment
    repeat: int
    question: Question


class ProbeScenario(Scenario):
    """A probe: it asks recorded moments of another world again.

    Description:
        Moments of recorded runs, rebuilt by replaying their world with the recorded answers. One episode contains the
        moments of all runs with its seed. No answer changes a later question.

    Observation:
        The observation of the recorded world in that moment, changed by the edit.

    Questions:
        Each moment that the edit changes, `repeats` times, many at once. With `sampling`, each moment is first asked
        once. A moment is asked again only if the probabilities of its first reply cannot replace the repeats.

    Actions:
        The actions of the world, read by the world.

    Termination:
        After the last answer.
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
        sampling: Mapping[str, Any] | None = None,
        kept: Mapping[str, str] | None = None,
    ) -> None:
        """Take the recorded world, the edit, and the files with the moments.

        Args:
            name: name of the world.
            source: the recorded world.
            edit: the entry of `sweep.yaml` about the edit; `find_edit` finds the edit by the `name` in this entry.
            repeats: number of times that each moment is asked.
            moments: SHA-256 of the file of moments.
            sampling: options of the model's calls. A moment is asked once if the probabilities of its first reply, with
                these options, can replace the repeats (`foundry.certainty.foreseen`). None asks each moment `repeats`
                times.
            kept: paths of the moments (`moments`) and of each run's answers (`past`, which contains `{run}`); None for
                a probe without a folder.
        """
        if isinstance(source, ProbeScenario):
            raise InputError(f"World '{source.name}' is itself a probe. Probe the world of its moments.")
        if type(source).read is Scenario.read:
            raise InputError(f"World '{source.name}' cannot be probed: its Scenario has no method `read`.")
        self.name, self.source, self.repeats = name, source, repeats
        self.kinds = source.kinds  # type: ignore[misc]  # each probe has the kinds of its world
        self.shows_images = source.shows_images  # type: ignore[misc]
        self._edit = find_edit(edit["name"], source)
        self._sha256, self._kept = moments, kept
        self._sampling = None if sampling is None else Sampling.of(sampling)

    def start(self, seed: int) -> "ProbeWorld":
        """Return the moments of the runs with this seed."""
        return ProbeWorld(self.source, list(self._put(seed)), self._sampling)

    def actions(self) -> Mapping[str, Actions]:
        """Return the possible decisions of the recorded world."""
        return self.source.actions()

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        """Return the persona of every agent of the world."""
        return self.source.personas(seed)

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer of about this length from the recorded world, to estimate the longest prompts."""
        return self.source.wordy_answer(question, characters)

    def redraw(self, recorded: Recorded) -> Redrawing:
        """Raise InputError, because moments of several runs have no common picture."""
        raise InputError(NO_PICTURES)

    def count_calls(self) -> int:
        """Return the maximum number of calls in an episode."""
        return self.moments().most() * self.repeats

    def count_moments(self, seed: int) -> int:
        """Return the number of moments with this seed that the edit changes."""
        return len({put.moment for put in self._put(seed)})

    def asked_at(self, moment: Moment) -> Question | None:
        """Return the question in a moment, or None if the edit changes nothing in it."""
        seed = self.moments().runs[moment.run].seed
        return self._changed(self._asked(seed), self._around(seed), moment)

    def drawn_at(self, moment: Moment) -> bytes:
        """Return the state of the world in a moment as a PNG, before the agents answer."""
        source, past = self.moments().runs[moment.run], self._places()["past"].replace("{run}", moment.run)
        wanted = moment.step, moment.agent, moment.kind
        for world, pending in played(self.source, source.seed, read_past(past, source.sha256)):
            if any(question.asked == wanted for question in pending):
                return world.draw()
        raise RecordError(
            f"World '{self.source.name}' no longer asks its recorded questions: the run now ends earlier."
        )

    def moments(self) -> Moments:
        """Return the moments of all seeds."""
        return read_moments(self._places()["moments"], self._sha256)

    def _put(self, seed: int) -> Iterator[RepeatedQuestion]:
        asked, around = self._asked(seed), self._around(seed)
        for moment in sorted(asked, key=lambda moment: (moment.step, moment)):
            changed = self._changed(asked, around, moment)
            if changed is not None:
                for repeat in range(self.repeats):
                    yield RepeatedQuestion(moment, repeat, replace(changed, again=changed.again + repeat * APART))

    def _around(self, seed: int) -> Mapping[Moment, Question]:
        return {**self._asked(seed), **self._asked(self._after(seed))} if self._edit.looks_around else {}

    def _changed(
        self, asked: Mapping[Moment, Question], around: Mapping[Moment, Question], moment: Moment
    ) -> Question | None:
        if self._edit is UNEDITED:
            return asked[moment]
        return self._edit.applied(asked[moment], [other for at, other in around.items() if at != moment])

    def _asked(self, seed: int) -> Mapping[Moment, Question]:
        places = self._places()
        return questions_of(MomentFiles(places["moments"], self._sha256, places["past"], seed, self.source))

    def _after(self, seed: int) -> int:
        seeds = sorted({run.seed for run in self.moments().runs.values()})
        return next((later for later in seeds if later > seed), seeds[0])

    def _places(self) -> Mapping[str, str]:
        if self._kept is None:
            raise InputError(f"World '{self.name}' exists only in the folder of a probe. Start one with foundry probe.")
        return self._kept


class ProbeWorld(World):
    """Asks the moments of one seed in rounds, so that a sweep can be stopped between rounds."""

    def __init__(self, source: Scenario, put: Sequence[RepeatedQuestion], sampling: Sampling | None = None) -> None:
        """Take the questions in order; with `sampling`, a moment is repeated only after its first answer has come."""
        self._source, self._sampling, self._completed, self._answered = source, sampling, 0, 0
        self._put = [question for question in put if sampling is None or question.repeat == 0]
        self._repeats: dict[Moment, list[RepeatedQuestion]] = {}
        for question in put:
            self._repeats.setdefault(question.moment, []).append(question)

    @property
    def finished(self) -> bool:
        """True if all questions are answered."""
        return not self._round()

    @property
    def step(self) -> int:
        """Number of completed rounds."""
        return self._completed

    def pending(self) -> Sequence[Question]:
        """Return the next `ROUND` questions."""
        return [question.question for question in self._round()]

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Return a record for each answered question."""
        if self.finished:
            raise ValueError("the episode is over")
        questions = self._round()
        if len(answers) != len(questions):
            raise ValueError(f"advance() got {len(answers)} answers for {len(questions)} pending questions")
        self._completed, self._answered = self._completed + 1, self._answered + len(questions)
        return [self._record(question, answer) for question, answer in zip(questions, answers, strict=True)]

    def _ask_again(self, put: RepeatedQuestion, answer: Answer, action: str | float | None) -> None:
        """Queue a moment's repeats after its first answer; if this has log-probabilities, no repeats are needed."""
        actions = self._source.actions().get(put.moment.kind)
        labels = () if actions is None else actions.labels
        if self._sampling is None or put.repeat:
            return
        is_told = action in labels and answer.logprobs
        if not is_told or foreseen(answer.text, answer.logprobs, str(action), labels, self._sampling) is None:
            self._put += self._repeats[put.moment][1:]

    def _round(self) -> Sequence[RepeatedQuestion]:
        return self._put[self._answered : self._answered + ROUND]

    def draw(self) -> bytes:
        """Raise InputError, because moments of several runs have no common picture."""
        raise InputError(NO_PICTURES)

    def _record(self, put: RepeatedQuestion, answer: Answer) -> ProbeStep:
        reading = self._source.read(put.question, answer)
        self._ask_again(put, answer, reading.action)
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
