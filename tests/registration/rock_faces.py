"""A rough wall that faces south, sampled twice: for the fit of one model to another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from vomstudio.registration.by_model.reference import ModelFit, fit_to_reference
from vomstudio.registration.placing import place
from vomstudio.registration.results import ModelPlacement
from vomstudio.registration.similarity import Similarity

Array = npt.NDArray[np.float64]
Relief = Callable[[Array], Array]


def ledges(flat: Array) -> Array:
    """How far a place of the wall stands out, metres."""
    x, y = flat.T
    steps = 0.5 * np.abs((0.8 * y + 0.3 * x) % 2.0 - 1.0)
    return np.asarray(0.8 * np.sin(0.7 * x) + steps + 0.1 * np.sin(5 * x) * np.cos(4 * y))


def smooth(flat: Array) -> Array:
    return np.zeros(len(flat))


def sampled(
    n: int, rng: np.random.Generator, noise: float, size: float = 20.0, relief: Relief = ledges
) -> Array:
    """(n, 3) World, at random over the wall."""
    flat = rng.uniform(0.0, size, (n, 2))
    out = relief(flat) + rng.normal(0.0, noise, n)
    return np.column_stack([flat[:, 0], -out, flat[:, 1]])


@dataclass(frozen=True)
class Case:
    """n, noise : of the model and of the reference; scale : unknown, and wrong by 2 %"""

    n: tuple[int, int] = (8_000, 12_000)
    noise: tuple[float, float] = (0.01, 0.01)
    size: float = 20.0
    relief: Relief = ledges
    scale: bool = False
    turned_deg: float = 2.0
    shifted_m: float = 0.3


@dataclass(frozen=True, eq=False)
class Outcome:
    """off_deg : (3,) of the rotation, about east, north, up; stated_deg : (3,) at 95 %
    off_scale, stated_scale : relative
    """

    off_deg: Array
    stated_deg: Array
    off_scale: float
    stated_scale: float
    fitted: ModelFit
    placed: ModelPlacement
    truth: Similarity


def once(case: Case, seed: int) -> Outcome:
    """A model turned and shifted from where it belongs, and fitted back."""
    rng = np.random.default_rng(seed)
    reference = sampled(case.n[1], rng, case.noise[1], case.size, case.relief)
    model = sampled(case.n[0], rng, case.noise[0], case.size, case.relief)
    axis, way = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    turn = Rotation.from_rotvec(np.radians(case.turned_deg) * axis).as_matrix()
    grow = 1.02 if case.scale else 1.0
    middle = np.array([case.size / 2, 0.0, case.size / 2])
    shift = middle + case.shifted_m * way
    moved = (model - middle) @ turn.T / grow + shift
    truth = Similarity(grow, turn.T, middle - grow * turn.T @ shift)
    spacing = tuple(case.size / np.sqrt(n) for n in case.n)
    fitted = fit_to_reference(
        moved,
        reference,
        Similarity(1.0, np.eye(3), np.zeros(3)),
        spacing=(spacing[0], spacing[1]),
        include_scale=case.scale,
    )
    placed = place([fitted.observation], None, moved)
    rotation = np.array(placed.matrix)[:3, :3] / placed.scale
    off = Rotation.from_matrix(rotation @ truth.rotation.T).as_rotvec()
    told = placed.rotation_error_95_deg
    stated = [
        np.nan if v is None else v for v in (told.about_east, told.about_north, told.about_up)
    ]
    return Outcome(
        np.degrees(off),
        np.array(stated),
        placed.scale / grow - 1.0,
        np.nan if placed.scale_error_95 is None else placed.scale_error_95,
        fitted,
        placed,
        truth,
    )
