"""The sample outcrop as files: model, pictures, picks and the truth about them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image
from pyproj import CRS

from . import cover, geology, photos, picks, pictures, triangles
from .geology import EPSG, ORIGIN, Array
from .relief import (
    BED_LENGTH,
    BED_SD,
    HEIGHT,
    LOWEST,
    ROUGHNESS_LENGTH,
    ROUGHNESS_SD,
    WIDTH,
    Cliff,
)

SEED = 7
TILE = 512  # cells of the finest grid
TILES_ACROSS, TILES_UP = 4, 2
CELL = WIDTH / (TILE * TILES_ACROSS)
IMAGE = 896  # pixels along each side of a tile
FINER, BANDS = 2, 8
JPEG_QUALITY = 68
# How far the mesh may be off, m.
ON_ROCK, ON_COVER = 0.055, 0.22
LONG_PICK = 4.6  # m: shorter ones get a finer mesh
SPARE = 5  # away from picks triangles are halved this often less than along them


def write_sample(folder: Path, seed: int = SEED) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    cliff = Cliff(seed)
    chosen = picks.courses(cliff)
    drawn = picks.draw(cliff, chosen, np.random.default_rng([seed, 1]))
    write_tables(folder, seed, drawn)
    free = np.concatenate([np.stack([c.s, c.h], axis=1) for c in chosen])
    rows, columns = TILE * TILES_UP + 1, TILE * TILES_ACROSS + 1
    face = cover.make_face(cliff, np.random.default_rng([seed, 2]), rows, columns, free)
    image = pictures.picture(
        cliff, face, np.random.default_rng([seed, 3]), IMAGE * TILES_UP, IMAGE * TILES_ACROSS
    )
    kept, rest = cut(face, drawn, np.random.default_rng([seed, 4]))
    write_model(folder, face, kept, image)
    # The photos see it finer than the model's textures show it. In bands: memory.
    rows, columns = FINER * IMAGE * TILES_UP, FINER * IMAGE * TILES_ACROSS
    bands = [
        pictures.picture(
            cliff, face, np.random.default_rng([seed, 3]), rows, columns, (i, i + rows // BANDS)
        )
        for i in range(0, rows, rows // BANDS)
    ]
    points = (face.points().reshape(-1, 3) + ORIGIN).round(3) - ORIGIN
    own, beyond = np.concatenate(kept), np.concatenate(rest)
    photos.write_photos(folder, face, free, np.concatenate(bands), points, own, beyond, seed)


def cut(
    face: cover.Face, drawn: list[picks.Pick], rng: np.random.Generator
) -> tuple[list[triangles.Ints], list[triangles.Ints]]:
    """Triangles (m, 3) of every tile, rows of the face's points: the model's, and what was cut
    off."""
    points = face.points()
    allowed = np.where(face.what == cover.ROCK, ON_ROCK, ON_COVER)
    tiles = triangles.triangulate(points, allowed, _picked(face, drawn), TILE, SPARE)
    inside = _ragged(face, rng)
    whole = [inside[t].all(axis=1) for t in tiles]
    return (
        [t[w] for t, w in zip(tiles, whole, strict=True)],
        [t[~w] for t, w in zip(tiles, whole, strict=True)],
    )


def write_model(
    folder: Path,
    face: cover.Face,
    kept: list[triangles.Ints],
    image: npt.NDArray[np.uint8],
) -> None:
    """OBJ in absolute coordinates to the millimetre, a material and picture for every tile."""
    (folder / "sample.prj").write_text(CRS.from_epsg(EPSG).to_wkt("WKT1_ESRI") + "\n")
    lines = [
        f"# Generated outcrop. EPSG:{EPSG}: x east, y north, z up, metres",
        "mtllib sample.mtl",
    ]
    flat = face.points().reshape(-1, 3) + ORIGIN
    number = np.zeros(len(flat), np.int64)
    used = np.unique(np.concatenate(kept))
    number[used] = np.arange(1, len(used) + 1)
    lines += ["v {:.3f} {:.3f} {:.3f}".format(*row) for row in flat[used].tolist()]
    columns = face.s.shape[1]
    names, faces, first = [], [], 1
    for k, part in enumerate(kept):
        row, column = divmod(k, TILES_ACROSS)
        names.append(f"face_{'ab'[row]}{column + 1}")
        corners = np.unique(part)
        u = (corners % columns - column * TILE) / TILE
        v = (corners // columns - row * TILE) / TILE
        lines += [f"vt {a:.4f} {b:.4f}" for a, b in zip(u.tolist(), v.tolist(), strict=True)]
        texture = np.zeros(len(flat), np.int64)
        texture[corners] = np.arange(first, first + len(corners))
        first += len(corners)
        faces.append(f"usemtl {names[-1]}")
        both = np.stack([number[part], texture[part]], axis=-1).reshape(-1, 6)
        faces += ["f {}/{} {}/{} {}/{}".format(*row) for row in both.tolist()]
        top = (TILES_UP - 1 - row) * IMAGE
        piece = image[top : top + IMAGE, column * IMAGE : (column + 1) * IMAGE]
        Image.fromarray(piece).save(
            folder / f"{names[-1]}.jpg", quality=JPEG_QUALITY, optimize=True
        )
    (folder / "sample.obj").write_text("\n".join(lines + faces) + "\n", "ascii", newline="\n")
    materials = "".join(
        f"newmtl {name}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {name}.jpg\n\n" for name in names
    )
    (folder / "sample.mtl").write_text(materials, "ascii", newline="\n")


def _picked(face: cover.Face, drawn: list[picks.Pick]) -> npt.NDArray[np.bool_]:
    """The places of the grid along which something is measured."""
    picked = np.zeros(face.s.shape, bool)
    for pick in drawn:
        s, h = pick.points @ geology.ALONG, pick.points @ geology.UP
        along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(s), np.diff(h)))])
        at = np.arange(0.0, along[-1], CELL)
        # Corners of squares of two cells; of short picks their middles, 1.4 cells from the corners.
        middle = int(np.linalg.norm(np.ptp(pick.points, axis=0)) < LONG_PICK)
        j = 2 * np.floor(np.interp(at, along, s) / (2 * CELL)).astype(int) + middle
        i = 2 * np.floor((np.interp(at, along, h) - LOWEST) / (2 * CELL)).astype(int) + middle
        picked[i, j] = True
    return picked


def _ragged(face: cover.Face, rng: np.random.Generator) -> npt.NDArray[np.bool_]:
    """Which places (flattened) lie within the part that was photographed: its edge is uneven."""

    def edge() -> Array:
        t = np.linspace(0, 1, face.s.shape[1])
        waves = rng.uniform(4, 60, 14)
        total = sum(np.sin(w * t * 6.28 + rng.uniform(0, 6.28)) / np.sqrt(w) for w in waves)
        return np.asarray(0.30 + 0.11 * total)

    h_part, s_part = (face.h - LOWEST) / HEIGHT, face.s / WIDTH
    columns = face.s.shape[1]
    at_h = np.clip((h_part * (columns - 1)).astype(int), 0, columns - 1)
    left, right, low, high = edge()[at_h], edge()[at_h], edge()[None, :], edge()[None, :]
    inside = (face.s > left) & (face.s < WIDTH - right)
    inside &= (face.h > LOWEST + 0.8 * low) & (face.h < LOWEST + HEIGHT - 1.5 * high - 0.2)
    del s_part
    return inside.reshape(-1)


def write_tables(folder: Path, seed: int, drawn: list[picks.Pick]) -> None:
    """picks.csv, and truth.csv with the orientation that each pick has in truth."""
    lines = [
        f"# picks on sample.obj, EPSG:{EPSG}; sample seed {seed}",
        f"# beds and fault walls are uneven by {1000 * BED_SD:g} mm (1 sigma), covariance"
        f" exp(-distance / {BED_LENGTH:g} m); joints by {1000 * ROUGHNESS_SD:g} mm along the view,"
        f" exp(-distance / {ROUGHNESS_LENGTH:g} m); the hand by {1000 * picks.PICK_SD:g} mm in"
        " every direction, each point on its own",
        "pick,kind,set,horizon,x,y,z",
    ]
    for pick in drawn:
        for x, y, z in (pick.points + ORIGIN).tolist():
            words = f"{pick.name},{pick.kind},{pick.set_name},{pick.horizon}"
            lines.append(f"{words},{x:.4f},{y:.4f},{z:.4f}")
    (folder / "picks.csv").write_text("\n".join(lines) + "\n", "utf-8", newline="\n")
    truth = [
        f"# truth of the sample outcrop, seed {seed}; angles in degrees to grid north of"
        f" EPSG:{EPSG}, lengths in metres",
        "name,kind,set,dip_direction_deg,dip_deg,trend_deg,plunge_deg,length_m",
    ]
    for pick in drawn:
        dip_direction, dip = geology.plane_angles(pick.normal)
        truth.append(f"{pick.name},{pick.kind},{pick.set_name},{dip_direction:.5f},{dip:.5f},,,")
    axis = f"{geology.AXIS_TREND_DEG:.5f},{geology.AXIS_PLUNGE_DEG:.5f}"
    truth.append(f"fold axis,fold axis,,,,{axis},")
    truth.append(f"bedding and fault,intersection,,,,{axis},")
    truth.append(f"displacement,displacement,,,,,,{geology.DISPLACEMENT:.4f}")
    (folder / "truth.csv").write_text("\n".join(truth) + "\n", "utf-8", newline="\n")
