"""Photo surveys: plans, and metadata and checks of photos before the reconstruction."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from vomstudio.api.checking import (
    check_flag,
    name_argument_in_errors,
    optional_path,
    required_text,
    to_path,
    warn,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.findings import Finding
from vomstudio.io.photos.reading import PhotoFolder
from vomstudio.photogrammetry.survey.folder_check import FolderCheck
from vomstudio.photogrammetry.survey.planning import SurveyPlan
from vomstudio.photogrammetry.survey.survey_options import CheckOptions, PlanOptions

if TYPE_CHECKING:
    from vomstudio.photogrammetry.survey.plan_camera import PlanCamera


def read_photos(folder: str | Path, *, progress: ProgressArgument = None) -> PhotoFolder:
    """Read the metadata of the photos in a folder, without decoding them.

    Parameters
    ----------
    folder : str or Path
        Folder of JPEG, HEIC, TIFF and PNG photos, which is searched three levels deep.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).

    Returns
    -------
    PhotoFolder
        ``photos`` (each with ``name``, ``width``, ``height``, ``camera``, ``focal_mm``,
        ``focal_px``, ``latitude_deg``, ``longitude_deg``, ``altitude_m`` with its
        reference, ``mask`` and others; None if not stated), ``skipped`` (name and reason),
        ``warnings``, ``cameras()``.

    Raises
    ------
    vs.errors.InputError
        If the folder does not exist or contains no usable photo.

    Examples
    --------
    >>> import vomstudio as vs
    >>> photos = vs.read_photos(vs.sample("photos"))
    >>> len(photos.photos), photos.photos[0].name
    (12, 'HL_2041.jpg')
    """
    from vomstudio.io.photos import reading

    survey = reading.read_photos(to_path(folder, "folder"), to_progress(progress))
    skipped_photos = [
        Finding("photo.left-out", photo=name, reason=reason) for name, reason in survey.skipped
    ]
    warn([*survey.warnings, *skipped_photos])
    return survey


def check(
    folder: str | Path, *, distance_m: float | None = None, progress: ProgressArgument = None
) -> FolderCheck:
    """Check a set of photos before alignment, and recommend what to shoot next time.

    Parameters
    ----------
    folder : str or Path
        Folder of photos.
    distance_m : float, optional
        Distance from the camera to the rock, metres, if known.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).

    Returns
    -------
    FolderCheck
        ``photos`` (``name``, ``gsd_m``, ``blur`` in pixels, ``views`` and others), ``findings``
        (``code``, ``severity``, ``message``, ``values``), ``plane_error``
        (``size_m``, ``error95_deg``), ``verdict``, ``next_time``.

    Raises
    ------
    vs.errors.InputError
        If the folder contains no photos.
    vs.errors.UsageError
        If the distance is invalid.

    Notes
    -----
    The rules follow sections 2.4 and 3.2 of the textbook; each finding states its value.

    Examples
    --------
    >>> import shutil, tempfile, pathlib
    >>> import vomstudio as vs
    >>> one = pathlib.Path(tempfile.mkdtemp())
    >>> _ = shutil.copy(vs.sample("photos", "HL_2041.jpg"), one)
    >>> vs.check(one).findings[0].code
    'one-photo'
    """
    from vomstudio.photogrammetry.survey.folder_check import check_folder

    options = options_from_arguments(CheckOptions, distance_m=distance_m)
    folder_check, _ = check_folder(
        to_path(folder, "folder"), options.distance_m, to_progress(progress)
    )
    return folder_check


def plan(
    camera: str | Path,
    *,
    width_m: float,
    height_m: float,
    distance_m: float | None = None,
    gsd_m: float | None = None,
    plane_m: float | None = None,
    overlap: float = 0.7,
    manner: Literal["handheld", "drone", "terrain"] = "handheld",
    aperture: float | None = None,
    focal_mm: float | None = None,
    receiver_m: float | None = None,
    control_m: float | None = None,
    sheet: str | Path | None = None,
    force: bool = False,
) -> SurveyPlan:
    """Plan a photo survey: positions, views and control points.

    Parameters
    ----------
    camera : str or Path
        Name of the camera, path of a photo taken with it, or "23.5x15.6,35,6000x4000"
        (sensor size and focal length in mm, image size in pixels).
    width_m, height_m : float
        Size of the outcrop, metres.
    distance_m, gsd_m, plane_m : float, optional
        Exactly one of distance from camera to rock, size of a pixel on the rock, and size
        of the smallest plane to measure; metres.
    overlap : float, optional
        Overlap of adjacent photos, 0.6 to 0.95.
    manner : {"handheld", "drone", "terrain"}, optional
        Whether photos are taken on foot, by drone in front of a cliff, or by drone over flat
        terrain.
    aperture : float, optional
        F-number, if it can be set; 8 by default.
    focal_mm : float, optional
        Focal length in mm, if the name of the camera does not include it.
    receiver_m, control_m : float, optional
        One-sigma errors of the camera receiver (default 3) and of control points (default
        0.02), metres.
    sheet : str or Path, optional
        Additional field sheet to print (.pdf, .svg, .html).
    force : bool, optional
        Whether to replace an existing file.

    Returns
    -------
    SurveyPlan
        ``gsd_m``, ``footprint_m``, ``spacing_m``, ``photos``, ``smallest_plane_m``,
        ``plane_error`` (each ``size_m``, ``error95_deg``), ``depth_of_field_m``,
        ``positions``, ``control_points``, ``registration``, ``warnings``.

    Raises
    ------
    vs.errors.UsageError
        If the camera is unknown or a length is invalid.
    vs.errors.TargetError
        If the sheet exists or cannot be written.

    Notes
    -----
    The ground sampling distance follows equation 18 of the textbook; the smallest plane is 1000
    pixels wide.

    Examples
    --------
    Size on the rock, at 20 m, of a pixel of a 23.5 mm sensor with 6000 pixels and a 35 mm lens:

    >>> import vomstudio as vs
    >>> camera = "23.5x15.6,35,6000x4000"
    >>> survey = vs.plan(camera, distance_m=20, width_m=30, height_m=10, manner="drone")
    >>> round(survey.gsd_m, 5) == round(23.5 / 6000 * 20 / 35, 5)
    True
    """
    from vomstudio.core.files.atomic import check_target
    from vomstudio.photogrammetry.survey.plan_forecast import add_forecasts
    from vomstudio.photogrammetry.survey.planning import plan_survey
    from vomstudio.products.report.field_sheet import check_format, write_field_sheet

    options = options_from_arguments(PlanOptions, locals())
    page, replace = optional_path(sheet, "sheet"), check_flag(force, "force")
    with name_argument_in_errors("sheet", "--output"):
        if page is not None:
            check_format(page)
            check_target(page, force=replace)
    with name_arguments_in_errors(PlanOptions), name_argument_in_errors("camera", "--camera"):
        plan = plan_survey(_camera(camera, options.focal_mm), options)
    plan = add_forecasts(plan, options.receiver_m, options.control_m)
    if page is not None:
        write_field_sheet(page, plan, force=replace)
    warn(plan.warnings)
    return plan


def _camera(camera: Any, focal_mm: float | None) -> PlanCamera:
    """Return the camera of a plan. Raises InputError, UsageError."""
    from vomstudio.photogrammetry.survey.plan_camera import parse_camera

    camera_text = os.fspath(camera) if isinstance(camera, os.PathLike) else camera
    return parse_camera(required_text(camera_text, "camera"), focal_mm)
