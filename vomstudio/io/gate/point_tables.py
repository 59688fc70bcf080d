"""Reading of point tables in World coordinates, for commands, functions and the window."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.points import ModelFrame, WorldPoints, points_to_world
from vomstudio.io.text import log_reading, tables
from vomstudio.io.text.file_text import MAX_OBJECTS
from vomstudio.io.text.log_reading import Boundaries
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.io.text.tables import PointGroups, TextTable, coordinate_columns, read_table


@dataclass(frozen=True, eq=False)
class WorldGroups:
    """Groups of points in the World frame.

    Parameters
    ----------
    groups : PointGroups
        Groups with World coordinates, and the findings from reading and placing them.
    crs : str or None
        CRS of the World frame.
    """

    groups: PointGroups
    crs: str | None


@dataclass(frozen=True, eq=False)
class WorldPairs:
    """Pairs of points on the two sides of a fault.

    Parameters
    ----------
    names : list of str
    points : (n, 6) float64
        East, north and up in metres on the hanging wall, followed by those on the footwall.
    warnings : tuple of Finding
    """

    names: list[str]
    points: FloatArray
    warnings: tuple[Finding, ...] = ()


def read_points(
    path: str | Path,
    by: str | None = None,
    options: FrameOptions = DEFAULT_FRAME,
    model: ModelFrame | None = None,
) -> WorldGroups:
    """Read the points of a text table in World coordinates, grouped by feature.

    Parameters
    ----------
    path : str or Path
    by : str, optional
        Column with the feature of each point; see `vomstudio.io.text.tables.read_points`.
    options : FrameOptions
        Frame options of the caller.
    model : ModelFrame, optional
        Frame of the model to which the points belong, used if the table does not state a frame.

    Raises
    ------
    InputError, UsageError
        If the table cannot be read, and as for `points_to_world`.
    """
    groups = tables.read_points(path, by)
    world_points = points_to_world(
        groups.points, file=Path(path), comments=groups.comments, options=options, model=model
    )
    warnings = (*groups.warnings, *world_points.findings)
    return WorldGroups(
        replace(groups, points=world_points.points, warnings=warnings), world_points.crs
    )


def read_row_positions(
    table: OrientationTable, options: FrameOptions = DEFAULT_FRAME, model: ModelFrame | None = None
) -> WorldPoints | None:
    """Return the coordinates of the rows of an orientation table in the World frame.

    Returns
    -------
    WorldPoints or None
        Points (n, 3), NaN for rows without coordinates; None if the table has no columns x, y and z
        that contain numbers.

    Raises
    ------
    InputError, UsageError
        As for `points_to_world`.
    """
    text_table = table.table
    if text_table.names is None:
        return None
    try:
        points = text_table.numbers(coordinate_columns(text_table))[table.row_indices]
    except InputError:
        return None
    return points_to_world(
        points, file=text_table.path, comments=text_table.comments, options=options, model=model
    )


def read_boundaries(
    table: str | Path | TextTable, options: FrameOptions = DEFAULT_FRAME
) -> Boundaries:
    """Read points with names and notes, such as the boundaries of a log, in World coordinates.

    Raises
    ------
    InputError, UsageError
        If the table cannot be read, and as for `points_to_world`.
    """
    text_table = _table(table)
    boundaries = log_reading.extract_boundaries(text_table)
    world_points = points_to_world(
        boundaries.points, file=text_table.path, comments=text_table.comments, options=options
    )
    return replace(boundaries, points=world_points.points, findings=world_points.findings)


def read_pairs(table: str | Path | TextTable, options: FrameOptions = DEFAULT_FRAME) -> WorldPairs:
    """Read pairs of points on the two sides of a fault in World coordinates.

    Raises
    ------
    InputError, UsageError
        If the table cannot be read, and as for `points_to_world`.
    """
    text_table = _table(table)
    names, points = log_reading.extract_pairs(text_table)
    world_points = points_to_world(
        points.reshape(-1, 3), file=text_table.path, comments=text_table.comments, options=options
    )
    return WorldPairs(names, world_points.points.reshape(-1, 6), world_points.findings)


def _table(table: str | Path | TextTable) -> TextTable:
    return table if isinstance(table, TextTable) else read_table(table, max_lines=MAX_OBJECTS)
