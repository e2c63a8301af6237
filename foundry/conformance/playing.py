"""Runs checks, and plays the episodes that they need, with usual, idle and empty replies."""

import asyncio
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from operator import attrgetter
from typing import Any, TypeAlias, TypeVar

import msgspec

from foundry import seeding
from foundry.composing.baselines import Stage
from foundry.errors import FoundryError
from foundry.models.base import Model, Request
from foundry.prompts.prompt import Prompt
from foundry.records import Record
from foundry.running.build import build
from foundry.texts import one_line
from foundry.worlds.base import Answer, Question, QuestionKey, Scenario, World

Case = TypeVar("Case")
Check: TypeAlias = Callable[[Case], str | None]
"""Function that checks one rule: it raises Broken if a part breaks the rule, and may return a note for the user."""
Answering: TypeAlias = Callable[[Sequence[Question]], list[Answer]]
"""Function that answers the pending questions, in order."""
POLICIES: tuple[Mapping[str, Any], ...] = (
    {"_target_": "foundry.worlds.any.any_policies.Random", "name": "scripted/random"},
    {"_target_": "foundry.worlds.camera.camera_policies.Wander", "name": "scripted/wander"},
)
"""Policies that replace the chosen model in the checks, if it costs something or cannot act in the world."""
_SPARE = 100
"""An episode is stopped as endless if it asks more than twice its promised maximum of questions plus this number."""


class Status(StrEnum):
    """The result of a check."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class Finding:
    """The result of one check of a part.

    Attributes:
        part: the checked part, such as `world bar`.
        check: name of the check.
        rule: the rule that it checks, as a sentence.
        note: advice, the reason why the check was skipped, or a remark.
    """

    part: str
    check: str
    rule: str
    status: Status
    note: str = ""


class Broken(Exception):
    """Raised if a rule does not hold; the message says where, and what to do."""


class Skipped(Exception):
    """Raised if a rule does not apply; the message says why."""


def require(condition: bool, message: str) -> None:
    """Raise Broken unless the condition holds."""
    if not condition:
        raise Broken(message)


def examine(part: str, checks: Sequence[Check[Case]], case: Case) -> list[Finding]:
    """Run the checks in order; if several fail for the same reason, only the first is reported as failed."""
    findings: list[Finding] = []
    causes: set[str] = set()
    for check in checks:
        finding = look(part, check, case)
        if finding.status is Status.FAILED and finding.note in causes:
            finding = Finding(part, finding.check, finding.rule, Status.SKIPPED, "because of the failure above")
        causes.add(finding.note)
        findings.append(finding)
    return findings


def look(part: str, check: Check[Case], case: Case) -> Finding:
    """Run one check, and return its finding."""
    name, rule = name_of(check), str(inspect.getdoc(check)).partition("\n")[0]
    try:
        note = check(case)
    except Skipped as reason:
        return Finding(part, name, rule, Status.SKIPPED, str(reason))
    except Broken as reason:
        return Finding(part, name, rule, Status.FAILED, str(reason))
    except Exception as error:  # noqa: BLE001 - the boundary: any error of a user's part is a finding
        return Finding(part, name, rule, Status.FAILED, _cause(error))
    return Finding(part, name, rule, Status.PASSED, note or "")


def name_of(check: Check[Case]) -> str:
    """Return the name of a check in words."""
    return check.__name__.replace("_", " ")


def failed(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings of rules that do not hold."""
    return [finding for finding in findings if finding.status is Status.FAILED]


def _cause(error: Exception) -> str:
    text = one_line(error)
    if isinstance(error, FoundryError):
        return text
    frames = inspect.getinnerframes(error.__traceback__) if error.__traceback__ else []
    own = [frame for frame in frames if "/foundry/conformance/" not in frame.filename.replace("\\", "/")]
    where = f" ({own[-1].filename}, line {own[-1].lineno})" if own else ""
    return f"{type(error).__name__}: {text}{where}"


@dataclass(frozen=True)
class Turn:
    """Questions that are asked together, the records of the answers, and the number of steps that are then complete."""

    questions: tuple[Question, ...]
    records: tuple[Record, ...]
    step: int


@dataclass(frozen=True)
class Episode:
    """An episode, played for checks.

    Attributes:
        opening: records before the first question.
        turns: rounds in order.
        left: questions that are pending at the end.
        pictures: PNG of the state after each step (0: the initial state); empty if none were drawn.
    """

    opening: tuple[Record, ...]
    turns: tuple[Turn, ...]
    finished: bool
    left: tuple[Question, ...]
    pictures: Mapping[int, bytes]

    @property
    def questions(self) -> Iterator[Question]:
        """All questions, in order."""
        return (question for turn in self.turns for question in turn.questions)

    @property
    def records(self) -> tuple[Record, ...]:
        """All records, in order."""
        return (*self.opening, *(record for turn in self.turns for record in turn.records))

    @property
    def asked(self) -> int:
        """Number of questions."""
        return sum(len(turn.questions) for turn in self.turns)

    def lines(self, stream: str) -> bytes:
        """Return the bytes that this episode would write to the record file `stream`."""
        return b"".join(msgspec.json.encode(record) + b"\n" for record in self.records if record.stream == stream)

    def content(self) -> list[bytes]:
        """Return each record and each question as bytes, to compare episodes."""
        return [
            *map(msgspec.json.encode, self.records),
            *(repr(seen(question)).encode() for question in self.questions),
        ]


seen = attrgetter("step", "agent", "kind", "observation", "images", "options", "idle")
"""Function that returns the fields in which two questions are compared, as a tuple."""


