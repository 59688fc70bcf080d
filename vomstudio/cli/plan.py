"""`vomstudio plan`: a photo survey before going out."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from vomstudio.cli.arguments import Subparsers, add_command, add_output
from vomstudio.cli.output import Output
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.survey.planning import SurveyPlan


def add_parser(subparsers: Subparsers) -> None:
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
            "its name, a photo taken with it, or numbers: 23.5x15.6,35,6000x4000 (sensor "
            "in mm, focal length in mm, pixels)"
        ),
    )
    parser.add_argument("--focal", type=float, metavar="MM", help=tr("focal length of the lens"))
    parser.add_argument("--distance", type=float, metavar="M", help=tr("from camera to rock"))
    parser.add_argument(
        "--width", type=float, required=True, metavar="M", help=tr("of the outcrop")
    )
    parser.add_argument(
        "--height", type=float, required=True, metavar="M", help=tr("of the outcrop")
    )
    parser.add_argument(
        "--gsd", type=float, metavar="M", help=tr("wanted size of a pixel on the rock")
    )
    parser.add_argument(
        "--plane", type=float, metavar="M", help=tr("smallest plane to be measured, across")
    )
    parser.add_argument(
        "--overlap", type=float, default=0.7, metavar="SHARE", help=tr("0.6 to 0.8 (default 0.7)")
    )
    parser.add_argument(
        "--manner",
        choices=["handheld", "drone", "terrain"],
        default="handheld",
        help=tr("on foot, by drone before a cliff, or by drone over flat ground"),
    )
    parser.add_argument(
        "--aperture", type=float, default=8.0, metavar="N", help=tr("f-number (default 8)")
    )
    add_output(parser, "a field sheet to print (.pdf, .svg, .html)")


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.files.atomic import check_target
    from vomstudio.products.report.field_sheet import check_format, write_field_sheet
    from vomstudio.survey.plan_camera import camera_of
    from vomstudio.survey.planning import plan_survey

    if args.output is not None:
        check_format(args.output)
        check_target(args.output, force=args.force)
    plan = plan_survey(
        camera_of(" ".join(args.camera), args.focal),
        args.width,
        args.height,
        distance_m=args.distance,
        gsd_m=args.gsd,
        plane_m=args.plane,
        overlap=args.overlap,
        manner=args.manner,
        f_number=args.aperture,
    )
    if args.output is not None:
        write_field_sheet(args.output, plan, force=args.force)
    out.result({**plan.as_dict(), "sheet": args.output})
    out.warn(plan.warnings)
    out.text(_in_words(plan))
    if args.output is not None:
        out.text(str(args.output))


def _in_words(plan: SurveyPlan) -> str:
    near, far = plan.depth_of_field_m
    c = plan.camera
    lines = [
        f"camera            {c.name}, {c.focal_mm:g} mm, sensor {c.sensor_width_mm:.3g} x "
        f"{c.sensor_height_mm:.3g} mm, {c.width_px} x {c.height_px} px",
        f"distance          {plan.distance_m:.4g} m",
        f"pixel on the rock {1000 * plan.gsd_m:.3g} mm",
        f"smallest plane    {plan.smallest_plane_m:.3g} m (1000 pixels)",
        f"one photo shows   {plan.footprint_m[0]:.3g} x {plan.footprint_m[1]:.3g} m",
        f"step              {plan.spacing_m[0]:.3g} m along, {plan.spacing_m[1]:.3g} m up "
        f"({plan.overlap:.0%} overlap)",
        f"photos            {len(plan.stations)}: {len(plan.of_kind('perpendicular'))} "
        f"perpendicular, {len(plan.of_kind('oblique'))} oblique by 30 degrees",
        f"views             {plan.views_least} or more of every place, {plan.views_median:.0f} as "
        "a rule",
        f"sharp             {near:.3g} m to {'infinity' if far is None else f'{far:.3g} m'} at "
        f"f/{plan.f_number:g} (within 2 pixels)",
        f"control points    {', '.join(p.label for p in plan.control_points)}: marks of "
        f"{100 * plan.target_size_m:.2g} cm or more",
    ]
    return "\n".join(lines)
