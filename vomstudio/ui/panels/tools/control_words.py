"""What the panel of control points, known lines and compass readings says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.words import to_translate, tr
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.records import Model
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.readings import Readings

if TYPE_CHECKING:
    from vomstudio.registration.results import Placed

_IN_THE_WINDOW = {
    "(--without)": to_translate("(take its tick away)"),
    "(--declination)": to_translate("(North)"),
    "(--north-sigma)": to_translate("(North)"),
}
"""What the options of the command are here."""


def in_short(
    points: Sequence[ControlPoint],
    lines: Sequence[KnownLine],
    found: int,
    error: VomError,
    readings: Readings,
) -> Finding:
    """Why there is no placement, or what is to be done next. found : so many points are found"""
    from vomstudio.studio.placing.known_lines import placement_lines
    from vomstudio.studio.placing.known_planes import placement_readings

    if placement_lines(lines) or placement_readings(lines, readings.seen):
        return finding_of(error)
    if not points:
        if any(not line.is_complete for line in lines):
            return Finding("line.value-missing")
        return Finding("registration.not-begun")
    if not found and not any(p.position for p in points):
        return Finding("control.coordinates-missing")
    left = sum(p.position is not None and not p.vertices for p in points)
    if found < 3 and left:
        return Finding("control.click-points", found=found, count=found + left)
    return finding_of(error)


def placement_text(placed: Placed, model: Model | None, crs: str | None) -> str:
    """What a geologist must know of it."""
    from vomstudio.registration.warnings import vertical_error_findings
    from vomstudio.studio.placing.known_lines import frame_after_placement

    said = [_worth(placed)]
    if model is not None and not placed.known.all:
        known = frame_after_placement(placed, model, crs).known_text()
        then = [
            tr("After registering: {known}", known=known),
            *map(str, vertical_error_findings(placed)),
        ]
        # What is wrong comes before what is known by it.
        said = [*said, *then] if placed.blunders else [*then, *said]
    text = "\n".join(said)
    for option, name in _IN_THE_WINDOW.items():
        text = text.replace(option, tr(name))
    return text


def reading_tips(
    lines: Sequence[KnownLine],
    readings: Readings,
    placed: Placed | None,
    turned_deg: float,
    studio: Studio,
) -> Mapping[str, str]:
    """Of what was read by compass, by id: what the placed model shows, what else is in its error,
    and what becomes of the placement without it; or why it places nothing."""
    from vomstudio.project.records import get_feature

    tips = {}
    for line in lines:
        if not line.is_read:
            continue
        if line.id not in readings.seen:
            feature = get_feature(studio.records, line.feature_id)
            tips[line.id] = (
                tr("The plane or line that was read is no longer in the project.")
                if feature is None
                else tr("{feature} has no plane and no direction at present.", feature=feature.name)
            )
        elif placed is not None:
            notation = studio.settings.notation
            tips[line.id] = "\n".join(_of_reading(line, readings, placed, turned_deg, notation))
    return tips


def _of_reading(
    line: KnownLine, readings: Readings, placed: Placed, turned_deg: float, notation: str
) -> list[str]:
    from dataclasses import replace

    from vomstudio.geology.orientation import Line, Plane
    from vomstudio.project.kinds.known_line import format_reading
    from vomstudio.studio.placing.known_planes import placed_direction

    seen = readings.seen[line.id]
    there = placed_direction(seen, placed)
    if line.kind == "plane":
        plane = Plane.from_normal(there)
        angles = round(plane.dip_direction_deg, 1), round(plane.dip_deg, 1)
    else:
        axis = Line.from_vector(there)
        angles = round(axis.trend_deg, 1), round(axis.plunge_deg, 1)
    shown = format_reading(
        replace(line, value=angles[0] % 360.0, inclination_deg=angles[1]), notation
    )
    read = replace(line, value=round(((line.value or 0.0) + turned_deg) % 360.0, 1))
    said = [
        tr("Placed: {placed}; read: {read}.", placed=shown, read=format_reading(read, notation))
    ]
    if seen.sigma_deg is not None and line.sigma is not None:
        said.append(
            tr(
                "What the model shows is itself known to ± {error:.1f}° (1σ), which counts too.",
                error=seen.sigma_deg,
            )
        )
    for each in placed.without:
        if each.label == line.name:
            said.append(
                tr(
                    "Without it the others agree to {others:.1f}° (RMS), and the model turns by "
                    "{turn:.1f}°.",
                    others=each.others_deg,
                    turn=each.turned_deg,
                )
            )
    return said


def _worth(placed: Placed) -> str:
    from vomstudio.registration.warnings import worst_axis_findings

    said = []
    if placed.rms_control_m is not None:
        said.append(
            tr(
                "Control points: {control:.3f} m (RMS).",
                control=placed.rms_control_m,
            )
        )
    if placed.rms_check_m is not None:
        said.append(tr("Check points: {check:.3f} m (RMS).", check=placed.rms_check_m))
    said += map(str, worst_axis_findings(placed))
    # What is wrong with a point is read first.
    return "\n".join([*map(str, reversed(placed.warnings)), " ".join(said)])
