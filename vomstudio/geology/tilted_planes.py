"""Planes as they may be: drawn from each plane's own error, and from that of its registration.

The joint 95 % region of a plane's orientation is taken for that of a normal distribution about it
(chi square with two degrees of freedom), wrapped onto the sphere along great circles. What the
total error has beyond the fit's own, and beyond the registration's, is alike in all directions
(`geometry.rotation_errors.enlarged_semi_axes`). Planes of one registration turn together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import UsageError
from vomstudio.geology.common_rotation_errors import Turns
from vomstudio.geology.orientation import planes_to_normals, sin_cos_deg
from vomstudio.geology.orientation_rows import OrientationRows
from vomstudio.geometry.rotation_errors import CHI2_TWO, enlarged_semi_axes

_WIDEST_DEG = 89.9


@dataclass(frozen=True, eq=False)
class TiltedPlanes:
    """n planes with their errors.

    normals : (n, 3) upward, World. axes : (n, 2, 3) tangent vectors at them, as long as the
    standard deviation along each, radians; zero where no error is known. turns : as in
    OrientationRows, of these planes
    """

    normals: FloatArray
    axes: FloatArray
    turns: Turns | None = None

    @property
    def known(self) -> BoolArray:
        """(n,) whether any error is known."""
        own = np.asarray(self.axes.any(axis=(1, 2)))
        return own if self.turns is None else own | (self.turns.group >= 0)

    def drawn(self, draws: int, generator: np.random.Generator) -> FloatArray:
        """(draws, n, 3) upward unit normals."""
        n = len(self.normals)
        move = np.einsum("knj,njc->knc", generator.standard_normal((draws, n, 2)), self.axes)
        if self.turns is not None and self.turns.known:
            group = self.turns.group
            halves = np.array([_root(covariance) for covariance in self.turns.rotations])
            gauss = generator.standard_normal((draws, len(halves), 3))
            rotations = np.einsum("gij,kgj->kgi", halves, gauss)
            turned = np.cross(rotations[:, np.maximum(group, 0)], self.normals)
            move += np.where((group >= 0)[:, None], turned, 0.0)
        angle = np.linalg.norm(move, axis=-1, keepdims=True)
        toward = move / np.maximum(angle, 1e-300)
        moved = np.cos(angle) * self.normals + np.sin(angle) * toward
        return np.asarray(np.where(moved[..., 2:] < 0.0, -moved, moved))


def tilted_planes(table: OrientationRows, rows: IntArray) -> TiltedPlanes:
    """Those rows of a table, which are planes, with the errors that stand in its columns
    `max_confidence95_deg`, `min_confidence95_deg`, `error_rake_deg` and `total95_deg`; without a
    rake the larger one in all directions; without these `dip_error_deg` and
    `dip_direction_error_deg`."""
    azimuth, dip = table.dip_direction_deg[rows], table.dip_deg[rows]
    turns = None if table.turns is None else table.turns.of(rows)
    turned = np.zeros(len(rows))
    if turns is not None:
        # What turns the planes together is no error of their own.
        registration = np.nan_to_num(cells_of(table, rows, "registration_error_deg"))
        turned = np.where(turns.group >= 0, registration, 0.0)
    axes = _axes(table, rows, turned)
    return TiltedPlanes(planes_to_normals(azimuth, dip), axes, turns)


def axes_without_registration(table: OrientationRows, rows: IntArray) -> FloatArray:
    """(n, 2, 3) as those of TiltedPlanes, of each plane by itself: what its model's registration
    adds to `total95_deg` is taken out."""
    registration = np.nan_to_num(cells_of(table, rows, "registration_error_deg"))
    return _axes(table, rows, registration)


def _axes(table: OrientationRows, rows: IntArray, turned: FloatArray) -> FloatArray:
    """turned : (n,) 95 % half-angles that are taken out of the total error, degrees"""
    azimuth, dip = table.dip_direction_deg[rows], table.dip_deg[rows]
    largest, smallest, total, rake = (
        cells_of(table, rows, name)
        for name in (
            "max_confidence95_deg",
            "min_confidence95_deg",
            "total95_deg",
            "error_rake_deg",
        )
    )
    along, across = (
        cells_of(table, rows, name) for name in ("dip_error_deg", "dip_direction_error_deg")
    )
    # An error of the dip direction turns the plane by its part along the strike.
    across = across * np.sin(np.radians(dip))
    split = ~np.isfinite(largest) & ~np.isfinite(total) & np.isfinite(along)
    largest = np.where(split, along, largest)
    smallest = np.where(split, np.where(np.isfinite(across), across, along), smallest)
    smallest = np.where(np.isfinite(rake) | split, smallest, largest)
    rake = np.where(split, 90.0, rake)
    own = np.nan_to_num(largest)
    narrow = np.where(np.isfinite(smallest), smallest, own)
    semi = np.stack(enlarged_semi_axes(own, narrow, np.nan_to_num(total), turned), axis=-1)
    sigma = np.radians(np.minimum(semi, _WIDEST_DEG)) / math.sqrt(CHI2_TWO)
    return np.asarray(sigma[..., None] * _frames(azimuth, dip, np.nan_to_num(rake)))


def _frames(azimuth_deg: FloatArray, dip_deg: FloatArray, rake_deg: FloatArray) -> FloatArray:
    """(n, 2, 3) unit vectors in the planes: with this rake, and across it."""
    strike_deg = np.where(dip_deg >= 90.0, np.mod(azimuth_deg - 90.0, 180.0), azimuth_deg - 90.0)
    sin_s, cos_s = sin_cos_deg(strike_deg)
    sin_d, cos_d = sin_cos_deg(dip_deg)
    sin_r, cos_r = (part[:, None] for part in sin_cos_deg(rake_deg))
    strike = np.stack([sin_s, cos_s, np.zeros_like(sin_s)], axis=-1)
    # The dip direction is (cos, -sin) of the strike.
    down = np.stack([cos_s * cos_d, -sin_s * cos_d, -sin_d], axis=-1)
    return np.stack([cos_r * strike + sin_r * down, cos_r * down - sin_r * strike], axis=1)


def cells_of(table: OrientationRows, rows: IntArray, name: str) -> FloatArray:
    """Numbers of a column, NaN where there is none; half-angles and rakes are never negative."""
    try:
        cells = table.column(name)
    except UsageError:
        return np.full(len(rows), np.nan)
    return np.array([_number(cells[row]) for row in rows], np.float64)


def _number(cell: str) -> float:
    try:
        value = float(cell.replace(",", "."))
    except ValueError:
        return math.nan
    return value if 0.0 <= value <= 180.0 else math.nan


def _root(covariance: FloatArray) -> FloatArray:
    """A matrix whose product with its transpose is the covariance."""
    values, axes = np.linalg.eigh(covariance)
    return np.asarray(axes * np.sqrt(np.maximum(values, 0.0)))
