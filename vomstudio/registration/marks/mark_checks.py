"""Checks of marks of control points for labels, photos and pixels that do not match.

Labels may lack coordinates, photos may not belong to cameras of the model, and pixels may follow
another convention.
"""

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

PhotoMark = tuple[str, str, float, float]

_MIN_SIMILARITY = 0.6
# Maximum number of photos that are checked; those with most marks are used.
_MAX_PHOTOS = 40
# Pixels within which marks agree with each other, and with surveyed points.
_MAX_RAY_PX, _MAX_POINT_PX = 4.0, 20.0
# Minimum improvement of residuals by another pixel convention.
_MIN_IMPROVEMENT = 5.0
# Minimum redundancy; with less redundancy, a scale could fit by chance.
_MIN_REDUNDANCY = 6
_MIN_POINTS = 4
_MIN_SHARE_INSIDE = 0.9
# Natural logarithms of the size of the photos relative to the marked copies.
_LOG_SIZES = np.linspace(-3.0, 3.0, 61)
_SIZE_TOLERANCE = 0.05
# Common sizes of copies are preferred if they fit about as well as the best.
_COMMON_LOG_SIZES = [math.log(times) for times in (0.125, 0.25, 1 / 3, 0.5, 2 / 3, 0.75)]
_COMMON_LOG_SIZES += [-log_size for log_size in _COMMON_LOG_SIZES]
_COMMON_SIZE_FACTOR = 2.0


# --- names ----------------------------------------------------------------------------------------
def most_similar_name(name: str, known_names: Sequence[str]) -> str | None:
    """Return the known name that is most similar to the given name, or None.

    Parameters
    ----------
    name : str
    known_names : sequence of str
        Known names.

    Returns
    -------
    str or None
    """
    normalised_name = _normalise(name)
    matches = [
        similar_name for similar_name in known_names if _normalise(similar_name) == normalised_name
    ]
    if len(matches) == 1:
        return matches[0]
    close_matches = get_close_matches(name, known_names, 1, _MIN_SIMILARITY)
    return close_matches[0] if close_matches else None


def _normalise(name: str) -> str:
    """Normalise a name by removing case, spaces, punctuation and leading zeros."""
    compact_name = re.sub(r"[\W_]+", "", name.casefold())
    return re.sub(r"0*(\d+)", lambda digits: digits.group(1), compact_name)


def _suggest_names(names: Sequence[str], known_names: Sequence[str]) -> list[str]:
    """Return the names, each with the most similar known name."""
    hints = []
    for name in names:
        similar_name = most_similar_name(name, known_names)
        hints.append(
            name if similar_name is None else tr("{name} ({near}?)", name=name, near=similar_name)
        )
    return hints


def name_findings(
    points: Sequence[str], marks: Sequence[PhotoMark], views: Mapping[str, View]
) -> list[Finding]:
    """Return findings about marks and points that do not match.

    The findings concern photos that do not belong to a camera, labels without coordinates, and
    points marked in fewer than two photos.

    Parameters
    ----------
    points : sequence of str
        Labels of the points that have coordinates.
    marks : sequence of PhotoMark
    views : mapping
        View of each photo, by its name.

    Returns
    -------
    list of Finding
    """
    find = create_photo_finder(list(views))
    unknown_photos = sorted({photo for _, photo, _, _ in marks if find(photo) is None})
    unknown_labels = sorted({label for label, *_ in marks} - set(points))
    photos_by_label = group_photos_by_label(points, marks, views)
    labels_with_few_marks = [label for label, photos in photos_by_label.items() if len(photos) < 2]
    findings = []
    if unknown_photos:
        findings.append(
            Finding(
                "control.photos-without-pose", photos=_suggest_names(unknown_photos, list(views))
            )
        )
    if unknown_labels:
        findings.append(
            Finding(
                "control.without-coordinates", labels=_suggest_names(unknown_labels, list(points))
            )
        )
    if labels_with_few_marks:
        findings.append(Finding("control.few-marks", labels=labels_with_few_marks))
    return findings


