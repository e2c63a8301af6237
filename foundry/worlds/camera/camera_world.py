"""The 3D world: one agent in a USD scene sees images and states its movements in plain language.

Keys of the observation (the image is no key, but a part of the question):

task          text of the task.
step          number of earlier decisions, so 0 for the first one, as in the paper.
x, y, z       place of the foot, metres.
yaw, pitch    heading and gaze, degrees.
history       earlier decisions, oldest first: [{step, reply, outcome, pose {x, y, z, yaw, pitch}}].
idle_streak   number of decisions without a movement since the last one with a movement.
target        name of the target, or "".
limits        {max_distance_m, max_turn_deg, max_gaze_deg}.

The keys below are in `Question.secret`; only scripted policies get them, and no prompt contains them:

way           corners of the shortest path to the goal: [[x, y]], metres.
near          whether the foot is near enough to the target.
reached       whether the foot is near enough and the target is in view.
target_yaw    heading from the eye to the target's middle, degrees.
target_pitch  angle from the eye to the target's middle, degrees, up positive.
in_view       whether the target is in view.
stopped       whether an obstacle stopped the last movement.
"""

import hashlib
import io
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import msgspec
import numpy as np
from PIL import Image

from foundry import seeding
from foundry.declared import Actions
from foundry.errors import InputError
from foundry.records import COMMAND_KINDS, CameraEpisode, CameraStep, Pose, Record, SeenImage
from foundry.worlds.base import (
    Answer,
    Computed,
    Question,
    Reading,
    Recorded,
    Redrawing,
    Scenario,
    World,
    unanswered,
    undecided_outcome,
)
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.navigation import CELL_M
from foundry.worlds.camera.camera_settings import read_camera_settings, read_limits
from foundry.worlds.camera.eye.overview import OverviewFrame, draw_overview
from foundry.worlds.camera.eye.rendering import angles, png
from foundry.worlds.camera.language import (
    Command,
    command_record,
    describe,
    every_kind,
    recorded_command,
    render_command,
)
from foundry.worlds.camera.language.interpreter import Interpreter
from foundry.worlds.camera.loading.scene import UInt8Array
from foundry.worlds.camera.surroundings import (
    POSE_DIGITS,
    Sight,
    Surroundings,
    Target,
    feet_of,
    foot_of,
    look,
    make_pose,
    surroundings_of,
)


@dataclass(frozen=True)
class MotionResult:
    """The motion that the world carried out for a command.

    Attributes:
        boundary: name of the obstacle or limit that shortened the motion, or None.
        travelled: length of the path, metres.
        places: poses on the path, including the last one.
        notes: one line for each clamped value.
    """

    pose: Pose
    boundary: str | None
    travelled: float
    places: tuple[Pose, ...]
    notes: tuple[str, ...]


def moved(
    pose: Pose, command: Command, collider: Collider, body: Body, *, pitch_limit: float, slide: bool
) -> MotionResult:
    """Return the motion for a command that is given at a pose; at obstacles, the body slides if `slide`, else stops."""
    if command.idle:
        return MotionResult(pose, None, 0.0, (pose,), ())
    yaw = (pose.yaw + (command.turn or 0.0)) % 360.0
    wanted = pose.pitch + (command.gaze or 0.0)
    pitch = min(max(wanted, -pitch_limit), pitch_limit)
    notes = (f"gaze clamped to {pitch:+.0f} deg",) if pitch != wanted else ()
    foot = foot_of(pose)
    turned = make_pose(foot, yaw, pitch)
    translate = command.translate
    if translate is None or not translate.distance:
        return MotionResult(turned, "gaze limit" if notes else None, 0.0, (turned,), notes)
    motion = collider.move(foot, yaw + translate.bearing, translate.distance, body, slide=slide)
    return MotionResult(
        make_pose(motion.foot, yaw, pitch),
        motion.stopped_by or ("gaze limit" if notes else None),
        round(float(motion.travelled_m), POSE_DIGITS),
        tuple(make_pose(place, yaw, pitch) for place in motion.track),
        notes,
    )


