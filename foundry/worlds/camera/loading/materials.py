"""The appearance of surfaces: materials of USD's preview surface or of MDL, with colours and textures."""

import hashlib
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError
from pxr import Ar, UsdShade

from foundry.worlds.camera.loading.scene import Colour, FloatArray, UInt8Array
from foundry.worlds.camera.loading.scene_files import is_within
from foundry.worlds.camera.loading.values import Findings, Values

LARGEST = 2048
"""Largest side of a picture, pixels; larger pictures are scaled down, since no view shows more."""

_UDIM, _FIRST = "<UDIM>", "1001"


def to_srgb(linear: FloatArray) -> FloatArray:
    """Return linear light as sRGB, both clamped to 0..1."""
    light = np.clip(linear, 0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def to_linear(srgb: FloatArray) -> FloatArray:
    """Return sRGB as linear light."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


class Textures:
    """Reads the pictures of one stage.

    Args:
        findings: collects content that cannot be drawn.
        root: folder below which pictures may be read.

    Attributes:
        digests: SHA-256 of each file that was read, by its resolved path.
    """

    def __init__(self, findings: Findings, root: Path) -> None:
        self.digests: dict[str, str] = {}
        self._findings, self._root = findings, root
        self._decoded: dict[str, UInt8Array | None] = {}
        self._shared: dict[tuple[tuple[int, ...], bytes], UInt8Array] = {}

    def load(self, attribute: Any | None, values: Values) -> UInt8Array | None:
        """Return the (h, w, 3 or 4) picture that an attribute names; None if it is missing or damaged."""
        asset = values.asset(attribute)
        if attribute is None or not asset.path:
            return None
        owner, resolved = str(attribute.GetPrim().GetPath()), asset.resolvedPath
        if _UDIM in asset.path:
            self._findings.add("Only the first tile of UDIM textures is drawn", asset.path)
            resolved = _first_tile(asset.path, attribute, values.time)
        if not resolved:
            self._findings.add("Texture not found", f"'{asset.path}' of {owner}")
            return None
        if not is_within(resolved, self._root):
            self._findings.add("Texture outside the scene's folder is not read", f"'{asset.path}' of {owner}")
            return None
        if resolved not in self._decoded:
            self._decoded[resolved] = self._decode(resolved, owner)
        return self._decoded[resolved]

    def shared(self, picture: UInt8Array) -> UInt8Array:
        """Return the same array for all pictures with the same pixels."""
        pixels = np.ascontiguousarray(picture)
        return self._shared.setdefault((pixels.shape, hashlib.sha256(pixels.tobytes()).digest()), pixels)

    def _decode(self, resolved: str, owner: str) -> UInt8Array | None:
        asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
        if not asset:
            self._findings.add("Texture not found", f"'{resolved}' of {owner}")
            return None
        content = bytes(asset.GetBuffer())
        self.digests[resolved] = hashlib.sha256(content).hexdigest()
        try:
            with Image.open(io.BytesIO(content)) as picture:
                return _pixels(picture)
        except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Image.DecompressionBombError):
            self._findings.add("Texture of a kind that cannot be read (PNG, JPEG, TGA and the like can)", resolved)
            return None


def _first_tile(path: str, attribute: Any, time: Any) -> str:
    layer = attribute.GetPropertyStack(time)[0].layer
    return next((tile for tile, number in UsdShade.UdimUtils.ResolveUdimTilePaths(path, layer) if number == _FIRST), "")


def _pixels(picture: Image.Image) -> UInt8Array:
    if picture.mode.startswith("I;16"):
        picture = Image.fromarray((np.asarray(picture) >> 8).astype(np.uint8))
    has_alpha = "A" in picture.getbands() or "transparency" in picture.info
    converted = picture.convert("RGBA" if has_alpha else "RGB")
    converted.thumbnail((LARGEST, LARGEST))
    return np.asarray(converted, np.uint8)


def scaled(texture: UInt8Array, scale: FloatArray, bias: FloatArray, *, linear: bool) -> UInt8Array:
    """Return linear light * `scale` + `bias`, both (4,), for every pixel; pixels are sRGB unless `linear`."""
    depth = texture.shape[2]
    values = texture / 255.0
    light = values[..., :3] if linear else to_linear(values[..., :3])
    out = [to_srgb(light * scale[:3] + bias[:3])]
    if depth == 4:
        out.append(np.clip(values[..., 3:] * scale[3] + bias[3], 0, 1))
    return np.round(np.concatenate(out, axis=2) * 255).astype(np.uint8)


UNCHANGED: FloatArray = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
"""The transform that leaves texture coordinates as they are."""


@dataclass(frozen=True, eq=False)
class Look:
    """The appearance that a material gives to a surface.

    Attributes:
        colour: sRGB 0..1; None means the surface's own colour, the primvar `colour_primvar`.
        colour_primvar: primvar of the surface's own colour.
        opacity: 0..1; None means the surface's own opacity, its primvar `displayOpacity`.
        emissive: sRGB 0..1.
        texture: (h, w, 3 or 4) sRGB, row 0 at the top, or None.
        wrap: mode of the texture outside 0..1: `repeat`, `mirror` or `clamp`.
        uv_primvar: primvar of the texture coordinates; None means the first one of the surface.
        uv_transform: (3, 2) transform of texture coordinates as rows (u, v, 1).
    """

    colour: Colour | None = None
    colour_primvar: str = "displayColor"
    opacity: float | None = None
    emissive: Colour = (0.0, 0.0, 0.0)
    texture: UInt8Array | None = None
    wrap: str = "repeat"
    uv_primvar: str | None = None
    uv_transform: FloatArray = field(default_factory=lambda: UNCHANGED)


def srgb(linear: Sequence[float]) -> Colour:
    """Return a linear RGB value as sRGB."""
    red, green, blue = to_srgb(np.array(linear, np.float64)).tolist()
    return red, green, blue


def source(shader: Any, name: str) -> Any | None:
    """Return the attribute from which an input gets its value, perhaps a node's output; None for an unset input."""
    shader_input = shader.GetInput(name)
    if not shader_input:
        return None
    attributes = shader_input.GetValueProducingAttributes()
    return attributes[0] if attributes else None


def node(attribute: Any | None) -> Any | None:
    """Return the shader whose output this attribute is, or None if the attribute holds a value itself."""
    if attribute is None or UsdShade.Utils.GetType(attribute.GetName()) != UsdShade.AttributeType.Output:
        return None
    return UsdShade.Shader(attribute.GetPrim())


def held(shader: Any, name: str) -> Any | None:
    """Return the attribute with the value of a shader's input; None if it is unset or another node sets it."""
    attribute = source(shader, name)
    return None if node(attribute) is not None else attribute


def identifier(shader: Any) -> str:
    """Return the kind of a shader node."""
    kind = shader.GetIdAttr().Get()
    return kind if isinstance(kind, str) else ""


def coordinates(shader: Any, name: str, values: Values) -> tuple[str | None, FloatArray]:
    """Find the primvar from which a shader's input gets texture coordinates, and the transform on the way.

    Returns:
        The primvar's name or None, and the (3, 2) transform of rows (u, v, 1).
    """
    steps: list[FloatArray] = []
    primvar = None
    for reader in _chain(shader, name):
        if identifier(reader) == "UsdTransform2d":
            scale = values.vector(held(reader, "scale"), 2) or (1.0, 1.0)
            turn = values.number(held(reader, "rotation"), 0.0)
            shift = values.vector(held(reader, "translation"), 2) or (0.0, 0.0)
            steps.append(uv_transform(scale, turn, shift))
        else:
            primvar = values.text(held(reader, "varname"), "") or None
    total = UNCHANGED
    for step in reversed(steps):
        total = total @ step[:2] + np.vstack([np.zeros((2, 2)), step[2]])
    return primvar, total


def _chain(shader: Any, name: str) -> Iterator[Any]:
    reader, seen = node(source(shader, name)), set()
    while reader is not None and reader.GetPath() not in seen:  # a file may connect a chain into a loop
        seen.add(reader.GetPath())
        yield reader
        reader = node(source(reader, "in"))


def uv_transform(scale: Sequence[float], turn_deg: float, shift: Sequence[float]) -> FloatArray:
    """Return the (3, 2) transform of rows (u, v, 1) that scales, then turns counter-clockwise, then shifts."""
    angle = np.radians(turn_deg)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.vstack([np.diag([scale[0], scale[1]]) @ turn, [shift[0], shift[1]]])


_WRAPS = {"mirror": "mirror", "clamp": "clamp", "black": "clamp"}
"""For USD's wrap modes, how a texture continues outside coordinates 0..1; in other modes the texture repeats."""

_CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3}
"""Index of the colour channel, by the name of the output of a texture node."""

