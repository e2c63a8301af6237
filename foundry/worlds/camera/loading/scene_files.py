"""Finds a scene's file. Allows the scene to read files from one folder only, since a scene may come from anyone."""

import os
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Tf, UsdUtils

from foundry import paths
from foundry.errors import InputError, not_found

ENDINGS = (".usd", ".usda", ".usdc", ".usdz")


def find_asset(name: str) -> Path:
    """Return the file with this name: absolute, in the working directory, or among the shipped assets.

    Raises:
        InputError: there is no such file.
    """
    given = Path(name).expanduser()
    for candidate in (given, paths.assets_dir() / given):
        if candidate.is_file():
            if candidate.suffix.lower() not in ENDINGS:
                raise InputError(f"'{name}' is no USD file: its name must end in {', '.join(ENDINGS)}.")
            return candidate.resolve()
    shipped = [file.name for file in paths.assets_dir().iterdir() if file.suffix in ENDINGS]
    raise not_found("Scene", name, shipped, "Give your own scene by its path.")


def scene_files(path: Path) -> list[Path]:
    """Return the existing files of a scene: its root layer, other layers and textures; sorted."""
    # USD prints its diagnostics itself; while the delegate exists, USD stores them instead.
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        layers, assets, _ = UsdUtils.ComputeAllDependencies(str(path))
    finally:
        delegate.TakeUncoalescedDiagnostics()
    named = {layer.realPath.split("[")[0] for layer in layers} | {str(asset).split("[")[0] for asset in assets}
    files = {Path(name).resolve() for name in named if name} | {path.resolve()}
    return sorted(file for file in files if file.is_file())


FORMATS = ("usd", "usda", "usdc", "usdz")
"""USD's own formats, whose layers list the files that they use."""


def file_of(resolved: str) -> Path:
    """Return the file of a resolved path, or the package of `scene.usdz[layer.usda]`; follows symbolic links."""
    return Path(resolved.split("[")[0]).resolve()


def is_within(resolved: str, root: Path) -> bool:
    """Return whether a resolved path is in this folder or below it."""
    return file_of(resolved).is_relative_to(root)


def open_layers(path: Path, root: Path) -> list[Any]:
    """Return the layers of a scene, opened but not composed; while they exist, USD does not read them again.

    Missing and unreadable layers are skipped; the composition reports them.

    Raises:
        InputError: a layer is outside the folder, or has a format that may name further files; it was not read.
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
    """Return a layer, or None if USD cannot read it.

    Raises:
        InputError: an extension of USD reads its format, and could read any file.
    """
    ending = Ar.GetResolver().GetExtension(name)
    if ending and ending not in FORMATS and Sdf.FileFormat.FindByExtension(ending):
        raise InputError(
            f"Scene '{scene}' refers to '{name}'. An extension of USD reads '.{ending}' files, and could read files "
            f"outside the folder. Convert it to one of {', '.join(FORMATS)}."
        )
    try:
        return Sdf.Layer.FindOrOpen(name)
    except Tf.ErrorException:
        return None


def check_used(path: Path, stage: Any, root: Path) -> None:
    """Check the files of a composed stage, including layers that only the composition names, such as value clips.

    Raises:
        InputError: a file is outside the folder.
    """
    used = {layer.realPath for layer in stage.GetUsedLayers()} - {""}
    _refuse(path, {file_of(name) for name in used if not is_within(name, root)}, root)


def _refuse(path: Path, elsewhere: set[Path], root: Path) -> None:
    """Reject a scene with files outside the folder.

    Raises:
        InputError: there are such files.
    """
    if not elsewhere:
        return
    files = sorted(elsewhere)
    rest = len(files) - 1
    more = f" and {rest} more file{'s' if rest > 1 else ''}" if rest else ""
    raise InputError(
        f"Scene '{path}' refers to '{files[0]}'{more}, which is not below '{root}'. {_way_out([root, *files])}"
    )


def _way_out(places: list[Path]) -> str:
    """Return an instruction for a user with files outside the folder."""
    try:
        folder = Path(os.path.commonpath(places))
    except ValueError:  # two drives of Windows
        folder = Path(places[0].anchor)
    if folder == Path(folder.anchor):
        return "Copy them into one folder, since only the whole disk contains them all."
    return (
        f"If you trust it, let it read all of '{folder}', which contains them all: world.scene.root='{folder}' "
        f"(--root '{folder}' for `foundry scene`)."
    )
