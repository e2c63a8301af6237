"""Makers of the small USD files that the tests load."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from foundry.worlds.camera.loading.scene import Scene, UInt8Array
from foundry.worlds.camera.loading.stage import load_scene

Build = Callable[[Any], object]
"""Puts something into a stage."""

SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
"""A unit square in the plane z = 0 that faces up."""


def new_stage(path: Path, *, up: str | None = "Z", unit: float | None = 1.0) -> Any:
    """Return an empty stage of this file; `up` and `unit` (metres) stay unauthored when None."""
    stage = Usd.Stage.CreateNew(str(path))
    if up is not None:
        UsdGeom.SetStageUpAxis(stage, up)
    if unit is not None:
        UsdGeom.SetStageMetersPerUnit(stage, unit)
    return stage


def saved(stage: Any) -> Path:
    if roots := stage.GetPseudoRoot().GetChildren():
        stage.SetDefaultPrim(roots[0])
    stage.GetRootLayer().Save()
    return Path(stage.GetRootLayer().realPath)


def loaded(stage: Any, *, exclude: Sequence[str] = ()) -> Scene:
    return load_scene(saved(stage), exclude=exclude)


def write_stage(path: Path, build: Build) -> Path:
    stage = new_stage(path)
    build(stage)
    return saved(stage)


def one_mesh(scene: Scene) -> Any:
    (mesh,) = scene.meshes
    return mesh


def mesh(
    stage: Any,
    path: str,
    points: Sequence[Sequence[float]] = SQUARE,
    faces: Sequence[Sequence[int]] = ((0, 1, 2, 3),),
    **attributes: Any,
) -> Any:
    """Add a mesh; `attributes` are attributes of UsdGeomMesh by name."""
    made = UsdGeom.Mesh.Define(stage, path)
    made.CreatePointsAttr([Gf.Vec3f(*point) for point in points])
    made.CreateFaceVertexCountsAttr([len(face) for face in faces])
    made.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
    for name, value in ({"subdivisionScheme": "none"} | attributes).items():
        made.GetPrim().GetAttribute(name).Set(value)
    return made


def instancer(
    stage: Any, path: str, prototypes: Sequence[str], indices: Sequence[int], positions: Sequence[Any]
) -> Any:
    made = UsdGeom.PointInstancer.Define(stage, path)
    made.CreatePrototypesRel().SetTargets([Sdf.Path(prototype) for prototype in prototypes])
    made.CreateProtoIndicesAttr(indices)
    made.CreatePositionsAttr([Gf.Vec3f(*position) for position in positions])
    return made


def primvar(gprim: Any, name: str, kind: Any, interpolation: str, values: Sequence[Any]) -> Any:
    made = UsdGeom.PrimvarsAPI(gprim).CreatePrimvar(name, kind, interpolation)
    made.Set(values)
    return made


def texture_coordinates(gprim: Any, values: Sequence[Sequence[float]], name: str = "st") -> None:
    kind = Sdf.ValueTypeNames.TexCoord2fArray
    primvar(gprim, name, kind, "faceVarying", Vt.Vec2fArray([Gf.Vec2f(*value) for value in values]))


def material(stage: Any, path: str, kind: str = "UsdPreviewSurface", **inputs: Any) -> Any:
    """Add a material with one shader; `inputs` are (type, value) by name."""
    made = UsdShade.Material.Define(stage, path)
    surface = shader(stage, f"{path}/Surface", kind, **inputs)
    made.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    return made


def shader(stage: Any, path: str, kind: str, **inputs: Any) -> Any:
    """Add a shader node; an input is (type, value), or (type, node, output) to connect it."""
    made = UsdShade.Shader.Define(stage, path)
    made.CreateIdAttr(kind)
    for name, (value_type, value, *output) in inputs.items():
        made_input = made.CreateInput(name, value_type)
        if output:
            made_input.ConnectToSource(value.ConnectableAPI(), output[0])
        else:
            made_input.Set(value)
    return made


def bind(prim: Any, bound: Any) -> None:
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(bound)


def textured(stage: Any, path: str, file: str, **reading: Any) -> Any:
    """Add a material whose colour comes out of a picture; `reading` are inputs of its UsdUVTexture."""
    names = Sdf.ValueTypeNames
    coordinates = shader(stage, f"{path}/St", "UsdPrimvarReader_float2", varname=(names.String, "st"))
    picture = shader(
        stage,
        f"{path}/Picture",
        "UsdUVTexture",
        **({"file": (names.Asset, file), "st": (names.Float2, coordinates, "result")} | reading),
    )
    return material(stage, path, diffuseColor=(names.Color3f, picture, "rgb"))


def picture(path: Path, pixels: Any) -> UInt8Array:
    """Write (h, w, 3 or 4) bytes as a PNG."""
    values = np.asarray(pixels, np.uint8)
    Image.fromarray(values).save(path)
    return values
