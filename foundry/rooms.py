"""What a layer has for a form: the room of the form's name in the layer's package says it."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any


def in_room(package: str, form: str, name: str) -> Any:
    """Return what `package.<form>` says under a name; None where there is no such room, or it says nothing."""
    room = f"{package}.{form}"
    if importlib.util.find_spec(room) is None:
        return None
    return getattr(importlib.import_module(room), name, None)
