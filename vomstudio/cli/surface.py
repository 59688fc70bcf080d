"""`vomstudio surface`: deviations of a patch from its plane."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.unitless_lengths import add_unitless_names, length_unit
from vomstudio.core.errors import UsageError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.products.surface.surface_options import SurfaceOptions

if TYPE_CHECKING:
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``surface`` command."""
    parser = add_command(
        subparsers,
        "surface",
        run,
        help_=tr("Measure the roughness of a patch and its deviations from a plane"),
    )
    parser.add_argument("model", metavar="MODEL", help=tr("mesh, point cloud or table x, y, z"))
    add_options(parser, SurfaceOptions)
    parser.add_argument(
        "--facet", metavar="N", type=int, help=tr("use only this facet of a labelled model")
    )
    add_output(parser, tr("output deviations (.tif, .ply or .csv)"), is_required=True)
    parser.add_argument(
        "--profiles",
        metavar="OUT.csv",
        help=tr("also write profiles along and across the smoothest direction as a table"),
    )
    add_frame(parser)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio surface``.

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
    from vomstudio.core.files.atomic import check_target
    from vomstudio.core.files.extensions import check_table_target
    from vomstudio.products.surface.analysis import analyse
    from vomstudio.products.surface.patch import parse_around
    from vomstudio.products.surface.writing import (
        format_from_path,
        write_deviations,
        write_profiles,
    )
    from vomstudio.studio.world_models import read_in_world

    options = parse_options(args, SurfaceOptions)
    format_from_path(args.output)
    if options.around is not None and args.facet is not None:
        raise UsageError(
            Finding("option.conflict", option="--facet", other="--around"), field="--facet"
        )
    region = None if options.around is None else parse_around(options.around)
    check_target(args.output, force=args.force, inputs=[args.model])
    if args.profiles is not None:
        check_table_target(
            args.profiles,
            force=args.force,
            inputs=[args.model, args.output],
            field="--profiles",
        )
    progress = progress_reporter(args)
    model = read_in_world(args.model, progress, frame_options(args))
    try:
        patch = _extract_patch(args, model.data, region)
        analysis = analyse(
            patch,
            noise_m=options.noise_m,
            cell_m=options.gsd_m,
            model=Path(args.model).name,
            frame=model.crs or "local",
            progress=progress,
        )
    except UsageError:
        raise
    except VomError as error:
        raise type(error)(error.message, file=args.model, field=error.field) from error
    warnings = [*model.warnings, *analysis.warnings]
    progress.stage(tr("Writing the results"))
    warnings += write_deviations(
        args.output, analysis, patch, crs=model.crs, force=args.force, axes=model.axes
    )
    if args.profiles is not None:
        write_profiles(args.profiles, analysis, crs=model.crs, force=args.force, axes=model.axes)
    result: dict[str, Any] = {"file": args.output, "profiles": args.profiles, **analysis.to_dict()}
    result["warnings"] = warnings
    out.result(add_unitless_names(result, is_metric=model.has_metric_unit))
    out.warn(warnings)
    out.text(_result_text(result, length_unit(model.has_metric_unit)))


def _extract_patch(
    args: argparse.Namespace, data: Mesh | PointCloud, region: Any
) -> Mesh | PointCloud:
    from vomstudio.products.surface.patch import extract_facet, extract_within_radius

    if region is not None:
        return extract_within_radius(data, *region)
    return data if args.facet is None else extract_facet(data, args.facet)


def _result_text(result: dict[str, Any], unit: str) -> str:
    """Describe the deviations, roughness and smoothest direction of a patch."""
    plane, figures = result["plane"], text_tables.figures
    lines = [
        tr(
            "Plane {plane}: deviations from {low} to {high} {unit}, RMS {rms} {unit}; the model's "
            "noise is {noise} {unit}.",
            unit=unit,
            plane=f"{text_tables.azimuth(plane['dip_direction_deg'], 1)}/"
            f"{text_tables.inclination(plane['dip_deg'], 1)}",
            low=figures(result["lowest_m"]),
            high=figures(result["highest_m"]),
            rms=figures(result["rms_m"]),
            noise=figures(result["noise_m"]),
        )
    ]
    hurst, smoothest_line = result["hurst"], result["smoothest"]
    if hurst is None:
        lines.append(result["hurst_reason"]["message"])
    else:
        lines.append(
            tr(
                "Hurst exponent {H:.2f} ± {error:.2f} (95 %) from {from_} to {to} {unit}.",
                unit=unit,
                H=hurst["H"],
                error=hurst["error95"],
                from_=figures(hurst["from_m"]),
                to=figures(hurst["to_m"]),
            )
        )
    if smoothest_line is None:
        lines.append(result["smoothest_reason"]["message"])
    else:
        lines.append(
            tr(
                "Smoothest along {line}, rake {rake:.0f} ± {error:.0f} degrees (95 %);"
                " {ratio:.1f} times as rough across it.",
                line=f"{text_tables.azimuth(smoothest_line['trend_deg'], 0)}/"
                f"{text_tables.inclination(smoothest_line['plunge_deg'], 0)}",
                rake=smoothest_line["rake_deg"],
                error=smoothest_line["error95_deg"],
                ratio=smoothest_line["ratio"],
            )
        )
    return "\n".join(lines)
