"""The 3D world: one agent in a USD scene sees images and says in plain language how it moves."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from foundry import seeding
from foundry.records import CameraEpisode, CameraStep, Outcome, Record, SeenImage
from foundry.worlds.base import Answer, Question, Recorded, Scenario, World, unanswered, undecided_outcome
from foundry.worlds.camera.eye.rendering import png
from foundry.worlds.camera.language.interpreter import Command, Interpreter
from foundry.worlds.camera.motion import Moved, feet_of, moved
from foundry.worlds.camera.reading import command_record, describe, recorded_command
from foundry.worlds.camera.redrawing import CameraRedrawing, overview_after
from foundry.worlds.camera.settings import read_limits, read_usd_settings
from foundry.worlds.camera.sight import Secret, Sight, observe
from foundry.worlds.camera.surroundings import Surroundings, Target, surroundings_of

MOVE = "move"
_IDLE = "I stay where I am. Stay."
"""The reply that does nothing."""


class CameraScenario(Scenario):
    """A configured 3D world.

    Description:
        One agent stands in a scene of triangles as an upright capsule. It sees a first-person image and says in
        plain language what to do; an interpreter reads a movement from it. The body stops at, or slides along,
        what it hits, climbs small steps and stays on the floor.

    Observation:
        See `foundry.worlds.camera.sight`; the image goes with the question.

    Questions:
        One `move` question per step.

    Actions:
        A turn of the body, then a turn of the gaze, then a translation, each if the reply asks for it; or staying.
        A reply without a readable movement leaves the agent where it is.

    Termination:
        Terminated when the agent stays by its own word while the goal is reached: within the target's radius and
        with the target in view. Truncated after `steps` decisions.

    Source:
        Hyodo, Minimal Local Simulation Foundations for LLM- and VLM-Driven Agents, section 2.2.
    """

    form: ClassVar[str] = "camera"
    kinds: ClassVar[tuple[str, ...]] = (MOVE,)
    records: ClassVar[tuple[type[Record], ...]] = (CameraStep, CameraEpisode, SeenImage)
    shows_images: ClassVar[bool] = True

    def __init__(self, *, interpreter: Interpreter, limits: Mapping[str, Any], **settings: Any) -> None:
        self.settings = read_usd_settings(settings)
        self.limits = read_limits(limits)
        self.interpreter = interpreter
        self.name = self.settings.name
        self.surroundings: Surroundings = surroundings_of(self.settings)

    def start(self, seed: int) -> UsdWorld:
        """Return a fresh episode; the seed draws the target and the first pose."""
        return UsdWorld(self, seed)

    def notes(self) -> Sequence[str]:
        """Say that nothing is to be found, where that is so."""
        if self.settings.targets:
            return ()
        return (
            f"World '{self.name}' has no world.targets: whether and how fast anything is reached is not defined, "
            "and what is measured of it says nothing; exploration and motion are measured as ever.",
        )

    def redraw(self, recorded: Recorded) -> CameraRedrawing:
        """Return the pictures of a run."""
        return CameraRedrawing(self.surroundings, recorded)

    def count_calls(self) -> int:
        """Return the number of decisions, at most."""
        return self.settings.steps


class UsdWorld(World):
    """One episode in a 3D world."""

    def __init__(self, scenario: CameraScenario, seed: int) -> None:
        self._scenario = scenario
        self._settings = scenario.settings
        self._around = scenario.surroundings
        self._target: Target | None = self._around.draw_target(seeding.stream(seed, "target"))
        self._pose = self._around.draw_start(seeding.stream(seed, "start"), self._target)
        self._trail = [self._pose]
        self._cells = set(self._around.visited(feet_of([self._pose])))
        self._history: deque[Mapping[str, Any]] = deque(maxlen=self._settings.history)
        self._idle_streak = 0
        self._steps = 0
        self._terminated = False
        self._caption = ""
        self._sight = self._around.look(self._pose, self._target)

    @property
    def finished(self) -> bool:
        """Whether the agent stays at its goal, or the decisions are used up."""
        return self._terminated or self._steps >= self._settings.steps

    @property
    def step(self) -> int:
        """Number of decisions made."""
        return self._steps

    def opening(self) -> Sequence[Record]:
        """Return the facts of the episode: the scene, the target and the shortest way to it."""
        target, way = self._target, self._around.way(self._pose, self._target)
        return [
            CameraEpisode(
                scene=self._around.scene.name,
                scene_sha256=self._around.scene.sha256,
                renderer=self._around.renderer().capabilities(),
                target=target.name if target else "",
                target_prims=target.paths if target else (),
                target_label=target.label if target else None,
                radius=target.radius if target else 0.0,
                start=self._pose,
                shortest_path=[(float(x), float(y), float(z)) for x, y, z in way.points],
                shortest_m=way.length,
                walkable_cells=self._around.reachable_cells(self._pose),
                cell_m=self._around.cell_m,
            )
        ]

    def pending(self) -> Sequence[Question]:
        """Return the one question of this step, with the image that the agent sees."""
        if self.finished:
            return []
        observation = observe(
            self._sight,
            self._target,
            step=self._steps,
            task=self._task(),
            history=tuple(self._history),
            idle_streak=self._idle_streak,
            limits=self._scenario.limits,
        )
        secret = Secret(self._around, self._sight, self._target)
        return [Question(self._steps + 1, 0, MOVE, observation, (self._sight.encoded,), secret, idle=_IDLE)]

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Move as the answer says; return the decision, and the image that led to it if it is kept."""
        (answer,) = answers
        outcome = unanswered(answer)
        command = Command() if outcome else self._scenario.interpreter.read(answer.text, self._scenario.limits)
        result = moved(self._pose, command, self._around, self._settings)
        before, self._pose = self._sight, result.pose
        self._sight = self._around.look(self._pose, self._target)
        self._cells |= self._around.visited(feet_of(result.places))
        self._steps += 1
        record = self._record(answer, outcome or command.outcome, command, result, before)
        self._remember(answer.text, command, record)
        self._terminated = command.stay and self._sight.success
        if record.image is None:
            return [record]
        return [record, SeenImage(path=record.image, content=before.encoded)]

    def draw(self) -> bytes:
        """Return the overview of the scene with the agent, its way so far and what it sees."""
        frame = overview_after(self._trail, self._settings.body.height, self._caption, self._sight.image)
        return png(self._around.overview(frame))

    def _task(self) -> str:
        name = self._target.name if self._target else ""
        return self._settings.task.replace("{target}", name)

    def _record(self, answer: Answer, outcome: Outcome, command: Command, result: Moved, before: Sight) -> CameraStep:
        suffix = "png" if self._settings.image_format == "png" else "jpg"
        return CameraStep(
            step=self._steps,
            agent=0,
            pose=before.pose,
            pose_next=result.pose,
            reply=answer.text,
            command=command_record(command),
            notes=(*command.notes, *result.notes),
            outcome=undecided_outcome(answer) if outcome is Outcome.UNREADABLE else outcome,
            boundary=result.boundary,
            travelled=result.travelled,
            image=f"images/step_{self._steps:04d}.{suffix}" if self._settings.keep_images else None,
            image_sha256=hashlib.sha256(before.encoded).hexdigest(),
            inference_s=answer.inference_s,
            distance_before=before.distance,
            distance_to_goal=self._sight.distance,
            visited_cells=len(self._cells),
            target_visible_px=before.target_px,
            visible_px=before.visible_px,
            line_of_sight=before.line_of_sight,
            success=self._sight.success,
        )

    def _remember(self, reply: str, command: Command, record: CameraStep) -> None:
        self._idle_streak = self._idle_streak + 1 if command.idle else 0
        said = describe(command, record)
        self._caption = describe(recorded_command(record), record)
        self._trail.append(self._pose)
        pose = {name: getattr(self._pose, name) for name in ("x", "y", "z", "yaw", "pitch")}
        self._history.append({"step": self._steps - 1, "reply": reply, "outcome": said, "pose": pose})
