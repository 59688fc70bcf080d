"""In which of several frames the cameras of a file and its model agree.

Programs write cameras in frames of their own, and models in another: with the transform of the
project or without, in map coordinates or less an offset. Cameras look at what was made of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.io.photos.own_cameras.result import OwnCameras, of_views

# The box of the model that cameras must look at is made so much larger on each side.
_WIDER = 0.5
# Cameras stand this many diagonals of the model from it at most.
_FAR = 50.0
_SOME = 0.2


@dataclass(frozen=True, eq=False)
class Candidate:
    """The same cameras in one frame; name : what it is called"""

    name: str
    views: Sequence[View]
    warnings: tuple[Finding, ...] = ()


def best_of(path: Path, candidates: Sequence[Candidate], bounds: FloatArray | None) -> OwnCameras:
    """The cameras in the first frame in which most of them look at the model.

    bounds : (2, 3) lowest and highest corner of the model; None takes the first candidate.
    Raises InputError as `of_views`.
    """
    chosen, said = candidates[0], list[Finding]()
    if bounds is not None:
        shares = [share_looking(candidate.views, bounds) for candidate in candidates]
        best = int(np.argmax(shares))
        chosen = candidates[best]
        if shares[best] < _SOME:
            said.append(not_looking(path))
        elif len(candidates) > 1:
            said.append(Finding("cameras.frame", file=path.name, frame=chosen.name))
    return of_views(path, chosen.views, None, (*chosen.warnings, *said))


def not_looking(path: Path) -> Finding:
    return Finding("cameras.not-looking", file=path.name)


def share_looking(views: Sequence[View], bounds: FloatArray) -> float:
    """The share of the cameras whose axis meets the widened box (2, 3) ahead of them and not too
    far away."""
    if not len(views):
        return 0.0
    size = bounds[1] - bounds[0]
    diagonal = float(np.linalg.norm(size))
    if not (np.isfinite(diagonal) and diagonal > 0):
        return 0.0
    margin = np.maximum(_WIDER * size, 0.1 * diagonal)
    low, high = bounds[0] - margin, bounds[1] + margin
    centres = np.array([view.centre for view in views])
    ahead = np.array([view.direction for view in views])
    with np.errstate(divide="ignore", invalid="ignore"):
        near, far = (low - centres) / ahead, (high - centres) / ahead
    first = np.nanmax(np.minimum(near, far), axis=1)
    last = np.nanmin(np.maximum(near, far), axis=1)
    meets = (last >= np.maximum(first, 0.0)) & (first <= _FAR * diagonal)
    return float(meets.mean())
