"""Summaries of registrations for reports and the model panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import Line
from vomstudio.geometry import transform
from vomstudio.geometry.frames import crs_label
from vomstudio.geometry.registrations import ReadNorth, Registration
from vomstudio.geometry.units import length_text
from vomstudio.project.records import Model
from vomstudio.project.registration_errors import bowing_of_registration
from vomstudio.registration.scatter import scale_findings
from vomstudio.registration.turn_checks import turn_findings, worst_turn95_deg
from vomstudio.registration.warnings import (
    bowing_findings,
    describe_edges,
    lens_bend_findings,
    weakest_axis_finding,
)

_Z95 = 1.959963984540054
_MIN_REDUNDANT_POINTS = 4
_SCALE_TOLERANCE = 1e-9
METHODS = {
    "gps": to_translate("GPS positions of the cameras"),
    "control": to_translate("control points marked in photos"),
    "points": to_translate("control points picked on the model"),
    "attitudes": to_translate("attitudes of the cameras"),
    "lines": to_translate(
        "lines on the model that are level, vertical, or of known azimuth or length, or what was "
        "read by compass"
    ),
    "reference": to_translate("another model, to which it was fitted"),
    "local": to_translate("nothing outside of the photos"),
}

_OBSERVATIONS = {
    "points": to_translate("points"),
    "cameras": to_translate("positions of cameras"),
    "attitudes": to_translate("attitudes of cameras"),
    "verticals": to_translate("verticals of cameras"),
    "lengths": to_translate("lengths"),
    "level_lines": to_translate("level lines"),
    "plumb_lines": to_translate("plumb lines"),
    "photo_upright": to_translate("upright of the photos"),
    "azimuths": to_translate("azimuths"),
    "compass": to_translate("compass readings"),
    "reference": to_translate("surfaces of another model"),
    "kept_scale": to_translate("scale that was kept"),
}

_NORTHS = {
    "grid": to_translate("grid north"),
    "true": to_translate("true north"),
    "magnetic": to_translate("magnetic north"),
}


@dataclass(frozen=True)
class Summary:
    """Summary of a registration.

    Attributes
    ----------
    sentence : str
        Description of the possible rotation error; "" if unknown.
    facts : tuple of (str, str)
        Names and values as text.
    """

    sentence: str
    facts: tuple[tuple[str, str], ...]
    warnings: tuple[Finding, ...]


def summary_of(registration: Registration) -> Summary:
    """Describe a registration in words, with 95 % errors.

    Parameters
    ----------
    registration : Registration

    Returns
    -------
    Summary
    """
    facts = [(tr("Registered by"), tr(METHODS[registration.method])), *_points(registration)]
    if registration.observations:
        facts.append((tr("Observations"), _observations(registration)))
    sentence = ""
    rotation = registration.rotation_covariance()
    if rotation is not None:
        east, north, up = _Z95 * np.degrees(np.sqrt(np.maximum(np.diag(rotation), 0.0)))
        for name, error in (
            (tr("Turned about up, 95 %"), up),
            (tr("Turned about north, 95 %"), north),
            (tr("Turned about east, 95 %"), east),
        ):
            facts.append((name, f"± {error:.2g}°"))
        axes = np.linalg.eigh(rotation)[1]
        worst = worst_turn95_deg(rotation) or 0.0
        axis = Line.from_vector(axes[:, -1])
        where = f"{format_azimuth(axis.trend_deg)}/{axis.plunge_deg:02.0f}"
        facts.append((tr("Weakest axis, 95 %"), f"{where} ± {worst:.2g}°"))
        sentence = weakest_axis_finding(worst, axis.trend_deg, axis.plunge_deg).message
    if registration.scale_error is not None:
        facts.append((tr("Scale, 95 %"), f"± {100.0 * _Z95 * registration.scale_error:.2g} %"))
    facts += _north(registration.read_north)
    bowing = bowing_of_registration(registration)
    if bowing is not None:
        text = (
            tr(
                "dips at the edge {side:.2g}° ± {error:.2g}° from the middle; edges {where}",
                side=bowing.side_deg,
                error=bowing.side_error95_deg,
                where=describe_edges(bowing),
            )
            if bowing.significant
            else tr("none shown, to ± {error:.2g}° at the edge", error=bowing.side_error95_deg)
        )
        facts.append((tr("Bowing by residuals, 95 %"), text))
    if registration.lens_bowing95_deg is not None:
        text = tr(
            "dips at the edge up to {side:.2g}° from the middle",
            side=registration.lens_bowing95_deg / 2.0,
        )
        facts.append((tr("Bowing by the lenses' errors, 95 %"), text))
    if registration.lens_stretch95:
        share = tr("up to {share:.2g} %", share=100.0 * registration.lens_stretch95)
        facts.append((tr("Depths stretched by the lenses' errors, 95 %"), share))
    return Summary(sentence, tuple(facts), tuple(_warnings(registration)))


def placement_facts(model: Model, resolution: float | None = None) -> list[tuple[str, str]]:
    """Describe the placement of a model by names and values.

    Parameters
    ----------
    model : Model
    resolution : float, optional
        Resolution in units of the model file.

    Returns
    -------
    list of (str, str)
        Names and values of the scale, the north and, if known, the resolution.
    """
    frame = model.frame
    metres = transform.scale_factor(model.to_world)
    if not frame.has_metres:
        scale = tr("not known")
    elif abs(metres - 1.0) < _SCALE_TOLERANCE:
        scale = tr("metres")
    else:
        scale = tr("metres; one unit of the file is {length}", length=length_text(metres, 4))
    if frame.kind == "crs":
        north = tr("grid north of {crs}", crs=crs_label(frame.crs or ""))
    else:
        north = tr("known") if frame.has_north else tr("not known")
    facts = [(tr("Scale"), scale), (tr("North"), north)]
    if resolution:
        shown = length_text(resolution * metres, metric=frame.has_metres)
        facts.append((tr("Resolution"), shown))
    return facts


def _observations(registration: Registration) -> str:
    """Return the number of observations of each kind used for the registration."""
    return ", ".join(
        tr(name)
        if group.kind in ("reference", "kept_scale", "photo_upright")
        else tr("{name}: {count}", name=tr(name), count=group.count)
        for group in registration.observations
        for name in [_OBSERVATIONS.get(group.kind, group.kind)]
    )


def _north(read: ReadNorth | None) -> list[tuple[str, str]]:
    """Return the north reference of azimuths and their common error."""
    if read is None:
        return []
    counted = tr(_NORTHS[read.north])
    if read.north != "grid":
        counted = tr("{north}, {turned:+.2f}° added", north=counted, turned=read.turned_deg)
    facts = [(tr("Azimuths were read from"), counted)]
    if read.declination_deg is not None:
        angle = f"{read.declination_deg:+.2f}°"
        source = tr("stated") if read.stated else tr("IGRF-14, {day}", day=read.day)
        facts.append((tr("Declination"), f"{angle} ({source})"))
    doubt = tr("± {angle:g}° for all alike (1σ)", angle=read.doubt_deg)
    return [*facts, (tr("North may be off by"), doubt)]


def _points(registration: Registration) -> list[tuple[str, str]]:
    control = [p for p in registration.control if not p.check]
    check = [p for p in registration.control if p.check]
    gps = registration.method == "gps"
    facts = []
    if control:
        facts.append((tr("GPS positions") if gps else tr("Control points"), str(len(control))))
    if registration.control and not gps:
        facts.append((tr("Check points"), str(len(check))))
    rms = registration.rms_control_m
    if rms is None and control:
        rms = float(np.sqrt(np.mean([np.square(p.residual).sum() for p in control])))
    if rms is not None:
        name = tr("RMS of GPS positions") if gps else tr("RMS of control points")
        facts.append((name, tr("{length:.3g} m", length=rms)))
    if registration.rms_check_m is not None:
        length = tr("{length:.3g} m", length=registration.rms_check_m)
        facts.append((tr("RMS of check points"), length))
    return facts


def _warnings(registration: Registration) -> list[Finding]:
    findings: list[Finding] = [*turn_findings(registration.rotation_covariance())]
    control = [p for p in registration.control if not p.check]
    # If the model was fitted to another model, the surfaces check the points.
    uses_points = registration.method != "reference"
    if uses_points and 0 < len(control) < _MIN_REDUNDANT_POINTS:
        findings.append(
            Finding("control.no-redundancy", count=len(control), least=_MIN_REDUNDANT_POINTS)
        )
    uses_points = uses_points and registration.method != "gps"
    if uses_points and 0 < len(control) == len(registration.control):
        findings.append(Finding("control.no-check-points"))
    if registration.scale_error is not None:
        findings += scale_findings(registration.scale_error)
    bowing = bowing_of_registration(registration)
    findings += bowing_findings(bowing)
    if registration.lens_bowing95_deg is not None:
        findings += lens_bend_findings(
            registration.lens_bowing95_deg, registration.lens_stretch95, bowing
        )
    return findings
