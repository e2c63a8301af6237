"""What a told way adds to the facts of an episode."""

from __future__ import annotations

import msgspec

from foundry.records import CameraEpisode


class Leg(msgspec.Struct, frozen=True, kw_only=True):
    """One straight piece of a told way.

    Attributes:
        turn: from the heading before, whole degrees, left positive, -180..180.
        metres: its length, seen from above, in tenths.
        end: foot at its end, metres.
        towards: name of the thing that it leads to as seen from its start, or null.
        near: name of the thing that is near its end, seen from there along the leg, or null.
        side: where that is: `ahead`, `left` or `right`, or null.
    """

    turn: int
    metres: float
    end: tuple[float, float, float]
    towards: str | None
    near: str | None
    side: str | None


class FollowEpisode(CameraEpisode, frozen=True, kw_only=True):
    """What holds for an episode in which a way is told (`episode.jsonl`, one line); the way is `shortest_path`.

    Attributes:
        grain: how much is told: `coarse`, `medium` or `fine`.
        instruction: the way in words, by language: `english`, `japanese`.
        legs: the way as it is told, from the start to the goal.
        facing: where the middle of the goal's thing is from its end: degrees from the heading there, left positive, and
            from the horizon, up positive.
    """

    grain: str
    instruction: dict[str, str]
    legs: list[Leg]
    facing: tuple[float, float]
