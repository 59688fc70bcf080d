"""Results of a survey check: findings with reasons and numbers, and a verdict as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from vomstudio.core.findings import Finding
from vomstudio.core.results import OPTIONAL_IN_JSON, Result
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.plane_sizes import PlaneError, PlaneSizes
from vomstudio.geometry.units import length_text
from vomstudio.photogrammetry.survey.survey_resolution import expected_planes

_SEVERITY_ORDER = {"error": 0, "warning": 1, "info": 2}


@dataclass(frozen=True)
class PhotoFigures:
    """Figures of one photo, with None for unknown values.

    Parameters
    ----------
    name : str
    gsd_m : float
        Metres per pixel on the rock.
    blur : float
        Sigma of edges, pixels.
    views : float
        Before the alignment, the median number of photos that show a point of this photo; after it,
        the mean number that show its tie points.
    brightness, overlap : float
    oblique_deg : float
    gsd : float
        Pixel size in the unit of the model if this is not the metre.
    """

    name: str
    gsd_m: float | None = None
    blur: float | None = None
    views: float | None = None
    brightness: float | None = None
    overlap: float | None = None
    oblique_deg: float | None = None
    gsd: float | None = field(default=None, metadata=OPTIONAL_IN_JSON)


@dataclass(frozen=True)
class SurveyReport(Result):
    """Result of a check of photos.

    Parameters
    ----------
    stage : {"before", "after"}
        Whether the check was made before or after the alignment.
    assessment : tuple of Finding
        Suitability of the photos.
    verdict : str
        The assessment in sentences.
    next_time : tuple of str
        Advice for the next survey, the most important first.
    smallest_plane_m : float or None
        Size of the smallest plane worth measuring: 100 times the resolution.
    plane_error : tuple of PlaneError
        Expected errors of planes of several sizes; empty if no pixel size is known.
    gsd, smallest_plane : float or None
        Values in the unit of the model if this is not the metre.
    """

    stage: str
    photos: tuple[PhotoFigures, ...]
    findings: tuple[Finding, ...]
    assessment: tuple[Finding, ...]
    gsd_m: float | None = None
    smallest_plane_m: float | None = None
    next_time: tuple[str, ...] = field(default=())
    plane_error: tuple[PlaneError, ...] = ()
    gsd: float | None = field(default=None, metadata=OPTIONAL_IN_JSON)
    smallest_plane: float | None = field(default=None, metadata=OPTIONAL_IN_JSON)
    verdict: str = ""

    def __post_init__(self) -> None:
        if not self.verdict:
            object.__setattr__(self, "verdict", " ".join(map(str, self.assessment)))


def sort_by_severity(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Sort findings by severity, errors first, keeping the order of equal ones."""
    return tuple(sorted(findings, key=lambda finding: _SEVERITY_ORDER[finding.severity]))


ADVICE = {
    "one-photo": to_translate(
        "Take at least five photos of every part of the rock, from different positions."
    ),
    "few-photos": to_translate("Take more photos: five or more of every part of the rock."),
    "parts": to_translate(
        "Close the gaps between the disconnected components with photos that overlap each of them"
        " by 60 %."
    ),
    "unmatched": to_translate(
        "Take photos with 60 to 80 % overlap, at a constant distance and in constant light."
    ),
    "low-overlap": to_translate("Take smaller steps between photos, for 60 to 80 % overlap."),
    "few-views": to_translate(
        "Take smaller steps between photos, so that five of them show every part."
    ),
    "one-direction": to_translate(
        "To prevent doming, add a second set of oblique photos from other positions, 20 to 30"
        " degrees off the perpendicular."
    ),
    "same-position": to_translate("Move between photos: take one photo from each position."),
    "collinear": to_translate("Add photos from beside or above the line of camera positions."),
    "blurred": to_translate(
        "Hold the camera still or use a tripod, use a shorter exposure, and focus on the rock."
    ),
    "soft": to_translate(
        "Come closer instead of zooming digitally, and use the camera's largest image size."
    ),
    "digital-zoom": to_translate("Come closer instead of zooming digitally."),
    "enlarged": to_translate("Use the camera's original files."),
    "exposure": to_translate("Expose for the rock, and check the photos on site."),
    "brightness-jump": to_translate(
        "Keep the exposure fixed, and take all photos in one period of constant light."
    ),
    "light-changed": to_translate("Take all photos in one period of constant light."),
    "focal-vague": to_translate(
        "Keep the camera's original files with their EXIF data, and add oblique photos, 20 to 30"
        " degrees off the perpendicular."
    ),
    "gsd-spread": to_translate(
        "Keep the distance constant, or add photos at intermediate distances."
    ),
    "gps-equal": to_translate(
        "Place control points or a scale bar, because these positions cannot register a model."
    ),
    "rotation": to_translate(
        "Place at least four control points, spread over the whole outcrop and not collinear."
    ),
    "control-unused": to_translate(
        "Mark at least four control points that are not collinear, each in four or more photos."
    ),
    "mark-scatter": to_translate("Mark the centre of every control point at full zoom."),
    "gps-noise": to_translate(
        "Place at least four control points, because these positions cannot orient the model."
    ),
}
"""Advice for the next survey, by the code of a finding."""


