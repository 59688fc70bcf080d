"""Read the control points, marks and masks that lie beside photos, to make records of them.

The files stay where they are. Once imported, the records are authoritative and the files exports.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.files.regular import read_whole
from vomstudio.core.progress import Progress
from vomstudio.io.control.control_files import crs_of, read_control, read_marks
from vomstudio.io.control.points import CONTROL, MARKS, ControlPoint, Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.project.assets import keep_asset
from vomstudio.project.photo_edits import (
    PointState,
)
from vomstudio.project.records import Asset, Record

PHOTO_TABLES = "photos"
"""Tables of photos whose own folder cannot be written."""
Records = Mapping[str, Record]


@dataclass(frozen=True)
class Beside:
    """What lies beside a set of photos.

    marks : (label, photo, x, y); masks : file kept in the project, by photo; problems : sentences
    on what could not be read, unread : the names of those tables, which nobody may replace unasked
    """

    points: tuple[PointState, ...] = ()
    marks: tuple[tuple[str, str, float, float], ...] = ()
    masks: Mapping[str, Asset] = field(default_factory=dict)
    crs: str = ""
    problems: tuple[str, ...] = ()
    unread: tuple[str, ...] = ()

    @property
    def pixels(self) -> dict[tuple[str, str], tuple[float, float]]:
        """Of the marks, by label and photo."""
        return {(label, photo): (x, y) for label, photo, x, y in self.marks}


def spare_folder(project: Path, photos: Path) -> Path:
    """Where the tables of photos are kept whose own folder cannot be written."""
    key = hashlib.sha256(str(photos).encode()).hexdigest()[:8]
    return project / PHOTO_TABLES / f"{photos.name}-{key}"


def tables_of(project: Path, photos: Path) -> tuple[Path | None, Path | None]:
    """The tables of control points and of marks of a folder of photos: beside them or in the
    project. None for a table that is in neither."""
    folders = [photos, spare_folder(project, photos.resolve())]
    found = [
        next((folder / name for folder in folders if (folder / name).is_file()), None)
        for name in (CONTROL, MARKS)
    ]
    return found[0], found[1]


def read_beside(
    project: Path,
    control: Path | None,
    marks: Path | None,
    masks: Mapping[str, Path],
    photos: Sequence[str],
    progress: Progress | None = None,
) -> Beside:
    """Read the tables, and keep the masks in the project. Of what cannot be read nothing is lost:
    the files stay, and `problems` names them."""
    points: tuple[PointState, ...] = ()
    seen: tuple[tuple[str, str, float, float], ...] = ()
    crs, problems, unread = "", [], []
    try:
        if control is not None:
            points = tuple(_state(point) for point in read_control(control))
            crs = crs_of(control) or ""
    except VomError as error:
        unread.append(CONTROL)
        problems.append(str(error))
    try:
        if marks is not None:
            seen = _by_photo(read_marks(marks), photos)
    except VomError as error:
        unread.append(MARKS)
        problems.append(str(error))
    kept = {}
    for done, (name, path) in enumerate(masks.items()):
        if progress is not None:
            progress.step(done)
        try:
            kept[name] = keep_asset(project, read_whole(path), path.suffix.lower())
        except (OSError, VomError) as error:
            problems.append(f"{path}: {error}")
    return Beside(points, seen, kept, crs, tuple(problems), tuple(unread))


def _state(point: ControlPoint) -> PointState:
    return PointState(point.label, point.position, point.sigma_m, point.check)


def _by_photo(
    marks: Sequence[Mark], photos: Sequence[str]
) -> tuple[tuple[str, str, float, float], ...]:
    """Under the names of the photos, where these are there."""
    find = photo_finder(photos)
    made = []
    for mark in marks:
        number = find(mark.photo)
        made.append((mark.label, mark.photo if number is None else photos[number], mark.x, mark.y))
    return tuple(made)


def stored_path(project: Path, photos: Path) -> str:
    """How the path of photos is written down: relative inside the project, else absolute."""
    full, home = photos.resolve(), project.resolve()
    return full.relative_to(home).as_posix() if full.is_relative_to(home) else str(full)
