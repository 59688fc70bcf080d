"""Makes resources/outcrop: a small cliff of folded beds whose orientations are known exactly.

    .venv/bin/python packaging/make_small_outcrop.py [FOLDER]

Beds are the surfaces q - g(p) = constant of a cylindrical fold, where p and q are coordinates
across the fold axis and g is piecewise linear: within one panel of the fold every bed is exactly
planar, and the normals of all panels are perpendicular to the axis. Picked points are where beds
cut edges of the mesh, plus noise. Nothing of the program's own arithmetic is used, so that
truth.csv is a witness from outside. Same seed, same files (JPEG bytes may differ between versions
of the image library).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image
from pyproj import CRS
from scipy.ndimage import gaussian_filter, gaussian_filter1d, map_coordinates

SEED = 20
EPSG = 32633
ORIGIN = np.array([372410.0, 4709820.0, 612.0])  # east, north, up of the left foot of the cliff, m
WIDTH, HEIGHT = 12.0, 6.0  # m
COLUMNS, ROWS = 96, 48  # cells of the mesh
FACE_AZIMUTH_DEG = 205.0  # which way the cliff looks
LEAN = 0.25  # horizontal retreat per metre of height
AXIS_TREND_DEG, AXIS_PLUNGE_DEG = 32.0, 14.0
PANEL_ENDS = np.array([2.9, 6.1, 8.9])  # along p, m: where the dip changes
PANEL_SLOPES = np.array([0.47, 0.14, -0.20, -0.52])  # rise of the beds along p
NOISE_M = 0.005
IMAGE_SIZE = 720  # pixels, of each half of the cliff
JPEG_QUALITY = 58


def direction(trend_deg: float, plunge_deg: float) -> np.ndarray:
    """Unit vector (east, north, up) of a line."""
    trend, plunge = np.radians([trend_deg, plunge_deg])
    return np.array(
        [np.sin(trend) * np.cos(plunge), np.cos(trend) * np.cos(plunge), -np.sin(plunge)]
    )


OUTWARD = direction(FACE_AZIMUTH_DEG, 0.0)
ALONG = direction(FACE_AZIMUTH_DEG - 90.0, 0.0)  # to the right of someone who looks at the cliff
UP = np.array([0.0, 0.0, 1.0])
AXIS = direction(AXIS_TREND_DEG, AXIS_PLUNGE_DEG)
ACROSS = np.cross(AXIS, UP) / np.linalg.norm(np.cross(AXIS, UP))  # horizontal, p grows along it
RISING = np.cross(ACROSS, AXIS)  # q grows along it


def fold_coordinate(points: np.ndarray) -> np.ndarray:
    """p, m, of points (..., 3) relative to ORIGIN."""
    return points @ ACROSS


def height_in_pile(points: np.ndarray) -> np.ndarray:
    """q - g(p), m: constant on a bed. Points (..., 3) relative to ORIGIN."""
    p = fold_coordinate(points)
    g = PANEL_SLOPES[0] * p
    for end, change in zip(PANEL_ENDS, np.diff(PANEL_SLOPES), strict=True):
        g = g + change * np.maximum(p - end, 0.0)
    return points @ RISING - g


def bed_orientation(panel: int) -> tuple[float, float]:
    """True dip direction and dip, degrees, of the beds in one panel."""
    normal = RISING - PANEL_SLOPES[panel] * ACROSS
    normal = normal / np.linalg.norm(normal)
    dip_direction = np.degrees(np.arctan2(normal[0], normal[1])) % 360.0
    return float(dip_direction), float(np.degrees(np.arccos(normal[2])))


def smooth_noise(rng: np.random.Generator, shape: tuple[int, int], sigma: float) -> np.ndarray:
    """Gaussian noise of standard deviation 1 whose bumps are some `sigma` cells wide."""
    noise = gaussian_filter(rng.normal(size=shape), sigma, mode="reflect")
    return noise / noise.std()


def beds(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Boundaries (n+1,), m, of the beds from below upward, and how hard (0..1) each is (n,)."""
    boundaries, hard = [-12.0], []
    strong = True
    while boundaries[-1] < 18.0:
        boundaries.append(
            boundaries[-1] + (rng.uniform(0.35, 0.8) if strong else rng.uniform(0.1, 0.34))
        )
        hard.append(rng.uniform(0.7, 1.0) if strong else rng.uniform(0.0, 0.35))
        strong = not strong
    return np.array(boundaries), np.array(hard)


