"""Reads a recorded probe for display, moment by moment: what agents perceive, prompts and answers."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import msgspec

from foundry.composing.preflight import scenario_of
from foundry.errors import FoundryError, InputError, not_found
from foundry.naming import NO_FORMAT, Subject, format_of, names_of
from foundry.records import Call, choice_of
from foundry.storing.matching import with_calls
from foundry.storing.probed import Choices, choices_in
from foundry.storing.store import RunFolder, SweepFolder, lines_of
from foundry.trust.unknown import check_targets
from foundry.worlds.probe.editing import NONE
from foundry.worlds.probe.moments import Moment, Moments, moments_in
from foundry.worlds.probe.probe_world import ProbeScenario, ProbeStep


class ConditionAnswers(msgspec.Struct, frozen=True):
    """The choices of one model in a moment, under one edit and with one format.

    `model`, `edit` and `format` are indices into the lists that `Overview` contains.

    Counts from the probabilities of one reply add up to `foundry.storing.probed.ANSWERS`.
    """

    model: int
    edit: int
    format: int
    counts: dict[str, int]


class Row(msgspec.Struct, frozen=True):
    """A moment: the recorded question, its strata and the choices in it."""

    run: str
    seed: int
    step: int
    agent: int
    kind: str
    again: int
    strata: dict[str, str | bool]
    answered: list[ConditionAnswers]


class EditSeen(msgspec.Struct, frozen=True):
    """An edit: its name, its kind (`leaves`), and the expected action for each action."""

    name: str
    leaves: str
    expected: dict[str, str] = {}


class Overview(msgspec.Struct, frozen=True):
    """The moments of a probe, and the models, edits and formats that were asked in them.

    Attributes:
        models: names of the models in its tables, in the order of its runs.
        edits: the edits; `none` is first.
        formats: names of the formats; `none` is first.
        moments: the moments, in the order of `moments.json`.
        missing: number of incomplete runs, whose answers are left out.
    """

    models: list[str]
    edits: list[EditSeen]
    formats: list[str]
    moments: list[Row]
    missing: int


class Reply(msgspec.Struct, frozen=True):
    """An answer: the choice, and the text of the reply, which is null if the log of calls lacks it."""

    choice: str
    text: str | None
    thinking: str | None = None
    ending: str = ""


class Replies(msgspec.Struct, frozen=True):
    """A model's answers in one moment, under one edit and with one format.

    Attributes:
        prompt: index into `SeenMoment.prompts`.
        expected: share of each choice, if it comes from the probabilities of one reply; else empty.
    """

    model: int
    edit: int
    format: int
    prompt: int | None
    replies: list[Reply]
    expected: dict[str, float] = {}


class PerceivedObservation(msgspec.Struct, frozen=True):
    """The observation of an agent under an edit, and the number of images in the question."""

    edit: int
    observation: dict[str, Any]
    images: int


class SeenMoment(msgspec.Struct, frozen=True):
    """The data of one moment for its page.

    Attributes:
        form: form of the world's records; "" if the world cannot be built.
        perceived: what the agent perceives under each edit; empty if the world cannot be built.
        why: reason why the world cannot be built, or "".
        prompts: messages of each different prompt.
        answers: answers by model, edit and format.
    """

    form: str
    perceived: list[PerceivedObservation]
    why: str
    prompts: list[list[dict[str, Any]]]
    answers: list[Replies]


@dataclass(frozen=True)
class _Run:
    folder: RunFolder
    subject: Subject
    edit: str
    format: str

    @property
    def key(self) -> str:
        """The id of the run, and a text that changes if the run is played again."""
        return self.folder.id + self.folder.beginning


@dataclass
class SeenProbe:
    """Reads a recorded probe, and caches data of complete runs.

    Args:
        folder: the probe.
        trusted: further packages whose classes the probe may build.
    """

    folder: SweepFolder
    trusted: Sequence[str] = ()
    _counted: dict[str, dict[Moment, Choices]] = field(default_factory=dict)
    _scenarios: dict[str, ProbeScenario] = field(default_factory=dict)
    _read: dict[str, dict[Moment, list[tuple[ProbeStep, Call | None]]]] = field(default_factory=dict)
    _seed: int | None = None

    @cached_property
    def moments(self) -> Moments:
        """The moments of the probe.

        Raises:
            RecordError: the moments cannot be read.
        """
        return moments_in(self.folder.moments_file)

    @cached_property
    def _runs(self) -> list[_Run]:
        return [_asked_in(run) for run in self.folder.runs()]

    @cached_property
    def models(self) -> dict[Subject, str]:
        """The name of each subject (a model with its prompt), in the order of the runs."""
        names = names_of(run.subject for run in self._runs)
        return {run.subject: names[run.subject] for run in self._runs}

    @cached_property
    def edits(self) -> list[EditSeen]:
        """The edits; `none` is first."""
        edits = [msgspec.convert(run.folder.config()["world"]["edit"], EditSeen) for run in self._runs]
        return sorted({edit.name: edit for edit in edits}.values(), key=lambda edit: edit.name != NONE)

    @cached_property
    def formats(self) -> list[str]:
        """The names of the formats; `none` is first."""
        return sorted(
            {run.format for run in self._runs}, key=lambda format_name: (format_name != NO_FORMAT, format_name)
        )

    def overview(self) -> Overview:
        """Return all moments with the choices in them.

        Raises:
            RecordError: a recorded file is damaged.
        """
        moments = self.moments
        answered: dict[Moment, list[ConditionAnswers]] = {moment: [] for moment in moments.moments}
        missing = 0
        for run in self._runs:
            if not run.folder.is_complete:
                missing += 1
                continue
            place = self._place(run)
            for moment, choices in self._choices(run).items():
                answered[moment].append(ConditionAnswers(*place, dict(choices.counts)))
        strata_shown = moments.strata or ({},) * len(moments.moments)
        rows = [
            Row(
                moment.run,
                moments.runs[moment.run].seed,
                moment.step,
                moment.agent,
                moment.kind,
                moment.again,
                strata,
                answered[moment],
            )
            for moment, strata in zip(moments.moments, strata_shown, strict=True)
        ]
        return Overview(list(self.models.values()), self.edits, self.formats, rows, missing)

    def place(self, run: str, step: int, agent: int, kind: str, again: int) -> int:
        """Return the index of a moment in the list of moments."""
        return self.moments.moments.index(Moment(run, step, agent, kind, again))

    def seen(self, number: int, *, plain: bool = False) -> SeenMoment:
        """Return the data of a moment for its page.

        Args:
            number: its index in the list of moments.
            plain: whether to show only the unedited question and the unchanged prompt.

        Raises:
            InputError: there is no moment with this number.
            RecordError: a recorded file is damaged.
        """
        moment = self.moment(number)
        prompts: list[list[dict[str, Any]]] = []
        answers = [
            self._replies(run, calls[moment], self._choices(run)[moment].expected, prompts)
            for run in self._asking(moment)
            if not plain or (run.edit, run.format) == (NONE, NO_FORMAT)
            if moment in (calls := self._calls(run))
        ]
        perceived, why = self._perceived(moment, self.edits[:1] if plain else self.edits)
        form = self._scenario(self.edits[0].name).source.form if perceived else ""
        return SeenMoment(form, perceived, why, prompts, answers)

    def picture(self, number: int, edit: int, image: int) -> bytes:
        """Return an image that an agent sees under an edit, or a picture of the world if the question has no image.

        Raises:
            InputError: there is no such image, or the world must not be built, because its code is not trusted.
            RecordError: the question of the moment cannot be rebuilt.
        """
        moment = self.moment(number)
        if edit >= len(self.edits):
            raise not_found("Edit", str(edit), [str(place) for place in range(len(self.edits))])
        scenario = self._scenario(self.edits[edit].name)
        question = scenario.asked_at(moment)
        if question is None:
            raise InputError(f"The edit '{self.edits[edit].name}' changes nothing in moment {number}.")
        if not question.images:
            return scenario.drawn_at(moment)
        if image >= len(question.images):
            last = len(question.images) - 1
            raise InputError(f"Moment {number} has no image {image}: give a number from 0 to {last}.")
        return question.images[image]

    def moment(self, number: int) -> Moment:
        """Return the moment with this index.

        Raises:
            InputError: there is no such moment.
            RecordError: the moments cannot be read.
        """
        if number >= len(self.moments.moments):
            raise InputError(f"There is no moment {number}: give a number from 0 to {len(self.moments.moments) - 1}.")
        return self.moments.moments[number]

    def _place(self, run: _Run) -> tuple[int, int, int]:
        edits = [edit.name for edit in self.edits]
        return list(self.models).index(run.subject), edits.index(run.edit), self.formats.index(run.format)

    def _asking(self, moment: Moment) -> list[_Run]:
        seed = self.moments.runs[moment.run].seed
        return [run for run in self._runs if run.folder.run.seed == seed and run.folder.is_complete]

    def _choices(self, run: _Run) -> dict[Moment, Choices]:
        if run.key not in self._counted:
            self._counted[run.key] = {Moment(*place): choices for place, choices in choices_in(run.folder).items()}
        return self._counted[run.key]

    def _calls(self, run: _Run) -> dict[Moment, list[tuple[ProbeStep, Call | None]]]:
        """Return the decisions of a run with their calls, by moment. Only results for one seed at a time are cached."""
        if self._seed != run.folder.run.seed:
            self._seed = run.folder.run.seed
            self._read.clear()
        if run.key not in self._read:
            self._read[run.key] = _with_calls(run.folder)
        return self._read[run.key]

    def _replies(
        self,
        run: _Run,
        asked: Sequence[tuple[ProbeStep, Call | None]],
        expected: dict[str, float],
        prompts: list[list[dict[str, Any]]],
    ) -> Replies:
        first = next((call for _, call in asked if call is not None), None)
        if first is not None and first.messages not in prompts:
            prompts.append(first.messages)
        replies = [
            Reply(_choice(run, line), call.text, call.thinking, call.ending)
            if call
            else Reply(_choice(run, line), None)
            for line, call in asked
        ]
        prompt = None if first is None else prompts.index(first.messages)
        return Replies(*self._place(run), prompt, replies, expected)

    def _perceived(self, moment: Moment, edits: Sequence[EditSeen]) -> tuple[list[PerceivedObservation], str]:
        perceived = []
        try:
            for place, edit in enumerate(edits):
                question = self._scenario(edit.name).asked_at(moment)
                if question is not None:
                    perceived.append(PerceivedObservation(place, dict(question.observation), len(question.images)))
        except FoundryError as error:
            return [], str(error)
        return perceived, ""

    def _scenario(self, edit: str) -> ProbeScenario:
        if edit not in self._scenarios:
            config = next(run.folder.config() for run in self._runs if run.edit == edit)
            check_targets({"world": config["world"]}, self.trusted, f"Probe '{self.folder.path.name}'")
            self._scenarios[edit] = cast(ProbeScenario, scenario_of(config))
        return self._scenarios[edit]


def _asked_in(folder: RunFolder) -> _Run:
    config = folder.config()
    return _Run(folder, Subject.of(config), config["world"]["edit"]["name"], format_of(config["prompt"]))


def _choice(run: _Run, line: ProbeStep) -> str:
    return choice_of(line, run.folder.declared.actions)


def _with_calls(folder: RunFolder) -> dict[Moment, list[tuple[ProbeStep, Call | None]]]:
    lines = lines_of(folder.steps_bytes(), ProbeStep, folder.stream_path("steps"))
    placed = (((line.step, line.agent, line.kind), line) for line in lines)
    calls: dict[Moment, list[tuple[ProbeStep, Call | None]]] = {}
    for line, call in with_calls(placed, folder.calls()):
        moment = Moment(line.run, line.step, line.agent, line.kind, line.again)
        calls.setdefault(moment, []).append((line, call))
    return calls
