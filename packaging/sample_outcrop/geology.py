"""What is true in the sample outcrop: fold, fault, joints, beds, as closed formulas.

Points are relative to ORIGIN, x east, y north, z up, metres. In the plane across the fold axis p is
horizontal and q rises; a bed is a surface q - g(p) = constant with g piecewise linear, its hinges
rounded. Within one panel every bed is exactly planar and contains the axis, and so does the fault.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

EPSG = 32633
ORIGIN = np.array([364_520.0, 4_721_864.0, 846.0])
"""East, north, up of the left end of the foot of the cliff."""

FACE_AZIMUTH_DEG = 200.0
AXIS_TREND_DEG, AXIS_PLUNGE_DEG = 31.0, 11.0

PANEL_ENDS = (7.0, 13.0, 24.0)
"""Along p, m: where the dip changes, in the footwall."""
PANEL_SLOPES = (0.75, 0.12, -0.38, 0.42)
"""Rise of the beds along p in each panel."""
HINGE_HALF_WIDTH = 0.5
"""Within this of a panel's end the beds are bent."""

FAULT_AT = (18.2, 6.0)
"""A point (p, q) of the fault's middle."""
FAULT_RISE_DEG = 66.0
"""Its apparent dip across the axis; it rises along p, so that the hanging wall is on its left."""
DISPLACEMENT = 1.8
"""The hanging wall has gone down the fault by this, at right angles to the axis (normal)."""
FAULT_HALF_WIDTH = 0.07
"""The fault is a band of gouge with two plane walls."""

JOINTS = {"J1": (193.0, 84.0), "J2": (262.0, 86.0), "J3": (140.0, 79.0)}
"""Dip direction and dip of the three joint sets."""


def direction(trend_deg: float, plunge_deg: float) -> Array:
    """Unit vector of a line."""
    trend, plunge = np.radians([trend_deg, plunge_deg])
    return np.array(
        [np.sin(trend) * np.cos(plunge), np.cos(trend) * np.cos(plunge), -np.sin(plunge)]
    )


def plane_normal(dip_direction_deg: float, dip_deg: float) -> Array:
    """Upward unit normal of a plane."""
    return -direction(dip_direction_deg + 180.0, 90.0 - dip_deg)


def plane_angles(normal: Array) -> tuple[float, float]:
    """Dip direction and dip, degrees, of a plane with this normal."""
    n = normal / np.linalg.norm(normal)
    n = n if n[2] >= 0 else -n
    dip_direction = np.degrees(np.arctan2(n[0], n[1])) % 360.0
    return float(dip_direction), float(np.degrees(np.arccos(n[2])))


UP = np.array([0.0, 0.0, 1.0])
OUT = direction(FACE_AZIMUTH_DEG, 0.0)
ALONG = direction(FACE_AZIMUTH_DEG - 90.0, 0.0)  # to the right of someone who looks at the cliff
AXIS = direction(AXIS_TREND_DEG, AXIS_PLUNGE_DEG)
ACROSS = np.cross(AXIS, UP) / np.linalg.norm(np.cross(AXIS, UP))
RISING = np.cross(ACROSS, AXIS)
_rise = np.radians(FAULT_RISE_DEG)
FAULT_UP = np.array([np.cos(_rise), np.sin(_rise)])  # in (p, q)
FAULT_RIGHT = np.array([np.sin(_rise), -np.cos(_rise)])
FAULT_NORMAL = FAULT_RIGHT[0] * ACROSS + FAULT_RIGHT[1] * RISING


def place(s: Array, h: Array, out: Array) -> Array:
    """Points (..., 3) at s to the right, h up, out of the cliff's plane."""
    return s[..., None] * ALONG + h[..., None] * UP + out[..., None] * OUT


def from_fault(points: Array) -> Array:
    """Signed distance (...) from the fault's middle, positive in the footwall."""
    p, q = points @ ACROSS, points @ RISING
    return (p - FAULT_AT[0]) * FAULT_RIGHT[0] + (q - FAULT_AT[1]) * FAULT_RIGHT[1]


