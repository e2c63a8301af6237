"""Tells a way in words, in English and in Japanese; every word of it is true of the legs that it is told from."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import TypeAlias

from foundry.worlds.camera.following.route_legs import Leg

GRAINS = ("coarse", "medium", "fine")
"""The goal alone; the turns and what is seen at them; every leg with its turn and its length."""

STRAIGHT_DEG, SLIGHT_DEG, BACK_DEG = 15.0, 50.0, 150.0
"""Turns up to which a way goes straight on and bears aside, and from which it goes back."""

TILT_DEG = 10
"""Degrees above or below the horizon from which they are told."""

Facing: TypeAlias = tuple[float, float]


def told(grain: str, goal: str, legs: Sequence[Leg], facing: Facing) -> dict[str, str]:
    """Return a way in words, by language.

    Args:
        grain: one of GRAINS.
        goal: name of the thing that it leads to.
        legs: the way.
        facing: where the middle of that thing is from its end, degrees from the heading and from the horizon.
    """
    return {language: teller.tell(grain, goal, legs, facing) for language, teller in _TELLERS.items()}


class Teller(ABC):
    """Puts a way into the words of a language."""

    joint = " "

    def tell(self, grain: str, goal: str, legs: Sequence[Leg], facing: Facing) -> str:
        """Return a way in words."""
        return self.joint.join(self._sentences(grain, goal, legs, facing))

    def _sentences(self, grain: str, goal: str, legs: Sequence[Leg], facing: Facing) -> Iterator[str]:
        if grain == "fine":
            yield from (self.measured(leg) for leg in legs)
            yield self.faced(goal, facing)
        elif grain == "medium" and legs:
            yield from (self.marked(leg) for leg in legs[:-1])
            yield self.last(goal, legs[-1])
        else:
            yield self.goal(goal)
        yield self.end(goal)

    @abstractmethod
    def goal(self, goal: str) -> str:
        """Say where to go."""

    @abstractmethod
    def measured(self, leg: Leg) -> str:
        """Say a leg by its turn and its length."""

    @abstractmethod
    def faced(self, goal: str, facing: Facing) -> str:
        """Say how to turn to the goal's thing at the end."""

    @abstractmethod
    def marked(self, leg: Leg) -> str:
        """Say a leg by its turn and what is seen."""

    @abstractmethod
    def last(self, goal: str, leg: Leg) -> str:
        """Say the leg that leads to the goal."""

    @abstractmethod
    def end(self, goal: str) -> str:
        """Say how the way ends."""


class English(Teller):
    """Tells it in English."""

    _SIDES = {"ahead": "ahead of you", "left": "ahead on your left", "right": "ahead on your right"}

    def goal(self, goal: str) -> str:
        """Say where to go."""
        return f"Go to {_the(goal)}."

    def measured(self, leg: Leg) -> str:
        """Say a leg by its turn and its length."""
        turn = f"Turn {_english_side(leg.turn)} by {abs(leg.turn)} degrees and walk" if leg.turn else "Walk"
        return f"{turn} {leg.metres:.1f} m."

    def faced(self, goal: str, facing: Facing) -> str:
        """Say how to turn to the goal's thing at the end."""
        aside, above = map(round, facing)
        where = f"{abs(aside)} degrees to your {_english_side(aside)}" if aside else "straight ahead"
        height = f", {abs(above)} degrees {'up' if above > 0 else 'down'}" if abs(above) >= TILT_DEG else ""
        return f"From there {_the(goal)} is {where}{height}."

    def marked(self, leg: Leg) -> str:
        """Say a leg by its turn and what is seen."""
        way = f"{self._turn(leg.turn)}on" + (f" towards {_the(leg.towards)}" if leg.towards else "")
        if leg.near is None or leg.side is None:
            return f"{way}."
        return f"{way} until you come near {_the(leg.near)}, {self._SIDES[leg.side]}."

    def last(self, goal: str, leg: Leg) -> str:
        """Say the leg that leads to the goal."""
        return f"{self._turn(leg.turn)}to {_the(goal)}."

    def end(self, goal: str) -> str:
        """Say how the way ends."""
        return f"Stop at {_the(goal)}, look at it, and stay there."

    def _turn(self, degrees: float) -> str:
        if abs(degrees) <= STRAIGHT_DEG:
            return "Walk "
        if abs(degrees) >= BACK_DEG:
            return "Turn around and walk "
        return f"{'Bear' if abs(degrees) <= SLIGHT_DEG else 'Turn'} {_english_side(degrees)} and walk "


class Japanese(Teller):
    """Tells it in Japanese; names stay as the scene has them."""

    joint = ""
    _SIDES = {"ahead": "正面", "left": "左前方", "right": "右前方"}

    def goal(self, goal: str) -> str:
        """Say where to go."""
        return f"「{goal}」まで行ってください。"

    def measured(self, leg: Leg) -> str:
        """Say a leg by its turn and its length."""
        turn = f"{_japanese_side(leg.turn)}に{abs(leg.turn)}度回り、" if leg.turn else ""
        return f"{turn}{leg.metres:.1f}メートル進んでください。"

    def faced(self, goal: str, facing: Facing) -> str:
        """Say how to turn to the goal's thing at the end."""
        aside, above = map(round, facing)
        where = f"{_japanese_side(aside)}{abs(aside)}度の方向" if aside else "真正面"
        height = f"、{'上' if above > 0 else '下'}に{abs(above)}度のところ" if abs(above) >= TILT_DEG else ""
        return f"そこから見て「{goal}」は{where}{height}にあります。"

    def marked(self, leg: Leg) -> str:
        """Say a leg by its turn and what is seen."""
        way = self._turn(leg.turn) + (f"「{leg.towards}」に向かって" if leg.towards else "")
        if leg.near is None or leg.side is None:
            return f"{way}進んでください。"
        return f"{way}進み、{self._SIDES[leg.side]}に見える「{leg.near}」の近くまで行ってください。"

    def last(self, goal: str, leg: Leg) -> str:
        """Say the leg that leads to the goal."""
        return f"{self._turn(leg.turn)}「{goal}」まで進んでください。"

    def end(self, goal: str) -> str:
        """Say how the way ends."""
        return f"「{goal}」のところで止まり、それを見て、そのまま動かないでください。"

    def _turn(self, degrees: float) -> str:
        if abs(degrees) <= STRAIGHT_DEG:
            return "まっすぐ"
        if abs(degrees) >= BACK_DEG:
            return "後ろを向いて"
        return f"{'斜め' if abs(degrees) <= SLIGHT_DEG else ''}{_japanese_side(degrees)}に曲がって"


_TELLERS: dict[str, Teller] = {"english": English(), "japanese": Japanese()}


def _english_side(degrees: float) -> str:
    return "left" if degrees > 0 else "right"


def _japanese_side(degrees: float) -> str:
    return "左" if degrees > 0 else "右"


def _the(name: str) -> str:
    """Return a name with its article; one that ends in a number is a proper name."""
    return name if name[-1:].isdigit() else f"the {name}"
