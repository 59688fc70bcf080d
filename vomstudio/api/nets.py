"""Stereonets to go on drawing on, and rose diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypedDict, Unpack

from vomstudio.api.checking import column_of, flag, one_of, required_number
from vomstudio.api.net_asked import NetAsked
from vomstudio.api.tables import Azimuth, rows_of
from vomstudio.errors import InputError, UsageError
from vomstudio.geology.density import DENSITY_METHODS
from vomstudio.geology.roses import HISTOGRAM_OF, ROSE_OF, bins_of
from vomstudio.geology.stereonet import PROJECTIONS
from vomstudio.words import tr

AnglePair = tuple[float, float] | str
AngleTriple = tuple[float, float, float] | str


class NetOptions(TypedDict, total=False):
    """What else may be done to a net, by the names of the command's options. Angles are degrees,
    tuples or texts such as "125/26/30".

    levels : of the contours, in that unit; None for round ones below the highest density
    filled : contours filled, or lines; None for filled where all are contoured together
    each_set : contours of each set by itself, in its colour
    sigma : of Kamb's methods, 0.5 to 10: larger is smoother; a uniform scatter is expected to have
        this density
    untilt : (dip direction, dip) of the plane that everything is turned by, to the horizontal
    rotate : (trend, plunge, angle) of the axis that everything is turned about after that, by the
        right-hand rule about its downward end
    intersections : the lines in which each two of at most 300 planes meet, too
    planes, cones, slip_lines : drawn too, as given: great circles of (dip direction, dip), small
        circles of (trend, plunge, half-angle), planes with the line of (dip direction, dip, rake)
    girdles : the great circle that each set fits best, of those that are girdles
    maxima : a cross where each set, or all as contoured, is densest
    errors : the 95 % ellipse of each plane, by the error columns of the table
    averages : of each set in words, with n and method
    fold : the fold axis of the bedding, its 95 % ellipse and its great circle
    quality, only_set : planes of the fold axis, as in `fold`
    size_mm : (width, height) of a new figure; None for that of pyplot's notebooks
    font, font_pt, symbol_pt, line_pt, grey : of letters, symbols and lines, and no colours at all
    """

    levels: Sequence[float] | None
    filled: bool | None
    each_set: bool
    sigma: float
    untilt: AnglePair | None
    rotate: AngleTriple | None
    intersections: bool
    planes: Sequence[AnglePair]
    cones: Sequence[AngleTriple]
    slip_lines: Sequence[AngleTriple]
    girdles: bool
    maxima: bool
    errors: bool
    averages: bool
    fold: bool
    quality: Literal["good", "doubtful"] | None
    only_set: str | None
    size_mm: tuple[float, float] | None
    font: str | None
    font_pt: float | None
    symbol_pt: float | None
    line_pt: float | None
    grey: bool


def stereonet(
    table: Any,
    *,
    ax: Any = None,
    contour: str | None = None,
    by: str | None = None,
    projection: Literal["area", "angle"] = "area",
    azimuth: Azimuth | None = None,
    **options: Unpack[NetOptions],
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
    options : ``levels``, ``filled``, ``each_set``, ``sigma`` of the contours; ``untilt`` (dip
        direction, dip), ``rotate`` (trend, plunge, angle), degrees; ``intersections``, ``girdles``,
        ``maxima``, ``errors``, ``averages``, ``fold``, True where wanted; ``quality``, ``only_set``
        of the fold's planes; ``planes``, ``cones``,
        ``slip_lines`` to draw as well; ``size_mm``, ``font``, ``font_pt``, ``symbol_pt``,
        ``line_pt``, ``grey``: as in the command, see ``vomstudio.api.nets.NetOptions``

    Returns
    -------
    The axes, of mplstereonet: go on with its ``ax.pole``, ``ax.plane``, ``ax.line``, or matplotlib.
    Great circles are left out with more than 40 planes.

    Raises
    ------
    vs.errors.InputError for another ``contour`` or ``projection``, axes of another library, angles
    that cannot be, and options of other names; vs.errors.UsageError for a column that is not there,
    for ``errors`` of a table that tells none, and for levels, circles or sizes that cannot be.

    Girdles after Woodcock (1977), averages after Fisher (1953) or by the orientation tensor.

    Examples
    --------
    >>> import vomstudio as vs
    >>> ax = vs.stereonet(([90, 100, 95], [40, 42, 38]), contour="kamb", cones=[(275, 50, 10)])
    >>> type(ax).__name__, ax.get_legend().get_texts()[-1].get_text()
    ('EqualAreaAxes', 'Cone 275/50/10')
    """
    from vomstudio.products.net import stereonet_axes
    from vomstudio.products.net.table_net import net_of_table

    one_of(projection, PROJECTIONS, "projection")
    if contour is not None:
        one_of(contour, DENSITY_METHODS, "contour")
    asked = NetAsked.of(dict(options), contour)
    if ax is not None and not stereonet_axes.are_axes(ax):
        raise InputError(
            tr("Axes of mplstereonet are needed, such as those that vs.stereonet returns."),
            field="ax",
        )
    if ax is not None and asked.size_mm is not None:
        raise UsageError(tr("Your own axes keep the size of their figure."), field="size_mm")
    rows = rows_of(table, azimuth)
    net = net_of_table(
        rows, column_of(by), projection=projection, contour=contour, contouring=asked.contouring
    )
    net = asked.wishes.net(net, rows)
    if ax is None:
        ax = stereonet_axes.new_axes(
            projection, asked.size_mm, len(stereonet_axes.lines_below(net))
        )
    stereonet_axes.draw_net(ax, net, asked.style)
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

    The mean in each title is the circular one (Mardia & Jupp 2000, 2.2.1), of strikes by doubled
    angles (Krumbein 1939).

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
    width, equal_area = required_number(bin_deg, "bin_deg"), flag(by_area, "by_area")
    if of not in HISTOGRAM_OF:
        bins_of(width)
    rows = rows_of(table, azimuth)
    wanted = of or ("strike" if rows.is_plane.any() else "trend")
    found = roses_of_table(
        rows,
        wanted,
        column_of(by),
        bin_deg=width,
        weight=column_of(weight, "weight"),
        by_area=equal_area,
    )
    check_roses(found, None)
    figure = plt.figure(figsize=figure_size(found))
    draw_roses(figure, found)
    return figure