def collect_advice(findings: Sequence[Finding]) -> tuple[str, ...]:
    """Return the advice for each warning and error, the most important first."""
    sentences = [
        tr(ADVICE[f.code])
        for f in sort_by_severity(findings)
        if f.severity != "info" and f.code in ADVICE
    ]
    return tuple(dict.fromkeys(sentences))


def assess(
    findings: Sequence[Finding],
    gsd_m: float | None,
    *,
    is_metric: bool = True,
    planes: PlaneSizes | None = None,
    hint: Sequence[Finding] = (),
) -> tuple[Finding, ...]:
    """Assess the suitability of the photos in two or three findings for a geologist.

    is_metric : whether sizes are in metres instead of units of the model
    gsd_m : median pixel size on the rock; if None, `hint` is appended
    planes : plane sizes for the resolution of the model; if None, the photos' pixel size is used
    """
    errors = [f for f in findings if f.severity == "error"]
    warnings = [f for f in findings if f.severity == "warning"]
    serious_findings = [*errors, *warnings]
    reasons = ", ".join(
        dict.fromkeys(
            tr(_SHORT_NAMES[f.code]) if f.code in _SHORT_NAMES else f.code
            for f in serious_findings[:3]
        )
    )
    if len(serious_findings) > 3:
        reasons = tr("{reasons} and {count} more", reasons=reasons, count=len(serious_findings) - 3)
    codes = [f.code for f in serious_findings]
    if errors:
        verdict = Finding("survey.incomplete", reasons=reasons, codes=codes)
    elif warnings:
        verdict = Finding("survey.reservations", reasons=reasons, codes=codes)
    else:
        verdict = Finding("survey.sound")
    if planes is not None:
        size = length_text(planes.resolution, 2, is_metric=is_metric)
        resolution_finding = Finding("survey.model-resolution", size=size)
        return (
            verdict,
            resolution_finding,
            expected_planes(planes, is_metric=is_metric, source="model"),
        )
    if gsd_m is not None:
        size_finding = Finding(
            "survey.pixel-size", pixel=length_text(gsd_m, 2, is_metric=is_metric)
        )
        return (
            verdict,
            size_finding,
            expected_planes(PlaneSizes.from_pixel_size(gsd_m), is_metric=is_metric),
        )
    return verdict, *hint


_SHORT_NAMES = {
    "one-photo": to_translate("a single photo"),
    "few-photos": to_translate("too few photos"),
    "damaged": to_translate("damaged photos"),
    "parts": to_translate("disconnected components"),
    "unmatched": to_translate("photos without matches"),
    "low-overlap": to_translate("too little overlap"),
    "few-views": to_translate("too few photos per point"),
    "one-direction": to_translate("a single view direction (risk of doming)"),
    "same-position": to_translate("several photos from one position"),
    "collinear": to_translate("collinear camera positions"),
    "blurred": to_translate("blurred photos"),
    "soft": to_translate("low sharpness in all photos"),
    "digital-zoom": to_translate("digital zoom"),
    "enlarged": to_translate("enlarged photos"),
    "exposure": to_translate("black or overexposed photos"),
    "brightness-jump": to_translate("jumps in brightness"),
    "light-changed": to_translate("changing light"),
    "gsd-spread": to_translate("very different pixel sizes"),
    "focal-vague": to_translate("a poorly constrained focal length"),
    "gps-equal": to_translate("unusable GPS positions"),
    "gps-noise": to_translate("GPS too inaccurate for the scene"),
    "unregistered": to_translate("photos without a pose"),
    "rotation": to_translate("an uncertain orientation"),
    "control-unused": to_translate("unusable control points"),
    "gps-unused": to_translate("unusable GPS positions"),
    "mark-scatter": to_translate("scattered marks of control points"),
    "weak-photos": to_translate("weakly connected photos"),
    "weak-poses": to_translate("uncertain poses"),
    "high-error": to_translate("large residuals"),
}
