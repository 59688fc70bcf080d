"""What lay beside the journal becomes records: control points, marks, masks, reconstructions.

The files stay where they are. Once taken in, the records are the truth and the files are exports.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from vomstudio.document.edit import Edit, change
from vomstudio.document.edits import new_id
from vomstudio.document.photo_edits import (
    PointState,
    add_photo_set,
    add_reconstruction,
    photo_sets,
    reconstruction_in,
)
from vomstudio.document.records import Asset, Model, PhotoSet, Record, Registration
from vomstudio.errors import InputError, VomError
from vomstudio.files.regular import is_folder, is_regular, read_whole
from vomstudio.io.control.control_files import crs_of, marks_beside, read_control, read_marks
from vomstudio.io.control.points import CONTROL, MARKS, ControlPoint, Mark
from vomstudio.io.photos.photo_names import photo_finder
from vomstudio.io.project.assets import keep_asset
from vomstudio.io.project.reconstructions import (
    RECONSTRUCTIONS,
    RESULT,
    asked,
    read_reconstruction,
)
from vomstudio.progress import Progress

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


def tables_of(
    project: Path, photos: Path, named: Sequence[Path] = ()
) -> tuple[Path | None, Path | None]:
    """The tables of control points and of marks of a folder of photos: beside them or in the
    project; where there are none, those that a reconstruction was given. named: other paths under
    which the photos were known."""
    folders = [photos, *(spare_folder(project, each) for each in (photos.resolve(), *named))]
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


def take_in_earlier(project: Path, records: Records) -> tuple[Edit | None, list[str]]:
    """One edit that takes in what an earlier version has left in the folder of the project and
    beside its photos, and sentences on what could not be read; None where there is nothing."""
    now: dict[str, Record] = dict(records)
    problems: list[str] = []
    for folder in _runs(project):
        request = asked(folder)
        if request is None:
            continue
        stated = Path(request["photos"])
        photos = _found(project, stated)
        photo_set = _set_of(project, now, photos or stated)
        if photo_set is None:
            photo_set, edit, said = _new_set(project, now, stated, photos, request)
            edit.swap(now)
            problems += said
        if (folder / RESULT).is_file() and reconstruction_in(now, folder.name) is None:
            with _naming(problems):
                reconstruction, registration = read_reconstruction(
                    folder, photo_set.id, photo_set.name
                )
                add_reconstruction(now, reconstruction, registration).swap(now)
                _place(now, folder.name, registration)
    after = {id_: record for id_, record in now.items() if records.get(id_) != record}
    label = "Take in photos, control points, masks and reconstructions"
    return (change(records, label, after) if after else None), problems


@contextlib.contextmanager
def _naming(problems: list[str]) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        problems.append(str(error))


def _runs(project: Path) -> list[Path]:
    """Folders of reconstructions, the oldest first."""
    folder = project / RECONSTRUCTIONS
    if not folder.is_dir():
        return []
    return sorted(each for each in folder.iterdir() if each.is_dir())


def _found(project: Path, stated: Path) -> Path | None:
    """The folder of the photos; beside the project where both were moved together."""
    places = (stated, project.parent / stated.name)
    return next((place for place in places if is_folder(place)), None)


def _set_of(project: Path, records: Records, photos: Path) -> PhotoSet | None:
    stored = stored_path(project, photos)
    return next((each for each in photo_sets(records) if each.path == stored), None)


def stored_path(project: Path, photos: Path) -> str:
    """How the path of photos is written down: relative inside the project, else absolute."""
    full, home = photos.resolve(), project.resolve()
    return full.relative_to(home).as_posix() if full.is_relative_to(home) else str(full)


def _new_set(
    project: Path,
    records: Records,
    stated: Path,
    photos: Path | None,
    request: Mapping[str, object],
) -> tuple[PhotoSet, Edit, list[str]]:
    from vomstudio.io.photos.reading import read_photos

    names: list[str] = []
    masks: dict[str, Path] = {}
    problems: list[str] = []
    if photos is not None:
        with _naming(problems):
            listed = read_photos(photos).photos
            names = [photo.name for photo in listed]
            masks = {photo.name: photo.mask for photo in listed if photo.mask is not None}
    control, marks = tables_of(project, photos or stated, (stated,))
    if control is None and marks is None:
        control, marks = _given(request)
    beside = read_beside(project, control, marks, masks, names)
    photo_set = PhotoSet(
        new_id("photos"),
        stated.name,
        stored_path(project, photos or stated),
        beside.crs,
        # Those beside photos that are not to be found now are taken in once they are.
        taken_in=photos is not None,
    )
    edit = add_photo_set(records, photo_set, beside.points, beside.pixels, beside.masks)
    return photo_set, edit, [*problems, *beside.problems]


def _given(request: Mapping[str, object]) -> tuple[Path | None, Path | None]:
    """The files that the reconstruction was told to use, where they are there."""
    control, marks = (
        Path(value) if isinstance(value, str) and is_regular(value) else None
        for value in (request.get("control"), request.get("marks"))
    )
    if control is not None and marks is None:
        with contextlib.suppress(VomError):
            beside = marks_beside(control)
            marks = beside if beside.is_file() else None
    return control, marks


def _place(records: dict[str, Record], folder: str, registration: Registration) -> None:
    """Models of a reconstruction are placed by what it found, unless another frame was declared."""
    inside = f"{RECONSTRUCTIONS}/{folder}/"
    for record in list(records.values()):
        if (
            isinstance(record, Model)
            and record.path.startswith(inside)
            and record.placement == registration.frame
        ):
            records[record.id] = replace(record, placement=registration)
