"""What control points and their marks can do for a set of photos, before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from vomstudio.errors import GeometryError
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.photogrammetry.align.matching import PhotoLike
from vomstudio.photogrammetry.place.control import WANTED_PHOTOS, WANTED_POINTS, require_width
from vomstudio.survey.check_results import named

LEAST_POINTS, LEAST_PHOTOS = 3, 2
_FAR_M = 5000.0
"""Points farther than this from the cameras' GPS are in another CRS than was said."""


@dataclass(frozen=True)
class PointCheck:
    """use : "control" or "check"; photos : of the set in which it is marked"""

    label: str
    use: str
    photos: int

    @property
    def usable(self) -> bool:
        return self.photos >= LEAST_PHOTOS

    @property
    def quality(self) -> str:
        """ "good", "doubtful" or "poor", by the number of photos."""
        return "good" if self.photos >= WANTED_PHOTOS else "doubtful" if self.usable else "poor"


@dataclass(frozen=True)
class ControlCheck:
    """problem : why the points cannot place a model, else None; warnings : sentences.
    crs : "EPSG:n", as asked for, stated or guessed; None for a local frame
    crs_reason : where it is from
    """

    points: tuple[PointCheck, ...]
    crs: str | None
    crs_reason: str
    problem: str | None
    warnings: tuple[str, ...]

    def _used(self, use: str) -> list[PointCheck]:
        return [point for point in self.points if point.use == use and point.usable]

    @property
    def summary(self) -> str:
        control, check = len(self._used("control")), len(self._used("check"))
        seen = [point.photos for point in self.points if point.usable]
        span = " to ".join(str(n) for n in sorted({min(seen), max(seen)})) if seen else ""
        each = f", each in {span} photos" if seen else ""
        return (
            f"{control} control point{'s' * (control != 1)} and {check} check "
            f"point{'s' * (check != 1)} can be used{each}"
        )

    def as_dict(self) -> dict[str, Any]:
        return {
            "points": [{**asdict(p), "quality": p.quality} for p in self.points],
            "crs": self.crs,
            "crs_reason": self.crs_reason,
            "summary": self.summary,
            "problem": self.problem,
            "warnings": list(self.warnings),
        }


def check_control(
    control: Sequence[ControlPoint],
    marks: Sequence[Mark],
    photos: Sequence[PhotoLike],
    crs: str | None = None,
    crs_reason: str = "as chosen",
) -> ControlCheck:
    """crs : of the points, where it is known; else the UTM zone of the photos' GPS is proposed
    where the points are near it."""
    find = photo_finder([photo.name for photo in photos])
    seen: dict[str, set[int]] = {point.label: set() for point in control}
    no_photo: dict[str, None] = {}
    others: dict[str, set[int]] = {}
    for mark in marks:
        number = find(mark.photo)
        if number is None:
            no_photo.setdefault(mark.photo)
        if number is not None:
            (seen if mark.label in seen else others).setdefault(mark.label, set()).add(number)
    points = tuple(
        PointCheck(p.label, "check" if p.check else "control", len(seen[p.label])) for p in control
    )
    code, reason, strange = _crs(control, photos, crs, crs_reason)
    return ControlCheck(
        points,
        code,
        reason,
        _problem(control, points, no_photo, sorted(others)),
        (*strange, *_warnings(points, no_photo, others)),
    )


def _problem(
    control: Sequence[ControlPoint],
    points: Sequence[PointCheck],
    no_photo: dict[str, None],
    no_point: Sequence[str],
) -> str | None:
    places = [
        p.position
        for p, facts in zip(control, points, strict=True)
        if facts.usable and facts.use == "control"
    ]
    if len(places) < LEAST_POINTS:
        why = ""
        if no_photo:
            why = f"; marks name photos that are not in the folder: {named(sorted(no_photo))}"
        elif no_point:
            why = f"; marks name points that the control does not have: {named(sorted(no_point))}"
        return (
            f"{LEAST_POINTS} control points, each marked in {LEAST_PHOTOS} or more of the photos, "
            f"are needed, and there {'is' if len(places) == 1 else 'are'} "
            f"{len(places) or 'none'}{why}"
        )
    try:
        local = np.array(places, np.float64)
        require_width(local - local.mean(axis=0))
    except GeometryError as error:
        return error.message
    return None


def _warnings(
    points: Sequence[PointCheck], no_photo: dict[str, None], others: dict[str, set[int]]
) -> Iterator[str]:
    used = [p for p in points if p.usable and p.use == "control"]
    unseen = [p.label for p in points if not p.usable]
    few = [p.label for p in used if p.photos < WANTED_PHOTOS]
    if LEAST_POINTS <= len(used) < WANTED_POINTS:
        yield f"{len(used)} control points leave nothing over to find a mistake with"
    if not any(p.usable and p.use == "check" for p in points):
        yield "no check points judge the model independently"
    if unseen:
        yield f"marked in fewer than {LEAST_PHOTOS} photos, so of no use: {named(sorted(unseen))}"
    if few:
        yield f"marked in fewer than {WANTED_PHOTOS} photos: {named(sorted(few))}"
    ties = sorted(label for label, rows in others.items() if len(rows) >= LEAST_PHOTOS)
    useless = sorted(set(others) - set(ties))
    if ties:
        yield f"marked without coordinates, so they tie photos together only: {named(ties)}"
    if useless:
        yield f"marked without coordinates, and in one photo only, so of no use: {named(useless)}"
    if no_photo:
        yield f"marks in {named(sorted(no_photo))} are not used: no such photo in the folder"


def _crs(
    control: Sequence[ControlPoint],
    photos: Sequence[PhotoLike],
    crs: str | None,
    reason: str,
) -> tuple[str | None, str, list[str]]:
    """The CRS, where it is from, and what is strange about it."""
    from vomstudio.photogrammetry.place.georeference import crs_of, has_position, world_positions

    placed = [photo for photo in photos if has_position(photo)]
    if not placed or not control:
        return crs, reason if crs else "none is stated: a local frame in metres", []
    guess = crs or crs_of(placed, None)
    try:
        cameras = np.median(world_positions(placed, guess), axis=0)
    except GeometryError as error:
        return crs, reason, [error.message]
    middle = np.median([p.position for p in control], axis=0)
    away = math.dist(cameras[:2], middle[:2])
    if crs is None:
        if away > _FAR_M:
            return None, "none is stated: a local frame in metres", []
        return guess, f"proposed: in it the points lie {away:.0f} m from the photos' GPS", []
    if away > _FAR_M:
        return (
            crs,
            reason,
            [
                f"in {crs} the control points lie {away / 1000:,.0f} km from the photos' GPS: is "
                "it the right one, and are x and y east and north?"
            ],
        )
    return crs, reason, []
