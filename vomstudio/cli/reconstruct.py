"""`vomstudio reconstruct`: reconstruction of a registered, textured model from photos."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Subparsers, add_command, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions

if TYPE_CHECKING:
    from vomstudio.studio.jobs.reconstruction_tasks import Reconstruction


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``reconstruct`` command."""
    parser = add_command(
        subparsers,
        "reconstruct",
        run,
        help_=tr("Reconstruct a textured model from a folder of photos"),
    )
    parser.add_argument(
        "photos", metavar="PHOTOS", help=tr("folder of JPEG, HEIC, TIFF or PNG photos")
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        required=True,
        help=tr("output folder; run again with the same folder to continue"),
    )
    add_options(parser, ReconstructOptions)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio reconstruct``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError, InputError, GeometryError, TargetError, WorkerError
    """
    from vomstudio.studio.jobs.reconstruction_requests import reconstruction_request
    from vomstudio.studio.jobs.reconstruction_tasks import RECONSTRUCT
    from vomstudio.studio.jobs.run_job import run_job

    options = parse_options(args, ReconstructOptions)
    order, findings = reconstruction_request(args.photos, args.output, options)
    result = run_job(RECONSTRUCT, order, progress_reporter(args))
    result = replace(result, warnings=(*findings, *result.warnings))
    out.result(result.to_dict())
    out.warn(result.warnings)
    out.text(_result_text(result))


def _result_text(result: Reconstruction) -> str:
    lines = [
        tr(
            "{aligned} of {count} photos aligned, reprojection error {error:.2f} px",
            aligned=result.registered,
            count=result.photos,
            error=result.reprojection_error_px,
        ),
        tr(
            "{points:,} points, {faces:,} faces, frame {frame}",
            points=result.dense_points,
            faces=result.faces,
            frame=result.frame,
        ),
        f"{result.mesh} ({sum(result.seconds.values()):.0f} s, {result.peak_memory_mb:.0f} MB)",
        tr("report: {file}", file=result.report),
        tr(
            "The folder “work” contains {size:.0f} MB of intermediate results, which can be"
            " deleted.",
            size=result.work_mb,
        ),
    ]
    return "\n".join(lines)
