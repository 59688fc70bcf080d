"""Row of a photo in lists and plans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vomstudio.photogrammetry.survey.check_results import SurveyReport


@dataclass
class PhotoRow:
    """Row of a photo in lists and plans.

    Attributes
    ----------
    width, height : int
        Size in pixels, as stored.
    place : (float, float) or None
        Position (x, y) in plan view, in metres, or None if unknown.
    look_direction : (float, float) or None
        Unit vector of the horizontal viewing direction, or None if it is unknown or vertical.
    gsd_m : float or None
        Size of a pixel on the rock in metres, or None if unknown.
    gsd : float or None
        Size of a pixel on the rock in model units, for a model that is not in metres.
    blur : float or None
        Width of the sharpest edges in pixels, or None if unknown.
    views : float or None
        Mean number of photos that show the same rock, or None if unknown.
    mask, sidecar_mask : str or None
        Files of the mask in use and of the mask beside the photo.
    """

    name: str
    path: str
    width: int
    height: int
    camera: str
    focal: str
    taken: str
    has_gps: bool
    mask: str | None
    thumbnail: str | None = None
    place: tuple[float, float] | None = None
    look_direction: tuple[float, float] | None = None
    gsd_m: float | None = None
    blur: float | None = None
    views: float | None = None
    findings: list[str] = field(default_factory=list)
    sidecar_mask: str | None = None
    found_sha256: str = ""
    gsd: float | None = None


def add_findings(rows: Sequence[PhotoRow], report: SurveyReport) -> None:
    """Set the findings, pixel sizes, blur and views of photo rows from a survey check."""
    rows_by_name = {row.name: row for row in rows}
    for row in rows:
        row.findings = []
    for photo_check in report.photos:
        match = rows_by_name.get(photo_check.name)
        if match is not None:
            match.gsd_m, match.gsd, match.views = (
                photo_check.gsd_m,
                photo_check.gsd,
                photo_check.views,
            )
            if photo_check.blur is not None:
                match.blur = photo_check.blur
    for finding in report.findings:
        for name in finding.values["photos"]:
            if name in rows_by_name:
                rows_by_name[name].findings.append(finding.message)
