"""Commands for planes that were fitted to picked points."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtWidgets import QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gate.stated_crs import WORLD_COMMENT
from vomstudio.project.kind import may_have_plane, select_plane_features
from vomstudio.project.records import PickedFeature
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.copied_command import (
    CommandArgument,
    CommandArguments,
    copy_with_file,
    format_numbers,
)
from vomstudio.ui.widgets.figure_file import choose_figure_file


def commands(studio: Studio, parent: QWidget) -> list[Command]:
    """Create the commands that draw the figure of plane shapes and copy the fit command."""

    def disabled_reason() -> Finding | None:
        # The search stops at the first plane, since it runs after every edit on thousands of
        # records.
        has_planes = any(
            isinstance(r, PickedFeature) and may_have_plane(r) for r in studio.records.values()
        )
        return None if has_planes else Finding("planes.none")

    return [
        Command(
            "fit_figure",
            tr("Plane s&hapes figure…"),
            lambda: _ask_for_figure(studio, parent),
            icon="chart-scatter-plot",
            tip=tr("Plot coplanarity against collinearity for selected or all planes."),
            disabled_reason=disabled_reason,
        ),
        Command(
            "copy_fit",
            tr("Copy &fit command…"),
            lambda: copy_fit(studio, parent),
            icon="console",
            tip=tr("Export the points of selected or all traces, and copy the command."),
            disabled_reason=disabled_reason,
        ),
    ]


def planes_to_fit(studio: Studio) -> Sequence[PickedFeature]:
    """Return the selected planes that were fitted to picked points, or else all such planes."""
    records = studio.records
    selected_features = [
        f
        for f in select_plane_features(records, studio.selection.ids)
        if isinstance(f, PickedFeature)
    ]
    return selected_features or [
        f for f in select_plane_features(records, list(records)) if isinstance(f, PickedFeature)
    ]


def _ask_for_figure(studio: Studio, parent: QWidget) -> None:
    path = choose_figure_file(parent, studio, tr("Plane shapes figure"), "shapes")
    if path is not None:
        write_figure(studio, path)


def write_figure(studio: Studio, path: Path) -> None:
    """Write the figure of plane shapes as SVG, PDF or PNG, replacing an existing file."""
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.net.shape_figure import write_shapes
    from vomstudio.project.tables.project_table import project_table

    table = project_table(
        studio.records, studio.measurements, {f.id for f in planes_to_fit(studio)}
    )
    try:
        with atomic_write(path, True) as temporary_path:
            write_shapes(temporary_path, table.rows, format=path.suffix.lower().removeprefix("."))
    except VomError as error:
        studio.fail(error)
    else:
        studio.written(path)


def copy_fit(studio: Studio, parent: QWidget) -> None:
    """Save the points of planes as a table, and copy the command that fits the planes."""
    planes = planes_to_fit(studio)
    measurements = studio.measured(f.id for f in planes)
    methods = {getattr(f, "method", "pca") for f in planes}

    def write(path: Path) -> None:
        from vomstudio.core.files.atomic import write_bytes
        from vomstudio.project.tables.orientation_table import csv_text

        rows = [WORLD_COMMENT.strip(), "id,x,y,z"]
        for f in planes:
            name = csv_text(f.id)
            rows += [f"{name},{format_numbers(p)}" for p in measurements[f.id].points.tolist()]
        write_bytes(path, ("\n".join(rows) + "\n").encode(), force=True)

    def build_command(path: Path) -> CommandArguments:
        arguments: list[CommandArgument | tuple[str, CommandArgument]] = [
            "fit",
            path,
            ("--by", "id"),
        ]
        if len(methods) == 1:
            arguments.append(("--method", str(next(iter(methods)))))
        return arguments

    copy_with_file(parent, studio, "points.csv", write, build_command)
