"""True measures: displacements of faults, planes through three points, logs along a line."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from vomstudio.api.checking import (
    angles_of,
    attitude_of,
    is_path,
    numbers,
    plane_text,
    refuse_rows,
    warn,
    wrong_shape,
)
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.frame_arguments import UpAxis, frame_arguments_named, frame_options
from vomstudio.api.tables import text_of
from vomstudio.geology.beds.bed_log import BedLog, bed_log
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.faults.displacement_options import DisplacementOptions, ThreePointOptions
from vomstudio.geology.faults.displacement_pairs import Displacements, displacements
from vomstudio.geology.faults.three_points import ThreePoints, plane_of_three_points
from vomstudio.geology.notation import exact_line
from vomstudio.geology.orientation import Line
from vomstudio.geometry.coordinate_limits import no_places
from vomstudio.io.gate.point_tables import read_boundaries, read_pairs


def displacement(
    pairs: Any,
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
    """How far the hanging wall of a fault moved, of pairs of points on both sides.

    Parameters
    ----------
    pairs : (n, 6) World, metres: x, y, z on the hanging wall, then on the footwall; or a DataFrame
        or file with the columns ``hanging_x`` ... ``footwall_z`` and, if wanted, ``name``
    fault : (dip direction, dip), degrees
    bed : (dip direction, dip) where the points are cut-offs of a bed; None where each pair was one
        point (piercing points)
    rake_deg, slip : of the slip lineation on the fault, or its (trend, plunge); an axis
    sigma_m : standard deviation of each coordinate; None for 0
    fault_error_deg, bed_error_deg : half-angles of the 95 % cones of the two normals
    rake_error_deg : 95 % of the rake
    crs, up, unit, to_crs : frame of the coordinates, as in `vs.read`; a file's comments and its
        `.prj` count; other units and systems are converted or refused

    Returns
    -------
    Displacements: ``what`` ("net slip", or "separation" where the slip is unknown), ``n``,
    ``pairs`` (each with ``displacement`` or ``separations``), means and standard deviations of net
    slip, throw and heave in metres, ``skipped``, ``warnings``.

    Raises
    ------
    vs.errors.UsageError for a slip without a bed, both ``rake_deg`` and ``slip``, and negative
    errors; vs.errors.GeometryError where no pair has a result; vs.errors.InputError for a table
    without these columns.

    Piercing points give the net slip, cut-offs give it along a known slip and separations without
    one (Hill 1959, Journal of Geology 67, 641-653).

    Examples
    --------
    Ten metres down the dip of a fault of 60 degrees:

    >>> import vomstudio as vs
    >>> found = vs.displacement([[5, 0, -8.66, 0, 0, 0]], fault=(90, 60), sigma_m=0.1)
    >>> round(found.mean_net_m, 2), round(found.mean_heave_m, 2)
    (10.0, 5.0)
    """
    options = options_from_arguments(
        DisplacementOptions,
        fault=plane_text(fault, "fault"),
        bed=None if bed is None else plane_text(bed, "bed"),
        rake_deg=rake_deg,
        slip=None if slip is None else exact_line(Line(*angles_of(slip, "slip", 2))),
        sigma_m=sigma_m,
        fault_error_deg=fault_error_deg,
        bed_error_deg=bed_error_deg,
        rake_error_deg=rake_error_deg,
    )
    with frame_arguments_named():
        read = read_pairs(_table(pairs, 6, "pairs"), frame_options(crs, up, unit, to_crs))
    with arguments_named(DisplacementOptions):
        found = displacements(read.names, read.points[:, :3], read.points[:, 3:], options)
    found = replace(found, warnings=(*read.warnings, *found.warnings))
    warn(found.warnings)
    return found


def threepoint(
    points: Any,
    *,
    sigma_m: float = 0.0,
    crs: str | None = None,
    up: UpAxis | None = None,
    unit: str | None = None,
    to_crs: str | None = None,
) -> ThreePoints:
    """The plane through three points or more, with the errors that follow from theirs.

    Parameters
    ----------
    points : (n, 3) World, metres, or a DataFrame or file with rows of x, y, z; n at least 3
    sigma_m : standard deviation of each coordinate; without it more than three points tell it by
        their misfit
    crs, up, unit, to_crs : frame of the coordinates, as in `vs.read`; a file's comments and its
        `.prj` count; other units and systems are converted or refused

    Returns
    -------
    ThreePoints: ``dip_direction_deg``, ``dip_deg``, ``strike_rhr_deg``, ``dip_error_deg`` and
    ``dip_direction_error_deg`` (95 %, each by itself), ``max_confidence95_deg`` (half-angle of the
    joint 95 % cone in the worst direction), ``n``, ``rms_m`` of the points about the plane (None of
    three), ``sigma_m`` behind the errors, ``warnings``, ``dropped_lines``; None where nothing is
    known of errors.

    Raises
    ------
    vs.errors.GeometryError for points on one line, or fewer than three;
    vs.errors.UsageError for a negative sigma; vs.errors.InputError for a table without places.

    The plane of least squares, which of three points goes through all; its errors are those of all
    planes that the points allow.

    Examples
    --------
    >>> import vomstudio as vs
    >>> found = vs.threepoint([[0, 0, 100], [0, 50, 100], [40, 20, 80]], sigma_m=0.5)
    >>> round(found.dip_direction_deg), round(found.dip_deg, 1), round(found.dip_error_deg, 1)
    (90, 26.6, 1.5)
    """
    options = options_from_arguments(ThreePointOptions, sigma_m=sigma_m)
    frame = frame_options(crs, up, unit, to_crs)
    with frame_arguments_named():
        read = read_boundaries(_table(points, 3, "points"), frame)
    found = plane_of_three_points(read.points, options.sigma_m).of_table(
        read.dropped, read.warnings
    )
    warn(found.warnings)
    return found


def log(
    table: Any,
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
    """Boundaries of beds along a line, and the true thickness between them.

    Parameters
    ----------
    table : (n, 3) World, metres, a point on each boundary, or a DataFrame or file with x, y, z
        and, if wanted, ``name``, ``lithology`` and ``notes`` of the bed that begins there
    bed : (dip direction, dip) of the beds, degrees
    sigma_m : standard deviation of each coordinate; None for 0
    bed_error_deg : half-angle of the 95 % cone of the bedding's normal; None for 0
    overturned : younger beds lie below
    crs, up, unit, to_crs : frame of the coordinates, as in `vs.read`; a file's comments and its
        `.prj` count; other units and systems are converted or refused

    Returns
    -------
    BedLog: ``n``, ``intervals`` from the oldest up (``number``, ``base``, ``top``, ``base_m``,
    ``top_m``, ``thickness_m`` with ``value`` and ``error95``, ``lithology``, ``strabospot``: its
    fields in StraboSpot's forms, ``notes``), ``total_m``, ``reordered``, ``warnings``.

    Raises
    ------
    vs.errors.GeometryError for fewer than two boundaries; vs.errors.UsageError for negative
    errors; vs.errors.InputError for a table without places.

    Thickness is what of the way between two points runs across the bedding (Ragan 2009, Structural
    Geology, chapter 2), its error to first order.

    Examples
    --------
    Ten metres along the ground across beds that dip 30 degrees are five across the beds:

    >>> import vomstudio as vs
    >>> found = vs.log([[0, 0, 0], [10, 0, 0]], bed=(90, 30), bed_error_deg=2)
    >>> round(found.total_m.value, 2), round(found.total_m.error95, 2)
    (5.0, 0.24)
    """
    options = options_from_arguments(
        LogOptions, sigma_m=sigma_m, bed_error_deg=bed_error_deg, overturned=overturned
    )
    frame = frame_options(crs, up, unit, to_crs)
    with frame_arguments_named():
        read = read_boundaries(_table(table, 3, "table"), frame)
    found = bed_log(
        read.points,
        attitude_of(bed, "bed"),
        names=read.names,
        lithologies=read.lithologies,
        notes=read.notes,
        sigma_m=options.sigma_m or 0.0,
        bed_error_deg=options.bed_error_deg or 0.0,
        overturned=options.overturned,
    )
    found = replace(found, warnings=(*read.warnings, *found.warnings))
    warn(found.warnings)
    return found


def _table(given: Any, width: int, name: str) -> Any:
    """Return a DataFrame, a file or an array (n, width) as a table of texts. Raises InputError."""
    if hasattr(given, "columns") or is_path(given):
        return text_of(given, name)
    from pandas import DataFrame

    names = (
        ("x", "y", "z")
        if width == 3
        else ("hanging_x", "hanging_y", "hanging_z", "footwall_x", "footwall_y", "footwall_z")
    )
    array = numbers(given, name)
    if array.ndim != 2 or array.shape[1] != width:
        raise wrong_shape(array, f"(n, {width})", name)
    refuse_rows(no_places(array[:, :3]) | no_places(array[:, -3:]), name)
    return text_of(DataFrame(array, columns=list(names)), name)
