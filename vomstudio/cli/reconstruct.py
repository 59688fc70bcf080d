"""`vomstudio reconstruct`: photos to a registered, textured model."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.cli.arguments import Subparsers, add_command, progress_of
from vomstudio.cli.output import Output
from vomstudio.errors import InputError, UsageError
from vomstudio.words import tr

if TYPE_CHECKING:
    from vomstudio.jobs.reconstruction_tasks import Reconstruction


def add_parser(subparsers: Subparsers) -> None:
    parser = add_command(
        subparsers, "reconstruct", run, help_=tr("Make a textured model of a folder of photos")
    )
    parser.add_argument("photos", metavar="PHOTOS", help=tr("folder of JPEG, TIFF or PNG photos"))
    parser.add_argument(
        "-o", "--output", metavar="DIR", required=True,
        help=tr("folder for the model; run again with the same one to go on where it stopped"),
    )  # fmt: skip
    parser.add_argument(
        "--quality",
        choices=["preview", "low", "medium", "high"],
        default="medium",
        help=tr("how much of the photos' resolution is used (default medium)"),
    )
    parser.add_argument(
        "--gcp",
        metavar="FILE",
        help=tr(
            "ground control: CSV label,x,y,z[,sigma][,use], XML of MicMac or Metashape, "
            "or OpenDroneMap's gcp_list.txt (default: control.csv in or beside the "
            "folder of the photos, where enough of its points are marked; none: do "
            "without)"
        ),
    )
    parser.add_argument(
        "--marks", metavar="FILE",
        help=tr("where the control is seen: CSV label,photo,x,y, or MicMac's XML (default: "
"in --gcp where that holds them, else marks.csv beside it, or in the folder "
"of the photos); labels that are not in --gcp are tie points"),
    )  # fmt: skip
    parser.add_argument("--crs", metavar="EPSG", help=tr("of the model, such as EPSG:32615"))
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help=tr("work on the Dask cluster of this scheduler")
    )
    parser.add_argument(
        "--threads", type=int, metavar="N", help=tr("of this machine (default: all processors)")
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", default=0,
        help=tr("of what is random; with --threads 1 the same seed gives the same model"),
    )  # fmt: skip


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.jobs.reconstruction_tasks import RECONSTRUCT, ReconstructionOrder
    from vomstudio.jobs.run_job import run_job

    photos, folder = Path(args.photos), Path(args.output)
    if not photos.is_dir():
        raise InputError(tr("is no folder of photos"), file=photos)
    if args.threads is not None and args.threads < 1:
        raise UsageError(tr("is 1 or more"), field="--threads")
    if folder.resolve() == photos.resolve():
        raise UsageError(tr("is the photos' own folder; name another"), field="--output")
    crs = None if args.crs is None else _crs(args.crs)
    control, marks, said = _control(args)
    order = ReconstructionOrder(
        photos.resolve(),
        folder.resolve(),
        args.quality,
        crs,
        control,
        marks,
        args.threads,
        args.seed,
        args.scheduler,
    )
    result = run_job(RECONSTRUCT, order, progress_of(args))
    result = replace(result, warnings=(*said, *result.warnings))
    out.result(result.as_dict())
    out.warn(result.warnings)
    out.text(_in_words(result))


def _crs(text: str) -> str:
    from vomstudio.io.gis.crs import parse_crs

    try:
        crs, metres = parse_crs(text)
    except InputError as error:
        raise UsageError(error.message, field="--crs") from error
    if metres != 1.0:
        raise UsageError(
            tr("is not in metres; choose one that is, such as a UTM zone"), field="--crs"
        )
    return crs


def _control(args: argparse.Namespace) -> tuple[Path | None, Path | None, list[str]]:
    """Tables of control points and of marks, and what there is to say about them."""
    from vomstudio.io.control.control_files import find_control, marks_beside
    from vomstudio.io.control.points import MARKS
    from vomstudio.io.photos.reading import photo_names
    from vomstudio.photogrammetry.place.mark_prediction import usable_tables

    named = None if args.marks is None else Path(args.marks).resolve()
    photos = Path(args.photos).resolve()
    with_photos = photos / MARKS
    if args.gcp is None or args.gcp.casefold() == "none":
        found, marks = find_control(photos) or (
            None,
            with_photos if with_photos.is_file() else None,
        )
        marks = named or marks
        _require_file(marks, "--marks")
        if args.gcp is not None:
            return None, marks, []
        names = [] if found is None else photo_names(photos)
        control, marks, why_not = usable_tables(found, marks, names)
        said = [f"{found}: not used. {why_not}"] if why_not else []
        return control, marks, said
    control = Path(args.gcp).resolve()
    marks = named
    _require_file(control, "--gcp")
    if marks is None and with_photos.is_file() and not marks_beside(control).is_file():
        marks = with_photos
    if marks is None and not (marks := marks_beside(control)).is_file():
        raise InputError(
            tr("there is no such file; name the marks with --marks"), file=marks, field="--marks"
        )
    _require_file(marks, "--marks")
    return control, marks, []


def _require_file(path: Path | None, field: str) -> None:
    if path is not None and not path.is_file():
        raise InputError(tr("there is no such file"), file=path, field=field)


def _in_words(result: Reconstruction) -> str:
    lines = [
        f"{result.registered} of {result.photos} photos placed, reprojection error "
        f"{result.reprojection_error_px:.2f} px",
        f"{result.dense_points:,} points, {result.faces:,} faces, frame {result.frame}",
        f"{result.mesh} ({sum(result.seconds.values()):.0f} s, {result.peak_memory_mb:.0f} MB)",
        f"report: {result.report}",
        f"the folder work beside it holds {result.work_mb:.0f} MB for another go and may be "
        "removed",
    ]
    return "\n".join(lines)
