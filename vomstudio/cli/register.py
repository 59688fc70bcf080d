"""`vomstudio register`: a model placed by what is known of its place."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli import text_tables
from vomstudio.cli.arguments import Subparsers, add_command, add_output, progress_of
from vomstudio.cli.output import Output
from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from vomstudio.io.models.reader import LoadedModel
    from vomstudio.registration.evidence import Evidence, Segment
    from vomstudio.registration.results import Placed
    from vomstudio.workspace.reference_fitting import ReferenceFit

_BESIDE = "beside the model"
_FEW = 20_000


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers,
        "register",
        run,
        help_=tr("Place a model by points, cameras, compass readings or lengths"),
    )
    parser.add_argument(
        "model",
        metavar="MODEL",
        help=tr("model or cloud in any format that is read; - solves for the placement alone"),
    )
    for option, said in (
        ("--pairs", tr("table: label, model_x, model_y, model_z, x, y, z[, use, sigma_x, …]")),
        ("--scale-bars", tr("table: from, to, length_m[, sigma_m, use]; labels of the pairs")),
        ("--attitudes", tr("table: photo, yaw, pitch, roll[, sigma_yaw, …, north]")),
        ("--horizon", tr("table: photo, x1, y1, x2, y2: pixels of a level line")),
        ("--orientations", tr("orientation table with model_x, model_y, model_z (normals, lines)")),
        ("--gcp", tr("control points with coordinates; their marks are in it, or beside it")),
        ("--marks", tr("where the control points are marked in the photos")),
    ):
        parser.add_argument(option, metavar="FILE", help=said)
    parser.add_argument(
        "--cameras",
        metavar="FILE",
        nargs="?",
        const=_BESIDE,
        help=tr("table: photo, x, y, z (or longitude, latitude, altitude); without FILE the GPS "
                "positions of the photos"),
    )  # fmt: skip
    parser.add_argument(
        "--scale",
        metavar="X1,Y1,Z1,X2,Y2,Z2,METRES",
        action="append",
        default=[],
        help=tr("two places on the model, and the metres between them"),
    )
    parser.add_argument(
        "--azimuth",
        metavar="X1,Y1,Z1,X2,Y2,Z2,DEG",
        action="append",
        default=[],
        help=tr("two places on the model, and the azimuth from the first to the second"),
    )
    parser.add_argument(
        "--reference",
        metavar="MODEL",
        help=tr("fit it to this mesh or cloud of the same rock, which stands where it should"),
    )
    parser.add_argument(
        "--stable",
        metavar="MASK",
        help=tr("polygons, or a cloud, of the part of the reference that has not moved"),
    )
    parser.add_argument("--crs", metavar="EPSG", help=tr("the projected CRS that it is placed in"))
    add_output(parser, tr("write the placed model"))


def run(args: argparse.Namespace, out: Output) -> None:
    """Raises UsageError, InputError, GeometryError or TargetError."""
    from vomstudio.files.atomic import check_target
    from vomstudio.io.gis.crs import metric_crs

    crs = None if args.crs is None else metric_crs(args.crs, "--crs")
    loaded = None
    if args.model != "-":
        from vomstudio.io.models.opening import read_model

        if args.output is not None:
            from vomstudio.io.models.writing import choose_writer

            choose_writer(Path(args.output))
            check_target(args.output, force=args.force, inputs=[args.model])
        loaded = read_model(Path(args.model), progress_of(args))
    elif args.output is not None:
        check_target(args.output, force=args.force, inputs=[])
    evidence, crs = _evidence(args, crs)
    fitted = _fitted(args, evidence, loaded, crs)
    if fitted is not None:
        crs = fitted.crs
        evidence.reference = fitted.fitted.observation
    found = _solved(evidence, loaded)
    result: dict[str, Any] = found.as_dict()
    warnings = [*found.warnings]
    if fitted is not None:
        result["reference"] = fitted.as_dict()
        warnings = [*fitted.warnings, *warnings]
    from vomstudio.registration.evidence import bars_as_checks

    for name, error in bars_as_checks(evidence, found):
        warnings.append(
            tr("The scale bar {name} judges: the placed model shows it {error:+.3g} m too long.",
               name=name, error=error)
        )  # fmt: skip
    if args.output is not None:
        warnings += _written(args, found, loaded, crs, result)
    result["warnings"] = warnings
    out.result(result)
    out.warn(warnings)
    if fitted is not None:
        out.text(_fit_in_words(fitted))
    out.text(in_words(found))


def _fitted(
    args: argparse.Namespace, evidence: Evidence, loaded: LoadedModel | None, crs: str | None
) -> ReferenceFit | None:
    """By the reference, from where all else that is given would have the model."""
    if args.reference is None:
        if args.stable is not None:
            raise UsageError(
                tr("A mask needs the reference that it belongs to: give --reference too."),
                field="--stable",
            )
        return None
    from vomstudio.workspace.reference_fitting import fit_model

    if loaded is None:
        raise UsageError(
            tr("A reference can place a model that is there. Name it in place of -."), field="MODEL"
        )
    near = None if evidence.empty else _solved(evidence, loaded)
    return fit_model(
        loaded, args.reference, near=near, crs=crs, stable=args.stable, progress=progress_of(args)
    )


def _fit_in_words(fitted: ReferenceFit) -> str:
    found = fitted.fitted
    return tr(
        "Fitted to the reference at {places} places ({share:.0f} % of the model), which it misses "
        "by {rms:.3g} m (robust, 1 sigma); the error is that of {blocks} blocks of {side:.3g} m.",
        places=found.places,
        share=100.0 * found.overlap,
        rms=found.rms_m,
        blocks=found.blocks,
        side=found.block_m,
    )


def _solved(evidence: Evidence, loaded: LoadedModel | None) -> Placed:
    from vomstudio.registration.evidence import register

    return register(evidence, None if loaded is None else _extent(loaded))


def _extent(loaded: LoadedModel) -> npt.NDArray[np.float64]:
    """(n, 3) some points of the model, spread over all of it."""
    import numpy as np

    from vomstudio.geometry.mesh import Mesh

    data = loaded.data
    points = data.vertices if isinstance(data, Mesh) else data.points
    return np.asarray(points[:: max(1, len(points) // _FEW)], np.float64)


def _evidence(args: argparse.Namespace, crs: str | None) -> tuple[Evidence, str | None]:
    from vomstudio.io.control import observation_tables as tables
    from vomstudio.io.gis.crs import from_degrees
    from vomstudio.registration.evidence import Evidence

    evidence = Evidence(to_grid=None if crs is None else from_degrees(crs))
    if args.marks is not None and args.gcp is None:
        raise UsageError(tr("Marks need their points: give --gcp too."), field="--marks")
    if args.cameras or args.attitudes or args.horizon or args.gcp:
        evidence.views = _views(args)
    if args.pairs is not None:
        evidence.pairs = tables.read_pairs(args.pairs)
    if args.gcp is not None:
        evidence.pairs, crs = _marked(args, evidence, crs)
    if args.scale_bars is not None:
        evidence.bars = tables.read_scale_bars(args.scale_bars)
    if args.attitudes is not None:
        evidence.attitudes = tables.read_attitudes(args.attitudes)
    if args.horizon is not None:
        evidence.level = tables.read_level_lines(args.horizon)
    if args.orientations is not None:
        evidence.compass = tables.read_compass(args.orientations)
    if args.cameras == _BESIDE:
        evidence.positions = _gps(args)
    elif args.cameras is not None:
        evidence.positions = tables.read_positions(args.cameras)
    evidence.lengths = [_segment(text, "--scale") for text in args.scale]
    evidence.azimuths = [_segment(text, "--azimuth") for text in args.azimuth]
    for _, _, metres in evidence.lengths:
        if not metres > 0:
            raise UsageError(tr("A length must be positive. Correct it."), field="--scale")
    if evidence.empty and args.reference is None:
        raise UsageError(
            tr(
                "Nothing was given to place the model by. Give --pairs, --gcp, --cameras, "
                "--attitudes, --horizon, --orientations, --scale, --azimuth or --reference."
            )
        )
    return evidence, crs


def _cameras_file(args: argparse.Namespace) -> Path:
    from vomstudio.io.photos.cameras_file import FILE_NAME

    if args.model == "-":
        raise UsageError(
            tr("Photos can place a model that is there. Name it in place of -."), field="MODEL"
        )
    return Path(args.model).with_name(FILE_NAME)


def _views(args: argparse.Namespace) -> dict[str, Any]:
    """The cameras in the model's own frame."""
    import numpy as np

    from vomstudio.io.photos.cameras_file import read_cameras

    cameras = read_cameras(_cameras_file(args))
    origin = np.array(cameras.origin, np.float64)
    return {view.name: view.moved(1.0, np.eye(3), origin) for view in cameras.views}


