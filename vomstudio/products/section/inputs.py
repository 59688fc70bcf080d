"""Input files of sections: the profile line, and the features to project."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.io.gate.axes import assumption_finding
from vomstudio.io.gate.points import ModelFrame, points_to_world
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.text.table_options import NO_TABLE_OPTIONS, TableOptions
from vomstudio.products.ortho.interpretation import Item, items_from_table, read_items

GIS_SUFFIXES = (".gpkg", ".geojson", ".json", ".shp", ".dxf")


@dataclass(frozen=True, eq=False)
class ProfileLine:
    """Profile line as stored in its file.

    Parameters
    ----------
    path : Path
    points : (n, 2) float64
        Coordinates as written in the file.
    stated : StatedCrs
    unit_m : float, optional
        Metres per unit of a CAD drawing; None if the file states no unit.
    is_crs_missing : bool
        Whether the file is GeoJSON without a ``crs``, which is in degrees according to the
        standard.
    warnings : tuple of Finding
    """

    path: Path
    points: FloatArray
    stated: StatedCrs
    unit_m: float | None = None
    is_crs_missing: bool = False
    warnings: tuple[Finding, ...] = ()


def read_profile_line(path: str | Path, progress: Progress | None = None) -> ProfileLine:
    """Read a profile line from a text table (x, y, z or x, y) or a GIS layer.

    Raises
    ------
    InputError
        If the file cannot be read, has several lines, or has fewer than two points.
    """
    path = Path(path)
    if path.suffix.lower() not in GIS_SUFFIXES:
        return _line_from_table(path)
    from vomstudio.io.gis.dxf_properties import read_dxf_properties
    from vomstudio.io.gis.layer_reading import is_geojson_without_crs
    from vomstudio.io.gis.line_reading import read_gis_lines

    gis_lines = read_gis_lines(path, progress)
    if len(gis_lines.lines) != 1:
        raise _line_count_error(len(gis_lines.lines), path)
    line = gis_lines.lines[0]
    unit = read_dxf_properties(path).unit_m if path.suffix.lower() == ".dxf" else None
    return ProfileLine(
        path,
        line.points[:, :2],
        StatedCrs(line.crs),
        unit_m=unit,
        is_crs_missing=is_geojson_without_crs(path),
        warnings=gis_lines.warnings,
    )


def profile_to_world(
    line: ProfileLine, crs: str | None, bounds: FloatArray
) -> tuple[FloatArray, tuple[Finding, ...]]:
    """Convert a profile line to the World frame.

    CAD templates state arbitrary units, so the stated unit is used only if the line overlaps the
    model in that unit but not in metres. GeoJSON without a ``crs`` is assumed to be in degrees,
    unless the unconverted coordinates overlap the model.

    Parameters
    ----------
    line : ProfileLine
    crs : str or None
        CRS of the World frame.
    bounds : (2, 3) float
        Minimum and maximum coordinates of the model in the World frame.

    Returns
    -------
    points : (n, 2) float64
    warnings : tuple of Finding

    Raises
    ------
    InputError
        If the line is not metric and cannot be converted, as in `points_to_world`.
    """
    warnings = list(line.warnings)
    if line.unit_m not in (None, 1.0) and not _boxes_overlap(line.points, bounds):
        line_in_metres = line.points * line.unit_m
        if _boxes_overlap(line_in_metres, bounds):
            unit = f"{line.unit_m:g} m"
            warnings.append(Finding("frame.unit-converted", unit=unit, height_unit=unit))
            return line_in_metres, tuple(warnings)
    if line.is_crs_missing and _boxes_overlap(line.points, bounds):
        warnings.append(assumption_finding(line.path, up="z", unit="m"))
        return line.points, tuple(warnings)
    placed_points = points_to_world(
        np.column_stack([line.points, np.zeros(len(line.points))]),
        file=line.path,
        stated_crs=line.stated,
        model=ModelFrame(crs),
    )
    return placed_points.points[:, :2], (*warnings, *placed_points.findings)


def _boxes_overlap(points: FloatArray, bounds: FloatArray) -> bool:
    """Return whether the bounding boxes of a line (n, 2) and a model overlap."""
    low, high = points.min(axis=0), points.max(axis=0)
    return bool((low <= bounds[1, :2]).all() and (high >= bounds[0, :2]).all())


def _line_count_error(count: int, path: Path) -> InputError:
    return InputError(
        Finding("section.several-lines", count=count), file=path, field="--section-line"
    )


def _line_from_table(path: Path) -> ProfileLine:
    from vomstudio.io.text.tables import read_table

    table = read_table(path)
    line_columns = [
        k for k, name in enumerate(table.names or ()) if name.strip().casefold() == "line"
    ]
    if line_columns and len(lines := set(table.labels(line_columns[0])) - {""}) > 1:
        raise _line_count_error(len(lines), path)
    columns_xy = [
        k
        for k, name in enumerate(table.names or ())
        if name.strip().casefold() in _COORDINATE_NAMES
    ]
    columns = columns_xy[:2] if len(columns_xy) >= 2 else [0, 1]
    points = table.numbers(columns)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        raise InputError(Finding("section.too-few-points"), file=path, field="--section-line")
    stated_crs, findings = table_crs(path, table.comments)
    return ProfileLine(path, points, stated_crs, warnings=findings)


_COORDINATE_NAMES = ("x", "y", "easting", "northing", "e", "n", "x_m", "y_m")


@dataclass(frozen=True, eq=False)
class FeatureInput:
    """Features read for a section.

    Attributes
    ----------
    items : tuple of Item
        Features with a position.
    convention : str
        Meaning of the columns of a table; "" for a project.
    """

    items: tuple[Item, ...] = ()
    convention: str = ""
    warnings: tuple[Finding, ...] = ()


def read_features(
    path: str | Path,
    options: TableOptions = NO_TABLE_OPTIONS,
    model: ModelFrame | None = None,
) -> FeatureInput:
    """Read the features of a project, or the planes of an orientation table with x, y, z.

    Parameters
    ----------
    path : str or Path
    options : TableOptions
        Columns and layer of a table.
    model : ModelFrame, optional
        Frame of the model that the section cuts; the coordinates of a table are converted to it.

    Raises
    ------
    InputError
        If the file cannot be read, or if no plane of the table has a position.
    UsageError
        If an option is invalid.
    """
    path = Path(path)
    if path.is_dir() or path.name == "journal.sqlite":
        return FeatureInput(read_items(path))
    from vomstudio.io.gate.orientation_files import read_orientations
    from vomstudio.io.text.column_mapping import parse_columns
    from vomstudio.io.text.tables import coordinate_columns

    table = read_orientations(
        path,
        options.azimuth,
        columns=parse_columns(options.columns),
        layer=options.layer,
    )
    columns = coordinate_columns(table.table)
    placed_points = points_to_world(
        table.table.numbers(columns)[table.row_indices],
        file=path,
        comments=table.table.comments,
        model=model,
    )
    positions = placed_points.points
    is_usable = np.asarray(table.is_plane & np.isfinite(positions).all(axis=1))
    if not is_usable.any():
        raise InputError(Finding("section.no-planes"), file=path)

    def words(column: str) -> list[str]:
        is_known = column in (table.table.names or ())
        return table.column(column) if is_known else [""] * len(table)

    names, domains, qualities = words("name"), words("domain"), words("quality")
    rows = [
        {
            "id": table.ids[k],
            "name": names[k],
            "kind": "" if table.kinds is None else table.kinds[k],
            "set": "" if table.sets is None else table.sets[k],
            "domain": domains[k],
            "quality": qualities[k],
            "dip_direction_deg": float(table.dip_direction_deg[k]),
            "dip_deg": float(table.dip_deg[k]),
            "overturned": table.overturned is not None and table.overturned[k] is True,
        }
        for k in np.flatnonzero(is_usable)
    ]
    warnings: list[Finding] = [*table.warnings, *placed_points.findings]
    lines = int((~table.is_plane).sum())
    if lines:
        warnings.append(Finding("section.lines-left-out", count=lines))
    is_unlocated = table.is_plane & ~is_usable
    if is_unlocated.any():
        line_numbers = [int(n) for n in table.line_numbers[is_unlocated]]
        warnings.append(
            Finding("section.planes-without-place", count=len(line_numbers), lines=line_numbers)
        )
    return FeatureInput(
        items_from_table(positions[is_usable], rows), table.convention, tuple(warnings)
    )
