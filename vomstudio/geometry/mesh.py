"""A triangle mesh as it stands in its file."""

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
    """`texture` is the full path of an image that exists, or None; `diffuse` is RGB in 0..1."""

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
        """(2, 3) lowest and highest corner; worked out once."""
        # Column by column: a reduction along rows of three is many times slower.
        columns = [self.vertices[:, axis] for axis in range(3)]
        return np.array([[c.min() for c in columns], [c.max() for c in columns]])

    @cached_property
    def undivided(self) -> Mesh:
        """The shape before faces were subdivided, without colours; itself if they were not."""
        from vomstudio.geometry.subdivision import undivided

        found = undivided(self.vertices, self.faces)
        return self if found is None else Mesh(*found)
