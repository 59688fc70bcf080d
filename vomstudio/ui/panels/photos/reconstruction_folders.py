"""The folders of a project in which models were made of photos, and what is found there."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.errors import InputError, TargetError, VomError, WorkerError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.containment import check_generated_path, make_folder
from vomstudio.core.files.regular import is_folder, is_regular, read_json, read_small
from vomstudio.io.models.reconstruction_file import RESULT
from vomstudio.io.photos.cameras_file import FILE_NAME, read_cameras
from vomstudio.project.photo_edits import add_reconstruction
from vomstudio.project.reconstructions import (
    RECONSTRUCTIONS,
    REQUEST,
    read_reconstruction,
)
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.events import Failed
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings, read_request

if TYPE_CHECKING:
    from vomstudio.photogrammetry.survey.check_results import SurveyReport

_FAILURE = "work/failure.txt"
# A direction that is steeper has no arrow on a map.
_MIN_ARROW_LENGTH = 0.2


def reconstruction_folder(project: Path, photos: Path, quality: str) -> Path:
    """Where the model of these photos in this quality is made, or was begun. One of another quality
    or of another folder of this name, which may have been measured on, stays as it is."""
    folder = project / RECONSTRUCTIONS
    for number in itertools.count(1):
        suffix = "" if number == 1 else f"-{number}"
        out = folder / f"{photos.name}{suffix}-{quality}"
        request = read_request(out / REQUEST)
        if request is None or _same_photos(request[0], photos):
            return out
    raise AssertionError("counting ends never")


def is_begun(out: Path) -> bool:
    """An earlier run has finished some stages and no more."""
    return (out / "work").is_dir() and not (out / "report.html").exists()


def store_failure(out: Path, reason: str) -> None:
    """Write beside the finished stages why the run failed, for the next start of the program; ""
    once it is made again. A disk that takes nothing has told so already."""
    with contextlib.suppress(OSError, TargetError):
        if reason:
            make_folder((out / _FAILURE).parent)
            write_bytes(check_generated_path(out / _FAILURE), reason.encode("utf-8"), force=True)
        else:
            (out / _FAILURE).unlink(missing_ok=True)


def report_failure(studio: Studio, out: Path, event: Failed) -> None:
    """Keep why the run failed, and report it now."""
    store_failure(out, event.message)
    studio.warn(event.to_error(), "error")


def read_failure(out: Path) -> str:
    """Why the last run failed, as a sentence; "" where it did not."""
    try:
        return read_small(out / _FAILURE).decode("utf-8", "replace").strip()
    except (InputError, OSError):
        return ""


def find_alignment(out: Path, photos: Path) -> Path | None:
    """A reconstruction of these photos with cameras: in `out`, else the newest one."""
    if (out / FILE_NAME).exists():
        return out
    cameras = out.parent.glob(f"*/{FILE_NAME}")
    folders = [each.parent for each in cameras if is_regular(each)]
    requests = {each: read_request(each / REQUEST) for each in folders}
    matches = [
        each
        for each, request in requests.items()
        if request is not None and _same_photos(request[0], photos)
    ]
    return max(matches, key=lambda each: (each / FILE_NAME).stat().st_mtime, default=None)


def find_newest(project: Path) -> tuple[Path, ReconstructionSettings] | None:
    """Photos and settings of the newest reconstruction, where the photos are to be found."""
    paths = (project / RECONSTRUCTIONS).glob(f"*/{REQUEST}")
    requests = [path for path in paths if is_regular(path)]
    for request in sorted(requests, key=lambda path: -path.stat().st_mtime)[:1]:
        if (stored := read_request(request)) is not None:
            folder, settings = stored
            # A project that was moved together with its photos.
            for place in (folder, project.parent / folder.name):
                if is_folder(place):
                    return place, settings
    return None


def read_survey_report(out: Path) -> SurveyReport | None:
    """The survey report of a finished reconstruction; None where there is none."""
    from vomstudio.photogrammetry.survey.check_results import SurveyReport

    try:
        result = read_json(out / RESULT)
        return serialisation.decode(SurveyReport, result["survey"])
    except (OSError, ValueError, TypeError, KeyError, WorkerError):
        return None


def record_reconstruction(studio: Studio, photo_set_id: str, folder: Path, name: str) -> None:
    """Add a finished reconstruction and its registration to the records of the project."""
    try:
        records = read_reconstruction(folder, photo_set_id, name)
    except VomError as error:
        studio.fail(error)
        return
    studio.attempt(add_reconstruction, *records)


def fill_camera_positions(out: Path, rows: Sequence[PhotoRow]) -> bool | None:
    """Enter into the rows the positions and headings of the aligned cameras. True where north is
    known, False in a local frame, None where nothing has been aligned."""
    if not (out / FILE_NAME).exists():
        return None
    try:
        cameras = read_cameras(out / FILE_NAME)
    except VomError:
        return None
    views = {view.name: view for view in cameras.views}
    for row in rows:
        row.place = row.looks = None
        if (view := views.get(row.name)) is not None:
            x, y, _ = view.centre
            dx, dy, _ = view.direction
            size = (dx * dx + dy * dy) ** 0.5
            row.place = (float(x), float(y))
            row.looks = (float(dx / size), float(dy / size)) if size > _MIN_ARROW_LENGTH else None
    return cameras.crs is not None


def _same_photos(stored_folder: Path, folder: Path) -> bool:
    """Whether a reconstruction was made of these photos; those that are gone have been moved."""
    return not stored_folder.is_dir() or stored_folder.resolve() == folder.resolve()