def cliff(rng: np.random.Generator, boundaries: np.ndarray, hard: np.ndarray) -> np.ndarray:
    """Mesh vertices (ROWS+1, COLUMNS+1, 3) relative to ORIGIN; row 0 is the foot."""
    s, h = np.meshgrid(np.linspace(0, WIDTH, COLUMNS + 1), np.linspace(0, HEIGHT, ROWS + 1))
    flat = s[..., None] * ALONG + h[..., None] * (UP - LEAN * OUTWARD)
    shape = s.shape
    relief = 0.42 * np.sin(2 * np.pi * s / 3.1 + 0.6) + 0.22 * np.sin(2 * np.pi * s / 1.7 + 0.5 * h)
    relief += 0.16 * smooth_noise(rng, shape, 9) + 0.05 * smooth_noise(rng, shape, 3)
    # Hard beds stand out as ledges, rounded off.
    fine = np.linspace(boundaries[0], boundaries[-1], 6000)
    profile = hard[np.clip(np.searchsorted(boundaries, fine) - 1, 0, hard.size - 1)]
    step = fine[1] - fine[0]
    profile = gaussian_filter1d(profile, 0.06 / step)
    relief += 0.22 * np.interp(height_in_pile(flat), fine, profile)
    return flat + relief[..., None] * OUTWARD


def rock_picture(
    rng: np.random.Generator, vertices: np.ndarray, boundaries: np.ndarray, hard: np.ndarray
) -> np.ndarray:
    """RGB image of the whole cliff, uint8, row 0 on top; two squares side by side."""
    rows, columns = IMAGE_SIZE, 2 * IMAGE_SIZE
    v, u = np.meshgrid(
        ROWS * (1 - (np.arange(rows) + 0.5) / rows),
        COLUMNS * (np.arange(columns) + 0.5) / columns,
        indexing="ij",
    )
    points = np.stack(
        [map_coordinates(vertices[..., k], [v, u], order=1, mode="nearest") for k in range(3)], -1
    )
    pixel = WIDTH / columns
    shape = (rows, columns)
    level = height_in_pile(points)
    bed = np.clip(np.searchsorted(boundaries, level) - 1, 0, hard.size - 1)
    strength = hard[bed]
    to_boundary = np.minimum(level - boundaries[bed], boundaries[bed + 1] - level)

    sandstone, marl = np.array([196.0, 170.0, 132.0]), np.array([118.0, 112.0, 104.0])
    tint = rng.normal(size=(hard.size, 3)) * [5, 4, 3] + rng.normal(size=(hard.size, 1)) * 9
    colour = marl + (sandstone - marl) * strength[..., None] + tint[bed]

    # Laminae follow the beds; blotches and grain do not.
    pile = np.linspace(boundaries[0], boundaries[-1], 20000)
    laminae = gaussian_filter1d(rng.normal(size=pile.size), 5)
    laminae = np.interp(level + 0.012 * smooth_noise(rng, shape, 12), pile, laminae / laminae.std())
    light = 1 + 0.055 * laminae * (1.25 - strength)
    light += 0.05 * smooth_noise(rng, shape, 40) + 0.05 * smooth_noise(rng, shape, 7)
    light += 0.05 * smooth_noise(rng, shape, 1.2)
    light -= 0.42 * np.exp(-((to_boundary / 0.016) ** 2))  # partings

    # Joints stand across the beds and stop at the soft ones.
    along = fold_coordinate(points) + 0.25 * level
    for number in np.unique(bed[strength > 0.6]):
        inside = bed == number
        thickness = boundaries[number + 1] - boundaries[number]
        places = np.cumsum(rng.gamma(6, thickness * 0.24, size=60)) - 6.0
        wander = 0.03 * np.sin(9 * level[inside] + number)
        distance = np.abs(along[inside][:, None] + wander[:, None] - places).min(axis=1)
        light[inside] -= 0.38 * np.exp(-((distance / (1.1 * pixel)) ** 2))

    # Light from above: what lies under a ledge is darker, its lip is brighter.
    out = points @ OUTWARD + LEAN * points[..., 2]
    for size, depth in ((0.08, 2.6), (0.3, 0.9)):
        light += np.clip(depth * (out - gaussian_filter(out, size / pixel)), -0.3, 0.15)
    # Water stains run down from soft beds.
    streaks = gaussian_filter(smooth_noise(rng, (1, columns), 5).repeat(rows, 0), (30, 1))
    fade = gaussian_filter(rng.normal(size=shape), (110, 14))
    stains = np.clip(streaks * 0.5 + fade / fade.std() - 0.9, 0, 1.6)
    colour = colour * (1 - 0.16 * stains[..., None]) + stains[..., None] * [3.0, -1.0, -5.0]
    rust = np.clip(smooth_noise(rng, shape, 26) - 0.9, 0, 1.5)[..., None]
    colour = colour + rust * [14.0, -2.0, -18.0]
    lichen = np.clip(smooth_noise(rng, shape, 4) + 0.7 * smooth_noise(rng, shape, 60) - 2.6, 0, 1)
    colour = colour + lichen[..., None] * [10.0, 26.0, 2.0]
    return np.clip(colour * light[..., None], 0, 255).astype(np.uint8)


