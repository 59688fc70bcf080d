"""Point colours of a cloud that does not show a field."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vomstudio.core.arrays import AnyArray, ByteArray, IntegerArray
from vomstudio.geometry.cloud import PointCloud


def make_coloring(sample: PointCloud) -> Callable[[PointCloud, IntegerArray], ByteArray]:
    """Return a function that colours points by their stored colours, intensity or height.

    All pieces of a cloud are coloured by the same rule, which is derived from a sample. The
    function returns colours (n, 3) uint8 for rows (n,) of a piece.
    """
    if sample.colors is not None:

        def stored_colors(piece: PointCloud, rows: IntegerArray) -> ByteArray:
            assert piece.colors is not None
            return np.asarray(piece.colors[rows, :3], np.uint8)

        return stored_colors
    intensity_field = ""
    for name, field in sample.fields.items():
        if "intensity" in name.lower() and float(np.ptp(field)) > 0:
            intensity_field = name

    def point_values(piece: PointCloud) -> AnyArray:
        return piece.fields[intensity_field] if intensity_field else piece.points[:, 2]

    values = point_values(sample)
    value_sample = np.asarray(values[:: max(1, len(values) // 100_000)], np.float64)
    low, high = np.nanpercentile(value_sample, [2.0, 98.0])
    dark, light = np.array([70.0, 66.0, 62.0]), np.array([232.0, 226.0, 214.0])

    def ramp(piece: PointCloud, rows: IntegerArray) -> ByteArray:
        values = point_values(piece)[rows]
        grey = np.clip((values - low) / max(float(high - low), 1e-9), 0.0, 1.0)[:, None]
        return np.asarray(dark + np.nan_to_num(grey) * (light - dark), np.uint8)

    return ramp
