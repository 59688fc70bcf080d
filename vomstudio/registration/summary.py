"""Summaries of registrations for reports and the model panel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.bowing import Bowing
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import Line
from vomstudio.geometry import transform
from vomstudio.geometry.frames import crs_label
from vomstudio.geometry.registrations import NorthReference, Registration
from vomstudio.geometry.units import length_text
from vomstudio.project.records import Model
from vomstudio.project.registration_errors import registration_bowing
from vomstudio.registration.rotation_uncertainty import turn_findings, worst_turn95_deg
from vomstudio.registration.scatter import scale_findings
from vomstudio.registration.warnings import (
    bowing_findings,
    describe_edges,
    lens_bend_findings,
    weakest_axis_finding,
)

_Z95 = 1.959963984540054
_MIN_REDUNDANT_POINTS = 4
_SCALE_TOLERANCE = 1e-9
METHOD_NAMES = {
    "gps": to_translate("GPS positions of the cameras"),
    "control": to_translate("control points marked in photos"),
    "points": to_translate("control points picked on the model"),
    "attitudes": to_translate("attitudes of the cameras"),
    "lines": to_translate("lines on the model with known direction or length, or compass readings"),
    "reference": to_translate("fit to another model"),
    "local": to_translate("photos only"),
}

_OBSERVATION_NAMES = {
    "points": to_translate("points"),
    "cameras": to_translate("camera positions"),
    "attitudes": to_translate("camera attitudes"),
    "verticals": to_translate("camera verticals"),
    "lengths": to_translate("lengths"),
    "level_lines": to_translate("level lines"),
    "plumb_lines": to_translate("plumb lines"),
    "photo_upright": to_translate("upright direction of the photos"),
    "azimuths": to_translate("azimuths"),
    "compass": to_translate("compass readings"),
    "reference": to_translate("surfaces of another model"),
    "kept_scale": to_translate("fixed scale"),
}

_NORTH_NAMES = {
    "grid": to_translate("grid north"),
    "true": to_translate("true north"),
    "magnetic": to_translate("magnetic north"),
}

FACT_NAMES = {
    "method": to_translate("Registered by"),
    "observations": to_translate("Observations"),
    "gps-positions": to_translate("GPS positions"),
    "control-points": to_translate("Control points"),
    "check-points": to_translate("Check points"),
    "rms-gps": to_translate("RMS of GPS positions"),
    "rms-control": to_translate("RMS of control points"),
    "rms-check": to_translate("RMS of check points"),
    "turned-about-up": to_translate("Rotation about up, 95 %"),
    "turned-about-north": to_translate("Rotation about north, 95 %"),
    "turned-about-east": to_translate("Rotation about east, 95 %"),
    "weakest-axis": to_translate("Weakest axis, 95 %"),
    "scale": to_translate("Scale, 95 %"),
    "azimuths-read-from": to_translate("Azimuths refer to"),
    "declination": to_translate("Declination"),
    "north-error": to_translate("Error of north"),
    "bowing": to_translate("Bowing from residuals, 95 %"),
    "lens-bowing": to_translate("Bowing from lens errors, 95 %"),
    "lens-stretch": to_translate("Depth stretch from lens errors, 95 %"),
}
"""Names of the facts of a registration by their codes."""


@dataclass(frozen=True)
class Fact:
    """Figure of a registration.

    Parameters
    ----------
    code : str
        Key in `FACT_NAMES`.
    text : str
        The figure as text.
    values : dict
        The numbers and words from which the text was made, by name.
    """

    code: str
    text: str
    values: Mapping[str, Any]

    @property
    def name(self) -> str:
        """Name of the fact, in the user's language."""
        return tr(FACT_NAMES[self.code])


@dataclass(frozen=True)
class Summary:
    """Summary of a registration.

    Attributes
    ----------
    rotation : Finding or None
        The possible rotation error about the weakest axis; None if unknown.
    facts : tuple of Fact
    warnings : tuple of Finding
    """

    rotation: Finding | None
    facts: tuple[Fact, ...]
    warnings: tuple[Finding, ...]


def summarize_registration(registration: Registration) -> Summary:
    """Describe a registration in words, with 95 % errors.

    Parameters
    ----------
    registration : Registration

    Returns
    -------
    Summary
    """
    method = registration.method
    facts = [_fact("method", tr(METHOD_NAMES[method]), method=method), *_point_facts(registration)]
    if registration.observations:
        counts = {group.kind: group.count for group in registration.observations}
        facts.append(_fact("observations", _observations(registration), **counts))
    weakest = None
    rotation = registration.rotation_covariance()
    if rotation is not None:
        east, north, up = _Z95 * np.degrees(np.sqrt(np.maximum(np.diag(rotation), 0.0)))
        facts += [
            _fact(code, f"± {error:.2g}°", error95_deg=float(error))
            for code, error in (
                ("turned-about-up", up),
                ("turned-about-north", north),
                ("turned-about-east", east),
            )
        ]
        axes = np.linalg.eigh(rotation)[1]
        worst_turn_deg = worst_turn95_deg(rotation) or 0.0
        axis = Line.from_vector(axes[:, -1])
        axis_text = f"{format_azimuth(axis.trend_deg)}/{axis.plunge_deg:02.0f}"
        weakest = weakest_axis_finding(worst_turn_deg, axis.trend_deg, axis.plunge_deg)
        facts.append(
            _fact("weakest-axis", f"{axis_text} ± {worst_turn_deg:.2g}°", **weakest.values)
        )
    if registration.scale_error is not None:
        percent = 100.0 * _Z95 * registration.scale_error
        facts.append(_fact("scale", f"± {percent:.2g} %", error95_percent=percent))
    facts += [
        *_north_facts(registration.read_north),
        *_bowing_facts(registration_bowing(registration)),
        *_lens_facts(registration),
    ]
    return Summary(weakest, tuple(facts), tuple(_warnings(registration)))


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
        scale = tr("unknown")
    elif abs(metres - 1.0) < _SCALE_TOLERANCE:
        scale = tr("metres")
    else:
        scale = tr("metres; one unit of the file is {length}", length=length_text(metres, 4))
    if frame.kind == "crs":
        north = tr("grid north of {crs}", crs=crs_label(frame.crs or ""))
    else:
        north = tr("known") if frame.has_north else tr("unknown")
    facts = [(tr("Scale"), scale), (tr("North"), north)]
    if resolution:
        resolution_text = length_text(resolution * metres, is_metric=frame.has_metres)
        facts.append((tr("Resolution"), resolution_text))
    return facts


