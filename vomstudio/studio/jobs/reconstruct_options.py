"""Options of reconstructions, declared once for all interfaces of the program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import Options, option
from vomstudio.core.words import to_translate


@dataclass(frozen=True)
class ReconstructOptions(Options):
    """Options for the quality, control points and computers of a reconstruction.

    Raises
    ------
    UsageError
        If a value is out of bounds, or the region does not consist of six numbers.
    """

    quality: Literal["preview", "low", "medium", "high"] = option(
        "medium", help=to_translate("share of the photos' resolution that is used")
    )
    gcp: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "control points: CSV label,x,y,z[,sigma][,use], XML of MicMac or Metashape, or"
            " OpenDroneMap's gcp_list.txt; none does without"
        ),
        automatic=to_translate(
            "control.csv in or beside the folder of the photos, if enough of its points are marked"
        ),
    )
    marks: str | None = option(
        None,
        metavar="FILE",
        help=to_translate(
            "marks of the control points: CSV label,photo,x,y, or XML of MicMac; other labels are"
            " tie points"
        ),
        automatic=to_translate(
            "in the file of the points, else marks.csv beside it or in the folder of the photos"
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
        help=to_translate("use the Dask cluster of this scheduler"),
        tip=to_translate("Address of the scheduler of a Dask cluster"),
        empty_text=to_translate("None, or tcp://computer:8786"),
    )
    threads: int | None = option(
        None,
        minimum=1,
        maximum=4096,
        label=to_translate("Threads"),
        help=to_translate("threads on this computer"),
        tip=to_translate("Number of threads; fewer need less memory"),
        automatic=to_translate("all processors"),
    )
    seed: int = option(
        0,
        minimum=0,
        maximum=2**31 - 1,
        label=to_translate("Seed"),
        tip=to_translate("With one thread the same seed gives the same model"),
        help=to_translate(
            "seed of random numbers; with --threads 1 the same seed gives the same model"
        ),
    )
    device: Literal["auto", "cpu", "cuda"] = option(
        "auto",
        help=to_translate(
            "processor of the depth maps; auto: a GPU if the installed COLMAP can use one"
        ),
    )
    region: str | None = option(
        None,
        metavar="x0,y0,z0,x1,y1,z1",
        help=to_translate("make a model of this box only, in the frame of the model"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if (box := self.box) is not None:
            from vomstudio.photogrammetry.base.region import Region

            Region.of(box)

    @property
    def box(self) -> tuple[float, ...] | None:
        """Return the minimum and maximum corners of the region, or None. Raises UsageError."""
        if self.region is None:
            return None
        try:
            return tuple(float(cell) for cell in self.region.split(","))
        except ValueError:
            raise UsageError(Finding("region.not-a-box"), field="--region") from None
