"""Which way an orthophoto looks, and why this way and not the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError, UsageError
from vomstudio.geology.orientation import Plane, lines_to_vectors, vectors_to_lines
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.ortho.world_points import in_world
from vomstudio.words import to_translate, tr

Array = npt.NDArray[np.float64]

_OPPOSITE = {
    to_translate("down-plunge"): "up-plunge",
    to_translate("up-plunge"): "down-plunge",
    to_translate("against the upward normal"): "along the upward normal",
    to_translate("along the upward normal"): "against the upward normal",
    to_translate("as given"): "against the given direction",
    to_translate("against the given direction"): "as given",
}
"""The sense of a view from the other side. Senses are data in sidecars."""


@dataclass(frozen=True)
class View:
    """A directed view, and in words why it looks this way and not the other.

    trend_deg, plunge_deg : the way the viewer looks; a negative plunge looks up
    sense : "as given", "against the upward normal", "along the upward normal", "down-plunge",
        "up-plunge", "against the given direction"
    reason : one sentence
    north_known, metric : False for a model whose north or whose scale is not known: the sheet then
        names no winds, and counts units
    """

    trend_deg: float
    plunge_deg: float
    sense: str
    reason: str
    north_known: bool = True
    metric: bool = True

    @property
    def frame(self) -> ViewFrame:
        return ViewFrame.looking(lines_to_vectors(self.trend_deg, self.plunge_deg))

    def flipped(self) -> View:
        """From the other side: a mirror image."""
        return View(
            wrap360(self.trend_deg + 180.0),
            0.0 - self.plunge_deg,
            _OPPOSITE[self.sense],
            tr("Flipped by request. Before: {reason}", reason=self.reason),
        )


def view_along_line(trend_deg: float, plunge_deg: float) -> View:
    """A view as typed. Raises UsageError for a plunge beyond 90 degrees, and a trend beyond ten
    turns, which is none that was meant."""
    for angle, most, field in ((trend_deg, 3600.0, "--trend"), (plunge_deg, 90.0, "--plunge")):
        if not abs(angle) <= most:
            raise UsageError(
                tr("A view needs a trend in degrees and a plunge from -90 (up) to 90 (down)."),
                field=field,
            )
    return View(
        wrap360(trend_deg),
        plunge_deg,
        "as given",
        tr("The viewer looks along the given direction."),
    )


def view_of_plane(plane: Plane) -> View:
    """Against the plane's upward normal; a vertical plane is looked at toward its dip direction
    + 180."""
    return _along(
        -plane.normal(),
        "against the upward normal",
        tr("The viewer looks against the upward normal of the plane."),
    )


def view_along_axis(
    trend_deg: float, plunge_deg: float, data: Mesh | PointCloud, to_world: npt.ArrayLike
) -> View:
    """Along a fold axis (axial): down-plunge, unless most of what that view hits turns its back to
    the viewer, which is a cliff seen from inside: then up-plunge."""
    down = lines_to_vectors(trend_deg, plunge_deg)
    if plunge_deg < 0:
        down = -down
    away, guessed = _facing_away(data, ViewFrame.looking(down), to_world)
    if math.isnan(away):
        return _along(down, "down-plunge", tr("Down-plunge."))
    if away > 0.5:
        reason = (
            tr(
                "Up-plunge: seen down-plunge, {share:.0f} % of the visible surface faces away from "
                "the viewer (normals estimated, taken to point up).",
                share=100 * away,
            )
            if guessed
            else tr(
                "Up-plunge: seen down-plunge, {share:.0f} % of the visible surface faces away from "
                "the viewer.",
                share=100 * away,
            )
        )
        return _along(-down, "up-plunge", reason)
    reason = (
        tr(
            "Down-plunge: {share:.0f} % of the visible surface faces the viewer (normals "
            "estimated, taken to point up).",
            share=100 * (1 - away),
        )
        if guessed
        else tr(
            "Down-plunge: {share:.0f} % of the visible surface faces the viewer.",
            share=100 * (1 - away),
        )
    )
    return _along(down, "down-plunge", reason)


def cost_of_direction(error_deg: float | None, depth_m: float, *, metric: bool = True) -> str:
    """What a direction that is off costs in a picture so deep (CONVENTIONS: lengths times cos d in
    the direction of tilt, displacements h sin d along the view), in a sentence. error_deg: the
    larger 95 % semi-axis of the direction; None where unknown, and 5 degrees are supposed."""
    figures = _cost(5.0 if error_deg is None else error_deg, depth_m, metric)
    if error_deg is None:
        return tr(
            "The error of the direction is unknown. An error of {angle:.1f}° would shorten lengths "
            "in the direction of tilt by {share:.1f} % and displace points against each other by "
            "up to {displacement:.3g} {unit} over the depth of the view ({depth:.3g} {unit}).",
            **figures,
        )
    return tr(
        "The 95 % error of the axis, {angle:.1f}°, shortens lengths in the direction of tilt by "
        "{share:.1f} % and displaces points against each other by up to {displacement:.3g} {unit} "
        "over the depth of the view ({depth:.3g} {unit}).",
        **figures,
    )


def cost_of_being_off(off_deg: float, depth_m: float, *, metric: bool = True) -> str:
    """The same of a direction that is known to be off the right one by so much."""
    return tr(
        "So far off, lengths in the direction of tilt are shortened by {share:.1f} % and points "
        "displaced against each other by up to {displacement:.3g} {unit} over the depth of the "
        "view ({depth:.3g} {unit}).",
        **_cost(off_deg, depth_m, metric),
    )


def _cost(off_deg: float, depth_m: float, metric: bool) -> dict[str, Any]:
    return {
        "angle": off_deg,
        "share": 100 * (1 - math.cos(math.radians(off_deg))),
        "displacement": depth_m * math.sin(math.radians(off_deg)),
        "depth": depth_m,
        "unit": "m" if metric else tr("units"),
    }


NEGLIGIBLE = 0.01
"""Of a length: what is shortened or displaced by less cannot be seen on a drawing."""


def is_costly(error_deg: float | None, depth_m: float, across_m: float) -> bool:
    """Whether a direction that is off costs more than can be neglected (CONVENTIONS: lengths times
    cos d, displacements h sin d): against lengths themselves, and against the picture's longer
    side `across_m`. error_deg : as of `cost_of_direction`; where it is unknown, nothing is"""
    if error_deg is None:
        return True
    off = math.radians(error_deg)
    return 1.0 - math.cos(off) > NEGLIGIBLE or depth_m * math.sin(off) > NEGLIGIBLE * across_m


def _facing_away(
    data: Mesh | PointCloud, frame: ViewFrame, to_world: npt.ArrayLike
) -> tuple[float, bool]:
    if isinstance(data, Mesh):
        from vomstudio.products.ortho import mesh_picture

        if not len(data.faces):
            raise InputError(tr("This model has no surface to draw."))
        world = in_world(to_world, data.vertices)
        return mesh_picture.share_facing_away(frame.to_view(world, world[0]), data.faces), False
    from vomstudio.geometry.transform import rotate
    from vomstudio.products.ortho import cloud_picture

    if not len(data.points):
        raise InputError(tr("This model has no points to draw."))
    world = in_world(to_world, data.points)
    normals = None
    if data.normals is not None:
        normals = rotate(np.asarray(to_world, np.float64), data.normals) @ frame.axes
    up = np.array([0.0, 0.0, 1.0]) @ frame.axes
    return cloud_picture.share_facing_away(data, frame.to_view(world, world[0]), normals, up)


def _along(direction: Array, sense: str, reason: str) -> View:
    trend, plunge, _ = vectors_to_lines(direction, directed=True)
    return View(float(trend[0]), float(plunge[0]), sense, reason)
