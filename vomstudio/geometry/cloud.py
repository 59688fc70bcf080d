"""Point cloud of a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    ByteArray,
    Float32Array,
    FloatArray,
    GenericArray,
    IntArray,
)
from vomstudio.geometry.progressive_order import ProgressiveOrder


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Point cloud of one model in its file frame.

    Attributes
    ----------
    points : (n, 3) float64
        Coordinates of the points.
    colors : (n, 3) uint8 or None
        Colours of the points.
    normals : (n, 3) float32 or None
        Normals of the points.
    fields : mapping
        Additional fields (n,) of the points by name, such as the intensity.
    arrangement : ProgressiveOrder or None
        Order in which the points are drawn, if known.
    """

    points: FloatArray
    colors: ByteArray | None = None
    normals: Float32Array | None = None
    fields: Mapping[str, GenericArray] = field(default_factory=dict)
    arrangement: ProgressiveOrder | None = None

    @cached_property
    def bounds(self) -> FloatArray:
        """Minimum and maximum corners (2, 3) of the bounding box, computed once."""
        if self.arrangement is not None and len(self.arrangement):
            boxes = self.arrangement.bounds
            return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
        # Column by column: a reduction along rows of three is many times slower.
        columns = [self.points[:, axis] for axis in range(3)]
        return np.array(
            [[column.min() for column in columns], [column.max() for column in columns]]
        )

    @property
    def count(self) -> int:
        """Number of points in the whole file."""
        return len(self.points)

    def select_rows(self, rows: IntArray | BoolArray | slice) -> PointCloud:
        """Return the points in these rows with all their values, without an arrangement."""
        return PointCloud(
            self.points[rows],
            None if self.colors is None else self.colors[rows],
            None if self.normals is None else self.normals[rows],
            {name: values[rows] for name, values in self.fields.items()},
        )

    def position(self, row: int) -> FloatArray:
        """Return the position (3,) of a point by its row in the file."""
        return np.asarray(self.points[row], np.float64)
