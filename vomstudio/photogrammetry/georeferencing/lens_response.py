"""How poses and tie points answer to other lenses: the bundle adjustment, linearised.

With the normal equations of a bundle adjustment (Triggs et al. 2000, Bundle adjustment: a modern
synthesis, section 6), points eliminated, a change of the lenses by d moves the poses by
-S_pp^-1 S_pl d, and each point by what its rays then ask for; what the observations tell of the
lenses is S_ll - S_lp S_pp^-1 S_pl.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.cameras import MODELS, Intrinsics, View
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import KnownCentre, KnownPoint

# Beside what photos tell: poses are known to a radian, and to the size of the scene. Nothing else
# holds the frame of a scene that rests on nothing.
_LOOSE = 1.0
_STEP_PX, _STEP_K = 0.5, 1e-4


@dataclass(frozen=True, eq=False)
class Response:
    """lenses : of the scene, in whose order the unknowns are, each as many as it has parameters
    information : (l, l) of the lenses' parameters, for observations in their own errors
    """

    scene: SparseScene
    lenses: tuple[Intrinsics, ...]
    information: FloatArray
    _poses_by_lens: FloatArray
    _point_inverse: FloatArray
    _to_pose: FloatArray
    _to_lens: FloatArray
    _rows: tuple[IntArray, IntArray, IntArray]

    @property
    def starts(self) -> IntArray:
        """(lenses,) where the unknowns of each lens begin."""
        counts = [len(lens.params) for lens in self.lenses]
        return np.concatenate([[0], np.cumsum(counts)])[:-1].astype(np.int64)

    def moved(self, change: FloatArray) -> SparseScene:
        """The scene once the lenses have changed by (l,) and all else was adjusted."""
        poses = self._poses_by_lens @ change
        views, points, lens_of = self._rows
        each = poses.reshape(-1, 6)
        became = []
        for lens, start in zip(self.lenses, self.starts, strict=True):
            params = np.array(lens.params) + change[start : start + len(lens.params)]
            became.append(replace(lens, params=tuple(params.tolist())))
        right = np.einsum("mij,mj->mi", self._to_pose, each[views])
        wide = self._to_lens.shape[2]
        own = np.zeros((len(self.lenses), wide))
        for k, (lens, start) in enumerate(zip(self.lenses, self.starts, strict=True)):
            own[k, : len(lens.params)] = change[start : start + len(lens.params)]
        right += np.einsum("mij,mj->mi", self._to_lens, own[lens_of])
        count = len(self._point_inverse)
        pull = np.stack([np.bincount(points, right[:, k], count) for k in range(3)], axis=1)
        shifts = -np.einsum("nij,nj->ni", self._point_inverse, pull)
        number = {lens: k for k, lens in enumerate(self.lenses)}
        there = [
            _turned(view, move, became[number[view.intrinsics]])
            for view, move in zip(self.scene.views, each, strict=True)
        ]
        kept = len(self.scene.points)
        return replace(self.scene, views=tuple(there), points=self.scene.points + shifts[:kept])


def response_of(
    scene: SparseScene,
    noise_px: float,
    points: Sequence[KnownPoint] = (),
    centres: Sequence[KnownCentre] = (),
) -> Response:
    """noise_px : of the tie points; points, centres : that are in the adjustment too, as in
    `ground_adjustment.bundle_adjust`"""
    lenses = tuple(dict.fromkeys(view.intrinsics for view in scene.views))
    number = {lens: k for k, lens in enumerate(lenses)}
    rows = np.array([number[view.intrinsics] for view in scene.views], np.int64)
    starts = np.concatenate([[0], np.cumsum([len(lens.params) for lens in lenses])])
    places, seen = _observations(scene, noise_px, points)
    wide = max(len(lens.params) for lens in lenses)
    by_pose, by_point, by_lens = _derivatives(scene.views, places, seen, wide)
    views, which = seen.views, seen.points
    count = len(places)

    inner = np.zeros((count, 3, 3))
    np.add.at(inner, which, np.einsum("mki,mkj->mij", by_point, by_point))
    inner += seen.prior[:, None, None] * np.eye(3)
    # A point that two almost parallel rays see is known to the size of the scene.
    scale = float(np.trace(inner, axis1=1, axis2=2).mean()) if count else 1.0
    inverse: FloatArray = np.linalg.inv(inner + 1e-12 * scale * np.eye(3)).astype(np.float64)
    to_pose: FloatArray = np.einsum("mki,mkj->mij", by_point, by_pose)
    to_lens: FloatArray = np.einsum("mki,mkj->mij", by_point, by_lens)

    size = 6 * len(scene.views)
    total = size + int(starts[-1])
    normal = np.zeros((total, total))
    lens_of = rows[views]
    columns = np.concatenate([by_pose, by_lens], axis=2)
    pull = np.concatenate([to_pose, to_lens], axis=2)
    places_of = np.full((len(views), 6 + wide), total, np.int64)
    places_of[:, :6] = 6 * views[:, None] + np.arange(6)
    for k, lens in enumerate(lenses):
        mine = lens_of == k
        places_of[np.ix_(mine, 6 + np.arange(len(lens.params)))] = (
            size + starts[k] + np.arange(len(lens.params))
        )
    padded = np.zeros((total + 1, total + 1))
    own = np.einsum("mki,mkj->mij", columns, columns)
    np.add.at(padded, (places_of[:, :, None], places_of[:, None, :]), own)
    _eliminate(padded, which, places_of, pull, inverse)
    normal = padded[:total, :total]
    _hold(normal, scene, centres)
    poses = normal[:size, :size]
    mixed = normal[:size, size:]
    answer = np.asarray(-np.linalg.solve(poses, mixed), np.float64)
    information = normal[size:, size:] + mixed.T @ answer
    information = (information + information.T) / 2.0
    return Response(
        scene, lenses, information, answer, inverse, to_pose, to_lens, (views, which, lens_of)
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """views, points : (m,) rows; weight : (m,) one over the error of a pixel; prior : (n,) one over
    the variance of a coordinate of each point"""

    views: IntArray
    points: IntArray
    weight: FloatArray
    prior: FloatArray


def _observations(
    scene: SparseScene, noise_px: float, points: Sequence[KnownPoint]
) -> tuple[FloatArray, _Seen]:
    views, which = [scene.track_views.astype(np.int64)], [scene.track_points]
    weight = [np.full(len(scene.track_views), 1.0 / noise_px)]
    places, prior = [scene.points], [np.zeros(len(scene.points))]
    count = len(scene.points)
    for point in points:
        if point.position is None or len(point.views) < 1:
            continue
        views.append(np.asarray(point.views, np.int64))
        which.append(np.full(len(point.views), count, np.int64))
        weight.append(np.full(len(point.views), 1.0 / point.mark_px))
        places.append(np.asarray(point.position, np.float64)[None])
        prior.append(np.array([point.sigma**-2.0]))
        count += 1
    seen = _Seen(*(np.concatenate(each) for each in (views, which, weight, prior)))
    return np.concatenate(places), seen


def _derivatives(
    views: Sequence[View], places: FloatArray, seen: _Seen, wide: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of each observation in its own error, (m, 2, k): by the pose (a turn and a shift in the
    camera's frame), by the point, by the lens; 0 where it cannot be had."""
    count = len(seen.views)
    by_pose, by_point = np.zeros((count, 2, 6)), np.zeros((count, 2, 3))
    by_lens = np.zeros((count, 2, wide))
    for row, view in enumerate(views):
        mine = np.flatnonzero(seen.views == row)
        if not len(mine):
            continue
        there = places[seen.points[mine]] @ view.rotation.T + view.translation
        step = 1e-5 * np.abs(there[:, 2:3])
        slopes = np.zeros((len(mine), 2, 3))
        for k in range(3):
            move = step * np.eye(3)[k]
            ahead, back = (
                view.intrinsics.project(there + move),
                view.intrinsics.project(there - move),
            )
            slopes[:, :, k] = (ahead - back) / (2.0 * step)
        turns = np.zeros((len(mine), 3, 6))
        x, y, z = there.T
        turns[:, 0, 1], turns[:, 0, 2] = z, -y
        turns[:, 1, 0], turns[:, 1, 2] = -z, x
        turns[:, 2, 0], turns[:, 2, 1] = y, -x
        turns[:, :, 3:] = np.eye(3)
        by_pose[mine] = slopes @ turns
        by_point[mine] = slopes @ view.rotation
        params = np.array(view.intrinsics.params)
        for k, name in enumerate(MODELS[view.intrinsics.model]):
            move = np.zeros(len(params))
            move[k] = _STEP_PX if name[0] in "fc" else _STEP_K
            two = [
                replace(view.intrinsics, params=tuple((params + sign * move).tolist()))
                for sign in (1.0, -1.0)
            ]
            pixels = [lens.project(there) for lens in two]
            by_lens[mine, :, k] = (pixels[0] - pixels[1]) / (2.0 * move[k])
    weight = seen.weight[:, None, None]
    made = by_pose * weight, by_point * weight, by_lens * weight
    lost = ~np.isfinite(np.concatenate(made, axis=2)).all(axis=(1, 2))
    for each in made:
        each[lost] = 0.0
    return made


