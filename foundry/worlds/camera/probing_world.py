"""The 3D world that asks questions after a walk: which things were in view, and where they are."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import msgspec

from foundry import seeding
from foundry.declared import Actions
from foundry.errors import InputError, not_found
from foundry.records import CameraEpisode, CameraStep, Outcome, Pose, Record, SeenImage
from foundry.worlds.base import Answer, Question, Reading
from foundry.worlds.camera.camera_world import MOVE, CameraWorld, MotionResult
from foundry.worlds.camera.language import Command, command_record
from foundry.worlds.camera.surroundings import DRAWS, encoded_view, make_pose
from foundry.worlds.camera.things import ThingsScenario
from foundry.worlds.camera.walk_questions import ACTIONS, Probe, Walk, along, ask, spread
from foundry.worlds.rounds.reading import deciding, options_of, read_decision
from foundry.worlds.validation import read_settings, refuse_repeated_names


class Frame(msgspec.Struct, frozen=True, kw_only=True):
    """A picture of the walk: its pose, and its file in the run's folder, or null if no file was stored."""

    pose: Pose
    image: str | None


class ProbeEpisode(CameraEpisode, frozen=True, kw_only=True):
    """The line of `episode.jsonl` for an episode with questions after a walk; such an episode has no target.

    Attributes:
        walk: `oracle` if the walk was drawn from the scene, `own` if the agent chose it.
        frames: the pictures that go with every question, in order; empty if the agent chose the walk.
    """

    walk: str
    frames: list[Frame]


class ProbeStep(CameraStep, frozen=True, kw_only=True):
    """A line of `steps.jsonl`: a decision of a walk, or an answer to a question after the walk.

    `command.answer` holds an answer, null for an unreadable reply; an answer moves nothing.

    Attributes:
        kind: `move`, or the kind of question.
        question: the question in words, by language; null for a move.
        choices: text of each choice, by its label; empty for numbers and moves.
        truth: the right answer; null for a move.
        chance: probability that a random possible answer is right; null for `distance` and moves.
        scale: for `distance`, the mean error of the best constant answer over all things, metres; else null.
        frames: files of the question's pictures; empty for a move.
    """

    kind: str
    question: dict[str, str] | None = None
    choices: dict[str, str] = {}
    truth: str | float | None = None
    chance: float | None = None
    scale: float | None = None
    frames: tuple[str, ...] = ()

    @property
    def decision(self) -> str | float | None:  # type: ignore[override]
        """The kind of the command, or the answer; None for an unreadable reply."""
        if self.question is None:
            return super().decision
        answer: str | float | None = self.command["answer"]
        return answer if self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED) else None


WALKS = ("oracle", "own")
"""Values of `walk`: `oracle` is a shortest route to a random thing; with `own`, the agent chooses its walk.
"""


class _ProbeSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    walk: str
    frames: Annotated[int, msgspec.Meta(ge=2, le=64)]
    questions: list[str]


@dataclass(frozen=True)
class Prepared:
    """A drawn walk: the poses of its pictures, the encoded pictures, and the questions about it."""

    frames: list[Pose]
    seen: list[bytes]
    probes: list[Probe]