def play(world: World, answering: Answering, *, most: int, looks: int = 1, pictures: bool = False) -> Episode:
    """Play a world until it ends, asks nothing, or has asked more than `most` questions.

    `pending()` is called `looks` times per round; `pictures` draws each state.
    """
    opening, asked = tuple(world.opening()), 0
    turns: list[Turn] = []
    drawn = {0: world.draw()} if pictures else {}
    while not world.finished and asked <= most:
        before = world.step
        for _ in range(looks - 1):
            world.pending()
        questions = tuple(world.pending())
        if not questions:
            break
        asked += len(questions)
        records = tuple(world.advance(answering(questions)))
        turns.append(Turn(questions, records, world.step))
        if pictures and world.step != before:
            drawn[world.step] = world.draw()
    return Episode(opening, tuple(turns), world.finished, tuple(world.pending()), drawn)


def play_ahead(world: World, answering: Answering, *, most: int, pick: Callable[[int], int]) -> Episode | None:
    """Play a world, and ask questions as early as it allows; return None if it allows no early question."""
    opening = tuple(world.opening())
    turns: list[Turn] = []
    while not world.finished and (ahead := world.ahead()) is None and len(turns) <= most:
        questions = tuple(world.pending())
        turns.append(Turn(questions, tuple(world.advance(answering(questions))), world.step))
    if world.finished or ahead is None:
        return None
    answered: dict[QuestionKey, tuple[Question, Answer]] = {}
    opened: list[QuestionKey] = []
    while not world.finished and len(answered) <= most:
        ready = ahead.ready()
        answered |= {
            question.asked: (question, answer) for question, answer in zip(ready, answering(ready), strict=True)
        }
        opened += [question.asked for question in ready]
        require(
            bool(opened), f"after {world.step} steps ready() returns no questions, although all questions have answers"
        )
        next_place = opened.pop(pick(len(opened)))
        ahead.take(next_place, answered[next_place][1])
        while whole := ahead.next_round():
            missing = [place for place in whole if place not in answered or place in opened]
            require(
                not missing,
                f"next_round() returned question {missing[:1]}, which has no answer yet; wait until all have answers",
            )
            questions = tuple(answered[place][0] for place in whole)
            records = world.advance([answered[place][1] for place in whole])
            turns.append(Turn(questions, tuple(records), world.step))
    return Episode(opening, tuple(turns), world.finished, tuple(world.pending()), {})


@dataclass(frozen=True)
class WorldCase:
    """A world and its prompt, for the checks.

    Attributes:
        make: function that builds a new scenario.
        make_prompt: function that builds a new prompt for it.
        templates: templates of the prompt as written, by kind of question.
        policy: a scripted model that answers; without one, replies are drawn from the options of each question.
        schemas: JSON Schema of the reply by kind of question, if replies must follow one.
    """

    make: Callable[[], Scenario]
    make_prompt: Callable[[], Prompt]
    templates: Mapping[str, Any] = field(default_factory=dict)
    policy: Model | None = None
    schemas: Mapping[str, Any] | None = None
    seed: int = 0

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario that all checks use, unless they need one that is not used yet."""
        return self.make()

    @property
    def most(self) -> int:
        """Number of questions after which an episode is stopped."""
        return 2 * self.scenario.count_calls() + _SPARE

    @cached_property
    def usual(self) -> Episode:
        """An episode with answers of the policy; without a policy, with answers drawn from each question's options."""
        return self.played(self.answers)

    @cached_property
    def drawn(self) -> Episode:
        """The same episode as `usual`, with a picture of every state."""
        return self.played(self.answers, pictures=True)

    @cached_property
    def idle(self) -> Episode:
        """An episode of idle replies; if a question has none, its reply is empty."""
        return self.played(lambda questions: [Answer(question.idle or "") for question in questions])

    @cached_property
    def silent(self) -> Episode:
        """An episode of empty replies."""
        return self.played(lambda questions: [Answer("") for _ in questions])

    @property
    def put(self) -> Sequence[Question]:
        """The questions that a prompt must accept: those after usual replies and those after empty replies."""
        return (*self.usual.questions, *self.silent.questions)

    def played(
        self, answering: Answering, *, scenario: Scenario | None = None, looks: int = 1, pictures: bool = False
    ) -> Episode:
        """Play an episode with this seed, of `scenario` or, by default, of the case's own scenario; see `play`."""
        world = (scenario or self.scenario).start(self.seed)
        return play(world, answering, most=self.most, looks=looks, pictures=pictures)

    def answers(self, questions: Sequence[Question]) -> list[Answer]:
        """Return the policy's answers; without a policy, draw from the options of each question."""
        if self.policy is None:
            return [Answer(self._reply(question)) for question in questions]
        replies = asyncio.run(self.policy.ask_all([request_of(question, self.seed) for question in questions]))
        return [Answer(reply.text, reply.ending) for reply in replies]

    def _reply(self, question: Question) -> str:
        if question.options:
            rng = seeding.stream(self.seed, f"check:{question.step}:{question.agent}:{question.kind}")
            return question.options[int(rng.integers(len(question.options)))]
        return question.idle if question.idle is not None else self.scenario.wordy_answer(question, 300)


def request_of(question: Question, seed: int) -> Request:
    """Convert a question to a request to a scripted model, which reads no messages."""
    return Request(
        messages=(),
        seed=question.sampling_seed(seed),
        kind=question.kind,
        observation=question.told,
        step=question.step,
        agent=question.agent,
        options=question.options,
        idle=question.idle,
    )


def policy_for(scenario: Scenario, chosen: Mapping[str, Any], seed: int) -> Mapping[str, Any] | None:
    """Return the first that costs nothing and can answer: the chosen model, or a shipped policy. None if none can."""
    stage = Stage(scenario, seed)
    stage.questions  # noqa: B018 - an error of the world is no reason against a policy
    return next((policy for policy in (chosen, *POLICIES) if stage.suits(build(policy))), None)
