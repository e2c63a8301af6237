"""Finds a scene's file, and refuses scenes that read files outside one folder, since a scene may come from anyone."""

import os
from pathlib import Path
from typing import Any

from pxr import Ar, Sdf, Tf, UsdUtils

from foundry import paths
from foundry.errors import InputError, not_found

FORMATS = ("usd", "usda", "usdc", "usdz")
"""USD's own formats. A USD file in one of these formats lists all files that it uses."""


def find_asset(name: str) -> Path:
    """Return the scene's file with this path, or the shipped scene with this name.

    Raises:
        InputError: there is no such file, or its name does not end as the name of a USD file.
    """
    given = Path(name).expanduser()
    for candidate in (given, paths.assets_dir() / given):
        if candidate.is_file():
            if not _is_usd(candidate):
                endings = ", ".join(f".{ending}" for ending in FORMATS)
                raise InputError(f"'{name}' is not a USD scene. Its name must end in {endings}.")
            return candidate.resolve()
    siblings = given.parent.iterdir() if given.is_absolute() and given.parent.is_dir() else ()
    known = [file.name for file in paths.assets_dir().iterdir()] + [str(file) for file in siblings]
    raise not_found("Scene", name, filter(_is_usd, known), "Give your own scene by its path.")


def _is_usd(file: Path | str) -> bool:
    return Path(file).suffix.lower().lstrip(".") in FORMATS


def scene_files(path: Path) -> list[Path]:
    """Return the existing files of a scene, sorted: its root layer, the other layers and the textures."""
    # USD prints its diagnostics itself; while the delegate exists, USD stores them instead.
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        layers, assets, _ = UsdUtils.ComputeAllDependencies(str(path))
    finally:
        delegate.TakeUncoalescedDiagnostics()
    named = {layer.realPath.split("[")[0] for layer in layers} | {str(asset).split("[")[0] for asset in assets}
    files = {Path(name).resolve() for name in named if name} | {path.resolve()}
    return sorted(file for file in files if file.is_file())


def file_of(resolved: str) -> Path:
    """Return the file at a path from USD's resolver; for `scene.usdz[layer.usda]`, this is the package `scene.usdz`.

    Symbolic links are followed.
    """
    return Path(resolved.split("[")[0]).resolve()


def is_within(resolved: str, root: Path) -> bool:
    """Return whether a path that USD has resolved lies in this folder or below it."""
    return file_of(resolved).is_relative_to(root)


def open_layers(path: Path, root: Path) -> list[Any]:
    """Return the opened files (layers) of a scene, without composing them to a stage.

    USD does not read a layer again while it is held. Missing and unreadable layers are skipped; the composition
    reports them.

    Raises:
        InputError: a layer is outside the folder, or has a format that may name further files. This layer was not read.
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
                next_layer = _opened(path, name)
                if next_layer is not None and next_layer.identifier not in opened:
                    opened[next_layer.identifier] = next_layer
                    waiting.append(next_layer)
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
            f"outside the allowed folder. Convert the file to one of {', '.join(FORMATS)}."
        )
    try:
        return Sdf.Layer.FindOrOpen(name)
    except Tf.ErrorException:
        return None


def check_used(path: Path, stage: Any, root: Path) -> None:
    """Check that a composed stage used no file outside the folder.

    Some layers, such as value clips, are named by the composition alone.

    Raises:
        InputError: a file is outside the folder.
    """
    used = {layer.realPath for layer in stage.GetUsedLayers()} - {""}
    _refuse(path, {file_of(name) for name in used if not is_within(name, root)}, root)


def _refuse(path: Path, elsewhere: set[Path], root: Path) -> None:
    if not elsewhere:
        return
    files = sorted(elsewhere)
    rest = len(files) - 1
    more = f" and {rest} more file{'s' if rest > 1 else ''}" if rest else ""
    try:
        folder = Path(os.path.commonpath([root, *files]))
    except ValueError:  # two drives of Windows
        folder = Path(root.anchor)
    advice = (
        "Copy them into one folder, since only the whole disk contains them all."
        if folder == Path(folder.anchor)
        else f"If you trust the scene, let it read all files in '{folder}': "
        f"world.scene.root='{folder}' (--root '{folder}' for `foundry scene`)."
    )
    raise InputError(f"Scene '{path}' refers to '{files[0]}'{more}, which is not below '{root}'. {advice}")
