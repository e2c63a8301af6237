"""A USD stage (.usd, .usda, .usdc, .usdz) as triangles, loaded once per process."""

import fnmatch
import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Kind, Tf, Usd, UsdGeom, UsdLux, UsdSkel, UsdUtils

from foundry.errors import InputError
from foundry.worlds.camera.loading.materials import Materials, Textures
from foundry.worlds.camera.loading.meshes import placed
from foundry.worlds.camera.loading.prims import GprimReader
from foundry.worlds.camera.loading.scene import FloatArray, Scene, SceneMesh
from foundry.worlds.camera.loading.scene_files import check_used, find_asset, open_layers
from foundry.worlds.camera.loading.values import Findings, Values

LARGEST_INSTANCER = 4_000_000
"""Maximum number of triangles of all copies of a prototype together; further copies are reported and not drawn."""

REACH = 1e8
"""Largest distance of a point from the origin, metres (for an instancer's copies: units of the file). A point farther
away is a mistake, and would make the other parts of the scene invisibly small.
"""

_DRAWN_PURPOSES = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


@dataclass(frozen=True)
class _Place:
    """The start of a walk over a part of a stage.

    Attributes:
        prefix: beginning of the paths of all meshes; it replaces the first `skip` characters of a prim's path.
        label: label that prims without a label of their own inherit.
        within: paths of the instancers that contain this part.
    """

    prefix: str = ""
    skip: int = 0
    label: str | None = None
    within: tuple[Any, ...] = ()

    def name(self, prim: Any) -> str:
        return self.prefix + str(prim.GetPath())[self.skip :]


