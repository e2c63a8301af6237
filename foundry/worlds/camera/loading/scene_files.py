"""The files that a scene is made of."""

from __future__ import annotations

from pathlib import Path

from pxr import UsdUtils


def scene_files(path: Path) -> list[Path]:
    """Return the root layer of a scene, its other layers and its textures, as far as they are found; sorted."""
    # USD prints its diagnostics on its own; while the delegate lives it keeps them instead.
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        layers, assets, _ = UsdUtils.ComputeAllDependencies(str(path))
    finally:
        delegate.TakeUncoalescedDiagnostics()
    named = {layer.realPath.split("[")[0] for layer in layers} | {str(asset).split("[")[0] for asset in assets}
    files = {Path(name).resolve() for name in named if name} | {path.resolve()}
    return sorted(file for file in files if file.is_file())
