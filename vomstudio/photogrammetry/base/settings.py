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
    """Sizes that a quality level selects.

    Attributes
    ----------
    align_px : int
        Maximum long side of the photos for feature detection.
    dense_px : int
        Maximum long side of the photos for depth maps.
    faces : int
        Maximum number of faces of the mesh.
    page_px, pages : int
        Side of a texture page, and the maximum number of pages.
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
class PipelineSettings(Result):
    """Settings of a reconstruction.

    Attributes
    ----------
    quality : str
        One of QUALITIES.
    crs : str or None
        CRS of the model, "EPSG:n". If None, the UTM zone of the cameras with GPS.
    control, marks : Path or None
        Tables of ground control points and of their marks in the photos. Marks with other labels
        tie photos together.
    threads : int or None
        Number of threads; None uses all processors. With 1, the same seed gives the same model.
    device : str
        Device that computes the depth maps, one of DEVICES; "auto" selects the GPU if the installed
        COLMAP supports it.
    region : tuple or None
        Minimum and maximum coordinates of the region to reconstruct, in the frame of the model. If
        None, everything is reconstructed.
    keep_background : bool
        Whether to reconstruct the background far behind the rock. Ignored if `region` is given.
    """

    quality: str = "medium"
    crs: str | None = None
    control: Path | None = None
    marks: Path | None = None
    threads: int | None = None
    seed: int = 0
    device: str = "auto"
    region: tuple[float, ...] | None = None
    keep_background: bool = False

    def __post_init__(self) -> None:
        """Check the values.

        Raises
        ------
        UsageError
            If the quality or the device is unknown, `threads` is less than 1, or the region is
            invalid.
        """
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
    def quality_sizes(self) -> Quality:
        """Sizes that the selected quality level defines."""
        return QUALITIES[self.quality]
