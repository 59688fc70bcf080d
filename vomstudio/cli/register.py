"""`vomstudio register`: placement of a model from observations."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Subparsers, add_command, add_output, progress_reporter
from vomstudio.cli.common.declared_options import add_options, parse_options
from vomstudio.cli.common.output import Output
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.registration.register_options import RegisterOptions

if TYPE_CHECKING:
    from vomstudio.registration.attitude_evidence import AttitudeResidual
    from vomstudio.registration.results import ModelPlacement
    from vomstudio.studio.placing.register_order import RegistrationResult


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``register`` command."""
    parser = add_command(
        subparsers,
        "register",
        run,
        help_=tr(
            "Register a model using points, cameras, compass readings, known lines or another model"
        ),
    )
    parser.add_argument(
        "model",
        metavar="MODEL",
        help=tr("model or cloud in any supported format; - computes only the registration"),
    )
    add_options(parser, RegisterOptions)
    add_output(parser, tr("write the registered model"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio register``.

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
    from vomstudio.registration.warnings import reference_fit_finding
    from vomstudio.studio.placing.register_order import register_model

    options = parse_options(args, RegisterOptions)
    if args.output is not None:
        if args.model != "-":
            from vomstudio.io.models.writing import choose_writer

            choose_writer(Path(args.output))
        check_target(
            args.output, force=args.force, inputs=[] if args.model == "-" else [args.model]
        )
    registered_model = register_model(args.model, options, progress_reporter(args))
    result = registered_model.to_dict()
    warnings = list(registered_model.placed.warnings)
    if args.output is not None:
        warnings += _write_registered_model(args, registered_model, result)
    result["warnings"] = warnings
    out.result(result)
    out.warn(warnings)
    if registered_model.reference is not None:
        fit = registered_model.reference.fitted
        statistics = fit.places, fit.overlap, fit.rms_m, fit.blocks, fit.block_m
        out.text(reference_fit_finding(*statistics).message)
    out.text(placement_text(registered_model.placed))
    if registered_model.attitudes:
        out.text(_attitudes_text(registered_model.attitudes))


def _attitudes_text(photos: Sequence[AttitudeResidual]) -> str:
    rows = [
        [p.photo, *(text_tables.figures(v) for v in (p.yaw_deg, p.pitch_deg, p.roll_deg))]
        for p in photos
    ]
    headers = [tr("photo"), tr("yaw"), tr("pitch"), tr("roll")]
    return "\n" + text_tables.table(headers, ["", "°", "°", "°"], rows)


def _write_registered_model(
    args: argparse.Namespace, registration_result: RegistrationResult, result: dict[str, Any]
) -> list[Finding]:
    loaded_model = registration_result.loaded
    if loaded_model is None:
        from vomstudio.cli.common.output import to_json
        from vomstudio.core.files.atomic import write_bytes

        write_bytes(Path(args.output), (to_json(result) + "\n").encode(), force=args.force)
        return []
    from vomstudio.geometry.model_transform import transform_model
    from vomstudio.geometry.units import Axes
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import write_model

    known_parts = registration_result.placed.known
    warnings = write_model(
        transform_model(loaded_model.data, registration_result.placed.matrix),
        registration_result.crs if known_parts.all else None,
        args.output,
        force=args.force,
        inputs=[loaded_model.path, *companions(loaded_model.path)],
        progress=progress_reporter(args),
        axes=Axes(metric=known_parts.scale, north=known_parts.north and known_parts.vertical),
        registration=registration_result.registration_in_world,
    )
    result["out"] = args.output
    return warnings


def placement_text(placement: ModelPlacement) -> str:
    """Describe the residuals, the results with each observation left out, and the findings."""
    from vomstudio.registration.warnings import worst_axis_findings

    block_texts = []
    for title, points in ((tr("control"), placement.control), (tr("check"), placement.check)):
        if points:
            rows = [
                [title, p.label, *(text_tables.figures(v) for v in (p.dx, p.dy, p.dz, p.error_m))]
                for p in points
            ]
            headers = [tr("use"), tr("label"), "dx", "dy", "dz", tr("error")]
            block_texts.append(text_tables.table(headers, ["", "", "m", "m", "m", "m"], rows))
    if placement.without:
        rows = [
            [
                w.label,
                *(
                    text_tables.figures(v)
                    for v in (w.error_deg, w.turned_deg, w.others_deg, w.weakest_95_deg)
                ),
            ]
            for w in placement.without
        ]
        headers = [
            tr("left out"),
            tr("deviation"),
            tr("model rotates by"),
            tr("RMS of others"),
            tr("weakest axis, 95 %"),
        ]
        block_texts.append(text_tables.table(headers, ["", "°", "°", "°", "°"], rows))
    return "\n".join([*block_texts, *map(str, worst_axis_findings(placement))])
