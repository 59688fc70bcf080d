"""`vomstudio export`: what a project holds, for other programs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.arguments import Subparsers, add_command, add_output
from vomstudio.cli.output import Output

if TYPE_CHECKING:
    from vomstudio.io.project import Project


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "export", run, help_="Write a project's features for other programs"
    )
    parser.add_argument("project", metavar="PROJECT", help="the folder NAME.vom")
    parser.add_argument("--to", metavar="FORMAT", choices=list(FORMATS), required=True)
    add_output(parser, "the file to write", required=True)


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.io.atomic import check_target
    from vomstudio.io.project import Project

    check_target(args.output, force=args.force)
    project = Project.open(Path(args.project))
    try:
        found = FORMATS[args.to](project, args.output, args.force)
    finally:
        project.close()
    out.result({"files": [args.output], **found})
    out.warn([f"{item['name']} left out: {item['reason']}" for item in found["skipped"]])
    out.text(f"{args.output}: {found['n']} features")


def _csv(project: Project, target: str, force: bool) -> dict[str, Any]:
    from vomstudio.io.orientation_table import write_orientation_csv
    from vomstudio.io.project_table import project_table

    table = project_table(project.session.records)
    write_orientation_csv(
        target,
        table.rows,
        crs=table.crs,
        north=table.north,
        notes=[f"project: {project.name}"],
        force=force,
    )
    return {"n": len(table.rows), "skipped": table.skipped}


FORMATS: dict[str, Callable[[Project, str, bool], dict[str, Any]]] = {"csv": _csv}
"""How to write each format; raises TargetError."""