def _gps(args: argparse.Namespace) -> Any:
    import numpy as np

    from vomstudio.io.control.observation_tables import Positions
    from vomstudio.io.photos.cameras_file import find_photos, read_cameras
    from vomstudio.io.photos.reading import read_photo

    path = _cameras_file(args)
    cameras = read_cameras(path)
    folder = find_photos(cameras, path)
    if folder is None:
        raise UsageError(
            tr("The photos of the model were not found. Give a table of camera positions."),
            field="--cameras",
        )
    names, places = [], []
    for view in cameras.views:
        photo = read_photo(folder / view.name)
        if photo.longitude_deg is not None and photo.latitude_deg is not None:
            names.append(view.name)
            height = 0.0 if photo.altitude_m is None else photo.altitude_m
            places.append((photo.longitude_deg, photo.latitude_deg, height))
    if not names:
        raise UsageError(
            tr("The photos have no GPS positions. Give a table of camera positions."),
            field="--cameras",
        )
    return Positions(tuple(names), np.array(places), True, np.full((len(names), 3), np.nan))


def _marked(
    args: argparse.Namespace, evidence: Evidence, crs: str | None
) -> tuple[Any, str | None]:
    """Control points with the places on the model that their marks in the photos show."""
    import numpy as np

    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_beside,
        read_control,
        read_marks,
    )
    from vomstudio.io.control.observation_tables import Pairs
    from vomstudio.registration.evidence import marked_places

    control = Path(args.gcp)
    points = read_control(control)
    crs = agreed_crs(control, crs)
    marks = read_marks(args.marks or marks_beside(control))
    evidence.marks = [(m.label, m.photo, m.x, m.y) for m in marks]
    places = marked_places(evidence, evidence.marks)
    seen = [p for p in points if p.label in places]
    sigma = [[p.sigma_m or math.nan] * 3 for p in seen]
    found = Pairs(
        tuple(p.label for p in seen),
        np.array([places[p.label] for p in seen]).reshape(-1, 3),
        np.array([p.position for p in seen], np.float64).reshape(-1, 3),
        np.array(sigma, np.float64).reshape(-1, 3),
        np.array([p.check for p in seen], bool),
    )
    if evidence.pairs is not None:
        found = evidence.pairs.with_more(found)
    return found, crs


