"""Compass readings from a table: what its columns mean, which north, what is wrong with a row.

A field book is typed by hand, so a row that cannot be read must not take the others with it: it is
listed with its line and the reason. Nothing is guessed that the numbers do not tell: an azimuth
that can be a strike as well as a dip direction waits for the user.
"""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vomstudio.document.edits import new_id
from vomstudio.document.kinds.reading import Reading
from vomstudio.document.records import Point
from vomstudio.errors import InputError
from vomstudio.geology.notation import parse_line, parse_plane
from vomstudio.geology.orientation import Line, wrap360
from vomstudio.io.text.orientation_reading import ALIASES, plane_of
from vomstudio.io.text.rows import (
    cut,
    is_blank,
    is_header,
    parse_number,
    read_text,
    rejoined_header,
    sniff,
)
from vomstudio.io.text.tables import COORDINATES, FARTHEST_M, lines_in_words, plain

NOTATIONS = ("dipdir/dip", "strike/dip", "strike/dip lhr", "quadrant", "trend/plunge")
"""What the two angles of a row are; the last one makes them lines."""

ToGrid = Callable[[float, float], tuple[float, float] | None]
"""From longitude and latitude to x and y of the project."""

NORTHS = ("magnetic", "true", "grid")

ROLES = ("name", "azimuth", "inclination", "quadrant", "text", "trend", "plunge", "geometry",
         "type", "set", "overturned", "x", "y", "z", "longitude", "latitude", "notes")  # fmt: skip
"""What a column can be. `azimuth` and `inclination` are the two angles of the notation, `trend` and
`plunge` those of rows that are lines in a table of planes, `text` both angles in one cell."""

_NAMES = {"name", "label", "reading", "measurement", "station", "locality", "site", "dataid"}
_DEGREES = {"longitude": {"longitude", "long", "lon", "lng"}, "latitude": {"latitude", "lat"}}
_NOTES = {"notes", "note", "comment", "comments", "remark", "remarks", "description"}
_OVERTURNED = {"overturned", "inverted", "overturnedbed"}
_YES = {"1", "true", "yes", "y", "x", "overturned", "inverted"}
_EMPTY = {"", "-", "–", "nan", "na", "n/a", "none"}


@dataclass(frozen=True, eq=False)
class FieldTable:
    """The cells of a text file. ragged: rows that have too many or too few, by index, and why."""

    path: Path
    names: tuple[str, ...] | None
    width: int
    delimiter: str
    rows: list[list[str]]
    lines: list[int]
    ragged: Mapping[int, str]
    notes: tuple[str, ...]

    def label(self, column: int) -> str:
        return self.names[column] if self.names else f"column {column + 1}"


@dataclass(frozen=True)
class Guess:
    """columns: role to column. notation: None where only the user can tell."""

    columns: Mapping[str, int]
    notation: str | None
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class FieldRow:
    """One reading as it stands in the table, before its azimuth is turned to grid north."""

    line: int
    name: str
    geometry: str
    azimuth_deg: float
    inclination_deg: float
    type_name: str = ""
    set_name: str = ""
    position: Point | None = None
    overturned: bool = False
    notes: str = ""


@dataclass(frozen=True)
class BadRow:
    line: int
    reason: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


@dataclass(frozen=True)
class FieldReadings:
    """rows: what can be added; bad: what is skipped, and why; remarks: what else to know."""

    rows: tuple[FieldRow, ...]
    bad: tuple[BadRow, ...]
    remarks: tuple[str, ...]

    @property
    def type_names(self) -> tuple[str, ...]:
        """The names in the type column, each once, in order."""
        return tuple(dict.fromkeys(row.type_name for row in self.rows if row.type_name))


