"""Maps of fracture traces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.api.checking import (
    check_flag,
    is_path,
    join_numbers,
    numbers,
    optional_path,
    optional_text,
    parse_angles,
    plane_text,
    require_valid_rows,
    requires_type_error,
    to_list,
    to_path,
    warn,
    wrong_shape_error,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.frame_arguments import UpAxis, frame_options, name_frame_arguments_in_errors
from vomstudio.api.tables import dataframe_crs
from vomstudio.core.arrays import FloatArray, ObjectArray
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geology.fractures.network import FractureNetwork, MappedNetwork
from vomstudio.products.fractures.mapping import FractureMapRequest, map_fractures

if TYPE_CHECKING:
    from vomstudio.api.argument_types import LinesArgument, PlaneArgument, ShapeArgument


def fractures(
    traces: LinesArgument,
    *,
    area: ShapeArgument | None = None,
    circle: tuple[float, ...] | None = None,
    scanline: ShapeArgument | None = None,
    snap_m: float = 0.0,
    by: str | Sequence[str] | None = None,
    strikes: Sequence[tuple[float, float]] | None = None,
    terzaghi_cap: float | None = None,
    layer: str | None = None,
    plane: PlaneArgument | None = None,
    plot: str | Path | None = None,
    force: bool = False,
    crs: str | None = None,
    up: UpAxis | None = None,
    unit: str | None = None,
    to_crs: str | None = None,
) -> FractureNetwork:
    """Compute the number, length, nodes and spacing of the fractures in a trace map.

    Parameters
    ----------
    traces : path, sequence of arrays, or GeoDataFrame
        Path of a GeoPackage, GeoJSON, shapefile or DXF; or the lines themselves as arrays
        (k, 2) of x East and y North in metres, arrays (k, 3) with heights, or shapely lines;
        or a GeoDataFrame in metres. Three-dimensional lines are analysed on their plane of best
        fit, with the warning ``lines.not-planar``.
    area : path, polygon or (k, 2) array, optional
        Mapped area: path of a layer of polygons, a shapely polygon, or its corners (k, 2)
        or (k, 3).
    circle : (float, ...), optional
        (x, y, radius) in metres, in place of an area; (x, y, z, radius) on a plane.
    scanline : path, line or (k, 2) array, optional
        Path of a layer of lines, a shapely line, or its corners (k, 2) or (k, 3), in place
        of an area.
    snap_m : float, optional
        Maximum distance of an end from the trace that it abuts, metres.
    by : str or sequence of str, optional
        Attribute of the file that contains the names of the sets, or the set of each trace.
    strikes : sequence of (float, float), optional
        Clockwise ranges of strike (from, to), degrees, each of which defines a set.
    terzaghi_cap : float, optional
        Maximum Terzaghi weight. If None, the weights are not limited.
    layer : str, optional
        Layer of the traces, if their file has several.
    plane : str, (float, float) or PlaneFit, optional
        Plane on which lines with heights are analysed: "DD/D", (dip direction, dip) or a
        PlaneFit; (0, 0) is the map.
    plot : str or Path, optional
        Picture to write (.svg, .pdf, .png).
    force : bool, optional
        Whether to replace an existing picture.
    crs, up, unit, to_crs : str, optional
        Frame of the traces, as in `vs.read`. GeoJSON without a ``crs`` is in degrees,
        according to the standard, and is converted.

    Returns
    -------
    FractureNetwork
        ``traces``, ``pieces``, ``area_m2``, ``P10_1_per_m``, ``P20_1_per_m2``,
        ``P20_nodes_1_per_m2``, ``P21_1_per_m``, their 95 % intervals (such as
        ``P21_95_1_per_m``), ``dispersion``, ``nodes`` (``I``, ``Y``, ``X``), ``mended``, ``length``
        (``mean_m``, ``naive_mean_m``, ``censored_share``, ``distribution``, ``parameters``
        and others), ``sets``, ``P21_by_size``, ``scanline``, ``plane`` (for three-dimensional
        lines: ``dip_deg``, ``scatter_m``, ``azimuths_from`` and others); None if undefined.

    Raises
    ------
    vs.errors.InputError
        If a file cannot be read or is in degrees.
    vs.errors.GeometryError
        If the area is outside the map, the lines do not define a plane, or the area or
        scanline is seen edge-on.
    vs.errors.UsageError
        If more than one of area, circle and scanline is given.
    vs.errors.TargetError
        If the picture exists or cannot be written.

    Notes
    -----
    Nodes after Sanderson & Nixon (2015), lengths in a window after Laslett (1982) and Pahl
    (1981), circles after Mauldon et al. (2001), weights along scanlines after Terzaghi (1965).

    Examples
    --------
    >>> import vomstudio as vs
    >>> joints = [[(0, y), (6, y)] for y in (1, 2, 3)] + [[(2, 1), (2, 3)]]
    >>> network = vs.fractures(joints, area=[(1, 0), (5, 0), (5, 4), (1, 4)])
    >>> network.P21_1_per_m, network.nodes.Y, network.nodes.X
    (0.875, 2, 1)
    """
    picture, replace = optional_path(plot, "plot"), check_flag(force, "force")
    options = options_from_arguments(
        FractureOptions,
        locals(),
        area=_file_text(area, "area"),
        circle=None if circle is None else join_numbers(numbers(circle, "circle")),
        scanline=_file_text(scanline, "scanline"),
        by=by if isinstance(by, str) else None,
        strikes=None if strikes is None else _format_ranges(strikes),
        layer=_layer(layer, traces),
        plane=None if plane is None else plane_text(plane, "plane"),
    )
    request = FractureMapRequest(
        None if _file_text(traces, "traces") is None else to_path(traces, "traces"),
        options,
        frame_options(crs, up, unit, to_crs),
    )
    with name_frame_arguments_in_errors(), name_arguments_in_errors(FractureOptions):
        mapped_fractures = map_fractures(
            request,
            lines=None if request.traces is not None else _shapes(traces, "traces"),
            crs=dataframe_crs(traces),
            area=None if area is None or options.area is not None else _areas(area),
            scanlines=(
                None
                if scanline is None or options.scanline is not None
                else _shapes([scanline], "scanline")
            ),
            sets=_set_names(by),
        )
    if picture is not None:
        _draw(mapped_fractures, picture, replace)
    warn(mapped_fractures.statistics.warnings)
    return mapped_fractures.statistics


def _draw(mapped_network: MappedNetwork, plot: Path, force: bool) -> None:
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.fractures.figure import write_fractures
    from vomstudio.products.net.figure import picture_format

    format_ = picture_format(plot, "plot")
    with atomic_write(plot, force) as temporary:
        write_fractures(temporary, mapped_network, format=format_)


def _format_ranges(value: Any) -> str | None:
    """Format strike ranges as options of the command; None if there are no ranges."""
    pairs = [parse_angles(pair, "strikes", 2) for pair in to_list(value, "strikes")]
    return ",".join(join_numbers(pair, "-") for pair in pairs) or None


def _set_names(by: Any) -> list[str] | None:
    """Return the set of each trace; None if `by` is None or the name of an attribute."""
    if by is None or isinstance(by, str):
        return None
    return [str(name) for name in to_list(by, "by")]


def _layer(value: Any, traces: Any) -> str | None:
    if value is not None and not is_path(traces):
        raise requires_type_error("layer", "traces", "str, pathlib.Path")
    return optional_text(value, "layer")


def _file_text(value: Any, name: str) -> str | None:
    """Return the path of a file as text, or None for other values."""
    return str(to_path(value, name)) if is_path(value) else None


def _areas(area: Any) -> ObjectArray:
    """Return an area as a polygon, from a geometry or its corners. Raises InputError."""
    import shapely

    polygon = area if hasattr(area, "geom_type") else shapely.Polygon(_to_corners(area, "area", 3))
    return np.array([polygon], object)


def _shapes(shapes: Any, name: str) -> ObjectArray:
    """Return lines as shapely geometries. Raises InputError."""
    import shapely

    lines = to_list(getattr(shapes, "geometry", shapes), name)
    geometries = [
        line if hasattr(line, "geom_type") else shapely.LineString(_to_corners(line, name, 2))
        for line in lines
    ]
    array = np.empty(len(geometries), object)
    array[:] = geometries
    return array


def _to_corners(value: Any, name: str, min_rows: int) -> FloatArray:
    xy = numbers(value, name)
    if xy.ndim != 2 or xy.shape[1] not in (2, 3) or len(xy) < min_rows:
        raise wrong_shape_error(xy, f"(n, 2), (n, 3), n >= {min_rows}", name)
    require_valid_rows(np.asarray(~np.isfinite(xy).all(axis=1)), name)
    return xy
