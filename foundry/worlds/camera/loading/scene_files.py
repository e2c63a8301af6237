"""Where a scene's file is, and the files that it is made of."""

from __future__ import annotations

from pathlib import Path

from pxr import UsdUtils

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


def scene_files(path: Path) -> list[Path]:
    """Return the root layer of a scene, its other layers and its textures, as far as they are found; sorted."""
    # USD prints its diagnostics on its own; while the delegate lives it keeps them instead.
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        layers, assets, _ = UsdUtils.ComputeAllDependencies(str(path))
    finally:
        delegate.TakeUncoalescedDiagnostics()
    named = {layer.realPath.split("[")[0] for layer in layers} | {str(asset).split("[")[0] for asset in assets}
    files = {Path(name).resolve() for name in named if name} | {path.resolve()}
    return sorted(file for file in files if file.is_file())
