"""Sets of photos as strangers bring them: buildings, drones, phones, boulders; cameras are known.

Every survey is a made scene, its true cameras, and what the files say of themselves, which may be
nothing, or wrong. The world is that of `rock_face`: x East, y North, z up, metres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from tests.io.photos import photo_maker
from tests.photogrammetry import rock_face
from tests.photogrammetry.rock_face import Array, Face, looking
from vomstudio.geometry.cameras import Intrinsics, View

LATITUDE, LONGITUDE, GROUND = 46.0, 11.0, 300.0
SIZE = (1296, 864)


@dataclass(frozen=True, eq=False)
class Survey:
    """face : what is there; views : true cameras, named as the files are
    said : EXIF focal length on 36 mm film of each photo, None where the file says nothing
    gps_m : error of the positions in EXIF, None for none
    """

    name: str
    face: Face
    views: tuple[View, ...]
    said: tuple[float | None, ...]
    gps_m: float | None = None
    makers: tuple[str, ...] = ()
    gains: tuple[float, ...] = field(default=())

    @property
    def centres(self) -> Array:
        return np.array([view.centre for view in self.views])

    def write(self, folder: Path, *, samples: int = 2) -> Path:
        """The photos, where they are not there yet."""
        folder.mkdir(parents=True, exist_ok=True)
        rng = np.random.default_rng(17)
        places = self.centres + rng.normal(0, self.gps_m or 0.0, (len(self.views), 3))
        for row, view in enumerate(self.views):
            path = folder / view.name
            if path.exists():
                continue
            gain = self.gains[row] if self.gains else 1.0
            pixels = rock_face.photograph(self.face, view, seed=row, samples=samples, gain=gain)
            options: dict[str, Any] = {}
            said = self.exif(row, places[row])
            if said:
                options["exif"] = photo_maker.exif_bytes(**said)
            if path.suffix == ".jpg":
                options["quality"] = 95
            Image.fromarray(pixels).save(path, **options)
        return folder

    def exif(self, row: int, place: Array) -> dict[str, Any]:
        said = self.said[row]
        found: dict[str, Any] = {}
        if said is not None:
            maker = self.makers[row] if self.makers else "Maker"
            found["main"] = {0x010F: photo_maker.text(maker), 0x0110: photo_maker.text("Model")}
            found["exif"] = {
                0x920A: photo_maker.rational(said / 1.5),
                0xA405: photo_maker.short(round(said)),
            }
        if self.gps_m is not None:
            metres = 111_195.0
            east = metres * np.cos(np.radians(LATITUDE))
            found["gps"] = photo_maker.at(
                LATITUDE + place[1] / metres, LONGITUDE + place[0] / east, GROUND + place[2]
            )
        return found


# --- cameras ------------------------------------------------------------------------------------
def lens(
    focal: float, size: tuple[int, int] = SIZE, bent: Sequence[float] = (), off=(0.0, 0.0)
) -> Intrinsics:
    """focal : in long sides; bent : k1, k2, p1, p2; off : of the principal point, pixels"""
    f = focal * max(size)
    cx, cy = size[0] / 2 + off[0], size[1] / 2 + off[1]
    if not bent:
        return Intrinsics.pinhole(*size, f, cx, cy)
    return Intrinsics("OPENCV", *size, (f, f, cx, cy, *(*bent, 0.0, 0.0, 0.0, 0.0)[:4]))


def upright(camera: Intrinsics) -> Intrinsics:
    """The same camera, held upright or its photo turned by a program."""
    named = (camera.height, camera.width)
    f = camera.focal[0]
    return Intrinsics.pinhole(*named, f, named[0] / 2, named[1] / 2)


def arc(
    count: int,
    camera: Intrinsics | Sequence[Intrinsics],
    *,
    distance: float,
    half_deg: float,
    height: float = 0.0,
    target: Sequence[float] = (0.0, 0.0, 0.0),
    ending: str = ".png",
    jitter: float = 0.03,
    seed: int = 3,
) -> list[View]:
    """Cameras on an arc south of the target, all looking at it more or less."""
    rng = np.random.default_rng(seed)
    cameras = [camera] * count if isinstance(camera, Intrinsics) else list(camera)
    views = []
    for i, angle in enumerate(np.radians(np.linspace(-half_deg, half_deg, count))):
        out = distance * (1 + rng.normal(0, jitter))
        place = np.array([out * np.sin(angle), -out * np.cos(angle), height])
        place += np.asarray(target) + rng.normal(0, jitter * distance / 3, 3)
        aim = np.asarray(target) + rng.normal(0, 0.03 * distance, 3) * [1, 0, 0.5]
        views.append(
            looking(f"{i + 1:04d}{ending}", cameras[i], place, aim, float(rng.normal(0, 1.5)))
        )
    return views


def block(
    rows: int,
    columns: int,
    camera: Intrinsics,
    *,
    height: float,
    step: tuple[float, float],
    tilt_deg: float = 0.0,
    heading_deg: float = 0.0,
    first: int = 0,
    seed: int = 5,
) -> list[View]:
    """A drone's flight lines; tilted photos look to `heading_deg`."""
    rng = np.random.default_rng(seed)
    views = []
    for r in range(rows):
        for c in range(columns):
            c_ = c if r % 2 == 0 else columns - 1 - c
            place = np.array(
                [(c_ - (columns - 1) / 2) * step[0], (r - (rows - 1) / 2) * step[1], height]
            ) + rng.normal(0, 0.015 * height, 3)
            tilt, heading = np.radians(tilt_deg), np.radians(heading_deg)
            away = np.tan(tilt) * height * np.array([np.sin(heading), np.cos(heading), 0])
            back = place - away * (tilt_deg > 0)
            aim = np.array([*place[:2], 0.0]) + rng.normal(0, 0.02 * height, 3) * [1, 1, 0]
            views.append(looking(f"DJI_{first + len(views) + 1:04d}.jpg", camera, back, aim))
    return views


