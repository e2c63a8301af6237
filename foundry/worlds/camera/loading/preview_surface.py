"""UsdPreviewSurface: colour, texture, opacity and emission."""

from __future__ import annotations

from typing import Any

import numpy as np
from PIL import Image

from foundry.worlds.camera.loading.findings import Findings
from foundry.worlds.camera.loading.scene import Colour, UInt8Array
from foundry.worlds.camera.loading.shading import Look, coordinates, held, identifier, node, source, srgb
from foundry.worlds.camera.loading.textures import Textures, scaled
from foundry.worlds.camera.loading.values import Values

_WRAPS = {"mirror": "mirror", "clamp": "clamp", "black": "clamp"}
"""Every other mode, and none at all, repeats."""


_CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3}
"""Outputs of a texture that are one channel of it."""


_NOT_DRAWN = {"normal": "Normal maps are not drawn", "displacement": "Displacement is not drawn"}
"""Inputs that a texture can give and that no picture shows."""


def preview_look(shader: Any, textures: Textures, findings: Findings, values: Values) -> Look:
    """Read a UsdPreviewSurface shader."""
    return _Reader(textures, findings, values).look(shader)


class _Reader:
    def __init__(self, textures: Textures, findings: Findings, values: Values) -> None:
        self._textures, self._findings, self._values = textures, findings, values

    def look(self, shader: Any) -> Look:
        """Read the surface; its colour comes from a value, a texture or a primvar."""
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
        """Return the (h, w) picture that the opacity comes from, or None when it comes from none."""
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