def _segment(text: str, option: str) -> Segment:
    try:
        x1, y1, z1, x2, y2, z2, value = (float(cell) for cell in text.split(","))
    except ValueError as error:
        raise UsageError(
            tr(
                "'{text}' is not seven numbers with commas between them: x1,y1,z1,x2,y2,z2,value.",
                text=text[:60],
            ),
            field=option,
        ) from error
    if not all(map(math.isfinite, (x1, y1, z1, x2, y2, z2, value))):
        raise UsageError(tr("'{text}' is not finite.", text=text[:60]), field=option)
    return (x1, y1, z1), (x2, y2, z2), value


def _written(
    args: argparse.Namespace,
    found: Placed,
    loaded: LoadedModel | None,
    crs: str | None,
    result: dict[str, Any],
) -> list[str]:
    if loaded is None:
        from vomstudio.cli.output import to_json
        from vomstudio.files.atomic import write_bytes

        write_bytes(Path(args.output), (to_json(result) + "\n").encode(), force=args.force)
        return []
    from vomstudio.geometry.moving import moved
    from vomstudio.geometry.units import Axes
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import write_model

    known = found.known
    warnings = write_model(
        moved(loaded.data, found.matrix),
        crs if known.all else None,
        args.output,
        force=args.force,
        inputs=[loaded.path, *companions(loaded.path)],
        progress=progress_of(args),
        axes=Axes(metric=known.scale, north=known.north and known.vertical),
    )
    result["out"] = args.output
    return warnings


def in_words(found: Placed) -> str:
    """Two tables and sentences."""
    from vomstudio.registration.remarks import said_of_worst

    blocks = []
    for title, points in ((tr("control"), found.control), (tr("check"), found.check)):
        if points:
            rows = [
                [title, p.label, *(text_tables.figures(v) for v in (p.dx, p.dy, p.dz, p.error_m))]
                for p in points
            ]
            heads = [tr("use"), tr("label"), "dx", "dy", "dz", tr("error")]
            blocks.append(text_tables.table(heads, ["", "", "m", "m", "m", "m"], rows))
    return "\n".join([*blocks, *said_of_worst(found)])
