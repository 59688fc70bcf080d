"""Folders of the reconstructions in a project and the files in these folders."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.errors import InputError, TargetError, VomError, WorkerError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.containment import check_generated_path, make_folder
from vomstudio.core.files.regular import is_folder, is_regular_file, read_json, read_small_file
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.io.models.reconstruction_file import RESULT
from vomstudio.io.photos.cameras_file import FILE_NAME, read_cameras
from vomstudio.project.photo_edits import add_reconstruction
from vomstudio.project.reconstructions import (
    RECONSTRUCTIONS,
    REQUEST,
    read_reconstruction,
)
from vomstudio.project.records import Model
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.events import Failed
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings, read_request

if TYPE_CHECKING:
    from vomstudio.photogrammetry.survey.check_results import SurveyReport

_FAILURE_FILE = "work/failure.txt"
# Minimum horizontal length of a unit direction; steeper directions have no arrow on the map.
_MIN_ARROW_LENGTH = 0.2


def reconstruction_folder(project: Path, photos: Path, quality: str) -> Path:
    """Return the folder for a reconstruction of these photos at this quality.

    Folders are not reused if they belong to another quality, or to other photos whose folder has
    the same name.
    """
    folder = project / RECONSTRUCTIONS
    for number in itertools.count(1):
        suffix = "" if number == 1 else f"-{number}"
        out = folder / f"{photos.name}{suffix}-{quality}"
        request = read_request(out / REQUEST)
        if request is None or _is_same_folder(request[0], photos):
            return out
    raise AssertionError("counting ends never")


def is_begun(out: Path) -> bool:
    """Return whether an earlier run has completed some but not all stages."""
    return (out / "work").is_dir() and not (out / "report.html").exists()


def store_failure(out: Path, reason: str) -> None:
    """Store why the run failed, so that the next session can show it.

    An empty reason removes the file. Disk errors are ignored, since the run has already reported
    them.
    """
    with contextlib.suppress(OSError, TargetError):
        if reason:
            make_folder((out / _FAILURE_FILE).parent)
            write_bytes(
                check_generated_path(out / _FAILURE_FILE), reason.encode("utf-8"), force=True
            )
        else:
            (out / _FAILURE_FILE).unlink(missing_ok=True)


def report_failure(studio: Studio, out: Path, event: Failed) -> None:
    """Store why the run failed, and report the reason to the user."""
    store_failure(out, event.message)
    studio.warn(event.to_error(), "error")


def read_failure(out: Path) -> str:
    """Return why the last run failed, as a sentence; empty if it did not fail."""
    try:
        return read_small_file(out / _FAILURE_FILE).decode("utf-8", "replace").strip()
    except (InputError, OSError):
        return ""


def find_alignment(out: Path, photos: Path) -> Path | None:
    """Return the folder of a reconstruction of these photos that has cameras.

    The result is `out` if it has cameras, otherwise the newest matching folder, or None.
    """
    if (out / FILE_NAME).exists():
        return out
    cameras = out.parent.glob(f"*/{FILE_NAME}")
    folders = [camera.parent for camera in cameras if is_regular_file(camera)]
    requests = {camera: read_request(camera / REQUEST) for camera in folders}
    matches = [
        camera
        for camera, request in requests.items()
        if request is not None and _is_same_folder(request[0], photos)
    ]
    return max(matches, key=lambda each: (each / FILE_NAME).stat().st_mtime, default=None)


def find_newest(project: Path) -> tuple[Path, ReconstructionSettings] | None:
    """Return the photo folder and settings of the newest reconstruction.

    Returns None if the project has no reconstruction, its request cannot be read, or the photos are
    missing.
    """
    paths = (project / RECONSTRUCTIONS).glob(f"*/{REQUEST}")
    requests = [path for path in paths if is_regular_file(path)]
    for request in sorted(requests, key=lambda path: -path.stat().st_mtime)[:1]:
        if (result := read_request(request)) is not None:
            folder, settings = result
            # The project may have been moved together with its photos.
            for candidate in (folder, project.parent / folder.name):
                if is_folder(candidate):
                    return candidate, settings
    return None


def read_survey_report(out: Path) -> SurveyReport | None:
    """Return the survey report of a completed reconstruction, or None if unreadable."""
    from vomstudio.photogrammetry.survey.check_results import SurveyReport

    try:
        result = read_json(out / RESULT)
        return serialisation.decode(SurveyReport, result["survey"])
    except (OSError, ValueError, TypeError, KeyError, WorkerError):
        return None


def record_reconstruction(studio: Studio, photo_set_id: str, folder: Path, name: str) -> None:
    """Add a completed reconstruction and its registration to the records of the project."""
    try:
        records = read_reconstruction(folder, photo_set_id, name)
    except VomError as error:
        studio.fail(error)
        return
    studio.attempt(add_reconstruction, *records)


def fill_camera_positions(out: Path, rows: Sequence[PhotoRow], model: Model | None) -> Frame | None:
    """Set the positions and headings of the aligned cameras in the rows.

    Parameters
    ----------
    out : Path
        Folder of the reconstruction.
    rows : sequence of PhotoRow
    model : Model or None
        Placed model of these photos; its placement replaces that of the alignment.

    Returns
    -------
    Frame or None
        Frame of the positions, or None if no alignment can be read.
    """
    if not (out / FILE_NAME).exists():
        return None
    try:
        cameras = read_cameras(out / FILE_NAME)
    except VomError:
        return None
    frame = Frame("local") if cameras.is_scaled else Frame()
    if cameras.crs is not None:
        frame = Frame("crs", cameras.crs)
    to_world = np.eye(4)
    if model is not None:
        frame, to_world = model.frame, transform.matrix(model.to_world)
    views = {view.name: view for view in cameras.views}
    for row in rows:
        row.place = row.look_direction = None
        if (view := views.get(row.name)) is not None:
            x, y, _ = transform.apply(to_world, [view.centre + np.array(cameras.origin)])[0]
            dx, dy, _ = to_world[:3, :3] @ view.direction
            size = (dx * dx + dy * dy) ** 0.5
            is_steep = size <= _MIN_ARROW_LENGTH * transform.scale_factor(to_world)
            row.place = (float(x), float(y))
            row.look_direction = None if is_steep else (float(dx / size), float(dy / size))
    return frame


def _is_same_folder(stored_folder: Path, folder: Path) -> bool:
    """Return whether a reconstruction was made from these photos.

    If the stored folder is missing, the photos are assumed to have been moved.
    """
    return not stored_folder.is_dir() or stored_folder.resolve() == folder.resolve()
