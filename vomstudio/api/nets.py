"""Stereonets to go on drawing on."""

from __future__ import annotations

from typing import Any, Literal

from vomstudio.api.checking import one_of
from vomstudio.api.tables import Azimuth, rows_of
from vomstudio.errors import InputError
from vomstudio.geology.stereonet import DENSITY_METHODS, PROJECTIONS
from vomstudio.words import tr


def stereonet(
    table: Any,
    *,
    ax: Any = None,
    contour: str | None = None,
    by: str | None = None,
    projection: Literal["area", "angle"] = "area",
    azimuth: Azimuth | None = None,
) -> Any:
    """Draw orientations on the lower hemisphere: poles and great circles of planes, lines, means.

    Parameters
    ----------
    table, azimuth : as in `stats`
    ax : axes of mplstereonet to draw on; None for new ones in a new figure of pyplot
    contour : density of all poles and lines: "kamb", "exponential_kamb", "linear_kamb" (in standard
        deviations of a uniform scatter; Kamb 1959, Vollmer 1995) or "schmidt" (% of the data in 1 %
        of the area)
    by : column that tells the sets apart, each with its colour and symbol; None for ``set``, else
        ``kind``
    projection : "area" (Schmidt) or "angle" (Wulff), of new axes

    Returns
    -------
    The axes, of mplstereonet: go on with its ``ax.pole``, ``ax.plane``, ``ax.line``, or matplotlib.
    Great circles are left out with more than 40 planes.

    Raises
    ------
    vs.errors.InputError for another ``contour`` or ``projection``, axes of another library, and
    angles that cannot be; vs.errors.UsageError for a column that is not there.

    Examples
    --------
    >>> import vomstudio as vs
    >>> ax = vs.stereonet(([90, 100, 95], [40, 42, 38]), contour="kamb")
    >>> type(ax).__name__
    'EqualAreaAxes'
    """
    from vomstudio.products.net import stereonet_axes
    from vomstudio.products.net.table_net import net_of_table

    one_of(projection, PROJECTIONS, "projection")
    if contour is not None:
        one_of(contour, DENSITY_METHODS, "contour")
    rows = rows_of(table, azimuth)
    net = net_of_table(rows, by, projection=projection, contour=contour)
    if ax is None:
        ax = stereonet_axes.new_axes(projection)
    elif not stereonet_axes.are_axes(ax):
        raise InputError(
            tr("Axes of mplstereonet are needed, such as those that vs.stereonet returns."),
            field="ax",
        )
    stereonet_axes.draw_net(ax, net)
    return ax
