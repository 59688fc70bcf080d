"""`vomstudio plan`: planning of a photo survey."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr
from vomstudio.photogrammetry.survey.survey_options import PlanOptions

if TYPE_CHECKING:
    from vomstudio.photogrammetry.survey.planning import SurveyPlan


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``plan`` command."""
    parser = add_command(
        subparsers,
        "plan",
        run,
        help_=tr("Plan a photo survey: distance, positions, control points"),
    )
    parser.add_argument(
        "--camera",
        nargs="+",
        required=True,
        metavar="CAMERA",
        help=tr(
            "camera name, a photo taken with it, or numbers: 23.5x15.6,35,6000x4000 (sensor in"
            " mm, focal length in mm, pixels)"
        ),
    )
    add_options(parser, PlanOptions)
    add_output(parser, tr("printable field sheet (.pdf, .svg, .html)"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio plan``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, TargetError
    """
    from vomstudio.core.files.atomic import check_target
    from vomstudio.photogrammetry.survey.plan_camera import parse_camera
    from vomstudio.photogrammetry.survey.plan_forecast import add_forecasts
    from vomstudio.photogrammetry.survey.planning import plan_survey
    from vomstudio.products.report.field_sheet import check_format, write_field_sheet

    options = parse_options(args, PlanOptions)
    if args.output is not None:
        check_format(args.output)
        check_target(args.output, force=args.force)
    plan = plan_survey(parse_camera(" ".join(args.camera), options.focal_mm), options)
    plan = add_forecasts(plan, options.receiver_m, options.control_m)
    if args.output is not None:
        write_field_sheet(args.output, plan, force=args.force)
    out.result({**plan.to_dict(), "sheet": args.output})
    out.warn(plan.warnings)
    out.text(_result_text(plan))
    if args.output is not None:
        out.text(str(args.output))


def _result_text(plan: SurveyPlan) -> str:
    from vomstudio.photogrammetry.survey.plan_forecast import forecast_text
    from vomstudio.photogrammetry.survey.survey_resolution import planes_summary

    near_m, far_m = plan.depth_of_field_m
    c = plan.camera
    rows = [
        (
            tr("camera"),
            tr(
                "{camera}, {focal:g} mm, sensor {sensor_width:.3g} x {sensor_height:.3g} mm, "
                "{width} x {height} px",
                camera=c.name,
                focal=c.focal_mm,
                sensor_width=c.sensor_width_mm,
                sensor_height=c.sensor_height_mm,
                width=c.width_px,
                height=c.height_px,
            ),
        ),
        (tr("distance"), f"{plan.distance_m:.4g} m"),
        (tr("GSD"), f"{1000 * plan.gsd_m:.3g} mm"),
        (tr("planes across"), planes_summary(plan.planes)),
        (tr("photo footprint"), f"{plan.footprint_m[0]:.3g} x {plan.footprint_m[1]:.3g} m"),
        (
            tr("spacing"),
            tr(
                "{along:.3g} m along, {up:.3g} m up ({overlap:.0f} % overlap)",
                along=plan.spacing_m[0],
                up=plan.spacing_m[1],
                overlap=100 * plan.overlap,
            ),
        ),
        (
            tr("photos"),
            tr(
                "{count}: {perpendicular} perpendicular, {oblique} oblique by 30 degrees",
                count=len(plan.positions),
                perpendicular=len(plan.select_kind("perpendicular")),
                oblique=len(plan.select_kind("oblique")),
            ),
        ),
        (
            tr("views"),
            tr(
                "at least {least} for every point, median {median:.0f}",
                least=plan.views_least,
                median=plan.views_median,
            ),
        ),
        (
            tr("depth of field"),
            tr(
                "{near:.3g} m to infinity at f/{aperture:g} (within 2 pixels)",
                near=near_m,
                aperture=plan.f_number,
            )
            if far_m is None
            else tr(
                "{near:.3g} m to {far:.3g} m at f/{aperture:g} (within 2 pixels)",
                near=near_m,
                far=far_m,
                aperture=plan.f_number,
            ),
        ),
        (
            tr("control points"),
            tr(
                "{points}: marks of at least {size:.2g} cm",
                points=", ".join(p.label for p in plan.control_points),
                size=100 * plan.target_size_m,
            ),
        ),
        *((tr("registration"), forecast_text(registration)) for registration in plan.registration),
    ]
    return text_tables.label_lines(rows)
