"""Small games: the usual settings of each, and functions that make one with changed settings."""

from typing import Any

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
