"""Conversion of coordinates from one coordinate reference system to another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.crs import crs_name, metric_crs


@dataclass(frozen=True, eq=False)
class Reprojection:
    """Conversion from a CRS to a projected CRS in metres.

    Heights are converted to metres but otherwise unchanged; heights of geocentric coordinates
    become ellipsoidal heights.

    Parameters
    ----------
    source : str
        CRS of the coordinates: projected, geographic or geocentric.
    target : str
        Projected CRS in metres.
    height_factor : float
        Metres per unit of the heights.
    """

    source: str
    target: str
    height_factor: float
    _transformer: Any

    @classmethod
    def create(
        cls, source: str, target: str, *, height_factor: float = 1.0, field: str = "--to-crs"
    ) -> Reprojection:
        """Prepare the conversion. Raises UsageError if the target is not in metres."""
        from pyproj import CRS, Transformer

        code = metric_crs(target, field)
        system = CRS.from_user_input(source)
        if not system.is_geocentric and system.is_compound:
            system = system.sub_crs_list[0]
        transformer = Transformer.from_crs(system, code, always_xy=True)
        return cls(source, code, height_factor, transformer)

    @property
    def finding(self) -> Finding:
        """Finding that reports the conversion."""
        return Finding("frame.reprojected", crs=crs_name(self.source), to_crs=crs_name(self.target))

    def apply(self, points: FloatArray) -> FloatArray:
        """Convert points.

        Parameters
        ----------
        points : (n, 3) float
            x, y, z in the unit of the source CRS; x is the longitude in a geographic CRS.

        Returns
        -------
        (n, 3) float
            East, north and up in metres.

        Raises
        ------
        InputError
            With the code ``frame.undefined-place`` for points at which a CRS is not defined.
        """
        from pyproj import CRS

        x, y, z = np.asarray(points, np.float64).T
        if CRS.from_user_input(self.source).is_geocentric:
            converted_points = np.column_stack(self._transformer.transform(x, y, z))
        else:
            east, north = self._transformer.transform(x, y)
            converted_points = np.column_stack([east, north, z * self.height_factor])
        is_finite = np.isfinite(points).all(axis=1)
        if not np.isfinite(converted_points[is_finite]).all():
            finding = Finding("frame.undefined-place", crs=crs_name(self.target))
            raise InputError(finding, field="--to-crs")
        return np.ascontiguousarray(converted_points)

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return the derivative (3, 3) of the conversion at a point, for converting normals.

        Central differences are used. Their step is far larger than rounding errors and far smaller
        than distances over which the derivative varies.
        """
        scale = max(1e-6 * float(np.abs(point[:2]).max()), 1e-6)
        steps = np.diag([scale, scale, max(scale, 1e-3)])
        forward, backward = self.apply(point + steps), self.apply(point - steps)
        return np.asarray(((forward - backward) / (2.0 * np.diag(steps)[:, None])).T, np.float64)
