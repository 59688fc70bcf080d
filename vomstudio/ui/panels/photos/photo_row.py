"""One photo as lists and plans show it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vomstudio.photogrammetry.survey.check_results import SurveyReport


@dataclass
class PhotoRow:
    """width, height: pixels as stored. place: (x, y) metres in plan; looks: unit vector (dx, dy) of
    the horizontal viewing direction, None where unknown or vertical. gsd_m: metres of a pixel on
    the rock, gsd: units of a model without metres; blur: edge width in pixels; views: mean number
    of photos that see the same rock. found_mask: the mask that lies beside the photo; mask: the one
    that is used."""

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
    looks: tuple[float, float] | None = None
    gsd_m: float | None = None
    blur: float | None = None
    views: float | None = None
    findings: list[str] = field(default_factory=list)
    sidecar_mask: str | None = None
    found_sha256: str = ""
    gsd: float | None = None


def add_findings(rows: Sequence[PhotoRow], report: SurveyReport) -> None:
    """Enter into each row what a survey check has found about its photo."""
    rows_by_name = {row.name: row for row in rows}
    for row in rows:
        row.findings = []
    for facts in report.photos:
        match = rows_by_name.get(facts.name)
        if match is not None:
            match.gsd_m, match.gsd, match.views = facts.gsd_m, facts.gsd, facts.views
            if facts.blur is not None:
                match.blur = facts.blur
    for finding in report.findings:
        for name in finding.values["photos"]:
            if name in rows_by_name:
                rows_by_name[name].findings.append(finding.message)