@dataclass(frozen=True)
class Turn:
    """From the north that the compass was read against to grid north.

    declination_deg: east positive, of magnetic readings. convergence_deg: of the meridian, grid
    north east of true north positive; None where no CRS says it.
    """

    north: str
    declination_deg: float = 0.0
    convergence_deg: float | None = None

    @property
    def deg(self) -> float:
        """What is added to an azimuth."""
        if self.north == "grid":
            return 0.0
        turned = self.declination_deg if self.north == "magnetic" else 0.0
        return turned - (self.convergence_deg or 0.0)

    def sentence(self) -> str:
        """What will be done to the azimuths, in words."""
        if self.north == "grid":
            return "Azimuths are kept as read: they are taken to be from grid north."
        steps = []
        if self.north == "magnetic":
            side = "E" if self.declination_deg >= 0 else "W"
            verb = "adds" if self.declination_deg >= 0 else "subtracts"
            steps.append(f"{verb} {abs(self.declination_deg):.4g}° {side} declination")
        if self.convergence_deg is None:
            steps.append("no meridian convergence, for no CRS says it")
        else:
            verb = "subtracts" if self.convergence_deg >= 0 else "adds"
            steps.append(f"{verb} {abs(self.convergence_deg):.2f}° meridian convergence")
        said = ", ".join(steps)
        sign = "−" if round(self.deg, 2) < 0 else "+"
        return f"{said[0].upper()}{said[1:]}: azimuths {sign} {abs(self.deg):.2f}°."


# --- reading ---------------------------------------------------------------------------------
def read_field_table(path: str | Path) -> FieldTable:
    """The cells of a table of readings; rows of another width are kept and marked.

    Raises InputError where the file is missing, is no text, or has no rows.
    """
    path = Path(path)
    text, notes = read_text(path)
    lines = [line.rstrip("\r") for line in text.split("\n")]
    kept = [
        (i, line)
        for i, line in enumerate(lines, 1)
        if not is_blank(line.strip()) and not line.lstrip().startswith("#")
    ]
    if not kept:
        raise InputError("there are no rows in it; a table of readings needs some.", file=path)
    delimiter = sniff([line for _, line in kept[:200]])
    if all(_is_orientation(line) for _, line in kept[1:20]) and len(kept) > 1:
        rows = [[line.strip()] for _, line in kept]  # each line is one reading: N42E 41SE
    else:
        rows = [_cut(line, delimiter) for _, line in kept]
    numbers = [i for i, _ in kept]
    header = is_header(rows[0], delimiter) and not any(_is_orientation(c) for c in rows[0])
    first = rows[0]
    if header:
        rows, numbers = rows[1:], numbers[1:]
        if delimiter == " " and rows:
            first = rejoined_header(first, [], rows)
    names = tuple(first) if header else None
    if not rows:
        raise InputError(
            "there is a header and nothing below it; a table of readings needs rows.", file=path
        )
    width = len(names) if names else Counter(map(len, rows)).most_common(1)[0][0]
    ragged = {}
    for i, row in enumerate(rows):
        while len(row) > width and not row[-1]:
            row.pop()
        if len(row) != width:
            ragged[i] = f"it has {len(row)} cells and not {width}" + (
                "; put a cell with commas in quotation marks" if len(row) > width else ""
            )
            row[:] = (row + [""] * width)[:width]
    return FieldTable(path, names, width, delimiter, rows, numbers, ragged, tuple(notes))


def _cut(line: str, delimiter: str) -> list[str]:
    if '"' not in line:
        return cut(line, delimiter)
    cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.strip() for cell in cells]


def _is_orientation(text: str) -> bool:
    """Both angles in one text; two bare numbers are as likely two columns."""
    if not any(c in text for c in "/°") and not any(c in "NSEWnsew" for c in text):
        return False
    for parse in (parse_plane, parse_line):
        try:
            parse(text)
        except InputError:
            continue
        return True
    return False


