"""What questions after a walk add to the records of a 3D world."""

from __future__ import annotations

import msgspec

from foundry.records import CameraEpisode, CameraStep, Outcome, Pose


class Frame(msgspec.Struct, frozen=True, kw_only=True):
    """A picture of the walk: where from, and its path in the run's folder, or null when it is not kept."""

    pose: Pose
    image: str | None


class ProbeEpisode(CameraEpisode, frozen=True, kw_only=True):
    """What holds for an episode with questions after a walk (`episode.jsonl`, one line); nothing is to be found.

    Attributes:
        walk: who walks: `oracle` or `own`.
        frames: the pictures that every question shows, in their order; empty where the agent itself walks.
    """

    walk: str
    frames: list[Frame]


class ProbeStep(CameraStep, frozen=True, kw_only=True):
    """One decision of a walk, or one answer after it (`steps.jsonl`).

    An answer is `command.answer`, null where none could be read; it moves nothing.

    Attributes:
        kind: `move`, or which question.
        question: it in words, by language; null for a move.
        choices: what there is to choose from, by label; empty for numbers and moves.
        truth: the right answer; null for a move.
        chance: how often an answer drawn among the possible ones is right; null for `distance` and moves.
        scale: of a `distance`, how far the best answer that is the same for all things is off in the mean, metres; else
            null.
        frames: images that the question showed, or those of them that are kept; empty for a move.
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
        """The kind of the command, or the answer; None where nothing could be read."""
        if self.question is None:
            return super().decision
        answer: str | float | None = self.command["answer"]
        return answer if self.outcome in (Outcome.CHOSEN, Outcome.REPAIRED) else None
