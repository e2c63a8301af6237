"""The records of a run: each kind of line has a struct, which documents the keys of this line.

All lines are UTF-8 JSON, one object per line. The encoding is deterministic: the keys have
the order of the fields in the struct.
"""

import math
from collections.abc import Container, Iterable
from enum import StrEnum
from typing import Any, ClassVar

import msgspec

from foundry.canary import Canary, TokenLogprobs

NOT_JSON = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
"""The errors of decoding damaged content, or content that is nested too deep."""


class Outcome(StrEnum):
    """The outcome of a model call. With any outcome but `chosen` and `repaired`, the reply chooses no action."""

    CHOSEN = "chosen"  # parsed as requested
    REPAIRED = "repaired"  # found by the fallback parser
    UNREADABLE = "unreadable"  # no decision could be read from the text
    EMPTY = "empty"  # an empty text
    TRUNCATED = "truncated"  # cut by the length limit before a decision could be read
    FAILED = "failed"  # the backend gave up on this call


class Counts(msgspec.Struct, kw_only=True):
    """Totals over a run: its calls, tokens, records and outcomes.

    `model_s` is the sum of the times of all answers, seconds, where a cached answer counts with its original time.
    `cached_tokens` is the number of prompt tokens that servers had in their own caches. Both are null if unknown.
    """

    calls: int = 0
    cached: int = 0
    retries: int = 0
    prompt_tokens: int = 0
    output_tokens: int = 0
    model_s: float | None = None
    cached_tokens: int | None = None
    steps: int = 0
    messages: int = 0
    outcomes: dict[str, int] = msgspec.field(default_factory=dict)
    message_outcomes: dict[str, int] = msgspec.field(default_factory=dict)

    def add_tokens(self, call: "Call") -> None:
        """Count the tokens of a call."""
        self.prompt_tokens += call.prompt_tokens or 0
        self.output_tokens += call.output_tokens or 0
        if call.cached_tokens is not None:
            self.cached_tokens = (self.cached_tokens or 0) + call.cached_tokens


def reused_share(counts: Iterable[Counts]) -> float | None:
    """Return the share of prompt tokens that servers took from their prompt caches; None if no server reports it."""
    counted = [count for count in counts if count.cached_tokens is not None]
    prompt_tokens = sum(counts.prompt_tokens for counts in counted)
    return sum(counts.cached_tokens or 0 for counts in counted) / prompt_tokens if prompt_tokens else None


def _increment(counter: dict[str, int], key: str) -> None:
    counter[key] = counter.get(key, 0) + 1


class Record(msgspec.Struct, frozen=True, kw_only=True):
    """The base class of all records of a world; `stream` is the name of the record's file without `.jsonl`."""

    stream: ClassVar[str] = ""

    @property
    def decision(self) -> str | int | float | None:
        """The decision in the form that the world declares; None if there is no decision."""
        action: str | int | float | None = getattr(self, "action", None)
        return action

    def tally(self, counts: Counts) -> None:
        """Add this record to the counts of its run."""


class Agent(Record, frozen=True, kw_only=True):
    """The persona of an agent for the whole run (`agents.jsonl`, if the world has personas).

    Attributes:
        agent: agent id, 0-based.
        persona: attribute to value.
    """

    stream: ClassVar[str] = "agents"

    agent: int
    persona: dict[str, str]


class RoundStep(Record, frozen=True, kw_only=True):
    """One decision in a world of rounds (`steps.jsonl`); a world adds its own keys in a subclass.

    Attributes:
        step: 1-based round.
        agent: agent id, 0-based.
        kind: kind of the question.
        action: a label or a number as the world declares them; null without a decision, as in talk or after an
            unreadable reply.
        outcome: outcome of the call.
        utility: the agent's payoff of the round for this decision, or null.
        message: the message, or null.
    """

    stream: ClassVar[str] = "steps"

    step: int
    agent: int
    kind: str
    action: str | int | float | None
    outcome: Outcome
    utility: float | None = None
    message: str | None = None

    def tally(self, counts: Counts) -> None:
        """Count the decision and its outcome."""
        counts.steps += 1
        _increment(counts.outcomes, self.outcome)


