"""Edits of observations in the 2D world; texts such as messages and memories do not change."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from foundry import seeding
from foundry.worlds.any.any_edits import attributes, with_part
from foundry.worlds.base import Question
from foundry.worlds.probe.editing import Edit, observing

HIGHER = 100
"""The edit `rename_agents` adds this number to the number of every agent."""
Moving: TypeAlias = Callable[[float, float], tuple[float, float]]
"""A function that returns the new position of a point (x, y)."""
_SIDES = {"left": "right", "right": "left"}
_TURNED = {"right": "up", "up": "left", "left": "down", "down": "right"}
_WAYS = ("up", "down", "left", "right")
_PLACED = ("fires", "places", "neighbours", "seen", "exits", "food", "zones")
"""The keys of an observation that list things with a position."""


def mirror(question: Question) -> Question:
    """Mirror all positions left to right, on the vertical axis."""
    return _placed(question, lambda x, y: (0 - x, y), _SIDES, lambda rows: [row[::-1] for row in rows])


def rotate(question: Question) -> Question:
    """Rotate all positions counter-clockwise by 90 degrees around the middle of the grid."""
    return _placed(question, lambda x, y: (0 - y, x), _TURNED, _turned)


def _turned(rows: Sequence[str]) -> list[str]:
    """Return rows of text rotated counter-clockwise: the last column becomes the first row."""
    return ["".join(column) for column in zip(*rows, strict=True)][::-1]


def _placed(
    question: Question, move: Moving, ways: Mapping[str, str], window: Callable[[Sequence[str]], list[str]]
) -> Question:
    """Return the question with all positions moved.

    Args:
        question: a question of a 2D world.
        move: returns the exact new position of a point; the origin must not move.
        ways: new direction by old direction, for the directions that change.
        window: returns the new rows of the agent's view as text, the uppermost first.
    """
    seen = question.observation
    x, y = move(seen["x"], seen["y"])
    open_ways = {ways.get(way, way) for way in seen.get("open", ())}
    return observing(
        question,
        **{key: [_moved(thing, move) for thing in seen[key]] for key in _PLACED if key in seen},
        x=x,
        y=y,
        burning=[list(move(*cell)) for cell in seen.get("burning", ())],
        window=window(seen.get("window", ())),
        open=[way for way in _WAYS if way in open_ways],
    )


def _moved(thing: Mapping[str, Any], move: Moving) -> dict[str, Any]:
    """Return a copy of a thing with a position, such as a place or fire, with its point and its edges moved."""
    changed = dict(thing)
    if "x" in thing:
        changed["x"], changed["y"] = move(thing["x"], thing["y"])
    if "x_min" in thing:
        corners = move(thing["x_min"], thing["y_min"]), move(thing["x_max"], thing["y_max"])
        xs, ys = (sorted(ends) for ends in zip(*corners, strict=True))
        changed |= {"x_min": xs[0], "x_max": xs[1], "y_min": ys[0], "y_max": ys[1]}
    return changed


def no_fire(question: Question) -> Question:
    """Remove the fires that the agent perceives; messages and memories about fires stay."""
    window = [row.replace("*", ".") for row in question.observation.get("window", ())]
    return observing(question, fires=[], burning=[], window=window)


def no_history(question: Question) -> Question:
    """Remove the agent's memories and the messages that it received."""
    return observing(question, memory=[], received=[])


def rename_agents(question: Question) -> Question:
    """Add 100 to the number of every agent, also of the perceiving agent; the order of the numbers does not change."""
    seen = question.observation
    named = {
        key: [{**agent, name: agent[name] + HIGHER} for agent in seen.get(key, ())]
        for key, name in (("neighbours", "id"), ("seen", "id"), ("received", "sender"))
    }
    touchable = [agent + HIGHER for agent in seen.get("touchable", ())]
    return observing(question, **named, agent=seen["agent"] + HIGHER, touchable=touchable)


def rename_places(question: Question) -> Question:
    """Rename the places to "Place 1", "Place 2" and so on."""
    seen = question.observation
    names = {place["name"]: f"Place {number}" for number, place in enumerate(seen["places"], start=1)}

    def renamed(place: Mapping[str, Any] | None) -> dict[str, Any] | None:
        return None if place is None else {**place, "name": names[place["name"]]}

    near = [{**other, "place": renamed(other["place"])} for other in seen["neighbours"]]
    places = [renamed(place) for place in seen["places"]]
    return observing(question, places=places, place=renamed(seen["place"]), neighbours=near)


def shuffle_neighbours(question: Question) -> Question:
    """List the neighbours in a random order, which is always the same for the same moment."""
    near = question.observation["neighbours"]
    order = seeding.stream(question.sampling_seed(0), "shuffle_neighbours").permutation(len(near))
    return observing(question, neighbours=[near[place] for place in order.tolist()])


def swap_persona(question: Question, part: str | None = None) -> Question | None:
    """Exchange the persona, or one attribute of it, with the first neighbour that has a different one.

    The edit is impossible, so it returns None, if no neighbour has a different one.
    """
    own, near = question.observation["persona"], question.observation["neighbours"]
    for other in near:
        gained = with_part(own, other["persona"], part)
        if gained != own:
            lost = {"persona": with_part(other["persona"], own, part)}
            personas = {
                key: [
                    seen_agent | lost if seen_agent["id"] == other["id"] else seen_agent
                    for seen_agent in question.observation.get(key, ())
                ]
                for key in ("neighbours", "seen")
            }
            return observing(question, persona=gained, **personas)
    return None


EDITS = (
    Edit("mirror", "equivariance", mirror, lambda action: _SIDES.get(action, action)),
    Edit("no_fire", "cause", no_fire),
    Edit("no_history", "cause", no_history),
    Edit("rename_agents", "invariance", rename_agents),
    Edit("rename_places", "invariance", rename_places),
    Edit("rotate", "equivariance", rotate, lambda action: _TURNED.get(action, action)),
    Edit("shuffle_neighbours", "invariance", shuffle_neighbours),
    Edit("swap_persona", "cause", swap_persona, parts=attributes),
)


def fire_moved(observation: Mapping[str, Any], keys: Sequence[str], value: float) -> Mapping[str, Any] | None:
    """Return the observation with a fire moved, in its direction from the agent, to a given distance.

    The fire moves to the nearest cell at this distance, and the observation states the exact distance of that cell. The
    function returns None if the fire cannot be moved: there is no such fire, the fire is in the agent's own cell, its
    new cell is outside the grid or out of the fire's radius, or fires spread.
    """
    fires, place = observation.get("fires", ()), int(keys[1])
    if not -len(fires) <= place < len(fires) or observation.get("burning") or observation.get("window"):
        return None
    fire, at = fires[place], (observation["x"], observation["y"])
    away = math.dist(at, (fire["x"], fire["y"]))
    if not away or value < 0:
        return None
    x, y = (round(own + (to - own) * value / away) for own, to in zip(at, (fire["x"], fire["y"]), strict=True))
    distance = math.dist(at, (x, y))
    if max(abs(x), abs(y)) > observation["half_size"] or distance > fire["radius"]:
        return None
    moved = {**fire, "x": x, "y": y, "distance": distance}
    return {**observation, "fires": [moved if seen_fire is fire else seen_fire for seen_fire in fires]}


MOVES = {r"fires\.-?\d+\.distance": fire_moved}