# --- guessing --------------------------------------------------------------------------------
def guess(table: FieldTable) -> Guess:
    """What the headers, and where there are none the cells, say of the columns."""
    if table.names is None:
        return _guess_without_names(table)
    known = [plain(name) for name in table.names]

    def first(aliases: Iterable[str]) -> int | None:
        wanted = set(aliases)
        return next((i for i, name in enumerate(known) if name in wanted), None)

    def of(meaning: str) -> int | None:
        return first(ALIASES[meaning])

    found: dict[str, int | None] = {
        "name": first(_NAMES),
        "type": of("kind"),
        "set": of("set"),
        "geometry": of("geometry"),
        "notes": first(_NOTES),
        "overturned": first(_OVERTURNED),
        "text": of("attitude"),
    }
    if found["name"] is None:
        found["name"] = of("id")
    for letter in "xyz":
        found[letter] = first({letter})
        if found[letter] is None:
            found[letter] = first(COORDINATES[letter])
    if found["x"] is None or found["y"] is None:
        found |= {role: first(aliases) for role, aliases in _DEGREES.items()}
    direction, strike, azimuth = of("dip direction"), of("strike"), of("azimuth")
    dip, quadrant = of("dip"), of("quadrant")
    trend, plunge = of("trend"), of("plunge")
    notation: str | None = None
    if dip is not None:
        found["inclination"] = dip
        if direction is not None and strike is not None and _are_winds(table, direction):
            direction, quadrant = None, direction
        if direction is not None:
            found["azimuth"], notation = direction, "dipdir/dip"
        elif strike is not None or quadrant is not None:
            found["azimuth"] = strike if strike is not None else azimuth
            found["quadrant"] = quadrant
            notation = _strike_notation(table, found["azimuth"], dip, quadrant)
        else:
            found["azimuth"] = azimuth
        found["trend"], found["plunge"] = trend, plunge
    elif trend is not None or (plunge is not None and azimuth is not None):
        found["azimuth"] = azimuth if trend is None else trend
        found["inclination"] = plunge
        notation = "trend/plunge"
    if found["text"] is None and found.get("azimuth") is None:
        found["text"] = _text_column(table)
    if notation is None and found["text"] is not None:
        notation = _said_by_text(table, found["text"])
    remarks = []
    declination = first({"declination", "magneticdeclination", "magdec", "decl"})
    if declination is not None:
        values = sorted({row[declination] for row in table.rows} - {""})
        what = values[0] if len(values) == 1 else f"{len(values)} different values"
        remarks.append(
            f"The column “{table.label(declination)}” ({what}) is not applied by itself: choose "
            "the north and type the declination."
        )
    return Guess(_once(found), notation, tuple(remarks))


def _guess_without_names(table: FieldTable) -> Guess:
    text = _text_column(table)
    if text is not None:
        return Guess({"text": text}, _said_by_text(table, text))
    for first in range(table.width - 1):
        cells = [(row[first], row[first + 1]) for row in table.rows[:50]]
        winds = any(c in "NSEW" for pair in cells for word in pair for c in word.upper())
        if winds and sum(_is_orientation(" ".join(pair)) for pair in cells) > len(cells) / 2:
            return Guess({"azimuth": first, "inclination": first + 1}, "quadrant")
        pairs = [(_number(a, table), _number(b, table)) for a, b in cells]
        sound = [
            a is not None and b is not None and 0 <= a <= 360 and 0 <= b <= 90 for a, b in pairs
        ]
        if sum(sound) > len(sound) / 2:
            return Guess({"azimuth": first, "inclination": first + 1}, None)
    return Guess({}, None)


def _text_column(table: FieldTable) -> int | None:
    """The first column most of whose cells name an orientation."""
    for column in range(table.width):
        cells = [row[column] for row in table.rows[:50] if row[column]]
        if cells and sum(map(_is_orientation, cells)) > len(cells) / 2:
            return column
    return None


def _said_by_text(table: FieldTable, column: int) -> str | None:
    """What pairs in one cell mean, where none of them is bare or the header says it."""
    name = plain(table.names[column]) if table.names else ""
    if "dipdir" in name:
        return "dipdir/dip"
    if "strike" in name:
        return "strike/dip"
    if "trend" in name or "lineation" in name:
        return "trend/plunge"
    bare = any(
        row[column] and not any(c in "NSEW" for c in row[column].upper()) for row in table.rows
    )
    return None if bare else "quadrant"


def _strike_notation(
    table: FieldTable, strike: int | None, dip: int, quadrant: int | None
) -> str | None:
    if strike is None:
        return None
    if quadrant is not None:
        return "quadrant" if all(row[quadrant] for row in table.rows) else "strike/dip"
    if any(c in "NSEW" for row in table.rows for c in (row[strike] + row[dip]).upper()):
        return "quadrant"
    name = plain(table.label(strike))
    return "strike/dip lhr" if "lhr" in name or "left" in name else "strike/dip"


