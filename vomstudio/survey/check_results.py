"""What a survey check has to say: findings with reasons and numbers, and a verdict in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

Severity = Literal["info", "warning", "error"]
_ORDER = {"error": 0, "warning": 1, "info": 2}


@dataclass(frozen=True)
class Finding:
    """code : one word for programs; photos : names of those it is about, empty where it is about
    all; text : what was found, why it matters, and what to do; value : the number it rests on"""

    code: str
    severity: Severity
    photos: tuple[str, ...]
    text: str
    value: float | None = None

    def as_dict(self) -> dict[str, Any]:
        return {
            "code": self.code,
            "severity": self.severity,
            "photos": list(self.photos),
            "text": self.text,
            "value": self.value,
        }


@dataclass(frozen=True)
class PhotoFigures:
    """gsd_m : metres per pixel on the rock; blur : sigma of edges, pixels; views : median number of
    photos that see a place of it (before), or mean number that see its tie points (after)"""

    name: str
    gsd_m: float | None = None
    blur: float | None = None
    views: float | None = None
    brightness: float | None = None
    overlap: float | None = None
    oblique_deg: float | None = None

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "gsd_m": self.gsd_m,
            "blur": self.blur,
            "views": self.views,
            "brightness": self.brightness,
            "overlap": self.overlap,
            "oblique_deg": self.oblique_deg,
        }


@dataclass(frozen=True)
class SurveyReport:
    """stage : "before" or "after" the alignment; next_time : what to shoot, the gravest first"""

    stage: str
    photos: tuple[PhotoFigures, ...]
    findings: tuple[Finding, ...]
    verdict: str
    gsd_m: float | None = None
    smallest_plane_m: float | None = None
    next_time: tuple[str, ...] = field(default=())

    def as_dict(self) -> dict[str, Any]:
        return {
            "stage": self.stage,
            "photos": [photo.as_dict() for photo in self.photos],
            "findings": [finding.as_dict() for finding in self.findings],
            "verdict": self.verdict,
            "gsd_m": self.gsd_m,
            "smallest_plane_m": self.smallest_plane_m,
            "next_time": list(self.next_time),
        }


def ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Errors first; otherwise as they were found."""
    return tuple(sorted(findings, key=lambda finding: _ORDER[finding.severity]))


NEXT_TIME = {
    "one-photo": "take at least five photos of every part of the rock, from different places",
    "few-photos": "take more photos: five or more of every part of the rock",
    "parts": "close the gaps between the parts with photos that overlap both by 60 %",
    "unmatched": "take photos with 60 to 80 % overlap, at steady distance and light",
    "low-overlap": "step less far between photos: 60 to 80 % overlap",
    "few-views": "step less far between photos, so that five of them see every place",
    "one-direction": (
        "add a second set of photos turned 20 to 30 degrees to the first, from other places, "
        "against doming"
    ),
    "same-position": "move between photos: one position, one photo",
    "collinear": "add photos from beside or above the line of camera positions",
    "blurred": "hold still or use a tripod, a shorter exposure, and focus on the rock",
    "soft": "come closer instead of zooming digitally, and use the camera's largest pictures",
    "digital-zoom": "come closer instead of zooming digitally",
    "enlarged": "use the camera's original files",
    "exposure": "expose for the rock, and look at the pictures on the spot",
    "brightness-jump": "keep to one exposure, and to one window of time with steady light",
    "light-changed": "keep to one window of time with steady light",
    "focal-vague": (
        "keep the camera's own files with their EXIF, and add photos turned 20 to 30 degrees"
    ),
    "gsd-spread": "keep to one distance, or bridge the two with photos in between",
    "gps-equal": "lay out control points or a scale bar: these positions cannot register anything",
    "gps-noise": "lay out at least four control points: these positions cannot orient the model",
}


def next_time(findings: Sequence[Finding]) -> tuple[str, ...]:
    """What to do differently, for warnings and errors."""
    said = [
        NEXT_TIME[f.code]
        for f in ordered(findings)
        if f.severity != "info" and f.code in NEXT_TIME
    ]  # fmt: skip
    return tuple(dict.fromkeys(said))


def verdict_of(
    findings: Sequence[Finding], gsd_m: float | None, unit: str = "m", *, hint: str = ""
) -> str:
    """One or two sentences for a geologist."""
    from vomstudio.survey.photo_limits import smallest_plane

    errors = [f for f in findings if f.severity == "error"]
    warnings = [f for f in findings if f.severity == "warning"]
    if errors:
        first = "These photos will not give a whole model"
    elif warnings:
        first = "These photos can give a model, with reservations"
    else:
        first = "These photos should give a sound model"
    grave = [*errors, *warnings]
    if grave:
        first += ": " + ", ".join(dict.fromkeys(_SHORT.get(f.code, f.code) for f in grave[:3]))
        if len(grave) > 3:
            first += f" and {len(grave) - 3} more"
    if gsd_m is not None:
        second = (
            f"One pixel covers {length(gsd_m, unit)}, so that planes down to about "
            f"{length(smallest_plane(gsd_m), unit)} across can be measured (1000 pixels)"
        )
    else:
        second = hint
    return f"{first}. {second}." if second else f"{first}."


_SHORT = {
    "one-photo": "a single photo",
    "few-photos": "too few photos",
    "damaged": "damaged photos",
    "parts": "photos that fall into parts",
    "unmatched": "photos that match no other",
    "low-overlap": "too little overlap",
    "few-views": "too few photos of each place",
    "one-direction": "one view direction, hence a risk of doming",
    "same-position": "several photos from one position",
    "collinear": "cameras in one line",
    "blurred": "blurred photos",
    "soft": "soft pixels",
    "digital-zoom": "digital zoom",
    "enlarged": "enlarged photos",
    "exposure": "black or burnt photos",
    "brightness-jump": "jumps of exposure",
    "light-changed": "changing light",
    "gsd-spread": "very different pixel sizes",
    "focal-vague": "a focal length that is not known",
    "gps-equal": "useless GPS",
    "gps-noise": "GPS too coarse for the scene",
    "unregistered": "photos that could not be placed",
    "weak-photos": "weakly tied photos",
    "high-error": "large residuals",
}


def length(value: float, unit: str = "m") -> str:
    """A length as people say it: `3.2 mm`, `1.8 m`; figures of a local frame keep their unit."""
    if unit != "m":
        return f"{value:.3g} {unit}"
    for factor, name in ((1e3, "mm"), (1e2, "cm"), (1.0, "m")):
        if value * factor < 100 or name == "m":
            return f"{value * factor:.2g} {name}" if value * factor < 100 else f"{value:.0f} m"
    return f"{value:g} m"


def named(names: Sequence[str]) -> str:
    """`a.jpg, b.jpg and 3 more`."""
    if len(names) <= 3:
        return ", ".join(names)
    return f"{', '.join(names[:2])} and {len(names) - 2} more"
