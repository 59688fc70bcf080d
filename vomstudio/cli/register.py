"""`vomstudio register`: a model placed by what is known of its place."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common import text_tables
from vomstudio.cli.common.arguments import Parser, Subparsers, add_command, add_output, progress_of
from vomstudio.cli.common.output import Output
from vomstudio.errors import UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from vomstudio.io.control.attitude_tables import AttitudeTable
    from vomstudio.io.control.observation_tables import Positions
    from vomstudio.io.models.reader import LoadedModel
    from vomstudio.io.photos.own_cameras.result import OwnCameras
    from vomstudio.registration.attitude_evidence import AttitudeMiss
    from vomstudio.registration.evidence import Evidence, Segment
    from vomstudio.registration.north import North
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
        ("--horizon", tr("table: photo, x1, y1, x2, y2: pixels of a level line")),
        ("--orientations", tr("orientation table with model_x, model_y, model_z (normals, lines)")),
        ("--gcp", tr("control points with coordinates; their marks are in it, or beside it")),
        ("--marks", tr("where the control points are marked in the photos")),
    ):
        parser.add_argument(option, metavar="FILE", help=said)
    parser.add_argument(
        "--model-cameras",
        metavar="FILE",
        help=tr("where the model's own cameras are: cameras.json, a sparse model of COLMAP, "
                "Metashape XML, reconstruction.json, shots.geojson (default: beside the model)"),
    )  # fmt: skip
    parser.add_argument(
        "--cameras",
        metavar="FILE",
        nargs="?",
        const=_BESIDE,
        help=tr("table: photo, x, y, z (or longitude, latitude, altitude), geo.txt, or a folder of "
                "photos with GPS; without FILE the photos where they are found"),
    )  # fmt: skip
    parser.add_argument(
        "--attitudes",
        metavar="FILE",
        nargs="?",
        const=_BESIDE,
        help=tr("table: photo, yaw, pitch, roll[, sigma_yaw, …, north], or a folder of photos that "
                "say how they were held; without FILE the photos where they are found"),
    )  # fmt: skip
    parser.add_argument(
        "--north",
        choices=("grid", "true", "magnetic"),
        default="grid",
        help=tr("what azimuths are counted from where a table does not say (default: grid)"),
    )
    parser.add_argument("--date", metavar="DAY", help=tr("of compass readings, for declination"))
    parser.add_argument(
        "--declination", metavar="DEG", help=tr("of magnetic north, east positive (default: IGRF)")
    )
    parser.add_argument(
        "--north-sigma",
        metavar="DEG",
        help=tr("how far a compass may be off for all photos alike, one sigma (default: 10)"),
    )
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
    _add_reference(parser)
    parser.add_argument("--crs", metavar="EPSG", help=tr("the projected CRS that it is placed in"))
    add_output(parser, tr("write the placed model"))


def _add_reference(parser: Parser) -> None:
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
    said: list[str] = []
    evidence, crs = _evidence(args, crs, loaded, said)
    fitted = _fitted(args, evidence, loaded, crs)
    if fitted is not None:
        crs = fitted.crs
        evidence.reference = fitted.fitted.observation
        said += fitted.warnings
    found = _solved(evidence, loaded)
    result: dict[str, Any] = found.as_dict()
    if fitted is not None:
        result["reference"] = fitted.as_dict()
    warnings = [*said, *_said_of_move(found, loaded, crs), *found.warnings]
    from vomstudio.registration.evidence import attitude_misses, bars_as_checks

    photos = attitude_misses(evidence, found)
    if photos:
        result["attitudes"] = [asdict(photo) for photo in photos]

    for name, error in bars_as_checks(evidence, found):
        warnings.append(
            tr("The scale bar {name} judges: the placed model shows it {error:.3g} m too long.",
               name=name, error=error)
            if error > 0
            else tr("The scale bar {name} judges: the placed model shows it {error:.3g} m too "
                    "short.", name=name, error=-error)
        )  # fmt: skip
    if args.output is not None:
        warnings += _written(args, found, loaded, crs, result)
    result["warnings"] = warnings
    out.result(result)
    out.warn(warnings)
    if fitted is not None:
        out.text(_fit_in_words(fitted))
    out.text(in_words(found))
    if photos:
        out.text(_of_photos(photos))


def _of_photos(photos: Sequence[AttitudeMiss]) -> str:
    rows = [
        [p.photo, *(text_tables.figures(v) for v in (p.yaw_deg, p.pitch_deg, p.roll_deg))]
        for p in photos
    ]
    heads = [tr("photo"), tr("yaw"), tr("pitch"), tr("roll")]
    return "\n" + text_tables.table(heads, ["", "°", "°", "°"], rows)


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
    # One point or two help the surfaces, but do not say where these begin.
    known = not (evidence.empty or evidence.too_few_alone)
    near = _solved(evidence, loaded) if known else None
    return fit_model(
        loaded, args.reference, near=near, crs=crs, stable=args.stable, progress=progress_of(args)
    )


def _fit_in_words(fitted: ReferenceFit) -> str:
    from vomstudio.registration.remarks import said_of_fitted

    found = fitted.fitted
    return said_of_fitted(found.places, found.overlap, found.rms_m, found.blocks, found.block_m)


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


def _said_of_move(found: Placed, loaded: LoadedModel | None, crs: str | None) -> list[str]:
    """How far a model is put from where its own file says that it is."""
    from vomstudio.registration.coordinate_checks import said_of_move

    if loaded is None or loaded.crs is None or not found.known.position:
        return []
    if crs is not None and crs != loaded.crs:
        return []
    extent = _extent(loaded)
    return said_of_move(extent, found(extent), loaded.crs)


def _evidence(
    args: argparse.Namespace, crs: str | None, loaded: LoadedModel | None, said: list[str]
) -> tuple[Evidence, str | None]:
    from vomstudio.io.control import observation_tables as tables
    from vomstudio.registration.camera_positions import in_metres
    from vomstudio.registration.coordinate_checks import said_of_area
    from vomstudio.registration.evidence import Evidence
    from vomstudio.registration.north import on_grid

    evidence = Evidence()
    if args.north_sigma is not None:
        evidence.north_doubt_deg = _angle(args.north_sigma, "--north-sigma")
    if args.marks is not None and args.gcp is None:
        raise UsageError(tr("Marks need their points: give --gcp too."), field="--marks")
    if args.cameras or args.attitudes or args.horizon or args.gcp:
        own = _own_cameras(args, loaded)
        evidence.views, evidence.centres = own.views, own.centres
        said += own.warnings
    if args.pairs is not None:
        evidence.pairs = tables.read_pairs(args.pairs)
    if args.gcp is not None:
        from vomstudio.cli.common.register_marks import marked_pairs

        evidence.pairs, crs = marked_pairs(args, evidence, crs, said)
    if args.scale_bars is not None:
        evidence.bars = tables.read_scale_bars(args.scale_bars)
    if args.horizon is not None:
        evidence.level = tables.read_level_lines(args.horizon)
    if args.orientations is not None:
        evidence.compass = tables.read_compass(args.orientations)
    place = None
    if evidence.pairs is not None:
        said += said_of_area(evidence.pairs.world, crs)
    if args.cameras is not None:
        evidence.positions, crs, place = in_metres(_positions(args, own), crs, said)
        said += said_of_area(evidence.positions.places, crs, converted=place is not None)
    north = _north(args, evidence, crs, place)
    if args.attitudes is not None:
        table = _held(args, own)
        said += table.notes
        evidence.attitudes = on_grid(table, north, said)
    evidence.lengths = [_segment(text, "--scale") for text in args.scale]
    evidence.azimuths = [_segment(text, "--azimuth") for text in args.azimuth]
    _turn_to_grid(args, evidence, north, said)
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


def _own_cameras(args: argparse.Namespace, loaded: LoadedModel | None) -> OwnCameras:
    """The cameras in the model's own frame."""
    from vomstudio.io.photos.cameras_file import FILE_NAME
    from vomstudio.io.photos.own_cameras.reading import find_own_cameras, read_own_cameras

    path = args.model_cameras
    if path is None:
        if args.model == "-":
            raise UsageError(
                tr(
                    "Photos can place a model that is there. Name it in place of -, or its cameras "
                    "with --model-cameras."
                ),
                field="MODEL",
            )
        path = find_own_cameras(args.model) or Path(args.model).with_name(FILE_NAME)
    return read_own_cameras(path, None if loaded is None else loaded.data.bounds)