def _are_winds(table: FieldTable, column: int) -> bool:
    cells = [row[column].upper() for row in table.rows if row[column]]
    return bool(cells) and all(set(cell) <= set("NSEW") for cell in cells)


def _once(found: Mapping[str, int | None]) -> dict[str, int]:
    """No column has two roles: the first one stays."""
    columns: dict[str, int] = {}
    for role, column in found.items():
        if column is not None and column not in columns.values():
            columns[role] = column
    return columns


# --- understanding ---------------------------------------------------------------------------
def what_is_missing(columns: Mapping[str, int], notation: str | None) -> str | None:
    """Why the table cannot be understood yet; None where it can."""
    if "text" not in columns:
        if "azimuth" not in columns and "inclination" not in columns:
            return "Say which columns hold the two angles, or which one holds both."
        if "azimuth" not in columns or "inclination" not in columns:
            other = "azimuth" if "inclination" in columns else "dip or plunge"
            return f"Say which column holds the {other}."
    if notation is None:
        return "Say what the angles are: the numbers do not tell a strike from a dip direction."
    return None


def understand(
    table: FieldTable,
    columns: Mapping[str, int],
    notation: str,
    to_grid: ToGrid | None = None,
) -> FieldReadings:
    """The readings of a table, as written: no azimuth is turned here.

    columns: role (of `ROLES`) to column. notation: one of `NOTATIONS`. A line that points up is
    given by its other end. A position needs x, y and z, or longitude, latitude and z and what turns
    degrees into x and y (`io.crs.from_degrees`); else the reading has none.
    """
    if notation not in NOTATIONS:
        raise ValueError(notation)
    rows: list[FieldRow] = []
    bad: list[BadRow] = []
    turned_over: list[int] = []
    placeless: list[int] = []
    for i, (cells, line) in enumerate(zip(table.rows, table.lines, strict=True)):
        if i in table.ragged:
            bad.append(BadRow(line, table.ragged[i]))
            continue
        word = {role: cells[column] for role, column in columns.items()}
        try:
            geometry, azimuth, inclination = _orientation(word, notation, table)
        except InputError as error:
            bad.append(BadRow(line, error.message))
            continue
        if inclination < 0:
            turned_over.append(line)
            azimuth, inclination = float(wrap360(azimuth + 180.0)), -inclination
        position = _position(word, table, to_grid)
        if position is None and any(word.get(c) for c in ("x", "y", "longitude", "latitude")):
            placeless.append(line)
        rows.append(
            FieldRow(
                line=line,
                name=word.get("name", ""),
                geometry=geometry,
                azimuth_deg=azimuth,
                inclination_deg=inclination,
                type_name=word.get("type", ""),
                set_name=word.get("set", ""),
                position=position,
                overturned=word.get("overturned", "").casefold() in _YES,
                notes=word.get("notes", ""),
            )
        )
    remarks = list(table.notes)
    if turned_over:
        remarks.append(
            f"{len(turned_over)} lines plunge upward and are given by their other end: "
            f"{lines_in_words(turned_over)}."
        )
    if placeless:
        n = len(placeless)
        why = "have no whole position (x, y and z)" if n > 1 else "has no whole position"
        if "longitude" in columns and to_grid is None:
            why = "have" if n > 1 else "has"
            why += " a position in degrees, which needs a project with a CRS,"
        remarks.append(
            f"{n} reading{'s' if n > 1 else ''} {why} and come{'' if n > 1 else 's'} without one: "
            f"{lines_in_words(placeless)}."
        )
    return FieldReadings(tuple(rows), tuple(bad), tuple(remarks))


