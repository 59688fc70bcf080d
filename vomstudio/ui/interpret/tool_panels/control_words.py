"""What the panel of control points and known lines says, and the command that does the same."""

from __future__ import annotations

from collections.abc import Sequence

from vomstudio.document.kinds.control_point import ControlPoint
from vomstudio.document.kinds.known_line import KnownLine
from vomstudio.document.records import Model
from vomstudio.errors import VomError
from vomstudio.registration.results import Placed
from vomstudio.ui.forms.copied_command import Word, numbers_text
from vomstudio.words import tr


def in_short(
    points: Sequence[ControlPoint], lines: Sequence[KnownLine], found: int, error: VomError
) -> str:
    """Why there is no placement, or what is to be done next. found : so many points are found"""
    from vomstudio.workspace.placing.known_lines import usable

    if usable(lines):
        return error.message
    if not points:
        if any(not line.complete for line in lines):
            return tr("Type what is known of the line in the list.")
        return tr(
            "Read the coordinates of control points from a file, or click a point on the "
            "outcrop and type its coordinates. Lines that are level, or whose azimuth or "
            "length is known, place the model in part."
        )
    if not found and not any(p.position for p in points):
        return tr("Type the coordinates of the points in the list, or read them from a file.")
    left = sum(p.position is not None and not p.vertices for p in points)
    if found < 3 and left:
        return tr(
            "Click the points on the outcrop, one after the other: {found} of {count} are "
            "found. From three on, or two where the model is declared upright, a ring shows "
            "where the others should be.",
            found=found,
            count=found + left,
        )
    return error.message


def in_words(placed: Placed, model: Model | None, crs: str | None) -> str:
    """What a geologist must know of it."""
    from vomstudio.registration.remarks import said_of_vertical
    from vomstudio.workspace.placing.known_lines import frame_after

    said = [_worth(placed)]
    if model is not None and not placed.known.all:
        known = frame_after(placed, model, crs).known_in_words()
        said = [tr("After registering: {known}", known=known), *said_of_vertical(placed), *said]
    return "\n".join(said)


def options(lines: Sequence[KnownLine]) -> list[tuple[str, Word]]:
    """As the command takes them."""
    from vomstudio.workspace.placing.known_lines import usable

    names = {"level": "--level", "azimuth": "--azimuth", "length": "--scale"}
    return [
        (
            names[line.kind],
            numbers_text(
                [*line.vertices[0], *line.vertices[-1],
                 *(v for v in (line.value, line.sigma) if v is not None)]
            ),
        )
        for line in usable(lines)
    ]  # fmt: skip


def _worth(placed: Placed) -> str:
    from vomstudio.registration.remarks import said_of_worst

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
    said += said_of_worst(placed)
    # What is wrong with a point is read first.
    return "\n".join([*reversed(placed.warnings), " ".join(said)])
