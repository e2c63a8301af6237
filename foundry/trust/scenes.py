"""The scenes of a sweep, as they go into a bundle."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from foundry.errors import InputError
from foundry.storing.store import SweepFolder


@dataclass(frozen=True)
class BundledScene:
    """A scene with all its files.

    Attributes:
        asset: what the configuration calls it.
        main: its root layer, as a path in the bundle.
        files: all its files, by their paths in the bundle.
    """

    asset: str
    main: str
    files: Mapping[str, Path]


def scenes_of(folder: SweepFolder) -> list[BundledScene]:
    """Return the scenes that the runs of a sweep are in.

    Raises:
        InputError: one is not found, or would not be whole elsewhere.
    """
    found: dict[str, BundledScene] = {}
    for condition, here in zip(folder.sweep.conditions, folder.sweep_here().conditions, strict=True):
        scene = condition.config["world"].get("scene")
        if isinstance(scene, Mapping) and isinstance(asset := scene.get("asset"), str) and asset not in found:
            found[asset] = _scene(asset, here.config["world"]["scene"])
    return list(found.values())


def _scene(asset: str, here: Mapping[str, Any]) -> BundledScene:
    """Return a scene with those of its files that it may read: they are below one folder, by default its own."""
    from foundry.worlds.camera.loading.scene_files import find_asset, scene_files

    main = find_asset(here["asset"]).resolve()
    limit = Path(here["root"]).resolve() if here.get("root") else main.parent
    files = [file for file in scene_files(main) if file == main or file.is_relative_to(limit)]
    root = Path(os.path.commonpath([file.parent for file in files]))
    if len(files) > 1:
        _check_movable(asset, root, main, files)
    digest = hashlib.sha256()
    for file in files:
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    top = PurePosixPath("scenes") / digest.hexdigest()[:16]
    return BundledScene(
        asset=asset,
        main=str(top / main.relative_to(root).as_posix()),
        files={str(top / file.relative_to(root).as_posix()): file for file in files},
    )


def _check_movable(asset: str, root: Path, main: Path, files: list[Path]) -> None:
    """Check on a copy that the scene finds all its files when it is somewhere else."""
    from foundry.worlds.camera.loading.scene_files import scene_files

    with tempfile.TemporaryDirectory() as name:
        copy = Path(name).resolve()
        for file in files:
            target = copy / file.relative_to(root)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
        found = scene_files(copy / main.relative_to(root))
    lost = [file for file in found if not file.is_relative_to(copy)]
    if lost or len(found) < len(files):
        what = f"'{lost[0]}'" if lost else "a file"
        raise InputError(
            f"Scene '{asset}' names {what} by an absolute path: make the path relative to bundle the sweep."
        )