def _observations(registration: Registration) -> str:
    """Return the kinds of observations of a registration, with their numbers, as text."""
    return ", ".join(
        tr(name)
        if group.kind in ("reference", "kept_scale", "photo_upright")
        else tr("{name}: {count}", name=tr(name), count=group.count)
        for group in registration.observations
        for name in [_OBSERVATION_NAMES.get(group.kind, group.kind)]
    )


def _fact(code: str, text: str, **values: Any) -> Fact:
    return Fact(code, text, values)


def _bowing_facts(bowing: Bowing | None) -> list[Fact]:
    """Return the bowing that the residuals of the points show."""
    if bowing is None:
        return []
    values = {"side_deg": bowing.side_deg, "side_error95_deg": bowing.side_error95_deg}
    text = (
        tr(
            "dips at the edge wrong by {side:.2g}° ± {error:.2g}° relative to the centre; edges"
            " {where}",
            side=bowing.side_deg,
            error=bowing.side_error95_deg,
            where=describe_edges(bowing),
        )
        if bowing.significant
        else tr("none detected, within ± {error:.2g}° at the edge", error=bowing.side_error95_deg)
    )
    return [_fact("bowing", text, significant=bowing.significant, **values)]


def _lens_facts(registration: Registration) -> list[Fact]:
    """Return the bowing and the stretch that the errors of the lenses allow."""
    facts = []
    if registration.lens_bowing95_deg is not None:
        half_width_deg = registration.lens_bowing95_deg / 2.0
        text = tr(
            "dips at the edge wrong by up to {side:.2g}° relative to the centre",
            side=half_width_deg,
        )
        facts.append(_fact("lens-bowing", text, side_deg=half_width_deg))
    if registration.lens_stretch95:
        percent = 100.0 * registration.lens_stretch95
        facts.append(
            _fact("lens-stretch", tr("up to {share:.2g} %", share=percent), percent=percent)
        )
    return facts


def _north_facts(north: NorthReference | None) -> list[Fact]:
    """Return the north reference of azimuths and their common error."""
    if north is None:
        return []
    reference_text = tr(_NORTH_NAMES[north.north])
    if north.north != "grid":
        reference_text = tr(
            "{north}, {turned:+.2f}° added", north=reference_text, turned=north.turned_deg
        )
    facts = [
        _fact("azimuths-read-from", reference_text, north=north.north, turned_deg=north.turned_deg)
    ]
    if north.declination_deg is not None:
        angle = f"{north.declination_deg:+.2f}°"
        source = tr("stated") if north.stated else tr("IGRF-14, {day}", day=north.day)
        values = {"stated": north.stated, "day": north.day}
        angle_deg = north.declination_deg
        facts.append(_fact("declination", f"{angle} ({source})", angle_deg=angle_deg, **values))
    error_text = tr("± {angle:g}° common to all azimuths (1σ)", angle=north.doubt_deg)
    return [*facts, _fact("north-error", error_text, sigma_deg=north.doubt_deg)]


def _point_facts(registration: Registration) -> list[Fact]:
    control = [point for point in registration.control if not point.check]
    check = [point for point in registration.control if point.check]
    is_gps = registration.method == "gps"
    facts = []
    if control:
        code = "gps-positions" if is_gps else "control-points"
        facts.append(_fact(code, str(len(control)), count=len(control)))
    if registration.control and not is_gps:
        facts.append(_fact("check-points", str(len(check)), count=len(check)))
    rms = registration.rms_control_m
    if rms is None and control:
        rms = float(np.sqrt(np.mean([np.square(point.residual).sum() for point in control])))
    for code, length_m in (
        ("rms-gps" if is_gps else "rms-control", rms),
        ("rms-check", registration.rms_check_m),
    ):
        if length_m is not None:
            text = tr("{length:.3g} m", length=length_m)
            facts.append(_fact(code, text, length_m=length_m))
    return facts


def _warnings(registration: Registration) -> list[Finding]:
    findings: list[Finding] = [*turn_findings(registration.rotation_covariance())]
    control = [point for point in registration.control if not point.check]
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
    bowing = registration_bowing(registration)
    findings += bowing_findings(bowing)
    if registration.lens_bowing95_deg is not None:
        findings += lens_bend_findings(
            registration.lens_bowing95_deg, registration.lens_stretch95, bowing
        )
    return findings
