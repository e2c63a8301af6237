"""Where a scene's file is."""

from __future__ import annotations

from pathlib import Path

from foundry import paths
from foundry.errors import InputError, not_found

ENDINGS = (".usd", ".usda", ".usdc", ".usdz")


def find_asset(name: str) -> Path:
    """Return the file of this name: absolute, in the working directory, or among the shipped assets.

    Raises:
        InputError: there is none.
    """
    given = Path(name).expanduser()
    for candidate in (given, paths.assets_dir() / given):
        if candidate.is_file():
            if candidate.suffix.lower() not in ENDINGS:
                raise InputError(f"'{name}' is no USD file: its name must end in {', '.join(ENDINGS)}.")
            return candidate.resolve()
    shipped = [file.name for file in paths.assets_dir().iterdir() if file.suffix in ENDINGS]
    raise not_found("Scene", name, shipped, "A scene of your own is given by its path.")
