"""Pictures on surfaces: found through USD's resolver (also inside a .usdz), decoded once, shared."""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError
from pxr import Ar, UsdShade

from foundry.worlds.camera.loading.confinement import is_within
from foundry.worlds.camera.loading.findings import Findings
from foundry.worlds.camera.loading.scene import FloatArray, UInt8Array
from foundry.worlds.camera.loading.values import Values

LARGEST = 2048
"""Pixels: a larger picture is reduced; no view shows more of it, and it would only fill the memory."""

_UDIM, _FIRST = "<UDIM>", "1001"


def to_srgb(linear: FloatArray) -> FloatArray:
    """Return linear light as sRGB, both clamped to 0..1."""
    light = np.clip(linear, 0, 1)
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def to_linear(srgb: FloatArray) -> FloatArray:
    """Return sRGB as linear light."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


class Textures:
    """The pictures of one stage.

    Attributes:
        digests: SHA-256 of the bytes of each file that was read, by its resolved path.
    """

    def __init__(self, findings: Findings, root: Path) -> None:
        """Begin with none.

        Args:
            findings: takes what cannot be drawn.
            root: folder below which pictures may be read.
        """
        self.digests: dict[str, str] = {}
        self._findings, self._root = findings, root
        self._decoded: dict[str, UInt8Array | None] = {}
        self._shared: dict[tuple[tuple[int, ...], bytes], UInt8Array] = {}

    def load(self, attribute: Any | None, values: Values) -> UInt8Array | None:
        """Return the (h, w, 3 or 4) picture that an attribute names, or None and a finding when there is none."""
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
        """Return the one object that stands for all pictures with these pixels."""
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
    """Apply value * scale + bias (both (4,)) to a picture; `linear`: its values are light, not sRGB."""
    depth = texture.shape[2]
    values = texture / 255.0
    light = values[..., :3] if linear else to_linear(values[..., :3])
    out = [to_srgb(light * scale[:3] + bias[:3])]
    if depth == 4:
        out.append(np.clip(values[..., 3:] * scale[3] + bias[3], 0, 1))
    return np.round(np.concatenate(out, axis=2) * 255).astype(np.uint8)
