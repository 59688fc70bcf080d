"""Errors of the poses of photos relative to the other photos.

The tie points are eliminated from the normal equations of the bundle adjustment (Triggs et al.
2000, Bundle adjustment: a modern synthesis, section 6), with fixed lenses. The tie points alone do
not determine a frame, so the covariance is that of a free network: relative to the similarity that
fits all well connected photos best. The error of the registration and the bending by the lens
affect all photos together and are stated separately.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import noise_px

_MAX_VIEWS = 600
# 95 % quantile of chi-squared with three degrees of freedom, for the ellipsoid of a vector.
_CHI2_95 = 7.814727903251179
# Poses are weak if their errors exceed both limits: a multiple of the median error, and a share of
# the distance from the rock or an angle, which corresponds to several pixels.
_WEAK_RATIO = 4.0
_WEAK_DISTANCE_SHARE, _WEAK_ANGLE_DEG = 0.005, 0.3
_MAX_ROUNDS = 5


@dataclass(frozen=True, eq=False)
class PoseErrors:
    """Errors of the poses of the v photos of a scene.

    Attributes
    ----------
    position95 : (v,) array
        Semi-major axis of the 95 % ellipsoid of each projection centre, in the unit of the scene.
    rotation95_deg : (v,) array
        Semi-major axis of the 95 % ellipsoid of each rotation, in degrees.
    is_weak : (v,) array of bool
        Whether the pose is much less certain than those of the other photos.
    """

    position95: FloatArray
    rotation95_deg: FloatArray
    is_weak: BoolArray

    def findings(self, scene: SparseScene) -> list[Finding]:
        """Return a warning that names the weakly connected photos, if any."""
        if not self.is_weak.any():
            return []
        return [
            Finding(
                "weak-poses",
                photos=tuple(sorted(self.weak_names(scene))),
                value=float(self.rotation95_deg[self.is_weak].max()),
            )
        ]

    def weak_names(self, scene: SparseScene) -> frozenset[str]:
        """Return the names of the weakly connected photos."""
        return frozenset(scene.views[row].name for row in np.flatnonzero(self.is_weak))

    def errors_by_name(self, scene: SparseScene) -> dict[str, tuple[float, float]]:
        """Return the errors of position and rotation by the name of the photo."""
        errors = zip(self.position95.tolist(), self.rotation95_deg.tolist(), strict=True)
        return {view.name: error for view, error in zip(scene.views, errors, strict=True)}


def pose_errors(scene: SparseScene, noise: float | None = None) -> PoseErrors | None:
    """Compute the errors of all poses of a scene.

    Returns None if the scene has too few or too many photos, or no tie points.

    Parameters
    ----------
    scene : SparseScene
    noise : float, optional
        Error of a tie point observation in one direction, pixels. By default, it is estimated.
    """
    count = len(scene.views)
    if not 3 <= count <= _MAX_VIEWS or not len(scene.points):
        return None
    normal = _pose_information(scene, noise_px(scene) if noise is None else noise)
    depths = np.array([_median_depth(scene, row) for row in range(count)])
    motions = _similarity_motions(scene.centres, float(np.nanmedian(depths)))
    is_datum = np.ones(count, bool)
    for _ in range(_MAX_ROUNDS):
        covariance = _free_network_covariance(normal, motions, is_datum)
        blocks = covariance.reshape(count, 6, count, 6)[np.arange(count), :, np.arange(count), :]
        position95 = _semi_axes(blocks[:, :3, :3])
        rotation95_deg = np.degrees(_semi_axes(blocks[:, 3:, 3:]))
        # A photo without tie points has no depth.
        shares = position95 / np.where(np.isfinite(depths), depths, 1e-300)
        is_weak = _exceeds(shares, _WEAK_DISTANCE_SHARE) | _exceeds(rotation95_deg, _WEAK_ANGLE_DEG)
        if (is_weak != is_datum).all() or is_weak.mean() > 0.5:
            break
        is_datum = ~is_weak
    return PoseErrors(position95, np.minimum(rotation95_deg, 180.0), is_weak)


def _exceeds(values: FloatArray, limit: float) -> BoolArray:
    return np.asarray((values > limit) & (values > _WEAK_RATIO * np.median(values)))


def _median_depth(scene: SparseScene, row: int) -> float:
    points = scene.points[scene.observed_points(row)]
    return float(np.median(scene.views[row].depths(points))) if len(points) else np.nan


def _semi_axes(covariances: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(_CHI2_95 * np.maximum(np.linalg.eigvalsh(covariances)[:, -1], 0.0)))


def _pose_information(scene: SparseScene, noise: float) -> FloatArray:
    """Return the normal matrix (6 v, 6 v) of the poses, with the tie points eliminated."""
    from scipy.sparse import bsr_matrix

    count, points = len(scene.views), scene.track_points
    pose_derivatives, point_derivatives = _derivatives(scene.views, scene, noise)
    normal = np.zeros((count, 6, count, 6))
    pose_blocks = np.zeros((count, 6, 6))
    np.add.at(
        pose_blocks,
        scene.track_views,
        np.einsum("mki,mkj->mij", pose_derivatives, pose_derivatives),
    )
    normal[np.arange(count), :, np.arange(count), :] = pose_blocks
    point_information = np.zeros((len(scene.points), 3, 3))
    np.add.at(
        point_information, points, np.einsum("mki,mkj->mij", point_derivatives, point_derivatives)
    )
    # Points on parallel rays are undetermined along these.
    values, axes = np.linalg.eigh(point_information)
    is_determined = values > 1e-9 * np.maximum(values[:, -1:], 1e-300)
    roots = np.where(is_determined, 1 / np.sqrt(np.where(is_determined, values, 1.0)), 0.0)
    whitening = np.einsum("nij,nj->nji", axes, roots)
    blocks = np.einsum("mab,mkb,mkj->maj", whitening[points], point_derivatives, pose_derivatives)
    # Rows by point, in the order of the observations.
    cross_terms = bsr_matrix(
        (blocks, scene.track_views, scene.track_offsets),
        shape=(3 * len(scene.points), 6 * count),
    ).tocsr()
    return np.asarray(
        normal.reshape(6 * count, 6 * count) - (cross_terms.T @ cross_terms).toarray()
    )


def _derivatives(
    views: Sequence[View], scene: SparseScene, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Return the weighted derivatives with respect to poses (m, 2, 6) and points (m, 2, 3).

    A pose consists of the projection centre and a rotation about the axes of the scene.
    """
    count = len(scene.track_views)
    pose_derivatives, point_derivatives = np.zeros((count, 2, 6)), np.zeros((count, 2, 3))
    for row, view in enumerate(views):
        rows = np.flatnonzero(scene.track_views == row)
        if not len(rows):
            continue
        rays = scene.points[scene.track_points[rows]] - view.centre
        camera_points = rays @ view.rotation.T
        step = 1e-5 * np.abs(camera_points[:, 2:3])
        slopes = np.zeros((len(rows), 2, 3))
        for axis, move in enumerate(np.eye(3)):
            ends = [view.intrinsics.project(camera_points + side * step * move) for side in (1, -1)]
            slopes[:, :, axis] = (ends[0] - ends[1]) / (2 * step)
        point_slopes = slopes @ view.rotation
        point_derivatives[rows] = point_slopes
        pose_derivatives[rows, :, :3] = -point_slopes
        # A rotation of the photo by a vector moves a ray, seen from the photo, by ray x vector.
        pose_derivatives[rows, :, 3:] = np.cross(point_slopes, rays[:, None])
    is_undefined = ~np.isfinite(pose_derivatives).all(axis=(1, 2))
    pose_derivatives[is_undefined] = point_derivatives[is_undefined] = 0.0
    return pose_derivatives / noise, point_derivatives / noise


