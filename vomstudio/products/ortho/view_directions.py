"""Viewing direction of an orthophoto, and the reason for its sense."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.orientation import Plane, lines_to_vectors, vectors_to_lines
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.ortho.world_points import transform_to_world

DOWN_PLUNGE, UP_PLUNGE = to_translate("down-plunge"), to_translate("up-plunge")
AGAINST_NORMAL = to_translate("against the upward normal")
ALONG_NORMAL = to_translate("along the upward normal")
AS_GIVEN, REVERSED = to_translate("as given"), to_translate("against the given direction")
"""Senses of views, as stored in sidecars."""
_OPPOSITE_SENSES = {
    DOWN_PLUNGE: UP_PLUNGE,
    UP_PLUNGE: DOWN_PLUNGE,
    AGAINST_NORMAL: ALONG_NORMAL,
    ALONG_NORMAL: AGAINST_NORMAL,
    AS_GIVEN: REVERSED,
    REVERSED: AS_GIVEN,
}


@dataclass(frozen=True)
class ViewDirection:
    """Viewing direction and the reason for its sense.

    Parameters
    ----------
    trend_deg, plunge_deg : float
        Viewing direction; it is upwards if the plunge is negative.
    sense : str
        `DOWN_PLUNGE`, `UP_PLUNGE`, `AGAINST_NORMAL`, `ALONG_NORMAL`, `AS_GIVEN` or `REVERSED`.
    reason : Finding
        Reason why the opposite direction was not chosen.
    is_north_known, is_metric : bool
        Whether the north and the scale of the model are known. Otherwise the sheet has no compass
        directions, or states lengths in model units.
    """

    trend_deg: float
    plunge_deg: float
    sense: str
    reason: Finding
    is_north_known: bool = True
    is_metric: bool = True

    @property
    def frame(self) -> ViewFrame:
        """Axes of the view."""
        return ViewFrame.from_direction(lines_to_vectors(self.trend_deg, self.plunge_deg))

    def flipped(self) -> ViewDirection:
        """Return the opposite view, which is a mirror image."""
        return ViewDirection(
            wrap360(self.trend_deg + 180.0),
            0.0 - self.plunge_deg,
            _OPPOSITE_SENSES[self.sense],
            Finding("view.flipped", reason=self.reason),
        )


def view_along_line(trend_deg: float, plunge_deg: float) -> ViewDirection:
    """Return the view along a line entered by the user.

    Raises
    ------
    UsageError
        If the plunge exceeds 90 degrees, or the trend ten full turns.
    """
    for angle, max_angle, field in ((trend_deg, 3600.0, "--trend"), (plunge_deg, 90.0, "--plunge")):
        if not abs(angle) <= max_angle:
            raise UsageError(
                Finding("angle.out-of-range", value=angle, minimum=-max_angle, maximum=max_angle),
                field=field,
            )
    return ViewDirection(
        wrap360(trend_deg),
        plunge_deg,
        AS_GIVEN,
        Finding("view.as-given"),
    )


def view_against_plane(plane: Plane) -> ViewDirection:
    """Return the view against the upward normal of a plane.

    The normal of a vertical plane points in its dip direction.
    """
    return _view_along(
        -plane.normal(),
        AGAINST_NORMAL,
        Finding("view.against-normal"),
    )


def view_along_axis(
    trend_deg: float, plunge_deg: float, data: Mesh | PointCloud, to_world: npt.ArrayLike
) -> ViewDirection:
    """Return the view along a fold axis.

    The view is down-plunge unless most of the visible surface would face away from the viewer, as
    for a cliff seen from inside. In this case it is up-plunge.

    Raises
    ------
    InputError
        If the model is empty.
    """
    down = lines_to_vectors(trend_deg, plunge_deg)
    if plunge_deg < 0:
        down = -down
    share, is_estimated = _away_facing_share(data, ViewFrame.from_direction(down), to_world)
    if math.isnan(share):
        return _view_along(down, DOWN_PLUNGE, Finding("view.down-plunge-unseen"))
    if share > 0.5:
        code = "view.up-plunge-estimated" if is_estimated else "view.up-plunge"
        return _view_along(-down, UP_PLUNGE, Finding(code, share_percent=100 * share))
    code = "view.down-plunge-estimated" if is_estimated else "view.down-plunge"
    return _view_along(down, DOWN_PLUNGE, Finding(code, share_percent=100 * (1 - share)))


def cost_of_direction(
    error_deg: float | None, depth_m: float, *, is_metric: bool = True
) -> Finding:
    """Return the effect of a direction error on a picture of the given depth.

    An error d multiplies lengths in the direction of tilt by cos d, and displaces points at a
    distance h along the view by h sin d. `error_deg` is the larger 95 % semi-axis of the direction;
    if None, 5 degrees are assumed.
    """
    if error_deg is None:
        return _cost("view.axis-error-unknown", 5.0, depth_m, is_metric)
    return _cost("view.axis-error", error_deg, depth_m, is_metric)


def cost_of_deviation(deviation_deg: float, depth_m: float, *, is_metric: bool = True) -> Finding:
    """Return the effect of a known deviation from the correct direction."""
    return _cost("view.off-axis-cost", deviation_deg, depth_m, is_metric)


def _cost(code: str, error_deg: float, depth_m: float, is_metric: bool) -> Finding:
    return Finding(
        code,
        error_deg=error_deg,
        share_percent=100 * (1 - math.cos(math.radians(error_deg))),
        displacement=depth_m * math.sin(math.radians(error_deg)),
        depth=depth_m,
        unit="m" if is_metric else tr("units"),
    )


MAX_NEGLIGIBLE_SHARE = 0.01
"""Maximum relative shortening or displacement that is not visible in a drawing."""


def is_costly(error_deg: float | None, depth_m: float, width_m: float) -> bool:
    """Return whether a direction error has a visible effect.

    An error d multiplies lengths by cos d, and displaces points at a distance h along the view by
    h sin d. Displacements are compared with the longer side of the picture, `width_m`. The result
    is True if `error_deg` is unknown.
    """
    if error_deg is None:
        return True
    error_rad = math.radians(error_deg)
    return (
        1.0 - math.cos(error_rad) > MAX_NEGLIGIBLE_SHARE
        or depth_m * math.sin(error_rad) > MAX_NEGLIGIBLE_SHARE * width_m
    )


def _away_facing_share(
    data: Mesh | PointCloud, frame: ViewFrame, to_world: npt.ArrayLike
) -> tuple[float, bool]:
    if isinstance(data, Mesh):
        from vomstudio.products.ortho import mesh_picture

        if not len(data.faces):
            raise InputError(Finding("model.no-surface"))
        world = transform_to_world(to_world, data.vertices)
        return mesh_picture.away_facing_share(frame.to_view(world, world[0]), data.faces), False
    from vomstudio.geometry.transform import rotate
    from vomstudio.products.ortho import cloud_picture

    if not len(data.points):
        raise InputError(Finding("model.no-surface"))
    world = transform_to_world(to_world, data.points)
    normals = None
    if data.normals is not None:
        normals = rotate(np.asarray(to_world, np.float64), data.normals) @ frame.axes
    up = np.array([0.0, 0.0, 1.0]) @ frame.axes
    return cloud_picture.away_facing_share(frame.to_view(world, world[0]), normals, up)


def _view_along(direction: FloatArray, sense: str, reason: Finding) -> ViewDirection:
    trend, plunge, _ = vectors_to_lines(direction, is_directed=True)
    return ViewDirection(float(trend[0]), float(plunge[0]), sense, reason)
