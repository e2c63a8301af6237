"""A USD stage (.usd, .usda, .usdc, .usdz) as triangles: loaded once in each process."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdUtils

from foundry.errors import InputError, not_found
from foundry.worlds.camera.loading.confinement import check_used, open_layers
from foundry.worlds.camera.loading.findings import Findings
from foundry.worlds.camera.loading.materials import Materials
from foundry.worlds.camera.loading.prims import GprimReader
from foundry.worlds.camera.loading.scene import FloatArray, Scene, SceneMesh
from foundry.worlds.camera.loading.textures import Textures
from foundry.worlds.camera.loading.traversal import Walker, reason_of, stage_frame
from foundry.worlds.camera.loading.values import Values

ENDINGS = (".usd", ".usda", ".usdc", ".usdz")


def load_scene(path: Path, *, exclude: Sequence[str] = (), root: Path | str | None = None) -> Scene:
    """Return what the stage shows, Z up and in metres; the same object when asked again for the same file.

    Args:
        path: the root layer.
        exclude: patterns of prim paths (`*` and `?` as in a shell, `*` also across `/`) that are left out with all
            that is below them.
        root: folder below which the scene may read files; None for that of its root layer.

    Raises:
        InputError: it cannot be opened, shows nothing, or is made of layers elsewhere.
    """
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"'{path}' is no USD scene: its name must end in {', '.join(ENDINGS)}.")
    if not path.is_file():
        siblings = path.parent.iterdir() if path.parent.is_dir() else ()
        scenes = [str(one) for one in siblings if one.suffix.lower() in ENDINGS]
        raise not_found("Scene", str(path), scenes, "Give the path of a USD file.")
    confines = path.resolve().parent if root is None else Path(root).expanduser().resolve()
    return _load(path.resolve(), path.stat().st_mtime_ns, tuple(exclude), confines)


@lru_cache(maxsize=8)
def _load(path: Path, _modified_ns: int, exclude: tuple[str, ...], root: Path) -> Scene:
    findings = Findings()
    # USD prints its diagnostics on its own; while the delegate lives it keeps them instead.
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        scene = _read(path, exclude, findings, root)
    finally:
        delegate.TakeUncoalescedDiagnostics()
    return scene


def _read(path: Path, exclude: tuple[str, ...], findings: Findings, root: Path) -> Scene:
    stage = _open(path, root)
    values = Values(findings, _first_time(stage))
    for error in stage.GetCompositionErrors():
        findings.add("Could not be composed", str(error).splitlines()[0])
    textures = Textures(findings, root)
    walker = Walker(GprimReader(Materials(textures, findings, values), findings, values), findings, exclude, values)
    up_axis, unit = _conventions(path, stage, findings)
    meshes = tuple(walker.meshes(stage, stage_frame(up_axis, unit)))
    warnings = tuple(findings.lines())
    if not meshes:
        raise InputError(f"'{path}' shows nothing that can be drawn. {' '.join(warnings)}".rstrip())
    return Scene(
        name=path.stem,
        source=str(path),
        sha256=_digest(stage, textures, exclude),
        meshes=meshes,
        bounds=_bounds(meshes),
        labels={label: tuple(paths) for label, paths in walker.labels.items()},
        warnings=warnings,
        up_axis=up_axis,
        metres_per_unit=unit,
        prims=walker.prims,
        triangles=sum(len(mesh.triangles) for mesh in meshes),
    )


def _open(path: Path, root: Path) -> Any:
    try:
        layers = open_layers(path, root)
        stage = Usd.Stage.Open(str(path))
        del layers  # the stage keeps those that it uses
        check_used(path, stage, root)
        return stage
    except Tf.ErrorException as error:
        raise InputError(f"'{path}' cannot be opened as a USD stage: {reason_of(error)}") from error


def _first_time(stage: Any) -> Any:
    """Return the time at which the stage is looked at: its start, so that animated things have a value."""
    if stage.HasAuthoredTimeCodeRange():
        return Usd.TimeCode(stage.GetStartTimeCode())
    return Usd.TimeCode.EarliestTime()


def _conventions(path: Path, stage: Any, findings: Findings) -> tuple[str, float]:
    """Return the axis that points up and the metres of a unit.

    Raises:
        InputError: the file gives none that can be.
    """
    if not stage.HasAuthoredMetadata("upAxis"):
        findings.add("No upAxis in the file", "USD's default is taken, Y")
    if not UsdGeom.StageHasAuthoredMetersPerUnit(stage):
        findings.add("No metersPerUnit in the file", "USD's default is taken, 0.01")
    up_axis, unit = str(UsdGeom.GetStageUpAxis(stage)), float(UsdGeom.GetStageMetersPerUnit(stage))
    if up_axis not in (UsdGeom.Tokens.y, UsdGeom.Tokens.z):
        raise InputError(f"'{path}' says upAxis = '{up_axis}': it can be 'Y' or 'Z'. Correct it in the file.")
    if not 0 < unit < math.inf:
        raise InputError(f"'{path}' says metersPerUnit = {unit:g}: it must be above 0. Correct it in the file.")
    return up_axis, unit


def _digest(stage: Any, textures: Textures, exclude: tuple[str, ...]) -> str:
    """Digest the content of all files, wherever they are, and what was left out of them."""
    files = {layer.realPath.split("[")[0] for layer in stage.GetUsedLayers()} - {""}
    digests = {hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files}
    parts = [*sorted(digests | set(textures.digests.values())), *sorted(exclude)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _bounds(meshes: Sequence[SceneMesh]) -> FloatArray:
    """Return (2, 3) bounds of the points; the authored extents are too often wrong."""
    lowest = np.min([mesh.points.min(axis=0) for mesh in meshes], axis=0)
    highest = np.max([mesh.points.max(axis=0) for mesh in meshes], axis=0)
    return np.stack([lowest, highest])