def _positions(args: argparse.Namespace, own: OwnCameras) -> Positions:
    """Where the photos were taken: by a table, or by themselves."""
    from vomstudio.io.control.observation_tables import read_positions
    from vomstudio.registration.photo_evidence import positions_in

    if args.cameras == _BESIDE or Path(args.cameras).is_dir():
        return positions_in(_photos(args.cameras, own, "--cameras"))
    return read_positions(args.cameras)


def _held(args: argparse.Namespace, own: OwnCameras) -> AttitudeTable:
    """How the photos were held: by a table, or by themselves."""
    from vomstudio.io.control.attitude_tables import read_attitudes
    from vomstudio.registration.photo_evidence import attitudes_in

    if args.attitudes == _BESIDE or Path(args.attitudes).is_dir():
        return attitudes_in(_photos(args.attitudes, own, "--attitudes"), own.views)
    return read_attitudes(args.attitudes, args.north)


def _north(
    args: argparse.Namespace,
    evidence: Evidence,
    crs: str | None,
    place: tuple[float, float] | None,
) -> North:
    """What is known of north, and of where and when the readings were made."""
    import numpy as np

    from vomstudio.registration.north import North, parse_day, place_of

    known = [] if evidence.pairs is None else [evidence.pairs.world]
    known += [] if evidence.positions is None else [evidence.positions.places]
    if place is None and crs is not None and known:
        place = place_of(crs, np.concatenate(known))
    declination = None
    if args.declination is not None:
        declination = _angle(args.declination, "--declination", signed=True)
    day = None if args.date is None else parse_day(args.date)
    return North(crs, place, day, declination)


