"""`vomstudio frames`: the usable frames of a video."""

from __future__ import annotations

import argparse

from vomstudio.cli.common.arguments import Subparsers, add_command, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.output import Output
from vomstudio.core.words import tr, tr_n
from vomstudio.photogrammetry.survey.survey_options import VideoFrameOptions


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``frames`` command."""
    parser = add_command(
        subparsers,
        "frames",
        run,
        help_=tr("Extract sharp frames from a video for a reconstruction"),
    )
    parser.add_argument(
        "video", metavar="VIDEO", help=tr("video of the outcrop in any common format")
    )
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help=tr("output folder"))
    parser.add_argument(
        "--force", action="store_true", help=tr("write into a folder that contains other files")
    )
    add_options(parser, VideoFrameOptions)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio frames``.

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
    from vomstudio.photogrammetry.survey.video import take_frames

    options = parse_options(args, VideoFrameOptions)
    report = take_frames(
        args.video, args.output, fps=options.fps, force=args.force, progress=progress_reporter(args)
    )
    out.result(report.to_dict())
    out.warn(report.warnings)
    lines = [
        tr(
            "{width} x {height} px, {seconds:.1f} s at {rate:g} frames per second",
            width=report.width,
            height=report.height,
            seconds=report.seconds,
            rate=report.video_fps,
        ),
        tr_n(
            "{count} frame in {folder}",
            "{count} frames in {folder}",
            len(report.frames),
            folder=args.output,
        ),
        *(
            "  "
            + tr_n("{count} left out: {reason}", "{count} left out: {reason}", n, reason=reason)
            for reason, n in report.skipped.items()
        ),
        report.verdict,
    ]
    out.text("\n".join(lines))