def _similarity_motions(centres: FloatArray, scale: float) -> FloatArray:
    """Return the derivatives (6 v, 7) of the poses with respect to a similarity."""
    count = len(centres)
    offsets = centres - centres.mean(axis=0)
    motions = np.zeros((count, 6, 7))
    motions[:, :3, :3] = scale * np.eye(3)
    for axis, rotation in enumerate(np.eye(3)):
        motions[:, :3, 3 + axis] = np.cross(rotation, offsets)
        motions[:, 3 + axis, 3 + axis] = 1.0
    motions[:, :3, 6] = offsets
    return motions.reshape(6 * count, 7)


def _free_network_covariance(
    normal: FloatArray, motions: FloatArray, is_datum: BoolArray
) -> FloatArray:
    """Return the covariance (6 v, 6 v) relative to the similarity that fits the datum best.

    Singular directions other than those of the similarity get very large variances.
    """
    size = len(normal)
    # Positions and rotations count equally at the distance of the rock.
    weights = np.tile([1 / motions[0, 0], 1 / motions[0, 0], 1 / motions[0, 0], 1, 1, 1], size // 6)
    weights = np.where(np.repeat(is_datum, 6), weights, 0.0) ** 2
    scales = 1 / np.sqrt(np.maximum(np.diag(normal), 1e-12 * np.diag(normal).max()))
    scaled_normal = normal * scales[:, None] * scales
    constraints = motions * weights[:, None] * scales[:, None]
    constraints /= np.linalg.norm(constraints, axis=0)
    ridge = 1e-10 * np.eye(size)
    inverse = np.linalg.inv(scaled_normal + constraints @ constraints.T + ridge)
    inverse = inverse * scales[:, None] * scales
    weighted_motions = motions * weights[:, None]
    fit = np.linalg.solve(weighted_motions.T @ motions, weighted_motions.T)
    to_free = np.eye(size) - motions @ fit
    return np.asarray(to_free @ inverse @ to_free.T)
