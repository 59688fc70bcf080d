"""Edits of what models made of photos rest on. Pure, as `project.edits` are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.registrations import Registration
from vomstudio.project.edit import Edit, change
from vomstudio.project.edits import set_registration
from vomstudio.project.records import (
    Asset,
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    Reconstruction,
    Record,
)

Records = Mapping[str, Record]
After = dict[str, Record | None]
Pixel = tuple[float, float]


@dataclass(frozen=True)
class PointState:
    """A marked point without its id: as a table or a window holds it. Fields as in MarkedPoint."""

    label: str
    position: Point | None = None
    sigma_m: float | None = None
    check: bool = False


Marks = Mapping[tuple[str, str], Pixel]
"""(label, photo) -> pixel."""


def points_of(records: Records, photo_set_id: str) -> list[MarkedPoint]:
    return [
        r for r in records.values() if isinstance(r, MarkedPoint) and r.photo_set_id == photo_set_id
    ]


def marks_of(records: Records, photo_set_id: str) -> list[tuple[MarkedPoint, ImageMark]]:
    """The marks of a set of photos, each with its point."""
    points = {p.id: p for p in points_of(records, photo_set_id)}
    return [
        (points[r.point_id], r)
        for r in records.values()
        if isinstance(r, ImageMark) and r.point_id in points
    ]


def masks_of(records: Records, photo_set_id: str) -> dict[str, Mask]:
    """By photo."""
    return {
        r.photo: r
        for r in records.values()
        if isinstance(r, Mask) and r.photo_set_id == photo_set_id
    }


def add_photo_set(
    records: Records,
    photo_set: PhotoSet,
    points: Sequence[PointState] = (),
    marks: Marks | None = None,
    masks: Mapping[str, Asset] | None = None,
) -> Edit:
    """A folder of photos, with what lay beside them."""
    if photo_set.id in records:
        raise DocumentError(Finding("record.exists", name=photo_set.name))
    after: After = {photo_set.id: photo_set}
    after |= _points_after(records, photo_set.id, points, marks or {})
    after |= _masks_after(records, photo_set.id, masks or {})
    return change(records, f"Add the photos {photo_set.name}", after)


def take_in(
    records: Records,
    photo_set_id: str,
    points: Sequence[PointState],
    marks: Marks,
    masks: Mapping[str, Asset | None],
    crs: str | None = None,
) -> Edit:
    """What lies beside the photos now, in place of the points and masks that are here."""
    photo_set = _set(records, photo_set_id)
    known = photo_set.crs if crs is None else crs
    after: After = {photo_set_id: replace(photo_set, crs=known)}
    after |= _points_after(records, photo_set_id, points, marks)
    after |= _masks_after(records, photo_set_id, masks)
    return change(records, f"Take in what lies beside the photos {photo_set.name}", after)


def set_points(
    records: Records,
    photo_set_id: str,
    points: Sequence[PointState],
    marks: Marks,
    label: str,
    *,
    crs: str | None = None,
) -> Edit:
    """Give a set of photos these points and marks; what is as it was is not touched. A point that
    has another label, and the marks of the old one, is the same point."""
    photo_set = _set(records, photo_set_id)
    after = _points_after(records, photo_set_id, points, marks)
    if crs is not None and crs != photo_set.crs:
        after[photo_set_id] = replace(photo_set, crs=crs)
    return change(records, label, after)


def set_masks(
    records: Records, photo_set_id: str, masks: Mapping[str, Asset | None], label: str
) -> Edit:
    """Give photos other masks; None for none."""
    _set(records, photo_set_id)
    return change(records, label, _masks_after(records, photo_set_id, masks))


def locate_photos(records: Records, photo_set_id: str, path: str) -> Edit:
    photo_set = _set(records, photo_set_id)
    return change(
        records,
        f"Locate the photos {photo_set.name}",
        {photo_set_id: replace(photo_set, path=path)},
    )


def add_reconstruction(
    records: Records, reconstruction: Reconstruction, registration: Registration
) -> Edit:
    """What a run has made of a set of photos, in place of an earlier run in the same folder."""
    _set(records, reconstruction.photo_set_id)
    after: After = {reconstruction.id: reconstruction}
    after |= set_registration(records, registration).after
    for other in records.values():
        if (
            isinstance(other, Reconstruction)
            and other.folder == reconstruction.folder
            and other.id != reconstruction.id
        ):
            after[other.id] = None
    return change(records, f"Make a model of {reconstruction.name}", after)


def reconstruction_in(records: Records, folder: str) -> Reconstruction | None:
    """The one whose files are in this folder."""
    return next(
        (r for r in records.values() if isinstance(r, Reconstruction) and r.folder == folder), None
    )


def registration_by(records: Records, reconstruction_id: str) -> Registration | None:
    """The registration that came with a reconstruction."""
    return next(
        (
            r
            for r in records.values()
            if isinstance(r, Registration) and r.reconstruction_id == reconstruction_id
        ),
        None,
    )


def _points_after(
    records: Records, photo_set_id: str, points: Sequence[PointState], marks: Marks
) -> After:
    old = {p.label: p for p in points_of(records, photo_set_id)}
    states = {state.label: state for state in points}
    for label, _ in marks:
        states.setdefault(label, PointState(label))
    ids = {label: old[label].id for label in states if label in old}
    old_marks = {(p.label, m.photo): m for p, m in marks_of(records, photo_set_id)}
    _renamed(ids, old, states, old_marks, marks)
    after: After = {}
    for label, state in states.items():
        id_ = ids.setdefault(label, new_id("point"))
        made = MarkedPoint(id_, photo_set_id, label, state.position, state.sigma_m, state.check)
        if records.get(id_) != made:
            after[id_] = made
    after |= {p.id: None for p in old.values() if p.id not in ids.values()}
    by_point = {(m.point_id, m.photo): m for m in old_marks.values()}
    kept = set()
    for (label, photo), (x, y) in marks.items():
        before = by_point.get((ids[label], photo))
        id_ = new_id("mark") if before is None else before.id
        kept.add(id_)
        mark = ImageMark(id_, ids[label], photo, x, y)
        if before != mark:
            after[id_] = mark
    after |= {m.id: None for m in by_point.values() if m.id not in kept}
    return after


def _renamed(
    ids: dict[str, str],
    old: Mapping[str, MarkedPoint],
    states: Mapping[str, PointState],
    old_marks: Marks | Mapping[tuple[str, str], ImageMark],
    marks: Marks,
) -> None:
    """Gives a label that is new the id of the one that is gone, where one came for one."""
    gone = [label for label in old if label not in states]
    new = [label for label in states if label not in old]
    if len(gone) == len(new) == 1:
        before = {photo for label, photo in old_marks if label == gone[0]}
        now = {photo for label, photo in marks if label == new[0]}
        if before == now:
            ids[new[0]] = old[gone[0]].id


def _masks_after(records: Records, photo_set_id: str, masks: Mapping[str, Asset | None]) -> After:
    old = masks_of(records, photo_set_id)
    after: After = {}
    for photo, file in masks.items():
        before = old.get(photo)
        if file is None:
            if before is not None:
                after[before.id] = None
        elif before is None:
            id_ = new_id("mask")
            after[id_] = Mask(id_, photo_set_id, photo, file)
        elif before.file != file:
            after[before.id] = replace(before, file=file)
    return after


def _set(records: Records, photo_set_id: str) -> PhotoSet:
    found = records.get(photo_set_id)
    if not isinstance(found, PhotoSet):
        raise DocumentError(Finding("record.missing", kind="photo set", id=photo_set_id))
    return found


def photo_sets(records: Records) -> Iterable[PhotoSet]:
    return (r for r in records.values() if isinstance(r, PhotoSet))
