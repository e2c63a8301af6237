"""Writes one scene as USD: things with labels, meshes with materials, copies as instances, all packed in a usdz."""

import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from PIL import Image
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdSemantics, UsdShade, Vt

from scene_building.shapes import Shape, Vector

Colour = tuple[int, int, int]
LABELS = "foundry"
REST = "*"
"""Key of the look that all groups of a shape have which are not named."""

_ALIGNMENT = 64
_HEADER = 30


@dataclass(frozen=True)
class Look:
    """The look of a surface.

    Attributes:
        name: names the material and the texture file.
        colour: sRGB, 0..255; of a textured surface only what shows where textures do not.
        texture: picture, row 0 at the top.
        glows: whether it shines by itself.
    """

    name: str
    colour: Colour
    texture: Image.Image | None = None
    glows: bool = False


def linear(colour: Colour) -> Gf.Vec3f:
    """Return an sRGB colour as USD keeps it: linear, 0..1."""
    parts = [c / 255 for c in colour]
    return Gf.Vec3f(*(p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts))


class SceneBuilder:
    """A scene while it is being made, in memory; `save` writes it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.stage = Usd.Stage.CreateInMemory(f"{name}.usdc")
        self._textures: dict[str, bytes] = {}
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        world = UsdGeom.Xform.Define(self.stage, "/World").GetPrim()
        Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
        self.stage.SetDefaultPrim(world)

    def thing(self, path: str, *labels: str, at: Vector = (0.0, 0.0, 0.0), turn: float = 0.0) -> str:
        """Start something that can be asked for by its labels; its meshes are relative to `at` and `turn` (degrees)."""
        self._groups(path)
        prim = UsdGeom.Xform.Define(self.stage, path).GetPrim()
        self._place(prim, at, turn)
        self._label(prim, labels)
        return path

    def part(self, path: str, label: str) -> None:
        """Name a part of the building, such as its walls: what stops a body, not what it is asked to find."""
        self._groups(f"{path}/_")
        self._name(self.stage.GetPrimAtPath(path), [label])

    def mesh(self, path: str, shape: Shape, looks: Look | Mapping[str, Look]) -> None:
        """Add a mesh; looks other than that of `REST` become geom subsets named after their groups."""
        self._groups(path)
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        self._fill(mesh, shape)
        by_group = {REST: looks} if isinstance(looks, Look) else looks
        for group, look in by_group.items():
            if group == REST:
                mesh.CreateDisplayColorAttr([linear(look.colour)])
                self._bind(mesh.GetPrim(), look)
                continue
            faces = [index for index, face in enumerate(shape) if face.group == group]
            name = "Part_" + group.replace("-", "_low").replace("+", "_high")
            subset = UsdShade.MaterialBindingAPI(mesh.GetPrim()).CreateMaterialBindSubset(name, Vt.IntArray(faces))
            self._bind(subset.GetPrim(), look)

    def pattern(self, name: str) -> str:
        """Start a pattern for `copy`; it is not part of the world itself."""
        return str(self.stage.CreateClassPrim(f"/Pattern_{name}").GetPath())

    def copy(self, path: str, pattern: str, *labels: str, at: Vector, turn: float = 0.0) -> None:
        """Add an instance of a pattern."""
        self._groups(path)
        prim = UsdGeom.Xform.Define(self.stage, path).GetPrim()
        # An inherit, since a reference could not reach the materials outside the pattern.
        prim.GetInherits().AddInherit(pattern)
        prim.SetInstanceable(True)
        self._place(prim, at, turn)
        self._label(prim, labels)

    def save(self, folder: Path) -> Path:
        """Write `<name>.usdz` into the folder; the same scene gives the same bytes."""
        layer = folder / f"{self.name}.usdc"
        self.stage.GetRootLayer().Export(str(layer))
        files = [(layer.name, layer.read_bytes()), *sorted(self._textures.items())]
        layer.unlink()
        package = folder / f"{self.name}.usdz"
        _write_package(package, files)
        return package

    def _groups(self, path: str) -> None:
        """Make the ancestors that do not exist yet."""
        for ancestor in Sdf.Path(path).GetParentPath().GetPrefixes():
            if not self.stage.GetPrimAtPath(ancestor):
                prim = UsdGeom.Xform.Define(self.stage, ancestor).GetPrim()
                Usd.ModelAPI(prim).SetKind(Kind.Tokens.group)

    def _place(self, prim: Usd.Prim, at: Vector, turn: float) -> None:
        xform = UsdGeom.Xformable(prim)
        xform.AddTranslateOp().Set(Gf.Vec3d(*at))
        if turn:
            xform.AddRotateZOp().Set(turn)

    def _label(self, prim: Usd.Prim, labels: Sequence[str]) -> None:
        model = Usd.ModelAPI(prim)
        model.SetKind(Kind.Tokens.component)
        model.SetAssetName(labels[0])
        self._name(prim, labels)

    def _name(self, prim: Usd.Prim, labels: Sequence[str]) -> None:
        UsdSemantics.LabelsAPI.Apply(prim, LABELS).CreateLabelsAttr(list(labels))

    def _fill(self, mesh: UsdGeom.Mesh, shape: Shape) -> None:
        corners = [tuple(round(c, 5) for c in corner) for face in shape for corner in face.corners]
        index = {corner: number for number, corner in enumerate(dict.fromkeys(corners))}
        points = Vt.Vec3fArray([Gf.Vec3f(*corner) for corner in index])
        mesh.CreatePointsAttr(points)
        mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
        mesh.CreateFaceVertexCountsAttr([len(face.corners) for face in shape])
        mesh.CreateFaceVertexIndicesAttr([index[corner] for corner in corners])
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        uvs = [Gf.Vec2f(round(u, 5), round(v, 5)) for face in shape for u, v in face.uvs]
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        st.Set(Vt.Vec2fArray(uvs))

    def _bind(self, prim: Usd.Prim, look: Look) -> None:
        path = f"/World/Looks/{look.name}"
        material = UsdShade.Material.Get(self.stage, path)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material if material else self._material(path, look))

    def _material(self, path: str, look: Look) -> UsdShade.Material:
        UsdGeom.Scope.Define(self.stage, "/World/Looks")
        material = UsdShade.Material.Define(self.stage, path)
        shader = UsdShade.Shader.Define(self.stage, f"{path}/Surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.8)
        diffuse = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        if look.texture is None:
            diffuse.Set(linear(look.colour))
        else:
            diffuse.ConnectToSource(self._texture(path, look.name, look.texture))
        if look.glows:
            shader.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(linear(look.colour))
        material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", Sdf.ValueTypeNames.Token))
        return material

    def _texture(self, path: str, name: str, picture: Image.Image) -> UsdShade.Output:
        file = f"textures/{name}.png"
        self._textures[file] = _png(picture)
        reader = UsdShade.Shader.Define(self.stage, f"{path}/Coordinates")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        texture = UsdShade.Shader.Define(self.stage, f"{path}/Texture")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(file))
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
        for wrap in ("wrapS", "wrapT"):
            texture.CreateInput(wrap, Sdf.ValueTypeNames.Token).Set("repeat")
        output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(output)
        return texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)


def _png(picture: Image.Image) -> bytes:
    file = BytesIO()
    picture.save(file, "PNG", optimize=True)
    return file.getvalue()


def _write_package(path: Path, files: Iterable[tuple[str, bytes]]) -> None:
    """Write a usdz: a zip without compression, every file on a boundary of 64 bytes, without times."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as package:
        offset = 0
        for name, content in files:
            entry = zipfile.ZipInfo(name)
            entry.create_system = 3
            padding = -(offset + _HEADER + len(name) + 4) % _ALIGNMENT
            entry.extra = b"\x86\x19" + padding.to_bytes(2, "little") + bytes(padding)
            package.writestr(entry, content)
            offset += _HEADER + len(name) + len(entry.extra) + len(content)
