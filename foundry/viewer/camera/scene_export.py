"""Converts a run's scene to GLB (binary glTF 2.0), for the 3D part of the viewer.

The file shows the scene as the model saw it: with foundry's triangles, textures and colours. The colours contain the
light already, so the page needs no light source (`KHR_materials_unlit`). The file also contains a glTF camera at the
height of the agent's eye above its feet. `extras.body_height` of the camera's node is the height of the agent's body,
in metres. `extras.targets` of the root node lists the boxes around objects that can be targets, in metres, Z up.

foundry writes the format itself: it is just a header, a JSON text and one block of bytes. Existing libraries for GLB
either leave the packing of the bytes to their caller, or cannot write materials that need no light.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import numpy.typing as npt
from PIL import Image

from foundry.storing.store import RunFolder, write_atomically
from foundry.viewer.camera.scenes import scene_of

if TYPE_CHECKING:
    from foundry.worlds.camera.loading.scene import Scene, SceneMesh, UInt8Array

LARGEST_PX = 1024
"""Largest side of a texture, pixels; a larger one would fill most of the file, and a browser shows no more detail."""
JPEG_QUALITY = 80

_FLOAT, _UINT32, _UINT8 = 5126, 5125, 5121
_VERTICES, _INDICES = 34962, 34963
_WRAPS = {"repeat": 10497, "mirror": 33648, "clamp": 33071}
_TO_Y_UP = (-0.7071067811865476, 0.0, 0.0, 0.7071067811865476)
"""Rotation, as quaternion (x, y, z, w), from foundry's axes (Z points up) to those of glTF (Y points up)."""


def kept_scene_glb(run: RunFolder) -> bytes | None:
    """Return the scene of a run as GLB, or None if the world has no scene or nothing is recorded yet.

    The GLB is stored in the sweep's folder, so the scene's own file is no longer needed.

    Raises:
        InputError: the scene's file is missing or has changed.
    """
    line = run.episode_bytes().partition(b"\n")[0]
    if not line:
        return None
    sha256 = str(msgspec.json.decode(line)["scene_sha256"])
    world = run.config()["world"]
    key = digest(sha256, *(world[name] for name in ("scene", "camera", "body", "targets")))
    file = run.viewer_file(f"{key}.glb")
    if file.is_file():
        return file.read_bytes()
    content = scene_glb(run.config(), sha256=sha256)
    if content is not None:
        keep(file, content)
    return content


def keep(file: Path, content: bytes) -> None:
    """Store a file that can be made again; in a read-only folder, nothing is stored."""
    with contextlib.suppress(OSError):
        file.parent.mkdir(exist_ok=True)
        write_atomically(file, content)


def digest(*parts: Any) -> str:
    """Return a short digest of all values that a file depends on."""
    return hashlib.sha256(msgspec.json.encode(parts, order="sorted")).hexdigest()[:16]


def scene_glb(run_config: Mapping[str, Any], *, sha256: str | None = None) -> bytes | None:
    """Return the scene of a run as GLB, Y up and in metres; None if its world has none.

    Args:
        run_config: the effective configuration of the run.
        sha256: digest that the scene must have, or None.

    Raises:
        InputError: the scene's file is missing or has changed.
    """
    world = run_config["world"]
    scene = scene_of(run_config, sha256)
    return (
        None
        if scene is None
        else _to_glb(scene, world["camera"], world["body"], _target_boxes(scene, world["targets"]))
    )


def _target_boxes(scene: Scene, targets: Sequence[Mapping[str, Any]]) -> dict[str, list[list[float]]]:
    """Return, by path, the box around each mesh that can be a target: its lowest and its highest corner, metres."""
    from foundry.worlds.camera.surroundings import is_below

    patterns = [pattern for target in targets for pattern in target["prims"]]
    wanted = [mesh for mesh in scene.meshes if any(is_below(mesh.path, pattern) for pattern in patterns)]
    return {mesh.path: [mesh.points.min(axis=0).tolist(), mesh.points.max(axis=0).tolist()] for mesh in wanted}


def _to_glb(
    scene: Scene, camera: Mapping[str, Any], body: Mapping[str, Any], targets: Mapping[str, list[list[float]]]
) -> bytes:
    """Return a scene and the agent's eye as GLB, from the world's settings and the boxes around possible targets."""
    from foundry.worlds.camera.eye.rendering import batches

    file = _File()
    root = file.add("nodes", {"name": scene.name, "rotation": _TO_Y_UP, "extras": {"targets": targets}})
    children = [file.add("nodes", {"mesh": file.mesh(batch)}) for batch in batches(scene.meshes)]
    lens = {"yfov": float(np.radians(camera["fov"])), "aspectRatio": camera["width"] / camera["height"], "znear": 0.02}
    eye = {
        "name": "eye",
        "camera": file.add("cameras", {"type": "perspective", "perspective": lens}),
        "translation": [0.0, 0.0, body["eye_height"]],
        "extras": {"body_height": body["height"]},
    }
    file.parts["nodes"][root]["children"] = [*children, file.add("nodes", eye)]
    return file.content(root)


