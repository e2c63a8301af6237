"""Small games and a small grid: the usual settings of each, and functions that make one with changed settings."""

from typing import Any

from foundry.worlds.base import Answer, Question, Scenario
from foundry.worlds.grid.grid_world import GridScenario
from foundry.worlds.grid.layouts import Uniform
from foundry.worlds.rounds.bar import Bar
from foundry.worlds.rounds.fishery import Fishery
from foundry.worlds.rounds.naming import NamingGame
from foundry.worlds.rounds.public_goods import PublicGoods, PunishedGoods

BAR: dict[str, Any] = {
    "name": "bar", "agents": 5, "steps": 3, "capacity": 0.6, "fun": 10, "crowded": 0, "home": 5, "reports": "explicit",
}  # fmt: skip
FISHERY: dict[str, Any] = {
    "name": "fishery", "agents": 5, "steps": 12, "stock": 100, "collapse": 5, "sharing": "stochastic", "talk": 0,
    "universalisation": False, "outsider": None,
}  # fmt: skip
NAMING: dict[str, Any] = {
    "name": "naming", "agents": 6, "steps": 3, "names": ["ama", "bodo", "ceri"], "protocol": "both", "memory": 2,
    "equal": 100, "different": -50, "established": None, "committed": 0, "committed_name": None, "until": None,
}  # fmt: skip
GOODS: dict[str, Any] = {"name": "goods", "agents": 4, "steps": 3, "tokens": 20, "multiplier": 2, "reset": True}
GRID: dict[str, Any] = {
    "name": "small", "half_size": 9, "agents": 2, "steps": 3, "layout": Uniform(), "places": [],
    "communication_distance": 20, "history": {"memory": 3, "messages": 3},
}  # fmt: skip
UP = '{"action": "move", "direction": "up", "memory": "", "reasoning": ""}'
HELLO = '{"message": "Hello.", "reasoning": ""}'


def bar(**changes: Any) -> Bar:
    return Bar(**(BAR | changes))


def fishery(**changes: Any) -> Fishery:
    return Fishery(**(FISHERY | changes))


def naming(**changes: Any) -> NamingGame:
    return NamingGame(**(NAMING | changes))


def goods(**changes: Any) -> PublicGoods:
    return PublicGoods(**(GOODS | changes))


def punished(**changes: Any) -> PunishedGoods:
    return PunishedGoods(**(GOODS | {"cost": 1, "loss": 3} | changes))


def grid(**changes: Any) -> GridScenario:
    return GridScenario(**(GRID | changes))


def greeted(scenario: Scenario, seed: int = 4) -> list[tuple[Question, str]]:
    """Return the questions and answers of an episode in which agents say hello and go up."""
    world, found = scenario.start(seed), list[tuple[Question, str]]()
    while not world.finished:
        pairs = [(question, HELLO if question.kind == "message" else UP) for question in world.pending()]
        found += pairs
        world.advance([Answer(text) for _, text in pairs])
    return found
