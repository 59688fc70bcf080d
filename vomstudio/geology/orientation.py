"""Lines and planes: geological angles and the corresponding vectors.

The World frame has x East, y North and z Up; azimuths are clockwise from North and all angles in
degrees. A line is given by (trend, plunge), with the plunge positive downward, and has the vector
(sin t cos p, cos t cos p, -sin p). A plane is given by (dip direction, dip) and has the upward
normal (sin dd sin d, cos dd sin d, cos d). Its pole is the downward normal, which is the line (dd +
180, 90 - d); its strike by the right-hand rule is dd - 90.

Angles are computed by atan2 of both components, never by arccos or arcsin alone, which lose half of
the digits near horizontal and vertical. Sines and cosines are exact at multiples of 90 degrees, so
the normal of a vertical plane has a z of exactly 0.
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
"""Dip below which a plane has no dip direction, and angle from vertical below which a line has no
trend. Planes and lines within this angle of vertical or horizontal are treated as exactly
vertical or horizontal if one of two equivalent directions must be selected. The value is
far below any measurement error and far above rounding errors.
"""


# Angles --------------------------------------------------------------------------------------


def sin_cos_deg(angle_deg: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the sine and cosine of angles in degrees, exact at multiples of 90.

    Parameters
    ----------
    angle_deg : float or array_like

    Returns
    -------
    sine, cosine : ndarray
    """
    if isinstance(angle_deg, float) and math.isfinite(angle_deg):
        return _scalar_sin_cos_deg(angle_deg)
    angle = np.asarray(angle_deg, dtype=np.float64)
    quadrant = np.round(angle / 90.0)
    remainder_rad = np.radians(angle - 90.0 * quadrant)
    s, c = np.sin(remainder_rad), np.cos(remainder_rad)
    quadrant_index = np.mod(quadrant, 4.0)
    # `np.select` takes ten times as long for a single angle.
    is_odd = (quadrant_index == 1.0) | (quadrant_index == 3.0)
    sine = np.where(is_odd, c, s) * np.where(quadrant_index >= 2.0, -1.0, 1.0) + 0.0
    cosine = (
        np.where(is_odd, s, c)
        * np.where((quadrant_index == 1.0) | (quadrant_index == 2.0), -1.0, 1.0)
        + 0.0
    )
    return sine, cosine


def _scalar_sin_cos_deg(angle_deg: float) -> tuple[FloatArray, FloatArray]:
    """Return the sine and cosine of a finite angle, five times faster than for an array."""
    quadrant = round(angle_deg / 90.0)
    remainder_rad = np.radians(angle_deg - 90.0 * quadrant)
    s, c = np.sin(remainder_rad), np.cos(remainder_rad)
    sine, cosine = ((s, c), (c, -s), (-s, -c), (-c, s))[quadrant % 4]
    return sine + 0.0, cosine + 0.0