def write_model(folder: Path, vertices: np.ndarray) -> None:
    """OBJ in absolute coordinates, millimetres; quads, the left and right half textured apart."""
    (folder / "outcrop.prj").write_text(CRS.from_epsg(EPSG).to_wkt("WKT1_ESRI") + "\n")
    lines = [
        f"# Generated outcrop. EPSG:{EPSG}: x east, y north, z up, metres",
        "mtllib outcrop.mtl",
    ]
    lines += ["v {:.3f} {:.3f} {:.3f}".format(*v) for v in vertices.reshape(-1, 3)]
    half = COLUMNS // 2
    texture: dict[tuple[int, int, int], int] = {}
    faces = []
    for side, name in enumerate(("rock_left", "rock_right")):
        faces.append(f"usemtl {name}")
        for row in range(ROWS):
            for column in range(side * half, (side + 1) * half):
                corners = ((0, 0), (0, 1), (1, 1), (1, 0))
                words = []
                for down, right in corners:
                    r, c = row + down, column + right
                    if (side, r, c) not in texture:
                        texture[side, r, c] = len(texture) + 1
                        lines.append(f"vt {(c - side * half) / half:.4f} {r / ROWS:.4f}")
                    words.append(f"{r * (COLUMNS + 1) + c + 1}/{texture[side, r, c]}")
                faces.append("f " + " ".join(words))
    (folder / "outcrop.obj").write_text("\n".join(lines + faces) + "\n", "ascii", newline="\n")
    materials = "".join(
        f"newmtl {name}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {name}.jpg\n\n"
        for name in ("rock_left", "rock_right")
    )
    (folder / "outcrop.mtl").write_text(materials, "ascii", newline="\n")


def trace(vertices: np.ndarray, level: float, panel: int) -> np.ndarray:
    """Where the bed surface at `level` cuts the upright edges of the mesh in one panel, (n, 3)."""
    ends = np.concatenate([[-np.inf], PANEL_ENDS, [np.inf]])
    found = []
    for column in range(COLUMNS + 1):
        edge = vertices[:, column]
        above = height_in_pile(edge) - level
        p = fold_coordinate(edge)
        for row in np.flatnonzero((above[:-1] < 0) & (above[1:] >= 0))[:1]:
            lower, upper = p[row : row + 2].min(), p[row : row + 2].max()
            # Well inside the panel, where the pile is exactly linear along the edge.
            if lower > ends[panel] + 0.1 and upper < ends[panel + 1] - 0.1:
                part = -above[row] / (above[row + 1] - above[row])
                found.append(edge[row] + part * (edge[row + 1] - edge[row]))
    return np.array(found).reshape(-1, 3)


def write_picks(
    folder: Path, rng: np.random.Generator, vertices: np.ndarray, boundaries: np.ndarray
) -> None:
    """Two bedding traces in each panel, with noise, and the orientation each truly has."""
    picks = ["trace,x,y,z"]
    truth = [
        f"# fold axis: trend {AXIS_TREND_DEG:g}, plunge {AXIS_PLUNGE_DEG:g} degrees;"
        f" noise of the picks: {1000 * NOISE_M:g} mm; grid north of EPSG:{EPSG}",
        "trace,dip_direction_deg,dip_deg",
    ]
    number = 0
    for panel in range(PANEL_SLOPES.size):
        candidates = [trace(vertices, level, panel) for level in boundaries]
        longest = max(len(points) for points in candidates)
        full = [points for points in candidates if len(points) >= max(15, 0.8 * longest)]
        for points in (full[len(full) // 4], full[(3 * len(full)) // 4]):
            number += 1
            noisy = points + rng.normal(scale=NOISE_M, size=points.shape) + ORIGIN
            picks += ["B{:02d},{:.4f},{:.4f},{:.4f}".format(number, *point) for point in noisy]
            truth.append("B{:02d},{:.4f},{:.4f}".format(number, *bed_orientation(panel)))
    (folder / "picks.csv").write_text("\n".join(picks) + "\n", "ascii", newline="\n")
    (folder / "truth.csv").write_text("\n".join(truth) + "\n", "ascii", newline="\n")


def main(arguments: list[str]) -> None:
    default = Path(__file__).resolve().parents[1] / "resources" / "outcrop"
    folder = Path(arguments[0]) if arguments else default
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(SEED)
    boundaries, hard = beds(rng)
    vertices = np.round(cliff(rng, boundaries, hard) + ORIGIN, 3)
    write_model(folder, vertices)
    vertices = vertices - ORIGIN
    picture = rock_picture(rng, vertices, boundaries, hard)
    for side, name in enumerate(("rock_left", "rock_right")):
        part = picture[:, side * IMAGE_SIZE : (side + 1) * IMAGE_SIZE]
        Image.fromarray(part).save(folder / f"{name}.jpg", quality=JPEG_QUALITY, optimize=True)
    write_picks(folder, rng, vertices, boundaries)


if __name__ == "__main__":
    main(sys.argv[1:])