def group_photos_by_label(
    points: Sequence[str], marks: Sequence[PhotoMark], views: Mapping[str, View]
) -> dict[str, set[str]]:
    """Return the photos of the model in which each label is marked.

    Parameters
    ----------
    points : sequence of str
        Labels.
    marks : sequence of PhotoMark
    views : mapping
        View of each photo, by its name.

    Returns
    -------
    dict
        Names of the photos, by label.
    """
    find = create_photo_finder(list(views))
    photos_by_label: dict[str, set[str]] = {label: set() for label in points}
    for label, photo, _, _ in marks:
        name = find(photo)
        if name is not None and label in photos_by_label:
            photos_by_label[label].add(name)
    return photos_by_label


def create_photo_finder(names: Sequence[str]) -> Callable[[str], str | None]:
    """Return a function that finds the name of a photo.

    Parameters
    ----------
    names : sequence of str
        Names of the photos.

    Returns
    -------
    callable
        Returns the name that a text refers to, or None.
    """
    find = photo_finder(names)

    def find_name(photo: str) -> str | None:
        photo_index = find(photo.replace("\\", "/"))
        return None if photo_index is None else names[photo_index]

    return find_name


# --- pixel conventions ----------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class _PhotoMarks:
    """All marks of one photo: the rows of their points, and their pixels."""

    view: View
    rows: IntArray
    pixels: FloatArray


@dataclass(frozen=True)
class _PixelConvention:
    """Alternative pixel convention.

    `turn` (2, 2) is the rotation of (column, row). `start` is the origin of the convention in the
    photo, as shares of the photo size.
    """

    words: str
    turn: tuple[tuple[int, int], tuple[int, int]]
    start: tuple[float, float] = (0.0, 0.0)

    def __call__(self, pixels: FloatArray, view: View) -> FloatArray:
        size = np.array([view.intrinsics.width, view.intrinsics.height], np.float64)
        return np.asarray(pixels @ np.array(self.turn, np.float64).T + size * self.start)


def _pixel_conventions() -> Iterator[_PixelConvention]:
    """Yield all conventions with the origin at a corner or the centre of a photo."""
    yield _PixelConvention(tr("column and row are swapped"), ((0, 1), (1, 0)))
    yield _PixelConvention(tr("rows are counted from the lower edge"), ((1, 0), (0, -1)), (0, 1))
    yield _PixelConvention(tr("columns are counted from the right edge"), ((-1, 0), (0, 1)), (1, 0))
    for angle, turn, start in (
        (180, ((-1, 0), (0, -1)), (1, 1)),
        (90, ((0, 1), (-1, 0)), (0, 1)),
        (270, ((0, -1), (1, 0)), (1, 0)),
    ):
        turned_text = tr("the photos were rotated by {angle}° when marked", angle=angle)
        yield _PixelConvention(turned_text, turn, start)
    exchanged_text = tr("column and row are swapped and counted from the lower right corner")
    yield _PixelConvention(exchanged_text, ((0, -1), (-1, 0)), (1, 1))
    description = tr("pixels are counted from the photo centre, with rows increasing upward")
    yield _PixelConvention(description, ((1, 0), (0, -1)), (0.5, 0.5))
    description = tr("pixels are counted from the photo centre, with rows increasing downward")
    yield _PixelConvention(description, ((1, 0), (0, 1)), (0.5, 0.5))


