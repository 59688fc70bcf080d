"""`vomstudio trace`: lines on a model, followed, proposed or drawn on an orthophoto."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.cli.common import straight_traces, text_tables, trace_drawing, trace_proposals
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.error_context import name_input_in_errors
from vomstudio.cli.common.frame_arguments import add_frame, add_project, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import declarations
from vomstudio.core.words import tr
from vomstudio.extraction.trace_options import (
    DrawnTraceOptions,
    FollowOptions,
    ProposalOptions,
    TraceSource,
)

if TYPE_CHECKING:
    from vomstudio.extraction.followed_trace import FollowedTrace
    from vomstudio.extraction.proposals.edge_pictures import EdgeDetector
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.studio.world_models import WorldModel

FORM_OPTIONS: dict[str, type[Any]] = {
    "through": FollowOptions,
    "propose": ProposalOptions,
    "from_ortho": DrawnTraceOptions,
}
"""Options for each form of the command, by the option that selects the form."""


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``trace`` command."""
    parser = add_command(
        subparsers,
        "trace",
        run,
        help_=tr("Follow a contact on a model, import drawn lines, or propose lines"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    add_options(parser, TraceSource)
    for options in FORM_OPTIONS.values():
        add_options(parser, options)
    straight_traces.add_set_options(parser)
    add_frame(parser)
    add_project(parser)
    add_output(parser, tr("write all vertices of the lines as CSV"), is_required=True)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio trace``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError
    """
    source = parse_options(args, TraceSource)
    _check_form(args, next(name for name in FORM_OPTIONS if getattr(source, name)))
    if source.propose:
        trace_proposals.run(args, parse_options(args, ProposalOptions), out)
    elif source.from_ortho is not None:
        trace_drawing.run(args, parse_options(args, DrawnTraceOptions), out)
    else:
        _follow_contact(args, parse_options(args, FollowOptions), out)


def _check_form(args: argparse.Namespace, form: str) -> None:
    """Raise UsageError if an option belongs to another form of the command."""
    flags = {item.name: item.flag for item in declarations(TraceSource)}
    allowed_names = {item.name for item in declarations(FORM_OPTIONS[form])}
    for other_form, options in FORM_OPTIONS.items():
        for item in declarations(options):
            if item.name not in allowed_names and getattr(args, item.name):
                raise _missing_option_error(item.flag, flags[other_form])
    if form != "through" and args.sets_table is not None:
        raise _missing_option_error("--sets-table", flags["through"])


def _missing_option_error(option: str, other_option: str) -> UsageError:
    return UsageError(Finding("option.requires", option=option, other=other_option), field=option)


def _follow_contact(args: argparse.Namespace, options: FollowOptions, out: Output) -> None:
    """Follow a contact. Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.extraction.followed_trace import write_path
    from vomstudio.extraction.proposals.edge_pictures import colour_by_edges
    from vomstudio.extraction.surface_graph import SurfaceGraph
    from vomstudio.io.models.opening import resolution
    from vomstudio.studio.jobs.edge_detection import open_edge_finder
    from vomstudio.studio.world_models import read_in_world

    inputs = [args.model, args.through, options.photo, options.cameras, options.onnx_model]
    check_table_target(args.output, force=args.force, inputs=[i for i in inputs if i is not None])
    model = read_in_world(args.model, progress_reporter(args), frame_options(args), args.project)
    way_points, findings = _read_way_points(args, model)
    if len(way_points) < 2:
        raise InputError(
            Finding("feature.too-few-points", count=2 - len(way_points), minimum=2),
            file=args.through,
        )
    spacing = resolution(model.data)
    with open_edge_finder(options.onnx_model, progress_reporter(args)) as edges:
        progress_reporter(args).stage(tr("Following the contact"))
        with name_input_in_errors(args.through):
            surface = SurfaceGraph(
                model.data
                if edges is None or options.photo is not None
                else colour_by_edges(model.data, spacing, *edges)
            )
            if way_points.shape[1] == 3:
                _require_on_model(args.through, way_points, surface, spacing)
            trace = _follow_line(args, options, model, surface, way_points, spacing, edges)
    notes = [tr("followed over {model}", model=Path(args.model).name), f"cost: {trace.cost}"]
    if args.photo is not None:
        notes.append(tr("in the photo {photo}", photo=Path(args.photo).name))
    write_path(args.output, trace.points, crs=model.crs, notes=notes, force=args.force)
    result: dict[str, Any] = {**trace.to_dict(), "table": args.output}
    result["warnings"] = [*model.warnings, *findings, *trace.warnings]
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(result["warnings"])
    out.text(_result_text(trace, length_unit(model.has_metric_unit)))


def _read_way_points(
    args: argparse.Namespace, model: WorldModel
) -> tuple[FloatArray, Sequence[Finding]]:
    """Return way-points (n, 3) in the World frame or (n, 2) in photo pixels, and findings."""
    from vomstudio.io.gate.point_tables import read_points
    from vomstudio.io.gate.points import ModelFrame
    from vomstudio.io.text.pixel_tables import read_pixels

    pixels = None if args.photo is None else read_pixels(args.through)
    if pixels is not None:
        return pixels, ()
    groups = read_points(args.through, model=ModelFrame(model.crs)).groups
    return groups.points, groups.warnings


def _follow_line(
    args: argparse.Namespace,
    options: FollowOptions,
    model: WorldModel,
    surface: SurfaceGraph,
    way_points: FloatArray,
    spacing: float,
    edges: tuple[EdgeDetector, Path] | None,
) -> FollowedTrace:
    from vomstudio.extraction.calibrated_photos import open_photos
    from vomstudio.extraction.followed_trace import followed_trace
    from vomstudio.extraction.photo_trace import photo_trace
    from vomstudio.extraction.proposals.edge_photos import replace_by_edges
    from vomstudio.extraction.proposals.edge_pictures import EDGE_COST
    from vomstudio.io.photos.cameras_file import FILE_NAME
    from vomstudio.io.photos.own_cameras.reading import find_camera_file

    arguments: dict[str, Any] = {
        "cost": options.used_cost if edges is None else EDGE_COST,
        "name": "" if edges is None else options.used_cost,
        "resolution": spacing,
        "model": Path(args.model).name,
        "frame": model.crs or "local",
        "priors": straight_traces.read_sets(args),
    }
    if options.photo is None:
        return followed_trace(surface, way_points, **arguments)
    cameras = options.cameras or find_camera_file(args.model)
    photos = open_photos(
        model.data,
        spacing,
        options.photo,
        cameras or Path(args.model).with_name(FILE_NAME),
        model.to_world,
    )
    if edges is not None:
        photos = replace_by_edges(photos, *edges)
    return photo_trace(surface, photos, way_points, **arguments)


def _require_on_model(
    path: str, points: FloatArray, surface: SurfaceGraph, resolution: float
) -> None:
    """Raise InputError with the line of the table if a way-point is not on the model."""
    from vomstudio.extraction.followed_trace import find_way_point_off_model, off_model_finding
    from vomstudio.io.text.tables import coordinate_columns, read_table

    row = find_way_point_off_model(surface, points, resolution)
    if row is None:
        return
    table = read_table(path)
    is_finite = np.isfinite(table.numbers(coordinate_columns(table))).all(axis=1)
    line = int(np.asarray(table.line_numbers)[is_finite][row])
    distance = float(surface.snap_distances(points)[row])
    raise InputError(off_model_finding(row + 1, distance, resolution), file=path, line=line)


def _result_text(trace: FollowedTrace, unit: str) -> str:
    """Describe the length and the plane of a trace."""
    lines = [
        tr(
            "The trace has {count} vertices and is {length:.3g} {unit} long; its maximum distance"
            " from a way-point is {snap:.3g} {unit}.",
            unit=unit,
            count=trace.vertices,
            length=trace.length_m,
            snap=trace.snap_m,
        )
    ]
    if trace.plane is not None:
        lines.append(
            tr(
                "Plane {plane} (95 %), {quality}.",
                plane=text_tables.plane_with_error(trace.plane),
                quality=trace.plane["quality"],
            )
        )
        if trace.plane["quality_reason"]:
            lines.append(str(trace.plane["quality_reason"]))
    if trace.tried:
        lines.append(
            tr(
                "Followed with the cost {cost}, which gives the best plane (95 % errors in deg:"
                " {tried}).",
                cost=trace.cost,
                tried=", ".join(
                    f"{trial.cost} ({text_tables.number(trial.error95_deg, 1)})"
                    for trial in trace.tried
                ),
            )
        )
    if trace.band is not None:
        lines += straight_traces.band_lines(trace.band)
    return "\n".join(lines)
