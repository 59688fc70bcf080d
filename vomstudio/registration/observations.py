"""Observations of the position of a model, with their residuals and derivatives.

Seven small parameters change a similarity: a rotation about east, north and up (rad) and a relative
change of scale, both about a centre in the World frame, and a translation. Each kind of observation
returns rows (`Rows`) of this linear problem. The sigma of a row is its stated one-sigma error in
the unit of the row (metres or radians). If the error is not stated, sigma is NaN, and the error is
estimated from the residuals. Rows of the same group enter the fit with equal weights; rows of the
same part have equal errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.registration.scatter import (
    HEIGHT_ERROR_RATIO,
    MIN_POINTS_FOR_AXES,
    MIN_POINTS_FOR_HEIGHTS,
)
from vomstudio.registration.similarity import Similarity, jacobians

COMPASS = "compass"
"""Name of the north error common to all planes, lines and azimuths measured by compass."""
YAW = "yaw"
"""Name of the north error common to all photos."""
# Share of a variance below which covariances between World axes are rounding errors.
_ROUNDING_SHARE = 1e-9


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of the linear problem.

    Attributes
    ----------
    residuals : (m,) array
        Predicted minus observed values.
    design : (m, 7) array
        Derivatives of `residuals` with respect to the seven parameters.
    sigma : (m,) array
        Stated errors, NaN if not stated.
    groups, parts : (m,) tuple of str
    shared_design : (m, k) array
        Derivatives with respect to k errors that are common to all rows of a kind.
    shared_sigma : (k,) array
        Prior one-sigma values of the common errors.
    shared_names : (k,) tuple of str
        Names of the common errors. Errors with the same name are common to several kinds; an
        error named "" affects a single kind.
    error_factors : (m,) array or None
        Largest plausible ratio of the error of each row to that of its part, assumed if too few
        rows determine it. If None, the ratio is 1.
    axes : (m, 3) array or None
        World directions of the rows of points, zero for other rows. If None, all are zero.
    """

    residuals: FloatArray
    design: FloatArray
    sigma: FloatArray
    groups: tuple[str, ...]
    parts: tuple[str, ...]
    shared_design: FloatArray
    shared_sigma: FloatArray
    shared_names: tuple[str, ...] = ()
    error_factors: FloatArray | None = None
    axes: FloatArray | None = None


class ObservationKind(Protocol):
    """One kind of observation."""

    @property
    def labels(self) -> Sequence[str]:
        """Labels (n,) of the observations; each observation has `len(rows) / n` adjacent rows."""

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows: ...


