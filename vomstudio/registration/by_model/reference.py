"""A model fitted to a reference that stands where it should."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.results import HIDDEN
from vomstudio.core.words import tr
from vomstudio.registration.by_model.matching import match
from vomstudio.registration.by_model.planes import RADIUS, Places, Reference, thinned
from vomstudio.registration.by_model.refining import Refined, refine
from vomstudio.registration.by_model.subsets import Spread, spread_of
from vomstudio.registration.combined import Combined
from vomstudio.registration.similarity import Similarity

NAME = "reference"
_CAPTURE = 0.05
"""Of the reference's diagonal: within so much points may belong to each other at first."""
_MATCHED = 300_000
_SCALE_HELD = 1e-4
"""One sigma, relative, of a scale that is known beforehand."""
_LEAST_SHARE, _FEW_SHARE = 0.02, 0.3
_ROUNDING = 1e-6
"""Of the size of the model: misses that are smaller are the computer's."""
_INTO = 0.1
"""Part of a free direction, in units of the size, from which on it is named."""


@dataclass(frozen=True, eq=False)
class FittedToReference:
    """observation : for the adjustment, together with whatever else is known
    places : of the model that were used, each the mean of its points within radius_m; overlap :
        their share; rms_m : robust, of their misses
    blocks, block_m : into which the overlap was cut for the error
    free : what the surfaces leave free, in words; warnings : sentences
    """

    observation: Combined = field(metadata=HIDDEN)
    places: int
    radius_m: float
    overlap: float
    rms_m: float
    blocks: int
    block_m: float
    free: tuple[str, ...]
    warnings: tuple[Finding, ...] = field(metadata=HIDDEN)


def fit_to_reference(
    model: FloatArray,
    reference: FloatArray,
    start: Similarity,
    *,
    spacing: tuple[float, float],
    scale: bool,
    stable: BoolArray | None = None,
    scale_error: float | None = None,
    progress: Progress | None = None,
) -> FittedToReference:
    """By ICP from coarse to fine, then by all seven numbers, with errors from repeated subsets.

    model : (n, 3) in its own frame; reference : (m, 3) World, metres
    start : model to World, within a twentieth of the reference's size
    spacing : of the model and of the reference, metres; scale : whether it is unknown
    stable : (m,) the points of the reference that have stayed where they were; None for all
    scale_error : relative error of a scale that is not fitted, one sigma; None if not known. It is
        propagated to the errors of rotation and shift
    Raises GeometryError where they do not overlap, Cancelled through `progress`.
    """
    progress = progress or Silent()
    target = reference if stable is None else reference[stable]
    if not len(target):
        raise GeometryError(Finding("reference.nothing-stable"))
    radius = RADIUS * max(spacing)
    diagonal = float(np.linalg.norm(np.ptp(reference, axis=0)))
    farthest = max(_CAPTURE * diagonal, radius)
    _require_near(start(model), reference, farthest)
    some = thinned(model, spacing[0] / start.scale, _MATCHED)
    fit = match(some, target, start, farthest=farthest, nearest=radius, progress=progress)
    there = Reference(target, radius)
    for _ in range(2 if scale else 1):
        # By the scale that is found the model's points lie within the same radius.
        places = Places(model, radius / fit.scale)
        found = refine(places, there, fit, scale=scale, progress=progress)
        fit = found.fit
    share = len(found.miss) / max(places.count, 1)
    if share < _LEAST_SHARE:
        raise GeometryError(Finding("reference.little-overlap", share_percent=100.0 * share))
    spread = spread_of(found, radius)
    whitening = spread.whitening
    if not scale:
        held = np.zeros((1, 7))
        held[0, 3] = 1.0 / _SCALE_HELD
        whitening = np.vstack([whitening, held])
    free = _free(found, scale)
    return FittedToReference(
        Combined(
            [NAME],
            found.fit,
            found.about,
            whitening,
            found.size,
            scale_error=0.0 if scale else scale_error or 0.0,
            scale_response=found.scale_response,
        ),
        len(found.miss),
        radius,
        share,
        found.sigma,
        spread.blocks,
        spread.side_m,
        free,
        tuple(_findings(found, spread, share, free)),
    )


def _require_near(placed: FloatArray, reference: FloatArray, farthest: float) -> None:
    from scipy.spatial import cKDTree

    step = max(1, len(placed) // 5000)
    thin = reference[:: max(1, len(reference) // 200_000)]
    distance, _ = cKDTree(thin).query(placed[::step], distance_upper_bound=farthest)
    if np.isfinite(distance).mean() > _LEAST_SHARE:
        return
    apart = float(np.linalg.norm(placed.mean(axis=0) - reference.mean(axis=0)))
    raise GeometryError(Finding("reference.apart", apart_m=apart))


def _free(found: Refined, scale: bool) -> tuple[str, ...]:
    """What is not determined, in words."""
    wanted = 7 if scale else 6
    if found.held.shape[1] >= wanted:
        return ()
    numbers = [0, 1, 2, 4, 5, 6, *([3] if scale else [])]
    axes = np.linalg.svd((found.held.T @ found.information)[:, numbers])[2]
    null = axes[found.held.shape[1] :]
    reach = np.linalg.norm(null, axis=0)
    words = []
    if reach[3:6].max() > _INTO:
        words.append(tr("sliding along the surface"))
    if reach[:3].max() > _INTO:
        words.append(tr("a turn"))
    if scale and reach[6] > _INTO:
        words.append(tr("the scale"))
    return tuple(words)


def _findings(found: Refined, spread: Spread, share: float, free: tuple[str, ...]) -> list[Finding]:
    findings = []
    if free:
        findings.append(Finding("reference.little-relief", free=list(free)))
    if share < _FEW_SHARE:
        findings.append(Finding("reference.partial", share_percent=100.0 * share))
    # Rounding is alike, too.
    if spread.alike and found.sigma > _ROUNDING * found.size:
        findings.append(Finding("reference.bent", side_m=spread.side_m))
    return findings
