"""Bowing (doming) of a model, detected in the residuals of points or cameras.

A photo block with a wrong lens model is bent: at a distance r from the middle, the model is offset
by c r^2 (James & Robson 2014, Earth Surface Processes and Landforms 39, 1413-1420). Dips then
change by 2 c r away from the middle, which looks like an open fold.

The residuals along the normal of the model are regressed on 1, u, v and u^2 + v^2, where u and v
are coordinates in its mean plane. A registration absorbs the first three terms (shift and tilt).
Control points and check points can therefore be combined: both differ from the truth by the same
shift and tilt. Student's t test decides whether c differs from zero.

Cameras bend with the model: a camera at a distance r from the middle is rotated by 2 c r, outward
or inward. The verticals of photos (roll and pitch of a gimbal, accelerometer of a phone) reveal
this even without control points, as rotations that increase with the distance from the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.serial_errors import fit_serial_correlation, whiten

MIN_BOWING_POINTS = 6
"""Minimum number of points: four unknowns and two degrees of freedom."""

SIGNIFICANCE = 0.05
MIN_SPREAD = 0.05
# Quantile of the distances that defines the edge: it ignores outliers far behind the outcrop.
EDGE_QUANTILE = 0.999
# Minimum relief, relative to the extent, for points to determine the depth scale.
MIN_RELIEF = 0.02


@dataclass(frozen=True)
class Bowing:
    """Bowing of a model.

    Attributes
    ----------
    n : int
        Number of points or photos.
    curvature_per_m, error95_per_m : float
        Curvature c along the upward normal and its 95 % error, 1/m; negative for a dome.
    reach_m : float
        Distance from the middle to the edge of the model, m.
    significant : bool
        True if c differs from zero at the 5 % significance level.
    normal : (3,) tuple
        Unit normal of the mean plane.
    """

    n: int
    curvature_per_m: float
    error95_per_m: float
    reach_m: float
    significant: bool
    normal: tuple[float, float, float]

    @property
    def side_deg(self) -> float:
        """Difference in dip between the edge and the middle, degrees."""
        return float(np.degrees(2.0 * abs(self.curvature_per_m) * self.reach_m))

    @property
    def side_error95_deg(self) -> float:
        return float(np.degrees(2.0 * self.error95_per_m * self.reach_m))

    @property
    def across_deg(self) -> float:
        """Difference in dip between opposite edges, degrees."""
        return 2.0 * self.side_deg

    @property
    def rise_m(self) -> float:
        """Distance between the edge and the tangent plane at the middle, m."""
        return abs(self.curvature_per_m) * self.reach_m**2

    @property
    def edge_direction(self) -> FloatArray:
        """Unit vector (3,) pointing from the tangent plane at the middle toward the edges."""
        return np.array(self.normal) * (1.0 if self.curvature_per_m > 0.0 else -1.0)


@dataclass(frozen=True)
class LensDeformation:
    """Possible deformation of a model due to lens errors, at 95 %.

    Attributes
    ----------
    curvature95_per_m : float
        Curvature c of the bowing, 1/m.
    reach_m : float
        Distance from the middle to the edge of the model, m.
    stretch95 : float
        Relative scale error of depths (along the normal of the model) against lengths along the
        model.
    """

    curvature95_per_m: float
    reach_m: float
    stretch95: float

    @property
    def side_deg(self) -> float:
        """Maximum difference in dip between the edge and the middle, degrees."""
        return float(np.degrees(2.0 * self.curvature95_per_m * self.reach_m))

    @property
    def across_deg(self) -> float:
        """Maximum difference in dip between opposite edges, degrees."""
        return 2.0 * self.side_deg

    @property
    def stretch_deg(self) -> float:
        """Maximum rotation due to the stretch (of planes at 45 degrees to the model), degrees."""
        return float(np.degrees(self.stretch95 / 2.0))


def bowing_deg(lens_across95_deg: float | None, bowing: Bowing | None) -> float | None:
    """Return the difference in dip between opposite edges due to bowing, degrees.

    Bowing that is significant in the residuals is used directly; otherwise the possible lens error
    (95 %) is used, limited to what the residuals allow.

    Parameters
    ----------
    lens_across95_deg : float or None
    bowing : Bowing or None

    Returns
    -------
    float or None
        None if the lens error is unknown and no bowing is significant.
    """
    if bowing is not None and bowing.significant:
        return bowing.across_deg
    if lens_across95_deg is None:
        return None
    if bowing is None:
        return lens_across95_deg
    return min(lens_across95_deg, 2.0 * (bowing.side_deg + bowing.side_error95_deg))


@dataclass(frozen=True, eq=False)
class ShapeChange:
    """Deformation of a whole model.

    Attributes
    ----------
    rotation : (3,) ndarray
        Rotation vector, radians.
    growth : float
        Relative change in lengths along the model.
    shift : (3,) ndarray
        Translation of the middle of the model, m.
    curvature_per_m : float
        Curvature c, 1/m.
    stretch : float
        Relative scale of depths against lengths along the model; 0 if the model has no relief.
    """

    rotation: FloatArray
    growth: float
    shift: FloatArray
    curvature_per_m: float
    stretch: float


def fit_shape_change(positions: FloatArray, displacements: FloatArray) -> ShapeChange:
    """Fit the deformation of a model to small displacements of its points.

    Parameters
    ----------
    positions, displacements : (n, 3) ndarray
        Points and their displacements in the World frame, m.

    Returns
    -------
    ShapeChange

    Raises
    ------
    numpy.linalg.LinAlgError
        If values are not finite.
    """
    centre, axes, radius = model_shape(positions)
    u, v, w = ((positions - centre) @ axes.T).T / radius
    projections = displacements @ axes.T
    columns = [np.ones(len(u)), u, v]
    has_relief = float(w.std()) > MIN_RELIEF
    if has_relief:
        columns.append(w)
    horizontal_coefficients = np.linalg.lstsq(
        np.stack(columns, axis=1), projections[:, :2], rcond=None
    )[0]
    bend_columns = np.stack([*columns, u**2 + v**2], axis=1)
    vertical_coefficients = np.linalg.lstsq(bend_columns, projections[:, 2], rcond=None)[0]
    growth = float(horizontal_coefficients[1, 0] + horizontal_coefficients[2, 1]) / 2.0 / radius
    rotation = (
        np.array(
            [
                vertical_coefficients[2],
                -vertical_coefficients[1],
                (horizontal_coefficients[1, 1] - horizontal_coefficients[2, 0]) / 2.0,
            ]
        )
        / radius
    )
    stretch = float(vertical_coefficients[3]) / radius - growth if has_relief else 0.0
    shift = np.array([*horizontal_coefficients[0], vertical_coefficients[0]]) @ axes
    return ShapeChange(
        rotation @ axes, growth, shift, float(vertical_coefficients[-1]) / radius**2, stretch
    )


def fit_bowing(
    positions: FloatArray,
    residuals: FloatArray,
    sigma: FloatArray | None = None,
    extent: FloatArray | None = None,
    normal: FloatArray | None = None,
) -> Bowing | None:
    """Fit the bowing of a model to the residuals of points.

    Parameters
    ----------
    positions, residuals : (n, 3) ndarray
        Positions and residuals (fitted minus measured) in the World frame in order of measurement,
        m. Serial correlation, such as the drift of a receiver, is not mistaken for bowing.
    sigma : (n, 3) ndarray, optional
        Standard deviations of the coordinates in metres, used as weights.
    extent : (m, 3) ndarray, optional
        Points that cover the whole model and define its mean plane, middle and edge.
    normal : (3,) ndarray, optional
        Normal of the mean plane of the model, if no points of the model are available.

    Returns
    -------
    Bowing or None
        None if there are too few points, or if they lie on a line or at equal distances from the
        middle.
    """
    n = len(positions)
    if n < MIN_BOWING_POINTS:
        return None
    centre, axes, radius = _reference_shape(positions, extent)
    if normal is not None:
        cross_axis = np.cross(axes[0], normal)
        cross_axis /= np.linalg.norm(cross_axis) or 1.0
        axes = np.array([np.cross(cross_axis, normal), cross_axis, normal])
    plane_points, normal = (positions - centre) @ axes[:2].T, axes[2]
    size = float(np.sqrt((plane_points**2).sum(axis=1).mean()))
    if not size > 0.0 or np.linalg.svd(plane_points - plane_points.mean(axis=0), compute_uv=False)[
        -1
    ] < (MIN_SPREAD * size * np.sqrt(n)):
        return None
    u, v = (plane_points / size).T
    columns = np.stack([np.ones(n), u, v, u**2 + v**2], axis=1)
    weight = np.ones(n)
    if sigma is not None and np.isfinite(sigma).all() and (sigma > 0).all():
        weight = 1.0 / np.sqrt((sigma**2) @ normal**2)
        weight = weight / weight.mean()
    serial_correlation = _neighbour_correlation(columns, residuals @ axes.T)
    rows = whiten(columns * weight[:, None], serial_correlation)
    # Part of the last column that the others do not explain; 0 for points at equal distances.
    bend_column = rows[:, 3] - rows[:, :3] @ np.linalg.lstsq(rows[:, :3], rows[:, 3], rcond=None)[0]
    if float(bend_column @ bend_column) < MIN_SPREAD**2 * float(rows[:, 3] @ rows[:, 3]):
        return None
    heights = whiten((residuals @ normal) * weight, serial_correlation)
    # The residuals (fitted minus measured) represent the bend of the model.
    curvature, error = _fit_last_coefficient(rows, heights, bend_column)
    return _build_bowing(n, curvature / size**2, error / size**2, radius, normal)


def _neighbour_correlation(columns: FloatArray, residuals: FloatArray) -> float:
    """Return the correlation of neighbouring residuals (n, 3) of a fit of columns (n, k)."""
    remaining_residuals = residuals - columns @ np.linalg.lstsq(columns, residuals, rcond=None)[0]
    sizes = np.sqrt((remaining_residuals**2).mean(axis=0))
    if not (sizes > 0.0).all():
        return 0.0
    k = columns.shape[1]
    columns_by_axis = np.zeros((len(columns), 3, 3 * k))
    for axis in range(3):
        columns_by_axis[:, axis, axis * k : (axis + 1) * k] = columns
    return fit_serial_correlation(columns_by_axis, remaining_residuals / sizes)


def fit_bowing_to_rotations(
    positions: FloatArray,
    rotations: FloatArray,
    cameras: FloatArray,
    extent: FloatArray | None = None,
) -> Bowing | None:
    """Fit the bowing of a model to the measured verticals of its photos.

    Parameters
    ----------
    positions : (n, 3) ndarray
        Positions of the cameras in the World frame, m.
    rotations : (n, 3) ndarray
        Rotation of each photo in the model relative to its measured orientation, radians, in the
        World frame. Only the components about east and north, which a vertical determines, are
        used.
    cameras : (n, 3, 3) ndarray
        Rotations from the camera to the World frame. They are needed because a misaligned mount
        rotates with the cameras and would look like bowing if the cameras surround a rock.
    extent : (m, 3) ndarray, optional
        Points that cover the whole model. See `fit_bowing`.

    Returns
    -------
    Bowing or None
        None if there are too few photos, or if bowing cannot be distinguished from a rotation of
        the whole model or of the mount.
    """
    n = len(positions)
    if n < MIN_BOWING_POINTS:
        return None
    centre, axes, radius = _reference_shape(positions, extent)
    u, v = ((positions - centre) @ axes[:2].T).T
    # The surface w = c (u^2 + v^2) has the normal w - 2 c (u, v), a rotation by w x (u, v).
    bend_rotation = np.outer(u, np.cross(axes[2], axes[0])) + np.outer(
        v, np.cross(axes[2], axes[1])
    )
    bend_rotations = -2.0 * bend_rotation[:, :2]
    size = float(np.sqrt((bend_rotations**2).mean()))
    if not size > 0.0:
        return None
    equations = np.zeros((n, 2, 6))
    # A registration absorbs rotations that are common to all photos.
    equations[:, 0, 0] = equations[:, 1, 1] = 1.0
    equations[:, :, 2:5] = cameras[:, :2, :]
    equations[:, :, 5] = bend_rotations / size
    rows = equations.reshape(-1, 6)
    bend_column = rows[:, 5] - rows[:, :5] @ np.linalg.lstsq(rows[:, :5], rows[:, 5], rcond=1e-6)[0]
    if float(bend_column @ bend_column) < MIN_SPREAD**2 * float(rows[:, 5] @ rows[:, 5]):
        return None
    curvature, error = _fit_last_coefficient(rows, rotations[:, :2].ravel(), bend_column)
    return _build_bowing(n, curvature / size, error / size, radius, axes[2])


def model_shape(points: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the centre, the axes and the radius of a model.

    Parameters
    ----------
    points : (m, 3) ndarray
        Points that cover the whole model, in the World frame, m.

    Returns
    -------
    centre : (3,) ndarray
    axes : (3, 3) ndarray
        Right-handed axes as rows; the last one is the upward normal.
    radius : float
        Distance from the centre to the edge along the mean plane (99.9 % quantile), m.
    """
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    if axes[2, 2] < 0.0:
        axes[2] = -axes[2]
    axes[1] = np.cross(axes[2], axes[0])
    distances = np.linalg.norm((points - centre) @ axes[:2].T, axis=1)
    return centre, axes, float(np.quantile(distances, EDGE_QUANTILE, method="higher"))


