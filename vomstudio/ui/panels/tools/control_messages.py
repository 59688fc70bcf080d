"""Texts for the panel of control points, known lines and compass readings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.readings import Readings

if TYPE_CHECKING:
    from vomstudio.registration.results import ModelPlacement

_WINDOW_NAMES = {
    "(--without)": to_translate("(clear the tick)"),
    "(--north-sigma)": to_translate("(North)"),
}
"""Texts that replace, in the window, the command-line options mentioned in findings."""


def placement_problem(
    points: Sequence[ControlPoint],
    lines: Sequence[KnownLine],
    pair_count: int,
    error: VomError,
    readings: Readings,
) -> Finding:
    """Return why the model is not placed, or what the user has to do next.

    `pair_count` is the number of complete points.
    """
    from vomstudio.studio.placing.known_lines import placement_lines
    from vomstudio.studio.placing.known_planes import placement_readings

    if placement_lines(lines) or placement_readings(lines, readings.directions):
        return to_finding(error)
    if not points:
        if any(not line.is_complete for line in lines):
            return Finding("line.value-missing")
        return Finding("registration.not-begun")
    if not pair_count and not any(p.position for p in points):
        return Finding("control.coordinates-missing")
    unclicked_count = sum(p.position is not None and not p.vertices for p in points)
    if pair_count < 3 and unclicked_count:
        return Finding("control.click-points", found=pair_count, count=pair_count + unclicked_count)
    return to_finding(error)


def format_placement(placement: ModelPlacement, model: Model | None, crs: str | None) -> str:
    """Format the residuals, frame accuracy and warnings of a placement."""
    from vomstudio.registration.warnings import vertical_error_findings
    from vomstudio.studio.placing.known_lines import frame_after_placement

    lines = [_format_residuals(placement)]
    if model is not None and not placement.known.all:
        accuracy = frame_after_placement(placement, model, crs).known_text()
        frame_lines = [
            tr("After registering: {known}", known=accuracy),
            *map(str, vertical_error_findings(placement)),
        ]
        # Blunders are listed before the accuracy, which they affect.
        lines = [*lines, *frame_lines] if placement.blunders else [*frame_lines, *lines]
    text = "\n".join(lines)
    for option, name in _WINDOW_NAMES.items():
        text = text.replace(option, tr(name))
    return text


def reading_tips(
    lines: Sequence[KnownLine],
    readings: Readings,
    placement: ModelPlacement | None,
    turned_deg: float,
    studio: Studio,
) -> Mapping[str, str]:
    """Format the tooltips of the compass readings, by line id.

    A tooltip compares the reading with the placed model and states the effect of omitting the
    reading, or explains why the reading is not used.
    """
    from vomstudio.project.records import get_feature

    tips = {}
    for line in lines:
        if not line.is_read:
            continue
        if line.id not in readings.directions:
            feature = get_feature(studio.records, line.feature_id)
            tips[line.id] = (
                tr("The measured plane or line is no longer in the project.")
                if feature is None
                else tr("{feature} currently has no plane or direction.", feature=feature.name)
            )
        elif placement is not None:
            notation = studio.settings.notation
            tips[line.id] = "\n".join(
                _format_reading_tip(
                    line=line,
                    readings=readings,
                    placement=placement,
                    turned_deg=turned_deg,
                    notation=notation,
                )
            )
    return tips


def _format_reading_tip(
    line: KnownLine, readings: Readings, placement: ModelPlacement, turned_deg: float, notation: str
) -> list[str]:
    from dataclasses import replace

    from vomstudio.geology.orientation import Line, Plane
    from vomstudio.project.kinds.known_line import format_reading
    from vomstudio.studio.placing.known_planes import placed_direction

    direction = readings.directions[line.id]
    vector = placed_direction(direction, placement)
    if line.kind == "plane":
        plane = Plane.from_normal(vector)
        angles = round(plane.dip_direction_deg, 1), round(plane.dip_deg, 1)
    else:
        axis = Line.from_vector(vector)
        angles = round(axis.trend_deg, 1), round(axis.plunge_deg, 1)
    model_text = format_reading(
        replace(line, value=angles[0] % 360.0, inclination_deg=angles[1]), notation
    )
    read_line = replace(line, value=round(((line.value or 0.0) + turned_deg) % 360.0, 1))
    lines = [
        tr(
            "On the model: {placed}; reading: {read}.",
            placed=model_text,
            read=format_reading(read_line, notation),
        )
    ]
    if direction.sigma_deg is not None and line.sigma is not None:
        lines.append(
            tr(
                "The attitude on the model has its own error of ± {error:.1f}° (1σ), which is"
                " included.",
                error=direction.sigma_deg,
            )
        )
    for result in placement.without:
        if result.label == line.name:
            lines.append(
                tr(
                    "Without this reading, the others agree to {others:.1f}° (RMS), and the model"
                    " rotates by {turn:.1f}°.",
                    others=result.others_deg,
                    turn=result.turned_deg,
                )
            )
    return lines


def _format_residuals(placement: ModelPlacement) -> str:
    from vomstudio.registration.warnings import worst_axis_findings

    lines = []
    if placement.rms_control_m is not None:
        lines.append(
            tr(
                "Control points: {control:.3f} m (RMS).",
                control=placement.rms_control_m,
            )
        )
    if placement.rms_check_m is not None:
        lines.append(tr("Check points: {check:.3f} m (RMS).", check=placement.rms_check_m))
    lines += map(str, worst_axis_findings(placement))
    # Warnings about points are listed before the residuals.
    return "\n".join([*map(str, reversed(placement.warnings)), " ".join(lines)])