def _stack_components(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return vectors (..., 3); x and y have the full shape, to which z is broadcast."""
    vectors = np.empty((*np.shape(x), 3))
    vectors[..., 0], vectors[..., 1], vectors[..., 2] = x, y, z
    return vectors


def _require_finite_number(value: float, name: str) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise GeometryError(Finding("number.not-an-angle", text=str(value)), field=name)
    return number


# Arrays --------------------------------------------------------------------------------------


def lines_to_vectors(trend_deg: npt.ArrayLike, plunge_deg: npt.ArrayLike) -> FloatArray:
    """Return the unit vectors of lines; plunges over 90 degrees are accepted.

    Parameters
    ----------
    trend_deg, plunge_deg : (n,) array_like

    Returns
    -------
    (n, 3) ndarray
        In the World frame.
    """
    sin_t, cos_t = sin_cos_deg(trend_deg)
    sin_p, cos_p = sin_cos_deg(plunge_deg)
    return _stack_components(sin_t * cos_p, cos_t * cos_p, 0.0 - sin_p)


def planes_to_normals(dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike) -> FloatArray:
    """Return the upward unit normals of planes.

    Parameters
    ----------
    dip_direction_deg, dip_deg : (n,) array_like

    Returns
    -------
    (n, 3) ndarray
        In the World frame.
    """
    sin_a, cos_a = sin_cos_deg(dip_direction_deg)
    sin_d, cos_d = sin_cos_deg(dip_deg)
    return _stack_components(sin_a * sin_d, cos_a * sin_d, cos_d)


def planes_to_poles(dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike) -> FloatArray:
    """Return the downward unit normals of planes.

    Parameters
    ----------
    dip_direction_deg, dip_deg : (n,) array_like

    Returns
    -------
    (n, 3) ndarray
        In the World frame.
    """
    return 0.0 - planes_to_normals(dip_direction_deg, dip_deg)


def vectors_to_lines(
    vectors: npt.ArrayLike, *, is_directed: bool = False
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Compute the trend and plunge of vectors.

    Parameters
    ----------
    vectors : (n, 3) array_like
        In the World frame, of any non-zero length.
    is_directed : bool
        If False, the vectors are axes: plunges are in [0, 90] and the trends of horizontal lines in
        [0, 180). If True, plunges are in [-90, 90].

    Returns
    -------
    trend, plunge : (n,) ndarray
        Degrees; NaN for zero or non-finite vectors. The trend of a vertical line is 0.
    undefined : (n,) ndarray of bool
        True for vertical lines, whose trend is undefined.
    """
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    is_invalid = ~np.isfinite(v).all(axis=-1) | ((x == 0) & (y == 0) & (z == 0))
    with np.errstate(invalid="ignore"):
        trend = np.degrees(np.arctan2(x, y))
        plunge = np.degrees(np.arctan2(-z, np.hypot(x, y)))
    if not is_directed:
        is_upward = plunge < 0
        trend = np.where(is_upward, trend + 180.0, trend)
        plunge = np.abs(plunge)
        is_flat = plunge < ANGLE_TOLERANCE_DEG
        plunge = np.where(is_flat, 0.0, plunge)
        trend = wrap360(trend)
        trend = np.where(is_flat, _wrap180(trend), trend)
    is_undefined = 90.0 - np.abs(plunge) < ANGLE_TOLERANCE_DEG
    plunge = np.where(is_undefined, np.copysign(90.0, plunge), plunge)
    trend = np.where(is_undefined, 0.0, wrap360(trend))
    return (
        np.where(is_invalid, np.nan, trend),
        np.where(is_invalid, np.nan, plunge + 0.0),
        np.where(is_invalid, False, is_undefined),
    )


def normals_to_planes(normals: npt.ArrayLike) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Compute the dip direction and dip of planes from their normals.

    Parameters
    ----------
    normals : (n, 3) array_like
        In the World frame, pointing up or down, of any non-zero length.

    Returns
    -------
    dip_direction, dip : (n,) ndarray
        Degrees; NaN for zero or non-finite normals. A vertical plane has a dip direction in [90,
        270), so that its strike is in [0, 180); the dip direction of a horizontal plane is 0.
    undefined : (n,) ndarray of bool
        True for horizontal planes, whose dip direction is undefined.
    """
    n = np.atleast_2d(np.asarray(normals, dtype=np.float64))
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    is_invalid = ~np.isfinite(n).all(axis=-1) | ((x == 0) & (y == 0) & (z == 0))
    with np.errstate(invalid="ignore"):
        azimuth = np.degrees(np.arctan2(x, y))
        dip = np.degrees(np.arctan2(np.hypot(x, y), np.abs(z)))
    azimuth = wrap360(np.where(z < 0, azimuth + 180.0, azimuth))
    is_vertical = 90.0 - dip < ANGLE_TOLERANCE_DEG
    dip = np.where(is_vertical, 90.0, dip)
    azimuth = np.where(is_vertical, wrap360(_wrap180(wrap360(azimuth - 90.0)) + 90.0), azimuth)
    is_undefined = dip < ANGLE_TOLERANCE_DEG
    azimuth = np.where(is_undefined, 0.0, azimuth)
    dip = np.where(is_undefined, 0.0, dip)
    return (
        np.where(is_invalid, np.nan, azimuth),
        np.where(is_invalid, np.nan, dip),
        np.where(is_invalid, False, is_undefined),
    )


def _wrap180(azimuth_deg: FloatArray) -> FloatArray:
    """Wrap azimuths in [0, 360) modulo 180; values within rounding of 180 become 0.

    The two equivalent azimuths of a horizontal line then give the same result.
    """
    wrapped_deg = np.where(azimuth_deg >= 180.0, azimuth_deg - 180.0, azimuth_deg)
    return np.where(180.0 - wrapped_deg < ANGLE_TOLERANCE_DEG, 0.0, wrapped_deg)


# Single lines and planes ---------------------------------------------------------------------


@dataclass(frozen=True)
class Line:
    """Axial or directed line.

    Parameters
    ----------
    trend_deg : float
        Taken modulo 360; 0 for a vertical line, which is `undefined`.
    plunge_deg : float
        [-90, 90], positive down; negative only for directed lines, which point up.

    Raises
    ------
    GeometryError
        If an angle is invalid.
    """

    trend_deg: float
    plunge_deg: float

    def __post_init__(self) -> None:
        trend = wrap360(_require_finite_number(self.trend_deg, "trend"))
        plunge = _require_finite_number(self.plunge_deg, "plunge") + 0.0
        if not -90.0 <= plunge <= 90.0:
            raise GeometryError(
                Finding("angle.out-of-range", value=plunge, minimum=-90, maximum=90),
                field="plunge",
            )
        object.__setattr__(self, "plunge_deg", plunge)
        object.__setattr__(self, "trend_deg", 0.0 if self.undefined else trend)

    @property
    def undefined(self) -> bool:
        """Whether the line is vertical and its trend therefore undefined."""
        return 90.0 - abs(self.plunge_deg) < ANGLE_TOLERANCE_DEG

    def vector(self) -> FloatArray:
        """Return the unit vector (3,) in the World frame."""
        return lines_to_vectors(self.trend_deg, self.plunge_deg)

    @classmethod
    def from_vector(cls, vector: npt.ArrayLike, *, is_directed: bool = False) -> Line:
        """Return the line along a vector of any non-zero length, axial unless `is_directed`."""
        v = _to_vector(vector, "direction")
        trend, plunge, _ = vectors_to_lines(v, is_directed=is_directed)
        return cls(float(trend[0]), float(plunge[0]))

    def to_downward(self) -> Line:
        """Return the same axis with a plunge in [0, 90]."""
        if self.plunge_deg >= 0:
            return self
        return Line(self.trend_deg + 180.0, -self.plunge_deg)

    def normal_plane(self) -> Plane:
        """Return the plane whose pole is this line."""
        line = self.to_downward()
        if line.undefined:
            return Plane(0.0, 0.0)
        if line.plunge_deg < ANGLE_TOLERANCE_DEG:
            return Plane.from_normal(line.vector())
        return Plane(line.trend_deg + 180.0, 90.0 - line.plunge_deg)


@dataclass(frozen=True)
class Plane:
    """Plane given by dip direction and dip.

    Parameters
    ----------
    dip_direction_deg : float
        Taken modulo 360; 0 for a horizontal plane, which is `undefined`. A vertical plane keeps the
        given direction, although the opposite one is equivalent; `from_normal` returns the one in
        [90, 270).
    dip_deg : float
        In [0, 90]; overturned beds have a flag instead of a dip over 90.

    Raises
    ------
    GeometryError
        If an angle is invalid.
    """

    dip_direction_deg: float
    dip_deg: float

    def __post_init__(self) -> None:
        azimuth = wrap360(_require_finite_number(self.dip_direction_deg, "dip direction"))
        dip = _require_finite_number(self.dip_deg, "dip") + 0.0
        if not 0.0 <= dip <= 90.0:
            raise GeometryError(
                Finding("angle.out-of-range", value=dip, minimum=0, maximum=90),
                field="dip",
            )
        object.__setattr__(self, "dip_deg", dip)
        object.__setattr__(self, "dip_direction_deg", 0.0 if self.undefined else azimuth)

    @property
    def undefined(self) -> bool:
        """Whether the plane is horizontal and its dip direction and strike therefore undefined."""
        return self.dip_deg < ANGLE_TOLERANCE_DEG

    @property
    def vertical(self) -> bool:
        return 90.0 - self.dip_deg < ANGLE_TOLERANCE_DEG

    @property
    def strike_rhr_deg(self) -> float:
        """Strike by the right-hand rule (dip to the right); meaningless if `undefined`."""
        return wrap360(self.dip_direction_deg - 90.0)

    @classmethod
    def from_strike(cls, strike_rhr_deg: float, dip_deg: float) -> Plane:
        return cls(_require_finite_number(strike_rhr_deg, "strike") + 90.0, dip_deg)

    @classmethod
    def from_normal(cls, normal: npt.ArrayLike) -> Plane:
        """Return the plane with a normal of any non-zero length, pointing up or down."""
        azimuth, dip, _ = normals_to_planes(_to_vector(normal, "normal"))
        return cls(float(azimuth[0]), float(dip[0]))

    @classmethod
    def from_normals(cls, normals: npt.ArrayLike) -> list[Plane]:
        """Return the planes with the normals (n, 3). See `from_normal`."""
        rows = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
        if not (np.isfinite(rows).all() and rows.any(axis=1).all()):
            return [cls.from_normal(row) for row in rows]
        azimuth, dip, _ = normals_to_planes(rows)
        return [cls(*pair) for pair in zip(azimuth.tolist(), dip.tolist(), strict=True)]

    def normal(self) -> FloatArray:
        """Return the upward unit normal (3,) in the World frame."""
        return planes_to_normals(self.dip_direction_deg, self.dip_deg)

    @property
    def pole_trend_deg(self) -> float:
        """Trend of the downward normal; 0 for a horizontal plane."""
        return 0.0 if self.undefined else wrap360(self.dip_direction_deg + 180.0)

    @property
    def pole_plunge_deg(self) -> float:
        """Plunge of the downward normal."""
        return 90.0 if self.undefined else 90.0 - self.dip_deg

    def pole(self) -> Line:
        """Return the pole, the downward normal, as a line."""
        return Line(self.pole_trend_deg, self.pole_plunge_deg)

    def strike_vector(self) -> FloatArray:
        """Return the horizontal unit vector (3,) along the strike, from which rakes are counted.

        The strike follows the right-hand rule, but is in [0, 180) for a vertical plane.
        """
        return lines_to_vectors(self._rake_strike_deg(), 0.0)

    def dip_vector(self) -> FloatArray:
        """Return the unit vector (3,) down the dip."""
        return lines_to_vectors(self._rake_strike_deg() + 90.0, self.dip_deg)

    def _rake_strike_deg(self) -> float:
        strike = self.strike_rhr_deg
        return float(_wrap180(np.asarray(strike))) if self.vertical else strike


def _to_vector(vector: npt.ArrayLike, name: str) -> FloatArray:
    v = np.asarray(vector, dtype=np.float64)
    if v.shape != (3,) or not np.isfinite(v).all() or not v.any():
        raise GeometryError(Finding("vector.invalid", name=name))
    return v


# Angles between ------------------------------------------------------------------------------


def _angle_deg(a: FloatArray, b: FloatArray, *, is_axial: bool) -> float:
    sine = float(np.linalg.norm(np.cross(a, b)))
    cosine = float(a @ b)
    return math.degrees(math.atan2(sine, abs(cosine) if is_axial else cosine))


def angle_between_lines(a: Line, b: Line, *, is_directed: bool = False) -> float:
    """Return the angle between two lines.

    Parameters
    ----------
    a, b : Line
    is_directed : bool, optional
        Whether the lines are directed.

    Returns
    -------
    float
        Degrees: 0 to 90 for axes, 0 to 180 for directed lines.
    """
    return _angle_deg(a.vector(), b.vector(), is_axial=not is_directed)


def angle_between_planes(a: Plane, b: Plane) -> float:
    """Return the acute dihedral angle between two planes.

    Parameters
    ----------
    a, b : Plane

    Returns
    -------
    float
        0 to 90 degrees.
    """
    return _angle_deg(a.normal(), b.normal(), is_axial=True)


def angle_line_plane(line: Line, plane: Plane) -> float:
    """Return the angle between a line and a plane.

    Parameters
    ----------
    line : Line
    plane : Plane

    Returns
    -------
    float
        0 to 90 degrees.
    """
    return 90.0 - _angle_deg(line.vector(), plane.normal(), is_axial=True)


def intersection(a: Plane, b: Plane) -> Line:
    """Return the intersection line of two planes.

    Parameters
    ----------
    a, b : Plane

    Returns
    -------
    Line

    Raises
    ------
    GeometryError
        If the planes are parallel.
    """
    cross_axis = np.cross(a.normal(), b.normal())
    if np.linalg.norm(cross_axis) < math.radians(ANGLE_TOLERANCE_DEG):
        raise GeometryError(Finding("planes.parallel"))
    return Line.from_vector(cross_axis)


# Rakes ---------------------------------------------------------------------------------------


def compute_rake(line: Line, plane: Plane) -> float:
    """Return the rake of an axial lineation, counted from the right-hand-rule strike.

    The rake is in [0, 180) degrees.
    A rake of 90 degrees is down dip. On a vertical plane, the rake is counted from the strike in
    [0, 180). A line off the plane is projected onto it along the normal (see `angle_line_plane` for
    the angle between them). On a horizontal plane, the rake is counted from the strike that belongs
    to the dip direction 0.

    Raises
    ------
    GeometryError
        If the line is parallel to the normal.
    """
    strike_component, dip_component = _plane_components(line, plane)
    return float(
        _wrap180(np.asarray(wrap360(math.degrees(math.atan2(dip_component, strike_component)))))
    )


def line_from_rake(plane: Plane, rake_deg: float) -> Line:
    """Return the lineation with a given rake on a plane.

    Parameters
    ----------
    plane : Plane
    rake_deg : float
        Rake as returned by `compute_rake`, taken modulo 180.

    Returns
    -------
    Line
    """
    sin_r, cos_r = sin_cos_deg(_require_finite_number(rake_deg, "rake"))
    return Line.from_vector(cos_r * plane.strike_vector() + sin_r * plane.dip_vector())


def rake_vectors(
    dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike, rake_deg: npt.ArrayLike
) -> FloatArray:
    """Return the unit vectors of lineations with given rakes on planes.

    Parameters
    ----------
    dip_direction_deg, dip_deg : (n,) array_like
        As in `Plane`.
    rake_deg : (n,) array_like
        Rakes as returned by `compute_rake`.

    Returns
    -------
    (n, 3) ndarray
    """
    dip = np.asarray(dip_deg, np.float64)
    strike = wrap360(np.asarray(dip_direction_deg, np.float64) - 90.0)
    strike = np.where(90.0 - dip < ANGLE_TOLERANCE_DEG, _wrap180(strike), strike)
    sin_r, cos_r = sin_cos_deg(rake_deg)
    along_strike = cos_r[:, None] * lines_to_vectors(strike, np.zeros_like(strike))
    return np.asarray(along_strike + sin_r[:, None] * lines_to_vectors(strike + 90.0, dip))


def slip_from_rake(plane: Plane, slip_rake_deg: float) -> Line:
    """Return the slip of the hanging wall as a directed line; reverse slip points up.

    Parameters
    ----------
    plane : Plane
    slip_rake_deg : float

    Returns
    -------
    Line
    """
    sin_r, cos_r = sin_cos_deg(_require_finite_number(slip_rake_deg, "rake"))
    vector = cos_r * plane.strike_vector() - sin_r * plane.dip_vector()
    return Line.from_vector(vector, is_directed=True)


def _plane_components(line: Line, plane: Plane) -> tuple[float, float]:
    """Return the components of the line along the strike and down the dip.

    Raises GeometryError if the line is parallel to the normal.
    """
    v = line.vector()
    strike_component, dip_component = (
        float(v @ plane.strike_vector()),
        float(v @ plane.dip_vector()),
    )
    if math.hypot(strike_component, dip_component) < math.radians(ANGLE_TOLERANCE_DEG):
        raise GeometryError(Finding("line.across-plane"))
    return strike_component, dip_component
