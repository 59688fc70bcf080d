"""Splitting of text into rows of cells: comments, delimiters, quotes and widths.

The meaning of the columns is determined in `tables`. Errors state the file and the line.

Quoted rows are split by the module csv. Other rows stay text until they are needed: reading 300,000
rows of six numbers takes 0.7 of the time of csv.reader and 0.2 of that of pandas with an unknown
delimiter. csv.Sniffer finds a wrong delimiter or none in 10 of 64 tables of the tests; only one of
these ten is free of comments and errors.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from operator import itemgetter
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.spreadsheet_cells import unescape_formula
from vomstudio.core.findings import Finding
from vomstudio.io.text.commented_rows import commented_rows, commented_rows_finding
from vomstudio.io.text.file_text import MAX_LINES, read_text, refuse_many_lines

MAX_LINE_LENGTH = 1_000_000
_MAX_CELLS = 4_000_000
_SAMPLE_ROWS = 200
_DELIMITERS = (";", "\t", ",", " ")  # in order of preference
DELIMITER_NAMES = {";": "semicolon", "\t": "tab", ",": "comma", " ": "spaces"}
# Each digit matches in only one way; otherwise, backtracking on a long cell would take minutes.
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eEdD][+-]?\d+)?")
_COMMA_NUMBER = re.compile(r"[+-]?(\d+,\d*|,\d+)([eEdD][+-]?\d+)?")
_SPECIAL_NUMBERS = {"nan": float("nan"), "inf": float("inf"), "infinity": float("inf")}
# 120/30, N30E/45SE, N30E or 45SE: angles in field notation, which do not name a column.
_ANGLE = re.compile(
    r"[NSEW]?\s?\d{1,3}([.,]\d+)?\s?°?\s?[NSEW]{1,2}"
    r"|[NSEW]?\s?\d{1,3}([.,]\d+)?\s?°?\s?([EW]\s*/\s*|\s?[/→]\s*)\d{1,3}([.,]\d+)?\s?°?\s?[NSEW]{0,2}"
)
_MISSING_WORDS = {"", "na", "n/a", "null", "none", "-"}
# Separator between traces: dashes, or `>` in GMT.
_SEPARATOR = re.compile(r"(-{2,}|={2,}|_{2,}|>.*)")
# Cell with the apostrophe that escapes a formula.
_ESCAPED_CELL = re.compile(r"(?:^|[;,\t ])'[=+\-@']", re.MULTILINE)
# First line for Excel, which is not a row of the table.
_EXCEL_DELIMITER = re.compile(r'\s*"?sep=(.|\\t)"?\s*', re.IGNORECASE)


@dataclass(frozen=True)
class TextRows:
    """Content of a text table before its columns are interpreted."""

    header: list[str] | None
    header_line: int | None
    width: int
    delimiter: str
    lines: list[str]
    """Data rows as text; use `rows` if it is not None."""
    rows: list[list[str]] | None
    """Cells (`width` per row) if lines cannot be split at the delimiter, otherwise None."""
    line_numbers: list[int]
    """Number (from 1) of the first line of each data row in the file."""
    comments: list[str]
    separators: list[int]
    notes: list[Finding]
    commented_lines: list[int] = field(default_factory=list)  # lines that look like rows


def parse_number(cell: str, *, decimal_comma: bool) -> float | None:
    """Return the number in a cell, NaN if it is empty or missing, or None for a word."""
    text = cell.strip()
    if _NUMBER.fullmatch(text):
        return float(text.replace("d", "e").replace("D", "e"))
    if decimal_comma and is_comma_number(text):
        return float(text.replace(",", ".").replace("d", "e").replace("D", "e"))
    lowercase_text = text.casefold()
    if lowercase_text in _MISSING_WORDS:
        return float("nan")
    value = _SPECIAL_NUMBERS.get(lowercase_text.lstrip("+-"))
    return -value if value is not None and lowercase_text.startswith("-") else value


def is_comma_number(cell: str) -> bool:
    """Return whether a cell is a number with a decimal comma."""
    return _COMMA_NUMBER.fullmatch(cell) is not None


def shorten(text: str, limit: int = 40) -> str:
    """Shorten a cell for a message."""
    printable_text = "".join(character if character.isprintable() else "?" for character in text)
    return printable_text if len(printable_text) <= limit else printable_text[: limit - 3] + "..."


def split_cells(line: str, delimiter: str) -> list[str]:
    """Split a line without quotes into stripped cells."""
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in line.split(delimiter)]


def read_rows(path: Path, *, has_header: bool = False, max_lines: int = MAX_LINES) -> TextRows:
    """Read a text file into rows of cells.

    Parameters
    ----------
    path : Path
    has_header : bool
        Whether rows contain words, such as labels of points. If True, a first row that mostly
        contains numbers is not a header.
    max_lines : int
        Maximum number of lines, which is lower if every cell becomes an object.

    Raises
    ------
    InputError
        If the file is missing, empty, not text, or not a table; states file and line.
    """
    text, notes = read_text(path, max_lines)
    # Without an apostrophe, the slow search is not needed.
    needs_cells = '"' in text or ("'" in text and _ESCAPED_CELL.search(text) is not None)
    if needs_cells:
        # Every cell becomes an object.
        width = 1 + max(text[: text.find("\n", 1)].count(character) for character in _DELIMITERS)
        refuse_many_lines(path, text.count("\n"), min(max_lines, _MAX_CELLS // width))
    lines = text.split("\n")
    delimiter_match = _EXCEL_DELIMITER.fullmatch(lines[0])
    if delimiter_match is not None:
        lines[0] = ""
    max_length = max(map(len, lines))
    if max_length > MAX_LINE_LENGTH:
        raise InputError(
            Finding("table.long-line", count=max_length),
            file=path,
            line=next(i for i, line in enumerate(lines, 1) if len(line) == max_length),
        )
    data, line_numbers, comments, separators = _separate_comments(lines)
    if not data:
        finding = Finding("table.no-rows")
        if comments and (
            commented_lines := _find_commented_rows(
                lines, [], 3, detect_delimiter(comments[:_SAMPLE_ROWS])
            )
        ):
            finding = commented_rows_finding(commented_lines, "error")
        raise InputError(finding, file=path)
    delimiter = detect_delimiter(data[:_SAMPLE_ROWS])
    if delimiter_match is not None:
        excel_delimiter = delimiter_match[1].replace("\\t", "\t")
        delimiter = (
            excel_delimiter
            if excel_delimiter in _DELIMITERS and excel_delimiter in data[0]
            else delimiter
        )
    refuse_decimal_commas(path, data, line_numbers, delimiter)
    rows: list[list[str]] | None = None
    if '"' in text:
        rows, line_numbers, comments, separators = _quoted_rows(path, lines, delimiter)
        first_row = rows[0]
    elif needs_cells:
        rows = [[unescape_formula(cell) for cell in split_cells(line, delimiter)] for line in data]
        first_row = rows[0]
    else:
        first_row = split_cells(data[0], delimiter)
    header = _trim_cells(first_row) if is_header(first_row, delimiter) else None
    if has_header and header is not None and _is_mostly_numbers(header, delimiter):
        header = None
    header_line = None
    if header is not None:
        header_line = line_numbers[0]
        data, line_numbers = data[1:], line_numbers[1:]
        rows = None if rows is None else rows[1:]
        if delimiter == " ":
            header = rejoin_header(header, data, rows)
        width = len(header)
    else:
        width = _most_common_width(data if rows is None else rows, delimiter)
    rows = _check_widths(path, data, rows, line_numbers, width, delimiter)
    sample = (data if rows is None else rows)[:_SAMPLE_ROWS] if comments else []
    return TextRows(
        header,
        header_line,
        width,
        delimiter,
        data,
        rows,
        line_numbers,
        comments,
        separators,
        notes,
        _find_commented_rows(lines, sample, width, delimiter) if comments else [],
    )


def _find_commented_rows(
    lines: list[str], sample: Sequence[str | list[str]], width: int, delimiter: str
) -> list[int]:
    return commented_rows(lines, sample, width, delimiter, split_cells, parse_number)


_NON_ROW_STARTS = frozenset(
    {"", *"#-=_>,;\x1a", *(c for c in map(chr, range(0x3001)) if c.isspace())}
)
"""First characters of blank lines, comments and separators, and of some data rows."""


def is_blank(stripped_text: str) -> bool:
    """Return whether a stripped line is empty, an end-of-file mark, or only delimiters."""
    return not stripped_text.strip(",;\x1a")


def _separate_comments(lines: list[str]) -> tuple[list[str], list[int], list[str], list[int]]:
    data: list[str] = []
    line_numbers: list[int] = []
    comments: list[str] = []
    separators: list[int] = []
    # Almost all lines of a large table are data rows, which are copied in blocks.
    first_characters = map(itemgetter(slice(1)), lines)
    other_rows = list(
        itertools.compress(itertools.count(), map(_NON_ROW_STARTS.__contains__, first_characters))
    )
    for previous, i in itertools.pairwise((-1, *other_rows, len(lines))):
        data += lines[previous + 1 : i]
        line_numbers += range(previous + 2, i + 1)
        if i == len(lines):
            break
        line, line_number = lines[i], i + 1
        stripped_line = line.strip()
        if is_blank(stripped_line):
            continue
        if stripped_line[0] == "#":
            comments.append(stripped_line[1:].strip())
        elif stripped_line[0] in "-=_>" and _SEPARATOR.fullmatch(stripped_line):
            separators.append(line_number)
        else:
            data.append(line)
            line_numbers.append(line_number)
    return data, line_numbers, comments, separators


class _RecordLines:
    """Iterator over lines for a csv reader that skips comments and separators.

    They are only removed between records because a quoted cell may contain several lines.
    """

    def __init__(self, lines: list[str], is_space_delimited: bool) -> None:
        self._lines = enumerate(lines, 1)
        self._is_space_delimited = is_space_delimited
        self.is_record_start = True
        self.first_line = 0
        self.comments: list[str] = []
        self.separators: list[int] = []

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        for line_number, line in self._lines:
            stripped_line = line.strip()
            if self.is_record_start:
                if is_blank(stripped_line):
                    continue
                if stripped_line[0] == "#":
                    self.comments.append(stripped_line[1:].strip())
                    continue
                if _SEPARATOR.fullmatch(stripped_line):
                    self.separators.append(line_number)
                    continue
                self.first_line = line_number
                self.is_record_start = False
            return (stripped_line.replace("\t", " ") if self._is_space_delimited else line) + "\n"
        raise StopIteration


def _quoted_rows(
    path: Path, lines: list[str], delimiter: str
) -> tuple[list[list[str]], list[int], list[str], list[int]]:
    source = _RecordLines(lines, delimiter == " ")
    reader = csv.reader(source, delimiter=delimiter, skipinitialspace=True, strict=True)
    rows: list[list[str]] = []
    line_numbers: list[int] = []
    while True:
        source.is_record_start = True
        try:
            rows.append([unescape_formula(cell.strip()) for cell in next(reader)])
        except StopIteration:
            return rows, line_numbers, source.comments, source.separators
        except csv.Error as error:
            raise InputError(
                Finding("table.open-quotes", reason=error), file=path, line=source.first_line
            ) from error
        line_numbers.append(source.first_line)


def detect_delimiter(sample: list[str]) -> str:
    """Detect the delimiter of a table.

    It is the delimiter that gives rows of the most uniform length, then the most numbers, and then
    the first one in `_DELIMITERS`: a semicolon or tab in addition to commas means decimal commas.
    """
    is_quoted = any('"' in line for line in sample)
    best_delimiter, best_score = " ", (-1.0, -1.0)
    for delimiter in _DELIMITERS:
        try:
            rows = _split_sample(sample, delimiter, is_quoted)
        except csv.Error:  # an unterminated cell; reading the table reports its line
            continue
        width, count = Counter(len(row) for row in rows).most_common(1)[0]
        if width < 2:
            continue
        cells = [cell for row in rows for cell in row if cell]
        decimal_comma = delimiter in ";\t"
        numeric_count = sum(
            parse_number(cell, decimal_comma=decimal_comma) is not None for cell in cells
        )
        score = (round(count / len(rows), 1), numeric_count / max(len(cells), 1))
        if score > best_score:
            best_delimiter, best_score = delimiter, score
    return best_delimiter


def _split_sample(sample: list[str], delimiter: str, is_quoted: bool) -> list[list[str]]:
    if not is_quoted:
        return [split_cells(line, delimiter) for line in sample]
    text = [line.replace("\t", " ") if delimiter == " " else line for line in sample]
    return list(csv.reader(text, delimiter=delimiter, skipinitialspace=True))


def refuse_decimal_commas(
    path: Path, data: list[str], line_numbers: list[int], delimiter: str
) -> None:
    """Raise InputError if rows look like `1,5 2,5 3,5`."""
    if delimiter not in ", ":
        return
    for line, line_number in zip(data[:2], line_numbers[:2], strict=True):
        cells = line.split()
        commas = [cell for cell in cells if is_comma_number(cell) and cell[-1] != ","]
        other_cells = [cell for cell in cells if cell not in commas]
        are_numbers = all(
            parse_number(other_cell, decimal_comma=False) is not None for other_cell in other_cells
        )
        if len(cells) > 1 and commas and are_numbers:
            raise InputError(Finding("table.comma-delimiter"), file=path, line=line_number)


def is_header(cells: list[str], delimiter: str) -> bool:
    """Return whether a row is a header, which contains a word or only missing values."""
    decimal_comma = delimiter in ";\t"
    if any(
        parse_number(cell, decimal_comma=decimal_comma) is None and not _ANGLE.fullmatch(cell)
        for cell in cells
    ):
        return True
    return all(cell.casefold() in _MISSING_WORDS for cell in cells)


def _is_mostly_numbers(cells: list[str], delimiter: str) -> bool:
    decimal_comma = delimiter in ";\t"
    number_count = sum(
        parse_number(cell, decimal_comma=decimal_comma) is not None for cell in cells if cell
    )
    return 2 * number_count > sum(map(bool, cells))


def _trim_cells(cells: list[str]) -> list[str]:
    end = len(cells)
    while end and not cells[end - 1]:
        end -= 1
    return cells[:end]


def rejoin_header(header: list[str], data: list[str], rows: list[list[str]] | None) -> list[str]:
    """Join the words of names such as `Dip direction` in a header delimited by spaces."""
    sample = rows[0] if rows else (data[0].split() if data else header)
    surplus_count = len(header) - len(sample)
    second_words = {"direction", "dir", "azimuth", "quadrant"}
    joined_cells: list[str] = []
    for word in header:
        is_continuation = joined_cells and (
            word[0] in "(["
            or (joined_cells[-1].casefold() == "dip" and word.casefold() in second_words)
        )
        if surplus_count > 0 and is_continuation:
            joined_cells[-1] += f" {word}"
            surplus_count -= 1
        else:
            joined_cells.append(word)
    return joined_cells


def _most_common_width(rows: Sequence[str | list[str]], delimiter: str) -> int:
    sample: Iterable[list[str]] = (
        split_cells(row, delimiter) if isinstance(row, str) else row for row in rows[:_SAMPLE_ROWS]
    )
    return Counter(len(_trim_cells(cells)) for cells in sample).most_common(1)[0][0]


def _check_widths(
    path: Path,
    data: list[str],
    rows: list[list[str]] | None,
    line_numbers: list[int],
    width: int,
    delimiter: str,
) -> list[list[str]] | None:
    """Return rows split into `width` cells, or None if all lines have that width.

    Raises InputError for a ragged row.
    """
    if rows is None:
        if delimiter == " ":
            is_uniform = all(len(line.split()) == width for line in data)
        else:
            is_uniform = set(map(str.count, data, repeat(delimiter))) <= {width - 1}
        if is_uniform:
            return None
        rows = [split_cells(line, delimiter) for line in data]
    for cells, line_number in zip(rows, line_numbers, strict=True):
        if len(cells) == width:
            continue
        if len(cells) < width or any(cells[width:]):
            count = len(_trim_cells(cells)) if len(cells) > width else len(cells)
            raise InputError(
                Finding(
                    "table.ragged-row",
                    count=count,
                    delimiter=DELIMITER_NAMES[delimiter],
                    expected=width,
                ),
                file=path,
                line=line_number,
            )
        del cells[width:]
    return rows
