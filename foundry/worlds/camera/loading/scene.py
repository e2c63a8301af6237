"""A scene as plain triangles: right-handed, Z up, metres."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from foundry.errors import InputError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
UInt8Array = npt.NDArray[np.uint8]
Colour = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class SceneMesh:
    """The triangles of one prim, or of one geom subset of it.

    Attributes:
        path: prim path; "<prim>/<subset>" for a geom subset, "<instancer>/<prototype>" for a point instancer.
        points: (n, 3) metres.
        triangles: (m, 3) indices of points, counter-clockwise seen from outside.
        normals: (n, 3) unit vectors; None means that the renderer computes them.
        uvs: (n, 2) texture coordinates, (0, 0) at the lower left of the texture, or None.
        colour: sRGB 0..1; multiplies the texture.
        vertex_colours: (n, 3) sRGB; None means `colour` everywhere.
        opacity: 0..1.
        texture: (h, w, 3 or 4) sRGB, row 0 at the top; meshes with the same picture share one object.
        wrap: mode of the texture outside 0..1: `repeat`, `mirror` or `clamp`.
        emissive: sRGB 0..1, added to the colour.
        label: the label of the prim or of its nearest labelled ancestor, or None.
    """

    path: str
    points: FloatArray
    triangles: IntArray
    normals: FloatArray | None = None
    uvs: FloatArray | None = None
    colour: Colour = (0.7, 0.7, 0.7)
    vertex_colours: UInt8Array | None = None
    opacity: float = 1.0
    texture: UInt8Array | None = None
    wrap: str = "repeat"
    emissive: Colour = (0.0, 0.0, 0.0)
    label: str | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """The content of a USD stage.

    Attributes:
        name: the scene file's name without the ending.
        sha256: digest of all files of the stage and of the excluded patterns.
        meshes: in the order of the stage.
        bounds: (2, 3) lowest and highest corner of the points, metres.
        labels: for each label, the paths of the prims that have it; questions can name these things.
        warnings: one line for each kind of content that could not be drawn or found.
        up_axis: as in the file, `Y` or `Z`.
        metres_per_unit: as in the file.
    """

    name: str
    source: str
    sha256: str
    meshes: tuple[SceneMesh, ...]
    bounds: FloatArray
    labels: Mapping[str, tuple[str, ...]]
    warnings: tuple[str, ...]
    up_axis: str
    metres_per_unit: float
    prims: int
    triangles: int

    def check_digest(self, sha256: str) -> None:
        """Check that this is the scene of a run, which recorded a digest.

        Raises:
            InputError: the scene's digest is another one.
        """
        if self.sha256 != sha256:
            raise InputError(
                f"Scene '{self.source}' is not the scene of the run (SHA-256 {self.sha256[:12]}, in the records "
                f"{sha256[:12]}). Restore the file that the run used."
            )
