"""One name for one class, however it was asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.errors import InputError
from foundry.naming import target_of


def with_public_names(value: Any) -> Any:
    """Return a configuration with every `_target_`, at any depth, by the public name of its class.

    That is its `public_name`, a path under which it promises to stay importable, else the path where it is defined; so
    one class has one name, however it was asked for. A target that cannot be found stays as it is.

    Raises:
        InputError: a class is not found under its public name.
    """
    if isinstance(value, Mapping):
        return {
            key: _public_name(inner) if key == "_target_" else with_public_names(inner) for key, inner in value.items()
        }
    return [with_public_names(inner) for inner in value] if isinstance(value, list | tuple) else value


def _public_name(target: Any) -> Any:
    try:
        found = target_of(target)
    except (ImportError, AttributeError, ValueError, TypeError):
        return target  # told by whoever builds it
    name = vars(found).get("public_name") if isinstance(found, type) else None
    if name is None:
        return f"{found.__module__}.{found.__qualname__}" if isinstance(found, type) else target
    try:
        known = target_of(name)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(f"{target} says that its public name is '{name}', which cannot be imported.") from error
    if known is not found:
        raise InputError(f"{target} says that its public name is '{name}', which is another class.")
    return name
