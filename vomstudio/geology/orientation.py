"""Lines and planes: the angles of geologists and the vectors behind them.

World frame x East, y North, z Up; azimuths clockwise from North, all angles in degrees. A line is
(trend, plunge), plunge positive down, with the vector (sin t cos p, cos t cos p, -sin p). A plane
is (dip direction, dip) with the upward normal (sin dd sin d, cos dd sin d, cos d); its pole is the
downward normal, the line (dd + 180, 90 - d); its strike, by the right-hand rule, is dd - 90.

Angles are recovered with atan2 of both legs, never with arccos or arcsin alone, which lose half of
the digits near horizontal and vertical; sines and cosines are exact at multiples of 90 degrees, so
that a vertical plane has a normal whose z is exactly 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.vectors import wrap360

ANGLE_TOLERANCE_DEG = 1e-7
"""A dip under this has no dip direction, a plunge within this of 90 has no trend, and a plane or
line within this of vertical or horizontal is treated as exactly that where a choice between two
equivalent directions must be made. Far below any measurement, far above rounding."""


# Angles --------------------------------------------------------------------------------------


def sin_cos_deg(angle_deg: float | FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine of degrees, exact at every multiple of 90."""
    angle = np.asarray(angle_deg, dtype=np.float64)
    quadrant = np.round(angle / 90.0)
    rest_rad = np.radians(angle - 90.0 * quadrant)
    s, c = np.sin(rest_rad), np.cos(rest_rad)
    turn = np.mod(quadrant, 4.0)
    sine = np.select([turn == 0, turn == 1, turn == 2], [s, c, -s], -c) + 0.0
    cosine = np.select([turn == 0, turn == 1, turn == 2], [c, -s, -c], s) + 0.0
    return sine, cosine


def _finite(value: float, name: str) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise GeometryError(Finding("number.not-an-angle", text=str(value)), field=name)
    return number


# Arrays --------------------------------------------------------------------------------------


def lines_to_vectors(trend_deg: npt.ArrayLike, plunge_deg: npt.ArrayLike) -> FloatArray:
    """Unit vectors (n, 3), World, of n lines; a plunge over 90 is not refused here."""
    sin_t, cos_t = sin_cos_deg(np.asarray(trend_deg, dtype=np.float64))
    sin_p, cos_p = sin_cos_deg(np.asarray(plunge_deg, dtype=np.float64))
    return np.stack(np.broadcast_arrays(sin_t * cos_p, cos_t * cos_p, 0.0 - sin_p), axis=-1)


def planes_to_normals(dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike) -> FloatArray:
    """Upward unit normals (n, 3), World, of n planes."""
    sin_a, cos_a = sin_cos_deg(np.asarray(dip_direction_deg, dtype=np.float64))
    sin_d, cos_d = sin_cos_deg(np.asarray(dip_deg, dtype=np.float64))
    return np.stack(np.broadcast_arrays(sin_a * sin_d, cos_a * sin_d, cos_d), axis=-1)


def planes_to_poles(dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike) -> FloatArray:
    """Downward unit normals (n, 3), World, of n planes."""
    return 0.0 - planes_to_normals(dip_direction_deg, dip_deg)