SPEAKS, SILENT, UNREAD = "speaks", "is silent", "unreadable"
"""Three choices: the agent sends a message, the agent sends no message, or its reply is unreadable."""


def choice_of(line: RoundStep | Any, deciding: Container[str]) -> str:
    """Return the choice that a line of `steps.jsonl` contains, under the name that probes give it.

    Args:
        line: a line with `kind`, `action`, `outcome` and `message`.
        deciding: kinds of question that ask for a decision; all others ask for a message only.
    """
    if line.outcome not in (Outcome.CHOSEN, Outcome.REPAIRED):
        return UNREAD
    if line.kind not in deciding:
        return SILENT if line.message is None else SPEAKS
    return line.action if isinstance(line.action, str) else f"{line.action:g}"


class GridStep(Record, frozen=True, kw_only=True):
    """One agent's step in a 2D world (`steps.jsonl`).

    Attributes:
        step: 1-based step.
        agent: agent id, 0-based.
        x: column before the move, cells.
        y: row before the move, cells, upwards.
        x_next: column after the move.
        y_next: row after the move.
        place: name of the place the agent stood in before the move, or null.
        fires: names of the fires it perceived before the move.
        neighbours: ids of the agents it could talk to before the move, ascending.
        message: the message, or null for silence or a reply without a message.
        action: `stay` or `move`; `stay` when the outcome left the agent where it is.
        direction: `up`, `down`, `left` or `right` for a requested move, else null.
        moved: whether its position changed; a requested move without a change was blocked.
        memory: the agent's new memory.
        reasoning: its explanation of the action.
        message_reasoning: its explanation of the message.
        outcome: outcome of the action call.
        message_outcome: outcome of the message call.
    """

    stream: ClassVar[str] = "steps"

    step: int
    agent: int
    x: int
    y: int
    x_next: int
    y_next: int
    place: str | None
    fires: tuple[str, ...]
    neighbours: tuple[int, ...]
    message: str | None
    action: str
    direction: str | None
    moved: bool
    memory: str
    reasoning: str
    message_reasoning: str
    outcome: Outcome
    message_outcome: Outcome

    @property
    def decision(self) -> str | None:
        """The direction of the agent's move, or another action such as `stay`; None after an unreadable reply."""
        return (self.direction or self.action) if self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED) else None

    def tally(self, counts: Counts) -> None:
        """Add to `counts` this step and the outcomes of its two replies, with the action and with the message."""
        counts.steps += 1
        _increment(counts.outcomes, self.outcome)
        _increment(counts.message_outcomes, self.message_outcome)


class Message(Record, frozen=True, kw_only=True):
    """A delivered message, with one of its recipients (`messages.jsonl`)."""

    stream: ClassVar[str] = "messages"

    step: int
    sender: int
    recipient: int
    text: str

    def tally(self, counts: Counts) -> None:
        """Count the delivery."""
        counts.messages += 1


class Pose(msgspec.Struct, frozen=True):
    """Position and gaze of an agent in a 3D world.

    Attributes:
        x, y, z: foot position, metres, z upwards.
        yaw: heading, degrees, counter-clockwise from +x, 0..360.
        pitch: gaze, degrees, up positive.
    """

    x: float
    y: float
    z: float
    yaw: float
    pitch: float


COMMAND_KINDS = ("stay", "forward", "back", "left", "right", "turn left", "turn right", "look up", "look down")
"""The kinds of command in a 3D world; with a walk, the walk gives the kind, otherwise the turn."""
_QUARTERS = ("forward", "left", "back", "right")  # of the circle of bearings, counter-clockwise


def command_kind(bearing: float, distance: float, turn: float, gaze: float) -> str:
    """Return the kind of a command (one of COMMAND_KINDS). Angles are in degrees, the distance in metres."""
    if distance > 0:
        return _QUARTERS[math.floor((bearing + 45) % 360 / 90) % 4]
    if turn:
        return "turn left" if turn > 0 else "turn right"
    if gaze:
        return "look up" if gaze > 0 else "look down"
    return COMMAND_KINDS[0]


