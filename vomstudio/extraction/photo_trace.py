"""What `vomstudio trace --photo` and `vs.follow` tell of a trace that was followed in a photo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.results import HIDDEN
from vomstudio.core.words import tr
from vomstudio.extraction.best_cost import AUTO, Tried, best_of
from vomstudio.extraction.calibrated_photos import CalibratedPhotos
from vomstudio.extraction.followed_trace import (
    FARTHEST,
    FollowedTrace,
    near_surface,
    plane_of,
    require_on_model,
)
from vomstudio.extraction.path_costs import OF_COLOURS
from vomstudio.extraction.path_jumps import find_jumps
from vomstudio.extraction.photo_following import PhotoFollower, PhotoPath
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.doubtful_stretches import fit_remaining_plane
from vomstudio.geology.plane_bands import SetPrior
from vomstudio.geology.profiles import DEFAULTS, Thresholds

# Below this share the line is said to be doubtful.
_AGREEING = 0.8
# A step so many times longer than the others, and than the model's resolution, leads across a gap
# that the photo does not show.
_JUMP, _JUMP_RESOLUTIONS = 10.0, 2.0


@dataclass(frozen=True, eq=False, repr=False)
class PhotoTrace(FollowedTrace):
    """Trace followed in a photo.

    Parameters
    ----------
    photo : str
    voters : tuple of str
        Names of the other photos that the trace was compared with.
    agreeing_share : float or None
        Share of the vertices visible in other photos that at least half of these confirm; None if
        no vertex is.
    pixels : (n, 2) array
        Vertices in the photo; the centre of its top-left pixel is (0.5, 0.5).
    seen, agreeing : (n,) int arrays
        Number of other photos in which each vertex is visible, and of those that confirm it.
    """

    photo: str
    voters: tuple[str, ...]
    agreeing_share: float | None
    pixels: FloatArray = field(repr=False, metadata=HIDDEN)
    seen: IntArray = field(repr=False, metadata=HIDDEN)
    agreeing: IntArray = field(repr=False, metadata=HIDDEN)


def photo_trace(
    surface: SurfaceGraph,
    photos: CalibratedPhotos,
    way_points: FloatArray,
    *,
    cost: str,
    resolution: float,
    model: str,
    frame: str,
    thresholds: Thresholds = DEFAULTS,
    priors: Sequence[SetPrior] = (),
    called: str = "",
) -> PhotoTrace:
    """Follow a contact in a photo and fit its plane.

    surface : of a model in World; resolution : of the model, m
    cost : of OF_COLOURS, or "auto" for the best of them; called : the cost by another name
    way_points : (w, 3) in World, or (w, 2) pixels of the photo
    Raises GeometryError for a way-point that is not on the model or the photo, or hidden in it;
    UsageError for a cost that photos do not have; InputError for a photo that cannot be read.
    """
    given = np.asarray(way_points, np.float64)
    follower = PhotoFollower(photos, OF_COLOURS[0] if cost == AUTO else cost)
    in_world = given.shape[1] == 3
    if in_world:
        require_on_model(surface, given, resolution)
        pixels = _seen_at(photos, given, resolution)
    else:
        pixels = given
    near = near_surface(surface)
    tried: tuple[Tried, ...] = ()
    if cost == AUTO:
        path, cost, tried = best_of(
            OF_COLOURS,
            lambda one: follower.by(one).follow(pixels),
            near.resolution_near,
            near.outcrop_normal,
            lambda one: find_jumps(
                one.points, one.costs, one.at, near.resolution_near(one.points) or 0.0
            ),
        )
    else:
        path = follower.follow(pixels)
    cost = called or cost
    marks = given if in_world else follower.thrown(pixels)
    notes = tr(
        "followed through {count} way-points by {cost} in the photo {photo}",
        count=len(given),
        cost=cost,
        photo=photos.name,
    )
    own = near.resolution_near(path.points) or 0.0
    rest = fit_remaining_plane(path.points, find_jumps(path.points, path.costs, path.at, own))
    plane, band, said = plane_of(
        path.points,
        near,
        model=model,
        frame=frame,
        thresholds=thresholds,
        notes=notes,
        priors=priors,
        rest=rest,
    )
    steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    share = _share(path)
    doubts = _doubts(path, steps, share, resolution)
    return PhotoTrace(
        points=path.points,
        length_m=float(steps.sum()),
        snap_m=float(np.linalg.norm(path.points[path.at] - marks, axis=1).max()),
        plane=plane,
        band=band,
        way_points=len(given),
        cost=cost,
        vertices=len(path.points),
        warnings=(
            *photos.warnings,
            *path.warnings,
            *said,
            *doubts,
        ),
        photo=photos.name,
        voters=path.voters,
        agreeing_share=share,
        pixels=path.pixels,
        seen=path.seen,
        agreeing=path.agreeing,
        tried=tried,
        doubtful=() if rest is None else rest.stretches,
    )


def _seen_at(photos: CalibratedPhotos, given: FloatArray, resolution: float) -> FloatArray:
    """(w, 2) pixels of way-points in World. Raises GeometryError for one that the photo does not
    show."""
    pixels = photos.views.pixels(photos.chosen, given)
    shown = photos.views.shows(photos.chosen, given, FARTHEST * resolution)
    for row in np.flatnonzero(~shown).tolist():
        raise GeometryError(Finding("path.not-shown", photo=photos.name, number=row + 1))
    return pixels


def _share(path: PhotoPath) -> float | None:
    return path.confirmed / path.judged if path.judged else None


def _doubts(
    path: PhotoPath, steps: FloatArray, share: float | None, resolution: float
) -> list[Finding]:
    said = []
    if path.missed:
        said.append(Finding("path.pixels-beside-model", count=path.missed))
    least = max(_JUMP * float(np.median(steps)), _JUMP_RESOLUTIONS * resolution)
    if jumps := int((steps > least).sum()):
        said.append(Finding("path.hidden-rock", count=jumps, gap_m=float(steps.max())))
    if share is not None and share < _AGREEING:
        said.append(Finding("path.unconfirmed", share_percent=100.0 * share))
    return said
