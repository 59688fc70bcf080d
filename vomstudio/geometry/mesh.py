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
    """Material of faces: full path of an existing image or None, and RGB in 0..1."""

    name: str
    texture: Path | None = None
    diffuse: tuple[float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of one model, in the model's own file frame.

    vertices : (n, 3) float64
    faces : (m, 3) int32, rows into `vertices`, grouped by material in the order of `materials`
    materials : p materials; empty where the file has none
    material_offsets : (p + 1,) int64; faces[o[i]:o[i + 1]] wear materials[i]
    uv : (n, 2) float32, origin at the lower left of the image; NaN where a vertex has none; or None
    colors : (n, 3) uint8 or None
    fields : other values per vertex, each (n,)

    A vertex with two texture coordinates stands twice.
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
        """Lowest and highest corner (2, 3), computed once."""
        # Column by column: a reduction along rows of three is many times slower.
        columns = [self.vertices[:, axis] for axis in range(3)]
        return np.array([[c.min() for c in columns], [c.max() for c in columns]])

    @cached_property
    def undivided(self) -> Mesh:
        """Mesh before subdivision, without colours; itself if it was not subdivided."""
        from vomstudio.geometry.subdivision import find_undivided

        undivided_arrays = find_undivided(self.vertices, self.faces)
        return self if undivided_arrays is None else Mesh(*undivided_arrays)
