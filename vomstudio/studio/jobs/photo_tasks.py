"""Jobs on photos: listing, survey check, import of what lies beside them."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.containment import make_folder
from vomstudio.core.files.regular import open_regular
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.project.imports.sidecar_import import SidecarData
from vomstudio.studio.jobs.job import Job, Lane


@dataclass(frozen=True)
class PhotosIn:
    """photos : their folder; cache : thumbnails are kept below it; masks : by photo, in place of
    those that lie beside the photos, None for those"""

    photos: Path
    cache: Path
    masks: Mapping[str, Path] | None = None


@dataclass(frozen=True)
class ListedPhoto:
    """What a photo says of itself. place : (x, y) metres in plan; looks : unit (dx, dy), each None
    where it is not known"""

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
    looks: tuple[float, float] | None
    found_sha256: str
    """Of the file of its mask, "" without one."""


@dataclass(frozen=True)
class PhotoList:
    """left_out : sentences on what is no usable photo"""

    rows: tuple[ListedPhoto, ...]
    left_out: tuple[Finding, ...]


def _list_photos(asked: PhotosIn, progress: Progress) -> PhotoList:
    from vomstudio.io.photos.pixels import thumbnail
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.survey.camera_positions import metres_from_gps

    found = read_photos(asked.photos, progress)
    thumbnails = asked.cache / "thumbnails"
    make_folder(thumbnails)
    places = metres_from_gps(found.photos)
    progress.stage(tr("Making thumbnails"), len(found.photos))
    rows = []
    for number, photo in enumerate(found.photos):
        progress.step(number)
        looks = None
        if photo.yaw_deg is not None and (photo.pitch_deg is None or photo.pitch_deg > -80):
            yaw = math.radians(photo.yaw_deg)
            looks = (math.sin(yaw), math.cos(yaw))
        east, north = (float(value) for value in places[number, :2])
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
                thumbnail=_keep_thumbnail(photo, thumbnails, thumbnail),
                place=(east, north) if math.isfinite(east) else None,
                looks=looks,
                found_sha256="" if photo.mask is None else _sha256(photo.mask),
            )
        )
    left_out = [
        Finding("photo.left-out", photo=name, reason=reason) for name, reason in found.skipped
    ]
    return PhotoList(tuple(rows), (*left_out, *found.warnings))


def _sha256(path: Path) -> str:
    try:
        with open_regular(path) as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except (InputError, OSError):
        return ""


def _focal(photo: Any) -> str:
    if photo.focal_mm is None:
        return tr("unknown") if photo.focal_px is None else f"{photo.focal_px:.0f} px"
    return f"{photo.focal_mm:g} mm"


def _keep_thumbnail(photo: Any, folder: Path, thumbnail: Callable[..., Any]) -> str | None:
    """The file of a small picture that is kept between sessions; None where there is none."""
    from PIL import Image

    status = photo.path.stat()
    name = f"{photo.path.resolve()} {status.st_size} {status.st_mtime_ns}"
    out = folder / f"{hashlib.sha256(name.encode()).hexdigest()[:24]}.jpg"
    if not out.exists():
        try:
            Image.fromarray(thumbnail(photo, 144)).convert("RGB").save(out, quality=85)
        except (OSError, ValueError):
            return None
    return str(out)


_FEWER = to_translate("Leave out the largest photos, or close other programs.")
LIST_PHOTOS = Job("list_photos", Lane.PHOTOS, PhotosIn, PhotoList, _list_photos, _FEWER)
"""What the photos of a folder say of themselves."""


def _check_photos(asked: PhotosIn, progress: Progress) -> SurveyReport:
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.survey.check import check_photos

    return check_photos(read_photos(asked.photos).replace_masks(asked.masks), progress=progress)


CHECK_PHOTOS = Job("check_photos", Lane.PHOTOS, PhotosIn, SurveyReport, _check_photos, _FEWER)
"""The survey check of a folder of photos, as `vomstudio check` prints it."""


@dataclass(frozen=True)
class SidecarImport:
    """What lies beside the photos called `names`: tables, and masks, file by photo, which are kept
    in the folder `project`"""

    project: Path
    control: Path | None
    marks: Path | None
    masks: Mapping[str, Path]
    names: tuple[str, ...]


def _import_sidecars(asked: SidecarImport, progress: Progress) -> SidecarData:
    from vomstudio.project.imports.sidecar_import import read_sidecars

    progress.stage(tr("Importing points and masks"), len(asked.masks))
    return read_sidecars(
        asked.project, asked.control, asked.marks, asked.masks, asked.names, progress
    )


IMPORT_SIDECARS = Job(
    "take_in_photos", Lane.PHOTOS, SidecarImport, SidecarData, _import_sidecars, _FEWER
)
"""What lies beside photos, to become records."""

JOBS = (LIST_PHOTOS, CHECK_PHOTOS, IMPORT_SIDECARS)
