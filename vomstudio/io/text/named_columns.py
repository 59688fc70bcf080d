"""Text tables with alternative column names, such as those of other programs.

Columns are identified by the header, in any order. A header may begin with `#`, as in Metashape.
Without a header, the columns have the order stated by the caller.
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
from vomstudio.geometry.coordinate_limits import check_coordinates, check_error
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.commented_rows import commented_rows_finding
from vomstudio.io.text.file_text import MAX_OBJECTS
from vomstudio.io.text.rows import parse_number, shorten
from vomstudio.io.text.tables import TextTable, read_table

LABEL_NAMES = (
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
PHOTO_NAMES = (
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
"""Names of the columns for the World coordinates x, y and z."""
_SIGMA_NAMES = (
    ("sigma x", "accuracy x", "error x", "sx", "sigma east", "sigma e"),
    ("sigma y", "accuracy y", "error y", "sy", "sigma north", "sigma n"),
    ("sigma z", "accuracy z", "error z", "sz", "sigma up", "sigma h"),
)
_COMMON_SIGMA_NAMES = ("sigma", "accuracy", "sigma m", "accuracy m")
_TEXT_COLUMNS = {"label", "photo", "from", "to"}
_INTEGER_CELL = re.compile(r"[+-]?\d+")
_CONTROL_WORDS = {"", "control", "yes", "true", "1", "gcp"}
_CHECK_WORDS = {"check", "no", "false", "0"}


class NamedTable:
    """Text table whose columns have alternative names."""

    def __init__(self, path: str | Path, order: Sequence[str]) -> None:
        """Read a table.

        Parameters
        ----------
        path : str or Path
        order : sequence of str
            Order of the columns if the table has no header.

        Raises
        ------
        InputError
            If the table is not valid or has no rows.
        """
        table = read_table(path, has_header=True, max_lines=MAX_OBJECTS)
        if table.names is None:
            table = _add_header(table, order)
        if not len(table):
            finding = (
                commented_rows_finding(table.commented_lines, "error")
                if table.commented_lines
                else Finding("table.no-rows")
            )
            raise InputError(finding, file=table.path, line=table.header_line)
        self.table, self.path = table, table.path
        self._normalised_names = [normalise_name(name) for name in table.names or ()]

    @property
    def notes(self) -> tuple[Finding, ...]:
        """Findings about comments that look like rows."""
        lines = self.table.commented_lines
        return (commented_rows_finding(lines),) if lines else ()

    def _find(self, names: Sequence[str]) -> int | None:
        for name in names:
            matches = [
                i
                for i, normalised_name in enumerate(self._normalised_names)
                if normalised_name == normalise_name(name)
            ]
            if matches:
                return matches[0]
        return None

    def has(self, names: Sequence[str]) -> bool:
        """Return whether the table has a column with one of the names."""
        return self._find(names) is not None

    def _column(self, names: Sequence[str], title: str) -> int:
        column = self._find(names)
        if column is None:
            raise self.table.header_error(
                Finding(
                    "table.missing-column",
                    column=title,
                    columns=self.table.names or (),
                    names=tuple(names),
                ),
                title,
            )
        return column

    def words(
        self, names: Sequence[str], title: str, *, allow_empty: bool = False
    ) -> tuple[str, ...]:
        """Return the text (n,) of a column. Raises InputError for an empty cell unless allowed."""
        texts = tuple(self.table.labels(self._column(names, title)))
        if not allow_empty:
            for row, word in enumerate(texts):
                if not word:
                    raise self.cell_error(row, Finding("table.value-missing"), title)
        return texts

    def columns(self, names: Sequence[Sequence[str]], title: Sequence[str]) -> FloatArray:
        """Return the numbers (n, k) of k columns.

        Raises InputError if a column is missing or a cell has no finite number.
        """
        column_numbers = [
            self._column(aliases, word) for aliases, word in zip(names, title, strict=True)
        ]
        values = np.asarray(self.table.numbers(column_numbers), np.float64)
        for row, column in np.argwhere(~np.isfinite(values)):
            raise self.cell_error(int(row), Finding("table.value-missing"), title[int(column)])
        return values

    def positive_numbers(self, names: Sequence[str], title: str) -> FloatArray:
        """Return the positive numbers (n,) in a column, NaN if missing.

        Raises InputError if a number is not positive or too large for an error.
        """
        column = self._find(names)
        if column is None:
            return np.full(len(self.table), np.nan)
        values = np.asarray(self.table.numbers([column])[:, 0], np.float64)
        for row in np.flatnonzero(values <= 0):
            raise self.cell_error(int(row), Finding("table.not-positive"), title)
        for line, value in enumerate(values.tolist()):
            if (finding := check_error(value)) is not None:
                raise self.cell_error(line, finding, title)
        return values

    def sigma(self) -> FloatArray:
        """Return the standard errors (n, 3) of x, y and z in metres, NaN if not stated."""
        if any(self.has(names) for names in _SIGMA_NAMES):
            title = ("sigma_x", "sigma_y", "sigma_z")
            return np.column_stack(
                [
                    self.positive_numbers(n, column_title)
                    for n, column_title in zip(_SIGMA_NAMES, title, strict=True)
                ]
            )
        return np.repeat(self.positive_numbers(_COMMON_SIGMA_NAMES, "sigma")[:, None], 3, axis=1)

    def is_check_point(self) -> BoolArray:
        """Return whether each row (n,) is a check point. Raises InputError for an unknown word."""
        column = self._find(("use", "role", "type"))
        if column is None:
            return np.zeros(len(self.table), bool)
        texts = [cell.casefold() for cell in self.table.cells(column)]
        for row, word in enumerate(texts):
            if word not in _CONTROL_WORDS | _CHECK_WORDS:
                raise self.cell_error(
                    row,
                    Finding("table.unknown-word", cell=shorten(word), words=("control", "check")),
                    "use",
                )
        return np.array([word in _CHECK_WORDS for word in texts], bool)

    def require_unique(self, labels: Sequence[str]) -> None:
        """Raise InputError if a label is repeated."""
        first_rows: dict[str, int] = {}
        for row, label in enumerate(labels):
            first_row = first_rows.setdefault(label, row)
            if first_row != row:
                raise self.cell_error(
                    row,
                    Finding(
                        "table.repeated-label",
                        label=shorten(label),
                        first_line=int(self.table.line_numbers[first_row]),
                    ),
                    "label",
                )

    def require_coordinates(self, positions: FloatArray) -> None:
        """Raise InputError if coordinates (n, 3) are out of range."""
        for row, position in enumerate(positions.tolist()):
            if (finding := check_coordinates((position[0], position[1], position[2]))) is not None:
                raise self.cell_error(row, finding, "x")

    def cell_error(self, row: int, cause: Finding, title: str) -> InputError:
        """Return an error with file, line and column."""
        return InputError(
            cause, file=self.path, line=int(self.table.line_numbers[row]), field=title
        )


def _add_header(table: TextTable, column_names: Sequence[str]) -> TextTable:
    """Use the last comment as header if it fits the columns, or else the given order.

    Raises InputError if neither is possible.
    """
    for comment in reversed(table.comments):
        cells = [cell.strip() for cell in comment.replace(";", ",").replace("\t", ",").split(",")]
        if len(cells) == 1:
            cells = comment.split()
        text_count = sum(parse_number(cell, decimal_comma=True) is None for cell in cells)
        is_header = any(cell.isalpha() for cell in cells) and 2 * text_count > len(cells)
        if len(cells) == table.width and is_header:
            return replace(table, names=tuple(cells))
    if not column_names or table.width < len(column_names):
        raise InputError(
            Finding(
                "table.no-header",
                columns=tuple(column_names) or ("dip_direction", "dip", "model_x", "…"),
            ),
            file=table.path,
            line=1,
        )
    _refuse_decimal_commas(table, column_names)
    extra_names = [f"column {i + 1}" for i in range(len(column_names), table.width)]
    return replace(table, names=(*column_names, *extra_names))


def _refuse_decimal_commas(table: TextTable, column_names: Sequence[str]) -> None:
    """Raise InputError if commas separate both columns and decimals.

    In this case, there are twice as many numerical cells as numerical columns, and all are
    integers.
    """
    text_count = sum(name in _TEXT_COLUMNS for name in column_names)
    number_count = table.width - text_count
    if (
        table.delimiter != ","
        or number_count % 2
        or number_count < 2 * (len(column_names) - text_count)
    ):
        return
    rows = [row[text_count:] for row in table.rows]
    if not all(_INTEGER_CELL.fullmatch(cell) for row in rows for cell in row):
        return
    decimals = [cell for row in rows for cell in row[1::2]]
    if any(cell[0] in "+-" for cell in decimals):
        return
    # Decimals of equal length, or with a leading zero as in 8,05, are not integers.
    if len(set(map(len, decimals))) > 1 and not any(
        len(decimal) > 1 and decimal[0] == "0" for decimal in decimals
    ):
        return
    raise InputError(
        Finding("table.comma-delimiter"), file=table.path, line=int(table.line_numbers[0])
    )
