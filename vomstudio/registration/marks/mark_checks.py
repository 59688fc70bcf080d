"""Marks of control points in photos that do not meet what they belong to: labels without
coordinates, photos that are no cameras of the model, and pixels that are counted otherwise."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import View
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.registration.similarity import fit_similarity

Marked = tuple[str, str, float, float]

_ALIKE = 0.6
# Photos that are looked at, those with most marks.
_MOST_PHOTOS = 40
# Pixels: rays of hand-set marks that miss by less agree, and surveyed points that are seen so near.
_AGREE_PX, _SEEN_PX = 4.0, 20.0
# Counted otherwise, they must meet so many times as well.
_FAR_BETTER = 5.0
# Observations beyond those that place the points: of fewer a scale could please all by chance.
_FEWEST_LEFT = 6
_FEWEST_POINTS = 4
_INSIDE = 0.9
# Natural logarithms of how many times as large the photos may be as those that were marked.
_SCALES = np.linspace(-3.0, 3.0, 61)
_SAME_SIZE = 0.05
# Sizes that copies usually have are taken where they fit about as well as the best.
_USUAL_SIZES = [math.log(times) for times in (0.125, 0.25, 1 / 3, 0.5, 2 / 3, 0.75)]
_USUAL_SIZES += [-logarithm for logarithm in _USUAL_SIZES]
_AS_GOOD = 2.0


# --- names ----------------------------------------------------------------------------------------
def nearest(name: str, known: Sequence[str]) -> str | None:
    """The one of the known names that is most like this one, None where none is."""
    wanted = _plain(name)
    same = [other for other in known if _plain(other) == wanted]
    if len(same) == 1:
        return same[0]
    close = get_close_matches(name, known, 1, _ALIKE)
    return close[0] if close else None


def _plain(name: str) -> str:
    """Without case, spaces, punctuation and leading zeros."""
    bare = re.sub(r"[\W_]+", "", name.casefold())
    return re.sub(r"0*(\d+)", lambda digits: digits.group(1), bare)


def _with_nearest(names: Sequence[str], known: Sequence[str]) -> list[str]:
    """Return the names, each with the known one that it is most like."""
    hints = []
    for name in names:
        near = nearest(name, known)
        hints.append(name if near is None else tr("{name} ({near}?)", name=name, near=near))
    return hints


def name_findings(
    points: Sequence[str], marks: Sequence[Marked], views: Mapping[str, View]
) -> list[Finding]:
    """What keeps marks and points apart: photos that are no cameras, labels that have no
    coordinates, points in fewer than two photos.

    points : labels that have coordinates
    """
    find = finder(list(views))
    strange = sorted({photo for _, photo, _, _ in marks if find(photo) is None})
    unknown = sorted({label for label, *_ in marks} - set(points))
    seen = photos_of(points, marks, views)
    few = [label for label, photos in seen.items() if len(photos) < 2]
    findings = []
    if strange:
        findings.append(
            Finding("control.photos-without-pose", photos=_with_nearest(strange, list(views)))
        )
    if unknown:
        findings.append(
            Finding("control.without-coordinates", labels=_with_nearest(unknown, list(points)))
        )
    if few:
        findings.append(Finding("control.few-marks", labels=few))
    return findings


def photos_of(
    points: Sequence[str], marks: Sequence[Marked], views: Mapping[str, View]
) -> dict[str, set[str]]:
    """Of each label in `points` the photos of the model in which it is marked."""
    find = finder(list(views))
    seen: dict[str, set[str]] = {label: set() for label in points}
    for label, photo, _, _ in marks:
        name = find(photo)
        if name is not None and label in seen:
            seen[label].add(name)
    return seen


def finder(names: Sequence[str]) -> Callable[[str], str | None]:
    """What finds the one of these names that a photo is meant by."""
    find = photo_finder(names)

    def found(photo: str) -> str | None:
        number = find(photo.replace("\\", "/"))
        return None if number is None else names[number]

    return found


# --- pixels that are counted otherwise ------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class _Seen:
    """All marks of one photo: rows of their points, and pixels."""

    view: View
    rows: IntArray
    pixels: FloatArray


@dataclass(frozen=True)
class _Otherwise:
    """turn : (2, 2), of (column, row); start : where their beginning lies in the photo, as shares
    of its size"""

    words: str
    turn: tuple[tuple[int, int], tuple[int, int]]
    start: tuple[float, float] = (0.0, 0.0)

    def __call__(self, pixels: FloatArray, view: View) -> FloatArray:
        size = np.array([view.intrinsics.width, view.intrinsics.height], np.float64)
        return np.asarray(pixels @ np.array(self.turn, np.float64).T + size * self.start)


def _counted_otherwise() -> Iterator[_Otherwise]:
    """All ways in which a corner, or the middle, of a photo is taken for the beginning."""
    yield _Otherwise(tr("column and row are exchanged"), ((0, 1), (1, 0)))
    yield _Otherwise(tr("rows are counted from the lower edge"), ((1, 0), (0, -1)), (0, 1))
    yield _Otherwise(tr("columns are counted from the right edge"), ((-1, 0), (0, 1)), (1, 0))
    for angle, turn, start in (
        (180, ((-1, 0), (0, -1)), (1, 1)),
        (90, ((0, 1), (-1, 0)), (0, 1)),
        (270, ((0, -1), (1, 0)), (1, 0)),
    ):
        turned = tr("the photos were turned by {angle}° when they were marked", angle=angle)
        yield _Otherwise(turned, turn, start)
    exchanged = tr("column and row are exchanged and counted from the lower right corner")
    yield _Otherwise(exchanged, ((0, -1), (-1, 0)), (1, 1))
    middle = tr("they are counted from the middle of the photo, with rows upward")
    yield _Otherwise(middle, ((1, 0), (0, -1)), (0.5, 0.5))
    middle = tr("they are counted from the middle of the photo, with rows downward")
    yield _Otherwise(middle, ((1, 0), (0, 1)), (0.5, 0.5))


def require_pixels_of_photos(
    marks: Sequence[Marked], views: Mapping[str, View], world: Mapping[str, Sequence[float]]
) -> None:
    """Raises GeometryError for marks that do not meet as they are, and do where they were made in
    copies of another size, or where rows and columns are counted otherwise.

    world : coordinates of the points, by their labels
    """
    labels, photos = _by_photo(marks, views)
    counts = np.bincount(np.concatenate([p.rows for p in photos]) if photos else [0], minlength=1)
    if int(np.maximum(2 * counts - 3, 0).sum()) < _FEWEST_LEFT:
        return
    targets = np.array([world.get(label, (math.nan,) * 3) for label in labels], np.float64)
    own, seen = _misses(photos, targets, lambda pixels, _: pixels)
    if own <= _AGREE_PX and not seen > _SEEN_PX:
        return
    best: tuple[float, float, str] | None = None
    for words, size, change in _ways(photos, targets):
        if _share_inside(photos, change) < _INSIDE:
            continue
        # In pixels of the photos that were marked.
        own_, seen_ = (miss / size for miss in _misses(photos, targets, change))
        better = own_ * _FAR_BETTER < own and not seen_ * 2.0 > seen
        places = own_ <= max(own, _AGREE_PX) and seen_ * _FAR_BETTER < seen
        if (better or places) and (best is None or own_ + np.nan_to_num(seen_) < best[0]):
            best = own_ + float(np.nan_to_num(seen_)), max(own_, np.nan_to_num(seen_)), words
    if best is not None:
        raise GeometryError(
            Finding(
                "control.other-pixels",
                miss_px=max(own, float(np.nan_to_num(seen))),
                better_px=best[1],
                change=best[2],
            )
        )


def _by_photo(marks: Sequence[Marked], views: Mapping[str, View]) -> tuple[list[str], list[_Seen]]:
    find = finder(list(views))
    numbers: dict[str, int] = {}
    of_photo: dict[str, tuple[list[int], list[tuple[float, float]]]] = {}
    for label, photo, x, y in marks:
        name = find(photo)
        if name is not None:
            rows, pixels = of_photo.setdefault(name, ([], []))
            rows.append(numbers.setdefault(label, len(numbers)))
            pixels.append((x, y))
    most = sorted(of_photo, key=lambda name: -len(of_photo[name][0]))[:_MOST_PHOTOS]
    return list(numbers), [
        _Seen(views[name], np.array(of_photo[name][0]), np.array(of_photo[name][1]))
        for name in most
    ]


def _ways(
    photos: Sequence[_Seen], targets: FloatArray
) -> Iterator[tuple[str, float, Callable[[FloatArray, View], FloatArray]]]:
    """Words, how many times as large the photos are as those that were marked, and the change."""
    for way in _counted_otherwise():
        yield way.words, 1.0, way

    def change(logarithm: float) -> Callable[[FloatArray, View], FloatArray]:
        return lambda pixels, _: pixels * math.exp(logarithm)

    def miss(logarithm: float) -> float:
        if _share_inside(photos, change(logarithm)) < _INSIDE:
            return math.inf
        own, seen = _misses(photos, targets, change(logarithm))
        return (own + float(np.nan_to_num(seen))) * math.exp(-logarithm)

    step = float(_SCALES[1] - _SCALES[0])
    misses = [miss(float(value)) for value in _SCALES]
    if not np.isfinite(misses).any():
        return
    best = float(_SCALES[int(np.argmin(misses))])
    while step > 1e-3:
        step /= 2.0
        best = min((best, best - step, best + step), key=miss)
    if abs(best) < _SAME_SIZE:
        return
    usual = min(_USUAL_SIZES, key=lambda value: abs(value - best))
    if abs(usual - best) < _SAME_SIZE and miss(usual) <= _AS_GOOD * miss(best):
        best = usual
    lens, size = photos[0].view.intrinsics, math.exp(best)
    words = tr(
        "they were made in copies of {width:.0f} x {height:.0f} pixels, while the photos have "
        "{w} x {h}: columns and rows are to be multiplied by {size:.3g}",
        width=lens.width / size,
        height=lens.height / size,
        w=lens.width,
        h=lens.height,
        size=size,
    )
    yield words, size, change(best)


def _share_inside(
    photos: Sequence[_Seen], change: Callable[[FloatArray, View], FloatArray]
) -> float:
    inside = [photo.view.contains(change(photo.pixels, photo.view)) for photo in photos]
    return float(np.concatenate(inside).mean())


def _misses(
    photos: Sequence[_Seen], targets: FloatArray, change: Callable[[FloatArray, View], FloatArray]
) -> tuple[float, float]:
    """Pixels (medians) by which marks miss the place in which their rays meet, and the surveyed
    points; the latter NaN where these are too few to tell.

    targets : (n, 3) World, NaN where not known
    """
    n = len(targets)
    normal, right, count = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n)
    there = [change(photo.pixels, photo.view) for photo in photos]
    for photo, pixels in zip(photos, there, strict=True):
        rays = photo.view.rays(pixels)
        across = np.eye(3) - rays[:, :, None] * rays[:, None, :]
        np.add.at(normal, photo.rows, across)
        np.add.at(right, photo.rows, across @ photo.view.centre)
        np.add.at(count, photo.rows, 1.0)
    places = np.full((n, 3), np.nan)
    for row in np.flatnonzero(count >= 2):
        if np.isfinite(normal[row]).all() and np.linalg.cond(normal[row]) < 1e8:
            places[row] = np.linalg.solve(normal[row], right[row])
    own = _median_miss(photos, there, places)
    known = np.flatnonzero(np.isfinite(places).all(axis=1) & np.isfinite(targets).all(axis=1))
    if len(known) < _FEWEST_POINTS:
        return own, math.nan
    try:
        fit = fit_similarity(places[known], targets[known])
    except GeometryError:
        return own, math.nan
    back = np.full((n, 3), np.nan)
    back[known] = fit.inverse(targets[known])
    return own, _median_miss(photos, there, back)


def _median_miss(photos: Sequence[_Seen], there: Sequence[FloatArray], places: FloatArray) -> float:
    """Of all marks whose place is known; infinite behind a camera."""
    found = []
    for photo, pixels in zip(photos, there, strict=True):
        known = np.isfinite(places[photo.rows]).all(axis=1)
        if known.any():
            off = photo.view.project(places[photo.rows][known]) - pixels[known]
            found.append(np.nan_to_num(np.linalg.norm(off, axis=1), nan=np.inf))
    return float(np.median(np.concatenate(found))) if found else math.inf
