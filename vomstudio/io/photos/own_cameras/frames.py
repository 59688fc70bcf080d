"""Selection of the frame in which the cameras of a file match its model.

Programs write cameras and models in several frames: with or without the transform of the project,
in map coordinates or minus an offset. Cameras face the model that was reconstructed from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.io.photos.own_cameras.result import ModelCameras, cameras_from_views

# Margin around the bounding box of the model on each side, relative to its size.
RELATIVE_MARGIN = 0.5
# Maximum distance of cameras from the model, in diagonals of its box.
MAX_DISTANCE_DIAGONALS = 50.0
MIN_FACING_SHARE = 0.2


@dataclass(frozen=True, eq=False)
class Candidate:
    """Cameras in one possible frame, with the name of the frame."""

    name: str
    views: Sequence[View]
    warnings: tuple[Finding, ...] = ()


def select_frame(
    path: Path, candidates: Sequence[Candidate], bounds: FloatArray | None
) -> ModelCameras:
    """Return the cameras in the frame in which the largest share of them faces the model.

    Parameters
    ----------
    path : Path
    candidates : sequence of Candidate
    bounds : (2, 3) float64 or None
        Lower-left and upper-right corners of the model. If None, the first candidate is selected.

    Raises
    ------
    InputError
        As for `cameras_from_views`.
    """
    selected_candidate, findings = candidates[0], list[Finding]()
    if bounds is not None:
        fractions = [facing_share(candidate.views, bounds) for candidate in candidates]
        best_frame = int(np.argmax(fractions))
        selected_candidate = candidates[best_frame]
        if fractions[best_frame] < MIN_FACING_SHARE:
            findings.append(not_facing_finding(path))
        elif len(candidates) > 1:
            findings.append(Finding("cameras.frame", file=path.name, frame=selected_candidate.name))
    return cameras_from_views(
        path, selected_candidate.views, None, (*selected_candidate.warnings, *findings)
    )


def not_facing_finding(path: Path) -> Finding:
    """Return the finding about cameras that do not face the model."""
    return Finding("cameras.not-looking", file=path.name)


def facing_share(views: Sequence[View], bounds: FloatArray) -> float:
    """Return the share of cameras whose axis meets the enlarged box (2, 3) of a model.

    The distance to the box must be at most `MAX_DISTANCE_DIAGONALS` of its diagonals.
    """
    if not len(views):
        return 0.0
    size = bounds[1] - bounds[0]
    diagonal = float(np.linalg.norm(size))
    if not (np.isfinite(diagonal) and diagonal > 0):
        return 0.0
    margin = np.maximum(RELATIVE_MARGIN * size, 0.1 * diagonal)
    low, high = bounds[0] - margin, bounds[1] + margin
    centres = np.array([view.centre for view in views])
    directions = np.array([view.direction for view in views])
    with np.errstate(divide="ignore", invalid="ignore"):
        low_distance, high_distance = (low - centres) / directions, (high - centres) / directions
    nearest_distance = np.nanmax(np.minimum(low_distance, high_distance), axis=1)
    last_distance = np.nanmin(np.maximum(low_distance, high_distance), axis=1)
    is_facing = (last_distance >= np.maximum(nearest_distance, 0.0)) & (
        nearest_distance <= MAX_DISTANCE_DIAGONALS * diagonal
    )
    return float(is_facing.mean())
