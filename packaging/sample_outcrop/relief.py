"""The face of the cliff: out(s, h), how far the rock stands out of a vertical plane, m.

Blocks bounded by planes of the three joint sets, broken off along beds, each storey a little behind
the one below; soft beds are hollowed out; talus and ground lie against the foot. Everything is a
formula, so that a pick can be placed on the surface to any precision without a mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import geology
from .geology import Array, Beds, Roughness

WIDTH, HEIGHT = 30.72, 15.36
LOWEST = -1.0  # of h
CREST = 12.1
STOREYS = (-20.0, -2.6, 1.4, 5.2, 9.0, 40.0)
"""Levels in the pile at which the blocks of one storey end and those of the next begin, before
they are moved to a soft bed."""
STOREY_BLEND = 0.07
ROUGHNESS_SD, ROUGHNESS_LENGTH = 0.005, 0.03
BED_SD, BED_LENGTH = 0.006, 0.05
TREADS = 0.34  # each storey is this much behind the one below


@dataclass(frozen=True)
class Block:
    """One block: its planes J1 (front), J2 and J3 (flanks) as out = a + b s + c h."""

    planes: dict[str, tuple[float, float, float]]

    def out(self, s: Array, h: Array) -> Array:
        return np.minimum.reduce([a + b * s + c * h for a, b, c in self.planes.values()])


def joint_plane(name: str, s: float, h: float, out: float) -> tuple[float, float, float]:
    """The joint of one set through a place on the cliff, as out = a + b s + c h."""
    n = geology.plane_normal(*geology.JOINTS[name])
    b, c = -(n @ geology.ALONG) / (n @ geology.OUT), -(n @ geology.UP) / (n @ geology.OUT)
    return float(out - b * s - c * h), float(b), float(c)


class Cliff:
    """A cliff made from a seed. `bare` gives the rock; `surface` the rock under talus."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.beds: Beds = geology.make_beds(rng)
        self._phase = rng.uniform(0, 2 * np.pi, 4)
        self.roughen(rng)
        soft = 0.5 * (self.beds.boundaries[:-1] + self.beds.boundaries[1:])[self.beds.hard < 0.5]
        self.storeys = np.array([soft[np.argmin(np.abs(soft - x))] for x in STOREYS[1:-1]])
        self.blocks = [self._storey(rng, i) for i in range(len(self.storeys) + 1)]
        fine = np.linspace(self.beds.boundaries[0], self.beds.boundaries[-1], 8000)
        depth = 0.23 * np.maximum(0.75 - self.beds.hard[self.beds.bed_at(fine)], 0.0)
        width = int(0.05 / (fine[1] - fine[0]))
        bell = np.hanning(2 * width + 1)
        self._hollow = (fine, np.convolve(depth, bell / bell.sum(), mode="same"))
        self.screes = [
            (rng.uniform(15.5, 17.5), rng.uniform(2.9, 3.3), 0.62),
            (rng.uniform(3.5, 5.5), rng.uniform(1.0, 1.4), 0.45),
            (rng.uniform(26.0, 28.0), rng.uniform(1.2, 1.7), 0.5),
        ]

    def roughen(self, rng: np.random.Generator) -> None:
        """Draw all unevenness anew, on the same blocks and beds."""
        self.roughness = Roughness(rng, ROUGHNESS_SD, ROUGHNESS_LENGTH)
        self.bed_waves = Roughness(rng, BED_SD, BED_LENGTH)
        self.wall_waves = (
            Roughness(rng, BED_SD, BED_LENGTH),
            Roughness(rng, BED_SD, BED_LENGTH),
        )

    def hollow(self, height: Array) -> Array:
        """How far the rock at a level in the pile has weathered back, m."""
        return np.asarray(np.interp(height, *self._hollow))

    def niche(self, points: Array, height: Array) -> Array:
        """How deep a block has fallen out of a bed here, m: some do, between joints."""
        bed = self.beds.bed_at(height)
        along = points @ geology.plane_normal(*geology.JOINTS["J2"])
        space = 0.45 + 0.9 * scramble(bed * 1.7)
        number = np.floor(along / space + scramble(bed * 0.61))
        luck = scramble(number * 3.1 + bed * 7.7)
        gone = (luck < 0.15) & (self.beds.hard[bed] > 0.5)
        return np.asarray(np.where(gone, 0.06 + 1.2 * luck, 0.0))

    def base(self, s: Array) -> Array:
        """Bays and buttresses."""
        a = self._phase
        wave = 0.75 * np.sin(2 * np.pi * s / 14.3 + a[0]) + 0.3 * np.sin(2 * np.pi * s / 6.1 + a[1])
        return np.asarray(wave)

    def _storey(self, rng: np.random.Generator, number: int) -> list[Block]:
        blocks = []
        s = -3.0 + rng.uniform(0, 1.5)
        while s < WIDTH + 3.0:
            width = rng.uniform(0.8, 2.4)
            middle = s + width / 2
            # Where on the cliff this storey is, about: the beds rise and fall along it.
            p = np.array([middle * float(geology.ALONG @ geology.ACROSS)])
            zero = geology.level(p[:, None] * geology.ACROSS)[0]
            edges = (STOREYS[number], STOREYS[number + 1])
            h = float(np.clip(np.mean(np.clip(edges, -3.0, 13.0)) - zero, -2.0, 14.0))
            out = float(self.base(np.array(middle))) - TREADS * number + rng.normal(0, 0.4)
            blocks.append(
                Block(
                    {
                        "J1": joint_plane("J1", middle, h, out),
                        "J2": joint_plane("J2", s, h, out),
                        "J3": joint_plane("J3", s + width, h, out),
                    }
                )
            )
            s += width + rng.uniform(0.15, 0.75)
        return blocks

    def storey_outs(self, s: Array, h: Array) -> list[Array]:
        return [np.maximum.reduce([block.out(s, h) for block in blocks]) for blocks in self.blocks]

    def bare(self, s: Array, h: Array) -> Array:
        """The rock without talus."""
        outs = self.storey_outs(s, h)
        out = outs[2]
        for _ in range(4):
            points = geology.place(s, h, out)
            height = geology.level(points)
            out = outs[0]
            for boundary, above in zip(self.storeys, outs[1:], strict=True):
                share = _step((height - boundary) / STOREY_BLEND)
                out = out + share * (above - out)
            out = out - self.hollow(height)
            # Crushed rock along the fault has fallen out.
            out = out - 0.22 * np.exp(-((geology.from_fault(points) / 0.28) ** 2))
        points = geology.place(s, h, out)
        out = out - self.niche(points, geology.level(points))
        out = out - 1.1 * np.maximum(h - CREST - 0.3 * np.sin(s / 1.9 + self._phase[2]), 0.0) ** 1.5
        return np.asarray(out + self.roughness(geology.place(s, h, out)))

    def talus(self, s: Array, h: Array) -> Array:
        """The surface of the scree, smooth; a cone where a gully feeds it."""
        a = self._phase
        top = 0.35 + 0.22 * np.sin(s / 2.3 + a[3]) + 0.12 * np.sin(s / 0.9 + a[1])
        for middle, height, fall in self.screes:
            top = np.maximum(top, height - fall * np.sqrt((s - middle) ** 2 + 0.15) * 0.8)
        # Repose at 34 degrees, against the wall as it would be without blocks.
        return np.asarray(self.base(s) - 0.75 + (top - h) * 1.48)

    def surface(self, s: Array, h: Array) -> tuple[Array, Array]:
        """Rock and talus together, and how far (m) the talus lies above the rock, negative below
        it."""
        rock, scree = self.bare(s, h), self.talus(s, h)
        over = scree - rock
        return np.maximum(rock, scree), over


def scramble(x: Array) -> Array:
    """A number in [0, 1) from any number, the same each time."""
    y = np.sin(x * 12.9898) * 43758.5453
    return np.asarray(y - np.floor(y))


def _step(t: Array) -> Array:
    """0 below -1, 1 above 1, smooth between."""
    t = np.clip(0.5 + 0.5 * t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def crossing(
    value: object, low: npt.NDArray[np.float64], high: npt.NDArray[np.float64], steps: int = 46
) -> Array:
    """Where value(t) (k,) rises through zero between low and high (k,): the lowest such t.

    NaN where it does not.
    """
    f: object = value
    t = low + (high - low) * np.linspace(0.0, 1.0, steps)[:, None]
    v = np.array([f(row) for row in t])  # type: ignore[operator]
    rises = (v[:-1] < 0) & (v[1:] >= 0)
    found = rises.any(axis=0)
    first = rises.argmax(axis=0)
    k = np.arange(len(low))
    a, b = t[first, k], t[first + 1, k]
    for _ in range(22):
        middle = 0.5 * (a + b)
        below = f(middle) < 0  # type: ignore[operator]
        a, b = np.where(below, middle, a), np.where(below, b, middle)
    return np.where(found, 0.5 * (a + b), np.nan)
