"""Import of control points, marks and masks stored next to photos.

The files remain in place. After the import, the records are authoritative and the files are
exports.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.files.regular import read_whole_file
from vomstudio.core.progress import Progress
from vomstudio.io.control.control_files import read_control, read_crs, read_marks
from vomstudio.io.control.points import CONTROL, MARKS, ControlPoint, Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.project.assets import store_asset
from vomstudio.project.photo_edits import (
    PointState,
)
from vomstudio.project.records import Asset, Record

PHOTO_TABLES = "photos"
"""Folder for the tables of photos whose own folder is read-only."""
Records = Mapping[str, Record]


@dataclass(frozen=True)
class SidecarData:
    """Contents of the sidecar files of a photo set.

    Attributes
    ----------
    marks : tuple
        Marks as (label, photo, x, y), in pixels.
    masks : mapping of str to Asset
        Files stored in the project, by photo name.
    problems : tuple of str
        Messages about data that could not be read.
    unread_files : tuple of str
        Names of unreadable tables, which must not be overwritten without asking the user.
    """

    points: tuple[PointState, ...] = ()
    marks: tuple[tuple[str, str, float, float], ...] = ()
    masks: Mapping[str, Asset] = field(default_factory=dict)
    crs: str = ""
    problems: tuple[str, ...] = ()
    unread_files: tuple[str, ...] = ()

    @property
    def pixels(self) -> dict[tuple[str, str], tuple[float, float]]:
        """Pixel coordinates of the marks by label and photo name."""
        return {(label, photo): (x, y) for label, photo, x, y in self.marks}


def fallback_folder(project: Path, photos: Path) -> Path:
    """Return the folder for tables of photos whose own folder is read-only."""
    key = hashlib.sha256(str(photos).encode()).hexdigest()[:8]
    return project / PHOTO_TABLES / f"{photos.name}-{key}"


def sidecar_tables(project: Path, photos: Path) -> tuple[Path | None, Path | None]:
    """Return the tables of control points and of marks, next to the photos or in the project.

    Returns None for a table that is in neither folder.
    """
    folders = [photos, fallback_folder(project, photos.resolve())]
    paths = [
        next((folder / name for folder in folders if (folder / name).is_file()), None)
        for name in (CONTROL, MARKS)
    ]
    return paths[0], paths[1]


def read_sidecars(
    project: Path,
    control: Path | None,
    marks: Path | None,
    masks: Mapping[str, Path],
    photos: Sequence[str],
    progress: Progress | None = None,
) -> SidecarData:
    """Read the tables and store the masks in the project.

    Unreadable files are left in place and reported in `problems`.
    """
    points: tuple[PointState, ...] = ()
    image_marks: tuple[tuple[str, str, float, float], ...] = ()
    crs, problems, unread_files = "", [], []
    try:
        if control is not None:
            points = tuple(_state(point) for point in read_control(control))
            crs = read_crs(control) or ""
    except VomError as error:
        unread_files.append(CONTROL)
        problems.append(str(error))
    try:
        if marks is not None:
            image_marks = _resolve_photos(read_marks(marks), photos)
    except VomError as error:
        unread_files.append(MARKS)
        problems.append(str(error))
    assets = {}
    for count, (name, path) in enumerate(masks.items()):
        if progress is not None:
            progress.step(count)
        try:
            assets[name] = store_asset(project, read_whole_file(path), path.suffix.lower())
        except (OSError, VomError) as error:
            problems.append(f"{path}: {error}")
    return SidecarData(points, image_marks, assets, crs, tuple(problems), tuple(unread_files))


def _state(point: ControlPoint) -> PointState:
    return PointState(point.label, point.position, point.sigma_m, point.check)


def _resolve_photos(
    marks: Sequence[Mark], photos: Sequence[str]
) -> tuple[tuple[str, str, float, float], ...]:
    """Replace the photo names of marks by the matching names of the photo set."""
    find = photo_finder(photos)
    resolved_marks = []
    for mark in marks:
        photo_index = find(mark.photo)
        resolved_marks.append(
            (mark.label, mark.photo if photo_index is None else photos[photo_index], mark.x, mark.y)
        )
    return tuple(resolved_marks)


def stored_path(project: Path, photos: Path) -> str:
    """Return the path to store for photos: relative inside the project, otherwise absolute."""
    resolved_path, folder = photos.resolve(), project.resolve()
    return (
        resolved_path.relative_to(folder).as_posix()
        if resolved_path.is_relative_to(folder)
        else str(resolved_path)
    )