class Walker:
    """Walks over a stage and yields its meshes.

    Attributes:
        labels: for each label, the paths of the prims that have it.
        prims: number of prims that were not left out.
    """

    def __init__(self, reader: GprimReader, findings: Findings, exclude: Sequence[str], values: Values) -> None:
        self.labels: dict[str, list[str]] = {}
        self.prims = 0
        self._reader, self._findings, self._values = reader, findings, values
        self._exclude, self._unmatched = tuple(exclude), set(exclude)
        self._transforms = UsdGeom.XformCache(values.time)

    def meshes(self, stage: Any, frame: FloatArray) -> Iterator[SceneMesh]:
        """Yield every mesh of the stage, transformed by the matrix `frame` (4, 4); points are rows."""
        yield from self._walk(stage.GetPseudoRoot(), Usd.PrimDefaultPredicate, _Place(), frame)
        for pattern in sorted(self._unmatched):
            self._findings.add("Pattern of `exclude` that matches no prim", pattern)

    def _walk(self, root: Any, predicate: Any, place: _Place, frame: FloatArray) -> Iterator[SceneMesh]:
        labels = {root.GetPath().GetParentPath(): place.label}
        prims = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(predicate)))
        for prim in prims:
            if self._is_left_out(prim):
                prims.PruneChildren()
                continue
            self.prims += 1
            label = label_of(prim, self._values)
            if label is not None:
                self.labels.setdefault(label, []).append(place.name(prim))
            here = label if label is not None else labels[prim.GetPath().GetParentPath()]
            labels[prim.GetPath()] = here
            self._name_what_is_not_drawn(prim)
            if prim.IsA(UsdGeom.PointInstancer):
                prims.PruneChildren()
            if _is_drawn(prim):
                yield from self._placed(prim, root, replace(place, label=here), frame)

    def _placed(self, prim: Any, root: Any, place: _Place, frame: FloatArray) -> Iterator[SceneMesh]:
        """Yield the meshes of one prim where they are in the scene; report a prim that USD cannot read."""
        try:
            matrix = (self._matrix(prim, root) @ frame)[None]
            meshes = [placed(mesh, matrix) for mesh in self._own_meshes(prim, place)]
        except Tf.ErrorException as error:
            self._findings.add("Could not be read", f"{place.name(prim)}: {reason_of(error)}")
            return
        for mesh in meshes:
            if (np.abs(mesh.points) <= REACH).all():
                yield mesh
            else:
                self._findings.add(f"Not drawn, since a point is not a number or is beyond {REACH:g} m", mesh.path)

    def _own_meshes(self, prim: Any, place: _Place) -> Iterator[SceneMesh]:
        if prim.IsA(UsdGeom.PointInstancer):
            yield from self._copies(UsdGeom.PointInstancer(prim), place)
            return
        path = str(prim.GetPath())
        for mesh in self._reader.read(prim):
            yield replace(mesh, path=place.name(prim) + mesh.path[len(path) :], label=place.label)

    def _copies(self, instancer: Any, place: _Place) -> Iterator[SceneMesh]:
        """Yield, for each mesh of a prototype, one mesh that joins all its copies, in the instancer's space."""
        prim, stage, time = instancer.GetPrim(), instancer.GetPrim().GetStage(), self._values.time
        if prim.GetPath() in place.within:
            self._findings.add("Not drawn, since the point instancer contains itself", place.name(prim))
            return
        indices = self._values.indices(instancer.GetProtoIndicesAttr())
        transforms = instancer.ComputeInstanceTransformsAtTime(
            time, time, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
        )
        mask = instancer.ComputeMaskAtTime(time)
        if indices is None or len(transforms) != len(indices) or len(mask or indices) != len(indices):
            self._findings.add("Not drawn, since the point instancer's lists differ in length", place.name(prim))
            return
        matrices = np.array(transforms, np.float64).reshape(-1, 4, 4)
        shown = (np.asarray(mask, np.bool_) if mask else np.ones(len(indices), np.bool_)) & self._sound(matrices, prim)
        for number, target in enumerate(instancer.GetPrototypesRel().GetForwardedTargets()):
            chosen = matrices[shown & (indices == number)]
            prototype = stage.GetPrimAtPath(target)
            if not prototype:
                self._findings.add("Prototype not found", f"{target} of {place.name(prim)}")
            elif len(chosen):
                skip = len(str(target.GetParentPath()).rstrip("/"))
                inner = _Place(place.name(prim), skip, place.label, (*place.within, prim.GetPath()))
                yield from self._multiplied(prototype, chosen, inner)

    def _sound(self, matrices: FloatArray, instancer: Any) -> npt.NDArray[np.bool_]:
        """Return, for each of (k, 4, 4) transforms, whether it is valid; report invalid transforms."""
        sound = (np.abs(matrices) <= REACH).all(axis=(1, 2))
        for number in np.flatnonzero(~sound):
            self._findings.add("Copies without a valid place are not drawn", f"{instancer.GetPath()}[{number}]")
        return np.asarray(sound)

    def _multiplied(self, prototype: Any, matrices: FloatArray, place: _Place) -> Iterator[SceneMesh]:
        for mesh in self._walk(prototype, Usd.PrimIsActive & Usd.PrimIsLoaded, place, np.eye(4)):
            most = max(1, LARGEST_INSTANCER // len(mesh.triangles))
            if len(matrices) > most:
                self._findings.add(f"Only the first {most} of {len(matrices)} copies are drawn", mesh.path)
            yield placed(mesh, matrices[:most])

    def _matrix(self, prim: Any, root: Any) -> FloatArray:
        """Return the (4, 4) transform from a prim's space to the space of `root`: the stage's root or a prototype."""
        if root.IsPseudoRoot():
            return np.array(self._transforms.GetLocalToWorldTransform(prim), np.float64)
        if prim == root:
            return np.eye(4)
        return np.array(self._transforms.ComputeRelativeTransform(prim, root)[0], np.float64)

    def _is_left_out(self, prim: Any) -> bool:
        path = str(prim.GetPath())
        matching = [pattern for pattern in self._exclude if fnmatch.fnmatchcase(path, pattern)]
        self._unmatched.difference_update(matching)
        return bool(matching) or self._is_invisible(prim)

    def _is_invisible(self, prim: Any) -> bool:
        if not prim.IsA(UsdGeom.Imageable):
            return False
        return bool(self._values.text(UsdGeom.Imageable(prim).GetVisibilityAttr(), "") == UsdGeom.Tokens.invisible)

    def _name_what_is_not_drawn(self, prim: Any) -> None:
        path, kind = str(prim.GetPath()), prim.GetTypeName()
        if kind and prim.GetPrimTypeInfo().GetSchemaType() == Tf.Type.Unknown:
            self._findings.add(f"Prims of the unknown type '{kind}' are not drawn", path)
        if prim.HasAPI(UsdLux.LightAPI):
            self._findings.add("Lights are not used, the scene is lit evenly", path)
        if prim.IsA(UsdGeom.Mesh) and prim.HasAPI(UsdSkel.BindingAPI):
            self._findings.add("Skinned meshes are drawn in their rest shape", path)
        mode = self._values.text(prim.GetAttribute("model:drawMode"), "default")
        if mode not in ("default", "inherited"):
            self._findings.add(f"The geometry is drawn instead of the draw mode '{mode}'", path)


def reason_of(error: Tf.ErrorException) -> str:
    """Return USD's reason for an error, without the line of USD's source code."""
    return " ".join(str(error).partition(" : ")[2].split()).strip("' ")


def _is_drawn(prim: Any) -> bool:
    if not (prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.PointInstancer)):
        return False
    return UsdGeom.Imageable(prim).ComputePurpose() in _DRAWN_PURPOSES