class CameraEpisode(Record, frozen=True, kw_only=True):
    """Constants of an episode in a 3D world (`episode.jsonl`, one line).

    Attributes:
        scene: name of the scene.
        scene_sha256: digest of the scene's files.
        renderer: renderer of the images, with its version.
        target: the target.
        target_prims: paths of the target's prims.
        target_label: label of the target's prims, as in `visible_px`, or null.
        radius: distance from the target that counts as reached, metres.
        start: the first pose.
        shortest_path: shortest path from the start to the goal, (k, 3) metres; empty if none exists.
        shortest_m: length of the shortest path, metres, or null.
        walkable_cells: cells of the walkable grid that are reachable from the start.
        cell_m: edge of a cell, metres.
    """

    stream: ClassVar[str] = "episode"

    scene: str
    scene_sha256: str
    renderer: str
    target: str
    target_prims: tuple[str, ...]
    target_label: str | None
    radius: float
    start: Pose
    shortest_path: list[tuple[float, float, float]]
    shortest_m: float | None
    walkable_cells: int
    cell_m: float


class CameraStep(Record, frozen=True, kw_only=True):
    """One decision in a 3D world (`steps.jsonl`).

    Attributes:
        step: 1-based decision.
        agent: agent id, 0-based.
        pose: pose before the motion.
        pose_next: pose after the motion.
        reply: the raw reply.
        command: the command as read: `translate` (null or `{bearing, distance}`, degrees from the heading,
            counter-clockwise, and metres), `turn`, `gaze` (degrees or null) and `stay`.
        notes: remarks of the reader.
        outcome: outcome of the call.
        boundary: obstacle or limit of the motion, or null.
        travelled: covered length, metres.
        image: path of the image, relative to the run's folder, or null if it was not recorded.
        image_sha256: hash of that image's bytes.
        inference_s: seconds of the model; never part of the simulated time.
        distance_before: geodesic distance to the goal before the motion, metres; null if unreachable.
        distance_to_goal: geodesic distance to the goal after the motion, metres; null if unreachable.
        visited_cells: cells of the walkable grid covered so far, the start included.
        target_visible_px: pixels of the target in the image.
        visible_px: pixels of every labelled thing in the image, by label; without things out of view.
        line_of_sight: whether a straight line from the eye reaches the target, before the motion.
        success: whether the goal is reached after the motion, that is, near enough and in view.
    """

    stream: ClassVar[str] = "steps"

    step: int
    agent: int
    pose: Pose
    pose_next: Pose
    reply: str
    command: dict[str, Any]
    notes: tuple[str, ...]
    outcome: Outcome
    boundary: str | None
    travelled: float
    image: str | None
    image_sha256: str
    inference_s: float
    distance_before: float | None
    distance_to_goal: float | None
    visited_cells: int
    target_visible_px: int
    visible_px: dict[str, int]
    line_of_sight: bool
    success: bool

    @property
    def decision(self) -> str | None:
        """The kind of the command, one of COMMAND_KINDS; None after an unreadable reply."""
        if self.outcome not in (Outcome.CHOSEN, Outcome.REPAIRED):
            return None
        way = self.command["translate"] or {"bearing": 0.0, "distance": 0.0}
        return command_kind(way["bearing"], way["distance"], self.command["turn"] or 0.0, self.command["gaze"] or 0.0)

    def tally(self, counts: Counts) -> None:
        """Count the decision and its outcome."""
        counts.steps += 1
        _increment(counts.outcomes, self.outcome)


class SeenImage(Record, frozen=True, kw_only=True):
    """A recorded image that a model saw: its path in the run's folder, and its bytes."""

    stream: ClassVar[str] = "images"

    path: str
    content: bytes


class Attempt(msgspec.Struct, frozen=True, kw_only=True):
    """A failed try of a call: its error, its duration in seconds, and whether the server said that it was busy."""

    error: str
    elapsed_s: float
    busy: bool = False


