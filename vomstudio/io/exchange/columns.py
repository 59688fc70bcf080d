"""Delimited text with the columns that another program expects."""

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
    """Write texts as UTF-8 files, either all or none, and return their paths.

    Raises TargetError.
    """
    paths = list(tables)
    with atomic_group(paths, force) as temporaries:
        for temporary, text in zip(temporaries, tables.values(), strict=True):
            temporary.write_bytes(text.encode("utf-8", "replace"))
    return paths


def delimited_text(names: Sequence[str], rows: Iterable[Sequence[Any]], delimiter: str) -> str:
    """Return a header line and one line per row, quoting cells that contain the delimiter."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=delimiter, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([_cell(value) for value in row] for row in rows)
    return out.getvalue()


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    if isinstance(value, float):
        # This is much finer than any measurement; more digits would show rounding errors.
        return f"{value:.12g}"
    text = " ".join(replace_control_characters(str(value)).split())
    return escape_foreign_cell(text) if isinstance(value, str) else text


def round_angle(value: float | None) -> float | None:
    """Return an angle rounded to remove digits that result from rounding errors.

    Parameters
    ----------
    value : float or None

    Returns
    -------
    float or None
    """
    return None if value is None else round(float(value), 6) + 0.0


def label(row: Row) -> str:
    """Return the name of a feature, or its ID if it has no name."""
    return str(row["name"] or row["id"] or "")


def sibling_path(out: Path, name: str) -> Path:
    """Return the path NAME_name.suffix next to a file NAME.suffix."""
    return out.with_name(f"{out.stem}_{name}{out.suffix}")