def vectors_to_lines(
    vectors: npt.ArrayLike, *, directed: bool = False
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Trend, plunge and "trend undefined" (n,) of vectors (n, 3) of any length but zero.

    Axial (default): plunge in [0, 90]; a horizontal line takes the trend in [0, 180).
    Directed: plunge in [-90, 90]. A vertical line has trend 0 and is flagged. Zero or non-finite
    vectors give NaN (and are not flagged as vertical). The input is not modified.
    """
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    bad = ~np.isfinite(v).all(axis=-1) | ((x == 0) & (y == 0) & (z == 0))
    with np.errstate(invalid="ignore"):
        trend = np.degrees(np.arctan2(x, y))
        plunge = np.degrees(np.arctan2(-z, np.hypot(x, y)))
    if not directed:
        up = plunge < 0
        trend = np.where(up, trend + 180.0, trend)
        plunge = np.abs(plunge)
        flat = plunge < ANGLE_TOLERANCE_DEG
        plunge = np.where(flat, 0.0, plunge)
        trend = wrap360(trend)
        trend = np.where(flat, _half_turn(trend), trend)
    undefined = 90.0 - np.abs(plunge) < ANGLE_TOLERANCE_DEG
    plunge = np.where(undefined, np.copysign(90.0, plunge), plunge)
    trend = np.where(undefined, 0.0, wrap360(trend))
    return (
        np.where(bad, np.nan, trend),
        np.where(bad, np.nan, plunge + 0.0),
        np.where(bad, False, undefined),
    )


def normals_to_planes(normals: npt.ArrayLike) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Dip direction, dip and "dip direction undefined" (n,) of normals (n, 3), either sign, any
    length but zero.

    A vertical plane takes the dip direction in [90, 270), so that its strike is in [0, 180).
    A horizontal one has dip direction 0 and is flagged. Zero or non-finite normals give NaN.
    """
    n = np.atleast_2d(np.asarray(normals, dtype=np.float64))
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    bad = ~np.isfinite(n).all(axis=-1) | ((x == 0) & (y == 0) & (z == 0))
    with np.errstate(invalid="ignore"):
        azimuth = np.degrees(np.arctan2(x, y))
        dip = np.degrees(np.arctan2(np.hypot(x, y), np.abs(z)))
    azimuth = wrap360(np.where(z < 0, azimuth + 180.0, azimuth))
    vertical = 90.0 - dip < ANGLE_TOLERANCE_DEG
    dip = np.where(vertical, 90.0, dip)
    azimuth = np.where(vertical, wrap360(_half_turn(wrap360(azimuth - 90.0)) + 90.0), azimuth)
    undefined = dip < ANGLE_TOLERANCE_DEG
    azimuth = np.where(undefined, 0.0, azimuth)
    dip = np.where(undefined, 0.0, dip)
    return (
        np.where(bad, np.nan, azimuth),
        np.where(bad, np.nan, dip),
        np.where(bad, False, undefined),
    )


def _half_turn(azimuth_deg: FloatArray) -> FloatArray:
    """An azimuth in [0, 360) taken modulo 180; one a rounding error below 180 or 360 is 0, so that
    the two readings of the same horizontal line agree."""
    half = np.where(azimuth_deg >= 180.0, azimuth_deg - 180.0, azimuth_deg)
    return np.where(180.0 - half < ANGLE_TOLERANCE_DEG, 0.0, half)


# Single lines and planes ---------------------------------------------------------------------


@dataclass(frozen=True)
class Line:
    """A line, axial or directed. Trend is taken modulo 360; plunge, positive down, must lie in
    [-90, 90] (negative only for directed lines: it points up). The trend of a vertical line is 0,
    and `undefined` says so. Raises GeometryError for anything else."""

    trend_deg: float
    plunge_deg: float

    def __post_init__(self) -> None:
        trend = wrap360(_finite(self.trend_deg, "trend"))
        plunge = _finite(self.plunge_deg, "plunge") + 0.0
        if not -90.0 <= plunge <= 90.0:
            raise GeometryError(
                Finding("angle.out-of-range", value=plunge, minimum=-90, maximum=90),
                field="plunge",
            )
        object.__setattr__(self, "plunge_deg", plunge)
        object.__setattr__(self, "trend_deg", 0.0 if self.undefined else trend)

    @property
    def undefined(self) -> bool:
        """True where the line is vertical, so that its trend means nothing."""
        return 90.0 - abs(self.plunge_deg) < ANGLE_TOLERANCE_DEG

    def vector(self) -> FloatArray:
        """Unit vector (3,), World."""
        return lines_to_vectors(self.trend_deg, self.plunge_deg)

    @classmethod
    def from_vector(cls, vector: npt.ArrayLike, *, directed: bool = False) -> Line:
        """The line along a vector of any length but zero; axial unless `directed`."""
        v = _vector3(vector, "direction")
        trend, plunge, _ = vectors_to_lines(v, directed=directed)
        return cls(float(trend[0]), float(plunge[0]))

    def downward(self) -> Line:
        """The same axis with a plunge in [0, 90]."""
        if self.plunge_deg >= 0:
            return self
        return Line(self.trend_deg + 180.0, -self.plunge_deg)

    def normal_plane(self) -> Plane:
        """The plane that has this line as its pole."""
        line = self.downward()
        if line.undefined:
            return Plane(0.0, 0.0)
        if line.plunge_deg < ANGLE_TOLERANCE_DEG:
            return Plane.from_normal(line.vector())
        return Plane(line.trend_deg + 180.0, 90.0 - line.plunge_deg)


@dataclass(frozen=True)
class Plane:
    """A plane. Dip direction is taken modulo 360; dip must lie in [0, 90] (an overturned bed is a
    flag beside its plane, not a dip over 90). The dip direction of a horizontal plane is 0, and
    `undefined` says so. A vertical plane keeps the dip direction it was given, though the opposite
    one names the same plane; `from_normal` gives the one in [90, 270). Raises GeometryError."""

    dip_direction_deg: float
    dip_deg: float

    def __post_init__(self) -> None:
        azimuth = wrap360(_finite(self.dip_direction_deg, "dip direction"))
        dip = _finite(self.dip_deg, "dip") + 0.0
        if not 0.0 <= dip <= 90.0:
            raise GeometryError(
                Finding("angle.out-of-range", value=dip, minimum=0, maximum=90),
                field="dip",
            )
        object.__setattr__(self, "dip_deg", dip)
        object.__setattr__(self, "dip_direction_deg", 0.0 if self.undefined else azimuth)

    @property
    def undefined(self) -> bool:
        """True where the plane is horizontal, so that dip direction and strike mean nothing."""
        return self.dip_deg < ANGLE_TOLERANCE_DEG

    @property
    def vertical(self) -> bool:
        return 90.0 - self.dip_deg < ANGLE_TOLERANCE_DEG

    @property
    def strike_rhr_deg(self) -> float:
        """Strike with the plane dipping to the right; meaningless where `undefined`."""
        return wrap360(self.dip_direction_deg - 90.0)

    @classmethod
    def from_strike(cls, strike_rhr_deg: float, dip_deg: float) -> Plane:
        return cls(_finite(strike_rhr_deg, "strike") + 90.0, dip_deg)

    @classmethod
    def from_normal(cls, normal: npt.ArrayLike) -> Plane:
        """The plane with this normal, of either sign and any length but zero."""
        azimuth, dip, _ = normals_to_planes(_vector3(normal, "normal"))
        return cls(float(azimuth[0]), float(dip[0]))

    @classmethod
    def from_normals(cls, normals: npt.ArrayLike) -> list[Plane]:
        """The planes with these normals (n, 3): `from_normal` of all at once."""
        rows = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
        if not (np.isfinite(rows).all() and rows.any(axis=1).all()):
            return [cls.from_normal(row) for row in rows]
        azimuth, dip, _ = normals_to_planes(rows)
        return [cls(*pair) for pair in zip(azimuth.tolist(), dip.tolist(), strict=True)]

    def normal(self) -> FloatArray:
        """Upward unit normal (3,), World."""
        return planes_to_normals(self.dip_direction_deg, self.dip_deg)

    @property
    def pole_trend_deg(self) -> float:
        """Trend of the downward normal, 0 where the plane is horizontal."""
        return 0.0 if self.undefined else wrap360(self.dip_direction_deg + 180.0)

    @property
    def pole_plunge_deg(self) -> float:
        """Plunge of the downward normal."""
        return 90.0 if self.undefined else 90.0 - self.dip_deg

    def pole(self) -> Line:
        """The downward normal as a line."""
        return Line(self.pole_trend_deg, self.pole_plunge_deg)

    def strike_vector(self) -> FloatArray:
        """Horizontal unit vector (3,) along the strike that rakes are counted from: right-hand
        rule, but in [0, 180) on a vertical plane."""
        return lines_to_vectors(self._rake_strike_deg(), 0.0)

    def dip_vector(self) -> FloatArray:
        """Unit vector (3,) down dip."""
        return lines_to_vectors(self._rake_strike_deg() + 90.0, self.dip_deg)

    def _rake_strike_deg(self) -> float:
        strike = self.strike_rhr_deg
        return float(_half_turn(np.asarray(strike))) if self.vertical else strike


def _vector3(vector: npt.ArrayLike, name: str) -> FloatArray:
    v = np.asarray(vector, dtype=np.float64)
    if v.shape != (3,) or not np.isfinite(v).all() or not v.any():
        raise GeometryError(Finding("vector.invalid", name=name))
    return v


# Angles between ------------------------------------------------------------------------------


def _angle_deg(a: FloatArray, b: FloatArray, *, axial: bool) -> float:
    across = float(np.linalg.norm(np.cross(a, b)))
    along = float(a @ b)
    return math.degrees(math.atan2(across, abs(along) if axial else along))


def angle_between_lines(a: Line, b: Line, *, directed: bool = False) -> float:
    """Angle in degrees: 0 to 90 between axes, 0 to 180 between directed lines."""
    return _angle_deg(a.vector(), b.vector(), axial=not directed)


def angle_between_planes(a: Plane, b: Plane) -> float:
    """Acute dihedral angle in degrees, 0 to 90."""
    return _angle_deg(a.normal(), b.normal(), axial=True)


def angle_line_plane(line: Line, plane: Plane) -> float:
    """Angle in degrees, 0 to 90, by which the line leaves the plane."""
    return 90.0 - _angle_deg(line.vector(), plane.normal(), axial=True)


def intersection(a: Plane, b: Plane) -> Line:
    """The line in which two planes meet. Raises GeometryError where they are parallel."""
    across = np.cross(a.normal(), b.normal())
    if np.linalg.norm(across) < math.radians(ANGLE_TOLERANCE_DEG):
        raise GeometryError(Finding("planes.parallel"))
    return Line.from_vector(across)


# Rakes ---------------------------------------------------------------------------------------


def rake_of(line: Line, plane: Plane) -> float:
    """Rake of a lineation (axial) in degrees, [0, 180), from the right-hand-rule strike, 90 = down
    dip; on a vertical plane the strike is taken in [0, 180).

    A line off the plane is first projected onto it along the normal (`angle_line_plane` tells by
    how much); a line along the normal has no rake: GeometryError. On a horizontal plane, whose
    strike is undefined, the rake is counted from the strike of dip direction 0.
    """
    along, down = _in_plane(line, plane)
    return float(_half_turn(np.asarray(wrap360(math.degrees(math.atan2(down, along))))))


def line_from_rake(plane: Plane, rake_deg: float) -> Line:
    """The lineation with this rake, as `rake_of` counts it; any angle is taken modulo 180."""
    sin_r, cos_r = sin_cos_deg(_finite(rake_deg, "rake"))
    return Line.from_vector(cos_r * plane.strike_vector() + sin_r * plane.dip_vector())


def slip_from_rake(plane: Plane, slip_rake_deg: float) -> Line:
    """The directed line along which the hanging wall moves; a reverse slip points up (negative
    plunge)."""
    sin_r, cos_r = sin_cos_deg(_finite(slip_rake_deg, "rake"))
    vector = cos_r * plane.strike_vector() - sin_r * plane.dip_vector()
    return Line.from_vector(vector, directed=True)


def _in_plane(line: Line, plane: Plane) -> tuple[float, float]:
    """Components of the line along the strike and down the dip."""
    v = line.vector()
    along, down = float(v @ plane.strike_vector()), float(v @ plane.dip_vector())
    if math.hypot(along, down) < math.radians(ANGLE_TOLERANCE_DEG):
        raise GeometryError(Finding("line.across-plane"))
    return along, down
