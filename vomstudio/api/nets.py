"""Stereonets to go on drawing on, and rose diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from vomstudio.api.checking import (
    column_of,
    items_of,
    joined,
    plane_text,
    required_number,
    slashed,
    wrong_type,
)
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.tables import Azimuth, rows_of
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.rose_options import RoseOptions
from vomstudio.products.net.figure_options import StereonetFigure, StereonetOptions

AnglePair = tuple[float, float] | str
AngleTriple = tuple[float, float, float] | str


def stereonet(
    table: Any,
    *,
    ax: Any = None,
    contour: Literal["kamb", "exponential_kamb", "linear_kamb", "schmidt"] | None = None,
    by: str | None = None,
    projection: Literal["area", "angle"] = "area",
    azimuth: Azimuth | None = None,
    levels: Sequence[float] | None = None,
    filled: bool | None = None,
    each_set: bool = False,
    kamb_sigma: float = 3.0,
    untilt: AnglePair | None = None,
    rotate: AngleTriple | None = None,
    intersections: bool = False,
    planes: Sequence[AnglePair] = (),
    cones: Sequence[AngleTriple] = (),
    slip_lines: Sequence[AngleTriple] = (),
    girdles: bool = False,
    maxima: bool = False,
    errors: bool = False,
    averages: bool = False,
    fold: bool = False,
    quality: Literal["good", "doubtful"] | None = None,
    only_set: str | None = None,
    size_mm: tuple[float, float] | None = None,
    font: str | None = None,
    font_size_pt: float | None = None,
    symbol_size_pt: float | None = None,
    line_width_pt: float | None = None,
    grey: bool = False,
) -> Any:
    """Draw orientations on the lower hemisphere: poles and great circles of planes, lines, means.

    Angles are in degrees, as tuples or as texts such as "125/26/30".

    Parameters
    ----------
    table, azimuth : as in `stats`
    ax : axes of mplstereonet to draw on; None for new ones in a new figure of pyplot
    contour : density of all poles and lines: "kamb", "exponential_kamb", "linear_kamb" (in standard
        deviations of a uniform scatter; Kamb 1959, Vollmer 1995) or "schmidt" (% of the data in 1 %
        of the area)
    by : column that groups the rows into sets, each with its colour and symbol; None for ``set``,
        else ``kind``
    projection : "area" (Schmidt) or "angle" (Wulff), of new axes
    levels : levels of the contours, in their unit; None for round numbers below the highest density
    filled : fill the contours; None for yes, unless ``each_set``
    each_set : contour each set separately, in its colour
    kamb_sigma : smoothness of Kamb's methods, 0.5 to 10: standard deviations expected of a uniform
        scatter
    untilt : (dip direction, dip) of the plane that is rotated to horizontal, with everything else
    rotate : (trend, plunge, angle): after that, rotate everything about this axis, by the
        right-hand rule about its downward end
    intersections : also the lines of intersection of each pair of at most 300 planes
    planes, cones, slip_lines : also great circles of (dip direction, dip), small circles of (trend,
        plunge, half-angle), planes with a line of (dip direction, dip, rake)
    girdles : the great circle that fits each set that is a girdle
    maxima : a cross where each set, or all as contoured, is densest
    errors : the 95 % ellipse of each plane, by the error columns of the table
    averages : mean of each set in words, with n and method
    fold : the fold axis of the bedding, its 95 % ellipse and its great circle
    quality, only_set : planes of the fold axis, as in `fold`
    size_mm : (width, height) of a new figure; None for that of pyplot's notebooks
    font, font_size_pt, symbol_size_pt, line_width_pt, grey : letters, symbols, lines and colours

    Returns
    -------
    The axes, of mplstereonet: go on with its ``ax.pole``, ``ax.plane``, ``ax.line``, or matplotlib.
    Great circles are left out with more than 40 planes.

    Raises
    ------
    vs.errors.InputError for another ``contour`` or ``projection``, axes of another library, invalid
    angles and unknown options; vs.errors.UsageError for a column that does not exist,
    for ``errors`` of a table without error columns, and for invalid levels, circles or sizes.

    Girdles after Woodcock (1977), averages after Fisher (1953) or by the orientation tensor.

    Examples
    --------
    >>> import vomstudio as vs
    >>> ax = vs.stereonet(([90, 100, 95], [40, 42, 38]), contour="kamb", cones=[(275, 50, 10)])
    >>> type(ax).__name__, ax.get_legend().get_texts()[-1].get_text()
    ('EqualAreaAxes', 'Cone 275/50/10')
    """
    from vomstudio.products.net import stereonet_axes
    from vomstudio.products.net.figure_style import FigureStyle
    from vomstudio.products.net.preparation import contouring_of, wishes_of
    from vomstudio.products.net.table_net import net_of_table

    options = options_from_arguments(
        StereonetOptions,
        by=column_of(by),
        projection=projection,
        contour=contour,
        levels=None if levels is None else _levels_text(levels),
        filled=filled,
        each_set=each_set,
        kamb_sigma=kamb_sigma,
        untilt=None if untilt is None else plane_text(untilt, "untilt"),
        rotate=None if rotate is None else slashed(rotate, "rotate", 3),
        intersections=intersections,
        planes=_texts(planes, "planes", 2),
        cones=_texts(cones, "cones", 3),
        slip_lines=_texts(slip_lines, "slip_lines", 3),
        girdles=girdles,
        maxima=maxima,
        errors=errors,
        averages=averages,
        fold=fold,
        quality=quality,
        only_set=only_set,
    )
    figure = options_from_arguments(
        StereonetFigure,
        size_mm=None if size_mm is None else _size_text(size_mm),
        font=font,
        font_size_pt=font_size_pt,
        symbol_size_pt=symbol_size_pt,
        line_width_pt=line_width_pt,
        grey=grey,
    )
    with arguments_named(StereonetFigure):
        style = FigureStyle.from_options(figure)
    with arguments_named(StereonetOptions):
        wishes = wishes_of(options)
    if ax is not None and not stereonet_axes.are_axes(ax):
        raise wrong_type(ax, "mplstereonet.StereonetAxes", "ax")
    if ax is not None and size_mm is not None:
        raise UsageError(Finding("option.conflict", option="size_mm", other="ax"), field="size_mm")
    rows = rows_of(table, azimuth)
    net = net_of_table(
        rows,
        options.by,
        projection=options.projection,
        contour=options.contour,
        contouring=contouring_of(options),
    )
    with arguments_named(StereonetOptions):
        net = wishes.net(net, rows)
    if ax is None:
        size = None if size_mm is None else style.size_mm
        ax = stereonet_axes.new_axes(projection, size, len(stereonet_axes.lines_below(net)))
    stereonet_axes.draw_net(ax, net, style)
    return ax


def _texts(values: Any, name: str, count: int) -> tuple[str, ...]:
    """Return angles as the command takes them. Raises InputError."""
    return tuple(slashed(each, name, count) for each in items_of(values, name))


def _levels_text(levels: Any) -> str:
    """Return levels as the command takes them. Raises InputError."""
    return joined([required_number(each, "levels") for each in items_of(levels, "levels")])


def _size_text(size: Any) -> str:
    """Return a size as the command takes it. Raises InputError."""
    try:
        width, height = size
    except (TypeError, ValueError):
        raise wrong_type(size, "(width, height)", "size_mm") from None
    return f"{required_number(width, 'size_mm'):g}x{required_number(height, 'size_mm'):g}"


def rose(
    table: Any,
    *,
    of: Literal["strike", "dip-direction", "trend", "dip", "plunge"] | None = None,
    by: str | None = None,
    bin_deg: float = 10.0,
    weight: str | None = None,
    scale: Literal["area", "length"] = "area",
    azimuth: Azimuth | None = None,
) -> Any:
    """Draw rose diagrams of strikes, dip directions or trends, or histograms of dips or plunges,
    one for each set.

    Parameters
    ----------
    table, azimuth : as in `stats`
    of : which angle; None for strikes, of lines alone trends. Strikes count at both ends
    by : column that names the set of each row; None for ``set``, else ``kind``
    bin_deg : width of the bins, which must divide 180 degrees evenly, of a histogram 90
    weight : column that each row counts by, such as the length; None for one each
    scale : "area" or "length", the measure of a petal that is proportional to its share

    Returns
    -------
    The figure, of pyplot: ``savefig`` writes it. All roses are to the same scale.

    Raises
    ------
    vs.errors.UsageError for bins that do not divide 180 and a column that is not there or has no
    numbers; vs.errors.GeometryError if no row has such an azimuth; vs.errors.InputError as
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

    options = options_from_arguments(
        RoseOptions,
        of=of,
        by=column_of(by),
        bin_deg=bin_deg,
        weight=column_of(weight, "weight"),
        scale=scale,
    )
    rows = rows_of(table, azimuth)
    with arguments_named(RoseOptions):
        roses = roses_of_table(
            rows,
            options.of or ("strike" if rows.is_plane.any() else "trend"),
            options.by,
            bin_deg=options.bin_deg,
            weight=options.weight,
            by_area=options.scale == "area",
        )
    check_roses(roses, None)
    figure = plt.figure(figsize=figure_size(roses))
    draw_roses(figure, roses)
    return figure
