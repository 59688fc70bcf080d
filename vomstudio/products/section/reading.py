"""What a section takes from files: the line of a profile, and features to be projected onto it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.products.ortho.interpretation import Item, items_of_table, read_items
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.io.text.orientation_columns import Azimuth

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


@dataclass(frozen=True, eq=False)
class ReadFeatures:
    """items : with a place; convention : how the columns of a table were understood, "" of a
    project; warnings : sentences"""

    items: tuple[Item, ...] = ()
    convention: str = ""
    warnings: tuple[str, ...] = ()


def read_features(path: str | Path, azimuth: Azimuth | None = None) -> ReadFeatures:
    """Features of a project folder, or planes of an orientation table with x, y, z.

    azimuth : what a column of the table called azimuth means. Raises InputError, UsageError."""
    path = Path(path)
    if path.is_dir() or path.name == "journal.sqlite":
        return ReadFeatures(read_items(path))
    from vomstudio.io.text.orientation_reading import read_orientations
    from vomstudio.io.text.tables import coordinate_columns, lines_in_words

    table = read_orientations(path, azimuth)
    columns = coordinate_columns(table.table)
    places = table.table.numbers(columns)[table.kept]
    keep = np.asarray(table.is_plane & np.isfinite(places).all(axis=1))
    if not keep.any():
        raise InputError(
            tr("The table has no plane with x, y, z. A feature without a place is on no section."),
            file=path,
        )
    named = "name" in (table.table.names or ())
    names = table.column("name") if named else [""] * len(table)
    rows = [
        {
            "id": table.ids[k],
            "name": names[k],
            "kind": "" if table.kinds is None else table.kinds[k],
            "set": "" if table.sets is None else table.sets[k],
            "dip_direction_deg": float(table.dip_direction_deg[k]),
            "dip_deg": float(table.dip_deg[k]),
            "overturned": table.overturned is not None and table.overturned[k] is True,
        }
        for k in np.flatnonzero(keep)
    ]
    said = list(table.warnings)
    lines = int((~table.is_plane).sum())
    if lines:
        said.append(
            tr_n(
                "{count} row of the table is a line and not projected.",
                "{count} rows of the table are lines and not projected.",
                lines,
            )
        )
    nowhere = table.is_plane & ~keep
    if nowhere.any():
        said.append(
            tr_n(
                "{count} plane without x, y, z is on no section: {lines}",
                "{count} planes without x, y, z are on no section: {lines}",
                int(nowhere.sum()),
                lines=lines_in_words([int(n) for n in table.line_numbers[nowhere]]),
            )
        )
    return ReadFeatures(items_of_table(places[keep], rows), table.convention, tuple(said))
