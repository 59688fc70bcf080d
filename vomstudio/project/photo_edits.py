"""Pure functions that create edits of photo sets, marked points and reconstructions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

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
    ReconstructionRecord,
    Record,
)

Records = Mapping[str, Record]
ChangedRecords = dict[str, Record | None]
Pixel = tuple[float, float]


@dataclass(frozen=True)
class PointState:
    """Marked point without its ID, as in a table or window, with the fields of MarkedPoint."""

    label: str
    position: Point | None = None
    sigma_m: float | None = None
    check: bool = False


_GENERIC_NAMES = {
    *("photos", "photo", "images", "image", "img", "imgs", "pictures", "pics", "jpg", "jpeg"),
    *("raw", "tif", "tiff", "dcim", "100media", "frames", "fotos", "bilder"),
}
"""Names of folders, in lower case, that do not identify an outcrop."""

Marks = Mapping[tuple[str, str], Pixel]
"""Pixel coordinates by (label, photo)."""


def points_of(records: Records, photo_set_id: str) -> list[MarkedPoint]:
    """Return the marked points of a photo set."""
    return [
        record
        for record in records.values()
        if isinstance(record, MarkedPoint) and record.photo_set_id == photo_set_id
    ]


def marks_of(records: Records, photo_set_id: str) -> list[tuple[MarkedPoint, ImageMark]]:
    """Return the marks of a photo set, each with its marked point."""
    points = {point.id: point for point in points_of(records, photo_set_id)}
    return [
        (points[record.point_id], record)
        for record in records.values()
        if isinstance(record, ImageMark) and record.point_id in points
    ]


def get_masks(records: Records, photo_set_id: str) -> dict[str, Mask]:
    """Return the masks of a photo set by photo name."""
    return {
        record.photo: record
        for record in records.values()
        if isinstance(record, Mask) and record.photo_set_id == photo_set_id
    }


def add_photo_set(
    records: Records,
    photo_set: PhotoSet,
    points: Sequence[PointState] = (),
    marks: Marks | None = None,
    masks: Mapping[str, Asset] | None = None,
) -> Edit:
    """Add a folder of photos with the points, marks and masks of its sidecar files.

    Raises DocumentError if the project already contains it.
    """
    if photo_set.id in records:
        raise DocumentError(Finding("record.exists", name=photo_set.name))
    new_records: ChangedRecords = {photo_set.id: photo_set}
    new_records |= _point_changes(records, photo_set.id, points, marks or {})
    new_records |= _mask_changes(records, photo_set.id, masks or {})
    return change(records, f"Add the photos {photo_set.name}", new_records)


def import_sidecar_data(
    records: Records,
    photo_set_id: str,
    points: Sequence[PointState],
    marks: Marks,
    masks: Mapping[str, Asset | None],
    crs: str | None = None,
) -> Edit:
    """Replace the points and marks of a photo set, and set masks, from its sidecar files."""
    photo_set = _set(records, photo_set_id)
    known_crs = photo_set.crs if crs is None else crs
    new_records: ChangedRecords = {photo_set_id: replace(photo_set, crs=known_crs)}
    new_records |= _point_changes(records, photo_set_id, points, marks)
    new_records |= _mask_changes(records, photo_set_id, masks)
    return change(records, f"Use files next to the photos {photo_set.name}", new_records)


def set_points(
    records: Records,
    photo_set_id: str,
    points: Sequence[PointState],
    marks: Marks,
    label: str,
    *,
    crs: str | None = None,
) -> Edit:
    """Set the points and marks of a photo set; unchanged points and marks keep their records.

    If exactly one label is replaced by a new one with marks in the same photos, the point is
    treated as renamed.
    """
    photo_set = _set(records, photo_set_id)
    new_records = _point_changes(records, photo_set_id, points, marks)
    if crs is not None and crs != photo_set.crs:
        new_records[photo_set_id] = replace(photo_set, crs=crs)
    return change(records, label, new_records)


def set_masks(
    records: Records, photo_set_id: str, masks: Mapping[str, Asset | None], label: str
) -> Edit:
    """Set the masks of photos; None removes a mask."""
    _set(records, photo_set_id)
    return change(records, label, _mask_changes(records, photo_set_id, masks))


def locate_photos(records: Records, photo_set_id: str, path: str) -> Edit:
    """Change the folder of a photo set."""
    photo_set = _set(records, photo_set_id)
    return change(
        records,
        f"Locate the photos {photo_set.name}",
        {photo_set_id: replace(photo_set, path=path)},
    )


def add_reconstruction(
    records: Records, reconstruction: ReconstructionRecord, registration: Registration
) -> Edit:
    """Add a reconstruction with its registration, replacing an earlier one in its folder."""
    _set(records, reconstruction.photo_set_id)
    new_records: ChangedRecords = {reconstruction.id: reconstruction}
    new_records |= set_registration(records, registration).after
    for other_record in records.values():
        if (
            isinstance(other_record, ReconstructionRecord)
            and other_record.folder == reconstruction.folder
            and other_record.id != reconstruction.id
        ):
            new_records[other_record.id] = None
    return change(records, f"Make a model of {reconstruction.name}", new_records)


def find_reconstruction(records: Records, folder: str) -> ReconstructionRecord | None:
    """Return the reconstruction whose files are in a folder, or None."""
    return next(
        (
            record
            for record in records.values()
            if isinstance(record, ReconstructionRecord) and record.folder == folder
        ),
        None,
    )


def reconstruction_registration(records: Records, reconstruction_id: str) -> Registration | None:
    """Return the registration that was computed with a reconstruction, or None."""
    return next(
        (
            record
            for record in records.values()
            if isinstance(record, Registration) and record.reconstruction_id == reconstruction_id
        ),
        None,
    )


def _point_changes(
    records: Records, photo_set_id: str, points: Sequence[PointState], marks: Marks
) -> ChangedRecords:
    old_points = {point.label: point for point in points_of(records, photo_set_id)}
    states = {state.label: state for state in points}
    for label, _ in marks:
        states.setdefault(label, PointState(label))
    ids = {label: old_points[label].id for label in states if label in old_points}
    old_marks = {(point.label, mark.photo): mark for point, mark in marks_of(records, photo_set_id)}
    _match_renamed_point(ids, old_points, states, old_marks, marks)
    new_records: ChangedRecords = {}
    for label, state in states.items():
        id_ = ids.setdefault(label, new_id("point"))
        point = MarkedPoint(id_, photo_set_id, label, state.position, state.sigma_m, state.check)
        if records.get(id_) != point:
            new_records[id_] = point
    new_records |= {
        old_point.id: None for old_point in old_points.values() if old_point.id not in ids.values()
    }
    marks_by_point = {
        (old_mark.point_id, old_mark.photo): old_mark for old_mark in old_marks.values()
    }
    used_ids = set()
    for (label, photo), (x, y) in marks.items():
        old_mark = marks_by_point.get((ids[label], photo))
        id_ = new_id("mark") if old_mark is None else old_mark.id
        used_ids.add(id_)
        mark = ImageMark(id_, ids[label], photo, x, y)
        if old_mark != mark:
            new_records[id_] = mark
    new_records |= {mark.id: None for mark in marks_by_point.values() if mark.id not in used_ids}
    return new_records


def _match_renamed_point(
    ids: dict[str, str],
    old_points: Mapping[str, MarkedPoint],
    states: Mapping[str, PointState],
    old_marks: Marks | Mapping[tuple[str, str], ImageMark],
    marks: Marks,
) -> None:
    """Assign the ID of a removed label to a new one if exactly one label was replaced."""
    removed_labels = [label for label in old_points if label not in states]
    added_labels = [label for label in states if label not in old_points]
    if len(removed_labels) == len(added_labels) == 1:
        old_photos = {photo for label, photo in old_marks if label == removed_labels[0]}
        photos = {photo for label, photo in marks if label == added_labels[0]}
        if old_photos == photos:
            ids[added_labels[0]] = old_points[removed_labels[0]].id


def _mask_changes(
    records: Records, photo_set_id: str, masks: Mapping[str, Asset | None]
) -> ChangedRecords:
    old_masks = get_masks(records, photo_set_id)
    new_records: ChangedRecords = {}
    for photo, file in masks.items():
        old_mask = old_masks.get(photo)
        if file is None:
            if old_mask is not None:
                new_records[old_mask.id] = None
        elif old_mask is None:
            id_ = new_id("mask")
            new_records[id_] = Mask(id_, photo_set_id, photo, file)
        elif old_mask.file != file:
            new_records[old_mask.id] = replace(old_mask, file=file)
    return new_records


def _set(records: Records, photo_set_id: str) -> PhotoSet:
    photo_set = records.get(photo_set_id)
    if not isinstance(photo_set, PhotoSet):
        raise DocumentError(Finding("record.missing", kind="photo set", id=photo_set_id))
    return photo_set


def photo_set_name(folder: Path) -> str:
    """Return the name of a photo set from its folder, ignoring generic names ("photos").

    Parameters
    ----------
    folder : Path

    Returns
    -------
    str
        Name of the folder, or of the folder that contains it.
    """
    parent = folder.resolve().parent.name
    return parent if parent and folder.name.casefold() in _GENERIC_NAMES else folder.name


def photo_sets(records: Records) -> Iterable[PhotoSet]:
    """Yield the photo sets of a project."""
    return (record for record in records.values() if isinstance(record, PhotoSet))