# --- places -------------------------------------------------------------------------------------
def facade(width: float = 24.0, height: float = 11.0, seed: int = 5) -> Face:
    """A building: weakly textured plaster, rows of equal windows set back, two round towers."""
    step = 0.05
    nx, nz = int(width / step) + 1, int(height / step) + 1
    x, z = np.linspace(-width / 2, width / 2, nx), np.linspace(-height / 2, height / 2, nz)
    xx, zz = np.meshgrid(x, z)
    depth = np.zeros_like(xx)
    for middle in (-0.3 * width, 0.3 * width):
        inside = np.clip(1 - ((xx - middle) / 2.2) ** 2, 0, None)
        depth -= 2.0 * np.sqrt(inside)
    window = _windows(xx, zz)
    depth += 0.35 * window
    depth -= 0.5 * ((zz > 0.38 * height) & (zz < 0.42 * height))
    stone = rock_face.rock_paint(seed, 0.035)

    def paint(points: Array) -> Array:
        tone = stone(points)
        calm = 165 + 0.45 * (tone - 118)
        glass = _windows(points[:, 0], points[:, 2])[:, None] > 0
        return np.where(glass, 0.35 * tone, calm)

    vertices = np.stack([xx, depth, zz], -1).reshape(-1, 3)
    return Face(vertices, rock_face.grid_faces(nz, nx), paint)


def _windows(x: Array, z: Array) -> Array:
    return ((x % 2.4 < 1.0) & ((z + 0.3) % 2.8 < 1.5)).astype(float)


