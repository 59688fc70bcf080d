"""`vomstudio check`: check a set of photos before reconstruction."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import is_folder
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.survey.survey_options import CheckOptions, CheckScene

if TYPE_CHECKING:
    from vomstudio.photogrammetry.survey.check_results import SurveyReport


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``check`` command."""
    parser = add_command(
        subparsers,
        "check",
        run,
        help_=tr(
            "Check whether photos are suitable for a reconstruction, or how well they were aligned"
        ),
    )
    parser.add_argument("photos", metavar="PHOTOS", help=tr("folder of photos"))
    add_options(parser, CheckOptions)
    add_options(parser, CheckScene)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio check``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    InputError
        If the folder of the photos or of the alignment cannot be read.
    """
    from vomstudio.photogrammetry.survey.folder_check import check_folder

    options, scene = parse_options(args, CheckOptions), None
    if args.scene is not None:
        if not is_folder(args.scene):
            raise InputError(Finding("folder.missing"), file=args.scene, field="--scene")
        from vomstudio.photogrammetry.base.scene import SparseScene
        from vomstudio.photogrammetry.base.stage_folders import stage_folder

        scene = SparseScene.load(stage_folder(Path(args.scene), "frame") or args.scene)
    folder_check, folder = check_folder(args.photos, options.distance_m, progress_reporter(args))
    out.text(_result_text(folder_check))
    if scene is not None:
        from vomstudio.photogrammetry.align.scene_check import check_scene

        placed_names = {view.name for view in scene.views}
        report = check_scene(
            scene,
            unregistered_names=[p.name for p in folder.photos if p.name not in placed_names],
            blur={p.name: p.blur for p in folder_check.photos if p.blur is not None},
        )
        folder_check = replace(folder_check, aligned=report)
        out.text("\n" + tr("After the alignment") + "\n" + _result_text(report))
    out.result(folder_check.to_dict())
    out.warn(
        [
            Finding("photo.left-out", photo=name, reason=reason)
            for name, reason in folder_check.skipped
        ]
    )
    out.warn(folder_check.warnings)


def _result_text(report: SurveyReport) -> str:
    unit, sizes = "mm", [None if p.gsd_m is None else 1000 * p.gsd_m for p in report.photos]
    if report.gsd is not None:
        unit, sizes = tr("units"), [p.gsd for p in report.photos]
    rows = [
        (
            photo.name,
            text_tables.number(size, 2 if unit == "mm" else 4),
            text_tables.number(photo.blur, 2),
            text_tables.number(photo.views, 1),
            text_tables.number(None if photo.overlap is None else 100 * photo.overlap, 0),
        )
        for photo, size in zip(report.photos, sizes, strict=True)
    ]
    lines = []
    if rows:
        headers = (tr("photo"), tr("GSD"), tr("blur"), tr("views"), tr("overlap"))
        lines = [text_tables.table(headers, ("", unit, "px", "", "%"), rows), ""]
    for finding in report.findings:
        lines.append(f"{finding.severity}: {finding.message}")
    lines += ["", report.verdict]
    lines += [tr("Next time: {advice}", advice=advice) for advice in report.next_time]
    return "\n".join(lines)