@dataclass
class _File:
    """A glTF file while it is made: its JSON arrays, its bytes, and its textures so far."""

    parts: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    _bytes: bytearray = field(default_factory=bytearray)
    _textures: dict[tuple[int, str], int] = field(default_factory=dict)

    def add(self, kind: str, part: dict[str, Any]) -> int:
        """Append an object, such as a mesh, to its array in the glTF file, and return its index there."""
        array = self.parts.setdefault(kind, [])
        array.append(part)
        return len(array) - 1

    def mesh(self, batch: Sequence[SceneMesh]) -> int:
        """Join meshes that have the same texture and opacity, and add them as one mesh."""
        corners = _corners(batch)
        attributes = {
            "POSITION": self._accessor(corners.points, _FLOAT, "VEC3", _VERTICES, bounded=True),
            "COLOR_0": self._accessor(corners.colours, _UINT8, "VEC4", _VERTICES),
        }
        if batch[0].texture is not None:
            attributes["TEXCOORD_0"] = self._accessor(corners.uvs, _FLOAT, "VEC2", _VERTICES)
        indices = self._accessor(corners.triangles.reshape(-1, 1), _UINT32, "SCALAR", _INDICES)
        primitive = {"attributes": attributes, "indices": indices, "material": self._material(batch[0])}
        return self.add("meshes", {"primitives": [primitive]})

    def _material(self, mesh: SceneMesh) -> int:
        look: dict[str, Any] = {"baseColorFactor": [1.0, 1.0, 1.0, mesh.opacity], "metallicFactor": 0.0}
        translucent = mesh.opacity < 1
        if mesh.texture is not None:
            look["baseColorTexture"] = {"index": self._texture(mesh.texture, mesh.wrap)}
            translucent = translucent or _has_holes(mesh.texture)
        return self.add(
            "materials",
            {
                "pbrMetallicRoughness": look,
                "alphaMode": "BLEND" if translucent else "OPAQUE",
                "doubleSided": True,
                "extensions": {"KHR_materials_unlit": {}},
            },
        )

    def _texture(self, pixels: UInt8Array, wrap: str) -> int:
        key = (id(pixels), wrap)
        if key not in self._textures:
            kind, content = _encoded(pixels)
            image = self.add("images", {"mimeType": kind, "bufferView": self._view(content)})
            sampler = self.add("samplers", {"wrapS": _WRAPS[wrap], "wrapT": _WRAPS[wrap]})
            self._textures[key] = self.add("textures", {"source": image, "sampler": sampler})
        return self._textures[key]

    def _accessor(
        self, values: npt.NDArray[Any], component: int, kind: str, target: int, *, bounded: bool = False
    ) -> int:
        part: dict[str, Any] = {
            "bufferView": self._view(values.tobytes(), target),
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if component == _UINT8:
            part["normalized"] = True
        if bounded:
            part |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self.add("accessors", part)

    def _view(self, content: bytes, target: int | None = None) -> int:
        part = {"buffer": 0, "byteOffset": len(self._bytes), "byteLength": len(content)}
        self._bytes += content + b"\0" * (-len(content) % 4)
        return self.add("bufferViews", part if target is None else {**part, "target": target})

    def content(self, root: int) -> bytes:
        """Return the bytes of the glTF file; its scene consists of the node `root` and all nodes below it."""
        head = {
            "asset": {"version": "2.0", "generator": "foundry"},
            "extensionsUsed": ["KHR_materials_unlit"],
            "scene": 0,
            "scenes": [{"nodes": [root]}],
            **self.parts,
            "buffers": [{"byteLength": len(self._bytes)}],
        }
        text = msgspec.json.encode(head)
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self._bytes), b"BIN\0") + bytes(self._bytes)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


@dataclass(frozen=True, eq=False)
class _Corners:
    """The n different corners of m triangles: points (n, 3), linear colours (n, 4), texture coordinates (n, 2).

    `triangles` (m, 3) contains the indices of the three corners of each triangle.
    """

    points: npt.NDArray[np.float32]
    colours: UInt8Array
    uvs: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.uint32]


def _corners(batch: Sequence[SceneMesh]) -> _Corners:
    """Return the different corners of meshes; normals do not count, since the colours include the light."""
    from foundry.worlds.camera.eye.rendering import lit_colours, with_normals
    from foundry.worlds.camera.loading.meshes import weld

    meshes = [with_normals(mesh) for mesh in batch]
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    points = np.concatenate([mesh.points for mesh in meshes])
    colours = _linear(np.concatenate([lit_colours(mesh) for mesh in meshes]))
    uvs = np.concatenate([np.zeros((len(mesh.points), 2)) if mesh.uvs is None else mesh.uvs for mesh in meshes])
    triangles = np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)])
    first, distinct = weld([points, colours, uvs])
    return _Corners(
        points=points[first].astype(np.float32),
        colours=np.pad(colours[first], ((0, 0), (0, 1)), constant_values=255),
        # A texture's origin is at the lower left in foundry and at the upper left in glTF.
        uvs=(uvs[first] * [1, -1] + [0, 1]).astype(np.float32),
        triangles=distinct[triangles].astype(np.uint32),
    )


def _linear(srgb: UInt8Array) -> UInt8Array:
    """Convert sRGB colours to linear light, as glTF requires for the colours of corners (vertices)."""
    from foundry.worlds.camera.loading.materials import to_linear

    return np.round(to_linear(srgb / 255.0) * 255).astype(np.uint8)


def _has_holes(pixels: UInt8Array) -> bool:
    return pixels.shape[2] == 4 and bool((pixels[..., 3] < 255).any())


def _encoded(pixels: UInt8Array) -> tuple[str, bytes]:
    """Return the media type and bytes of a texture: PNG if a pixel is transparent, else the smaller of PNG and JPEG."""
    holes = _has_holes(pixels)
    picture = Image.fromarray(pixels).convert("RGBA" if holes else "RGB")
    picture.thumbnail((LARGEST_PX, LARGEST_PX))
    encoded = {"image/png": _saved(picture, "PNG", optimize=True)}
    if not holes:
        encoded["image/jpeg"] = _saved(picture, "JPEG", quality=JPEG_QUALITY)
    return min(encoded.items(), key=lambda item: len(item[1]))


def _saved(picture: Image.Image, kind: str, **options: Any) -> bytes:
    content = io.BytesIO()
    picture.save(content, kind, **options)
    return content.getvalue()
