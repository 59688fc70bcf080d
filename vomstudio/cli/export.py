"""`vomstudio export`: export of a project's features for other programs."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.project.exports.export_options import ExportFormat

MAX_NAMED_FEATURES = 5
"""Maximum number of features per reason that are listed individually."""


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``export`` command."""
    parser = add_command(
        subparsers, "export", run, help_=tr("Export the features of a project to other programs")
    )
    parser.add_argument("project", metavar="PROJECT", help=tr("the folder NAME.vom"))
    add_options(parser, ExportFormat)
    add_output(parser, tr("output file"), is_required=True)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio export``.

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
    from vomstudio.project.exports.export import export_project

    table = export_project(
        Path(args.project),
        args.to,
        Path(args.output),
        is_projected=args.projected,
        force=args.force,
        progress=progress_reporter(args),
    )
    files = [str(path) for path in table.files]
    result: dict[str, Any] = {"files": files, "n": len(table.rows), "skipped": table.skipped}
    if table.warnings:
        result["warnings"] = table.warnings
    if table.layers:
        result["layers"] = dict(table.layers)
    out.result(result)
    out.warn([*table.warnings, *_skipped_findings(table.skipped)])
    out.text(
        tr_n(
            "{files}: {count} feature",
            "{files}: {count} features",
            len(table.rows) if table.features is None else table.features,
            files=", ".join(files),
        )
    )


def _skipped_findings(skipped_features: Sequence[Mapping[str, Any]]) -> list[Finding]:
    """Return one finding per feature, or a single one for many with the same reason."""
    names_by_reason: dict[Finding, list[str]] = {}
    for item in skipped_features:
        names_by_reason.setdefault(item["reason"], []).append(item["name"])
    findings = []
    for reason, features in names_by_reason.items():
        if len(features) > MAX_NAMED_FEATURES:
            findings.append(Finding("features.left-out", count=len(features), reason=reason))
        else:
            findings += [Finding("feature.left-out", feature=f, reason=reason) for f in features]
    return findings