def require_photo_pixels(
    marks: Sequence[PhotoMark], views: Mapping[str, View], world: Mapping[str, Sequence[float]]
) -> None:
    """Check that the marks are given in pixels of the photos.

    Parameters
    ----------
    marks : sequence of (label, photo, x, y)
    views : mapping
    world : mapping
        Coordinates of the points, by label.

    Raises
    ------
    GeometryError
        If the rays of the marks intersect only for another photo size or pixel convention.
    """
    labels, photos = _group_by_photo(marks, views)
    counts = np.bincount(
        np.concatenate([photo.rows for photo in photos]) if photos else [0], minlength=1
    )
    if int(np.maximum(2 * counts - 3, 0).sum()) < _MIN_REDUNDANCY:
        return
    targets = np.array([world.get(label, (math.nan,) * 3) for label in labels], np.float64)
    ray_px, point_px = _median_residuals(photos, targets, lambda pixels, _: pixels)
    if ray_px <= _MAX_RAY_PX and not point_px > _MAX_POINT_PX:
        return
    best_conversion: tuple[float, float, str] | None = None
    for description, size, change in _conversions(photos, targets):
        if _share_inside(photos, change) < _MIN_SHARE_INSIDE:
            continue
        # Convert to pixels of the marked copies.
        changed_ray_px, changed_point_px = (
            mark_misfit / size for mark_misfit in _median_residuals(photos, targets, change)
        )
        has_improved_rays = (
            changed_ray_px * _MIN_IMPROVEMENT < ray_px and not changed_point_px * 2.0 > point_px
        )
        has_improved_points = (
            changed_ray_px <= max(ray_px, _MAX_RAY_PX)
            and changed_point_px * _MIN_IMPROVEMENT < point_px
        )
        if (has_improved_rays or has_improved_points) and (
            best_conversion is None
            or changed_ray_px + np.nan_to_num(changed_point_px) < best_conversion[0]
        ):
            best_conversion = (
                changed_ray_px + float(np.nan_to_num(changed_point_px)),
                max(changed_ray_px, np.nan_to_num(changed_point_px)),
                description,
            )
    if best_conversion is not None:
        raise GeometryError(
            Finding(
                "control.other-pixels",
                miss_px=max(ray_px, float(np.nan_to_num(point_px))),
                better_px=best_conversion[1],
                change=best_conversion[2],
            )
        )


def _group_by_photo(
    marks: Sequence[PhotoMark], views: Mapping[str, View]
) -> tuple[list[str], list[_PhotoMarks]]:
    find = create_photo_finder(list(views))
    row_by_label: dict[str, int] = {}
    marks_by_photo: dict[str, tuple[list[int], list[tuple[float, float]]]] = {}
    for label, photo, x, y in marks:
        name = find(photo)
        if name is not None:
            rows, pixels = marks_by_photo.setdefault(name, ([], []))
            rows.append(row_by_label.setdefault(label, len(row_by_label)))
            pixels.append((x, y))
    photos_with_most_marks = sorted(marks_by_photo, key=lambda name: -len(marks_by_photo[name][0]))[
        :_MAX_PHOTOS
    ]
    return list(row_by_label), [
        _PhotoMarks(
            views[name], np.array(marks_by_photo[name][0]), np.array(marks_by_photo[name][1])
        )
        for name in photos_with_most_marks
    ]


def _conversions(
    photos: Sequence[_PhotoMarks], targets: FloatArray
) -> Iterator[tuple[str, float, Callable[[FloatArray, View], FloatArray]]]:
    """Yield alternative pixel conventions.

    Each consists of a description, the size of the photos relative to the copies in which the
    points were marked, and a conversion.
    """
    for convention in _pixel_conventions():
        yield convention.words, 1.0, convention

    def change(log_size: float) -> Callable[[FloatArray, View], FloatArray]:
        return lambda pixels, _: pixels * math.exp(log_size)

    def total_residual(log_size: float) -> float:
        if _share_inside(photos, change(log_size)) < _MIN_SHARE_INSIDE:
            return math.inf
        ray_px, point_px = _median_residuals(photos, targets, change(log_size))
        return (ray_px + float(np.nan_to_num(point_px))) * math.exp(-log_size)

    step = float(_LOG_SIZES[1] - _LOG_SIZES[0])
    distances = [total_residual(float(value)) for value in _LOG_SIZES]
    if not np.isfinite(distances).any():
        return
    best_log_size = float(_LOG_SIZES[int(np.argmin(distances))])
    while step > 1e-3:
        step /= 2.0
        best_log_size = min(
            (best_log_size, best_log_size - step, best_log_size + step), key=total_residual
        )
    if abs(best_log_size) < _SIZE_TOLERANCE:
        return
    common_log_size = min(_COMMON_LOG_SIZES, key=lambda value: abs(value - best_log_size))
    if abs(common_log_size - best_log_size) < _SIZE_TOLERANCE and total_residual(
        common_log_size
    ) <= _COMMON_SIZE_FACTOR * total_residual(best_log_size):
        best_log_size = common_log_size
    lens, size = photos[0].view.intrinsics, math.exp(best_log_size)
    text = tr(
        "they were made in copies of {width:.0f} x {height:.0f} pixels instead of {w} x {h}, so"
        " columns and rows must be multiplied by {size:.3g}",
        width=lens.width / size,
        height=lens.height / size,
        w=lens.width,
        h=lens.height,
        size=size,
    )
    yield text, size, change(best_log_size)