def unfaulted(points: Array) -> tuple[Array, Array]:
    """p and q (...) before the fault moved."""
    p, q = points @ ACROSS, points @ RISING
    hanging = from_fault(points) < 0
    return (
        np.where(hanging, p + DISPLACEMENT * FAULT_UP[0], p),
        np.where(hanging, q + DISPLACEMENT * FAULT_UP[1], q),
    )


def level(points: Array) -> Array:
    """Height in the pile of beds (...), m: constant on a bed."""
    p, q = unfaulted(points)
    g = PANEL_SLOPES[0] * p
    w = HINGE_HALF_WIDTH
    for end, change in zip(PANEL_ENDS, np.diff(PANEL_SLOPES), strict=True):
        t = p - end
        g = g + change * np.where(np.abs(t) < w, (t + w) ** 2 / (4 * w), np.maximum(t, 0.0))
    return np.asarray(q - g)


def panel_of(points: Array) -> npt.NDArray[np.int64]:
    """Which panel (...) each point is in, -1 within a hinge."""
    p, _ = unfaulted(points)
    panel = np.searchsorted(PANEL_ENDS, p)
    near = np.min([np.abs(p - end) for end in PANEL_ENDS], axis=0) < HINGE_HALF_WIDTH
    return np.where(near, -1, panel)


def bed_normal(panel: int) -> Array:
    """Unit normal of the beds in one panel."""
    n = RISING - PANEL_SLOPES[panel] * ACROSS
    return np.asarray(n / np.linalg.norm(n))


class Roughness:
    """A Gaussian random field with covariance sd^2 exp(-distance / length), from random waves.

    The waves' numbers follow the Cauchy law, which is that covariance's spectrum.
    """

    def __init__(self, rng: np.random.Generator, sd: float, length: float, waves: int = 192):
        k = rng.normal(size=(waves, 3)) / np.abs(rng.normal(size=(waves, 1))) / length
        # Waves shorter than a tenth of the length are dust: they become uneven otherwise.
        size = np.linalg.norm(k, axis=1, keepdims=True)
        self._k = (k * np.minimum(1.0, 60.0 / length / size)).T
        self._phase = rng.uniform(0, 2 * np.pi, waves)
        self._scale = sd * np.sqrt(2.0 / waves)

    def __call__(self, points: Array) -> Array:
        flat = points.reshape(-1, 3)
        result = np.empty(len(flat))
        for i in range(0, len(flat), 20_000):
            part = flat[i : i + 20_000] @ self._k + self._phase
            result[i : i + 20_000] = np.cos(part).sum(axis=1)
        return np.asarray(self._scale * result.reshape(points.shape[:-1]))


@dataclass(frozen=True)
class Beds:
    """The pile: boundaries (n + 1,) from below upward, hardness 0..1 and kind (n,) of each bed."""

    boundaries: Array
    hard: Array
    kind: npt.NDArray[np.int64]

    def bed_at(self, height: Array) -> npt.NDArray[np.int64]:
        return np.clip(np.searchsorted(self.boundaries, height) - 1, 0, len(self.hard) - 1)


LIMESTONE, MARL, SANDSTONE, RED = range(4)


def make_beds(rng: np.random.Generator) -> Beds:
    """Thick limestones with marl between, thin-bedded stretches, a red bed now and then."""
    boundaries, hard, kind = [-14.0], [], []

    def bed(thickness: float, hardness: float, what: int) -> None:
        boundaries.append(boundaries[-1] + thickness)
        hard.append(hardness)
        kind.append(what)

    while boundaries[-1] < 22.0:
        for _ in range(rng.integers(2, 4)):
            what = LIMESTONE if rng.random() < 0.7 else SANDSTONE
            bed(rng.uniform(0.45, 1.25), rng.uniform(0.75, 1.0), what)
            bed(rng.uniform(0.06, 0.24), rng.uniform(0.1, 0.4), MARL)
        if rng.random() < 0.6:  # thin-bedded
            for _ in range(rng.integers(3, 6)):
                bed(rng.uniform(0.08, 0.2), rng.uniform(0.7, 0.9), SANDSTONE)
                bed(rng.uniform(0.03, 0.08), 0.3, MARL)
        else:
            bed(rng.uniform(0.25, 0.5), rng.uniform(0.2, 0.4), RED if rng.random() < 0.6 else MARL)
    return Beds(np.array(boundaries), np.array(hard), np.array(kind))
