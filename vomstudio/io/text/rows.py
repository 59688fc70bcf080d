"""From text to rows of cells: comments, delimiter, quotes, widths.

The meaning of the columns is `tables`'s business; here a text becomes lines, and the lines cells,
and whatever cannot is refused with the file's name and the line.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.spreadsheet_cells import unescape_formula
from vomstudio.core.findings import Finding
from vomstudio.io.text.commented_rows import commented_finding, commented_rows
from vomstudio.io.text.file_text import MOST_LINES, read_text, refuse_too_many

LONGEST_LINE = 1_000_000
_MOST_CELLS = 4_000_000
_SAMPLE = 200
_DELIMITERS = (";", "\t", ",", " ")  # in order of preference where two fit equally well
DELIMITER_NAMES = {";": "semicolon", "\t": "tab", ",": "comma", " ": "spaces"}
# Each digit can be matched in one way only: else a long one that is no number takes minutes.
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eEdD][+-]?\d+)?")
_COMMA_NUMBER = re.compile(r"[+-]?(\d+,\d*|,\d+)([eEdD][+-]?\d+)?")
_NOT_FINITE = {"nan": float("nan"), "inf": float("inf"), "infinity": float("inf")}
_MISSING = {"", "na", "n/a", "null", "none", "-"}
# A line that parts one trace from the next: rules of dashes, or GMT's `>`.
_SEPARATOR = re.compile(r"(-{2,}|={2,}|_{2,}|>.*)")
# A cell with the apostrophe that keeps spreadsheets from calculating it.
_MARKED = re.compile(r"(?:^|[;,\t ])'[=+\-@']", re.MULTILINE)
# Excel's own first line, which is no row of the table.
_STATED_DELIMITER = re.compile(r'\s*"?sep=(.|\\t)"?\s*', re.IGNORECASE)


@dataclass(frozen=True)
class TextRows:
    """What a text file holds, before anything is known of its columns."""

    header: list[str] | None
    header_line: int | None
    width: int
    delimiter: str
    lines: list[str]
    """The data rows as text; not to be cut by hand where `rows` is there."""
    rows: list[list[str]] | None
    """The cells, where cutting at the delimiter is not enough; each row has `width` of them."""
    numbers: list[int]
    """The line in the file at which each data row begins, counted from 1."""
    comments: list[str]
    separators: list[int]
    notes: list[Finding]
    commented: list[int] = field(default_factory=list)  # lines that look like rows


def parse_number(cell: str, *, decimal_comma: bool) -> float | None:
    """The number in a cell, NaN where it is empty or says so, None where it is a word."""
    text = cell.strip()
    if _NUMBER.fullmatch(text):
        return float(text.replace("d", "e").replace("D", "e"))
    if decimal_comma and is_comma_number(text):
        return float(text.replace(",", ".").replace("d", "e").replace("D", "e"))
    low = text.casefold()
    if low in _MISSING:
        return float("nan")
    value = _NOT_FINITE.get(low.lstrip("+-"))
    return -value if value is not None and low.startswith("-") else value


def is_comma_number(cell: str) -> bool:
    """Whether the cell is a number with a decimal comma."""
    return _COMMA_NUMBER.fullmatch(cell) is not None


def shortened(text: str, limit: int = 40) -> str:
    """A cell as an error may quote it."""
    clean = "".join(c if c.isprintable() else "?" for c in text)
    return clean if len(clean) <= limit else clean[: limit - 3] + "..."


def cut(line: str, delimiter: str) -> list[str]:
    """The stripped cells of a line without quotes."""
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in line.split(delimiter)]


def read_rows(path: Path, *, named: bool = False, most: int = MOST_LINES) -> TextRows:
    """Read a text file into rows of cells.

    named : rows have words among their numbers, such as the labels of points: a first row in which
        most cells are numbers is then no header
    most : lines that are read; fewer where every cell becomes an object

    Raises `InputError` (file, line) for what is missing, empty, not text, or not a table.
    """
    text, notes = read_text(path, most)
    cells_apart = '"' in text or _MARKED.search(text) is not None
    if cells_apart:
        # Every cell becomes an object.
        width = 1 + max(text[: text.find("\n", 1)].count(sign) for sign in _DELIMITERS)
        refuse_too_many(path, text.count("\n"), min(most, _MOST_CELLS // width))
    lines = text.split("\n")
    stated = _STATED_DELIMITER.fullmatch(lines[0])
    if stated is not None:
        lines[0] = ""
    longest = max(map(len, lines))
    if longest > LONGEST_LINE:
        raise InputError(
            Finding("table.long-line", count=longest),
            file=path,
            line=next(i for i, line in enumerate(lines, 1) if len(line) == longest),
        )
    data, numbers, comments, separators = _without_comments(lines)
    if not data:
        finding = Finding("table.no-rows")
        if comments and (like := _commented(lines, [], 3, sniff(comments[:_SAMPLE]))):
            finding = commented_finding(like, "error")
        raise InputError(finding, file=path)
    delimiter = sniff(data[:_SAMPLE])
    if stated is not None:
        named_by = stated[1].replace("\\t", "\t")
        delimiter = named_by if named_by in _DELIMITERS and named_by in data[0] else delimiter
    refuse_decimal_commas_between_spaces(path, data, numbers, delimiter)
    rows: list[list[str]] | None = None
    if '"' in text:
        rows, numbers, comments, separators = _quoted_rows(path, lines, delimiter)
        first = rows[0]
    elif cells_apart:
        rows = [[unescape_formula(cell) for cell in cut(line, delimiter)] for line in data]
        first = rows[0]
    else:
        first = cut(data[0], delimiter)
    header = _trimmed(first) if is_header(first, delimiter) else None
    if named and header is not None and _mostly_numbers(header, delimiter):
        header = None
    header_line = None
    if header is not None:
        header_line = numbers[0]
        data, numbers = data[1:], numbers[1:]
        rows = None if rows is None else rows[1:]
        if delimiter == " ":
            header = rejoined_header(header, data, rows)
        width = len(header)
    else:
        width = _usual_width(data if rows is None else rows, delimiter)
    rows = _checked_widths(path, data, rows, numbers, width, delimiter)
    sample = (data if rows is None else rows)[:_SAMPLE] if comments else []
    return TextRows(
        header,
        header_line,
        width,
        delimiter,
        data,
        rows,
        numbers,
        comments,
        separators,
        notes,
        _commented(lines, sample, width, delimiter) if comments else [],
    )


def _commented(
    lines: list[str], sample: Sequence[str | list[str]], width: int, delimiter: str
) -> list[int]:
    return commented_rows(lines, sample, width, delimiter, cut, parse_number)


_NO_ROW = frozenset({"", *"#-=_>,;\x1a", *(c for c in map(chr, range(0x3001)) if c.isspace())})
"""How a line may begin that is blank, a comment or a rule; a row may begin so too."""


def is_blank(bare: str) -> bool:
    """Nothing, the end-of-file mark of old systems, or the bare delimiters of an empty row."""
    return not bare.strip(",;\x1a")


def _without_comments(lines: list[str]) -> tuple[list[str], list[int], list[str], list[int]]:
    data: list[str] = []
    numbers: list[int] = []
    comments: list[str] = []
    separators: list[int] = []
    for number, line in enumerate(lines, 1):
        # Of a table of a million rows hardly one begins like something that is no row.
        if line[:1] not in _NO_ROW:
            data.append(line)
            numbers.append(number)
            continue
        bare = line.strip()
        if is_blank(bare):
            continue
        if bare[0] == "#":
            comments.append(bare[1:].strip())
        elif bare[0] in "-=_>" and _SEPARATOR.fullmatch(bare):
            separators.append(number)
        else:
            data.append(line)
            numbers.append(number)
    return data, numbers, comments, separators


class _RecordLines:
    """Feeds lines to a csv reader: comments and rules are left out, but only between records,
    since a quoted cell may run over several lines."""

    def __init__(self, lines: list[str], spaces: bool) -> None:
        self._lines = enumerate(lines, 1)
        self._spaces = spaces
        self.fresh = True
        self.begin = 0
        self.comments: list[str] = []
        self.separators: list[int] = []

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        for number, line in self._lines:
            bare = line.strip()
            if self.fresh:
                if is_blank(bare):
                    continue
                if bare[0] == "#":
                    self.comments.append(bare[1:].strip())
                    continue
                if _SEPARATOR.fullmatch(bare):
                    self.separators.append(number)
                    continue
                self.begin = number
                self.fresh = False
            return (bare.replace("\t", " ") if self._spaces else line) + "\n"
        raise StopIteration


def _quoted_rows(
    path: Path, lines: list[str], delimiter: str
) -> tuple[list[list[str]], list[int], list[str], list[int]]:
    source = _RecordLines(lines, delimiter == " ")
    reader = csv.reader(source, delimiter=delimiter, skipinitialspace=True, strict=True)
    rows: list[list[str]] = []
    numbers: list[int] = []
    while True:
        source.fresh = True
        try:
            rows.append([unescape_formula(cell.strip()) for cell in next(reader)])
        except StopIteration:
            return rows, numbers, source.comments, source.separators
        except csv.Error as error:
            raise InputError(
                Finding("table.open-quotes", reason=error), file=path, line=source.begin
            ) from error
        numbers.append(source.begin)


def sniff(sample: list[str]) -> str:
    """The delimiter under which the rows agree best: first in their length, then in being numbers,
    then by preference (a semicolon or tab beside commas means decimal commas)."""
    quoted = any('"' in line for line in sample)
    best, best_score = " ", (-1.0, -1.0)
    for delimiter in _DELIMITERS:
        try:
            rows = _cut_sample(sample, delimiter, quoted)
        except csv.Error:  # a cell without end; reading it in earnest will name its line
            continue
        width, count = Counter(len(row) for row in rows).most_common(1)[0]
        if width < 2:
            continue
        cells = [cell for row in rows for cell in row if cell]
        comma = delimiter in ";\t"
        numeric = sum(parse_number(c, decimal_comma=comma) is not None for c in cells)
        score = (round(count / len(rows), 1), numeric / max(len(cells), 1))
        if score > best_score:
            best, best_score = delimiter, score
    return best


def _cut_sample(sample: list[str], delimiter: str, quoted: bool) -> list[list[str]]:
    if not quoted:
        return [cut(line, delimiter) for line in sample]
    text = [line.replace("\t", " ") if delimiter == " " else line for line in sample]
    return list(csv.reader(text, delimiter=delimiter, skipinitialspace=True))


def refuse_decimal_commas_between_spaces(
    path: Path, data: list[str], numbers: list[int], delimiter: str
) -> None:
    """`1,5 2,5 3,5` looks like comma-separated words; say what it is instead."""
    if delimiter not in ", ":
        return
    for line, number in zip(data[:2], numbers[:2], strict=True):
        cells = line.split()
        commas = [c for c in cells if is_comma_number(c) and c[-1] != ","]
        others = [c for c in cells if c not in commas]
        plain = all(parse_number(c, decimal_comma=False) is not None for c in others)
        if len(cells) > 1 and commas and plain:
            raise InputError(Finding("table.comma-delimiter"), file=path, line=number)


def is_header(cells: list[str], delimiter: str) -> bool:
    comma = delimiter in ";\t"
    if any(parse_number(cell, decimal_comma=comma) is None for cell in cells):
        return True
    return all(cell.casefold() in _MISSING for cell in cells)


def _mostly_numbers(cells: list[str], delimiter: str) -> bool:
    comma = delimiter in ";\t"
    numbers = sum(parse_number(cell, decimal_comma=comma) is not None for cell in cells if cell)
    return 2 * numbers > sum(map(bool, cells))


def _trimmed(cells: list[str]) -> list[str]:
    end = len(cells)
    while end and not cells[end - 1]:
        end -= 1
    return cells[:end]


def rejoined_header(header: list[str], data: list[str], rows: list[list[str]] | None) -> list[str]:
    """`Dip direction  Strike (RHR)` above two columns is two names, though spaces part them."""
    sample = rows[0] if rows else (data[0].split() if data else header)
    surplus = len(header) - len(sample)
    second = {"direction", "dir", "azimuth", "quadrant"}
    joined: list[str] = []
    for word in header:
        goes_on = joined and (
            word[0] in "([" or (joined[-1].casefold() == "dip" and word.casefold() in second)
        )
        if surplus > 0 and goes_on:
            joined[-1] += f" {word}"
            surplus -= 1
        else:
            joined.append(word)
    return joined


def _usual_width(rows: Sequence[str | list[str]], delimiter: str) -> int:
    sample: Iterable[list[str]] = (
        cut(row, delimiter) if isinstance(row, str) else row for row in rows[:_SAMPLE]
    )
    return Counter(len(_trimmed(cells)) for cells in sample).most_common(1)[0][0]


def _checked_widths(
    path: Path,
    data: list[str],
    rows: list[list[str]] | None,
    numbers: list[int],
    width: int,
    delimiter: str,
) -> list[list[str]] | None:
    """Rows cut to `width`, or None where all plain lines have it. Raises at a ragged row."""
    if rows is None:
        if delimiter == " ":
            uniform = all(len(line.split()) == width for line in data)
        else:
            uniform = set(map(str.count, data, repeat(delimiter))) <= {width - 1}
        if uniform:
            return None
        rows = [cut(line, delimiter) for line in data]
    for cells, number in zip(rows, numbers, strict=True):
        if len(cells) == width:
            continue
        if len(cells) < width or any(cells[width:]):
            found = len(_trimmed(cells)) if len(cells) > width else len(cells)
            raise InputError(
                Finding(
                    "table.ragged-row",
                    count=found,
                    delimiter=DELIMITER_NAMES[delimiter],
                    expected=width,
                ),
                file=path,
                line=number,
            )
        del cells[width:]
    return rows
