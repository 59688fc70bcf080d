"""Lines on a surface as a table with one row per vertex."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import comment_line, escape_formula
from vomstudio.core.version import __version__

COLUMNS = ("line", "x", "y", "z")


def write_line_table(
    path: str | Path,
    lines: Sequence[tuple[str, FloatArray]],
    *,
    crs: str | None,
    is_north_known: bool = True,
    source: str = "",
    force: bool = False,
) -> None:
    """Write lines as CSV with the columns `line, x, y, z` in the World frame, metres.

    Parameters
    ----------
    path : str or Path
    lines : sequence of tuple of str and (n, 3) float64
        Names and points of the lines.
    crs : str or None
        CRS of the points.
    is_north_known : bool, optional
        Whether azimuths refer to grid north.
    source : str, optional
        Inputs of the lines, written to the header.
    force : bool, optional
        Whether to replace existing files.

    Raises
    ------
    TargetError
        If the file cannot be written.
    """
    file = io.StringIO()
    file.write(comment_line(f"VOM Studio {__version__}, lines of {source}"))
    axes = "x East, y North, z Up" if is_north_known else "x, y, z of a frame without north"
    file.write(comment_line(f"CRS: {crs or 'local'}; {axes}, metres"))
    out = csv.writer(file, lineterminator="\n")
    out.writerow(COLUMNS)
    for name, points in lines:
        out.writerows(
            [escape_formula(name), f"{x:.6f}", f"{y:.6f}", f"{z:.6f}"]
            for x, y, z in points.tolist()
        )
    write_bytes(path, file.getvalue().encode("utf-8"), force=force)