class MapProbeScenario(ThingsScenario):
    """A 3D world with questions after a walk.

    Description:
        A walk leads through a scene: along a shortest route to a random thing (`oracle`), or as the agent chooses
        (`own`). Then the agent answers questions about the pictures of the walk: which of two things is nearer to the
        end, on which side a thing is, how many of the named things were visible, in which order things came into view,
        and how far away a thing is. With `oracle`, walks are drawn until one allows every question. With `own`, the
        questions that the walk does not allow are left out.

    Observation:
        For a question: `question`, the words `{english, japanese}`; `choices`, `[{label, text}]`; `frames`, the number
        of pictures, of which the latest is last; `walk`; `step`. For a move, see `foundry.worlds.camera.camera_world`.

    Questions:
        With `walk: own`, one `move` question per step for `steps` decisions, or until the agent chooses to stay. After
        the walk, one question of each kind in `questions`, one after the other.

    Actions:
        A letter for `nearer` and `order`, `left` or `right` for `side`, a number for `count` and `distance`.

    Termination:
        Terminated after the last question.

    Source:
        The kinds of question follow VSI-Bench (Yang et al. 2025) and MindCube (Yin et al. 2025). foundry makes the
        questions from the scene.
    """

    kinds: ClassVar[tuple[str, ...]] = (MOVE, *ACTIONS)
    records: ClassVar[tuple[type[Record], ...]] = (ProbeStep, ProbeEpisode, SeenImage)

    def __init__(
        self,
        *,
        walk: str,
        frames: int,
        questions: Sequence[str],
        way: Mapping[str, Any],
        things: Mapping[str, Any],
        **settings: Any,
    ) -> None:
        values = {"walk": walk, "frames": frames, "questions": questions}
        self.probing = read_settings(_ProbeSettings, values, "world")
        _check(self.probing)
        super().__init__(way=way, things=things, **settings)
        self._latest: tuple[int, Prepared] | None = None

    def start(self, seed: int) -> "MapProbeWorld":
        """Return a fresh episode; the seed draws the questions, and the walk or the start of the agent's own walk."""
        if self.probing.walk == "own":
            start = self.surroundings.draw_start(seeding.stream(seed, "start"), None)
            return MapProbeWorld(self, start, seed, None)
        prepared = self.prepared(seed)
        return MapProbeWorld(self, prepared.frames[-1], seed, prepared)

    def actions(self) -> dict[str, Actions]:
        """Return the possible answers by kind of question, and the kinds of command if the agent chooses its walk."""
        walked = super().actions() if self.probing.walk == "own" else {}
        return {**walked, **{kind: ACTIONS[kind] for kind in self.probing.questions}}

    def count_calls(self) -> int:
        """Return the maximum number of calls: one per decision of the agent's own walk, and one per question."""
        return len(self.probing.questions) + (self.settings.steps if self.probing.walk == "own" else 0)

    def read(self, question: Question, answer: Answer) -> Reading:
        """Return the answer to a question about the walk, or the kind of command of a move."""
        if question.kind == MOVE:
            return super().read(question, answer)
        return read_decision(answer, ACTIONS[question.kind], question.kind)

    def prepared(self, seed: int) -> Prepared:
        """Return the walk of the run with this seed, and its questions; the latest walk is cached.

        Raises:
            InputError: no drawn walk allows all questions.
        """
        if self._latest is None or self._latest[0] != seed:
            self._latest = (seed, self._drawn(seed))
        return self._latest[1]

    def _drawn(self, seed: int) -> Prepared:
        goals, starts, drawn = (seeding.stream(seed, name) for name in ("target", "start", "probes"))
        allowed: set[str] = set()
        for _ in range(DRAWS):
            target, start = self.draw_way(goals, starts)
            points = self.surroundings.way(start, target).points
            end = make_pose(points[-1], start.yaw, 0.0)
            facing = end.yaw + self.things.aside(target.name, end)
            frames = along(start, points, facing, self.probing.frames)
            walk = Walk(self.things, frames)
            probes = [question for kind in self.probing.questions if (question := ask(kind, walk, drawn)) is not None]
            if len(probes) == len(self.probing.questions):
                return Prepared(frames, [encoded_view(self.surroundings, pose) for pose in frames], probes)
            allowed |= {probe.kind for probe in probes}
        never = ", ".join(kind for kind in self.probing.questions if kind not in allowed)
        raise InputError(
            f"Scene '{self.settings.scene.asset}' has no walk that allows all of world.questions"
            f"{f', and none that allows {never}' if never else ''}. Name fewer questions, or change world.frames "
            "or world.things."
        )


def _check(probing: _ProbeSettings) -> None:
    if probing.walk not in WALKS:
        raise InputError(f"world.walk={probing.walk} is not one of: {', '.join(WALKS)}.")
    for kind in probing.questions:
        if kind not in ACTIONS:
            raise not_found("Kind of question in world.questions", kind, ACTIONS)
    refuse_repeated_names(probing.questions, "world.questions")
    if not probing.questions:
        raise InputError(f"world.questions is empty. Name some of {', '.join(ACTIONS)}.")


