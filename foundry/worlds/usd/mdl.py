"""MDL materials (OmniPBR and its like) and other shaders, as far as their base colour goes."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Sdf

from foundry.worlds.usd.findings import Findings
from foundry.worlds.usd.scene import Colour, UInt8Array
from foundry.worlds.usd.shading import Look, constant, identifier, source, srgb, uv_transform
from foundry.worlds.usd.textures import Textures, scaled

_TEXTURES = ("diffuse_texture", "base_color_texture", "albedo_texture", "BaseColorTexture")
_COLOURS = ("diffuse_color_constant", "base_color_factor", "diffuse_reflection_color", "glass_color", "base_color")
_OMNI_GREY = (0.2, 0.2, 0.2)
"""OmniPBR's colour where none is authored, linear."""


def mdl_look(shader: Any, textures: Textures, findings: Findings, time: Any) -> Look:
    """Read the base colour, texture, opacity and emission of an MDL shader by OmniPBR's names."""
    tint = np.array(constant(shader, "diffuse_tint", (1.0, 1.0, 1.0), time), np.float64)
    opacity, emissive = _opacity(shader, findings, time), _emissive(shader, time)
    picture = _picture(shader, textures, time)
    if picture is None:
        colour = srgb(np.array(_base_colour(shader, time), np.float64)[:3] * tint)
        return Look(colour=colour, opacity=opacity, emissive=emissive)
    if constant(shader, "project_uvw", False, time):
        findings.add("Textures projected along the axes are drawn by the surface's own coordinates", _where(shader))
    texture = picture[..., :3]
    if (tint != 1).any():
        texture = scaled(texture, np.append(tint, 1.0), np.zeros(4), linear=False)
    transform = uv_transform(
        constant(shader, "texture_scale", (1.0, 1.0), time),
        float(constant(shader, "texture_rotate", 0.0, time)),
        constant(shader, "texture_translate", (0.0, 0.0), time),
    )
    return Look(
        colour=(1.0, 1.0, 1.0),
        opacity=opacity,
        emissive=emissive,
        texture=textures.shared(texture),
        uv_transform=transform,
    )


def other_look(shader: Any, findings: Findings, time: Any) -> Look:
    """Read what can be read of a shader of any other kind (MaterialX among them): a constant base colour."""
    kind = identifier(shader) or str(shader.GetPath())
    for name in ("base_color", "baseColor", "diffuse_color", "diffuseColor", "color"):
        value = constant(shader, name, None, time)
        if value is not None:
            findings.add(f"Of shaders of the kind '{kind}' only the base colour is drawn", _where(shader))
            return Look(colour=srgb(value))
    findings.add(f"Shaders of the kind '{kind}' cannot be drawn", _where(shader))
    return Look()


def _where(shader: Any) -> str:
    return str(shader.GetPath())


def _base_colour(shader: Any, time: Any) -> Any:
    authored = (name for name in _COLOURS if source(shader, name) is not None)
    name = next(authored, None)
    return _OMNI_GREY if name is None else constant(shader, name, _OMNI_GREY, time)


def _picture(shader: Any, textures: Textures, time: Any) -> UInt8Array | None:
    for name in _TEXTURES:
        picture = textures.load(source(shader, name), time)
        if picture is not None:
            return picture
    return None


def _opacity(shader: Any, findings: Findings, time: Any) -> float:
    if source(shader, "glass_color") is not None:
        return 0.3
    if not constant(shader, "enable_opacity", False, time):
        return 1.0
    if constant(shader, "opacity_texture", Sdf.AssetPath(), time).path:
        findings.add("Opacity that cannot be drawn", _where(shader))
    return float(constant(shader, "opacity_constant", 1.0, time))


def _emissive(shader: Any, time: Any) -> Colour:
    if not constant(shader, "enable_emission", False, time):
        return (0.0, 0.0, 0.0)
    return srgb(constant(shader, "emissive_color", (1.0, 0.1, 0.1), time))
