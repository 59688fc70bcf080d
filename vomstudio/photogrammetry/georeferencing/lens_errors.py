"""What the errors of the lenses do to a placed model: how far it may bow, stretch, turn and grow.

A block of photos with a wrong lens bends (James & Robson 2014, Earth Surface Processes and
Landforms 39, 1413-1420), and no residual shows it where nothing but the photos knows the shape. So
each lens is moved by what it may be wrong, poses and points are adjusted to that (`lens_response`),
the scene is registered again as it was, and what becomes of its tie points is told as a turn, a
growth, a bowing and a stretch of depths.

What a lens may be wrong: a focal length that is held is known as well as EXIF gives it, or as a
usual lens is; all else as well as the photos and the ground determine it, neighbouring tie points
counted as one, and no worse than lenses differ by. So much for what was held at nought: it may
still be there, too small for these photos to show.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.geology.bowing import LensBend, model_shape, shape_change
from vomstudio.geometry.cameras import MODELS, Intrinsics, View
from vomstudio.photogrammetry.align.priors import FAR_FROM_EXIF, LOOSEST_SIGMA, Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import (
    KnownCentre,
    KnownPoint,
    noise_px,
)
from vomstudio.photogrammetry.georeferencing.ground_calibration import LensVerdict
from vomstudio.photogrammetry.georeferencing.lens_response import Response, response_of
from vomstudio.registration.similarity import Similarity

_Z95 = 1.959963984540054
# Tie points for each photo, of which a few dozen know a lens as well as thousands that err alike.
_PER_PHOTO = 60
# Of lenses of the same model from the factory, one sigma, before photos tell: the radial terms of
# undistorted and of plain lenses, and of the diagonal, the middle (see `align.priors`).
_K1, _K2, _CENTRE = 0.1, 0.05, 0.005 / np.sqrt(2.0)
# EXIF is wrong by no more in nineteen cameras of twenty; what is more shows (see `align.priors`).
_EXIF = FAR_FROM_EXIF / _Z95
_MOST_LENSES = 20
_MOST_VIEWS = 1500
_FEWEST_POINTS = 20


@dataclass(frozen=True, eq=False)
class LensEffect:
    """covariance : (7, 7) of turns about east, north and up (rad), a relative change of scale and a
    shift about a place, as in `Scatter`; planes anywhere on the model counted in the mean, which
    bowing and stretch turn too
    bend : by the 95 % errors
    """

    covariance: FloatArray
    bend: LensBend


def lens_effect(
    scene: SparseScene,
    cameras: Sequence[Calibration],
    about: FloatArray,
    placed_again: Callable[[SparseScene], Similarity] | None = None,
    points: Sequence[KnownPoint] = (),
    centres: Sequence[KnownCentre] = (),
    lenses: Sequence[LensVerdict] = (),
) -> LensEffect | None:
    """None where the cameras are not known, or there is too little to tell.

    scene : registered; about : (3,) in its frame; placed_again : the registration of a scene like
    it, None where its own points hold it; points, centres : that it was adjusted to; lenses : what
    became of them then
    """
    if not cameras or len(scene.points) < _FEWEST_POINTS or len(scene.views) > _MOST_VIEWS:
        return None
    free = dict(_freed(scene, cameras, lenses))
    if not free:
        return None
    some = _thinned(scene)
    wide = _with_second(some, free)
    response = response_of(wide, noise_px(wide), points, centres)
    middle, axes, reach = model_shape(scene.points)
    found = []
    try:
        for change in _changes(response, [free.get(lens) for lens in _lenses(some)]):
            there = response.moved(change)
            fit = _own(wide, there) if placed_again is None else placed_again(there)
            moves = fit(there.points) - wide.points
            found.append(shape_change(wide.points, moves))
    except (GeometryError, np.linalg.LinAlgError):
        return None
    own, _, _ = model_shape(wide.points)
    rows = np.zeros((len(found), 7))
    for row, one in zip(rows, found, strict=True):
        away = about - own
        row[:3], row[3] = one.turn, one.growth
        row[4:] = one.shift + np.cross(one.turn, away) + one.growth * away
    covariance = rows.T @ rows
    curvature = float(np.sqrt(sum(one.curvature_per_m**2 for one in found)))
    stretch = float(np.sqrt(sum(one.stretch**2 for one in found)))
    if not np.isfinite([*covariance.ravel(), curvature, stretch]).all():
        return None
    away2 = float(
        (((scene.points - middle) @ axes[:2].T) ** 2).sum(axis=1).clip(0, reach**2).mean()
    )
    tilt = (2.0 * curvature) ** 2 * away2 / 2.0 + (stretch / 2.0) ** 2 / 2.0
    covariance[:3, :3] += tilt * axes[:2].T @ axes[:2]
    return LensEffect(covariance, LensBend(_Z95 * curvature, reach, _Z95 * stretch))


def bend_of_lenses(scene: SparseScene, cameras: Sequence[Calibration]) -> LensBend | None:
    """Of a scene that nothing outside of the photos holds, in its own unit of length."""
    found = lens_effect(scene, cameras, scene.points.mean(axis=0))
    return None if found is None else found.bend


def same(_scene: SparseScene) -> Similarity:
    """Of a scene that its adjustment holds where it is."""
    return Similarity(1.0, np.eye(3), np.zeros(3))


def _lenses(scene: SparseScene) -> list[Intrinsics]:
    return list(dict.fromkeys(view.intrinsics for view in scene.views))


def _freed(
    scene: SparseScene, cameras: Sequence[Calibration], lenses: Sequence[LensVerdict]
) -> list[tuple[Intrinsics, float]]:
    """(lens, one sigma of its focal length as a share where that is held, else 0) of the lenses
    with most photos."""
    by_photo = {photo: camera for camera in cameras for photo in camera.photos}
    by_ground = {photo for lens in lenses if lens.freed for photo in lens.photos}
    count: dict[Intrinsics, int] = {}
    held: dict[Intrinsics, float] = {}
    for view in scene.views:
        camera = by_photo.get(view.name)
        if camera is None:
            continue
        count[view.intrinsics] = count.get(view.intrinsics, 0) + 1
        known = _EXIF if camera.exif_px is not None else LOOSEST_SIGMA
        freed = camera.focal == "freed" or view.name in by_ground
        held[view.intrinsics] = 0.0 if freed else known
    most = sorted(count, key=lambda lens: -count[lens])[:_MOST_LENSES]
    return [(lens, held[lens]) for lens in most]


def _thinned(scene: SparseScene) -> SparseScene:
    """With some of the tie points, those in most photos first, so that each photo has enough."""
    wanted = np.full(len(scene.views), _PER_PHOTO)
    if len(scene.track_views) <= wanted.sum():
        return scene
    rng = np.random.default_rng(0)
    order = rng.permutation(len(scene.points))
    order = order[np.argsort(-np.minimum(scene.track_lengths[order], 6), kind="stable")]
    keep = np.zeros(len(scene.points), bool)
    offsets = scene.track_offsets
    for point in order:
        mine = scene.track_views[offsets[point] : offsets[point + 1]]
        if (wanted[mine] > 0).any():
            keep[point] = True
            wanted[mine] -= 1
        if not (wanted > 0).any():
            break
    seen = np.repeat(keep, scene.track_lengths)
    return replace(
        scene,
        points=scene.points[keep],
        colors=scene.colors[keep],
        errors_px=scene.errors_px[keep],
        track_offsets=np.concatenate([[0], np.cumsum(scene.track_lengths[keep])]).astype(np.int64),
        track_views=scene.track_views[seen],
        track_pixels=scene.track_pixels[seen],
    )


def _with_second(scene: SparseScene, known: dict[Intrinsics, float]) -> SparseScene:
    """With a place for k2, which bends a block most, in lenses that have none."""

    def wider(view: View) -> View:
        lens = view.intrinsics
        if lens.model != "SIMPLE_RADIAL" or lens not in known:
            return view
        return replace(view, intrinsics=replace(lens, model="RADIAL", params=(*lens.params, 0.0)))

    return replace(scene, views=tuple(wider(view) for view in scene.views))


def _changes(response: Response, held: Sequence[float | None]) -> list[FloatArray]:
    """One-sigma changes of all lenses, (l,) each, independent of each other. held : of each lens
    one sigma of its focal length as a share, 0 where that was estimated, None for a lens that is
    taken as right."""
    prior, fixed, wrong = [], [], []
    for lens, share in zip(response.lenses, held, strict=True):
        diagonal = float(np.hypot(lens.width, lens.height))
        for name in MODELS[lens.model]:
            spread = {"c": _CENTRE * diagonal, "k": _K2, "p": 0.1 * _K2}.get(name[0], np.inf)
            prior.append(_K1 if name == "k1" else spread)
            focal = name[0] == "f"
            fixed.append(share is None or (focal and share > 0.0))
            wrong.append((share or 0.0) * lens.focal[0] if focal else 0.0)
    loose = ~np.array(fixed)
    information = response.information + np.diag(np.array(prior) ** -2.0)
    inner = information[np.ix_(loose, loose)]
    values, axes = np.linalg.eigh(inner)
    values = np.maximum(values, 1e-12 * values[-1])
    changes = []
    for value, axis in zip(values, axes.T, strict=True):
        change = np.zeros(len(loose))
        change[loose] = axis / np.sqrt(value)
        changes.append(change)
    # The rest of a lens answers to a wrong focal length.
    for k in np.flatnonzero(wrong):
        change = np.zeros(len(loose))
        change[k] = wrong[k]
        pull = response.information[np.ix_(loose, [k])][:, 0] * wrong[k]
        change[loose] = -(axes / values) @ (axes.T @ pull)
        changes.append(change)
    return changes


def _own(before: SparseScene, after: SparseScene) -> Similarity:
    """By the tie points themselves."""
    from vomstudio.registration.similarity import fit_similarity

    return fit_similarity(after.points, before.points)
