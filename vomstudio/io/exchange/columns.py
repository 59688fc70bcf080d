"""Delimited text in the columns of another program."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.files.plain_characters import replace_control_characters
from vomstudio.core.files.spreadsheet_cells import escape_foreign_cell

Row = Mapping[str, Any]


def write_tables(tables: Mapping[Path, str], *, force: bool) -> list[Path]:
    """Write texts as UTF-8 files, all or none. Raises TargetError."""
    paths = list(tables)
    with atomic_group(paths, force) as temporaries:
        for temporary, text in zip(temporaries, tables.values(), strict=True):
            temporary.write_bytes(text.encode("utf-8", "replace"))
    return paths


def delimited_text(names: Sequence[str], rows: Iterable[Sequence[Any]], delimiter: str) -> str:
    """Return a header line and one line per row; cells that contain the delimiter are quoted."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([_cell(value) for value in row] for row in rows)
    return out.getvalue()


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    if isinstance(value, float):
        # Far finer than any measurement; more digits would show rounding errors.
        return f"{value:.12g}"
    text = " ".join(replace_control_characters(str(value)).split())
    return escape_foreign_cell(text) if isinstance(value, str) else text


def degrees(value: float | None) -> float | None:
    """Return an angle without digits from rounding errors."""
    return None if value is None else round(float(value), 6) + 0.0


def label(row: Row) -> str:
    """Return the label of a feature."""
    return str(row["name"] or row["id"] or "")


def sibling_path(out: Path, name: str) -> Path:
    """Return NAME_name.suffix."""
    return out.with_name(f"{out.stem}_{name}{out.suffix}")
