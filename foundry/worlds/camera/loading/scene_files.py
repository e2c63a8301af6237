"""Where a scene's file is, and which files it may read: those below one folder, as a scene may come from anyone."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Tf, UsdUtils

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


FORMATS = ("usd", "usda", "usdc", "usdz")
"""USD's own formats, whose layers say which files they are made of."""


def file_of(resolved: str) -> Path:
    """Return the file behind a resolved path, the package of `scene.usdz[layer.usda]`, symbolic links followed."""
    return Path(resolved.split("[")[0]).resolve()


def is_within(resolved: str, root: Path) -> bool:
    """Return whether a resolved path is in this folder or below it."""
    return file_of(resolved).is_relative_to(root)


def open_layers(path: Path, root: Path) -> list[Any]:
    """Return the layers of a scene, opened but not composed; while they are kept, USD does not read them again.

    Layers that are not found or cannot be read are left to whoever composes the scene, and named by it.

    Raises:
        InputError: one is elsewhere, or of a format that may name files on its own; it was not read.
    """
    first = Sdf.Layer.FindOrOpen(str(path))
    opened = {} if first is None else {first.identifier: first}
    waiting, elsewhere = list(opened.values()), set()
    while waiting:
        layer = waiting.pop()
        for dependency in layer.GetCompositionAssetDependencies():
            name = layer.ComputeAbsolutePath(Sdf.Layer.SplitIdentifier(dependency)[0])
            resolved = str(Ar.GetResolver().Resolve(name)) if name else ""
            if resolved and not is_within(resolved, root):
                elsewhere.add(file_of(resolved))
            elif resolved:
                found = _opened(path, name)
                if found is not None and found.identifier not in opened:
                    opened[found.identifier] = found
                    waiting.append(found)
    _refuse(path, elsewhere, root)
    return list(opened.values())


def _opened(scene: Path, name: str) -> Any | None:
    """Return a layer, or None where USD cannot read it.

    Raises:
        InputError: its format is an extension of this USD, which may read whatever it names.
    """
    ending = Ar.GetResolver().GetExtension(name)
    if ending and ending not in FORMATS and Sdf.FileFormat.FindByExtension(ending):
        raise InputError(
            f"Scene '{scene}' refers to '{name}': what an extension of USD reads for '.{ending}' files cannot be kept "
            f"below one folder. Turn it into one of {', '.join(FORMATS)}."
        )
    try:
        return Sdf.Layer.FindOrOpen(name)
    except Tf.ErrorException:
        return None


def check_used(path: Path, stage: Any, root: Path) -> None:
    """Check what a composed stage was made of: also layers that only composing it names, such as value clips.

    Raises:
        InputError: one is elsewhere.
    """
    used = {layer.realPath for layer in stage.GetUsedLayers()} - {""}
    _refuse(path, {file_of(name) for name in used if not is_within(name, root)}, root)


def _refuse(path: Path, elsewhere: set[Path], root: Path) -> None:
    """Refuse a scene that is made of files outside the folder.

    Raises:
        InputError: it is.
    """
    if not elsewhere:
        return
    files = sorted(elsewhere)
    rest = len(files) - 1
    more = f" and {rest} more file{'s' if rest > 1 else ''}" if rest else ""
    raise InputError(
        f"Scene '{path}' refers to '{files[0]}'{more}, which is not below '{root}': {_way_out([root, *files])}"
    )


def _way_out(places: list[Path]) -> str:
    """Return what to do about places that no one folder to read from holds."""
    try:
        folder = Path(os.path.commonpath(places))
    except ValueError:  # two drives of Windows
        folder = Path(places[0].anchor)
    if folder == Path(folder.anchor):
        return "copy them into one folder, since only the whole disk holds them all."
    return (
        f"if you trust it, let it read all of '{folder}', which holds them all, with world.scene.root='{folder}' "
        f"(--root '{folder}' for `foundry scene`)."
    )
