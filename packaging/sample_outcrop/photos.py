"""The photos of the sample outcrop: rays through every pixel, the surface's picture where they
meet it, and what a camera does to light."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from . import camera, casting, control, exif, geology, surroundings
from .camera import LENS, Shot
from .control import Target
from .cover import Face
from .geology import Array
from .pictures import Solid
from .relief import HEIGHT, LOWEST, WIDTH

SAMPLES = 3  # rays along each side of a pixel
JPEG_QUALITY = 88
GPS_SD = 3.0  # m, each coordinate
VIGNETTING = 0.10  # darker in the corners
ELECTRONS = 9000.0  # that make white: grain
SKY_HIGH, SKY_LOW = np.array([0.34, 0.50, 0.78]), np.array([0.66, 0.75, 0.86])


@dataclass(frozen=True)
class Scene:
    """What there is to be seen, relative to ORIGIN.

    points (n, 3), triangles (m, 3), the first `facing` of which are of the face; steep (m,) 0..1
    where that picture is stretched over them; image RGB (rows, columns, 3) of the whole face, row 0
    on top
    """

    points: Array
    triangles: npt.NDArray[np.int64]
    facing: int
    steep: Array
    image: npt.NDArray[np.uint8]
    targets: list[Target]
    noise: Solid


def write_photos(
    folder: Path,
    face: Face,
    picks: Array,
    image: npt.NDArray[np.uint8],
    points: Array,
    own: npt.NDArray[np.int64],
    rest: npt.NDArray[np.int64],
    seed: int,
) -> None:
    """Photos, control points with their marks, and the truth about the cameras.

    picks : (k, 2) s and h; points (n, 3) relative to ORIGIN; own (m, 3) triangles of the model;
    rest : (r, 3) those of the face beyond the model's edge
    """
    noise = Solid(np.random.default_rng([seed, 5]))
    more, triangles = surroundings.surroundings(face, noise)
    facing = np.concatenate([own, rest])
    surface = _dense(points, own)
    scene = Scene(
        np.concatenate([points, more]),
        np.concatenate([facing, triangles + len(points)]),
        len(facing),
        _steep(points, facing),
        image,
        control.place_targets(face, surface, picks),
        noise,
    )
    shots = camera.shots(np.random.default_rng([seed, 6]))
    write_survey(folder, scene, shots, np.random.default_rng([seed, 7]))
    (folder / "photos").mkdir(exist_ok=True)
    gps = np.random.default_rng([seed, 8])
    for i, shot in enumerate(shots):
        light = expose(scene, shot)
        picture = develop(light, shot, np.random.default_rng([seed, 9, i]))
        words = exif.words(shot, shot.centre + gps.normal(0.0, GPS_SD, 3), GPS_SD)
        Image.fromarray(picture).save(
            folder / "photos" / shot.name, quality=JPEG_QUALITY, optimize=True, exif=words
        )


def _steep(points: Array, triangles: npt.NDArray[np.int64]) -> Array:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    towards = (normal @ geology.OUT) / (np.linalg.norm(normal, axis=1) + 1e-12)
    return np.asarray(np.clip((0.55 - towards) / 0.35, 0.0, 1.0))


def _dense(points: Array, triangles: npt.NDArray[np.int64]) -> Array:
    """Points (n, 3) on a surface, some 5 cm apart."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    longest = np.max([np.linalg.norm(q - p, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    found = []
    for n in (1, 2, 4, 8, 16, 32):
        chosen = (longest / n <= 0.05) & ((n == 1) | (longest / max(n / 2, 0.5) > 0.05))
        if n == 32:
            chosen |= longest / n > 0.05
        i, j = np.meshgrid(np.arange(n), np.arange(n))
        u, v = ((i[i + j < n] + 1 / 3) / n), ((j[i + j < n] + 1 / 3) / n)
        part = (1 - u - v)[:, None, None] * a[chosen] + u[:, None, None] * b[chosen]
        found.append((part + v[:, None, None] * c[chosen]).reshape(-1, 3))
    return np.concatenate(found)


def expose(scene: Scene, shot: Shot) -> Array:
    """Light (rows, columns, 3), linear, 1 = white paint in the sun, over the area of each pixel."""
    rows, columns = camera.HEIGHT, camera.WIDTH
    result = np.empty((rows, columns, 3))
    step = 50
    inside = (np.arange(columns * SAMPLES) + 0.5) / SAMPLES
    for first in range(0, rows, step):
        down = first + (np.arange(step * SAMPLES) + 0.5) / SAMPLES
        x, y = camera.straighten(
            *np.meshgrid((inside - LENS["cx"]) / LENS["fx"], (down - LENS["cy"]) / LENS["fy"])
        )
        depth, triangle = casting.cast_block(
            shot, scene.points, scene.triangles, x, y, first, SAMPLES
        )
        ways = np.stack([x, y, np.ones(x.shape)], axis=-1).reshape(-1, 3) @ shot.rotation
        seen = _seen(scene, shot.centre, ways, depth.ravel(), triangle.ravel())
        parts = seen.reshape(step, SAMPLES, columns, SAMPLES, 3)
        result[first : first + step] = parts.mean(axis=(1, 3))
    return result


