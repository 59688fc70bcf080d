"""The photographs on the sample outcrop: colours of beds, weathering, light and shadow.

Everything is a function of the place in space, so that nothing is stretched where the face turns
away from the picture.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter, gaussian_filter1d, map_coordinates

from . import geology
from .cover import GREEN, ROCK, SCREE, SOIL, Face
from .geology import LIMESTONE, MARL, RED, SANDSTONE, Array
from .relief import Cliff, scramble

SUN = geology.direction(238.0, -44.0)  # toward the sun
COLORS = {
    LIMESTONE: (188.0, 176.0, 154.0),
    SANDSTONE: (172.0, 148.0, 112.0),
    MARL: (104.0, 99.0, 90.0),
    RED: (139.0, 96.0, 76.0),
}


class Solid:
    """Noise in space of standard deviation 1, the same everywhere: a lattice that repeats."""

    def __init__(self, rng: np.random.Generator, size: int = 64) -> None:
        self._lattice = gaussian_filter(rng.normal(size=(size,) * 3), 0.8, mode="wrap")
        self._lattice /= self._lattice.std()

    def __call__(self, points: Array, length: float | tuple[float, float, float]) -> Array:
        at = np.moveaxis(points / np.asarray(length), -1, 0).astype(np.float32)
        return np.asarray(
            map_coordinates(self._lattice, at, order=1, mode="grid-wrap", output=np.float32)
        )

    def octaves(self, points: Array, length: float, count: int) -> Array:
        total = np.zeros(points.shape[:-1], np.float32)
        for i in range(count):
            total += self(points + 17.3 * i, length / 2**i) * 0.6**i
        return np.asarray(total)


def picture(
    cliff: Cliff,
    face: Face,
    rng: np.random.Generator,
    rows: int,
    columns: int,
    band: tuple[int, int] | None = None,
) -> npt.NDArray[np.uint8]:
    """RGB (rows, columns, 3) of the whole face, row 0 on top; of rows band[0] to band[1] only."""
    first, last = band or (0, rows)
    v, u = np.meshgrid(
        (face.s.shape[0] - 1) * (1 - (np.arange(first, last) + 0.5) / rows),
        (face.s.shape[1] - 1) * (np.arange(columns) + 0.5) / columns,
        indexing="ij",
    )

    def on(grid: Array, order: int = 1) -> Array:
        return np.asarray(map_coordinates(grid, [v, u], order=order, mode="nearest"))

    out = on(face.out)
    points = geology.place(on(face.s), on(face.h), out)
    what = on(face.what.astype(np.float32), 0).astype(np.int8)
    shade = on(face.shade, 0)
    noise = Solid(rng)
    color = _rock(cliff, points, noise, rng)
    scree = _scree(points, noise, shade)
    color = np.where((what == SCREE)[..., None], scree, color)
    green = _green(points, noise, shade, rng)
    color = np.where((what == GREEN)[..., None], green, color)
    soil = np.array([122.0, 106.0, 74.0]) * (1 + 0.16 * noise.octaves(points, 0.5, 4)[..., None])
    grass = np.array([112.0, 116.0, 58.0]) * (1 + 0.2 * noise(points, 0.05)[..., None])
    tuft = np.clip(0.5 + noise.octaves(points, 0.9, 4), 0, 1)[..., None]
    color = np.where((what == SOIL)[..., None], soil + (grass - soil) * tuft, color)
    light = _light(face, points, noise, what, on)
    # The sky is blue, the sun is not.
    shadowed = np.clip(1.1 - light, 0, 1)[..., None]
    color = color * light[..., None] * (1 + shadowed * np.array([-0.07, 0.0, 0.10]))
    return np.clip(color, 0, 255).astype(np.uint8)


def _rock(cliff: Cliff, points: Array, noise: Solid, rng: np.random.Generator) -> Array:
    beds = cliff.beds
    height = geology.level(points) + cliff.bed_waves(points)
    bed = beds.bed_at(height)
    hard = beds.hard[bed]
    count = len(beds.hard)
    tint = rng.normal(size=(count, 1)) * 10 + rng.normal(size=(count, 1)) * [3, 0, -4]
    palette = np.array([COLORS[k] for k in range(4)])[beds.kind] + tint
    color = palette[bed]
    # Lamination: finer and stronger in sandstone and marl.
    fine = np.linspace(beds.boundaries[0], beds.boundaries[-1], 24000)
    laminae = gaussian_filter1d(rng.normal(size=fine.size), 3.5) * 2.4
    laminae += gaussian_filter1d(rng.normal(size=fine.size), 14) * 4.0
    wavy = np.interp(height + 0.012 * noise(points, 0.35), fine, laminae)
    strength = np.array([0.030, 0.085, 0.075, 0.06])[[LIMESTONE, MARL, SANDSTONE, RED]]
    order = np.argsort([LIMESTONE, MARL, SANDSTONE, RED])
    light = 1 + strength[order][beds.kind[bed]] * wavy
    # Partings.
    gap = np.minimum(height - beds.boundaries[bed], beds.boundaries[bed + 1] - height)
    light -= 0.42 * np.exp(-((gap / 0.013) ** 2))
    light -= 0.12 * np.exp(-((gap / 0.05) ** 2))
    light *= 1 + 0.05 * noise.octaves(points, 0.9, 3) + 0.055 * noise.octaves(points, 0.11, 4)
    # Cracks: joints that the relief does not show, each within one bed.
    for k, (name, spacing, depth) in enumerate((("J2", 0.5, 0.5), ("J3", 0.7, 0.45))):
        n = geology.plane_normal(*geology.JOINTS[name])
        along = points @ n + 0.02 * noise(points, 0.5)
        shift = rng.uniform(0, 1, count)[bed]
        space = np.clip((beds.boundaries[bed + 1] - beds.boundaries[bed]) * 1.1, 0.12, None)
        space = space * spacing * rng.uniform(0.8, 1.6, count)[bed]
        number = np.floor(along / space + shift)
        wander = scramble(number + 911 * bed + 77 * k)
        away = np.abs((along / space + shift) - number - 0.2 - 0.6 * wander) * space
        away = away + 0.012 * np.clip(noise.octaves(points + k, 0.25, 3), 0, 2)
        exists = (scramble(number * 3.7 + bed * 13 + k) < 0.62) & (hard > 0.5)
        width = 0.004 + 0.009 * scramble(number * 1.3 + bed + 5 * k)
        light -= np.where(exists, depth * np.exp(-((away / width) ** 2)), 0.0)
    color = color * light[..., None]
    # Gouge and broken rock beside the fault, rusty.
    away = np.abs(geology.from_fault(points))
    waves = 0.5 * (cliff.wall_waves[0](points) + cliff.wall_waves[1](points))
    beyond = np.abs(geology.from_fault(points) + waves) - geology.FAULT_HALF_WIDTH
    gouge = 1 / (1 + np.exp(np.clip(beyond / 0.006, -40, 40)))
    rubble = np.clip(1.0 - away / 0.55, 0, 1) * np.clip(0.7 + noise.octaves(points, 0.10, 3), 0, 1)
    clay = np.array([133.0, 90.0, 66.0]) * (1 + 0.16 * noise.octaves(points, 0.06, 3)[..., None])
    broken = np.array([150.0, 128.0, 104.0]) * (
        1 + 0.22 * noise.octaves(points, 0.07, 3)[..., None]
    )
    color = color + (broken - color) * (0.65 * rubble)[..., None]
    color = color + (clay - color) * gouge[..., None]
    # A skin of weathering, dust and soil washed down, here thick and there gone.
    skin = np.array([158.0, 146.0, 126.0]) * (1 + 0.10 * noise.octaves(points, 0.4, 4)[..., None])
    thick = noise.octaves(points + 41, 2.2, 5) + 0.5 * noise(points, (0.3, 0.3, 2.5))
    thick = np.clip(0.36 + 0.30 * thick, 0.08, 0.8)[..., None]
    color = color + (skin * light[..., None].clip(0.55, 1.1) - color) * thick
    # Stains that run down, rust, lichen.
    drawn = noise(points, (0.22, 0.22, 3.2)) + 0.6 * noise(points, (0.09, 0.09, 2.0))
    patch = noise.octaves(points + 5, 2.8, 2)
    stain = np.clip(0.45 * drawn + 0.8 * patch - 0.55, 0, 1.0)[..., None]
    color = color * (1 - 0.36 * stain) + stain * [2.0, 3.0, 6.0]
    rust = np.clip(noise.octaves(points + 11, 1.1, 4) - 0.9, 0, 1.0)[..., None]
    color = color * (1 + rust * np.array([0.10, -0.05, -0.20]))
    pale = np.clip(noise.octaves(points + 23, 0.8, 3) - 1.0, 0, 1)[..., None]
    color = color + pale * 16
    lichen = np.clip(noise.octaves(points + 31, 0.10, 3) + 0.7 * patch - 1.9, 0, 0.6)[..., None]
    return np.asarray(color * (1 - lichen) + lichen * np.array([138.0, 140.0, 112.0]))


def _scree(points: Array, noise: Solid, shade: Array) -> Array:
    stone = np.array([166.0, 154.0, 134.0]) * (1 + 0.14 * shade[..., None])
    stone = stone + 12.0 * np.sin(9.0 * shade)[..., None] * np.array([1.0, 0.3, -0.6])
    grit = np.array([140.0, 127.0, 106.0]) * (1 + 0.1 * noise.octaves(points, 0.6, 3)[..., None])
    grit = grit * (1 + 0.2 * noise.octaves(points, 0.05, 2)[..., None])
    stone = stone * (1 + 0.07 * noise.octaves(points, 0.08, 3)[..., None])
    return np.asarray(np.where((shade != 0)[..., None], stone, grit))


def _green(points: Array, noise: Solid, shade: Array, rng: np.random.Generator) -> Array:
    leaves = np.array([84.0, 92.0, 52.0]) + shade[..., None] * np.array([16.0, 8.0, 6.0])
    grain = rng.normal(size=shade.shape)
    grain = gaussian_filter(grain, 0.9)
    grain = grain / grain.std()
    clumps = noise.octaves(points, 0.13, 3)
    return np.asarray(leaves * (1 + 0.3 * clumps + 0.28 * grain)[..., None].clip(0.25, 1.9))


def _light(
    face: Face, points: Array, noise: Solid, what: npt.NDArray[np.int8], on: object
) -> Array:
    """Sun, sky and shadow, about 1 on a plane in the sun."""
    step = float(face.s[0, 1] - face.s[0, 0])
    # Fine relief that the mesh is too coarse for.
    dv, du = np.gradient(face.out, step)
    normal = geology.OUT - du[..., None] * geology.ALONG - dv[..., None] * geology.UP
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    sun = np.clip(normal @ SUN, 0, 1)
    # Cast shadows: walk toward the sun over the face, on a coarser grid.
    k = 2
    coarse = face.out[::k, ::k]
    shadow = np.zeros(coarse.shape)
    along, up, out = SUN @ geology.ALONG, SUN @ geology.UP, SUN @ geology.OUT
    reach = np.geomspace(0.05, 6.0, 42)
    i, j = np.meshgrid(*(np.arange(n, dtype=np.float32) for n in coarse.shape), indexing="ij")
    for r in reach:
        there = map_coordinates(
            coarse,
            [i + r * up / (k * step), j + r * along / (k * step)],
            order=1,
            mode="constant",
            cval=-99.0,
        )
        blocked = there - (coarse + r * out)
        shadow = np.maximum(shadow, np.clip(blocked / (0.02 + 0.04 * r), 0, 1))
    shadow = gaussian_filter(shadow, 0.7)
    full = map_coordinates(
        shadow,
        [
            np.arange(face.s.shape[0])[:, None] / k + 0 * np.arange(face.s.shape[1]),
            np.arange(face.s.shape[1])[None, :] / k + 0 * np.arange(face.s.shape[0])[:, None],
        ],
        order=1,
        mode="nearest",
    )
    sky = 0.62 + 0.2 * normal[..., 2] + 0.18 * (normal @ geology.OUT)
    for size, weight in ((0.06, 1.6), (0.2, 0.75), (0.7, 0.28)):
        inside = gaussian_filter(face.out, size / step) - face.out
        sky = sky - np.clip(weight * inside, -0.1, 0.25)
    light = 0.58 * np.clip(sky, 0.25, 1.1) + 0.72 * sun * (1 - 0.92 * full)
    assert callable(on)
    shown: Array = np.asarray(on(light))
    bumps = noise.octaves(points + 3, 0.035, 2)
    return np.asarray(shown * (1 + np.where(what == ROCK, 0.05, 0.08) * bumps))