def _secret_of(around: Surroundings, sight: Sight, target: Target | None, stopped: bool) -> Computed:
    """Return the data that only scripted policies get; the text at the top of this module explains the keys."""
    return Computed(
        {
            "way": lambda: [] if sight.near else around.way(sight.pose, target).corners,
            "near": lambda: sight.near,
            "reached": lambda: sight.success,
            "target_yaw": lambda: _direction_of(around, sight.pose, target)[0],
            "target_pitch": lambda: _direction_of(around, sight.pose, target)[1],
            "in_view": lambda: sight.target_px > 0,
            "stopped": lambda: stopped,
        }
    )


def _direction_of(around: Surroundings, pose: Pose, target: Target | None) -> tuple[float | None, float | None]:
    """Return yaw and pitch from the eye to the target's middle, degrees, or None and None without a target."""
    if target is None:
        return None, None
    return angles(target.surfaces.points.mean(axis=0) - around.eye(pose))


MOVE = "move"
_IDLE = "I stay where I am. Stay."
"""The idle reply."""


class CameraScenario(Scenario):
    """A vision-language agent in a 3D scene.

    Description:
        One agent stands in a scene of triangles as an upright capsule. The agent sees a first-person image and states
        its movement in plain language; an interpreter reads the movement. The body stops at an obstacle or slides along
        it, climbs small steps and stays on the floor.

    Observation:
        The keys at the head of `foundry.worlds.camera.camera_world`. The image goes with the question.

    Questions:
        One `move` question per step.

    Actions:
        A turn of the body, then a turn of the gaze, then a translation, as far as the reply asks for them; or staying.
        A reply without a readable movement leaves the agent in place.

    Termination:
        Terminated when the agent chooses to stay at the goal, that is, within the target's radius and with the target
        in view. Truncated after `steps` decisions.

    Source:
        Hyodo, Minimal Local Simulation Foundations for LLM- and VLM-Driven Agents, section 2.2.
    """

    form: ClassVar[str] = "camera"
    kinds: ClassVar[tuple[str, ...]] = (MOVE,)
    records: ClassVar[tuple[type[Record], ...]] = (CameraStep, CameraEpisode, SeenImage)
    shows_images: ClassVar[bool] = True

    def __init__(self, *, interpreter: Interpreter, limits: Mapping[str, Any], **settings: Any) -> None:
        self.settings = read_camera_settings(settings)
        self.limits = read_limits(limits)
        self.interpreter = interpreter
        self.name = self.settings.name
        self.surroundings: Surroundings = surroundings_of(self.settings)
        self.options = (_IDLE, *(f"{render_command(command).capitalize()}." for command in every_kind(self.limits)))

    def start(self, seed: int) -> "CameraWorld":
        """Return a fresh episode; the seed draws the target and the first pose."""
        target = self.surroundings.draw_target(seeding.stream(seed, "target"))
        return CameraWorld(self, target, self.surroundings.draw_start(seeding.stream(seed, "start"), target))

    def notes(self) -> Sequence[str]:
        """If the world has no target, return a note that the measures of reaching a target are undefined."""
        if self.settings.targets:
            return ()
        return (
            f"World '{self.name}' has no world.targets, so measures of reaching a target are undefined. Measures of "
            "exploration and motion are not affected.",
        )

    def redraw(self, recorded: Recorded) -> "CameraRedrawing":
        """Return the pictures of a run."""
        return CameraRedrawing(self.surroundings, recorded)

    def check_begun(self, episode: bytes) -> None:
        """Check that a recorded episode was played in this scene; `episode` is the line of its `episode.jsonl`."""
        self.surroundings.episode(episode)

    def actions(self) -> dict[str, Actions]:
        """Return the kinds of command as actions; amounts are left out, and an unreadable reply counts as `stay`."""
        return {MOVE: Actions(labels=COMMAND_KINDS, idle=COMMAND_KINDS[0])}

    def count_calls(self) -> int:
        """Return the maximum number of decisions."""
        return self.settings.steps

    def understood(self, answer: Answer) -> Command:
        """Return the command in an answer; if the answer is unreadable, the command's outcome says why."""
        if (unread := unanswered(answer)) is not None:
            return Command(outcome=unread)
        command = self.interpreter.read(answer.text, self.limits)
        return replace(command, outcome=undecided_outcome(answer)) if not command.is_read else command

    def strata(self, question: Question) -> dict[str, bool]:
        """Return, for a move, whether the target is in view and whether an obstacle stopped the last move."""
        if question.kind != MOVE or question.secret is None:
            return {}
        strata = {"wall": question.secret["stopped"]}
        return {"target": question.secret["in_view"], **strata} if question.observation["target"] else strata

    def read(self, question: Question, answer: Answer) -> Reading:
        """Return the kind of command in an answer, without amounts."""
        command = self.understood(answer)
        return Reading(command.outcome, command.kind if command.is_read else None)


