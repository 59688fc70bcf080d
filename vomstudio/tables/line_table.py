"""Lines on a surface as a table: a row for each vertex."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.files.atomic import write_bytes
from vomstudio.version import __version__

Array = npt.NDArray[np.float64]

COLUMNS = ("line", "x", "y", "z")
_FORMULA = tuple("=+-@\t\r'")


def write_line_table(
    path: str | Path,
    lines: Sequence[tuple[str, Array]],
    *,
    crs: str | None,
    north_known: bool = True,
    source: str = "",
    force: bool = False,
) -> None:
    """CSV with `line, x, y, z` in World, metres. lines : names and (n, 3) points. Raises
    TargetError."""
    file = io.StringIO()
    file.write(f"# VOM Studio {__version__}, lines of {' '.join(source.split())}\n")
    axes = "x East, y North, z Up" if north_known else "x, y, z of a frame without north"
    file.write(f"# CRS: {crs or 'local'}; {axes}, metres\n")
    out = csv.writer(file, lineterminator="\n")
    out.writerow(COLUMNS)
    for name, points in lines:
        cell = f"'{name}" if name.startswith(_FORMULA) else name
        out.writerows([cell, f"{x:.6f}", f"{y:.6f}", f"{z:.6f}"] for x, y, z in points.tolist())
    write_bytes(path, file.getvalue().encode("utf-8"), force=force)
