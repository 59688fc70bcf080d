"""The last steps of a fit of a model to a reference, on all seven numbers of a similarity.

Why not Open3D's alone: it knows no scale from point to plane, and tells neither what each point
says nor in which directions the surfaces slide along each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.registration.by_model.planes import Places, Reference
from vomstudio.registration.similarity import Similarity, jacobians

_TUKEY = 4.685
"""95 % efficient where errors are normal (Holland & Welsch 1977)."""
_MAD = 1.4826
_STEPS = 40
_FEWEST = 60
_NOTHING = 1e-8
"""Share of the largest: less information is rounding."""
_ROUNDING = 1e-6
"""Of the radius: surfaces that are one and the same are moved by no less to see what they hold, or
only the rounding of their coordinates would answer."""
_NOISE = 0.5
"""Share of the information in a direction above which it is made up by the noise of normals."""
_TRIED = 0.3
"""In sigmas, the mean miss to which the model is moved to see how it is pulled back."""
_ANSWERS = 0.3
"""Share of what normals promise: in which it is pulled back by less is free."""


@dataclass(frozen=True, eq=False)
class Refined:
    """fit : model to World; about : (3,) World, the middle of what was used; size : m, its radius
    places : (k, 3) World, points that were used, miss : (k,) along the reference's normals
    moves : (k, 7) derivatives of the misses by the seven numbers, in units of `size`
    pull, slope : (k,) the robust loss's first and second derivatives
    sigma : robust, of the misses
    held : (7, d) see `determined`
    response : (d, d) by how much the sum of pulls in these directions changes where the model is
        moved along them: 1 and 0 if normals knew no noise and the surfaces no bend
    scale_response : (7,) change of turn, scale and shift (m) about `about` per relative error of a
        fixed scale; None if the scale was fitted
    """

    fit: Similarity
    about: FloatArray
    size: float
    places: FloatArray
    miss: FloatArray
    moves: FloatArray
    pull: FloatArray
    slope: FloatArray
    sigma: float
    held: FloatArray
    response: FloatArray
    scale_response: FloatArray | None = None

    @property
    def information(self) -> FloatArray:
        """(7, 7)"""
        return np.asarray((self.moves * self.slope[:, None]).T @ self.moves, np.float64)


def refine(
    model: Places,
    reference: Reference,
    start: Similarity,
    *,
    scale: bool,
    progress: Progress,
) -> Refined:
    """From a start at which the model lies within the reference's radius of it.

    scale : whether it is one of the unknowns
    Raises GeometryError where too little of the two overlaps, Cancelled through `progress`.
    """
    progress.stage(tr("Refining the fit"), _STEPS)
    fit = start
    for number in range(_STEPS):
        found = _look(model, reference, fit, scale)
        step = _newton(found)
        fit = _moved(fit, step, found.about, found.size)
        progress.step(number + 1)
        # In metres at the rim: a hundredth of what the mean of so many points is known to.
        if np.abs(step).max() * found.size < 0.01 * found.sigma / np.sqrt(len(found.miss)):
            break
    found = _look(model, reference, fit, scale)
    response = _response(model, reference, found, scale)
    values, axes = np.linalg.eigh((response + response.T) / 2.0)
    kept = axes[:, values > _ANSWERS]
    found = replace(found, held=found.held @ kept, response=kept.T @ response @ kept)
    if scale:
        return found
    return replace(found, scale_response=_scale_response(model, reference, found))


def _scale_response(model: Places, reference: Reference, result: Refined) -> FloatArray:
    """Return the response (7,) of a fit to a relative error of its fixed scale, numerically."""
    step = _TRIED * result.sigma / result.size
    ends = []
    for sign in (1.0, -1.0):
        scaled = _moved(result.fit, sign * step * np.eye(7)[3], result.about, result.size)
        there = _look(model, reference, scaled, False, result)
        ends.append(result.held.T @ (there.moves.T @ there.pull))
    pull_change = (ends[0] - ends[1]) / (2.0 * step)
    change = -result.held @ np.linalg.solve(result.response, pull_change)
    change[4:] *= result.size
    change[3] = 1.0
    return np.asarray(change, np.float64)


def _response(model: Places, reference: Reference, found: Refined, scale: bool) -> FloatArray:
    """(d, d) as told of `Refined`, by moving the model a little to and fro."""
    step = _TRIED * found.sigma * np.sqrt(len(found.miss))
    columns = []
    for way in found.held.T:
        ends = []
        for sign in (1.0, -1.0):
            fit = _moved(found.fit, sign * step * way, found.about, found.size)
            there = _look(model, reference, fit, scale, found)
            ends.append(found.held.T @ (there.moves.T @ there.pull))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.column_stack(columns) if columns else np.zeros((0, 0))


def _look(
    model: Places,
    reference: Reference,
    fit: Similarity,
    scale: bool,
    like: Refined | None = None,
) -> Refined:
    """What the places say at a similarity. like : with its middle, size and sigma"""
    met = reference.met(model, fit)
    if len(met.miss) < _FEWEST:
        raise GeometryError(Finding("reference.few-places", places=len(met.miss)))
    sigma = max(_MAD * float(np.median(np.abs(met.miss))), _ROUNDING * reference.radius)
    if like is not None:
        sigma = like.sigma
    # Points that miss by much more belong to what has changed, or to nothing.
    near = np.abs(met.miss) < _TUKEY * sigma
    places, miss, normal = met.places[near], met.miss[near], met.normal[near]
    about = places.mean(axis=0) if like is None else like.about
    size = max(float(np.sqrt(((places - about) ** 2).sum(axis=1).mean())), 1e-9)
    if like is not None:
        size = like.size
    units = np.array([1.0, 1.0, 1.0, 1.0, size, size, size])
    whole = jacobians(places - about) * units
    if not scale:
        whole[:, :, 3] = 0.0
    moves = np.einsum("nx,nxk->nk", normal, whole)
    share = np.minimum((miss / (_TUKEY * sigma)) ** 2, 1.0)
    pull = miss * (1.0 - share) ** 2
    slope = (1.0 - share) * (1.0 - 5.0 * share)
    # The information that a normal gets by its own noise alone.
    weight = slope * met.tilt[near]
    noise = np.einsum("n,nxk,nxl->kl", weight, whole, whole, optimize=True)
    noise -= (moves * weight[:, None]).T @ moves
    information = (moves * slope[:, None]).T @ moves
    held = determined(information, noise)
    return Refined(
        fit, about, size, places, miss, moves, pull, slope, sigma, held, np.eye(held.shape[1])
    )


def determined(information: FloatArray, noise: FloatArray) -> FloatArray:
    """(7, d) the directions that are determined, with information (7, 7) of 1 each and 0 between
    them. The others hold no more information than rounding, or mostly such as noise (7, 7) makes
    up."""
    values, axes = np.linalg.eigh(information)
    there = values > _NOTHING * max(values[-1], 1e-300)
    inside = axes[:, there] / np.sqrt(values[there])
    shares, turns = np.linalg.eigh(inside.T @ noise @ inside)
    kept = shares <= _NOISE
    return np.asarray(inside @ turns[:, kept], np.float64)


def _newton(found: Refined) -> FloatArray:
    """(7,) the change in units of the size; nothing in what is free.

    By Fisher scoring: the mean slope in place of each point's, which is negative of far ones.
    """
    moves = found.moves @ found.held
    if not moves.shape[1]:
        return np.zeros(7)
    weight = max(float(found.slope.mean()), 0.2)
    step = np.linalg.lstsq(weight * moves.T @ moves, moves.T @ found.pull, rcond=1e-12)[0]
    return -np.asarray(found.held @ step, np.float64)


def _moved(fit: Similarity, step: FloatArray, about: FloatArray, size: float) -> Similarity:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    grow = float(np.exp(np.clip(step[3], -0.5, 0.5)))
    shift = step[4:] * size
    return Similarity(
        fit.scale * grow,
        turn @ fit.rotation,
        grow * turn @ (fit.translation - about) + about + shift,
    )
