"""Writing of tables of control points, marks, point pairs and compass readings."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.backup import back_up
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.files.spreadsheet_cells import escape_formula
from vomstudio.core.findings import Finding
from vomstudio.io.control.observation_tables import CompassTable, Pairs
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.gate.stated_crs import WORLD_COMMENT

_CRS = re.compile(r"# (?:EPSG:\d+|[A-Z]+CRS\[.*\])")


def write_control(
    path: Path, points: Iterable[ControlPoint], crs: str | None = None
) -> Path | None:
    """Write the table of points completely or not at all; delete it if `points` is empty.

    Parameters
    ----------
    path : Path
    points : iterable of ControlPoint
    crs : str or None
        CRS of the points as "EPSG:n" or WKT on one line; it is written as a comment of the table.

    Returns
    -------
    Path or None
        Path of the backup of an existing table with other columns or comments, or None.

    Raises
    ------
    TargetError
        If the file cannot be written.
    """
    rows = [
        [
            escape_formula(point.label),
            *map(_format_number, point.position),
            "" if point.sigma_m is None else _format_number(point.sigma_m),
            "check" if point.check else "control",
        ]
        for point in points
    ]
    comment = f"# {crs}\n" if crs is not None and _CRS.fullmatch(f"# {crs}") else ""
    return _write(path, ["label", "x", "y", "z", "sigma", "use"], rows, comment)


def write_pairs(path: Path, pairs: Pairs) -> Path | None:
    """Write points on a model as the table for `register --pairs`.

    The return value and the errors are those of `write_control`.
    """
    has_sigma = bool(np.isfinite(pairs.sigma).any())
    header = ["label", "model_x", "model_y", "model_z", "x", "y", "z", "use"]
    header += ["sigma_x", "sigma_y", "sigma_z"] if has_sigma else []
    rows = []
    for k, label in enumerate(pairs.labels):
        positions = [*pairs.model[k].tolist(), *pairs.world[k].tolist()]
        row = [
            escape_formula(label),
            *map(_format_number, positions),
            "check" if pairs.check[k] else "control",
        ]
        if has_sigma:
            row += ["" if np.isnan(v) else _format_number(v) for v in pairs.sigma[k].tolist()]
        rows.append(row)
    comment = WORLD_COMMENT if pairs.crs is None else f"# CRS: {pairs.crs}\n"
    return _write(path, header, rows, comment)


def write_compass(path: Path, table: CompassTable) -> Path | None:
    """Write compass readings as the table for `register --orientations`.

    The return value and the errors are those of `write_control`.
    """
    header = ["id", "element", "dip_direction_deg", "dip_deg", "trend_deg", "plunge_deg"]
    header += ["model_x", "model_y", "model_z", "sigma_deg"]
    rows = []
    for k, label in enumerate(table.labels):
        angles = [_format_number(table.azimuth_deg[k]), _format_number(table.inclination_deg[k])]
        is_plane = bool(table.is_plane[k])
        sigma = float(table.sigma[k])
        rows.append(
            [
                escape_formula(label),
                "plane" if is_plane else "line",
                *(angles if is_plane else ["", ""]),
                *(["", ""] if is_plane else angles),
                *map(_format_number, table.model[k].tolist()),
                "" if np.isnan(sigma) else _format_number(sigma),
            ]
        )
    return _write(path, header, rows)


def write_marks(path: Path, marks: Iterable[Mark]) -> Path | None:
    """Write the table of marks completely or not at all, or delete it if `marks` is empty.

    The return value and the errors are those of `write_control`.
    """
    rows = [
        [
            escape_formula(mark.label),
            escape_formula(mark.photo),
            _format_number(mark.x),
            _format_number(mark.y),
        ]
        for mark in marks
    ]
    return _write(path, ["label", "photo", "x", "y"], rows)


def _write(
    path: Path, header: Sequence[str], rows: Sequence[Sequence[str]], comment: str = ""
) -> Path | None:
    check_generated_path(path)
    backup = back_up(path) if path.exists() and not _has_only_columns(path, header) else None
    if not rows:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise TargetError(
                Finding("file.not-removed", reason=error.strerror), file=path
            ) from error
        return backup
    text = io.StringIO()
    # Without quotes, a line that begins with # or > would not be read as part of the table.
    needs_quotes = any(not row[0][:1].isalnum() for row in rows)
    writer = csv.writer(
        text, lineterminator="\n", quoting=csv.QUOTE_ALL if needs_quotes else csv.QUOTE_MINIMAL
    )
    writer.writerow(header)
    writer.writerows(rows)
    write_bytes(path, (comment + text.getvalue()).encode(), force=True)
    return backup


def _has_only_columns(path: Path, header: Sequence[str]) -> bool:
    """Return whether a table has only these columns and no comments that would be lost."""
    try:
        with io.TextIOWrapper(open_regular_file(path), encoding="utf-8") as stream:
            first_line = stream.readline().rstrip("\n").replace('"', "")
            if _CRS.fullmatch(first_line):
                first_line = stream.readline().rstrip("\n").replace('"', "")
            return first_line == ",".join(header) and not any(row.startswith("#") for row in stream)
    except (InputError, OSError, UnicodeDecodeError):
        return False


def _format_number(value: float) -> str:
    """Return the shortest text that identifies the number."""
    return repr(float(value)).removesuffix(".0")