def courtyard(size: float = 14.0, height: float = 8.0) -> Face:
    """Three walls about a court, open to the south, and its floor."""
    back = rock_face.rough_face(size, height, 0.05, seed=11, joints=False)
    side = rock_face.rough_face(size, height, 0.05, seed=12, joints=False)
    floor = rock_face.rough_face(size, size, 0.08, seed=13, joints=False)
    parts = []
    flat = np.array([1, 0.4, 1])
    parts.append((back.vertices * flat + [0, size / 2, 0], back.faces))
    v = side.vertices * flat
    parts.append((np.column_stack([v[:, 1] + size / 2, -v[:, 0], v[:, 2]]), side.faces))
    parts.append((np.column_stack([-v[:, 1] - size / 2, v[:, 0], v[:, 2]]), side.faces))
    v = floor.vertices * [1, 0.15, 1]
    parts.append((np.column_stack([v[:, 0], v[:, 2], -v[:, 1] - height / 2]), floor.faces))
    return joined(parts, rock_face.rock_paint(9, 0.03))


def joined(parts: Sequence[tuple[Array, Any]], paint: Callable[[Array], Array]) -> Face:
    starts = np.cumsum([0, *(len(v) for v, _ in parts)])
    vertices = np.concatenate([v for v, _ in parts])
    faces = np.concatenate([f + s for (_, f), s in zip(parts, starts[:-1], strict=True)])
    return Face(vertices, faces.astype(np.int32), paint)


def ground(width: float = 110.0, height: float = 90.0, seed: int = 21, finest: float = 0.1) -> Face:
    """A shore seen from above: relief of a few metres."""
    scale = 8.0
    face = rock_face.rough_face(width / scale, height / scale, 0.03, seed=seed)
    v = face.vertices * scale * [1, 0.6, 1]
    return Face(
        np.column_stack([v[:, 0], v[:, 2], -v[:, 1]]),
        face.faces,
        rock_face.rock_paint(seed, finest),
    )


def boulder(radius: float = 1.5, seed: int = 31) -> Face:
    """A lump of rock on the ground."""
    from scipy.ndimage import map_coordinates

    rng = np.random.default_rng(seed)
    noise = rock_face.lattice(rng, 48)
    n = 420
    u, w = np.meshgrid(np.linspace(0, 2 * np.pi, 2 * n), np.linspace(0.001, np.pi - 0.001, n))
    out = np.stack([np.cos(u) * np.sin(w), np.sin(u) * np.sin(w), np.cos(w)], -1).reshape(-1, 3)
    bumps = sum(
        a * map_coordinates(noise, (out * c + 7).T, order=3, mode="grid-wrap")
        for c, a in ((1.2, 0.12), (2.7, 0.07), (6.0, 0.03), (14.0, 0.012), (30, 0.005))
    )
    lump = out * (radius * (1 + bumps))[:, None] * [1.2, 0.9, 0.8]
    floor = rock_face.rough_face(14, 14, 0.05, seed=seed, joints=False).vertices * [1, 0.3, 1]
    floor = np.column_stack([floor[:, 0], floor[:, 2], -floor[:, 1] - 0.7 * radius])
    k = int(14 / 0.05) + 1
    grid = rock_face.grid_faces(n, 2 * n)[:, ::-1]
    return joined(
        [(lump, grid), (floor, rock_face.grid_faces(k, k))], rock_face.rock_paint(seed, 0.008)
    )


# --- surveys ------------------------------------------------------------------------------------
def _nothing(views: Sequence[View]) -> tuple[None, ...]:
    return (None,) * len(views)


def castle() -> Survey:
    """A facade in 10 wide-baseline photos, straightened, without a word of EXIF."""
    views = arc(10, lens(0.9, off=(-6, 7)), distance=17, half_deg=42)
    return Survey("castle", facade(), tuple(views), _nothing(views))


def fountain(count: int = 8) -> Survey:
    """A face of strong relief in few photos, straightened, without EXIF."""
    views = arc(count, lens(0.9), distance=9, half_deg=38, seed=4)
    return Survey("fountain", rock_face.rough_face(), tuple(views), _nothing(views))


