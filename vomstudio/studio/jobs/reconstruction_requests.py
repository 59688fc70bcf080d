"""Creation of reconstruction requests from the options of a command or function."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.containment import check_in_project
from vomstudio.core.findings import Finding
from vomstudio.io.control.control_files import find_control, marks_path
from vomstudio.io.control.points import MARKS
from vomstudio.io.gis.crs import parse_crs_option
from vomstudio.io.photos.reading import photo_names
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions
from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest

CONTROL_OFF = "none"


def reconstruction_request(
    photos: str | Path,
    output: str | Path,
    options: ReconstructOptions,
) -> tuple[ReconstructionRequest, list[Finding]]:
    """Create the request for a reconstruction, with findings about unused tables.

    Raises
    ------
    InputError, UsageError
    """
    folder, out = Path(photos), Path(output)
    if not folder.is_dir():
        raise InputError(Finding("folder.not-of-photos"), file=folder)
    check_in_project(out)
    if out.resolve() == folder.resolve():
        raise UsageError(
            Finding("folder.of-photos"),
            field="--output",
        )
    crs = None if options.crs is None else _crs(options.crs)
    points, marks, findings = _find_tables(folder, options.gcp, options.marks)
    order = ReconstructionRequest.of(
        folder.resolve(), out.resolve(), replace(options, crs=crs), points, marks
    )
    return order, findings


def _crs(text: str) -> str:
    crs, metres = parse_crs_option(text)
    if metres != 1.0:
        raise UsageError(
            Finding("frame.not-in-metres", crs=crs),
            field="--crs",
        )
    return crs


def _find_tables(
    photos: Path, gcp: str | Path | None, marks_option: str | Path | None
) -> tuple[Path | None, Path | None, list[Finding]]:
    """Return the tables of control points and marks, or None if not used, and findings.

    Raises InputError if a table given by the user, or the marks for it, do not exist.
    """
    from vomstudio.photogrammetry.georeferencing.mark_prediction import usable_tables

    specified_marks = None if marks_option is None else Path(marks_option).resolve()
    photos = photos.resolve()
    photo_marks = photos / MARKS
    if gcp is None or str(gcp).casefold() == CONTROL_OFF:
        control_path, marks = find_control(photos) or (
            None,
            photo_marks if photo_marks.is_file() else None,
        )
        marks = specified_marks or marks
        _require_file(marks, "--marks")
        if gcp is not None:
            return None, marks, []
        names = [] if control_path is None else photo_names(photos)
        control, marks, findings = usable_tables(control_path, marks, names)
        reasons = [
            Finding(
                "reconstruct.tables-unused",
                file=control_path,
                reason=finding.message,
                reason_code=finding.code,
            )
            for finding in findings
        ]
        return control, marks, reasons
    control = Path(gcp).resolve()
    marks = specified_marks
    _require_file(control, "--gcp")
    if marks is None and photo_marks.is_file() and not marks_path(control).is_file():
        marks = photo_marks
    if marks is None and not (marks := marks_path(control)).is_file():
        raise InputError(
            Finding("control.marks-missing"),
            file=marks,
            field="--marks",
        )
    _require_file(marks, "--marks")
    return control, marks, []


def _require_file(path: Path | None, field: str) -> None:
    if path is not None and not path.is_file():
        raise InputError(Finding("file.missing"), file=path, field=field)
