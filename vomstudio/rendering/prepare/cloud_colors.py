"""The colours that the points of a cloud are drawn with while it shows no field."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vomstudio.core.arrays import AnyArray, ByteArray, IntegerArray
from vomstudio.geometry.cloud import PointCloud


def coloring(sample: PointCloud) -> Callable[[PointCloud, IntegerArray], ByteArray]:
    """Gives (n, 3) for rows (n,) of pieces of a cloud: its own colours, else its intensity, else a
    quiet ramp of height, by one rule for all, which follows from a sample of it."""
    if sample.colors is not None:

        def own(piece: PointCloud, rows: IntegerArray) -> ByteArray:
            assert piece.colors is not None
            return np.asarray(piece.colors[rows, :3], np.uint8)

        return own
    chosen = ""
    for name, field in sample.fields.items():
        if "intensity" in name.lower() and float(np.ptp(field)) > 0:
            chosen = name

    def values_of(piece: PointCloud) -> AnyArray:
        return piece.fields[chosen] if chosen else piece.points[:, 2]

    values = values_of(sample)
    some = np.asarray(values[:: max(1, len(values) // 100_000)], np.float64)
    low, high = np.nanpercentile(some, [2.0, 98.0])
    dark, light = np.array([70.0, 66.0, 62.0]), np.array([232.0, 226.0, 214.0])

    def ramp(piece: PointCloud, rows: IntegerArray) -> ByteArray:
        values = values_of(piece)[rows]
        grey = np.clip((values - low) / max(float(high - low), 1e-9), 0.0, 1.0)[:, None]
        return np.asarray(dark + np.nan_to_num(grey) * (light - dark), np.uint8)

    return ramp