def _turn_to_grid(
    args: argparse.Namespace, evidence: Evidence, north: North, said: list[str]
) -> None:
    """Azimuths and compass readings from the north of the map."""
    from vomstudio.registration.north import turn_of

    if args.north == "grid" or not (evidence.azimuths or evidence.compass):
        return
    turn, sentence = turn_of(args.north, north, "--north")
    said.append(sentence)
    evidence.azimuths = [(a, b, (deg + turn) % 360.0) for a, b, deg in evidence.azimuths]
    evidence.compass_turn_deg = turn


def _angle(text: str, option: str, *, signed: bool = False) -> float:
    try:
        value = float(text.strip().rstrip("°").replace(",", "."))
    except ValueError:
        value = math.nan
    if not (abs(value) <= 180.0 and (signed or value > 0)):
        raise UsageError(
            tr("'{text}' is no angle in degrees that is possible here.", text=text[:40]),
            field=option,
        )
    return value


def _photos(given: str, own: OwnCameras, option: str) -> dict[str, Path]:
    """The photos of the model's cameras, in the folder that is given or where they are found."""
    from vomstudio.io.photos.own_cameras.photos import find_photos_of

    photos = find_photos_of(own, None if given == _BESIDE else Path(given))
    if not photos:
        raise UsageError(
            tr(
                "No photo of the model's cameras ({name}, …) was found. Name the folder of the "
                "photos, or a table.",
                name=next(iter(own.centres)),
            ),
            field=option,
        )
    return photos


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
        from vomstudio.cli.common.output import to_json
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
