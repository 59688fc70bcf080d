"""Stereonets to go on drawing on, and rose diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from vomstudio.api.checking import one_of
from vomstudio.api.tables import Azimuth, rows_of
from vomstudio.errors import InputError
from vomstudio.geology.density import DENSITY_METHODS
from vomstudio.geology.orientation import Plane
from vomstudio.geology.roses import HISTOGRAM_OF, ROSE_OF, bins_of
from vomstudio.geology.stereonet import PROJECTIONS
from vomstudio.words import tr


def stereonet(
    table: Any,
    *,
    ax: Any = None,
    contour: str | None = None,
    by: str | None = None,
    projection: Literal["area", "angle"] = "area",
    azimuth: Azimuth | None = None,
    levels: Sequence[float] | None = None,
    filled: bool | None = None,
    each_set: bool = False,
    sigma: float = 3.0,
    untilt: tuple[float, float] | None = None,
    intersections: bool = False,
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
    levels : of the contours, in that unit; None for round ones below the highest density
    filled : contours filled, or lines; None for filled where all are contoured together
    each_set : contours of each set by itself, in its colour
    sigma : of Kamb's methods, 0.5 to 10: larger is smoother; a uniform scatter is expected to have
        this density
    projection : "area" (Schmidt) or "angle" (Wulff), of new axes
    untilt : (dip direction, dip) of the plane that everything is turned by, to the horizontal
    intersections : the lines in which each two of at most 300 planes meet, too

    Returns
    -------
    The axes, of mplstereonet: go on with its ``ax.pole``, ``ax.plane``, ``ax.line``, or matplotlib.
    Great circles are left out with more than 40 planes.

    Raises
    ------
    vs.errors.InputError for another ``contour`` or ``projection``, axes of another library, and
    angles that cannot be; vs.errors.UsageError for a column that is not there, and for ``levels``
    or a ``sigma`` that cannot be.

    Examples
    --------
    >>> import vomstudio as vs
    >>> ax = vs.stereonet(([90, 100, 95], [40, 42, 38]), contour="kamb")
    >>> type(ax).__name__
    'EqualAreaAxes'
    """
    from vomstudio.products.net import stereonet_axes
    from vomstudio.products.net.contents import Contouring
    from vomstudio.products.net.contours import check_contouring
    from vomstudio.products.net.net_options import net_untilted, with_intersections
    from vomstudio.products.net.table_net import net_of_table

    one_of(projection, PROJECTIONS, "projection")
    if contour is not None:
        one_of(contour, DENSITY_METHODS, "contour")
    rows = rows_of(table, azimuth)
    wanted = tuple(sorted({float(level) for level in levels or ()}))
    check_contouring(contour, wanted, sigma)
    look = Contouring(wanted, filled, each_set, sigma)
    net = net_of_table(rows, by, projection=projection, contour=contour, contouring=look)
    if intersections:
        net = with_intersections(net)
    if untilt is not None:
        net = net_untilted(net, Plane(*untilt))
    if ax is None:
        ax = stereonet_axes.new_axes(projection)
    elif not stereonet_axes.are_axes(ax):
        raise InputError(
            tr("Axes of mplstereonet are needed, such as those that vs.stereonet returns."),
            field="ax",
        )
    stereonet_axes.draw_net(ax, net)
    return ax


def rose(
    table: Any,
    *,
    of: Literal["strike", "dip-direction", "trend", "dip", "plunge"] | None = None,
    by: str | None = None,
    bin_deg: float = 10.0,
    weight: str | None = None,
    by_area: bool = True,
    azimuth: Azimuth | None = None,
) -> Any:
    """Draw rose diagrams of strikes, dip directions or trends, or histograms of dips or plunges,
    one for each set.

    Parameters
    ----------
    table, azimuth : as in `stats`
    of : which angle; None for strikes, of lines alone trends. Strikes count at both ends
    by : column that tells the sets apart; None for ``set``, else ``kind``
    bin_deg : width of the bins, which must divide 180 degrees evenly, of a histogram 90
    weight : column that each row counts by, such as the length; None for one each
    by_area : the area of a petal is its share, else its length

    Returns
    -------
    The figure, of pyplot: ``savefig`` writes it. All roses are to the same scale.

    Raises
    ------
    vs.errors.UsageError for bins that do not divide 180 and a column that is not there or has no
    numbers; vs.errors.GeometryError where nothing has such an azimuth; vs.errors.InputError as
    `stats`.

    The mean in each title is the circular one (Mardia & Jupp 2000, 2.2.1 and 9.4).

    Examples
    --------
    >>> import vomstudio as vs
    >>> figure = vs.rose(([90, 100, 95, 270], [40, 42, 38, 60]), bin_deg=30)
    >>> [text.get_text() for text in figure.texts][1]
    'mean 004-184, R̄ 0.99'
    """
    import matplotlib.pyplot as plt

    from vomstudio.products.net.rose import draw_roses, figure_size
    from vomstudio.products.net.rose_contents import check_roses, roses_of_table

    if of is not None:
        one_of(of, (*ROSE_OF, *HISTOGRAM_OF), "of")
    if of not in HISTOGRAM_OF:
        bins_of(bin_deg)
    rows = rows_of(table, azimuth)
    wanted = of or ("strike" if rows.is_plane.any() else "trend")
    found = roses_of_table(rows, wanted, by, bin_deg=bin_deg, weight=weight, by_area=by_area)
    check_roses(found, None)
    figure = plt.figure(figsize=figure_size(found))
    draw_roses(figure, found)
    return figure