_NOT_DRAWN = {"normal": "Normal maps are not drawn", "displacement": "Displacement is not drawn"}
"""Inputs of a shader that foundry does not draw, each with the message for the user."""


class _Reader:
    def __init__(self, textures: Textures, findings: Findings, values: Values) -> None:
        self._textures, self._findings, self._values = textures, findings, values

    def look(self, shader: Any) -> Look:
        """Return the look of a preview surface; its colour comes from a value, a texture or a primvar."""
        diffuse = source(shader, "diffuseColor")
        giver = node(diffuse)
        opacity = self._values.number(held(shader, "opacity"), 1.0)
        emissive = self._emissive(shader)
        for name, kind in _NOT_DRAWN.items():
            if node(source(shader, name)) is not None:
                self._findings.add(kind, str(shader.GetPath()))
        if giver is None:
            value = self._values.vector(held(shader, "diffuseColor"), 3) or (0.18, 0.18, 0.18)
            return Look(colour=srgb(value), opacity=opacity, emissive=emissive)
        if identifier(giver).startswith("UsdPrimvarReader"):
            name = self._values.text(held(giver, "varname"), "displayColor")
            return Look(colour_primvar=name, opacity=opacity, emissive=emissive)
        if identifier(giver) == "UsdUVTexture":
            return self._textured(shader, giver, diffuse, opacity, emissive)
        self._findings.add("Shader node that cannot be drawn", f"{identifier(giver)} at {giver.GetPath()}")
        return Look(opacity=opacity, emissive=emissive)

    def _emissive(self, shader: Any) -> Colour:
        if node(source(shader, "emissiveColor")) is not None:
            self._findings.add("Emission from a texture is not drawn", str(shader.GetPath()))
        return srgb(self._values.vector(held(shader, "emissiveColor"), 3) or (0.0, 0.0, 0.0))

    def _textured(self, shader: Any, giver: Any, diffuse: Any, opacity: float, emissive: Colour) -> Look:
        picture = self._picture(giver)
        if picture is None:
            fallback = self._values.vector(held(giver, "fallback"), 3)
            return Look(colour=None if fallback is None else srgb(fallback), opacity=opacity, emissive=emissive)
        channel = _CHANNELS.get(str(diffuse.GetBaseName()), -1)
        rgb = picture[..., :3] if channel < 0 else np.repeat(_channel(picture, channel)[..., None], 3, axis=2)
        alpha = self._alpha(shader)
        primvar, transform = coordinates(giver, "st", self._values)
        return Look(
            colour=(1.0, 1.0, 1.0),
            opacity=opacity,
            emissive=emissive,
            texture=self._textures.shared(rgb if alpha is None else _with_alpha(rgb, alpha)),
            wrap=_WRAPS.get(self._values.text(held(giver, "wrapS"), "repeat"), "repeat"),
            uv_primvar=primvar,
            uv_transform=transform,
        )

    def _picture(self, giver: Any) -> UInt8Array | None:
        picture = self._textures.load(source(giver, "file"), self._values)
        if picture is None:
            return None
        scale = np.array(self._values.vector(held(giver, "scale"), 4) or (1.0, 1.0, 1.0, 1.0))
        bias = np.array(self._values.vector(held(giver, "bias"), 4) or (0.0, 0.0, 0.0, 0.0))
        linear = self._values.text(held(giver, "sourceColorSpace"), "auto") == "raw"
        if not linear and (scale == 1).all() and (bias == 0).all():
            return picture
        return scaled(picture, scale, bias, linear=linear)

    def _alpha(self, shader: Any) -> UInt8Array | None:
        """Return the texture of the opacity as (h, w) bytes; None if no texture sets the opacity."""
        opacity = source(shader, "opacity")
        giver = node(opacity)
        if opacity is None or giver is None:
            return None
        picture = self._picture(giver) if identifier(giver) == "UsdUVTexture" else None
        if picture is None:
            self._findings.add("Opacity that cannot be drawn", str(shader.GetPath()))
            return None
        alpha = _channel(picture, _CHANNELS.get(str(opacity.GetBaseName()), 0))
        threshold = self._values.number(held(shader, "opacityThreshold"), 0.0)
        return alpha if threshold <= 0 else np.where(alpha >= threshold * 255, 255, 0).astype(np.uint8)