def court() -> Survey:
    """Three walls from inside by a DSLR: 30 degrees between neighbours, a lens with distortion."""
    camera = lens(0.72, bent=(-0.12, 0.09, 0.0008, -0.0005), off=(9, -5))
    views = []
    rng = np.random.default_rng(8)
    for i, angle in enumerate(np.radians(np.linspace(-105, 105, 12))):
        place = np.array([-3.5 * np.sin(angle), -1.5 - 3 * np.cos(angle), -2.2])
        place += rng.normal(0, 0.3, 3)
        aim = np.array([7 * np.sin(angle), 7 * np.cos(angle), 0.0])
        views.append(looking(f"DSC_{i + 400:04d}.jpg", camera, place, aim))
    return Survey("court", courtyard(), tuple(views), (26.0,) * len(views))


def nadir(said: float | None = 25.0, gps: float | None = 2.0, name: str = "nadir") -> Survey:
    """A drone's block, straight down only."""
    camera = lens(25.4 / 36, bent=(0.02, -0.03))
    views = block(4, 5, camera, height=45, step=(15, 18))
    return Survey(name, ground(), tuple(views), (said,) * len(views), gps)


def nadir_oblique(said: float | None = 25.0) -> Survey:
    """The same with two lines of obliques."""
    camera = lens(25.4 / 36, bent=(0.02, -0.03))
    views = block(3, 5, camera, height=45, step=(15, 20))
    for heading in (0, 90, 180, 270):
        views += block(
            1,
            3,
            camera,
            height=40,
            step=(16, 16),
            tilt_deg=35,
            heading_deg=heading,
            first=len(views),
            seed=heading,
        )
    name = "nadir and oblique" + ("" if said else ", no EXIF")
    return Survey(name, ground(), tuple(views), (said,) * len(views), 2.0)


def phones(said: bool = True) -> Survey:
    """One phone, its three lenses and both ways to hold it; one lens only once."""
    wide, one, tele = lens(26 / 36, bent=(0.05, -0.06)), lens(35 / 36), lens(52 / 36)
    chosen = [
        wide,
        wide,
        upright(wide),
        one,
        wide,
        tele,
        upright(wide),
        tele,
        wide,
        one,
        wide,
        wide,
    ]
    chosen += [tele, upright(tele)]
    views = arc(len(chosen), chosen, distance=10, half_deg=35, ending=".jpg", seed=6)
    film = tuple(c.focal[0] / max(c.width, c.height) * 36 for c in chosen)
    name = "phone, three lenses" + ("" if said else ", no EXIF")
    return Survey(name, rock_face.rough_face(), tuple(views), film if said else _nothing(views))


def bent_lens(said: float | None = None) -> Survey:
    """A wide lens with strong distortion."""
    camera = lens(0.62, bent=(-0.28, 0.09, 0.001, 0.0005), off=(8, 6))
    views = arc(12, camera, distance=8, half_deg=35, seed=9, ending=".jpg")
    name = "strong distortion" + ("" if said else ", no EXIF")
    return Survey(name, rock_face.rough_face(), tuple(views), (said,) * len(views))


def two_cameras(exif: bool) -> Survey:
    """Two cameras of equal size of photo and different lens, files that do not tell them apart."""
    a, b = lens(0.75, bent=(-0.08, 0.03)), lens(1.15)
    views = arc(14, [a, b] * 7, distance=10, half_deg=35, seed=12, ending=".jpg")
    said = tuple([27.0, 41.0] * 7) if exif else _nothing(views)
    name = "two cameras" + ("" if exif else ", no EXIF")
    return Survey(name, rock_face.rough_face(), tuple(views), said)


def around(count: int = 24, said: float | None = 35.0) -> Survey:
    """A boulder, walked around."""
    camera = lens(35 / 36, bent=(-0.06, 0.04))
    rng = np.random.default_rng(2)
    views = []
    for i, angle in enumerate(np.linspace(0, 2 * np.pi, count, endpoint=False)):
        out = 5.0 + rng.normal(0, 0.2)
        place = np.array([out * np.cos(angle), out * np.sin(angle), 0.9 + rng.normal(0, 0.2)])
        views.append(looking(f"P{i:07d}.jpg", camera, place, rng.normal(0, 0.1, 3)))
    name = f"boulder, {count} photos" + ("" if said else ", no EXIF")
    return Survey(name, boulder(), tuple(views), (said,) * count)