def _eliminate(
    normal: FloatArray, which: IntArray, places: IntArray, pull: FloatArray, inverse: FloatArray
) -> None:
    """Take out of the normal equations, in place, what the points take up. which : (m,) point of
    each observation; places : (m, k) its unknowns; pull : (m, 3, k)"""
    order = np.argsort(which, kind="stable")
    ends = np.concatenate([np.flatnonzero(np.diff(which[order])) + 1, [len(order)]])
    start = 0
    for end in ends:
        mine = order[start:end]
        start = end
        cross = np.concatenate(list(pull[mine]), axis=1)
        at = places[mine].ravel()
        taken = cross.T @ inverse[which[mine[0]]] @ cross
        np.subtract.at(normal, (at[:, None], at[None, :]), taken)


def _hold(normal: FloatArray, scene: SparseScene, centres: Sequence[KnownCentre]) -> None:
    """Known places of cameras, and what keeps the rest from drifting, in place."""
    reach = float(np.linalg.norm(scene.centres - scene.centres.mean(axis=0), axis=1).max()) or 1.0
    loose = np.array([_LOOSE, _LOOSE, _LOOSE, *(3 * [_LOOSE / reach**2])])
    for row in range(len(scene.views)):
        at = np.arange(6 * row, 6 * row + 6)
        normal[at, at] += loose
    for centre in centres:
        view = scene.views[centre.view]
        # The centre moves by -R^T times the shift in the camera's frame.
        known = view.rotation @ np.diag(np.asarray(centre.sigma) ** -2.0) @ view.rotation.T
        at = np.arange(6 * centre.view + 3, 6 * centre.view + 6)
        normal[np.ix_(at, at)] += known


def _turned(view: View, move: FloatArray, lens: Intrinsics) -> View:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(move[:3]).as_matrix()
    shift = turn @ view.translation + move[3:]
    return View(view.name, lens, np.ascontiguousarray(turn @ view.rotation), shift)
