"""Response of poses and tie points to lens changes, by linearised bundle adjustment.

The points are eliminated from the normal equations of a bundle adjustment (Triggs et al. 2000,
Bundle adjustment: a modern synthesis, section 6). A change of the lenses by d then changes the
poses by -S_pp^-1 S_pl d, and each point follows its rays. The information of the observations on
the lenses is S_ll - S_lp S_pp^-1 S_pl.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import KnownCentre, KnownPoint

# Weak prior of the poses: one radian, and the size of the scene. It fixes the frame of a scene that
# has no external observations.
_POSE_SIGMA = 1.0
_STEP_PX, _STEP_K = 0.5, 1e-4


@dataclass(frozen=True, eq=False)
class LensResponse:
    """Response of a scene to lens changes.

    Attributes
    ----------
    lenses : tuple of Intrinsics
        Lenses of the scene in the order of the unknowns, each with its parameters.
    information : (l, l) array
        Information matrix of the lens parameters.
    """

    scene: SparseScene
    lenses: tuple[Intrinsics, ...]
    information: FloatArray
    _poses_by_lens: FloatArray
    _point_inverse: FloatArray
    _point_pose_information: FloatArray
    _point_lens_information: FloatArray
    _rows: tuple[IntArray, IntArray, IntArray]

    @property
    def starts(self) -> IntArray:
        """Index (n,) of the first unknown of each of the n lenses."""
        counts = [len(lens.params) for lens in self.lenses]
        return np.concatenate([[0], np.cumsum(counts)])[:-1].astype(np.int64)

    def apply_change(self, change: FloatArray) -> SparseScene:
        """Return the adjusted scene after a change (l,) of the lenses."""
        poses = self._poses_by_lens @ change
        views, points, lens_rows = self._rows
        pose_changes = poses.reshape(-1, 6)
        new_lenses = []
        for lens, start in zip(self.lenses, self.starts, strict=True):
            params = np.array(lens.params) + change[start : start + len(lens.params)]
            new_lenses.append(replace(lens, params=tuple(params.tolist())))
        right = np.einsum("mij,mj->mi", self._point_pose_information, pose_changes[views])
        parameter_count = self._point_lens_information.shape[2]
        lens_changes = np.zeros((len(self.lenses), parameter_count))
        for k, (lens, start) in enumerate(zip(self.lenses, self.starts, strict=True)):
            lens_changes[k, : len(lens.params)] = change[start : start + len(lens.params)]
        right += np.einsum("mij,mj->mi", self._point_lens_information, lens_changes[lens_rows])
        count = len(self._point_inverse)
        pull = np.stack([np.bincount(points, right[:, k], count) for k in range(3)], axis=1)
        point_shifts = -np.einsum("nij,nj->ni", self._point_inverse, pull)
        number = {lens: k for k, lens in enumerate(self.lenses)}
        new_views = [
            _move_view(view, move, new_lenses[number[view.intrinsics]])
            for view, move in zip(self.scene.views, pose_changes, strict=True)
        ]
        point_count = len(self.scene.points)
        return replace(
            self.scene,
            views=tuple(new_views),
            points=self.scene.points + point_shifts[:point_count],
        )


def compute_response(
    scene: SparseScene,
    noise_px: float,
    points: Sequence[KnownPoint] = (),
    centres: Sequence[KnownCentre] = (),
) -> LensResponse:
    """Compute the response of a scene to lens changes.

    Parameters
    ----------
    scene : SparseScene
    noise_px : float
        Error of a tie point observation in one direction, in pixels.
    points, centres : sequence
        Observations of the adjustment, as in `ground_adjustment.bundle_adjust`.
    """
    lenses = tuple(dict.fromkeys(view.intrinsics for view in scene.views))
    number = {lens: k for k, lens in enumerate(lenses)}
    rows = np.array([number[view.intrinsics] for view in scene.views], np.int64)
    starts = np.concatenate([[0], np.cumsum([len(lens.params) for lens in lenses])])
    positions, observations = _observations(scene, noise_px, points)
    width = max(len(lens.params) for lens in lenses)
    pose_derivatives, point_derivatives, lens_derivatives = _derivatives(
        scene.views, positions, observations, width
    )
    views, point_rows = observations.views, observations.points
    count = len(positions)

    point_information = np.zeros((count, 3, 3))
    np.add.at(
        point_information,
        point_rows,
        np.einsum("mki,mkj->mij", point_derivatives, point_derivatives),
    )
    point_information += observations.prior[:, None, None] * np.eye(3)
    # Points on two almost parallel rays need a prior of the size of the scene.
    scale = float(np.trace(point_information, axis1=1, axis2=2).mean()) if count else 1.0
    inverse: FloatArray = np.linalg.inv(point_information + 1e-12 * scale * np.eye(3)).astype(
        np.float64
    )
    point_pose_information: FloatArray = np.einsum(
        "mki,mkj->mij", point_derivatives, pose_derivatives
    )
    point_lens_information: FloatArray = np.einsum(
        "mki,mkj->mij", point_derivatives, lens_derivatives
    )

    size = 6 * len(scene.views)
    total = size + int(starts[-1])
    normal = np.zeros((total, total))
    lens_rows = rows[views]
    columns = np.concatenate([pose_derivatives, lens_derivatives], axis=2)
    pull = np.concatenate([point_pose_information, point_lens_information], axis=2)
    parameter_indices = np.full((len(views), 6 + width), total, np.int64)
    parameter_indices[:, :6] = 6 * views[:, None] + np.arange(6)
    for k, lens in enumerate(lenses):
        has_lens = lens_rows == k
        parameter_indices[np.ix_(has_lens, 6 + np.arange(len(lens.params)))] = (
            size + starts[k] + np.arange(len(lens.params))
        )
    padded_matrix = np.zeros((total + 1, total + 1))
    products = np.einsum("mki,mkj->mij", columns, columns)
    np.add.at(
        padded_matrix, (parameter_indices[:, :, None], parameter_indices[:, None, :]), products
    )
    _eliminate_points(padded_matrix, point_rows, parameter_indices, pull, inverse)
    normal = padded_matrix[:total, :total]
    _add_priors(normal, scene, centres)
    poses = normal[:size, :size]
    mixed_normal = normal[:size, size:]
    poses_by_lens = np.asarray(-np.linalg.solve(poses, mixed_normal), np.float64)
    information = normal[size:, size:] + mixed_normal.T @ poses_by_lens
    information = (information + information.T) / 2.0
    return LensResponse(
        scene,
        lenses,
        information,
        poses_by_lens,
        inverse,
        point_pose_information,
        point_lens_information,
        (views, point_rows, lens_rows),
    )


@dataclass(frozen=True, eq=False)
class _Observations:
    """Observations of points in photos.

    views, points : (m,) rows of the view and point of each observation
    weight : (m,) inverse pixel errors
    prior : (n,) inverse variance of a coordinate of each point
    """

    views: IntArray
    points: IntArray
    weight: FloatArray
    prior: FloatArray


def _observations(
    scene: SparseScene, noise_px: float, points: Sequence[KnownPoint]
) -> tuple[FloatArray, _Observations]:
    views, point_rows = [scene.track_views.astype(np.int64)], [scene.track_points]
    weight = [np.full(len(scene.track_views), 1.0 / noise_px)]
    positions, prior = [scene.points], [np.zeros(len(scene.points))]
    count = len(scene.points)
    for point in points:
        if point.position is None or len(point.views) < 1:
            continue
        views.append(np.asarray(point.views, np.int64))
        point_rows.append(np.full(len(point.views), count, np.int64))
        weight.append(np.full(len(point.views), 1.0 / point.mark_px))
        positions.append(np.asarray(point.position, np.float64)[None])
        prior.append(np.array([point.sigma**-2.0]))
        count += 1
    observations = _Observations(
        *(np.concatenate(item) for item in (views, point_rows, weight, prior))
    )
    return np.concatenate(positions), observations


def _derivatives(
    views: Sequence[View],
    positions: FloatArray,
    observations: _Observations,
    n_lens_parameters: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the weighted derivatives (m, 2, k) of observations for pose, point and lens.

    A pose consists of a rotation and a translation in the camera frame. Undefined derivatives are
    0.
    """
    count = len(observations.views)
    pose_derivatives, point_derivatives = np.zeros((count, 2, 6)), np.zeros((count, 2, 3))
    lens_derivatives = np.zeros((count, 2, n_lens_parameters))
    for row, view in enumerate(views):
        rows_of_view = np.flatnonzero(observations.views == row)
        if not len(rows_of_view):
            continue
        camera_points = (
            positions[observations.points[rows_of_view]] @ view.rotation.T + view.translation
        )
        step = 1e-5 * np.abs(camera_points[:, 2:3])
        slopes = np.zeros((len(rows_of_view), 2, 3))
        for k in range(3):
            move = step * np.eye(3)[k]
            forward_pixels, backward_pixels = (
                view.intrinsics.project(camera_points + move),
                view.intrinsics.project(camera_points - move),
            )
            slopes[:, :, k] = (forward_pixels - backward_pixels) / (2.0 * step)
        rotation_derivatives = np.zeros((len(rows_of_view), 3, 6))
        x, y, z = camera_points.T
        rotation_derivatives[:, 0, 1], rotation_derivatives[:, 0, 2] = z, -y
        rotation_derivatives[:, 1, 0], rotation_derivatives[:, 1, 2] = -z, x
        rotation_derivatives[:, 2, 0], rotation_derivatives[:, 2, 1] = y, -x
        rotation_derivatives[:, :, 3:] = np.eye(3)
        pose_derivatives[rows_of_view] = slopes @ rotation_derivatives
        point_derivatives[rows_of_view] = slopes @ view.rotation
        params = np.array(view.intrinsics.params)
        for k, name in enumerate(CAMERA_MODELS[view.intrinsics.model]):
            move = np.zeros(len(params))
            move[k] = _STEP_PX if name[0] in "fc" else _STEP_K
            shifted_lenses = [
                replace(view.intrinsics, params=tuple((params + sign * move).tolist()))
                for sign in (1.0, -1.0)
            ]
            pixels = [lens.project(camera_points) for lens in shifted_lenses]
            lens_derivatives[rows_of_view, :, k] = (pixels[0] - pixels[1]) / (2.0 * move[k])
    weight = observations.weight[:, None, None]
    weighted_derivatives = (
        pose_derivatives * weight,
        point_derivatives * weight,
        lens_derivatives * weight,
    )
    is_undefined = ~np.isfinite(np.concatenate(weighted_derivatives, axis=2)).all(axis=(1, 2))
    for item in weighted_derivatives:
        item[is_undefined] = 0.0
    return weighted_derivatives