class MapProbeWorld(CameraWorld):
    """One episode with questions after a walk."""

    def __init__(self, scenario: MapProbeScenario, start: Pose, seed: int, prepared: Prepared | None) -> None:
        super().__init__(scenario, None, start)
        self._probing, self._things, self._seed = scenario.probing, scenario.things, seed
        self._asked = 0
        self._seen = [self._sight.encoded]
        self._frames: list[Pose] = []
        self._paths: tuple[str, ...] = ()
        self._probes: list[Probe] | None = None
        if prepared is not None:
            self._frames, self._seen, self._probes = prepared.frames, prepared.seen, prepared.probes
            self._paths = tuple(self._path("walk", number) for number in range(1, len(self._frames) + 1))

    @property
    def finished(self) -> bool:
        """True if all questions are answered."""
        return self._probes is not None and self._asked >= len(self._probes)

    def opening(self) -> Sequence[Record]:
        """Return the facts of the episode, and the pictures of a drawn walk."""
        keep_images = self._settings.keep_images
        pairs = zip(self._frames, self._paths, strict=True)
        frames = [Frame(pose=pose, image=path if keep_images else None) for pose, path in pairs]
        facts = ProbeEpisode(**self._facts(), walk=self._probing.walk, frames=frames)
        images = zip(self._paths, self._seen, strict=False) if keep_images else ()
        return [facts, *(SeenImage(path=path, content=content) for path, content in images)]

    def pending(self) -> Sequence[Question]:
        """Return the next move or question."""
        if self._probes is None:
            return super().pending()
        if self.finished:
            return []
        probe = self._probes[self._asked]
        observation = {
            "question": dict(probe.question),
            "choices": [{"label": label, "text": text} for label, text in probe.choices.items()],
            "frames": len(self._seen),
            "walk": self._probing.walk,
            "step": self._steps,
        }
        secret, options = {"answer": deciding(probe.truth)}, options_of(ACTIONS[probe.kind])
        return [Question(self._steps + 1, 0, probe.kind, observation, tuple(self._seen), secret, options)]

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Move, or record the answer to a question; draw the questions when the walk ends."""
        if self._probes is not None:
            return [self._answered(answers[0], self._probes[self._asked])]
        records = super().advance(answers)
        self._seen.append(self._sight.encoded)
        stayed = self._latest is not None and self._latest.command["stay"]
        if not stayed and self._steps < self._settings.steps:
            return records
        self._end_walk()
        if not self._settings.keep_images:
            return records
        return [*records, SeenImage(path=self._paths[-1], content=self._seen[-1])]

    def _end_walk(self) -> None:
        chosen = spread(self._trail, self._probing.frames)
        self._frames = [self._trail[place] for place in chosen]
        self._seen = [self._seen[place] for place in chosen]
        self._paths = tuple(self._path("step", place + 1) for place in chosen)
        walk, drawn = Walk(self._things, self._frames), seeding.stream(self._seed, "probes")
        asked = (ask(kind, walk, drawn) for kind in self._probing.questions)
        self._probes = [probe for probe in asked if probe is not None]

    def _record(self, *decided: Any) -> ProbeStep:
        return ProbeStep(**msgspec.structs.asdict(super()._record(*decided)), kind=MOVE)

    def _answered(self, answer: Answer, probe: Probe) -> ProbeStep:
        reading = read_decision(answer, ACTIONS[probe.kind], probe.kind)
        self._asked += 1
        self._steps += 1
        paths = self._paths if self._settings.keep_images else ()
        command, still = Command(outcome=reading.outcome), MotionResult(self._pose, None, 0.0, (), ())
        record = msgspec.structs.replace(
            self._record(answer, command, still, self._sight),
            command={**command_record(command), "answer": reading.action},
            image=paths[-1] if paths else None,
            image_sha256=hashlib.sha256(self._seen[-1]).hexdigest(),
            kind=probe.kind,
            question=dict(probe.question),
            choices=dict(probe.choices),
            truth=probe.truth,
            chance=probe.chance,
            scale=probe.scale,
            frames=paths,
        )
        self._latest = record
        self._trail.append(self._pose)
        return record