class Call(msgspec.Struct, frozen=True, kw_only=True):
    """One model call (`calls.jsonl.zst`).

    Attributes:
        step, agent: 1-based step, id of the agent.
        kind: kind of the question (`message`, `action`, ...).
        model: name of the model that was asked.
        digest: the model's digest on the server, or null.
        key: hash of everything that affects the answer; the key of the answer cache.
        seed: sampling seed of the call.
        messages: the prompt exactly as sent; images by their SHA-256.
        parameters: all other parameters, as sent.
        text: the raw reply.
        thinking: the separate thinking text, if the server gave one.
        ending: reason for the text's end: `stop`, `length`, or `aborted` (the backend gave up).
        prompt_tokens, output_tokens: tokens of the prompt and of the reply, or null where unknown.
        timings: seconds by name (`total`, `load`, `prompt`, `output`, `queue`, `latency`) where known.
        attempts: failed tries before this answer.
        host: answering server, or null.
        cached: whether the answer came from the cache.
        server_version: version of that server, or its fingerprint without a version, or null.
        served_model: name of the model in that server's reply, or null.
        cached_tokens: prompt tokens from the server's prompt cache, or null if not reported.
        remote: model and address to which the server passed the call, or null.
        logprobs: the reply's tokens with their log-probabilities; left out if not reported.
    """

    step: int
    agent: int
    kind: str
    model: str
    digest: str | None
    key: str
    seed: int
    messages: list[dict[str, Any]]
    parameters: dict[str, Any]
    text: str
    thinking: str | None
    ending: str
    prompt_tokens: int | None
    output_tokens: int | None
    timings: dict[str, float]
    attempts: tuple[Attempt, ...]
    host: str | None
    cached: bool
    server_version: str | None = None
    served_model: str | None = None
    cached_tokens: int | None = None
    remote: str | None = None
    logprobs: tuple[TokenLogprobs, ...] | msgspec.UnsetType = msgspec.UNSET


class Member(msgspec.Struct, frozen=True, kw_only=True):
    """One of the models of a population: its name, its digest, and the ids of its agents."""

    model: str
    digest: str | None
    agents: tuple[int, ...]


class Origin(msgspec.Struct, frozen=True, kw_only=True):
    """The run and the step at which a fork begins.

    Attributes:
        sweep: folder name of the original sweep.
        run: id of the original run.
        at: first step that differs from the original run.
        records_sha256: SHA-256 of the original run's record files, by name.
    """

    sweep: str
    run: str
    at: int
    records_sha256: dict[str, str]


class RunSummary(msgspec.Struct, frozen=True, kw_only=True):
    """The result of a run (`run.json`, written last and atomically).

    Attributes:
        run: the run's id.
        status: `complete` or `failed`.
        world: name of the world.
        model: name of the model.
        prompt: name of the prompt variant.
        seed: seed of the run.
        sampling_seed: seed of the sampling only, or null if it follows `seed`.
        foundry_version: version of foundry.
        python_version: version of Python.
        packages: versions of the packages that can change a record.
        git_commit: commit of the clone foundry runs from, or null.
        model_digest: digest of the model on its server, or null.
        server_version: version of the model's server, or null.
        counts: totals over the run.
        started: ISO 8601, UTC; empty if the run's worker process died.
        ended: ISO 8601, UTC.
        duration_s: wall time, seconds.
        error: cause of the failure in one line, or null.
        error_type: class of the error, or null.
        traceback: traceback of an unexpected error, or null.
        records_sha256: SHA-256 of the bytes of each record file, by name.
        members: models of a mixed population; empty for a single model.
        origin: origin of a forked run; null for all others.
        readers: version of the code that read the replies (`foundry.provenance.READERS`).
        form: form of its records (`Declared.form`); null in sweeps of 0.1.
        canaries: facts about the weights of each served model; empty if unknown.
    """

    run: str
    status: str
    world: str
    model: str
    prompt: str
    seed: int
    sampling_seed: int | None
    foundry_version: str
    python_version: str
    packages: dict[str, str]
    git_commit: str | None
    model_digest: str | None
    server_version: str | None
    counts: Counts
    started: str
    ended: str
    duration_s: float
    error: str | None
    error_type: str | None
    traceback: str | None
    records_sha256: dict[str, str]
    members: tuple[Member, ...] = ()
    origin: Origin | None = None
    readers: int = 1
    form: str | None = None
    canaries: tuple[Canary, ...] = ()
