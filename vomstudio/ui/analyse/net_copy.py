"""The net, or its roses, as a command that draws the same planes and lines."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from vomstudio.geology.orientation import Plane
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.forms.copied_command import Word, Words
from vomstudio.ui.forms.copied_planes import beside, copy_with_table

if TYPE_CHECKING:
    from vomstudio.ui.analyse.stereonet_panel import StereonetPanel

_SWITCHES = {
    "girdles": "--girdles", "maxima": "--maxima", "errors": "--errors", "averages": "--averages",
    "intersections": "--intersections",
}  # fmt: skip


def copy_net_command(parent: QWidget, studio: Studio, panel: StereonetPanel) -> None:
    """Ask where the table of what is shown shall be written, and copy the command."""
    ids = [id_ for each in panel.contents().sets for id_ in each.ids]
    words = net_words if panel.wishes.view == "net" else rose_words
    copy_with_table(parent, studio, "net.csv", ids, partial(words, panel))


def net_words(panel: StereonetPanel, table: Path) -> Words:
    """The command of the net. table : of what is shown"""
    wishes, contours = panel.wishes, panel.contours
    words: list[Word | tuple[str, Word]] = [
        "stereonet", table, ("--set", "kind"), ("--projection", panel.view.projection),
    ]  # fmt: skip
    if contours.method is not None:
        contouring = contours.contouring
        words += [("--contour", contours.method),
                  "--filled" if contouring.filled else "--no-filled"]  # fmt: skip
        words += ["--each-set"] if contouring.each_set else []
        words += [] if contours.method == "schmidt" else [("--sigma", contouring.sigma)]
        if wishes.levels:
            words.append(("--levels", ",".join(f"{level:g}" for level in wishes.levels)))
    words += [switch for name, switch in _SWITCHES.items() if name in wishes.asked]
    turning = wishes.turning
    if turning.plane is not None:
        words.append(("--untilt", _plane(turning.plane)))
    if turning.axis is not None:
        axis = turning.axis
        said = f"{axis.trend_deg:.10g}/{axis.plunge_deg:.10g}/{turning.angle_deg:.10g}"
        words.append(("--rotate", said))
    for circle in wishes.circles:
        axis = circle.axis
        if circle.half_angle_deg == 90.0:
            words.append(("--plane", _plane(Plane.from_normal(axis.vector()))))
        else:
            cone = f"{axis.trend_deg:.10g}/{axis.plunge_deg:.10g}/{circle.half_angle_deg:.10g}"
            words.append(("--cone", cone))
    return [*words, ("-o", beside(table, "svg")), "--force"]


def rose_words(panel: StereonetPanel, table: Path) -> Words:
    """The command of the roses or histograms."""
    of = panel.wishes.view.replace("_", "-").replace(" ", "-")
    words: list[Word | tuple[str, Word]] = [
        "rose", table, ("--of", of), ("--bin", panel.wishes.bin_deg), ("--set", "kind"),
        ("--scale", "area" if panel.wishes.by_area else "length"),
    ]  # fmt: skip
    if panel.wishes.by_length:
        words.append(("--weight", "extent_m"))
    return [*words, ("-o", beside(table, "svg")), "--force"]


def _plane(plane: Plane) -> str:
    return f"{plane.dip_direction_deg:.10g}/{plane.dip_deg:.10g}"
