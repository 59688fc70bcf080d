"""What a section takes from files: the line of a profile, and features to be projected onto it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.products.ortho.interpretation import Item, items_of_table, read_items
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

GIS_ENDINGS = (".gpkg", ".geojson", ".json", ".shp", ".dxf")


def read_profile_line(path: str | Path) -> tuple[Array, tuple[str, ...]]:
    """(n, 2) x, y of the line in a text table (x, y, z or x, y) or a GIS layer, and what must be
    said. Raises InputError for a file without a line, and where there are several."""
    path = Path(path)
    if path.suffix.lower() not in GIS_ENDINGS:
        return _line_of_table(path), ()
    from vomstudio.io.gis.line_reading import read_gis_lines

    read = read_gis_lines(path)
    if len(read.lines) != 1:
        raise InputError(
            tr(
                "The file of the profile holds {count} lines. It must hold one.",
                count=len(read.lines),
            ),
            file=path,
            field="--profile",
        )
    points = read.lines[0].points
    wide = bool((np.abs(points) <= [180.0, 90.0]).all())
    if wide and path.suffix.lower() in (".geojson", ".json") and read.crs == "EPSG:4326":
        return points[:, :2], (
            tr(
                "The GeoJSON of the profile states no projected CRS: its coordinates are taken as "
                "metres of World."
            ),
        )
    return points[:, :2], ()


def _line_of_table(path: Path) -> Array:
    from vomstudio.io.text.tables import read_table

    table = read_table(path)
    found = [k for k, name in enumerate(table.names or ()) if name.strip().casefold() in _X_Y]
    columns = found[:2] if len(found) >= 2 else [0, 1]
    points = table.numbers(columns)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        raise InputError(
            tr("A profile needs the x and y of at least two points, a row each."),
            file=path,
            field="--profile",
        )
    return points


_X_Y = ("x", "y", "easting", "northing", "e", "n", "x_m", "y_m")


def read_features(path: str | Path) -> tuple[Item, ...]:
    """Features of a project folder, or planes of an orientation table with x, y, z. Raises
    InputError."""
    path = Path(path)
    if path.is_dir() or path.name == "journal.sqlite":
        return read_items(path)
    from vomstudio.io.text.orientation_reading import read_orientations
    from vomstudio.io.text.tables import coordinate_columns

    table = read_orientations(path)
    columns = coordinate_columns(table.table)
    places = table.table.numbers(columns)[table.kept]
    keep = np.asarray(table.is_plane & np.isfinite(places).all(axis=1))
    if not keep.any():
        raise InputError(
            tr("The table has no plane with x, y, z. A feature without a place is on no section."),
            file=path,
        )
    rows = [
        {
            "id": table.ids[k],
            "kind": "" if table.kinds is None else table.kinds[k],
            "set": "" if table.sets is None else table.sets[k],
            "dip_direction_deg": float(table.dip_direction_deg[k]),
            "dip_deg": float(table.dip_deg[k]),
        }
        for k in np.flatnonzero(keep)
    ]
    return items_of_table(places[keep], rows)