def _share_inside(
    photos: Sequence[_PhotoMarks], change: Callable[[FloatArray, View], FloatArray]
) -> float:
    is_inside = [photo.view.contains(change(photo.pixels, photo.view)) for photo in photos]
    return float(np.concatenate(is_inside).mean())


def _median_residuals(
    photos: Sequence[_PhotoMarks],
    targets: FloatArray,
    change: Callable[[FloatArray, View], FloatArray],
) -> tuple[float, float]:
    """Return the median residuals of marks from their intersections and from surveyed points.

    Parameters
    ----------
    photos : sequence of _PhotoMarks
    targets : (n, 3) array
        Surveyed points in the World frame, NaN if unknown.
    change : callable
        Conversion of pixels.

    Returns
    -------
    (float, float)
        Median residuals, pixels. The second is NaN if there are too few surveyed points.
    """
    n = len(targets)
    normal, right_hand_sides, count = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n)
    converted_pixels = [change(photo.pixels, photo.view) for photo in photos]
    for photo, pixels in zip(photos, converted_pixels, strict=True):
        rays = photo.view.rays(pixels)
        projector = np.eye(3) - rays[:, :, None] * rays[:, None, :]
        np.add.at(normal, photo.rows, projector)
        np.add.at(right_hand_sides, photo.rows, projector @ photo.view.centre)
        np.add.at(count, photo.rows, 1.0)
    places = np.full((n, 3), np.nan)
    for row in np.flatnonzero(count >= 2):
        if np.isfinite(normal[row]).all() and np.linalg.cond(normal[row]) < 1e8:
            places[row] = np.linalg.solve(normal[row], right_hand_sides[row])
    ray_px = _median_residual(photos, converted_pixels, places)
    known_indices = np.flatnonzero(
        np.isfinite(places).all(axis=1) & np.isfinite(targets).all(axis=1)
    )
    if len(known_indices) < _MIN_POINTS:
        return ray_px, math.nan
    try:
        fit = fit_similarity(places[known_indices], targets[known_indices])
    except GeometryError:
        return ray_px, math.nan
    projected_points = np.full((n, 3), np.nan)
    projected_points[known_indices] = fit.inverse(targets[known_indices])
    return ray_px, _median_residual(photos, converted_pixels, projected_points)


def _median_residual(
    photos: Sequence[_PhotoMarks], pixel_arrays: Sequence[FloatArray], positions: FloatArray
) -> float:
    """Return the median residual of marks of known points; infinite behind a camera."""
    distances = []
    for photo, pixels in zip(photos, pixel_arrays, strict=True):
        is_known = np.isfinite(positions[photo.rows]).all(axis=1)
        if is_known.any():
            offset = photo.view.project(positions[photo.rows][is_known]) - pixels[is_known]
            distances.append(np.nan_to_num(np.linalg.norm(offset, axis=1), nan=np.inf))
    return float(np.median(np.concatenate(distances))) if distances else math.inf