class CameraWorld(World):
    """One episode in a 3D world with a target and a first pose."""

    def __init__(self, scenario: CameraScenario, target: Target | None, start: Pose) -> None:
        self._scenario = scenario
        self._settings = scenario.settings
        self._around = scenario.surroundings
        self._target = target
        self._pose = start
        self._trail = [self._pose]
        self._cells = self._covered([self._pose])
        self._history: deque[Mapping[str, Any]] = deque(maxlen=self._settings.history)
        self._idle_streak = 0
        self._steps = 0
        self._terminated = False
        self._latest: CameraStep | None = None
        self._sight = look(self._around, self._pose, self._target)

    @property
    def finished(self) -> bool:
        """True if the agent has chosen to stay at the goal, or has made all decisions."""
        return self._terminated or self._steps >= self._settings.steps

    @property
    def step(self) -> int:
        """Number of decisions made so far."""
        return self._steps

    def opening(self) -> Sequence[Record]:
        """Return the record of the episode's scene, target and shortest path."""
        return [CameraEpisode(**self._facts())]

    def _facts(self) -> dict[str, Any]:
        target, way = self._target, self._around.way(self._pose, self._target)
        return {
            "scene": self._around.scene.name,
            "scene_sha256": self._around.scene.sha256,
            "renderer": self._around.renderer().capabilities(),
            "target": target.name if target else "",
            "target_prims": target.paths if target else (),
            "target_label": target.label if target else None,
            "radius": target.radius if target else 0.0,
            "start": self._pose,
            "shortest_path": [(float(x), float(y), float(z)) for x, y, z in way.points],
            "shortest_m": way.length,
            "walkable_cells": len(self._around.navigator.reachable(foot_of(self._pose))),
            "cell_m": CELL_M,
        }

    def pending(self) -> Sequence[Question]:
        """Return this step's question, with the agent's image; an empty list if the episode is finished."""
        if self.finished:
            return []
        stopped = self._latest is not None and self._latest.boundary is not None
        secret, options = _secret_of(self._around, self._sight, self._target, stopped), self._scenario.options
        return [Question(self._steps + 1, 0, MOVE, self._observed(), (self._sight.encoded,), secret, options, _IDLE)]

    def _observed(self) -> dict[str, Any]:
        limits = self._scenario.limits
        return {
            "task": self._task(),
            "step": self._steps,
            **msgspec.structs.asdict(self._sight.pose),
            "history": tuple(self._history),
            "idle_streak": self._idle_streak,
            "target": self._target.name if self._target else "",
            "limits": {key: getattr(limits, key) for key in ("max_distance_m", "max_turn_deg", "max_gaze_deg")},
        }

    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Move as the answer says; return the record of the decision and, if images are stored, the agent's image."""
        (answer,) = answers
        command = self._scenario.understood(answer)
        result = self._moved(command)
        before, self._pose = self._sight, result.pose
        self._sight = look(self._around, self._pose, self._target)
        self._cells |= self._covered(result.places)
        self._steps += 1
        record = self._record(answer, command, result, before)
        self._remember(command, record)
        self._terminated = command.stay and self._sight.success
        if record.image is None:
            return [record]
        return [record, SeenImage(path=record.image, content=before.encoded)]

    def draw(self) -> bytes:
        """Return the overview of the scene with the agent, its path so far and its view."""
        frame = _overview_after(self._latest, self._trail, self._settings.body.height, self._sight.image)
        return png(draw_overview(self._around.scene, frame))

    def _moved(self, command: Command) -> MotionResult:
        around, slides = self._around, self._settings.boundary == "slide"
        limit = self._settings.camera.pitch_limit
        return moved(self._pose, command, around.collider, around.body, pitch_limit=limit, slide=slides)

    def _covered(self, places: Sequence[Pose]) -> set[int]:
        """Return the cells that the body covers while it moves from place to place."""
        cells = self._around.navigator.visited(feet_of(places), self._around.body.radius_m)
        return set(cells.tolist())

    def _task(self) -> str:
        name = self._target.name if self._target else ""
        return self._settings.task.replace("{target}", name)

    def _path(self, name: str, number: int) -> str:
        suffix = "png" if self._settings.image_format == "png" else "jpg"
        return f"images/{name}_{number:04d}.{suffix}"

    def _record(self, answer: Answer, command: Command, result: MotionResult, before: Sight) -> CameraStep:
        return CameraStep(
            step=self._steps,
            agent=0,
            pose=before.pose,
            pose_next=result.pose,
            reply=answer.text,
            command=command_record(command),
            notes=(*command.notes, *result.notes),
            outcome=command.outcome,
            boundary=result.boundary,
            travelled=result.travelled,
            image=self._path("step", self._steps) if self._settings.keep_images else None,
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

    def _remember(self, command: Command, record: CameraStep) -> None:
        self._idle_streak = self._idle_streak + 1 if command.idle else 0
        self._latest = record
        self._trail.append(self._pose)
        said, pose = describe(command, record), msgspec.structs.asdict(self._pose)
        self._history.append({"step": self._steps - 1, "reply": record.reply, "outcome": said, "pose": pose})


class CameraRedrawing(Redrawing):
    """Draws overviews of a run again from its records: the scene with the agent, its path so far and its view."""

    def __init__(self, around: Surroundings, recorded: Recorded) -> None:
        """Read the records.

        Raises:
            InputError: the run has not begun, or the scene has changed.
        """
        if not recorded.episode:
            raise InputError("The run has not begun, so it has no episode.jsonl to draw.")
        episode = around.episode(recorded.episode)
        self._around = around
        self._recorded = recorded
        self._steps = msgspec.json.Decoder(CameraStep).decode_lines(recorded.steps)
        self._poses = [episode.start, *(step.pose_next for step in self._steps)]

    def draw(self, step: int) -> bytes:
        """Return the overview after a step as PNG."""
        return png(draw_overview(self._around.scene, self.frame(step)))

    def told(self, step: int) -> Sequence[str]:
        """Return one line for a film: the reply of a step and its outcome; the picture itself shows the command."""
        if not 1 <= step <= len(self._steps):
            return ()
        record = self._steps[step - 1]
        return (f"reply ({record.outcome}): {' '.join(record.reply.split())}",)

    def frame(self, step: int) -> OverviewFrame:
        """Return the data from which the overview after a step is drawn."""
        latest = self._steps[step - 1] if step else None
        return _overview_after(latest, self._poses[: step + 1], self._around.settings.body.height, self.view(step))

    def view(self, step: int) -> UInt8Array:
        """Return the view after a step, (h, w, 3): the image that the model got, or a new one if none is stored."""
        name = self._steps[step].image if step < len(self._steps) else None
        picture = None if name is None else self._recorded.kept(name)
        if picture is not None:
            return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), np.uint8)
        pose = self._poses[step]
        return self._around.renderer().view(self._around.eye(pose), pose.yaw, pose.pitch)


def _overview_after(
    latest: CameraStep | None, poses: Sequence[Pose], height_m: float, inset: UInt8Array
) -> OverviewFrame:
    """Return the data for the overview after the latest decision: all poses so far, and the present view."""
    trail = feet_of(poses)
    caption = "" if latest is None else describe(recorded_command(latest), latest)
    return OverviewFrame(
        foot=trail[-1],
        yaw_deg=poses[-1].yaw,
        height_m=height_m,
        trail=trail,
        caption=f"Step {len(poses) - 1}  {caption}".strip(),
        inset=inset,
    )
