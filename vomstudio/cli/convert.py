"""`vomstudio convert`: conversion of a mesh or point cloud to another format."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Subparsers, add_command, report_reading
from vomstudio.cli.common.frame_arguments import add_frame, frame_options
from vomstudio.cli.common.output import Output
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geometry.units import METRES_PER_UNIT

_CAMERA_SUFFIXES = ("", ".json")
"""Suffixes of outputs with cameras: the folder of COLMAP, and transforms.json."""

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.core.findings import Finding
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.geometry.registrations import Registration
    from vomstudio.geometry.units import Axes
    from vomstudio.io.models.reader import LoadedModel


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``convert`` command."""
    parser = add_command(
        subparsers,
        "convert",
        run,
        help_=tr("Convert a model, a cloud or cameras to another format"),
    )
    parser.add_argument(
        "input",
        metavar="IN",
        help=tr("model or cloud in any supported format, cameras, or folder of a reconstruction"),
    )
    parser.add_argument(
        "output",
        metavar="OUT",
        help=tr(
            "output file, whose extension selects the format; for cameras: transforms.json, or a"
            " folder for COLMAP"
        ),
    )
    add_frame(parser)
    parser.add_argument(
        "--world", action="store_true", help=tr("write cameras in World coordinates")
    )
    parser.add_argument("--force", action="store_true", help=tr("replace an existing OUT"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio convert``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    UsageError
        If an option does not apply to the input.
    InputError, TargetError
        If a file cannot be read or written.
    """
    target = Path(args.output)
    if target.suffix.lower() in _CAMERA_SUFFIXES and _may_be_cameras(Path(args.input)):
        _convert_cameras(args, out)
        return
    if args.world:
        raise UsageError(Finding("option.requires", option="--world", other=tr("cameras")))
    from vomstudio.core.files.atomic import check_target
    from vomstudio.core.findings import unique_findings
    from vomstudio.geometry.registration_frames import change_file_frame
    from vomstudio.io.models.frames import establish_frame, stored_registration
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.opening import read_model
    from vomstudio.io.models.writing import choose_writer, write_model

    choose_writer(target)
    check_target(target, force=args.force, inputs=[args.input])
    options = frame_options(args)
    if options.up == "z":
        # This reverses the rotation of a format that is Y-up by definition
        # (`_transform_to_metres`).
        options = replace(options, up=None)
    progress = report_reading(args, args.input)
    loaded_model = read_model(Path(args.input), progress, options)
    warnings: list[Finding] = list(loaded_model.warnings)
    crs, unit = loaded_model.crs, 1.0
    frame_result = establish_frame(loaded_model, options)
    warnings += frame_result.findings
    if crs is not None:
        unit = frame_result.frame.unit_m
    if args.unit is None and unit != 1.0:
        warnings.append(Finding("frame.crs-unit-kept", metres=unit))
    scale = METRES_PER_UNIT[args.unit] if args.unit and crs is None else 1.0
    stored_result = stored_registration(loaded_model, options)
    warnings += stored_result.findings
    data = _transform_to_metres(loaded_model, args.up, scale)
    registration = stored_result.registration
    if registration is not None:
        registration = change_file_frame(
            registration, _similarity_matrix(loaded_model, args.up, scale)
        )
    inputs = [loaded_model.path, *companions(loaded_model.path)]
    warnings += write_model(
        data,
        crs,
        target,
        force=args.force,
        inputs=inputs,
        progress=progress,
        axes=_axes(loaded_model, crs, args.unit, registration),
        registration=registration,
    )
    # The frame may also have reported an error of the registration.
    warnings = list(unique_findings(warnings))
    out.result({"in": args.input, "out": args.output, "crs": crs, "warnings": warnings})
    out.warn(warnings)
    out.text(
        tr("{output}: point cloud from {input}", output=args.output, input=args.input)
        if loaded_model.kind == "cloud"
        else tr("{output}: mesh from {input}", output=args.output, input=args.input)
    )


def _may_be_cameras(path: Path) -> bool:
    from vomstudio.io.photos.own_cameras.reading import EXTENSIONS

    return path.is_dir() or path.suffix.lower() in EXTENSIONS


def _convert_cameras(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.photogrammetry.inspect.camera_export import export_cameras

    first_option = frame_options(args).first_option
    if first_option is not None:
        finding = Finding("option.conflict", option=first_option, other=tr("cameras"))
        raise UsageError(finding, field=first_option)
    report_reading(args, args.input)
    result = export_cameras(args.input, args.output, world=args.world, force=args.force)
    out.result({"in": args.input, "out": args.output, **result.to_dict()})
    out.warn(result.warnings)
    out.text(
        tr_n(
            "{output}: {count} camera, {points} points",
            "{output}: {count} cameras, {points} points",
            result.photos,
            output=args.output,
            points=f"{result.points:,}",
        )
    )


def _axes(
    loaded_model: LoadedModel, crs: str | None, unit: str | None, registration: Registration | None
) -> Axes:
    """Return whether the axes of the model are in metres and whether north is known."""
    from vomstudio.geometry.units import Axes
    from vomstudio.io.photos.cameras_file import has_known_scale

    if registration is not None:
        return registration.frame.axes
    is_metric = crs is not None or has_known_scale(loaded_model.path) is True
    return Axes(
        metric=is_metric or unit is not None or loaded_model.unit_m is not None, north=is_metric
    )


def _transform_to_metres(
    loaded_model: LoadedModel, up: str | None, scale: float
) -> Mesh | PointCloud:
    """Scale a model to metres and rotate it according to ``--up``.

    For a Y-up format, "z" reverses the rotation that its reader has applied.
    """
    import numpy as np

    from vomstudio.geometry.mesh import Mesh

    data = loaded_model.data
    change_matrix = _similarity_matrix(loaded_model, up, scale)
    if np.array_equal(change_matrix, np.eye(4)):
        return data
    # Rotate about a point of the model so that large coordinates do not lose digits.
    centre, matrix = _pivot(loaded_model), change_matrix[:3, :3]
    if isinstance(data, Mesh):
        return replace(data, vertices=(data.vertices - centre) @ matrix.T + centre)
    normals = data.normals
    if normals is not None:
        normals = (normals @ (matrix / scale).T).astype(np.float32)
    return replace(
        data, points=(data.points - centre) @ matrix.T + centre, normals=normals, arrangement=None
    )


def _similarity_matrix(loaded_model: LoadedModel, up: str | None, scale: float) -> FloatArray:
    """Return the similarity (4, 4) from the coordinates as read to those of the output."""
    import numpy as np

    centre, rotation = _pivot(loaded_model), np.eye(3)
    if up == "y" and loaded_model.turned_about is None:
        rotation = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    elif up == "z" and loaded_model.turned_about is not None:
        rotation = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    change_matrix = np.eye(4)
    change_matrix[:3, :3] = rotation * scale
    change_matrix[:3, 3] = centre - change_matrix[:3, :3] @ centre
    return change_matrix


def _pivot(loaded_model: LoadedModel) -> FloatArray:
    import numpy as np

    return np.zeros(3) if loaded_model.turned_about is None else np.array(loaded_model.turned_about)
