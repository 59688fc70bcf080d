"""True measures: fault displacements, three-point planes, and bed logs along a line."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vomstudio.api.checking import (
    is_model,
    is_path,
    numbers,
    parse_angles,
    plane_text,
    require_valid_rows,
    to_plane,
    warn,
    wrong_shape_error,
)
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.frame_arguments import UpAxis, frame_options, name_frame_arguments_in_errors
from vomstudio.api.point_arguments import points
from vomstudio.api.tables import to_text_table
from vomstudio.geology.beds.bed_log import BedLog, bed_log
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.faults.displacement_options import DisplacementOptions, ThreePointOptions
from vomstudio.geology.faults.displacement_pairs import Displacements, displacements
from vomstudio.geology.faults.three_points import ThreePoints, plane_of_three_points
from vomstudio.geology.notation import format_exact_line
from vomstudio.geology.orientation import Line
from vomstudio.geometry.coordinate_limits import find_invalid_points
from vomstudio.io.gate.point_tables import read_boundaries, read_pairs

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vomstudio.api.argument_types import PointsArgument, TableArgument


def displacement(
    pairs: ArrayLike | TableArgument,
    *,
    fault: tuple[float, float],
    bed: tuple[float, float] | None = None,
    rake_deg: float | None = None,
    slip: tuple[float, float] | None = None,
    sigma_m: float | None = None,
    fault_error_deg: float = 0.0,
    bed_error_deg: float = 0.0,
    rake_error_deg: float = 0.0,
    crs: str | None = None,
    up: UpAxis | None = None,
    unit: str | None = None,
    to_crs: str | None = None,
) -> Displacements:
    """Compute fault displacements from pairs of points on the two sides of a fault.

    Parameters
    ----------
    pairs : (n, 6) array, DataFrame or path
        x, y, z on the hanging wall, followed by x, y, z on the footwall, in the World frame,
        metres; or a DataFrame or file with the columns ``hanging_x`` to ``footwall_z`` and
        optionally ``name``.
    fault : (float, float)
        (dip direction, dip) of the fault, degrees.
    bed : (float, float), optional
        (dip direction, dip) of the bed whose cut-offs the points represent. If None, they
        are piercing points.
    rake_deg : float, optional
        Rake of the slip lineation on the fault.
    slip : (float, float), optional
        Alternatively, (trend, plunge) of the slip lineation, an axis without direction.
    sigma_m : float, optional
        Standard deviation of each coordinate, metres; 0 by default.
    fault_error_deg, bed_error_deg : float, optional
        Half-angles of the 95 % cones of the two normals, degrees.
    rake_error_deg : float, optional
        95 % error of the rake, degrees.
    crs, up, unit, to_crs : str, optional
        Frame of the coordinates; see `vs.read`. Comments and the `.prj` of a file are read,
        and other units and coordinate systems are converted or rejected.

    Returns
    -------
    Displacements
        ``what`` ("net slip", or "separation" if the slip is unknown), ``n``, ``pairs``
        (each with ``displacement`` or ``separations``), means and standard deviations of
        net slip, throw and heave in metres, ``skipped``, ``warnings``.

    Raises
    ------
    vs.errors.UsageError
        If a slip is given without a bed, both ``rake_deg`` and ``slip`` are given, a rake is
        given for a horizontal fault, or an error is negative.
    vs.errors.GeometryError
        If no pair has a result.
    vs.errors.InputError
        If the table does not have these columns.

    Notes
    -----
    Piercing points give the net slip. Cut-offs give the net slip if the slip direction is known,
    otherwise separations (Hill 1959, Journal of Geology 67, 641-653).

    Examples
    --------
    Ten metres of slip down the dip of a fault that dips 60 degrees:

    >>> import vomstudio as vs
    >>> result = vs.displacement([[5, 0, -8.66, 0, 0, 0]], fault=(90, 60), sigma_m=0.1)
    >>> round(result.mean_net_m, 2), round(result.mean_heave_m, 2)
    (10.0, 5.0)
    """
    options = options_from_arguments(
        DisplacementOptions,
        locals(),
        fault=plane_text(fault, "fault"),
        bed=None if bed is None else plane_text(bed, "bed"),
        slip=None if slip is None else format_exact_line(Line(*parse_angles(slip, "slip", 2))),
    )
    with name_frame_arguments_in_errors():
        point_table = read_pairs(_table(pairs, 6, "pairs"), frame_options(crs, up, unit, to_crs))
    with name_arguments_in_errors(DisplacementOptions):
        result = displacements(
            point_table.names, point_table.points[:, :3], point_table.points[:, 3:], options
        )
    result = replace(result, warnings=(*point_table.warnings, *result.warnings))
    warn(result.warnings)
    return result


def threepoint(
    points: PointsArgument,
    *,
    sigma_m: float = 0.0,
    crs: str | None = None,
    up: UpAxis | None = None,
    unit: str | None = None,
    to_crs: str | None = None,
) -> ThreePoints:
    """Fit a plane to three or more points, and propagate the errors of the points.

    Parameters
    ----------
    points : (n, 3) array, DataFrame, PointCloud, Mesh, PyVista data set or path
        At least three points in the World frame, metres; a DataFrame or file with rows of
        x, y, z; or a model, with its vertices.
    sigma_m : float, optional
        Standard deviation of each coordinate; by default estimated from the residuals of
        more than three points.
    crs, up, unit, to_crs : str, optional
        Frame of the coordinates; see `vs.read`. Comments and the `.prj` of a file are read,
        and other units and coordinate systems are converted or rejected.

    Returns
    -------
    ThreePoints
        ``dip_direction_deg``, ``dip_deg``, ``strike_rhr_deg``, ``dip_error_deg`` and
        ``dip_direction_error_deg`` (95 %, each separately), ``max_confidence95_deg``
        (half-angle of the joint 95 % cone in the worst direction), ``n``, ``rms_m`` of the
        points about the plane (None for three points), ``sigma_m`` used for the errors,
        ``warnings``, ``dropped_lines``. Unknown errors are returned as None.

    Raises
    ------
    vs.errors.GeometryError
        If the points are collinear, or there are fewer than three.
    vs.errors.UsageError
        If `sigma_m` is negative.
    vs.errors.InputError
        If the table contains no coordinates.

    Notes
    -----
    The least-squares plane passes exactly through three points. Its errors include all planes
    that are compatible with the points.

    Examples
    --------
    >>> import vomstudio as vs
    >>> bed = vs.threepoint([[0, 0, 100], [0, 50, 100], [40, 20, 80]], sigma_m=0.5)
    >>> round(bed.dip_direction_deg), round(bed.dip_deg, 1), round(bed.dip_error_deg, 1)
    (90, 26.6, 1.5)
    """
    options = options_from_arguments(ThreePointOptions, sigma_m=sigma_m)
    frame = frame_options(crs, up, unit, to_crs)
    with name_frame_arguments_in_errors():
        point_table = read_boundaries(_table(points, 3, "points"), frame)
    result = plane_of_three_points(point_table.points, options.sigma_m).with_table_findings(
        point_table.dropped, point_table.warnings
    )
    warn(result.warnings)
    return result


def log(
    table: PointsArgument,
    *,
    bed: tuple[float, float],
    sigma_m: float | None = None,
    bed_error_deg: float | None = None,
    overturned: bool = False,
    crs: str | None = None,
    up: UpAxis | None = None,
    unit: str | None = None,
    to_crs: str | None = None,
) -> BedLog:
    """Log the bed boundaries along a line, with the true thickness between them.

    Parameters
    ----------
    table : (n, 3) array, DataFrame, PointCloud, PyVista data set or path
        One point (n, 3) on each boundary in the World frame, metres; or a DataFrame or file
        with x, y, z and optionally ``name``, ``lithology`` and ``notes`` of the bed above.
    bed : (float, float)
        (dip direction, dip) of the beds, degrees.
    sigma_m : float, optional
        Standard deviation of each coordinate, metres; 0 by default.
    bed_error_deg : float, optional
        Half-angle of the 95 % cone of the bedding normal; 0 by default.
    overturned : bool, optional
        Whether the beds are overturned, with the younger beds below.
    crs, up, unit, to_crs : str, optional
        Frame of the coordinates; see `vs.read`. Comments and the `.prj` of a file are read,
        and other units and coordinate systems are converted or rejected.

    Returns
    -------
    BedLog
        ``n``, ``intervals`` upward from the oldest (``number``, ``base``, ``top``, ``base_m``,
        ``top_m``, ``thickness_m`` with ``value`` and ``error95``, ``lithology``,
        ``strabospot`` with the StraboSpot fields, ``notes``), ``total_m``,
        ``reordered``, ``warnings``.

    Raises
    ------
    vs.errors.GeometryError
        If there are fewer than two boundaries.
    vs.errors.UsageError
        If an error is negative.
    vs.errors.InputError
        If the table contains no coordinates.

    Notes
    -----
    The thickness is the distance between two points across the bedding (Ragan 2009, Structural
    Geology, chapter 2). Its error is propagated to first order.

    Examples
    --------
    Ten metres across the strike of beds that dip 30 degrees correspond to a thickness of five:

    >>> import vomstudio as vs
    >>> result = vs.log([[0, 0, 0], [10, 0, 0]], bed=(90, 30), bed_error_deg=2)
    >>> round(result.total_m.value, 2), round(result.total_m.error95, 2)
    (5.0, 0.24)
    """
    options = options_from_arguments(LogOptions, locals())
    frame = frame_options(crs, up, unit, to_crs)
    with name_frame_arguments_in_errors():
        point_table = read_boundaries(_table(table, 3, "table"), frame)
    result = bed_log(
        point_table.points,
        to_plane(bed, "bed"),
        names=point_table.names,
        lithologies=point_table.lithologies,
        notes=point_table.notes,
        sigma_m=options.sigma_m or 0.0,
        bed_error_deg=options.bed_error_deg or 0.0,
        overturned=options.overturned,
    )
    result = replace(result, warnings=(*point_table.warnings, *result.warnings))
    warn(result.warnings)
    return result


def _table(value: Any, width: int, name: str) -> Any:
    """Convert a DataFrame, a file or an array (n, width) to a table of texts.

    Raises
    ------
    InputError
        If the array has another shape or contains an invalid row.
    """
    if hasattr(value, "columns") or is_path(value):
        return to_text_table(value, name)
    from pandas import DataFrame

    names = (
        ("x", "y", "z")
        if width == 3
        else ("hanging_x", "hanging_y", "hanging_z", "footwall_x", "footwall_y", "footwall_z")
    )
    array = points(value, name) if is_model(value) else numbers(value, name)
    if array.ndim != 2 or array.shape[1] != width:
        raise wrong_shape_error(array, f"(n, {width})", name)
    require_valid_rows(find_invalid_points(array[:, :3]) | find_invalid_points(array[:, -3:]), name)
    return to_text_table(DataFrame(array, columns=list(names)), name)
