"""Options of reconstructions, declared once for all interfaces of the program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate

Quality = Literal["preview", "low", "medium", "high"]


@dataclass(frozen=True)
class ReconstructOptions(Options):
    """Options for the quality, control points and computers of a reconstruction.

    Raises
    ------
    UsageError
        If a value is out of bounds, or the region does not consist of six numbers.
    """

    quality: Quality = option(
        "medium",
        label=to_translate("Quality"),
        help=to_translate("fraction of the photo resolution to use"),
        tip=to_translate("Fraction of the photo resolution to use"),
        titles=(
            to_translate("Preview"),
            to_translate("Low"),
            to_translate("Medium"),
            to_translate("High"),
        ),
        choice_tips=(
            to_translate("takes minutes; for testing the photos"),
            to_translate("depth maps of 1000 pixels"),
            to_translate("depth maps of 1600 pixels"),
            to_translate("depth maps of 3200 pixels; takes hours"),
        ),
    )
    gcp: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "control points: CSV (label,x,y,z[,sigma][,use]), XML from MicMac or Metashape, or"
            " OpenDroneMap's gcp_list.txt; none: use no control points"
        ),
        automatic_text=to_translate(
            "control.csv in or next to the photo folder, if enough of its points are marked"
        ),
    )
    marks: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "marks of the control points: CSV label,photo,x,y, or XML from MicMac; other labels"
            " are tie points"
        ),
        automatic_text=to_translate(
            "in the control point file, otherwise marks.csv next to it or in the photo folder"
        ),
    )
    crs: str | None = option(
        None,
        metavar="EPSG",
        help=to_translate("coordinate reference system of the model, such as EPSG:32615"),
    )
    scheduler: str | None = option(
        None,
        metavar="ADDRESS",
        label=to_translate("Cluster"),
        help=to_translate("use the Dask cluster with this scheduler"),
        tip=to_translate("Address of the scheduler of a Dask cluster"),
        empty_text=to_translate("None, or tcp://computer:8786"),
    )
    threads: int | None = option(
        None,
        minimum=1,
        maximum=4096,
        label=to_translate("Threads"),
        help=to_translate("number of threads on this computer"),
        tip=to_translate("Number of threads; fewer need less memory"),
        automatic_text=to_translate("all processors"),
    )
    seed: int = option(
        0,
        minimum=0,
        maximum=2**31 - 1,
        label=to_translate("Seed"),
        tip=to_translate("With one thread, the same seed gives the same model"),
        help=to_translate(
            "seed of the random numbers; with --threads 1, the same seed gives the same model"
        ),
    )
    device: Literal["auto", "cpu", "cuda"] = option(
        "auto",
        label=to_translate("Device"),
        help=to_translate(
            "processor for depth maps; auto: a GPU if the installed COLMAP supports it"
        ),
        tip=to_translate("Processor for depth maps"),
        titles=(to_translate("Automatic"), to_translate("Processor"), to_translate("NVIDIA GPU")),
    )
    region: str | None = option(
        None,
        metavar="x0,y0,z0,x1,y1,z1",
        label=to_translate("Region"),
        help=to_translate("reconstruct only this box, in the frame of the model"),
        tip=to_translate("Box as x0,y0,z0,x1,y1,z1 in the frame of the model"),
        empty_text=to_translate("Whole outcrop"),
    )
    keep_background: bool = option(
        False,
        label=to_translate("Keep background"),
        help=to_translate("also reconstruct the background far behind the rock"),
        tip=to_translate("Also reconstruct the background far behind the rock"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if (box := self.box) is not None:
            from vomstudio.photogrammetry.base.region import Region

            Region.of(box)

    @property
    def box(self) -> tuple[float, ...] | None:
        """Minimum and maximum corners of the region, or None if not given. Raises UsageError."""
        if self.region is None:
            return None
        try:
            return tuple(float(cell) for cell in self.region.split(","))
        except ValueError:
            raise UsageError(Finding("region.not-a-box"), field="--region") from None
