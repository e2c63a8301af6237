"""Names of things in a stage: semantic labels, else the names of components."""

from __future__ import annotations

from typing import Any

from pxr import Kind, Usd

from foundry.worlds.camera.loading.values import Values

_OURS = "semantics:labels:foundry"


def label_of(prim: Any, values: Values) -> str | None:
    """Return the prim's own label, or None.

    The first that is there counts: the labels `foundry` of UsdSemantics, its other labels, the semantic data that
    Isaac Sim writes, and for a component its display name or its name with spaces for underscores.
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
    for attribute in sorted(attributes, key=lambda one: (one.GetName() != _OURS, one.GetName())):
        label = values.first_text(attribute)
        if label:
            return label
    return None


def _isaac_label(prim: Any, values: Values) -> str | None:
    for attribute in prim.GetAuthoredPropertiesInNamespace("semantic"):
        if attribute.GetName().endswith(":params:semanticData"):
            return values.text(attribute, "")
    return None