def _eliminate_points(
    normal: FloatArray,
    residual_rows: IntArray,
    unknown_indices: IntArray,
    pull: FloatArray,
    inverse: FloatArray,
) -> None:
    """Eliminate the points from the normal equations, in place.

    residual_rows : (m,) point of each observation
    unknown_indices : (m, k) indices of the unknowns of each observation
    pull : (m, 3, k) terms of the normal matrix between the point and these unknowns
    """
    order = np.argsort(residual_rows, kind="stable")
    ends = np.concatenate([np.flatnonzero(np.diff(residual_rows[order])) + 1, [len(order)]])
    start = 0
    for end in ends:
        rows_of_point = order[start:end]
        start = end
        cross_terms = np.concatenate(list(pull[rows_of_point]), axis=1)
        unknowns = unknown_indices[rows_of_point].ravel()
        correction = cross_terms.T @ inverse[residual_rows[rows_of_point[0]]] @ cross_terms
        np.subtract.at(normal, (unknowns[:, None], unknowns[None, :]), correction)


def _add_priors(normal: FloatArray, scene: SparseScene, centres: Sequence[KnownCentre]) -> None:
    """Add known camera positions and a weak prior on the poses, in place."""
    max_distance = (
        float(np.linalg.norm(scene.centres - scene.centres.mean(axis=0), axis=1).max()) or 1.0
    )
    pose_prior = np.array(
        [_POSE_SIGMA, _POSE_SIGMA, _POSE_SIGMA, *(3 * [_POSE_SIGMA / max_distance**2])]
    )
    for row in range(len(scene.views)):
        position = np.arange(6 * row, 6 * row + 6)
        normal[position, position] += pose_prior
    for centre in centres:
        view = scene.views[centre.view]
        # The centre moves by -R^T times the translation in the camera frame.
        prior_information = (
            view.rotation @ np.diag(np.asarray(centre.sigma) ** -2.0) @ view.rotation.T
        )
        position = np.arange(6 * centre.view + 3, 6 * centre.view + 6)
        normal[np.ix_(position, position)] += prior_information


def _move_view(view: View, move: FloatArray, lens: Intrinsics) -> View:
    from scipy.spatial.transform import Rotation

    rotation = Rotation.from_rotvec(move[:3]).as_matrix()
    shift = rotation @ view.translation + move[3:]
    return View(view.name, lens, np.ascontiguousarray(rotation @ view.rotation), shift)
