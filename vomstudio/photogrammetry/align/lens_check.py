"""Findings on focal lengths after the alignment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from vomstudio.core.findings import Finding

if TYPE_CHECKING:
    from vomstudio.photogrammetry.align.priors import Calibration

# Maximum relative error of a focal length; all depths have the same relative error.
_MAX_RELATIVE_ERROR = 0.05
_MIN_RELATIVE_DIFFERENCE = 0.04


def lens_findings(cameras: Sequence[Calibration]) -> list[Finding]:
    """Report focal lengths that are poorly determined or contradict EXIF."""
    vague_errors: dict[str, float] = {}
    wrong_changes: dict[str, float] = {}
    for camera in cameras:
        focal, sigma = camera.values[0], camera.sigma[0]
        if camera.exif_px is None:
            error = math.inf if camera.focal == "held" else sigma / focal
            # NaN counts as unknown.
            if not error <= _MAX_RELATIVE_ERROR:
                vague_errors |= dict.fromkeys(camera.photos, error)
        elif abs(camera.exif_px / focal - 1) > max(_MIN_RELATIVE_DIFFERENCE, 3 * sigma / focal):
            wrong_changes |= dict.fromkeys(camera.photos, camera.exif_px / focal - 1)
    findings = []
    if vague_errors:
        error = max(vague_errors.values())
        known_error = error if math.isfinite(error) else None
        findings.append(Finding("focal-vague", photos=tuple(vague_errors), value=known_error))
    if wrong_changes:
        worst_change = max(wrong_changes.values(), key=abs)
        percent = 100 * worst_change
        finding = Finding(
            "focal-wrong", photos=tuple(wrong_changes), value=worst_change, error_percent=percent
        )
        findings.append(finding)
    return findings
