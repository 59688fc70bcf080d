"""Triangle mesh of a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import (
    ByteArray,
    Float32Array,
    FloatArray,
    GenericArray,
    Int32Array,
    IntArray,
)


@dataclass(frozen=True)
class Material:
    """Material of faces: path of an existing image or None, and RGB from 0 to 1 or None."""

    name: str
    texture: Path | None = None
    diffuse: tuple[float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangle mesh of one model in its file frame.

    Attributes
    ----------
    vertices : (n, 3) float64
        Vertices.
    faces : (m, 3) int32
        Rows of `vertices`, grouped by material in the order of `materials`.
    materials : tuple of Material
        Materials (p,); empty if the file has none.
    material_offsets : (p + 1,) int64
        With these offsets o, ``faces[o[i]:o[i + 1]]`` have the material ``materials[i]``.
    uv : (n, 2) float32 or None
        Texture coordinates with the origin at the lower left of the image; NaN if missing.
    colors : (n, 3) uint8 or None
        Colours of the vertices.
    fields : mapping
        Additional fields (n,) of the vertices, by name.

    Notes
    -----
    A vertex with two texture coordinates is stored twice.
    """

    vertices: FloatArray
    faces: Int32Array
    materials: tuple[Material, ...] = ()
    material_offsets: IntArray = field(default_factory=lambda: np.zeros(1, np.int64))
    uv: Float32Array | None = None
    colors: ByteArray | None = None
    fields: Mapping[str, GenericArray] = field(default_factory=dict)

    @cached_property
    def bounds(self) -> FloatArray:
        """Minimum and maximum corners (2, 3) of the bounding box, computed once."""
        # Column by column: a reduction along rows of three is many times slower.
        columns = [self.vertices[:, axis] for axis in range(3)]
        return np.array(
            [[column.min() for column in columns], [column.max() for column in columns]]
        )

    @cached_property
    def undivided(self) -> Mesh:
        """Mesh before subdivision, without colours, or the mesh itself if not subdivided."""
        from vomstudio.geometry.subdivision import find_undivided

        undivided_arrays = find_undivided(self.vertices, self.faces)
        return self if undivided_arrays is None else Mesh(*undivided_arrays)
