"""The places have other names, which say nothing; names in texts, as in messages and memories, stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "rename_places"
LEAVES = "invariance"


def edit(question: Question) -> Question:
    """Return the question with the places named by their number."""
    seen = question.observation
    names = {place["name"]: f"Place {number}" for number, place in enumerate(seen["places"], start=1)}

    def renamed(place: Mapping[str, Any] | None) -> dict[str, Any] | None:
        return None if place is None else {**place, "name": names[place["name"]]}

    near = [{**other, "place": renamed(other["place"])} for other in seen["neighbours"]]
    places = [renamed(place) for place in seen["places"]]
    return observing(question, places=places, place=renamed(seen["place"]), neighbours=near)
