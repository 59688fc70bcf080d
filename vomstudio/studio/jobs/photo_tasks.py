"""Jobs on photos: listing, survey check and import of companion files."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError, TargetError, WorkerError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.containment import make_folder
from vomstudio.core.files.regular import open_regular_file, read_json
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.version import __version__
from vomstudio.core.words import to_translate, tr
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.project.imports.sidecar_import import SidecarData
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane


@dataclass(frozen=True)
class PhotosRequest:
    """Request concerning a folder of photos.

    Parameters
    ----------
    cache : Path
        Folder below which thumbnails and results of checks are cached.
    masks : mapping of str to Path, optional
        Mask file of each photo, keyed by photo name. By default, masks beside the photos are
        used.
    """

    photos: Path
    cache: Path
    masks: Mapping[str, Path] | None = None


@dataclass(frozen=True)
class ListedPhoto:
    """Metadata of a photo.

    Parameters
    ----------
    place : (float, float) or None
        Position in plan view, metres.
    look_direction : (float, float) or None
        Unit vector of the viewing direction in plan view.
    """

    name: str
    path: str
    width: int
    height: int
    camera: str
    focal: str
    taken: str
    has_gps: bool
    mask: str | None
    thumbnail: str | None
    place: tuple[float, float] | None
    look_direction: tuple[float, float] | None
    found_sha256: str
    """Hash of the photo's mask file, or "" if the photo has no mask."""


@dataclass(frozen=True)
class PhotoListing:
    """Photos of a folder; `left_out` contains the reasons why other files cannot be used."""

    rows: tuple[ListedPhoto, ...]
    left_out: tuple[Finding, ...]


def _list_photos(request: PhotosRequest, progress: Progress) -> PhotoListing:
    from vomstudio.io.photos.pixels import thumbnail
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.survey.camera_positions import metres_from_gps

    survey = read_photos(request.photos, progress)
    thumbnails = request.cache / "thumbnails"
    make_folder(thumbnails)
    positions = metres_from_gps(survey.photos)
    progress.stage(tr("Creating thumbnails"), len(survey.photos))
    rows = []
    for number, photo in enumerate(survey.photos):
        progress.step(number)
        look_direction = None
        if photo.yaw_deg is not None and (photo.pitch_deg is None or photo.pitch_deg > -80):
            yaw = math.radians(photo.yaw_deg)
            look_direction = (math.sin(yaw), math.cos(yaw))
        east, north = (float(value) for value in positions[number, :2])
        rows.append(
            ListedPhoto(
                name=photo.name,
                path=str(photo.path),
                width=photo.width,
                height=photo.height,
                camera=photo.camera or tr("unknown"),
                focal=_focal(photo),
                taken="" if photo.taken_at is None else photo.taken_at.isoformat(" ", "seconds"),
                has_gps=photo.latitude_deg is not None,
                mask=None if photo.mask is None else str(photo.mask),
                thumbnail=_cache_thumbnail(photo, thumbnails, thumbnail),
                place=(east, north) if math.isfinite(east) else None,
                look_direction=look_direction,
                found_sha256="" if photo.mask is None else _sha256(photo.mask),
            )
        )
    left_out = [
        Finding("photo.left-out", photo=name, reason=reason) for name, reason in survey.skipped
    ]
    return PhotoListing(tuple(rows), (*left_out, *survey.warnings))


def _sha256(path: Path) -> str:
    try:
        with open_regular_file(path) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except (InputError, OSError):
        return ""


def _focal(photo: Any) -> str:
    if photo.focal_mm is None:
        return tr("unknown") if photo.focal_px is None else f"{photo.focal_px:.0f} px"
    return f"{photo.focal_mm:g} mm"


def _cache_thumbnail(photo: Any, folder: Path, thumbnail: Callable[..., Any]) -> str | None:
    """Return the path of a photo's cached thumbnail, or None if it cannot be created."""
    from PIL import Image

    name = _file_state(photo.path)
    out = folder / f"{hashlib.sha256(name.encode()).hexdigest()[:24]}.jpg"
    if not out.exists():
        try:
            Image.fromarray(thumbnail(photo, 144)).convert("RGB").save(out, quality=85)
        except (OSError, ValueError):
            return None
    return str(out)


def _file_state(path: Path) -> str:
    """Return the path, size and time of a file, which change when the file is replaced."""
    status = path.stat()
    return f"{path.resolve()} {status.st_size} {status.st_mtime_ns}"


MEMORY_ADVICE = to_translate("Leave out the largest photos, or close other programs.")
LIST_PHOTOS = Job(
    "list_photos", Lane.PHOTOS, PhotosRequest, PhotoListing, _list_photos, MEMORY_ADVICE
)
"""Read the metadata of the photos in a folder."""


def _check_photos(request: PhotosRequest, progress: Progress) -> SurveyReport:
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.survey.check import check_photos

    folder = read_photos(request.photos).replace_masks(request.masks)
    files = [path for photo in folder.photos for path in (photo.path, photo.mask) if path]
    state = "\n".join([__version__, *map(_file_state, files)])
    name = hashlib.sha256(state.encode()).hexdigest()[:24]
    cached_values = request.cache / "checks" / f"{name}.json"
    with contextlib.suppress(InputError, OSError, ValueError, TypeError, KeyError, WorkerError):
        # The verdict is derived again, in the present language.
        return replace(serialisation.decode(SurveyReport, read_json(cached_values)), verdict="")
    report = check_photos(folder, progress=progress)
    with contextlib.suppress(OSError, TargetError):
        make_folder(cached_values.parent)
        write_bytes(cached_values, json.dumps(serialisation.encode(report)).encode(), force=True)
    return report


CHECK_PHOTOS = Job(
    "check_photos", Lane.PHOTOS, PhotosRequest, SurveyReport, _check_photos, MEMORY_ADVICE
)
"""Check the photos in a folder, as `vomstudio check` does."""


@dataclass(frozen=True)
class SidecarImport:
    """Request to import companion files of the photos `names` into the project.

    Parameters
    ----------
    project : Path
        Folder in which masks are stored.
    control, marks : Path or None
        Tables of the control points and of their image marks.
    masks : mapping of str to Path
        Mask files, keyed by photo name.
    """

    project: Path
    control: Path | None
    marks: Path | None
    masks: Mapping[str, Path]
    names: tuple[str, ...]


def _import_sidecars(request: SidecarImport, progress: Progress) -> SidecarData:
    from vomstudio.project.imports.sidecar_import import read_sidecars

    progress.stage(tr("Importing points and masks"), len(request.masks))
    return read_sidecars(
        request.project, request.control, request.marks, request.masks, request.names, progress
    )


IMPORT_SIDECARS = Job(
    "take_in_photos", Lane.PHOTOS, SidecarImport, SidecarData, _import_sidecars, MEMORY_ADVICE
)
"""Read the companion files of photos as records."""

JOBS = (LIST_PHOTOS, CHECK_PHOTOS, IMPORT_SIDECARS)