def _build_bowing(
    n: int, curvature: float, error: float, max_distance: float, normal: FloatArray
) -> Bowing:
    x, y, z = (float(v) for v in normal)
    return Bowing(n, curvature, error, max_distance, abs(curvature) > error, (x, y, z))


def _reference_shape(
    positions: FloatArray, extent: FloatArray | None
) -> tuple[FloatArray, FloatArray, float]:
    """Return the `model_shape` of the model, or of the positions if its points are unknown."""
    return model_shape(positions if extent is None or len(extent) < MIN_BOWING_POINTS else extent)


def _fit_last_coefficient(
    rows: FloatArray, values: FloatArray, last_column: FloatArray
) -> tuple[float, float]:
    """Return the last coefficient of a regression and its 95 % error.

    `last_column` is the part of the last column that the other columns do not explain.
    """
    from scipy.special import stdtrit

    # Photos that all face the same direction cannot separate the mount from the registration.
    solution, _, rank, _ = np.linalg.lstsq(rows, values, rcond=1e-6)
    residuals = values - rows @ solution
    dof = len(rows) - int(rank)
    variance = float(residuals @ residuals) / dof / float(last_column @ last_column)
    error = float(stdtrit(dof, 1.0 - SIGNIFICANCE / 2.0)) * float(np.sqrt(variance))
    return float(solution[-1]), error
