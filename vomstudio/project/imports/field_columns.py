"""What the columns of a table of readings mean, by their names and by what stands in them.

Nothing is guessed that the numbers do not tell: an azimuth that can be a strike as well as a dip
direction waits for the user.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.orientation_columns import ALIASES
from vomstudio.io.text.tables import COORDINATES
from vomstudio.project.imports.field_table import FieldTable, is_orientation, number_in

_NAMES = {"name", "label", "reading", "measurement", "station", "locality", "site", "dataid"}
_DEGREES = {"longitude": {"longitude", "long", "lon", "lng"}, "latitude": {"latitude", "lat"}}
_NOTES = {"notes", "note", "comment", "comments", "remark", "remarks", "description"}


@dataclass(frozen=True)
class Guess:
    """columns: role to column. notation: None where only the user can tell."""

    columns: Mapping[str, int]
    notation: str | None
    findings: tuple[Finding, ...] = ()


def guess(table: FieldTable) -> Guess:
    """What the headers, and where there are none the cells, say of the columns."""
    if table.names is None:
        return _guess_without_names(table)
    known = [normalise_name(name) for name in table.names]

    def first(aliases: Iterable[str]) -> int | None:
        wanted = set(aliases)
        return next((i for i, name in enumerate(known) if name in wanted), None)

    def of(meaning: str) -> int | None:
        return first(ALIASES[meaning])

    found: dict[str, int | None] = {
        "name": first(_NAMES),
        "type": of("kind"),
        "set": of("set"),
        "element": of("element"),
        "notes": first(_NOTES),
        "overturned": of("overturned"),
        "text": of("attitude"),
    }
    if found["set"] is None:
        found["set"] = first({"domain"})
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
    findings = []
    declination = first({"declination", "magneticdeclination", "magdec", "decl"})
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
    return Guess(_once(found), notation, tuple(findings))


def _guess_without_names(table: FieldTable) -> Guess:
    text = _text_column(table)
    if text is not None:
        return Guess({"text": text}, _said_by_text(table, text))
    for first in range(table.width - 1):
        cells = [(row[first], row[first + 1]) for row in table.rows[:50]]
        winds = any(c in "NSEW" for pair in cells for word in pair for c in word.upper())
        if winds and sum(is_orientation(" ".join(pair)) for pair in cells) > len(cells) / 2:
            return Guess({"azimuth": first, "inclination": first + 1}, "quadrant")
        pairs = [(number_in(a, table), number_in(b, table)) for a, b in cells]
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
        if cells and sum(map(is_orientation, cells)) > len(cells) / 2:
            return column
    return None


def _said_by_text(table: FieldTable, column: int) -> str | None:
    """What pairs in one cell mean, where none of them is bare or the header says it."""
    name = normalise_name(table.names[column]) if table.names else ""
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
    name = normalise_name(table.label(strike))
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
