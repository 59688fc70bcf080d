"""Input photos of a reconstruction: selection, checks and hashes."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.photogrammetry.base.checkpoints import make_key
from vomstudio.photogrammetry.base.settings import PipelineSettings

if TYPE_CHECKING:
    from vomstudio.geometry.cameras import View
    from vomstudio.io.control.points import ControlPoint, Mark
    from vomstudio.io.photos.photo import Photo
    from vomstudio.io.photos.reading import PhotoFolder


@dataclass(frozen=True)
class ControlTables:
    """Tables of control points and marks, read before the reconstruction.

    Attributes
    ----------
    points, marks : tuple
        Points and marks; empty if the table is not given.
    crs : str or None
        CRS of the points, "EPSG:n" (or WKT). If None, they are in a local frame in metres.
    hashes : tuple
        Hashes of the files of points and of marks; None if the file is not given.
    """

    points: tuple[ControlPoint, ...]
    marks: tuple[Mark, ...]
    crs: str | None
    hashes: tuple[str | None, str | None]


def read_tables(settings: PipelineSettings) -> ControlTables:
    """Read the tables of control points and marks.

    Raises InputError if a table cannot be read, and UsageError if its CRS cannot be used.
    """
    from vomstudio.io.control.control_files import agreed_crs, read_control, read_marks

    control, marks = settings.control, settings.marks
    return ControlTables(
        () if control is None else tuple(read_control(control)),
        () if marks is None else tuple(read_marks(marks)),
        None if control is None else agreed_crs(control, settings.crs),
        (
            None if control is None else hash_file(control),
            None if marks is None else hash_file(marks),
        ),
    )


def usable_photos(
    folder: Path,
    settings: PipelineSettings,
    tables: ControlTables,
    progress: Progress,
    masks: Mapping[str, Path] | None = None,
) -> PhotoFolder:
    """Return the usable photos, and reject input that would only fail hours later.

    Parameters
    ----------
    folder : Path
    settings : PipelineSettings
    tables : ControlTables
    progress : Progress
    masks : mapping of str to Path, optional
        Mask of each photo, by name. If None, the masks next to the photos are used.

    Raises
    ------
    InputError
        If there are fewer than two photos, or if the control points or GPS positions cannot
        register a model.
    UsageError, GeometryError
        If the CRS is invalid or does not contain the photos.
    """
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.georeferencing.control_check import check_control
    from vomstudio.photogrammetry.georeferencing.georeference import (
        has_position,
        select_crs,
        world_positions,
    )
    from vomstudio.photogrammetry.georeferencing.mark_observations import report_coincident_marks

    photo_folder = read_photos(folder, progress).replace_masks(masks)
    if len(photo_folder.photos) < 2:
        reasons = [
            tr("{photo} was left out: {reason}", photo=name, reason=reason)
            for name, reason in photo_folder.skipped[:1]
        ]
        raise InputError(Finding("alignment.too-few-photos", reasons=reasons), file=folder)
    if settings.control is not None:
        checked_control = check_control(
            tables.points, tables.marks, photo_folder.photos, settings.crs
        )
        if checked_control.problem is not None:
            raise InputError(checked_control.problem, file=settings.marks)
    photo_folder.warnings.extend(report_coincident_marks(tables.marks))
    if settings.crs is not None and settings.control is None:
        placed_photos = [photo for photo in photo_folder.photos if has_position(photo)]
        if len(placed_photos) < 3:
            raise InputError(
                Finding(
                    "gps-few",
                    "error",
                    value=len(placed_photos),
                    total=len(photo_folder.photos),
                    crs=settings.crs,
                    photos=[photo.name for photo in placed_photos],
                ),
                file=folder,
            )
        world_positions(placed_photos, select_crs(placed_photos, settings.crs))
    return photo_folder


@dataclass(frozen=True)
class OriginalPhoto:
    """Original photo for the texture, read on access."""

    original: Photo
    view: View

    @property
    def photo(self) -> bytes:
        return read_bytes(self.original.path)

    @property
    def mask(self) -> bytes | None:
        return None if self.original.mask is None else read_bytes(self.original.mask)


def photo_hash(photo: Photo) -> str:
    """Return the hash of a photo and its mask."""
    return make_key(*(hash_file(path) for path in (photo.path, photo.mask) if path is not None))


def read_bytes(path: Path) -> bytes:
    """Read a file. Raises InputError if it cannot be read."""
    try:
        with open_regular_file(path) as stream:
            return stream.read()
    except OSError as error:
        raise InputError(
            Finding("reconstruct.photo-lost", reason=error.strerror),
            file=path,
        ) from error


def hash_file(path: Path) -> str:
    """Return the hexadecimal SHA-256 hash of a file. Raises InputError if it is unreadable."""
    try:
        with open_regular_file(path) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error


def alignment_facts(photos: Sequence[Photo]) -> list[Any]:
    """Return the properties of photos that the alignment uses besides their pixels."""
    return [[p.name, str(p.camera_key), p.latitude_deg, p.longitude_deg] for p in photos]
