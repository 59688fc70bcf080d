"""Stereonets and rose diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from vomstudio.api.checking import (
    column_name,
    join_angles,
    join_numbers,
    plane_text,
    required_number,
    to_list,
    wrong_type_error,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.tables import Azimuth, to_orientation_table
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.rose_options import RoseOptions
from vomstudio.products.net.figure_options import StereonetFigure, StereonetOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mplstereonet import StereonetAxes

    from vomstudio.api.argument_types import OrientationsArgument

AnglePair = tuple[float, float] | str
AngleTriple = tuple[float, float, float] | str


def stereonet(
    table: OrientationsArgument,
    *,
    ax: StereonetAxes | None = None,
    contour: Literal["kamb", "exponential_kamb", "linear_kamb", "schmidt"] | None = None,
    by: str | None = None,
    projection: Literal["area", "angle"] = "area",
    azimuth: Azimuth | None = None,
    levels: Sequence[float] | None = None,
    filled: bool | None = None,
    each_set: bool = False,
    contour_set: str | None = None,
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
) -> StereonetAxes:
    """Draw poles, great circles, lines and means in a lower-hemisphere stereonet.

    Angles are in degrees and are given as tuples or as texts such as "125/26/30".

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        See `stats`.
    azimuth : {"strike", "dipdir"}, optional
        See `stats`.
    ax : StereonetAxes, optional
        Axes of mplstereonet; by default, new axes in a new pyplot figure.
    contour : {"kamb", "exponential_kamb", "linear_kamb", "schmidt"}, optional
        Density of all poles and lines: "kamb", "exponential_kamb", "linear_kamb" (in
        standard deviations of a uniform distribution; Kamb 1959, Vollmer 1995) or "schmidt"
        (% of the data in 1 % of the area).
    by : str, optional
        Column that groups the rows into sets, each with its own colour and symbol; by
        default ``set``, otherwise ``kind``.
    projection : {"area", "angle"}, optional
        Projection of new axes, "area" (Schmidt) or "angle" (Wulff).
    levels : sequence of float, optional
        Contour levels in the unit of the contours; by default round numbers below the
        maximum density.
    filled : bool, optional
        Whether to fill the contours; by default True unless ``each_set`` is set.
    each_set : bool, optional
        Whether to contour each set separately, in its own colour.
    contour_set : str, optional
        Set that is contoured; by default all sets are contoured together.
    kamb_sigma : float, optional
        Smoothing of Kamb's methods, 0.5 to 10: expected count of a uniform distribution, in
        standard deviations.
    untilt : AnglePair, optional
        (dip direction, dip) of a plane that is rotated to horizontal, together with all
        data.
    rotate : AngleTriple, optional
        (trend, plunge, angle) of a rotation applied to all data after ``untilt``, by the
        right-hand rule about the downward end of the axis.
    intersections : bool, optional
        Whether to draw the line of intersection of each pair of planes (up to 300 planes).
    planes : sequence of AnglePair, optional
        Great circles as (dip direction, dip).
    cones, slip_lines : sequence of AngleTriple, optional
        Small circles as (trend, plunge, half-angle), and planes with a line as (dip direction,
        dip, rake).
    girdles : bool, optional
        Whether to draw the great circle of each girdle.
    maxima : bool, optional
        Whether to mark the maximum density of each set, or of all data as contoured.
    errors : bool, optional
        Whether to draw the 95 % ellipse of each plane from the error columns of the table.
    averages : bool, optional
        Whether to state the mean of each set, with n and method.
    fold : bool, optional
        Whether to draw the fold axis of the bedding with its 95 % ellipse and great circle.
    quality : {"good", "doubtful"}, optional
        Worst verdict of the planes for the fold axis; see `fold`.
    only_set : str, optional
        Set of the planes for the fold axis; see `fold`.
    size_mm : (float, float), optional
        (width, height) of a new figure; by default the size set in pyplot.
    font : str, optional
        Font family.
    font_size_pt, symbol_size_pt, line_width_pt : float, optional
        Sizes of letters and symbols, and line width, points.
    grey : bool, optional
        Whether to draw in grey.

    Returns
    -------
    object
        Axes of mplstereonet with the methods ``ax.pole``, ``ax.plane`` and ``ax.line``.
        Great circles are omitted if there are more than 40 planes.

    Raises
    ------
    vs.errors.InputError
        If ``contour``, ``projection`` or another option is unknown, the axes belong to
        another library, or an angle is invalid.
    vs.errors.UsageError
        If a column does not exist, ``errors`` is set for a table without error columns, or
        levels, circles or sizes are invalid.

    Notes
    -----
    Girdles follow Woodcock (1977). Averages follow Fisher (1953) or the orientation tensor.

    Examples
    --------
    >>> import vomstudio as vs
    >>> ax = vs.stereonet(([90, 100, 95], [40, 42, 38]), contour="kamb", cones=[(275, 50, 10)])
    >>> type(ax).__name__, ax.get_legend().get_texts()[-1].get_text()
    ('EqualAreaAxes', 'Cone 275/50/10')
    """
    from vomstudio.products.net.figure_style import FigureStyle
    from vomstudio.products.net.net_axes import is_stereonet_axes
    from vomstudio.products.net.preparation import additions_from_options, contouring_from_options
    from vomstudio.products.net.script_net import create_axes, draw_net
    from vomstudio.products.net.table_net import net_from_table

    options = options_from_arguments(
        StereonetOptions,
        locals(),
        by=column_name(by),
        levels=None if levels is None else _levels_text(levels),
        untilt=None if untilt is None else plane_text(untilt, "untilt"),
        rotate=None if rotate is None else join_angles(rotate, "rotate", 3),
        planes=_format_angles(planes, "planes", 2),
        cones=_format_angles(cones, "cones", 3),
        slip_lines=_format_angles(slip_lines, "slip_lines", 3),
    )
    figure = options_from_arguments(
        StereonetFigure, locals(), size_mm=None if size_mm is None else _size_text(size_mm)
    )
    with name_arguments_in_errors(StereonetFigure):
        style = FigureStyle.from_options(figure)
    with name_arguments_in_errors(StereonetOptions):
        additions = additions_from_options(options)
    if ax is not None and not is_stereonet_axes(ax):
        raise wrong_type_error(ax, "mplstereonet.StereonetAxes", "ax")
    if ax is not None and size_mm is not None:
        raise UsageError(Finding("option.conflict", option="size_mm", other="ax"), field="size_mm")
    rows = to_orientation_table(table, azimuth)
    with name_arguments_in_errors(StereonetOptions):
        net = net_from_table(
            rows,
            options.by,
            projection=options.projection,
            contour=options.contour,
            contouring=contouring_from_options(options),
        )
        net = additions.net(net, rows)
    if ax is None:
        ax = create_axes(net, style, None if size_mm is None else style.size_mm)
    draw_net(ax, net, style)
    return ax


def _format_angles(values: Any, name: str, count: int) -> tuple[str, ...]:
    """Format angles for the options of the command. Raises InputError if they are invalid."""
    return tuple(join_angles(item, name, count) for item in to_list(values, name))


def _levels_text(levels: Any) -> str:
    """Format levels for the options of the command. Raises InputError if they are invalid."""
    return join_numbers([required_number(item, "levels") for item in to_list(levels, "levels")])


def _size_text(size: Any) -> str:
    """Format a size for the options of the command. Raises InputError if it is invalid."""
    try:
        width, height = size
    except (TypeError, ValueError):
        raise wrong_type_error(size, "(width, height)", "size_mm") from None
    return f"{required_number(width, 'size_mm'):g}x{required_number(height, 'size_mm'):g}"


def rose(
    table: OrientationsArgument,
    *,
    ax: Axes | None = None,
    of: Literal["strike", "dip-direction", "trend", "dip", "plunge"] | None = None,
    by: str | None = None,
    bin_deg: float = 10.0,
    weight: str | None = None,
    scale: Literal["area", "length"] = "area",
    azimuth: Azimuth | None = None,
) -> Axes:
    """Draw rose diagrams of azimuths, or histograms of dips or plunges, by set.

    Parameters
    ----------
    table : DataFrame, path, or (dip direction, dip)
        See `stats`.
    azimuth : {"strike", "dipdir"}, optional
        See `stats`.
    ax : Axes, optional
        Rectangular axes of matplotlib for the rose of a single set; by default, new axes for
        each set in a new pyplot figure.
    of : {"strike", "dip-direction", "trend", "dip", "plunge"}, optional
        Angle that is plotted; by default the strike, or the trend if the table contains only
        lines. Strikes are plotted in both directions.
    by : str, optional
        Column that names the set of each row; by default ``set``, otherwise ``kind``.
    bin_deg : float, optional
        Width of the bins, degrees, which must divide 180 (90 for a histogram) evenly.
    weight : str, optional
        Column with the weight of each row, such as the length; by default all weights are 1.
    scale : {"area", "length"}, optional
        Whether the area or the length of a petal is proportional to its share.

    Returns
    -------
    Axes
        Axes of the first rose. ``ax.figure`` contains the roses of all sets, to the same scale.

    Raises
    ------
    vs.errors.UsageError
        If the bins do not divide 180 evenly, a column is missing or contains no numbers, or
        several sets are to be drawn on ``ax``.
    vs.errors.GeometryError
        If no row has such an azimuth.
    vs.errors.InputError
        Under the conditions of `stats`, or if ``ax`` is not rectangular axes of matplotlib.

    Notes
    -----
    The title states the circular mean (Mardia & Jupp 2000, 2.2.1), which is computed from
    doubled angles for strikes (Krumbein 1939).

    Examples
    --------
    >>> import vomstudio as vs
    >>> ax = vs.rose(([90, 100, 95, 270], [40, 42, 38, 60]), bin_deg=30)
    >>> [text.get_text() for text in ax.figure.texts][1]
    'mean 004-184, R̄ 0.99'
    """
    import matplotlib.pyplot as plt

    from vomstudio.products.net.rose import draw_roses, draw_single_rose, figure_size
    from vomstudio.products.net.rose_contents import check_roses, roses_from_table

    options = options_from_arguments(
        RoseOptions, locals(), by=column_name(by), weight=column_name(weight, "weight")
    )
    if ax is not None and getattr(ax, "name", None) != "rectilinear":
        raise wrong_type_error(ax, "matplotlib.axes.Axes", "ax")
    rows = to_orientation_table(table, azimuth, azimuth_only=True)
    with name_arguments_in_errors(RoseOptions):
        roses = roses_from_table(
            rows,
            options.of or ("strike" if rows.is_plane.any() else "trend"),
            options.by,
            bin_deg=options.bin_deg,
            weight=options.weight,
            is_area_scaled=options.scale == "area",
        )
    check_roses(roses, None)
    if ax is None:
        figure = plt.figure(figsize=figure_size(roses))
        return next(iter(draw_roses(figure, roses).axes.values()))
    if len(roses.roses) > 1:
        raise UsageError(Finding("rose.several-sets", sets=list(roses.roses)), field="ax")
    draw_single_rose(ax, roses)
    return ax