def _orientation(
    word: Mapping[str, str], notation: str, table: FieldTable
) -> tuple[str, float, float]:
    """("plane" or "line", azimuth, inclination) of a row. Raises InputError."""
    said = word.get("geometry", "").casefold()
    given = [word.get("azimuth", ""), word.get("inclination", "")]
    is_empty = all(cell.casefold() in _EMPTY for cell in (*given, word.get("text", "")))
    if word.get("plunge", "") and (said.startswith("line") or is_empty):
        return _line(word.get("trend", ""), word["plunge"], table)
    if word.get("text", "").casefold() not in _EMPTY:
        if notation == "trend/plunge" or said.startswith("line"):
            line = parse_line(word["text"])
            return "line", line.trend_deg, line.plunge_deg
        plane = parse_plane(word["text"], notation)
        return "plane", plane.dip_direction_deg, plane.dip_deg
    if is_empty:
        raise InputError("there are no angles")
    for cell, what in zip(given, ("azimuth", "dip or plunge"), strict=True):
        if cell.casefold() in _EMPTY:
            raise InputError(f"there is no {what}")
    if notation == "trend/plunge":
        return _line(given[0], given[1], table)
    azimuth, dip = (_number(cell, table) for cell in given)
    if (
        notation == "dipdir/dip"
        and azimuth is not None
        and dip is not None
        and 0.0 <= azimuth <= 360.0
        and 0.0 <= dip <= 90.0
    ):
        return "plane", float(wrap360(azimuth)) if dip else 0.0, dip
    if azimuth is not None and azimuth > 360.0:
        raise InputError(f"an azimuth of {azimuth:g} is not within 0 to 360.")
    quadrant = word.get("quadrant", "") if notation in ("quadrant", "strike/dip") else ""
    plane = plane_of((*given, quadrant) if quadrant else tuple(given), notation)
    return "plane", plane.dip_direction_deg, plane.dip_deg


def _line(trend: str, plunge: str, table: FieldTable) -> tuple[str, float, float]:
    a, b = _number(trend, table), _number(plunge, table)
    if a is not None and b is not None:
        if not 0.0 <= a <= 360.0:
            raise InputError(f"a trend of {a:g} is not within 0 to 360.")
        if not -90.0 <= b <= 90.0:
            raise InputError(f"a plunge of {b:g} is over 90.")
        line = Line(a, b)
    else:
        line = parse_line(f"{trend} {plunge}")
    return "line", line.trend_deg, line.plunge_deg


def _position(word: Mapping[str, str], table: FieldTable, to_grid: ToGrid | None) -> Point | None:
    x, y, z, longitude, latitude = (
        _number(word.get(role, ""), table) for role in ("x", "y", "z", "longitude", "latitude")
    )
    if (x is None or y is None) and to_grid and longitude is not None and latitude is not None:
        found = to_grid(longitude, latitude) if abs(latitude) <= 90.0 else None
        x, y = found if found is not None else (None, None)
    if x is None or y is None or z is None or max(abs(x), abs(y), abs(z)) > FARTHEST_M:
        return None
    return x, y, z


def _number(cell: str, table: FieldTable) -> float | None:
    """None where it is no finite number."""
    if not cell:
        return None
    value = parse_number(cell.rstrip("°"), decimal_comma=table.delimiter in ";\t")
    return value if value is not None and math.isfinite(value) else None


# --- records ---------------------------------------------------------------------------------
def make_readings(
    rows: Sequence[FieldRow],
    *,
    type_ids: Mapping[str, str],
    type_id: str,
    set_name: str = "",
    turn_deg: float = 0.0,
    source: str = "",
) -> list[Reading]:
    """Records of the rows, their azimuths turned to grid north.

    type_ids: the id for each name in the type column, by its casefolded name; `type_id` and
    `set_name` are for rows that have none. A horizontal plane and a vertical line keep azimuth 0.
    """
    readings = []
    for row in rows:
        undefined = row.inclination_deg == (0.0 if row.geometry == "plane" else 90.0)
        azimuth = 0.0 if undefined else float(wrap360(row.azimuth_deg + turn_deg))
        readings.append(
            Reading(
                id=new_id("reading"),
                name=row.name,
                type_id=type_ids.get(row.type_name.casefold(), type_id)
                if row.type_name
                else type_id,
                geometry="line" if row.geometry == "line" else "plane",
                azimuth_deg=azimuth,
                inclination_deg=row.inclination_deg,
                turned_deg=turn_deg,
                position=row.position,
                source=source,
                set_name=row.set_name or set_name,
                overturned=row.overturned,
                notes=row.notes,
            )
        )
    return readings
