"""`vomstudio measurable`: expected quality of a plane before it is picked."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import (
    Subparsers,
    add_command,
    add_output,
    progress_reporter,
)
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import (
    add_frame,
    add_project,
    frame_options,
    unknown_unit,
)
from vomstudio.cli.common.labelled_models import write_labelled_model
from vomstudio.cli.common.orientation_tables import add_table_options, read_table_picks
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.extraction.measurable_options import MeasurableOptions, MeasurableTarget

if TYPE_CHECKING:
    from vomstudio.geology.orientation import Plane
    from vomstudio.products.surface.measurable_map import MeasurableMap
    from vomstudio.studio.world_models import WorldModel


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``measurable`` command."""
    parser = add_command(
        subparsers,
        "measurable",
        run,
        help_=tr("Map how accurately a plane could be measured at each point of a model"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh or point cloud"))
    add_options(parser, MeasurableTarget)
    add_options(parser, MeasurableOptions)
    add_output(parser, tr("output map: a raster (.tif) or the model with its fields (.ply)"))
    add_table_options(parser)
    add_frame(parser)
    add_project(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio measurable``.

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
    from vomstudio.cli.common.error_context import name_input_in_errors
    from vomstudio.core.files.atomic import check_target
    from vomstudio.io.models.writing import choose_writer
    from vomstudio.products.surface.measurable_map import (
        RASTER_SUFFIXES,
        measurable_map,
        write_raster,
    )
    from vomstudio.studio.world_models import read_in_world

    options, target = parse_options(args, MeasurableOptions), parse_options(args, MeasurableTarget)
    plane, findings = _target_plane(target, args)
    is_raster = args.output is not None and Path(args.output).suffix.lower() in RASTER_SUFFIXES
    if args.output is not None:
        if not is_raster:
            choose_writer(Path(args.output))
        inputs = [args.model, *([target.mean] if target.mean else [])]
        check_target(args.output, force=args.force, inputs=inputs)
    if target.gsd_m is not None and not is_raster:
        raise UsageError(
            Finding("option.requires", option="--gsd", other="-o NAME.tif"), field="--gsd"
        )
    progress = progress_reporter(args)
    model = read_in_world(args.model, progress, frame_options(args), args.project)
    with name_input_in_errors(args.model):
        measurability_map = measurable_map(
            model.data, plane, _add_registration_error(options, model, plane), progress
        )
    warnings = [*model.warnings, *findings, *unknown_unit(model)]
    warnings += measurability_map.warnings
    result: dict[str, Any] = {"file": args.output, **measurability_map.to_dict()}
    if is_raster:
        result["raster"] = write_raster(
            args.output,
            model.data,
            measurability_map,
            crs=model.crs,
            cell_m=target.gsd_m,
            force=args.force,
            progress=progress,
        )
    elif args.output is not None:
        args.labels = args.output
        warnings += write_labelled_model(args, model, measurability_map.as_fields())
    result["warnings"] = warnings
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(warnings)
    out.text(_result_text(measurability_map))


def _target_plane(
    target: MeasurableTarget, args: argparse.Namespace
) -> tuple[Plane, tuple[Finding, ...]]:
    """Return the plane given by the user or the mean plane of a table, with its findings."""
    if target.plane is not None:
        from vomstudio.geology.notation import parse_plane_option

        return parse_plane_option(target.plane), ()
    from vomstudio.geology.populations.table_means import mean_plane

    assert target.mean is not None
    table = read_table_picks(args, target.mean)
    return mean_plane(table, target.set), tuple(table.warnings)


def _add_registration_error(
    options: MeasurableOptions, model: WorldModel, plane: Plane
) -> MeasurableOptions:
    """Return the options with the error of the project's registration if none was given."""
    if options.registration_error_deg is not None or model.project_model is None:
        return options
    from vomstudio.project.measurement import ToWorld

    tilt_deg = ToWorld.from_model(model.project_model).tilt_deg(plane.normal()) or 0.0
    return replace(options, registration_error_deg=tilt_deg)


def _result_text(measurable: MeasurableMap) -> str:
    """Describe the shares of the model by plane quality, and the best location for a trace."""
    from vomstudio.products.surface.measurable_map import share_findings

    figures = text_tables.figures
    plane = (
        f"{text_tables.azimuth(measurable.plane['dip_direction_deg'], 1)}/"
        f"{text_tables.inclination(measurable.plane['dip_deg'], 1)}"
    )
    lines = [
        tr(
            "Plane {plane}, traces of {length} m, resolution {resolution} m.",
            plane=plane,
            length=figures(measurable.length_m),
            resolution=figures(measurable.resolution_m),
        ),
        *map(str, share_findings(measurable)),
    ]
    if measurable.best is not None:
        lines.append(
            tr(
                "The best position for a trace is {x:.2f}, {y:.2f}, {z:.2f} (95 % error"
                " {error} deg).",
                x=measurable.best["x"],
                y=measurable.best["y"],
                z=measurable.best["z"],
                error=text_tables.number(measurable.best["error95_deg"], 2),
            )
        )
    return "\n".join(lines)
