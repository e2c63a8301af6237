"""Which files a scene may read: those below one folder, as a scene may come from anyone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pxr import Ar, Sdf

from foundry.errors import InputError


def file_of(resolved: str) -> Path:
    """Return the file behind a resolved path, the package of `scene.usdz[layer.usda]`, symbolic links followed."""
    return Path(resolved.split("[")[0]).resolve()


def is_within(resolved: str, root: Path) -> bool:
    """Return whether a resolved path is in this folder or below it."""
    return file_of(resolved).is_relative_to(root)


def open_layers(path: Path, root: Path) -> list[Any]:
    """Return the layers of a scene, opened but not composed; while they are kept, USD does not read them again.

    Layers that are not found are left to whoever composes the scene.

    Raises:
        InputError: one is elsewhere; it was not read.
    """
    first = Sdf.Layer.FindOrOpen(str(path))
    opened = {} if first is None else {first.identifier: first}
    waiting = list(opened.values())
    while waiting:
        layer = waiting.pop()
        for dependency in layer.GetCompositionAssetDependencies():
            name = layer.ComputeAbsolutePath(Sdf.Layer.SplitIdentifier(dependency)[0])
            resolved = str(Ar.GetResolver().Resolve(name)) if name else ""
            if resolved:
                check_within(path, resolved, root)
                found = Sdf.Layer.FindOrOpen(name)
                if found is not None and found.identifier not in opened:
                    opened[found.identifier] = found
                    waiting.append(found)
    return list(opened.values())


def check_used(path: Path, stage: Any, root: Path) -> None:
    """Check what a composed stage was made of: also layers that only composing it names, such as value clips.

    Raises:
        InputError: one is elsewhere.
    """
    for layer in stage.GetUsedLayers():
        if layer.realPath:
            check_within(path, layer.realPath, root)


def check_within(path: Path, resolved: str, root: Path) -> None:
    """Refuse a scene that is made of a file outside the folder.

    Raises:
        InputError: it is.
    """
    if not is_within(resolved, root):
        raise InputError(
            f"Scene '{path}' refers to '{file_of(resolved)}', which is not below '{root}': "
            "if you trust it, name a folder that holds both with world.scene.root=... (--root)."
        )
