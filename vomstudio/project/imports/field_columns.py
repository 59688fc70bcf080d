"""Detection of the columns of a table of readings from their names and cells.

The module does not guess anything that the numbers leave ambiguous: the user decides whether an
azimuth is a strike or a dip direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from vomstudio.core.findings import Finding
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_columns import ALIASES, LINE_WORDS
from vomstudio.io.text.tables import COORDINATES
from vomstudio.project.imports.field_table import FieldTable, is_orientation, parse_cell

_NAMES = {"name", "label", "reading", "measurement", "dataid"}
_STATION_NAMES = {
    "station",
    "stationid",
    "stationname",
    "stationnumber",
    "stop",
    "outcrop",
    "locality",
    "localityid",
    "localityname",
    "site",
}
"""Words in a type name that mean a line."""
UNCLEAR_WORDS = ("slickenside", "slicken side")
"""Words in a type name that may mean a polished plane or the lines on it."""
_GEOGRAPHIC_NAMES = {
    "longitude": {"longitude", "long", "lon", "lng"},
    "latitude": {"latitude", "lat"},
}
_NOTES_NAMES = {"notes", "note", "comment", "comments", "remark", "remarks", "description"}


@dataclass(frozen=True)
class Guess:
    """Guessed columns by role, and the notation, or None if the user has to select it."""

    columns: Mapping[str, int]
    notation: str | None
    findings: tuple[Finding, ...] = ()


def geometry_of_type(name: str) -> Literal["plane", "line"] | None:
    """Return the geometry that a type name implies; most names imply planes.

    Parameters
    ----------
    name : str

    Returns
    -------
    {"plane", "line"} or None
        None if the name may mean either.
    """
    word = name.casefold()
    if any(item in word for item in UNCLEAR_WORDS):
        return None
    return "line" if any(item in word for item in LINE_WORDS) else "plane"


def guess(table: FieldTable) -> Guess:
    """Guess the roles of the columns from the header or, without a header, from the cells."""
    if table.names is None:
        return _guess_without_names(table)
    names = [normalise_name(name) for name in table.names]

    def find_column(aliases: Iterable[str]) -> int | None:
        accepted_names = set(aliases)
        return next((i for i, name in enumerate(names) if name in accepted_names), None)

    def find_alias_column(meaning: str) -> int | None:
        return find_column(ALIASES[meaning])

    roles: dict[str, int | None] = {
        "name": find_column(_NAMES),
        "station": find_column(_STATION_NAMES),
        "type": find_alias_column("kind"),
        "set": find_alias_column("set"),
        "element": find_alias_column("element"),
        "notes": find_column(_NOTES_NAMES),
        "overturned": find_alias_column("overturned"),
        "text": find_alias_column("attitude"),
    }
    if roles["set"] is None:
        roles["set"] = find_column({"domain"})
    if roles["name"] is None:
        roles["name"] = find_alias_column("id")
    for letter in "xyz":
        roles[letter] = find_column({letter})
        if roles[letter] is None:
            roles[letter] = find_column(COORDINATES[letter])
    if roles["x"] is None or roles["y"] is None:
        roles |= {role: find_column(aliases) for role, aliases in _GEOGRAPHIC_NAMES.items()}
    direction, strike, azimuth = (
        find_alias_column("dip direction"),
        find_alias_column("strike"),
        find_alias_column("azimuth"),
    )
    dip, quadrant = find_alias_column("dip"), find_alias_column("quadrant")
    trend, plunge = find_alias_column("trend"), find_alias_column("plunge")
    notation: str | None = None
    if dip is not None:
        roles["inclination"] = dip
        if direction is not None and strike is not None and _are_directions(table, direction):
            direction, quadrant = None, direction
        if direction is not None:
            roles["azimuth"], notation = direction, "dipdir/dip"
        elif strike is not None or quadrant is not None:
            roles["azimuth"] = strike if strike is not None else azimuth
            roles["quadrant"] = quadrant
            notation = _strike_notation(table, roles["azimuth"], dip, quadrant)
        else:
            roles["azimuth"] = azimuth
        roles["trend"], roles["plunge"] = trend, plunge
    elif trend is not None or (plunge is not None and azimuth is not None):
        roles["azimuth"] = azimuth if trend is None else trend
        roles["inclination"] = plunge
        notation = "trend/plunge"
    if roles["text"] is None and roles.get("azimuth") is None:
        roles["text"] = _text_column(table)
    if notation is None and roles["text"] is not None:
        notation = _text_notation(table, roles["text"])
    findings = []
    declination = find_column({"declination", "magneticdeclination", "magdec", "decl"})
    if declination is not None:
        values = sorted({row[declination] for row in table.rows} - {""})
        findings.append(
            Finding(
                "reading.declination-column",
                column=table.label(declination),
                count=len(values),
                first=values[0] if values else "",
            )
        )
    return Guess(_assign_once(roles), notation, tuple(findings))


def _guess_without_names(table: FieldTable) -> Guess:
    text = _text_column(table)
    if text is not None:
        return Guess({"text": text}, _text_notation(table, text))
    for first_column in range(table.width - 1):
        cells = [(row[first_column], row[first_column + 1]) for row in table.rows[:50]]
        has_directions = any(
            letter in "NSEW" for pair in cells for word in pair for letter in word.upper()
        )
        if (
            has_directions
            and sum(is_orientation(" ".join(pair)) for pair in cells) > len(cells) / 2
        ):
            return Guess({"azimuth": first_column, "inclination": first_column + 1}, "quadrant")
        pairs = [(parse_cell(azimuth, table), parse_cell(dip, table)) for azimuth, dip in cells]
        are_angles = [
            azimuth is not None and dip is not None and 0 <= azimuth <= 360 and 0 <= dip <= 90
            for azimuth, dip in pairs
        ]
        if sum(are_angles) > len(are_angles) / 2:
            return Guess({"azimuth": first_column, "inclination": first_column + 1}, None)
    return Guess({}, None)


def _text_column(table: FieldTable) -> int | None:
    """Return the first column in which most of the cells contain an orientation, or None."""
    for column in range(table.width):
        cells = [row[column] for row in table.rows[:50] if row[column]]
        if cells and sum(map(is_orientation, cells)) > len(cells) / 2:
            return column
    return None


def _text_notation(table: FieldTable, column: int) -> str | None:
    """Return the notation of pairs in one cell, or None if it is not known.

    It is known if the header states it or if all cells contain compass directions.
    """
    name = normalise_name(table.names[column]) if table.names else ""
    if "dipdir" in name:
        return "dipdir/dip"
    if "strike" in name:
        return "strike/dip"
    if "trend" in name or "lineation" in name:
        return "trend/plunge"
    has_numbers = any(
        row[column] and not any(letter in "NSEW" for letter in row[column].upper())
        for row in table.rows
    )
    return None if has_numbers else "quadrant"


def _strike_notation(
    table: FieldTable, strike: int | None, dip: int, quadrant: int | None
) -> str | None:
    if strike is None:
        return None
    if quadrant is not None:
        return "quadrant" if all(row[quadrant] for row in table.rows) else "strike/dip"
    if any(letter in "NSEW" for row in table.rows for letter in (row[strike] + row[dip]).upper()):
        return "quadrant"
    name = normalise_name(table.label(strike))
    return "strike/dip lhr" if "lhr" in name or "left" in name else "strike/dip"


def _are_directions(table: FieldTable, column: int) -> bool:
    cells = [row[column].upper() for row in table.rows if row[column]]
    return bool(cells) and all(set(cell) <= set("NSEW") for cell in cells)


def _assign_once(roles: Mapping[str, int | None]) -> dict[str, int]:
    """Return the columns by role; if a column has several roles, only the first is used."""
    columns: dict[str, int] = {}
    for role, column in roles.items():
        if column is not None and column not in columns.values():
            columns[role] = column
    return columns
