"""The frame of a model: what its file states, completed by options."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.core.finding_texts import TEXTS
from vomstudio.core.findings import Finding
from vomstudio.document.records import Frame, UpAxis
from vomstudio.errors import InputError, UsageError
from vomstudio.geometry.units import METRES
from vomstudio.io.gate.frame_options import AS_STATED, FrameOptions
from vomstudio.io.gate.metric import check_metric, looks_like_degrees
from vomstudio.io.gis.crs import metres_of, parse_crs, typed_crs
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.photos.cameras_file import scale_known
from vomstudio.words import tr


@dataclass(frozen=True)
class FrameWithFindings:
    """A frame, and what was assumed to establish it."""

    frame: Frame
    findings: tuple[Finding, ...] = ()


def establish_frame(loaded: LoadedModel, options: FrameOptions = AS_STATED) -> FrameWithFindings:
    """Establish the frame of a model that was read with the same options.

    A file that states nothing is taken as local, in metres, z up.

    Parameters
    ----------
    loaded : LoadedModel
        From `vomstudio.io.models.opening.read_model`.
    options : FrameOptions

    Returns
    -------
    FrameWithFindings
        With ``frame.assumed`` if neither file nor options define up axis and unit.

    Raises
    ------
    InputError
        With the code ``frame.not-metric`` for a CRS that is not metric at the data.
    UsageError
        For options that contradict the file's format or each other.
    """
    frame = _frame(loaded, options)
    if frame.crs is None:
        return FrameWithFindings(frame, _assumed(loaded, options, frame.up_axis))
    field = "--to-crs" if options.to_crs else "--crs" if options.crs else "CRS"
    bounds = np.asarray(loaded.data.bounds, np.float64)
    return FrameWithFindings(frame, check_frame(frame, bounds, file=loaded.path, field=field))


def check_frame(
    frame: Frame,
    bounds: npt.NDArray[np.float64],
    *,
    file: str | Path | None = None,
    field: str = "CRS",
) -> tuple[Finding, ...]:
    """Check that a frame is metric at the data.

    Parameters
    ----------
    frame : Frame
    bounds : (2, 3) float
        Lowest and highest corner in the file's frame.
    file, field : optional
        For the error.

    Returns
    -------
    tuple of Finding
        Empty for a frame without a CRS.

    Raises
    ------
    InputError
        With the code ``frame.not-metric``.
    """
    if frame.crs is None:
        return ()
    return check_metric(frame.crs, _map_bounds(bounds, frame), file=file, field=field)


def frame_findings(loaded: LoadedModel, options: FrameOptions = AS_STATED) -> tuple[Finding, ...]:
    """Return what `establish_frame` reports or would refuse."""
    try:
        return establish_frame(loaded, options).findings
    except InputError as error:
        if error.code not in TEXTS:
            raise
        return (Finding(error.code, **error.values),)


def _frame(loaded: LoadedModel, options: FrameOptions) -> Frame:
    if options.to_crs is not None:
        # The coordinates were converted when they were read.
        return Frame("crs", loaded.crs, 1.0, "z")
    up = _up_axis(loaded, options)
    if options.crs is not None:
        code, metres = typed_crs(options.crs)
        _require_unit(code, metres, options.unit)
        return Frame("crs", code, metres, up)
    if loaded.crs is not None:
        return Frame("crs", loaded.crs, _unit_of(loaded.crs, options.unit), up)
    unit_m = METRES[options.unit] if options.unit is not None else loaded.unit_m or 1.0
    return Frame("local", None, unit_m, up)


def _map_bounds(bounds: npt.NDArray[np.float64], frame: Frame) -> npt.NDArray[np.float64]:
    """Return lowest and highest east and north in the unit of the CRS, (2, 2)."""
    low, high = bounds
    if frame.up_axis == "y":
        # The file's z is South.
        return np.array([[low[0], -high[2]], [high[0], -low[2]]])
    return np.array([low[:2], high[:2]])


def frame_of_file(path: Path, crs: str | None) -> Frame:
    """Return the frame that a file states, undeclared if it states none.

    A model reconstructed with control points in a local system is in metres and knows north.
    """
    if crs:
        return Frame("crs", crs, metres_of(crs))
    return Frame("local") if scale_known(path) else Frame()


def _up_axis(loaded: LoadedModel, options: FrameOptions) -> UpAxis:
    if loaded.turned_about is None:
        return options.up or "z"
    if options.up == "z":
        raise UsageError(
            tr(
                "This format is Y-up by definition and is rotated to Z-up when it is read. To "
                "declare another up axis, first write the model in another format with "
                "vomstudio convert --up z."
            ),
            field="--up",
        )
    return "z"


def _assumed(loaded: LoadedModel, options: FrameOptions, up: UpAxis) -> tuple[Finding, ...]:
    """Return the findings about a file without a CRS."""
    if scale_known(loaded.path) is not None:
        # Our own reconstruction states what it knows in the file beside it.
        return ()
    maybe = looks_like_degrees(np.asarray(loaded.data.bounds, np.float64))
    findings = () if maybe is None or options.unit is not None else (maybe,)
    if options.is_given or (loaded.turned_about is not None and loaded.unit_m is not None):
        return findings
    unit = loaded.units[0] if loaded.unit_m is not None else "m"
    assumed = Finding("frame.assumed", file=loaded.path.name, up=up, unit=unit, crs=None)
    return (assumed, *findings)


def _unit_of(crs: str, unit: str | None) -> float:
    """Return the metres per unit of a CRS that a file names. Raises UsageError for another unit."""
    try:
        code, metres = parse_crs(crs)
    except InputError:  # not a projected CRS: used as it was before
        return 1.0 if unit is None else METRES[unit]
    _require_unit(code, metres, unit)
    return metres


def _require_unit(code: str, metres: float, unit: str | None) -> None:
    if unit is not None and METRES[unit] != metres:
        raise UsageError(
            tr(
                "The unit of {crs} is {metres:g} m, not {unit}. Leave out --crs or --unit.",
                crs=code,
                metres=metres,
                unit=unit,
            ),
            field="--unit",
        )