def _seen(
    scene: Scene, centre: Array, ways: Array, depth: Array, triangle: npt.NDArray[np.int64]
) -> Array:
    """Light (n, 3) that comes from places centre + depth * way."""
    high = np.clip(ways[:, 2] / np.linalg.norm(ways, axis=1) * 1.6, 0, 1)[:, None]
    light = SKY_LOW + (SKY_HIGH - SKY_LOW) * high
    met = triangle >= 0
    on_face = np.flatnonzero(met & (triangle < scene.facing))
    points = centre + ways[on_face] * depth[on_face, None]
    color = _pictured(scene.image, points)
    # Grain of the rock where the picture has none.
    steep = scene.steep[triangle[on_face]]
    some = steep > 0
    grain = scene.noise.octaves(points[some], 0.16, 5)
    color[some] *= np.exp(0.22 * steep[some] * grain)[:, None]
    for target in scene.targets:
        near, white = target.paint(points)
        if len(white):
            # As bright as the rock around it allows.
            shade = np.clip(color[near].mean() / 0.30, 0.35, 1.0)
            color[near] = shade * (0.05 + 0.75 * white[:, None])
    light[on_face] = color
    beyond = np.flatnonzero(met & (triangle >= scene.facing))
    if len(beyond):
        points = centre + ways[beyond] * depth[beyond, None]
        a, b, c = (scene.points[scene.triangles[triangle[beyond], k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal *= -np.sign((normal * ways[beyond]).sum(axis=1))[:, None]
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        paint = surroundings.colors(points, normal, scene.noise)
        light[beyond] = (paint / 255.0) ** 2.2
    return np.asarray(light)


def _pictured(image: npt.NDArray[np.uint8], points: Array) -> Array:
    """Linear light (n, 3) of the face's picture at points of it, between four of its pixels."""
    rows, columns, _ = image.shape
    x = (points @ geology.ALONG / WIDTH * columns - 0.5).clip(0, columns - 1.001)
    y = ((1 - (points @ geology.UP - LOWEST) / HEIGHT) * rows - 0.5).clip(0, rows - 1.001)
    i, j = y.astype(np.int64), x.astype(np.int64)
    v, u = (y - i)[:, None], (x - j)[:, None]
    linear = (np.arange(256) / 255.0) ** 2.2
    return np.asarray(
        (1 - v) * ((1 - u) * linear[image[i, j]] + u * linear[image[i, j + 1]])
        + v * ((1 - u) * linear[image[i + 1, j]] + u * linear[image[i + 1, j + 1]])
    )


def develop(light: Array, shot: Shot, rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """What the camera makes of light: vignetting, exposure, grain, tone curve."""
    y, x = np.indices(light.shape[:2]) + 0.5
    r2 = (x - LENS["cx"]) ** 2 + (y - LENS["cy"]) ** 2
    dark = 1.0 - VIGNETTING * r2 / r2.max()
    light = 1.12 * shot.exposure * light * dark[..., None]
    light = light + rng.normal(size=light.shape) * np.sqrt(light.clip(0) / ELECTRONS + 2e-6)
    return np.asarray((255.0 * light.clip(0, 1) ** (1 / 2.2) + 0.5).astype(np.uint8))


def write_survey(folder: Path, scene: Scene, shots: list[Shot], rng: np.random.Generator) -> None:
    """control.csv, marks.csv, and cameras_truth.csv with control_truth.csv."""
    frame = f"EPSG:{geology.EPSG}: x east, y north, z up, metres"
    given = [f"# {frame}; sigma of every coordinate in metres", "label,x,y,z,sigma,use"]
    true = [f"# truth of control.csv; {frame}", "label,x,y,z"]
    marks = [
        "# pixels of the photo as it is stored: x to the right, y down, the middle of the first"
        f" pixel is (0.5, 0.5); uncertain by {control.MARK_SD:g} pixels (1 sigma)",
        "label,photo,x,y",
    ]
    for target in scene.targets:
        x, y, z = target.middle + geology.ORIGIN
        true.append(f"{target.label},{x:.5f},{y:.5f},{z:.5f}")
        x, y, z = target.middle + geology.ORIGIN + rng.normal(0.0, control.SURVEY_SD, 3)
        given.append(f"{target.label},{x:.4f},{y:.4f},{z:.4f},{control.SURVEY_SD:g},{target.use}")
        for shot in shots:
            pixels, depth = shot.project(target.middle[None])
            error = rng.normal(0.0, control.MARK_SD, 2)
            u, v = pixels[0]
            if depth[0] <= 0 or not (12 < u < camera.WIDTH - 12 and 12 < v < camera.HEIGHT - 12):
                continue
            way = target.middle - shot.centre
            far = float(np.linalg.norm(way))
            free = casting.distance_along(scene.points, scene.triangles, shot.centre, way / far)
            if free < far - 0.03 or -(way @ target.normal) / far < 0.35:
                continue
            marks.append(f"{target.label},{shot.name},{u + error[0]:.3f},{v + error[1]:.3f}")
    names = [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
    cameras = [
        f"# truth of the photos; {frame}. r: rotation from east, north, up to the camera's right,"
        " down, forward, row by row; lens as OpenCV has it (k1, k2, p1, p2), pixels with the middle"
        " of the first at (0.5, 0.5)",
        ",".join(["name", "x", "y", "z", *names, "width", "height", *LENS]),
    ]
    for shot in shots:
        x, y, z = shot.centre + geology.ORIGIN
        turned = [f"{value:.12f}" for value in shot.rotation.ravel()]
        lens = [f"{value:g}" for value in (camera.WIDTH, camera.HEIGHT, *LENS.values())]
        cameras.append(",".join([shot.name, f"{x:.5f}", f"{y:.5f}", f"{z:.5f}", *turned, *lens]))
    for name, lines in (
        ("control.csv", given),
        ("control_truth.csv", true),
        ("marks.csv", marks),
        ("cameras_truth.csv", cameras),
    ):
        (folder / name).write_text("\n".join(lines) + "\n", "utf-8", newline="\n")