def stage_frame(up_axis: str, metres_per_unit: float) -> FloatArray:
    """Return the (4, 4) transform from a stage's axes and units to Z up and metres; points are rows."""
    frame = np.eye(4)
    if up_axis == UsdGeom.Tokens.y:
        frame[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    frame[:3, :3] *= metres_per_unit
    return frame


_OURS = "semantics:labels:foundry"


def label_of(prim: Any, values: Values) -> str | None:
    """Return the prim's own label, or None.

    The first of these that exists counts: its label `foundry` of UsdSemantics, its other labels of UsdSemantics, its
    semantic data of Isaac Sim, and, for a component, its display name or its name with spaces for underscores.
    """
    for read in (_semantic_label, _isaac_label):
        label = read(prim, values)
        if label:
            return label
    if Kind.Registry.IsA(Usd.ModelAPI(prim).GetKind(), Kind.Tokens.component):
        return str(prim.GetDisplayName()) or str(prim.GetName().replace("_", " "))
    return None


def _semantic_label(prim: Any, values: Values) -> str | None:
    attributes = prim.GetAuthoredPropertiesInNamespace("semantics:labels")
    for attribute in sorted(attributes, key=lambda attribute: (attribute.GetName() != _OURS, attribute.GetName())):
        label = values.first_text(attribute)
        if label:
            return label
    return None


def _isaac_label(prim: Any, values: Values) -> str | None:
    for attribute in prim.GetAuthoredPropertiesInNamespace("semantic"):
        if attribute.GetName().endswith(":params:semanticData"):
            return values.text(attribute, "")
    return None


def load_scene(asset: Path | str, *, exclude: Sequence[str] = (), root: Path | str | None = None) -> Scene:
    """Return the content of a stage, Z up and in metres; the latest scenes are cached.

    Args:
        asset: path of the root layer, or name of a shipped scene.
        exclude: patterns of prim paths to leave out, with everything below them (`*` and `?` as in a shell, but `*`
            also matches `/`).
        root: folder below which the scene may read files; None means the folder of its root layer.

    Raises:
        InputError: the file does not exist, cannot be opened, shows nothing, or uses layers outside the folder.
    """
    path = find_asset(str(asset))
    confines = path.parent if root is None else Path(root).expanduser().resolve()
    return _load(path, path.stat().st_mtime_ns, tuple(exclude), confines)


@lru_cache(maxsize=8)
def _load(path: Path, _modified_ns: int, exclude: tuple[str, ...], root: Path) -> Scene:
    findings = Findings()
    # USD prints its diagnostics itself; while the delegate exists, USD stores them instead.
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        return _read(path, exclude, findings, root)
    finally:
        delegate.TakeUncoalescedDiagnostics()


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
        # The points count, since authored extents are often wrong.
        bounds=np.array([end([end(mesh.points, axis=0) for mesh in meshes], axis=0) for end in (np.min, np.max)]),
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
        del layers  # the stage keeps the layers that it uses
        check_used(path, stage, root)
        return stage
    except Tf.ErrorException as error:
        raise InputError(f"'{path}' cannot be opened as a USD stage: {reason_of(error)}") from error


def _first_time(stage: Any) -> Any:
    """Return the first time code of a stage; the stage is read there, so that animated attributes have a value."""
    if stage.HasAuthoredTimeCodeRange():
        return Usd.TimeCode(stage.GetStartTimeCode())
    return Usd.TimeCode.EarliestTime()


def _conventions(path: Path, stage: Any, findings: Findings) -> tuple[str, float]:
    if not stage.HasAuthoredMetadata("upAxis"):
        findings.add("No upAxis in the file", "USD's default is taken, Y")
    if not UsdGeom.StageHasAuthoredMetersPerUnit(stage):
        findings.add("No metersPerUnit in the file", "USD's default is taken, 0.01")
    up_axis, unit = str(UsdGeom.GetStageUpAxis(stage)), float(UsdGeom.GetStageMetersPerUnit(stage))
    if up_axis not in (UsdGeom.Tokens.y, UsdGeom.Tokens.z):
        raise InputError(
            f"'{path}' has upAxis = '{up_axis}', but it must be 'Y' or 'Z'. Correct the value in the file."
        )
    if not 0 < unit < math.inf:
        raise InputError(
            f"'{path}' has metersPerUnit = {unit:g}, but it must be above 0. Correct the value in the file."
        )
    return up_axis, unit


def _digest(stage: Any, textures: Textures, exclude: tuple[str, ...]) -> str:
    """Return a digest of the content of all files and of the excluded patterns; file names do not count."""
    files = {layer.realPath.split("[")[0] for layer in stage.GetUsedLayers()} - {""}
    digests = {hashlib.sha256(Path(file).read_bytes()).hexdigest() for file in files}
    parts = [*sorted(digests | set(textures.digests.values())), *sorted(exclude)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
