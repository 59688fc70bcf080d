"""Stereonets as arrays: projections, great and small circles, and confidence ellipses.

The lower hemisphere is projected onto the unit circle with x to the East and y to the North: a
vertical line plots at the centre, a horizontal line on the primitive circle (radius 1). "area" is
Lambert's equal-area (Schmidt) projection, "angle" the stereographic, equal-angle (Wulff)
projection. Curves are unit vectors on the lower hemisphere. Longitude and latitude are those of
mplstereonet's axes: both are zero straight down, the longitude is 90 degrees at the East and the
latitude at the North. This module does not draw anything and never modifies its inputs.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane, sin_cos_deg

PROJECTIONS = ("area", "angle")


def _check_projection(projection: str) -> None:
    if projection not in PROJECTIONS:
        raise ValueError(f"unknown projection {projection!r}; use one of {PROJECTIONS}")


def project(vectors: npt.ArrayLike, projection: str = "area", *, flip: bool = True) -> FloatArray:
    """Project vectors onto the net.

    Parameters
    ----------
    vectors : (n, 3) array_like
        Vectors of any length; zero vectors result in NaN.
    projection : {"area", "angle"}, optional
    flip : bool, optional
        If True, vectors that point up are treated as axes and plotted at their lower end. If False,
        they are projected beyond the primitive circle, as required for curves that cross it (a
        vector that points straight up becomes NaN for "angle" and lies on the circle of radius
        sqrt(2) for "area").

    Returns
    -------
    (n, 2) ndarray

    Raises
    ------
    ValueError
        If the projection is unknown.
    """
    _check_projection(projection)
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    with np.errstate(invalid="ignore", divide="ignore"):
        v = v / np.linalg.norm(v, axis=-1, keepdims=True)
        if flip:
            v = np.where(v[..., 2:] > 0, -v, v)
        x, y, down = v[..., 0], v[..., 1], -v[..., 2]
        # The radius is sqrt(2) sin(t/2) for "area" and tan(t/2) for "angle", with t from straight
        # down.
        scale = 1.0 / (np.sqrt(1.0 + down) if projection == "area" else 1.0 + down)
        return np.stack([x * scale, y * scale], axis=-1) + 0.0


def unproject(points: npt.ArrayLike, projection: str = "area") -> FloatArray:
    """Return the downward unit vectors of points on the net.

    Parameters
    ----------
    points : (n, 2) array_like
    projection : {"area", "angle"}, optional

    Returns
    -------
    (n, 3) ndarray
        NaN for points outside the primitive circle.

    Raises
    ------
    ValueError
        If the projection is unknown.
    """
    _check_projection(projection)
    p = np.atleast_2d(np.asarray(points, dtype=np.float64))
    r2 = np.sum(p**2, axis=-1)
    is_inside = r2 <= 1.0 + 1e-12
    r2 = np.where(is_inside, np.minimum(r2, 1.0), np.nan)
    if projection == "area":
        scale, down = np.sqrt(2.0 - r2), 1.0 - r2
    else:
        scale, down = 2.0 / (1.0 + r2), (1.0 - r2) / (1.0 + r2)
    return np.stack([p[..., 0] * scale, p[..., 1] * scale, 0.0 - down], axis=-1)


def vectors_to_longitude_latitude(vectors: npt.ArrayLike, *, flip: bool = True) -> FloatArray:
    """Return the positions of vectors on the axes of mplstereonet.

    Parameters
    ----------
    vectors : (..., 3) array_like
        Vectors of any length.
    flip : bool, optional
        As in `project`.

    Returns
    -------
    (..., 2) ndarray
        Longitude and latitude, radians.
    """
    v = np.asarray(vectors, dtype=np.float64)
    if flip:
        v = np.where(v[..., 2:] > 0, -v, v)
    east, north, down = v[..., 0], v[..., 1], 0.0 - v[..., 2]
    return np.stack([np.arctan2(east, down), np.arctan2(north, np.hypot(east, down))], axis=-1)


def longitude_latitude_to_vectors(positions: npt.ArrayLike) -> FloatArray:
    """Return the unit vectors (..., 3) at positions on the axes of mplstereonet.

    Parameters
    ----------
    positions : (..., 2) array_like
        Longitude and latitude, radians.
    """
    longitude, latitude = np.moveaxis(np.asarray(positions, dtype=np.float64), -1, 0)
    horizontal_radii = np.cos(latitude)
    return np.stack(
        [
            horizontal_radii * np.sin(longitude),
            np.sin(latitude),
            0.0 - horizontal_radii * np.cos(longitude),
        ],
        axis=-1,
    )


def hemisphere_grid(size: int) -> tuple[FloatArray, FloatArray]:
    """Return a square grid on the lower hemisphere, with its edges on the primitive circle.

    Returns
    -------
    steps : (size,) ndarray
        Longitudes of the columns and latitudes of the rows, radians.
    vectors : (size, size, 3) ndarray
    """
    steps = np.linspace(-np.pi / 2, np.pi / 2, size)
    return steps, longitude_latitude_to_vectors(np.stack(np.meshgrid(steps, steps), axis=-1))


def line_at(x: float, y: float, projection: str = "area") -> Line | None:
    """Return the line at a point of the net.

    Parameters
    ----------
    x, y : float
    projection : {"area", "angle"}, optional

    Returns
    -------
    Line or None
        None if the point is outside the net.
    """
    vector = unproject([[x, y]], projection)[0]
    return None if not np.isfinite(vector).all() else Line.from_vector(vector)


def great_circles(
    dip_direction_deg: npt.ArrayLike, dip_deg: npt.ArrayLike, n: int = 91
) -> FloatArray:
    """Return the great circles of planes as arcs on the lower hemisphere.

    Each arc runs from one end of the strike through the dip line to the other end. The arc of a
    vertical plane is a diameter. The arc of a horizontal plane is half of the primitive circle
    (`great_circle` returns the full circle).

    Parameters
    ----------
    dip_direction_deg, dip_deg : (m,) array_like
    n : int, optional
        Number of points per arc.

    Returns
    -------
    (m, n, 3) ndarray
        Unit vectors; the ends are horizontal except for rounding.
    """
    azimuth = np.atleast_1d(np.asarray(dip_direction_deg, dtype=np.float64))
    dip = np.atleast_1d(np.asarray(dip_deg, dtype=np.float64))
    sin_a, cos_a = sin_cos_deg(azimuth)
    sin_d, cos_d = sin_cos_deg(dip)
    strike = np.stack([-cos_a, sin_a, np.zeros_like(sin_a)], axis=-1)
    down = np.stack([sin_a * cos_d, cos_a * cos_d, 0.0 - sin_d], axis=-1)
    sin_r, cos_r = sin_cos_deg(np.linspace(0.0, 180.0, n))
    return np.asarray(
        strike[:, None, :] * cos_r[None, :, None] + down[:, None, :] * sin_r[None, :, None]
    )


def great_circle(plane: Plane, n: int = 91) -> FloatArray:
    """Return the great circle of one plane; the full primitive circle if it is horizontal.

    Parameters
    ----------
    plane : Plane
    n : int, optional
        Number of points.

    Returns
    -------
    (n, 3) ndarray
    """
    if plane.undefined:
        sin_a, cos_a = sin_cos_deg(np.linspace(0.0, 360.0, n))
        return np.stack([sin_a, cos_a, np.zeros(n)], axis=-1)
    return np.asarray(great_circles(plane.dip_direction_deg, plane.dip_deg, n)[0])


def confidence_ellipse(
    axis: npt.ArrayLike,
    major: npt.ArrayLike,
    max_angle_deg: float,
    min_angle_deg: float,
    n: int = 181,
) -> list[FloatArray]:
    """Return the curve of an elliptical confidence cone about an axis.

    Parameters
    ----------
    axis : (3,) array_like
        Pole of a plane, or a fold axis.
    major : (3,) array_like
        Direction of the larger half-angle; it need not be exactly perpendicular to the axis.
    max_angle_deg, min_angle_deg : float
        Half-angles toward `major` and perpendicular to it, degrees.
    n : int
        Number of points of the curve.

    Returns
    -------
    list of (k, 3) ndarray
        Polylines of unit vectors, split at the primitive circle.

    Raises
    ------
    GeometryError
        If `major` is parallel to the axis or not finite.
    """
    axis_vector = np.asarray(axis, dtype=np.float64)
    axis_vector = axis_vector / np.linalg.norm(axis_vector)
    major_axis = np.asarray(major, dtype=np.float64)
    major_axis = major_axis - axis_vector * (major_axis @ axis_vector)
    length = float(np.linalg.norm(major_axis))
    if not math.isfinite(length) or length < 1e-9:
        raise GeometryError(Finding("net.ellipse-direction"))
    major_axis = major_axis / length
    return cone_curve(
        axis_vector, major_axis, np.cross(axis_vector, major_axis), max_angle_deg, min_angle_deg, n
    )


def pole_ellipse(
    plane: Plane,
    max_angle_deg: float,
    min_angle_deg: float,
    rake_deg: float,
    n: int = 181,
) -> list[FloatArray]:
    """Return the confidence ellipse of the pole of a plane.

    Parameters
    ----------
    plane : Plane
    max_angle_deg, min_angle_deg : float
        Semi-axes of the confidence region, degrees.
    rake_deg : float
        Direction of the largest tilt, 0 to 180 degrees from the strike.
    n : int
        Number of points of the curve.

    Returns
    -------
    list of (k, 3) ndarray
        Polylines of unit vectors, split at the primitive circle.
    """
    sin_r, cos_r = sin_cos_deg(rake_deg)
    major = cos_r * plane.strike_vector() + sin_r * plane.dip_vector()
    return confidence_ellipse(-plane.normal(), major, max_angle_deg, min_angle_deg, n)


def cone_curve(
    axis: FloatArray,
    first: FloatArray,
    second: FloatArray,
    first_angle_deg: float,
    second_angle_deg: float,
    n: int,
) -> list[FloatArray]:
    """Return the curve of an elliptical cone about an orthonormal frame.

    The curve is closed and split into polylines at the primitive circle.

    At the position angle t about the axis, the half-angle of the cone is the radius of an ellipse
    with the given half-angles as semi-axes, so no half-angle exceeds the larger one.

    Parameters
    ----------
    axis, first, second : (3,) ndarray
        Orthonormal frame.
    first_angle_deg, second_angle_deg : float
        Half-angles toward `first` and `second`, degrees.
    n : int
        Number of points of the curve.

    Returns
    -------
    list of (k, 3) ndarray
    """
    # Use equal steps of the eccentric angle: with equal steps of t, the ends of a long ellipse have
    # visible corners.
    sin_u, cos_u = sin_cos_deg(np.linspace(0.0, 360.0, n))
    major_components = max(first_angle_deg, 1e-12) * cos_u
    minor_components = max(second_angle_deg, 1e-12) * sin_u
    radius = np.hypot(major_components, minor_components)
    cos_t, sin_t = major_components / radius, minor_components / radius
    sin_r, cos_r = sin_cos_deg(radius)
    curve = (
        cos_r[:, None] * axis + (sin_r * cos_t)[:, None] * first + (sin_r * sin_t)[:, None] * second
    )
    return split_at_primitive(curve)


def split_at_primitive(curve: npt.ArrayLike) -> list[FloatArray]:
    """Move a curve to the lower hemisphere, split where it crosses the primitive circle.

    Directions that point up are replaced by their opposites. The parts of a curve that
    crosses the primitive circle end exactly on it.

    Parameters
    ----------
    curve : (n, 3) array_like

    Returns
    -------
    list of (k, 3) ndarray
    """
    c = np.asarray(curve, dtype=np.float64)
    is_upward = c[:, 2] > 1e-12
    parts: list[FloatArray] = []
    part_points: list[FloatArray] = []
    for i in range(len(c)):
        if i and is_upward[i] != is_upward[i - 1]:
            weight = c[i - 1, 2] / (c[i - 1, 2] - c[i, 2])
            crossing = c[i - 1] + weight * (c[i] - c[i - 1])
            crossing[2] = 0.0
            crossing = crossing / np.linalg.norm(crossing)
            part_points.append(-crossing if is_upward[i - 1] else crossing)
            parts.append(np.array(part_points))
            part_points = [-crossing if is_upward[i] else crossing]
        part_points.append(-c[i] if is_upward[i] else c[i])
    parts.append(np.array(part_points))
    is_closed = len(parts) > 1 and np.allclose(c[0], c[-1], atol=1e-9)
    if is_closed:
        # The curve starts within a part, so its last part continues into the first one.
        parts[0] = np.vstack([parts.pop()[:-1], parts[0]])
    return [part for part in parts if len(part) > 1]
