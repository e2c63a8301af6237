"""What a recorded condition says of its runs' records; the one place that knows how sweeps of 0.1 are told apart."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import msgspec

from foundry.declared import Declared, keys_of
from foundry.naming import present
from foundry.records import Agent, CameraEpisode, CameraStep, GridStep, Message, SeenImage

UNSAID = "any"
"""The form of records of which nobody said what they are: they are read by the keys that all steps have."""
_NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
_OLD_FORMS = {
    "foundry.worlds.grid.world.GridScenario": Declared(form="grid", streams=keys_of((GridStep, Message, Agent))),
    "foundry.worlds.camera.world.CameraScenario": Declared(
        form="camera", streams=keys_of((CameraStep, CameraEpisode, SeenImage))
    ),
}


def declared_before(config: Mapping[str, Any]) -> Declared:
    """Return what the records of a configuration are of which 0.1 said no more than its world's class."""
    return _OLD_FORMS.get(present(config["world"].get("_target_")), Declared(form=UNSAID))


def recorded_declaration(condition: Mapping[str, Any]) -> Declared | None:
    """Return what a condition of `sweep.yaml` declares; None where it was recorded by 0.1, which declared nothing.

    Raises:
        ValueError: it is declared in another shape, or as another form than its world's class has.
    """
    if "declared" not in condition:
        return None
    try:
        declared = msgspec.convert(condition["declared"], Declared)
    except msgspec.ValidationError as error:
        raise ValueError(f"declared: {error}") from error
    for name in (declared.form, *declared.streams):
        if not _NAME.fullmatch(name) or name == "calls":
            raise ValueError(f"declared: {name!r} is no name of a form or of a record file")
    shipped = declared_before(condition["config"]).form
    if shipped not in (UNSAID, declared.form):
        target = condition["config"]["world"]["_target_"]
        raise ValueError(
            f"declared: its form is {declared.form!r}, but the records of {target} are of form {shipped!r}"
        )
    return declared