def _channel(picture: UInt8Array, channel: int) -> UInt8Array:
    """Return one channel as (h, w); a picture without alpha is opaque."""
    if channel >= picture.shape[2]:
        return np.full(picture.shape[:2], 255, np.uint8)
    return picture[..., channel]


def _with_alpha(rgb: UInt8Array, alpha: UInt8Array) -> UInt8Array:
    if alpha.shape != rgb.shape[:2]:
        alpha = np.asarray(Image.fromarray(alpha).resize(rgb.shape[1::-1]), np.uint8)
    return np.dstack([rgb, alpha])


_TEXTURES = ("diffuse_texture", "base_color_texture", "albedo_texture", "BaseColorTexture")
_COLOURS = ("diffuse_color_constant", "base_color_factor", "diffuse_reflection_color", "glass_color", "base_color")
_NORMAL_MAPS = ("normalmap_texture", "detail_normalmap_texture", "normal_map_texture")
_OMNI_GREY = (0.2, 0.2, 0.2)
"""Default colour of OmniPBR, linear."""


def mdl_look(shader: Any, textures: Textures, findings: Findings, values: Values) -> Look:
    """Return the base colour, texture, opacity and emission of an MDL shader, by the names that OmniPBR uses."""
    tint = np.array(values.vector(held(shader, "diffuse_tint"), 3) or (1.0, 1.0, 1.0))
    if any(values.asset(held(shader, name)).path for name in _NORMAL_MAPS):
        findings.add("Normal maps are not drawn", _where(shader))
    opacity, emissive = _opacity(shader, findings, values), _emissive(shader, values)
    picture = _picture(shader, textures, values)
    if picture is None:
        colour = srgb(np.array(_base_colour(shader, values)) * tint)
        return Look(colour=colour, opacity=opacity, emissive=emissive)
    if values.flag(held(shader, "project_uvw"), False):
        findings.add("Textures projected along the axes are drawn by the surface's own coordinates", _where(shader))
    texture = picture[..., :3]
    if (tint != 1).any():
        texture = scaled(texture, np.append(tint, 1.0), np.zeros(4), linear=False)
    transform = uv_transform(
        values.vector(held(shader, "texture_scale"), 2) or (1.0, 1.0),
        values.number(held(shader, "texture_rotate"), 0.0),
        values.vector(held(shader, "texture_translate"), 2) or (0.0, 0.0),
    )
    return Look(
        colour=(1.0, 1.0, 1.0),
        opacity=opacity,
        emissive=emissive,
        texture=textures.shared(texture),
        uv_transform=transform,
    )