def strip(count: int = 40, said: float | None = 35.0) -> Survey:
    """A long low cliff, walked along, every photo face on."""
    camera = lens(35 / 36, bent=(-0.06, 0.04))
    face = rock_face.rough_face(112.0, 9.0, 0.06, seed=41)
    rng = np.random.default_rng(6)
    views = []
    for i, x in enumerate(np.linspace(-50, 50, count)):
        place = np.array([x, -10 + rng.normal(0, 0.5), rng.normal(-1.0, 0.15)])
        aim = place + [rng.normal(0, 0.6), 10, 0.8 + rng.normal(0, 0.3)]
        views.append(looking(f"IMG_{i + 1:04d}.jpg", camera, place, aim, float(rng.normal(0, 1))))
    name = "strip" + ("" if said else ", no EXIF")
    return Survey(
        name,
        Face(face.vertices, face.faces, rock_face.rock_paint(41, 0.025)),
        tuple(views),
        (said,) * count,
    )


def wrong_exif(count: int = 12, half_deg: float = 35.0) -> Survey:
    """A focal length in EXIF that is 25 % off."""
    camera = lens(35 / 36, bent=(-0.06, 0.04))
    views = arc(count, camera, distance=9, half_deg=half_deg, seed=14, ending=".jpg")
    name = f"wrong EXIF, {count} photos within {half_deg:g} degrees"
    return Survey(name, rock_face.rough_face(), tuple(views), (44.0,) * count)


def abreast(said: float | None = None, name: str = "abreast, no EXIF") -> Survey:
    """Eight photos side by side, all square to the face."""
    camera = lens(35 / 36, bent=(-0.06, 0.04))
    rng = np.random.default_rng(19)
    views = []
    for i, x in enumerate(np.linspace(-3.6, 3.6, 8)):
        place = np.array([x, -8.0, 0.0]) + rng.normal(0, 0.1, 3)
        views.append(looking(f"s{i}.jpg", camera, place, place + [0, 8, 0]))
    return Survey(name, rock_face.rough_face(), tuple(views), (said,) * 8)


def turned_by_program(said: float | None = None) -> Survey:
    """One camera held upright for three of its photos, which a program turned; no EXIF is left."""
    camera = lens(0.8, bent=(-0.1, 0.05))
    chosen = [camera] * 12
    views = arc(12, chosen, distance=9, half_deg=35, seed=23, ending=".jpg")
    for i in (3, 7, 8):
        f, w, h = camera.focal[0], camera.width, camera.height
        other = Intrinsics("OPENCV", h, w, (f, f, h / 2, w / 2, -0.1, 0.05, 0.0, 0.0))
        views[i] = replace(views[i], intrinsics=other)
    return Survey(
        "turned by a program, no EXIF", rock_face.rough_face(), tuple(views), (said,) * 12
    )


SURVEYS: dict[str, Callable[[], Survey]] = {
    "castle": castle,
    "fountain": fountain,
    "court": court,
    "nadir": nadir,
    "nadir-bare": lambda: nadir(None, None, "nadir, no EXIF"),
    "nadir-wrong": lambda: nadir(30.0, 2.0, "nadir, wrong EXIF"),
    "oblique": nadir_oblique,
    "oblique-bare": lambda: nadir_oblique(None),
    "phones": phones,
    "phones-bare": lambda: phones(False),
    "bent": lambda: bent_lens(22.0),
    "bent-bare": bent_lens,
    "two": lambda: two_cameras(True),
    "two-bare": lambda: two_cameras(False),
    "boulder": around,
    "boulder-few": lambda: around(14, None),
    "strip": strip,
    "strip-bare": lambda: strip(40, None),
    "wrong": wrong_exif,
    "wrong-few": lambda: wrong_exif(5, 25.0),
    "wrong-narrow": lambda: wrong_exif(8, 6.0),
    "abreast-bare": abreast,
    "abreast": lambda: abreast(35.0, "abreast"),
    "turned": turned_by_program,
}
