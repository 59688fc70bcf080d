"""What a section takes from files: the line of a profile, and features to be projected onto it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Message
from vomstudio.errors import InputError
from vomstudio.products.ortho.interpretation import Item, items_of_table, read_items
from vomstudio.progress import Progress
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.io.text.orientation_columns import Azimuth

Array = npt.NDArray[np.float64]

GIS_ENDINGS = (".gpkg", ".geojson", ".json", ".shp", ".dxf")


@dataclass(frozen=True, eq=False)
class ProfileLine:
    """points : (n, 2) as the file has them; crs : that the file states; unit_m : metres in a unit
    of a drawing for CAD, None where nothing is said; unnamed : of a GeoJSON, which is in degrees
    where it names no CRS; warnings : sentences"""

    path: Path
    points: Array
    crs: str | None = None
    unit_m: float | None = None
    unnamed: bool = False
    warnings: tuple[Message, ...] = ()


def read_profile_line(path: str | Path, progress: Progress | None = None) -> ProfileLine:
    """The line in a text table (x, y, z or x, y) or a GIS layer. Raises InputError for a file
    without a line, and where there are several."""
    path = Path(path)
    if path.suffix.lower() not in GIS_ENDINGS:
        return ProfileLine(path, _line_of_table(path))
    from vomstudio.io.gis.dxf_facts import dxf_facts
    from vomstudio.io.gis.layer_reading import names_no_crs
    from vomstudio.io.gis.line_reading import read_gis_lines

    read = read_gis_lines(path, progress)
    if len(read.lines) != 1:
        raise _not_one(len(read.lines), path)
    line = read.lines[0]
    unit = dxf_facts(path).unit_m if path.suffix.lower() == ".dxf" else None
    return ProfileLine(path, line.points[:, :2], line.crs, unit, names_no_crs(path), read.warnings)


def profile_in_world(
    line: ProfileLine, crs: str | None, bounds: Array
) -> tuple[Array, tuple[Message, ...]]:
    """(n, 2) x, y of World, and what must be said. crs : of World; bounds : (2, 3) of the model.

    A line in another CRS is converted. What a drawing for CAD says of its unit counts only where
    the line meets the model in that unit and not in metres: templates say what nobody meant. Raises
    InputError for degrees over a model that is on no map.
    """
    said = list(line.warnings)
    if line.unit_m not in (None, 1.0) and not _meets(line.points, bounds):
        scaled = line.points * line.unit_m
        if _meets(scaled, bounds):
            said.append(
                tr(
                    "The drawing is in units of {unit:g} m and was converted to metres.",
                    unit=line.unit_m,
                )
            )
            return scaled, tuple(said)
    moved = _converted(line, crs)
    if line.unnamed and (moved is None or not _meets(moved, bounds)):
        said.append(
            tr(
                "The GeoJSON of the profile states no projected CRS: its coordinates are taken as "
                "metres of World."
            )
        )
        return line.points, tuple(said)
    if moved is None:
        return line.points, tuple(said)
    said.append(tr("The profile was converted to the coordinate reference system of the model."))
    return moved, tuple(said)


def _converted(line: ProfileLine, crs: str | None) -> Array | None:
    """In the CRS of World; None where it is in that one, in none that is known, or World has none.
    Raises InputError."""
    if line.crs is None:
        return None
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError, ProjError

    try:
        theirs = CRS.from_user_input(line.crs)
        ours = None if crs is None else CRS.from_user_input(crs)
    except CRSError:
        return None
    if ours is None:
        if theirs.is_geographic and not line.unnamed:
            raise InputError(
                tr(
                    "The profile is in degrees, and the model has no coordinate reference system. "
                    "Say which one with --crs, or give the line in the coordinates of the model."
                ),
                file=line.path,
                field="--profile",
            )
        return None
    if theirs.equals(ours, True) or not (theirs.is_geographic or theirs.is_projected):
        return None
    try:
        turn = Transformer.from_crs(theirs, ours, always_xy=True)
        moved = np.stack(turn.transform(*line.points.T), axis=1)
    except ProjError:
        return None
    return moved if np.isfinite(moved).all() else None


def _meets(points: Array, bounds: Array) -> bool:
    """Whether a line's box (n, 2) and that of a model have something in common."""
    low, high = points.min(axis=0), points.max(axis=0)
    return bool((low <= bounds[1, :2]).all() and (high >= bounds[0, :2]).all())


def _not_one(count: int, path: Path) -> InputError:
    return InputError(
        tr("The file of the profile holds {count} lines. It must hold one.", count=count),
        file=path,
        field="--profile",
    )


def _line_of_table(path: Path) -> Array:
    from vomstudio.io.text.tables import read_table

    table = read_table(path)
    named = [k for k, name in enumerate(table.names or ()) if name.strip().casefold() == "line"]
    if named and len(lines := set(table.labels(named[0])) - {""}) > 1:
        raise _not_one(len(lines), path)
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
    warnings: tuple[Message, ...] = ()


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
    parts = "domain" if "domain" in (table.table.names or ()) else None
    domains = [""] * len(table) if parts is None else table.column(parts)
    rows = [
        {
            "id": table.ids[k],
            "name": names[k],
            "kind": "" if table.kinds is None else table.kinds[k],
            "set": "" if table.sets is None else table.sets[k],
            "domain": domains[k],
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
