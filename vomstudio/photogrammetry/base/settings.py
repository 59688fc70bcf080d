"""Settings of a reconstruction."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.results import Result
from vomstudio.photogrammetry.base.region import Region


@dataclass(frozen=True)
class Quality:
    """align_px : long side of the photos in which features are sought
    dense_px : long side of the photos whose pixels get a depth
    faces : of the mesh at most
    page_px : side of a texture page; pages : at most
    """

    align_px: int
    dense_px: int
    faces: int
    page_px: int
    pages: int


QUALITIES = {
    "preview": Quality(1200, 640, 60_000, 2048, 1),
    "low": Quality(1600, 1000, 150_000, 4096, 1),
    "medium": Quality(2000, 1600, 300_000, 4096, 4),
    "high": Quality(3200, 3200, 1_500_000, 8192, 8),
}


DEVICES = ("auto", "cpu", "cuda")


@dataclass(frozen=True)
class Settings(Result):
    """quality : one of QUALITIES
    crs : "EPSG:n" of the model; None for the UTM zone of the cameras, where they have GPS
    control, marks : tables of ground control points and where they are seen in the photos; marks
        of other labels tie photos together
    threads : None for as many as there are processors; with 1, the same seed gives the same model
    device : one of DEVICES, on which depth maps are computed; "auto" takes the GPU where the
        installed COLMAP can use one
    region : lowest and highest corner of the part of which a model is made, in its frame; None for
        all
    """

    quality: str = "medium"
    crs: str | None = None
    control: Path | None = None
    marks: Path | None = None
    threads: int | None = None
    seed: int = 0
    device: str = "auto"
    region: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Raises UsageError for a quality or a device that there is not, and a region that is no
        box."""
        if self.quality not in QUALITIES:
            raise UsageError(
                Finding("option.not-a-choice", value=self.quality, choices=list(QUALITIES)),
                field="quality",
            )
        if self.device not in DEVICES:
            raise UsageError(
                Finding("option.not-a-choice", value=self.device, choices=list(DEVICES)),
                field="device",
            )
        if self.threads is not None and self.threads < 1:
            raise UsageError(
                Finding("option.too-small", value=self.threads, minimum=1), field="threads"
            )
        Region.of(self.region)

    @property
    def steps(self) -> Quality:
        """Sizes and numbers of the chosen quality."""
        return QUALITIES[self.quality]