def other_look(shader: Any, findings: Findings, values: Values) -> Look:
    """Return the constant base colour of a shader that is neither a preview surface nor an MDL shader."""
    kind = identifier(shader) or str(shader.GetPath())
    for name in ("base_color", "baseColor", "diffuse_color", "diffuseColor", "color"):
        value = values.vector(held(shader, name), 3)
        if value is not None:
            findings.add(f"Only the base colour of shaders of the kind '{kind}' is drawn", _where(shader))
            return Look(colour=srgb(value))
    findings.add(f"Shaders of the kind '{kind}' cannot be drawn", _where(shader))
    return Look()


def _where(shader: Any) -> str:
    return str(shader.GetPath())


def _base_colour(shader: Any, values: Values) -> Sequence[float]:
    name = next((name for name in _COLOURS if source(shader, name) is not None), None)
    return _OMNI_GREY if name is None else values.vector(held(shader, name), 3) or _OMNI_GREY


def _picture(shader: Any, textures: Textures, values: Values) -> UInt8Array | None:
    pictures = (textures.load(source(shader, name), values) for name in _TEXTURES)
    return next((picture for picture in pictures if picture is not None), None)


def _opacity(shader: Any, findings: Findings, values: Values) -> float:
    if source(shader, "glass_color") is not None:
        return 0.3
    if not values.flag(held(shader, "enable_opacity"), False):
        return 1.0
    if values.asset(held(shader, "opacity_texture")).path:
        findings.add("Opacity that cannot be drawn", _where(shader))
    return values.number(held(shader, "opacity_constant"), 1.0)


def _emissive(shader: Any, values: Values) -> Colour:
    if not values.flag(held(shader, "enable_emission"), False):
        return (0.0, 0.0, 0.0)
    return srgb(values.vector(held(shader, "emissive_color"), 3) or (1.0, 0.1, 0.1))


_PREVIEW = ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader")
_CONTEXTS = ("", "mdl", "mtlx")
"""USD's render contexts for a material's surface shader, the preferred one first."""


class Materials:
    """Reads each material of a stage once."""

    def __init__(self, textures: Textures, findings: Findings, values: Values) -> None:
        self._textures, self._findings, self._values = textures, findings, values
        self._looks: dict[str, Look] = {}

    def look(self, prim: Any) -> Look:
        """Return the look of a prim or of a geom subset; without a material, a look without colour and texture."""
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        if not material:
            self._name_missing(prim)
            return Look()
        path = str(material.GetPath())
        if path not in self._looks:
            self._looks[path] = self._read(material)
        return self._looks[path]

    def _name_missing(self, prim: Any) -> None:
        while prim and not prim.IsPseudoRoot():
            binding = prim.GetRelationship("material:binding")
            for target in binding.GetTargets() if binding else ():
                if not prim.GetStage().GetPrimAtPath(target):
                    self._findings.add("Material not found", f"{target} of {prim.GetPath()}")
            prim = prim.GetParent()

    def _read(self, material: Any) -> Look:
        shader = next(filter(bool, (material.ComputeSurfaceSource(name)[0] for name in _CONTEXTS)), None)
        if shader is None:
            self._findings.add("Material without a surface that can be drawn", str(material.GetPath()))
            return Look()
        if identifier(shader) in _PREVIEW:
            return _Reader(self._textures, self._findings, self._values).look(shader)
        if shader.GetPrim().HasAttribute("info:mdl:sourceAsset"):
            return mdl_look(shader, self._textures, self._findings, self._values)
        return other_look(shader, self._findings, self._values)
