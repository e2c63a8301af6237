"""Which material each surface is bound to, and what it looks like."""

from __future__ import annotations

from typing import Any

from pxr import UsdShade

from foundry.worlds.camera.loading.findings import Findings
from foundry.worlds.camera.loading.mdl import mdl_look, other_look
from foundry.worlds.camera.loading.preview_surface import preview_look
from foundry.worlds.camera.loading.shading import Look, identifier
from foundry.worlds.camera.loading.textures import Textures
from foundry.worlds.camera.loading.values import Values

_PREVIEW = ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader")
_CONTEXTS = ("", "mdl", "mtlx")
"""Render contexts in which a surface is looked for, the plain one first."""


class Materials:
    """Reads each material of a stage once."""

    def __init__(self, textures: Textures, findings: Findings, values: Values) -> None:
        self._textures, self._findings, self._values = textures, findings, values
        self._looks: dict[str, Look] = {}

    def look(self, prim: Any) -> Look:
        """Return the look of a prim or of a geom subset; the plain look when nothing is bound to it."""
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
            return preview_look(shader, self._textures, self._findings, self._values)
        if shader.GetPrim().HasAttribute("info:mdl:sourceAsset"):
            return mdl_look(shader, self._textures, self._findings, self._values)
        return other_look(shader, self._findings, self._values)
