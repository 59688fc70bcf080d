"""Figure, tables and command line of a bed thickness log."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from vomstudio.core.files.atomic import atomic_write, write_bytes
from vomstudio.core.files.spreadsheet_cells import escape_formula
from vomstudio.core.options import option_words
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.notation import format_exact_plane
from vomstudio.io.gate.stated_crs import WORLD_COMMENT
from vomstudio.products.section.line_log import LogResult, RockDescription, unique_names
from vomstudio.ui.widgets.copied_command import CommandArguments, format_numbers


def draw_figure(result: LogResult, dpi: float = 130.0) -> bytes:
    """Draw the figure as PNG. Runs in a worker thread."""
    file = io.BytesIO()
    _write_figure(result, file, "png", dpi)
    return file.getvalue()


def write(result: LogResult, path: Path) -> None:
    """Write the table or figure in the format of the file extension.

    An existing file is replaced. Runs in a worker thread.
    """
    from vomstudio.project.tables.log_table import describe_log_inputs, write_log

    suffix = path.suffix.lower().removeprefix(".")
    if suffix == "csv":
        description = describe_log_inputs(result.bed, result.bed95_deg)
        is_metric = result.request.is_metric
        write_log(path, result.log, description=description, is_metric=is_metric, force=True)
    else:
        with atomic_write(path, True) as temporary_path:
            _write_figure(result, temporary_path, suffix, 300.0)


def _write_figure(result: LogResult, target: io.BytesIO | Path, format_: str, dpi: float) -> None:
    from vomstudio.products.section.bed_log_figure import write_log_figure
    from vomstudio.project.tables.log_table import describe_log_inputs

    description = describe_log_inputs(result.bed, result.bed95_deg)
    write_log_figure(
        target,
        result.log,
        format=format_,
        description=description,
        is_metric=result.request.is_metric,
        dpi=dpi,
    )


def write_boundaries(result: LogResult, path: Path) -> None:
    """Write the table of boundaries that the command reads, replacing an existing file.

    Raises TargetError.
    """
    file = io.StringIO()
    file.write(WORLD_COMMENT)
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["name", "x", "y", "z", "lithology", "notes"])
    descriptions = result.request.words
    names = unique_names([b.name for b in result.boundaries])
    for name, boundary in zip(names, result.boundaries, strict=True):
        description = descriptions.get(boundary.key, RockDescription())
        coordinates = format_numbers(boundary.position).split(",")
        writer.writerow(
            [
                escape_formula(name),
                *coordinates,
                escape_formula(description.lithology),
                escape_formula(description.notes),
            ]
        )
    write_bytes(path, file.getvalue().encode(), force=True)


def log_command(result: LogResult, table: Path) -> CommandArguments:
    """Return the command that reproduces the log and its figure from a table of boundaries."""
    options = LogOptions(
        sigma_m=result.sigma_m or None,
        bed_error_deg=result.bed95_deg or None,
        overturned=result.request.options.overturned,
    )
    result_stem = table.with_name(f"{table.stem}_result")
    return [
        "log",
        table,
        ("--bed", format_exact_plane(result.bed)),
        *option_words(options),
        ("-o", result_stem.with_suffix(".csv")),
        ("--plot", result_stem.with_suffix(".svg")),
    ]