@dataclass(frozen=True, eq=False)
class Points:
    """Points on the model with known World coordinates, in metres.

    Horizontal coordinates and heights have separate errors if there are at least five points;
    each axis has its own error if there are at least twelve.

    Attributes
    ----------
    model, world : (n, 3) array
        Points on the model, and the same points in the World frame.
    sigma : (n, 3) array
        One-sigma errors of `world`, NaN if not stated. These are then estimated from the
        residuals, which also contain the errors of `model`.
    name : str
        Name of the group of points, which are equally accurate unless their errors are stated.
    click_error_m : (n,) array or None
        Error of each coordinate of the points on the model, World metres. If None, 0.
    covariance : (n, 3, 3) array or None
        Covariances of `model`, in its frame and unit. If None, 0.
    """

    labels: Sequence[str]
    model: FloatArray
    world: FloatArray
    sigma: FloatArray
    name: str = "points"
    click_error_m: FloatArray | None = None
    covariance: FloatArray | None = None

    def errors(self, fit: Similarity) -> tuple[FloatArray, FloatArray]:
        """Return the errors of the residuals, including the errors of the points on the model.

        Returns
        -------
        sigma : (n, 3) array
            Errors along the axes of each point, NaN if not stated.
        axes : (n, 3, 3) array
            World directions (as rows) along which the errors of a point are independent.
        """
        sigma = self.sigma
        if self.click_error_m is not None:
            sigma = np.hypot(sigma, self.click_error_m[:, None])
        axes = np.tile(np.eye(3), (len(sigma), 1, 1))
        if self.covariance is None:
            return sigma, axes
        rotation = fit.scale * fit.rotation
        covariance = rotation @ self.covariance @ rotation.T + sigma[:, :, None] ** 2 * np.eye(3)
        diagonal = np.einsum("nii->ni", covariance)
        off_diagonal = np.abs(covariance - diagonal[:, :, None] * np.eye(3)).max(axis=(1, 2))
        sigma = np.sqrt(diagonal)
        is_inclined = np.isfinite(off_diagonal) & (
            off_diagonal > _ROUNDING_SHARE * diagonal.max(axis=1)
        )
        if is_inclined.any():
            values, vectors = np.linalg.eigh(covariance[is_inclined])
            sigma[is_inclined] = np.sqrt(np.maximum(values, 0.0))
            axes[is_inclined] = np.swapaxes(vectors, 1, 2)
        return sigma, axes

    def total_sigma(self, fit: Similarity) -> FloatArray:
        """Return the errors (n, 3) of the residuals along east, north and up; NaN if not stated."""
        sigma, axes = self.errors(fit)
        return np.asarray(np.sqrt(np.einsum("nji,nj->ni", axes**2, sigma**2)))

    def assume_exact_model(self) -> Points:
        """Return the points, assuming that their positions on the model are exact."""
        return replace(self, click_error_m=None, covariance=None)

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_points = fit(self.model)
        n = len(placed_points)
        sigma, axes = self.errors(fit)
        design = axes @ jacobians(placed_points - centre)
        residuals = np.einsum("nij,nj->ni", axes, placed_points - self.world)
        parts = ("", "", "")
        if n >= MIN_POINTS_FOR_AXES:
            parts = (" east", " north", " up")
        elif n >= MIN_POINTS_FOR_HEIGHTS:
            parts = (" level", " level", " up")
        row_names = tuple(self.name + part for part in parts)
        rows = _rows(residuals.ravel(), design.reshape(-1, 7), sigma, (self.name,) * 3, row_names)
        rows = replace(rows, axes=axes.reshape(-1, 3))
        if n >= MIN_POINTS_FOR_HEIGHTS:
            return rows
        return replace(rows, error_factors=np.tile([1.0, 1.0, HEIGHT_ERROR_RATIO], n))


@dataclass(frozen=True, eq=False)
class Lengths:
    """Measured distances between points on the model, metres.

    Attributes
    ----------
    first, second : (n, 3) array
        End points on the model.
    length : (n,) array
        Distances.
    sigma : (n,) array
        One-sigma errors, NaN if not stated.
    click_error_m : (n,) array or None
        Errors contributed by the clicks on both ends, World metres. If None, 0.
    click_error : (n,) array or None
        The same errors in the unit of the model. If None, 0.
    """

    labels: Sequence[str]
    first: FloatArray
    second: FloatArray
    length: FloatArray
    sigma: FloatArray
    click_error_m: FloatArray | None = None
    click_error: FloatArray | None = None

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_lengths = fit.scale * np.linalg.norm(self.second - self.first, axis=1)
        design = np.zeros((len(placed_lengths), 7))
        design[:, 3] = placed_lengths
        sigma = self.sigma
        if self.click_error_m is not None:
            sigma = np.hypot(sigma, self.click_error_m)
        if self.click_error is not None:
            sigma = np.hypot(sigma, fit.scale * self.click_error)
        return _rows(placed_lengths - self.length, design, sigma, ("lengths",))

    def assume_exact_model(self) -> Lengths:
        """Return the lengths, assuming that their end points on the model are exact."""
        return replace(self, click_error_m=None, click_error=None)


