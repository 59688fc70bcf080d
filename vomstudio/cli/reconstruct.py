"""`vomstudio reconstruct`: photos to a registered, textured model."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from vomstudio.cli.common.arguments import Subparsers, add_command, progress_of
from vomstudio.cli.common.output import Output
from vomstudio.errors import UsageError
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
    parser.add_argument(
        "--device", choices=["auto", "cpu", "cuda"], default="auto",
        help=tr("for the depth maps (auto, the default: a GPU where the installed COLMAP has one)"),
    )  # fmt: skip
    parser.add_argument(
        "--region",
        metavar="x0,y0,z0,x1,y1,z1",
        help=tr("make a model of this box alone, in the frame of the model"),
    )


def run(args: argparse.Namespace, out: Output) -> None:
    from vomstudio.jobs.reconstruction_orders import order_reconstruction
    from vomstudio.jobs.reconstruction_tasks import RECONSTRUCT
    from vomstudio.jobs.run_job import run_job

    order, said = order_reconstruction(
        args.photos,
        args.output,
        quality=args.quality,
        control=args.gcp,
        marks=args.marks,
        crs=args.crs,
        scheduler=args.scheduler,
        threads=args.threads,
        seed=args.seed,
        device=args.device,
        region=_region(args.region),
    )
    result = run_job(RECONSTRUCT, order, progress_of(args))
    result = replace(result, warnings=(*said, *result.warnings))
    out.result(result.as_dict())
    out.warn(result.warnings)
    out.text(_in_words(result))


def _region(text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(cell) for cell in text.split(",")]
    except ValueError as error:
        raise UsageError(
            tr("A region is six numbers: x0,y0,z0,x1,y1,z1, its lowest and highest corner."),
            field="--region",
        ) from error


def _in_words(result: Reconstruction) -> str:
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
            "The folder “work” beside it holds {size:.0f} MB of intermediate results. It may be "
            "removed.",
            size=result.work_mb,
        ),
    ]
    return "\n".join(lines)
