"""CRS and units of coordinates, from the options or from the statements of the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.finding_texts import Severity
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gate.frame_options import FrameOptions
from vomstudio.io.gis.axis_units import StatedAxes, stated_axes
from vomstudio.io.gis.crs import crs_name, parse_crs_option

MAX_SHOWN_CHARACTERS = 80
_UNIT_TOLERANCE = 2e-7
"""Relative tolerance; files state the US survey foot with seven digits."""


def choose_axes(
    text: str | None,
    options: FrameOptions,
    *,
    file: Path,
    height_unit: str | None = None,
) -> tuple[StatedAxes, tuple[Finding, ...]]:
    """Choose the CRS and units of coordinates.

    Parameters
    ----------
    text : str or None
        Code, name or WKT of the CRS stated by the file.
    options : FrameOptions
        Options of the caller, which override the statements of the file.
    file : Path
        File of the coordinates, for error messages.
    height_unit : str, optional
        Unit of the heights that the file states in addition to the CRS, as a key of
        `METRES_PER_UNIT`.

    Returns
    -------
    StatedAxes
    findings : tuple of Finding
        ``frame.crs-unreadable`` if the stated CRS is not known and the options specify none;
        ``frame.crs-replaced`` if the options specify a CRS other than that of the file.

    Raises
    ------
    UsageError
        If an option is not a usable CRS, or if a unit is not that of the CRS.
    """
    findings: list[Finding] = []
    try:
        text_axes = stated_axes(text, height_unit)
    except InputError:
        text_axes = stated_axes(None, height_unit)
        if options.crs is None:
            findings.append(crs_reading_finding(file, text or ""))
    axes = text_axes
    if options.crs is not None:
        axes = _option_axes(options, height_unit, file)
        if text_axes.crs is not None and text_axes.crs != axes.crs:
            findings.append(
                Finding(
                    "frame.crs-replaced",
                    file=file.name,
                    file_crs=crs_name(text_axes.crs),
                    crs=crs_name(axes.crs or options.crs),
                )
            )
    if options.unit is not None:
        axes = _check_unit(axes, options.unit, file)
    return axes, tuple(findings)


def crs_reading_finding(file: Path, text: str) -> Finding:
    """Return the finding for a CRS that is not known."""
    shown_text = " ".join(text.split())[:MAX_SHOWN_CHARACTERS]
    return Finding("frame.crs-unreadable", file=file.name, crs=shown_text)


def require_crs(axes: StatedAxes, file: Path) -> str:
    """Return the CRS to convert from. Raises UsageError if neither file nor options state one."""
    if axes.crs is None:
        raise UsageError(Finding("frame.no-crs"), file=file, field="--to-crs")
    return axes.crs


def assumed_frame_findings(
    file: Path,
    options: FrameOptions,
    *,
    up: str,
    unit: str,
    has_up: bool,
    has_unit: bool,
    severity: Severity | None = None,
) -> tuple[Finding, ...]:
    """Return ``frame.assumed`` if neither file nor options state the up axis or the unit.

    Parameters
    ----------
    file : Path
    options : FrameOptions
    up, unit : str
        Up axis and unit that are used.
    has_up, has_unit : bool
        Whether the file states them.
    severity : optional
        Severity of the finding. If None, that of the catalogue is used.
    """
    has_up, has_unit = has_up or options.up is not None, has_unit or options.unit is not None
    if has_up and has_unit:
        return ()
    assumed_up, assumed_unit = None if has_up else up, None if has_unit else unit
    return (assumption_finding(file, up=assumed_up, unit=assumed_unit, severity=severity),)


def assumption_finding(
    file: Path, *, up: str | None, unit: str | None, severity: Severity | None = None
) -> Finding:
    """Return ``frame.assumed`` for a file without a CRS.

    Parameters
    ----------
    file : Path
    up, unit : str or None
        Assumed up axis and unit; None if they are stated, so that they are not values of the
        finding.
    severity : optional
        Severity of the finding. If None, that of the catalogue is used.
    """
    values = {"up": up, "unit": unit}
    texts = {"up": tr("{up} up", up=up), "unit": tr("unit {unit}", unit=unit)}
    assumed_values = {name: value for name, value in values.items() if value is not None}
    assumption_texts = [*(texts[name] for name in assumed_values), tr("no CRS")]
    return Finding(
        "frame.assumed",
        severity,
        file=file.name,
        assumed=assumption_texts,
        **assumed_values,
        crs=None,
    )


def _option_axes(options: FrameOptions, height_unit: str | None, file: Path) -> StatedAxes:
    assert options.crs is not None
    if options.to_crs is None:
        parse_crs_option(options.crs)
    try:
        return stated_axes(options.crs, height_unit)
    except InputError as error:
        raise UsageError(error, file=file, field="--crs") from error


def _check_unit(axes: StatedAxes, unit: str, file: Path) -> StatedAxes:
    """Compare the unit given in the options with the CRS, and return the axes to be used.

    These are empty for a local system, whose unit is replaced by that of the options.

    Raises
    ------
    UsageError
        If the CRS of the axes has another unit.
    """
    if axes.kind == "local":
        return StatedAxes()
    if axes.kind != "projected" or axes.crs is None or axes.unit_m is None:
        return axes
    if np.isclose(METRES_PER_UNIT[unit], axes.unit_m, rtol=_UNIT_TOLERANCE, atol=0.0):
        return axes
    raise UsageError(
        Finding("frame.unit-contradiction", crs=crs_name(axes.crs), metres=axes.unit_m, unit=unit),
        file=file,
        field="--unit",
    )
