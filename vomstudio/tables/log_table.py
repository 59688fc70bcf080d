"""A log as a table: a row for each interval, from the oldest up."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from vomstudio.files.atomic import write_bytes
from vomstudio.geology.beds.bed_log import BedLog
from vomstudio.geology.beds.lithologies import FIELDS
from vomstudio.version import __version__

COLUMNS = (
    "number", "base", "top", "base_m", "top_m", "thickness_m", "thickness_error95_m", "lithology",
    *FIELDS, "notes",
)  # fmt: skip
_FORMULA = tuple("=+-@\t\r'")


def write_log(path: str | Path, log: BedLog, *, about: str = "", force: bool = False) -> None:
    """CSV. about : for the head, on what the thicknesses rest. Raises TargetError."""
    file = io.StringIO()
    file.write(f"# VOM Studio {__version__}, log; {' '.join(about.split())}\n")
    file.write("# metres across the bedding, errors 95 %, from the oldest bed up\n")
    out = csv.writer(file, lineterminator="\n")
    out.writerow(COLUMNS)
    for each in log.intervals:
        error = each.thickness_m.error95
        words = [each.lithology, *(each.strabospot.get(f, "") for f in FIELDS), each.notes]
        out.writerow([
            each.number, _cell(each.base), _cell(each.top), f"{each.base_m:.4f}",
            f"{each.top_m:.4f}", f"{each.thickness_m.value:.4f}",
            "" if error is None else f"{error:.4f}", *map(_cell, words),
        ])  # fmt: skip
    write_bytes(path, file.getvalue().encode("utf-8"), force=force)


def _cell(text: str) -> str:
    return f"'{text}" if text.startswith(_FORMULA) else text