@dataclass(frozen=True, eq=False)
class FixedScale(Lengths):
    """Known scale, expressed as a length across the model.

    It is never excluded as an outlier.

    Attributes
    ----------
    scale_error : float
        Relative one-sigma error of the scale; 0 if unknown.
    """

    scale_error: float = 0.0

    @property
    def scale_derivative(self) -> FloatArray:
        """Derivative (1,) of the residual with respect to the relative error of the scale."""
        return -self.length


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions on the model that were also measured in the World frame, such as by compass.

    Attributes
    ----------
    model, world : (n, 3) array
        Unit vectors: normals of planes, or lines.
    axial : bool
        Whether a direction and its opposite are equivalent.
    sigma : (n, 2) array
        One-sigma errors along and across the dip (for lines, along and across the plunge), rad;
        NaN if not stated.
    north_sigma : float
        One-sigma error of compass north, common to all directions, rad.
    """

    labels: Sequence[str]
    model: FloatArray
    world: FloatArray
    sigma: FloatArray
    axial: bool = True
    north_sigma: float = 0.0

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_directions = self.model @ fit.rotation.T
        world_directions = self.world
        if self.axial:
            signs = np.where((placed_directions * world_directions).sum(axis=1) < 0, -1.0, 1.0)
            world_directions = world_directions * signs[:, None]
        down, horizontal_tangents = _tangents(world_directions)
        design = np.zeros((len(placed_directions), 2, 7))
        residuals = np.zeros((len(placed_directions), 2))
        shared_columns = np.zeros((len(placed_directions), 2, 1))
        for row, tangent in enumerate((down, horizontal_tangents)):
            residuals[:, row] = _angle(placed_directions, world_directions, tangent)
            # A rotation w moves the direction u by w x u; its component along e is w . (u x e).
            rotation_columns = _cross_product(placed_directions, tangent)
            design[:, row, :3] = rotation_columns
            shared_columns[:, row, 0] = rotation_columns[:, 2]
        rows = _rows(residuals.ravel(), design.reshape(-1, 7), self.sigma, ("directions",))
        return _add_shared_error(rows, shared_columns.reshape(-1, 1), self.north_sigma, COMPASS)


@dataclass(frozen=True, eq=False)
class Verticals:
    """Directions of the model that point straight down, as measured by a phone accelerometer.

    Attributes
    ----------
    model : (n, 3) array
        Unit vectors.
    sigma : (n, 2) array
        One-sigma errors, rad; NaN if not stated.
    cameras : (n, 3, 3) array
        Rotations from the cameras to the model.
    mount_sigma : float
        See `Attitudes`.
    """

    labels: Sequence[str]
    model: FloatArray
    sigma: FloatArray
    cameras: FloatArray
    mount_sigma: float = 0.0

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_directions = self.model @ fit.rotation.T
        rows = _downward_rows(placed_directions, self.sigma, "verticals")
        axes = fit.rotation @ self.cameras
        cross_derivatives = np.cross(
            axes, placed_directions[:, :, None], axisa=1, axisb=1, axisc=1
        )[:, :2, :]
        return _add_shared_error(rows, cross_derivatives.reshape(-1, 3), self.mount_sigma)


@dataclass(frozen=True, eq=False)
class PlumbLines:
    """Vertical directions of the model whose upper end is not known.

    Attributes
    ----------
    model : (n, 3) array
        Unit vectors.
    sigma : (n, 2) array
        One-sigma errors, rad; NaN if not stated.
    """

    labels: Sequence[str]
    model: FloatArray
    sigma: FloatArray

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_directions = self.model @ fit.rotation.T
        down = np.where(placed_directions[:, 2:] > 0, -placed_directions, placed_directions)
        return _downward_rows(down, self.sigma, "plumb lines")


@dataclass(frozen=True, eq=False)
class PhotoUpright:
    """Prior on the vertical: cameras are held upright to within several degrees.

    The prior is never treated as an outlier.

    Attributes
    ----------
    model : (1, 3) array
        Upward unit vector in the model frame.
    sigma : (1, 2) array
        One-sigma errors, rad.
    """

    labels: Sequence[str]
    model: FloatArray
    sigma: FloatArray

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        return _downward_rows(-self.model @ fit.rotation.T, self.sigma, "photo upright")


@dataclass(frozen=True, eq=False)
class LevelLines:
    """Directions of the model that are horizontal, such as horizons in photos.

    Attributes
    ----------
    model : (n, 3) array
        Unit vectors.
    sigma : (n,) array
        One-sigma errors, rad; NaN if not stated.
    min_separation_rad : float
        Minimum angle between lines that are used separately, rad. If all angles are smaller,
        the lines count as one line in their mean direction. Otherwise, the error of a single
        line could tilt the model about this direction.
    """

    labels: Sequence[str]
    model: FloatArray
    sigma: FloatArray
    min_separation_rad: float = 0.0

    @property
    def max_angle_rad(self) -> float:
        """Largest angle between two of the lines, in rad."""
        return float(np.arccos(np.clip(np.abs(self.model @ self.model.T).min(), 0.0, 1.0)))

    @property
    def are_nearly_parallel(self) -> bool:
        """Whether the lines are too nearly parallel to determine the tilt about them."""
        return len(self.labels) > 1 and self.max_angle_rad < self.min_separation_rad

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_directions = self.model @ fit.rotation.T
        if self.are_nearly_parallel:
            main_direction = np.linalg.svd(placed_directions / self.sigma[:, None])[2][0]
            placed_directions = (
                np.sign(placed_directions @ main_direction)[:, None] * main_direction
            )
        design = np.zeros((len(placed_directions), 7))
        design[:, :3] = _cross_product(placed_directions, np.array([0.0, 0.0, 1.0]))
        return _rows(placed_directions[:, 2], design, self.sigma, ("level lines",))


@dataclass(frozen=True, eq=False)
class Azimuths:
    """Directions of the model whose azimuth is known.

    Attributes
    ----------
    model : (n, 3) array
        Unit vectors that are not vertical.
    azimuth : (n,) array
        Azimuths from north to east, rad.
    sigma : (n,) array
        One-sigma errors, rad; NaN if not stated.
    north_sigma : float
        One-sigma error of north (such as a compass), common to all azimuths, rad.
    """

    labels: Sequence[str]
    model: FloatArray
    azimuth: FloatArray
    sigma: FloatArray
    north_sigma: float = 0.0

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        placed_directions = self.model @ fit.rotation.T
        east, north = placed_directions[:, 0], placed_directions[:, 1]
        horizontal_squares = np.maximum(east**2 + north**2, 1e-12)
        residuals = np.arctan2(east, north) - self.azimuth
        residuals = (residuals + np.pi) % (2 * np.pi) - np.pi
        slope = np.column_stack(
            [
                north / horizontal_squares,
                -east / horizontal_squares,
                np.zeros(len(horizontal_squares)),
            ]
        )
        design = np.zeros((len(horizontal_squares), 7))
        design[:, :3] = _cross_product(placed_directions, slope)
        rows = _rows(residuals, design, self.sigma, ("azimuths",))
        # A north error rotates all azimuths about the vertical.
        return _add_shared_error(rows, design[:, 2:3], self.north_sigma, COMPASS)


@dataclass(frozen=True, eq=False)
class Attitudes:
    """Measured rotations of cameras.

    Attributes
    ----------
    model, world : (n, 3, 3) array
        Rotations from the camera to the model frame and to the World frame.
    axes : (n, 3, 3) array
        Orthogonal World axes (as columns) about which errors of yaw, pitch and roll rotate.
    sigma : (n, 3) array
        One-sigma errors of yaw, pitch and roll, rad; NaN if not stated.
    north_sigma : float
        One-sigma error of north (such as a compass), common to all photos, rad.
    mount_sigma : float
        One-sigma misalignment of the measuring instrument with the camera about each camera axis,
        common to all photos, rad.
    """

    labels: Sequence[str]
    model: FloatArray
    world: FloatArray
    axes: FloatArray
    sigma: FloatArray
    north_sigma: float = 0.0
    mount_sigma: float = 0.0

    def rows(self, fit: Similarity, centre: FloatArray) -> Rows:
        from scipy.spatial.transform import Rotation

        placed_rotations = fit.rotation @ self.model
        relative_rotations = placed_rotations @ np.swapaxes(self.world, 1, 2)
        rotations = Rotation.from_matrix(relative_rotations).as_rotvec()
        # Rotation = axes @ (yaw, pitch, roll).
        inverse = np.swapaxes(self.axes, 1, 2)
        residuals = np.einsum("nij,nj->ni", inverse, rotations)
        n = len(residuals)
        design = np.zeros((n, 3, 7))
        design[:, :, :3] = inverse
        rows = _rows(residuals.ravel(), design.reshape(-1, 7), self.sigma, ("yaw", "pitch", "roll"))
        # Express the common rotation caused by a north error as yaw, pitch and roll of each camera.
        rows = _add_shared_error(rows, inverse[:, :, 2].reshape(-1, 1), self.north_sigma, YAW)
        return _add_shared_error(
            rows, (inverse @ placed_rotations).reshape(-1, 3), self.mount_sigma
        )


_KIND_NAMES: tuple[tuple[type, str], ...] = (
    (FixedScale, "kept_scale"),
    (Lengths, "lengths"),
    (LevelLines, "level_lines"),
    (PlumbLines, "plumb_lines"),
    (PhotoUpright, "photo_upright"),
    (Azimuths, "azimuths"),
    (Attitudes, "attitudes"),
    (Verticals, "verticals"),
    (Directions, "compass"),
)


def kind_name(kind: ObservationKind) -> str:
    """Return the name under which a kind of observation is recorded in a registration.

    Parameters
    ----------
    kind : ObservationKind

    Returns
    -------
    str
    """
    if isinstance(kind, Points):
        return kind.name
    return next((name for cls, name in _KIND_NAMES if isinstance(kind, cls)), "reference")


def all_rows(
    kinds: Sequence[ObservationKind], fit: Similarity, position: FloatArray
) -> tuple[Rows, list[int]]:
    """Concatenate the rows of all kinds, about a point in the World frame.

    Common errors with the same name are merged into one column.

    Returns
    -------
    rows : Rows
    begins : list of int
        First row of each kind, and the end of the last kind.
    """
    rows_by_kind = [kind.rows(fit, position) for kind in kinds if len(kind.labels)]
    starts = [0]
    for rows in rows_by_kind:
        starts.append(starts[-1] + len(rows.residuals))
    columns: dict[tuple[int, int] | str, int] = {}
    columns_by_kind = []
    for kind_index, rows in enumerate(rows_by_kind):
        column_keys = [name or (kind_index, k) for k, name in enumerate(rows.shared_names)]
        columns_by_kind.append([columns.setdefault(key, len(columns)) for key in column_keys])
    shared_columns, sizes = np.zeros((starts[-1], len(columns))), np.zeros(len(columns))
    for start, rows, selected_columns in zip(starts, rows_by_kind, columns_by_kind, strict=False):
        shared_columns[start : start + len(rows.residuals), selected_columns] = rows.shared_design
        sizes[selected_columns] = rows.shared_sigma
    joined_rows = Rows(
        np.concatenate([rows.residuals for rows in rows_by_kind]),
        np.concatenate([rows.design for rows in rows_by_kind]),
        np.concatenate([rows.sigma for rows in rows_by_kind]),
        tuple(name for rows in rows_by_kind for name in rows.groups),
        tuple(name for rows in rows_by_kind for name in rows.parts),
        shared_columns,
        sizes,
        tuple(key if isinstance(key, str) else "" for key in columns),
        np.concatenate(
            [
                np.ones(len(rows.residuals)) if rows.error_factors is None else rows.error_factors
                for rows in rows_by_kind
            ]
        ),
        np.concatenate(
            [
                np.zeros((len(rows.residuals), 3)) if rows.axes is None else rows.axes
                for rows in rows_by_kind
            ]
        ),
    )
    return joined_rows, starts


def _rows(
    residuals: FloatArray,
    design: FloatArray,
    sigma: FloatArray,
    groups: tuple[str, ...],
    parts: tuple[str, ...] = (),
) -> Rows:
    """Return rows with the given errors and without common errors.

    `groups` and `parts` refer to the rows of a single observation. By default, each group consists
    of one part.
    """
    n = len(residuals)
    return Rows(
        np.asarray(residuals, np.float64),
        np.asarray(design, np.float64),
        np.asarray(sigma, np.float64).ravel(),
        groups * (n // len(groups)),
        (parts or groups) * (n // len(parts or groups)),
        np.zeros((n, 0)),
        np.zeros(0),
    )


def _add_shared_error(rows: Rows, shared_columns: FloatArray, sigma: float, name: str = "") -> Rows:
    """Add errors that are common to all rows.

    `shared_columns` (m, k) contains the derivatives. `name` identifies errors that are common to
    several kinds.
    """
    if not sigma > 0:
        return rows
    k = shared_columns.shape[1]
    return replace(
        rows,
        shared_design=np.hstack([rows.shared_design, shared_columns]),
        shared_sigma=np.concatenate([rows.shared_sigma, np.full(k, sigma)]),
        shared_names=(*rows.shared_names, *(name,) * k),
    )


def _downward_rows(placed_directions: FloatArray, sigma: FloatArray, name: str) -> Rows:
    """Return the rows of World directions (n, 3) that are observed to point straight down."""
    horizontal_lengths = np.hypot(placed_directions[:, 0], placed_directions[:, 1])
    # Use the full angle, which may exceed 90 degrees; its direction is undefined straight up.
    angle = np.arctan2(horizontal_lengths, -placed_directions[:, 2])
    factor = np.where(
        horizontal_lengths > 1e-12, angle / np.maximum(horizontal_lengths, 1e-12), 1.0
    )
    residuals = placed_directions[:, :2] * factor[:, None]
    residuals[(horizontal_lengths <= 1e-12) & (placed_directions[:, 2] > 0), 0] = np.pi
    design = np.zeros((len(placed_directions), 2, 7))
    # Rotations about east and north move a direction along the horizontal axes; rotations about the
    # direction itself do not.
    design[:, 0, 1] = -1.0
    design[:, 1, 0] = 1.0
    return _rows(residuals.ravel(), design.reshape(-1, 7), sigma, (name,))


def _cross_product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return cross products along the last axis, ten times faster than NumPy for few vectors."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _tangents(directions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two tangents (n, 3) of unit vectors: within their vertical plane, and horizontal."""
    up = np.array([0.0, 0.0, 1.0])
    horizontal_axes = _cross_product(up, directions)
    size = np.linalg.norm(horizontal_axes, axis=1, keepdims=True)
    horizontal_axes = np.where(
        size > 1e-9, horizontal_axes / np.maximum(size, 1e-12), [[1.0, 0.0, 0.0]]
    )
    return _cross_product(horizontal_axes, directions), horizontal_axes


def _angle(
    placed_directions: FloatArray, observed_directions: FloatArray, tangent: FloatArray
) -> FloatArray:
    """Return the component (n,) along a tangent of the angle between directions, in rad.

    The component is scaled to the angle instead of its sine, so that the fit converges even
    from distant directions.
    """
    component = (placed_directions * tangent).sum(axis=1)
    sines = np.linalg.norm(
        placed_directions
        - (placed_directions * observed_directions).sum(axis=1)[:, None] * observed_directions,
        axis=1,
    )
    angle = np.arctan2(sines, (placed_directions * observed_directions).sum(axis=1))
    return np.asarray(
        np.where(sines > 1e-12, component / np.maximum(sines, 1e-12) * angle, component)
    )
