"""What a surface looks like, and how to follow the connections of a USD shader network."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pxr import UsdShade

from foundry.worlds.camera.loading.scene import Colour, FloatArray, UInt8Array
from foundry.worlds.camera.loading.textures import to_srgb
from foundry.worlds.camera.loading.values import Values

UNCHANGED: FloatArray = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
"""The transform of texture coordinates that does nothing."""


@dataclass(frozen=True, eq=False)
class Look:
    """What a material says about a surface.

    Attributes:
        colour: sRGB 0..1, or None: the surface's own colour, the primvar `colour_primvar`.
        colour_primvar: where the surface's own colour is.
        opacity: 0..1, or None: the surface's displayOpacity.
        emissive: sRGB 0..1.
        texture: (h, w, 3 or 4) sRGB, row 0 at the top, or None.
        wrap: what the texture does outside 0..1: `repeat`, `mirror` or `clamp`.
        uv_primvar: where the texture coordinates are, or None: the surface's first.
        uv_transform: (3, 2), applied to rows (u, v, 1).
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
    """Return the attribute that gives an input its value: an authored value or a node's output; None when unset."""
    shader_input = shader.GetInput(name)
    if not shader_input:
        return None
    attributes = shader_input.GetValueProducingAttributes()
    return attributes[0] if attributes else None


def node(attribute: Any | None) -> Any | None:
    """Return the shader whose output this attribute is, or None when it holds a value."""
    if attribute is None or UsdShade.Utils.GetType(attribute.GetName()) != UsdShade.AttributeType.Output:
        return None
    return UsdShade.Shader(attribute.GetPrim())


def held(shader: Any, name: str) -> Any | None:
    """Return the attribute that holds the value of an input; None when it is unset or comes out of another node."""
    attribute = source(shader, name)
    return None if node(attribute) is not None else attribute


def identifier(shader: Any) -> str:
    """Return the kind of a shader node."""
    kind = shader.GetIdAttr().Get()
    return kind if isinstance(kind, str) else ""


def coordinates(shader: Any, name: str, values: Values) -> tuple[str | None, FloatArray]:
    """Follow an input of texture coordinates to the primvar it reads, and the transform on the way.

    Returns:
        The primvar's name or None, and the (3, 2) transform of rows (u, v, 1).
    """
    steps: list[FloatArray] = []
    primvar = None
    for reader in _chain(shader, name):
        if identifier(reader) == "UsdTransform2d":
            steps.append(_transform(reader, values))
        else:
            primvar = values.text(held(reader, "varname"), "") or None
    total = UNCHANGED
    for step in reversed(steps):
        total = total @ step[:2] + np.vstack([np.zeros((2, 2)), step[2]])
    return primvar, total


def _chain(shader: Any, name: str) -> Iterator[Any]:
    reader, seen = node(source(shader, name)), set()
    while reader is not None and reader.GetPath() not in seen:  # a file may join the end of a chain to its start
        seen.add(reader.GetPath())
        yield reader
        reader = node(source(reader, "in"))


def _transform(reader: Any, values: Values) -> FloatArray:
    scale = values.vector(held(reader, "scale"), 2) or (1.0, 1.0)
    turn = values.number(held(reader, "rotation"), 0.0)
    shift = values.vector(held(reader, "translation"), 2) or (0.0, 0.0)
    return uv_transform(scale, turn, shift)


def uv_transform(scale: Sequence[float], turn_deg: float, shift: Sequence[float]) -> FloatArray:
    """Return the (3, 2) transform of rows (u, v, 1) that scales, turns counter-clockwise, then shifts."""
    angle = np.radians(turn_deg)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.vstack([np.diag([scale[0], scale[1]]) @ turn, [shift[0], shift[1]]])
