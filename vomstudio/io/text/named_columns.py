"""Text tables whose columns go by several names, as the tables of other programs have them.

Headers are found by what they say, in any order; one that begins with `#` counts too, as Metashape
writes it. Without a header the columns stand in an order that the caller names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.coordinate_limits import why_no_coordinate, why_no_error
from vomstudio.io.text.column_names import plain
from vomstudio.io.text.commented_rows import commented_finding
from vomstudio.io.text.file_text import MOST_OBJECTS
from vomstudio.io.text.rows import parse_number, shortened
from vomstudio.io.text.tables import TextTable, read_table

LABEL = (
    "label",
    "name",
    "point",
    "point id",
    "id",
    "marker",
    "punkt",
    "punktnummer",
    "punkt nr",
    "nr",
    "nom",
    "nombre",
    "punto",
)
PHOTO = (
    "photo",
    "image",
    "image name",
    "photo id",
    "source file",
    "picture",
    "photo name",
    "file",
    "filename",
    "file name",
    "name",
    "label",
    "camera",
    "foto",
    "bild",
    "imagen",
)
WORLD = (
    (
        "x",
        "east",
        "easting",
        "e",
        "world x",
        "lon",
        "longitude",
        "x east",
        "x easting",
        "x longitude",
        "rechtswert",
        "ostwert",
        "est",
        "este",
    ),
    (
        "y",
        "north",
        "northing",
        "n",
        "world y",
        "lat",
        "latitude",
        "y north",
        "y northing",
        "y latitude",
        "hochwert",
        "nordwert",
        "nord",
        "norte",
    ),
    (
        "z",
        "up",
        "height",
        "elevation",
        "altitude",
        "alt",
        "h",
        "world z",
        "z altitude",
        "höhe",
        "hoehe",
        "hauteur",
        "altura",
        "cota",
        "elevación",
        "altitud",
    ),
)
"""Names of columns that hold photos, and World coordinates."""
_SIGMA = (
    ("sigma x", "accuracy x", "error x", "sx", "sigma east", "sigma e"),
    ("sigma y", "accuracy y", "error y", "sy", "sigma north", "sigma n"),
    ("sigma z", "accuracy z", "error z", "sz", "sigma up", "sigma h"),
)
_SIGMA_ALL = ("sigma", "accuracy", "sigma m", "accuracy m")
_WORDS = {"label", "photo", "from", "to"}
_WHOLE = re.compile(r"[+-]?\d+")
_CONTROL = {"", "control", "yes", "true", "1", "gcp"}
_CHECK = {"check", "no", "false", "0"}


class NamedTable:
    """A text table whose columns have several names."""

    def __init__(self, path: str | Path, order: Sequence[str]) -> None:
        """order : of the columns where there is no header"""
        table = read_table(path, named=True, most=MOST_OBJECTS)
        if table.names is None:
            table = _with_header(table, order)
        if not len(table):
            finding = (
                commented_finding(table.commented, "error")
                if table.commented
                else Finding("table.no-rows")
            )
            raise InputError(finding, file=table.path, line=table.header_line)
        self.table, self.path = table, table.path
        self._plain = [plain(name) for name in table.names or ()]

    @property
    def notes(self) -> tuple[Finding, ...]:
        """Findings about comments that look like rows."""
        lines = self.table.commented
        return (commented_finding(lines),) if lines else ()

    def _find(self, names: Sequence[str]) -> int | None:
        for name in names:
            found = [i for i, each in enumerate(self._plain) if each == plain(name)]
            if found:
                return found[0]
        return None

    def has(self, names: Sequence[str]) -> bool:
        return self._find(names) is not None

    def _column(self, names: Sequence[str], called: str) -> int:
        found = self._find(names)
        if found is None:
            raise self.table.header_error(
                Finding(
                    "table.missing-column",
                    column=called,
                    columns=self.table.names or (),
                    names=tuple(names),
                ),
                called,
            )
        return found

    def words(self, names: Sequence[str], called: str, *, empty: bool = False) -> tuple[str, ...]:
        found = tuple(self.table.labels(self._column(names, called)))
        if not empty:
            for row, word in enumerate(found):
                if not word:
                    raise self.at(row, Finding("table.value-missing"), called)
        return found

    def columns(self, names: Sequence[Sequence[str]], called: Sequence[str]) -> FloatArray:
        """(n, columns) finite numbers."""
        which = [self._column(some, word) for some, word in zip(names, called, strict=True)]
        values = np.asarray(self.table.numbers(which), np.float64)
        for row, column in np.argwhere(~np.isfinite(values)):
            raise self.at(int(row), Finding("table.value-missing"), called[int(column)])
        return values

    def positive(self, names: Sequence[str], called: str) -> FloatArray:
        """(n,) positive numbers, NaN where the cell is empty or there is no column."""
        which = self._find(names)
        if which is None:
            return np.full(len(self.table), np.nan)
        values = np.asarray(self.table.numbers([which])[:, 0], np.float64)
        for row in np.flatnonzero(values <= 0):
            raise self.at(int(row), Finding("table.not-positive"), called)
        for line, value in enumerate(values.tolist()):
            if (said := why_no_error(value)) is not None:
                raise self.at(line, said, called)
        return values

    def sigma(self) -> FloatArray:
        """(n, 3) metres."""
        if any(self.has(names) for names in _SIGMA):
            called = ("sigma_x", "sigma_y", "sigma_z")
            return np.column_stack(
                [self.positive(n, c) for n, c in zip(_SIGMA, called, strict=True)]
            )
        return np.repeat(self.positive(_SIGMA_ALL, "sigma")[:, None], 3, axis=1)

    def uses(self) -> BoolArray:
        """(n,) whether it judges only."""
        which = self._find(("use", "role", "type"))
        if which is None:
            return np.zeros(len(self.table), bool)
        words = [cell.casefold() for cell in self.table.cells(which)]
        for row, word in enumerate(words):
            if word not in _CONTROL | _CHECK:
                raise self.at(
                    row,
                    Finding("table.unknown-word", cell=shortened(word), words=("control", "check")),
                    "use",
                )
        return np.array([word in _CHECK for word in words], bool)

    def require_once(self, labels: Sequence[str]) -> None:
        seen: dict[str, int] = {}
        for row, label in enumerate(labels):
            first = seen.setdefault(label, row)
            if first != row:
                raise self.at(
                    row,
                    Finding(
                        "table.repeated-label",
                        label=shortened(label),
                        first_line=int(self.table.line_numbers[first]),
                    ),
                    "label",
                )

    def require_places(self, places: FloatArray) -> None:
        for row, place in enumerate(places.tolist()):
            if (said := why_no_coordinate((place[0], place[1], place[2]))) is not None:
                raise self.at(row, said, "x")

    def at(self, row: int, cause: Finding, called: str) -> InputError:
        return InputError(
            cause, file=self.path, line=int(self.table.line_numbers[row]), field=called
        )


def _with_header(table: TextTable, order: Sequence[str]) -> TextTable:
    """The last comment, where it names as many columns as there are; else our own order."""
    for comment in reversed(table.comments):
        cells = [c.strip() for c in comment.replace(";", ",").replace("\t", ",").split(",")]
        if len(cells) == 1:
            cells = comment.split()
        words = sum(parse_number(cell, decimal_comma=True) is None for cell in cells)
        named = any(cell.isalpha() for cell in cells) and 2 * words > len(cells)
        if len(cells) == table.width and named:
            return replace(table, names=tuple(cells))
    if not order or table.width < len(order):
        raise InputError(
            Finding(
                "table.no-header", columns=tuple(order) or ("dip_direction", "dip", "model_x", "…")
            ),
            file=table.path,
            line=1,
        )
    _refuse_decimal_commas(table, order)
    more = [f"column {i + 1}" for i in range(len(order), table.width)]
    return replace(table, names=(*order, *more))


def _refuse_decimal_commas(table: TextTable, order: Sequence[str]) -> None:
    """Raises InputError where commas part the columns and the digits of numbers as well: twice as
    many cells behind the words as there are numbers, and whole ones all of them."""
    words = sum(name in _WORDS for name in order)
    numbers = table.width - words
    if table.delimiter != "," or numbers % 2 or numbers < 2 * (len(order) - words):
        return
    rows = [row[words:] for row in table.rows]
    if not all(_WHOLE.fullmatch(cell) for row in rows for cell in row):
        return
    behind = [cell for row in rows for cell in row[1::2]]
    if any(cell[0] in "+-" for cell in behind):
        return
    # As programs write them, with as many digits each; or 8,05, as no whole number is written.
    if len(set(map(len, behind))) > 1 and not any(len(c) > 1 and c[0] == "0" for c in behind):
        return
    raise InputError(
        Finding("table.comma-delimiter"), file=table.path, line=int(table.line_numbers[0])
    )
