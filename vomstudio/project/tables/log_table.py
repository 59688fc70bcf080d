"""Log as a table with one row per interval, starting with the oldest."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import comment_line, escape_formula
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.geology.beds.bed_log import BedLog
from vomstudio.geology.beds.lithologies import STRABOSPOT_FIELDS
from vomstudio.geology.notation import format_attitude, format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.units import Axes, table_columns

COLUMNS = (
    "number",
    "base",
    "top",
    "base_m",
    "top_m",
    "thickness_m",
    "thickness_error95_m",
    "lithology",
    *STRABOSPOT_FIELDS,
    "notes",
)


def write_log(
    path: str | Path,
    log: BedLog,
    *,
    description: str = "",
    is_metric: bool = True,
    force: bool = False,
) -> None:
    """Write a log as CSV.

    Parameters
    ----------
    path : str or Path
    log : BedLog
    description : str
        Inputs of the thicknesses, written to the header.
    is_metric : bool
        Whether lengths are in metres. If False, they are in units of a model of unknown scale.
    force : bool, optional
        Whether to replace existing files.

    Raises
    ------
    TargetError
        If the file cannot be written.
    """
    file = io.StringIO()
    file.write(comment_line(f"VOM Studio {__version__}, log; {description}"))
    unit = Axes(metric=is_metric).unit
    file.write(f"# {unit} across the bedding, errors 95 %, from the oldest bed up\n")
    out = csv.writer(file, lineterminator="\n")
    out.writerow(table_columns(COLUMNS, is_metric=is_metric))
    for interval in log.intervals:
        error = interval.thickness_m.error95
        texts = [
            interval.lithology,
            *(interval.strabospot.get(field, "") for field in STRABOSPOT_FIELDS),
            interval.notes,
        ]
        out.writerow(
            [
                interval.number,
                escape_formula(interval.base),
                escape_formula(interval.top),
                f"{interval.base_m:.4f}",
                f"{interval.top_m:.4f}",
                f"{interval.thickness_m.value:.4f}",
                "" if error is None else f"{error:.4f}",
                *map(escape_formula, texts),
            ]
        )
    write_bytes(path, file.getvalue().encode("utf-8"), force=force)


def describe_log_inputs(bed: Plane, error95_deg: float) -> str:
    """Return the inputs of the thicknesses of a log, for its header."""
    if not error95_deg:
        return tr("bedding {bed}, error unknown", bed=format_plane(bed, decimals=1))
    return tr("bedding {bed} (95 %)", bed=format_attitude(bed, error95_deg))
