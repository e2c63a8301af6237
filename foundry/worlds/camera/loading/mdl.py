"""MDL materials (OmniPBR and its like) and other shaders, as far as their base colour goes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from foundry.worlds.camera.loading.findings import Findings
from foundry.worlds.camera.loading.scene import Colour, UInt8Array
from foundry.worlds.camera.loading.shading import Look, held, identifier, source, srgb, uv_transform
from foundry.worlds.camera.loading.textures import Textures, scaled
from foundry.worlds.camera.loading.values import Values

_TEXTURES = ("diffuse_texture", "base_color_texture", "albedo_texture", "BaseColorTexture")
_COLOURS = ("diffuse_color_constant", "base_color_factor", "diffuse_reflection_color", "glass_color", "base_color")
_NORMAL_MAPS = ("normalmap_texture", "detail_normalmap_texture", "normal_map_texture")
_OMNI_GREY = (0.2, 0.2, 0.2)
"""OmniPBR's colour where none is authored, linear."""


def mdl_look(shader: Any, textures: Textures, findings: Findings, values: Values) -> Look:
    """Read the base colour, texture, opacity and emission of an MDL shader by OmniPBR's names."""
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
    """Read what can be read of a shader of any other kind (MaterialX among them): a constant base colour."""
    kind = identifier(shader) or str(shader.GetPath())
    for name in ("base_color", "baseColor", "diffuse_color", "diffuseColor", "color"):
        value = values.vector(held(shader, name), 3)
        if value is not None:
            findings.add(f"Of shaders of the kind '{kind}' only the base colour is drawn", _where(shader))
            return Look(colour=srgb(value))
    findings.add(f"Shaders of the kind '{kind}' cannot be drawn", _where(shader))
    return Look()


def _where(shader: Any) -> str:
    return str(shader.GetPath())


def _base_colour(shader: Any, values: Values) -> Sequence[float]:
    authored = (name for name in _COLOURS if source(shader, name) is not None)
    name = next(authored, None)
    return _OMNI_GREY if name is None else values.vector(held(shader, name), 3) or _OMNI_GREY


def _picture(shader: Any, textures: Textures, values: Values) -> UInt8Array | None:
    for name in _TEXTURES:
        picture = textures.load(source(shader, name), values)
        if picture is not None:
            return picture
    return None


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
