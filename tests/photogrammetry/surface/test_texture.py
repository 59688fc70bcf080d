import itertools
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from tests.messages import by_code, refused, with_code
from tests.photogrammetry import rock_face as rock
from tests.photogrammetry.surface.texture_truth import compare, sample_pages
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, GeometryError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model
from vomstudio.photogrammetry.surface.atlas import AtlasOptions
from vomstudio.photogrammetry.surface.texture import TextureOptions, make_texture
from vomstudio.studio.jobs.executors import Threads

SIZE = (360, 270)
BOX = (-0.85, 0.85, -0.6, 0.6)
LENSES = {
    "pinhole": None,
    "distorted": ("OPENCV", (-0.12, 0.03, 0.001, -0.001)),
}


def wall(n: int = 25, width: float = 2.0, height: float = 1.5) -> Mesh:
    face = rock.flat_face(width, height, rock.checker_paint(0.1), n)
    return Mesh(face.vertices, face.faces)


def cameras(lens: str = "pinhole", rows: int = 1, columns: int = 4) -> list:
    return rock.ring_of_views(
        rows,
        columns,
        spread=(0.8, 0.5),
        distance=1.6,
        size=SIZE,
        focal=280.0,
        toward=0.3,
        params=LENSES[lens],
    )


def photos(face: rock.Face, views: list, **how) -> list:
    return [
        rock.taken(
            view,
            rock.photograph(
                face,
                view,
                seed=k,
                shaded=False,
                noise=1.0,
                **{name: value[k] for name, value in how.items()},
            ),
        )
        for k, view in enumerate(views)
    ]


@pytest.fixture(scope="module")
def rock_wall():
    """A flat wall with rock on it, four photos of differing exposure."""
    face = rock.flat_face(2.0, 1.5, rock.rock_paint(3, finest=0.02))
    gains = [1.0, 1.15, 0.87, 1.05]
    return face, cameras(), gains, photos(face, cameras(), gain=gains)


def shift(drawn: np.ndarray, true: np.ndarray) -> tuple[float, float]:
    """By how many pixels a picture is displaced, to the right and down: least squares."""
    soft, like = (cv2.GaussianBlur(p, (0, 0), 1.5) for p in (drawn, true))
    down, right = np.gradient(like)
    columns = np.stack([-right, -down, like, np.ones_like(like)], -1)[4:-4, 4:-4].reshape(-1, 4)
    found = np.linalg.lstsq(columns, soft[4:-4, 4:-4].ravel(), rcond=None)[0]
    return float(found[0] / found[2]), float(found[1] / found[2])


@pytest.mark.full
@pytest.mark.parametrize("lens", first_in_default_tier(LENSES, 1))
def test_checkerboard_texture_is_positioned_within_a_tenth_of_a_texel(lens):
    face = rock.flat_face(2.0, 1.5, rock.checker_paint(0.1))
    made = make_texture(wall(), photos(face, cameras(lens)))
    step = made.report.texel_m
    seen = compare(made.mesh, made.pages, face, step=step, box=BOX, shaded=False)
    drawn, true = (p.mean(-1) for p in (seen.drawn, seen.true))
    assert seen.covered.mean() > 0.95
    for rows, columns in itertools.product((slice(0, 90), slice(90, 180)), repeat=2):
        part = rows, slice(columns.start, columns.stop + 60)
        dx, dy = shift(drawn[part], true[part])
        assert abs(dx) < 0.1
        assert abs(dy) < 0.1
    assert seen.likeness(1.0) > 0.97


@pytest.mark.full
def test_photo_gains_are_estimated(rock_wall):
    _, views, gains, taken = rock_wall
    found = make_texture(wall(), taken).report.gains
    product = np.array([np.array(found[v.name]) * g for v, g in zip(views, gains, strict=True)])
    np.testing.assert_allclose(product / product.mean(axis=0), 1.0, atol=0.01)


def test_differing_exposures_leave_neither_stains_nor_seams(rock_wall):
    face, _, _, taken = rock_wall
    made = make_texture(wall(), taken)
    seen = compare(made.mesh, made.pages, face, step=made.report.texel_m, box=BOX, shaded=False)
    assert seen.low_error(6.0) < 1.5
    assert seen.sharpness(0.8) > 0.9
    assert seen.likeness(0.8) > 0.93


@pytest.mark.full
def test_blurred_photo_is_used_only_where_no_sharp_one_is_available():
    face = rock.flat_face(2.0, 1.5, rock.rock_paint(3, finest=0.02))
    views = cameras()
    plain = make_texture(wall(), photos(face, views)).report
    soft = make_texture(wall(), photos(face, views, blur=[0, 0, 2.5, 0])).report
    name = views[2].name
    assert soft.sharpness[name] < 0.75
    assert soft.drawn_share[name] < 0.6 * plain.drawn_share[name]


def green(seen) -> float:
    """How far green exceeds red where it does most, smoothed, against the truth."""
    excess = cv2.GaussianBlur(seen.residual[..., 1] - seen.residual[..., 0], (0, 0), 1.5)
    return float(excess[seen.covered].max())


@pytest.mark.full
def test_occluder_in_one_photo_does_not_appear_in_the_texture(rock_wall):
    face, views, _, _ = rock_wall
    blocked = [None, (180.0, 130.0, 40.0, 55.0), None, None]
    made = make_texture(wall(), photos(face, views, occluder=blocked))
    seen = compare(made.mesh, made.pages, face, step=made.report.texel_m, box=BOX, shaded=False)
    assert green(seen) < 25
    left_out = made.report.left_out_share
    assert left_out[views[1].name] > 0.05
    assert left_out[views[3].name] < 0.03


def test_masked_part_does_not_appear_in_the_texture_of_two_photos(rock_wall):
    face, views, _, _ = rock_wall
    blocked = (180.0, 130.0, 40.0, 55.0)
    taken = photos(face, views[:2], occluder=[None, blocked])
    assert green(_compared(face, make_texture(wall(), taken))) > 40
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    hidden = ((x - 180) / 42) ** 2 + ((y - 130) / 57) ** 2 < 1
    mask = np.where(hidden, 0, 255).astype(np.uint8)
    taken[1] = SimpleNamespace(
        photo=taken[1].photo, mask=cv2.imencode(".png", mask)[1].tobytes(), view=views[1]
    )
    assert green(_compared(face, make_texture(wall(), taken))) < 20


def _compared(face, made):
    return compare(made.mesh, made.pages, face, step=made.report.texel_m, box=BOX, shaded=False)


def test_pillar_does_not_appear_on_the_wall_behind_it():
    def paint(points):
        return np.where(points[:, 1:2] < -0.15, [200.0, 40.0, 40.0], [110.0, 120.0, 130.0])

    def both(n: int) -> tuple:
        back = rock.flat_face(2.0, 1.5, paint, n)
        pillar = rock.flat_face(0.15, 1.2, paint, max(n // 2, 2))
        vertices = np.concatenate([back.vertices, pillar.vertices + [0.0, -0.3, 0.0]])
        faces = np.concatenate([back.faces, pillar.faces + len(back.vertices)])
        return vertices, faces.astype(np.int32)

    face = rock.Face(*both(2), paint)
    taken = photos(face, cameras())
    made = make_texture(Mesh(*both(41)), taken)
    middle = made.mesh.vertices[made.mesh.faces].mean(axis=1)
    on_wall = np.flatnonzero(middle[:, 1] > -0.1)
    third = np.full((len(on_wall), 2), 1 / 3)
    colors = sample_pages(made.mesh, made.pages, on_wall, third)
    assert (colors[:, 0] - colors[:, 2]).max() < 20


def test_unseen_faces_are_counted_and_take_the_colour_of_neighbours(rock_wall):
    _, _, _, taken = rock_wall
    tall = wall(41, 2.0, 2.8)
    made = make_texture(tall, taken)
    report = made.report
    assert 0.3 < report.unseen_share < 0.5
    assert with_code(report.warnings, "texture.unseen")
    assert sum(report.seen_by_share.values()) == pytest.approx(1)
    assert sum(report.drawn_share.values()) == pytest.approx(1 - report.unseen_share)
    assert made.mesh.colors is not None
    assert made.mesh.colors.min() > 20
    assert min(page[page.sum(-1) == 0].size for page in made.pages) == 0


def owners(mesh: Mesh, page: int, shape: tuple[int, int], grow: float = 0.0) -> np.ndarray:
    """How many faces hold each texel's centre well inside; and which chart has it."""
    count = np.zeros(shape, int)
    start, stop = mesh.material_offsets[page : page + 2]
    for f in range(start, stop):
        x, y = (mesh.uv[mesh.faces[f]].astype(float) * [shape[1], -shape[0]] + [0, shape[0]]).T
        i0, i1 = int(x.min()), int(x.max()) + 1
        j0, j1 = int(y.min()), int(y.max()) + 1
        jj, ii = np.mgrid[j0 : min(j1 + 1, shape[0]), i0 : min(i1 + 1, shape[1])]
        det = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0])
        if det == 0:
            continue
        px, py = ii + 0.5 - x[0], jj + 0.5 - y[0]
        u = (px * (y[2] - y[0]) - py * (x[2] - x[0])) / det
        v = ((x[1] - x[0]) * py - (y[1] - y[0]) * px) / det
        inside = (u > 1e-3) & (v > 1e-3) & (u + v < 1 - 1e-3)
        count[jj[inside], ii[inside]] += 1
    return count


def test_pages_contain_every_face_once_and_respect_the_maximum_size():
    face = rock.rough_face(3.0, 2.0, 0.05)
    views = rock.ring_of_views(1, 3, spread=(2.0, 0), distance=2.2, size=SIZE, focal=280.0)
    taken = photos(face, views)
    options = TextureOptions(atlas=AtlasOptions(page=128))
    made = make_texture(Mesh(face.vertices, face.faces), taken, options)
    assert len(made.pages) > 1
    assert len(made.mesh.faces) == len(face.faces)
    assert len(made.mesh.materials) == len(made.pages)
    assert made.mesh.uv.min() >= 0
    assert made.mesh.uv.max() <= 1
    for number, page in enumerate(made.pages):
        assert max(page.shape) <= 128
        assert owners(made.mesh, number, page.shape[:2]).max() <= 1
    corners = made.mesh.vertices[made.mesh.faces]
    old = face.vertices[face.faces]
    np.testing.assert_allclose(
        np.sort(corners.mean(1) @ [1.0, 10.0, 100.0]), np.sort(old.mean(1) @ [1.0, 10.0, 100.0])
    )


def texel_ratio(made, photos: list) -> float:
    """90 % quantile over the area of the texels in pixels of the nearest photo."""
    corners = made.mesh.vertices[made.mesh.faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(a, b), axis=1) / 2
    (page,) = made.pages
    uv = made.mesh.uv[made.mesh.faces].astype(float) * page.shape[1::-1]
    u, v = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    texels = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2
    distance = np.min(
        [np.linalg.norm(corners.mean(1) - p.view.centre, axis=1) for p in photos], axis=0
    )
    ratio = np.sqrt(area / texels) * photos[0].view.intrinsics.focal[0] / distance
    order = np.argsort(ratio)
    sums = np.cumsum(area[order])
    return float(ratio[order][np.searchsorted(sums, 0.9 * sums[-1])])


@pytest.mark.parametrize("slanting_deg", [0.0, 55.0])
def test_texels_follow_the_pixels_of_the_best_photo(slanting_deg: float) -> None:
    """Also of photos that see a face at a slant and near their borders."""
    face, mesh = rock.flat_face(2.0, 1.5, rock.checker_paint(0.1), 25), wall()
    turn = np.radians(slanting_deg)
    lens = Intrinsics.pinhole(*SIZE, 150.0, SIZE[0] / 2, SIZE[1] / 2)
    place = 1.6 * np.array([np.sin(turn), -np.cos(turn), 0.0])
    views = [rock.looking(f"{k}.png", lens, place + [0.1 * k, 0, 0], (0, 0, 0)) for k in range(2)]
    taken = photos(face, views)
    made = make_texture(mesh, taken)
    assert made.report.texel_ratio == pytest.approx(texel_ratio(made, taken), rel=0.05)
    assert made.report.texel_ratio < 1.3
    assert "texture.pages-full" not in {w.code for w in made.report.warnings}
    small = TextureOptions(atlas=AtlasOptions(page=64, max_pages=1))
    report = make_texture(mesh, taken, small).report
    assert report.texel_ratio > 1.3
    finding = by_code(report.warnings)["texture.pages-full"]
    assert finding["factor"] == report.texel_ratio


def test_a_part_in_close_up_has_finer_texels_than_the_rest() -> None:
    face, mesh = rock.flat_face(2.0, 1.5, rock.checker_paint(0.1), 41), wall(41)
    lens = Intrinsics.pinhole(*SIZE, 280.0, SIZE[0] / 2, SIZE[1] / 2)
    views = [
        rock.looking(f"far{k}.png", lens, (0.1 * k, -2.4, 0), (0.1 * k, 0, 0)) for k in range(2)
    ]
    views += [
        rock.looking(f"near{k}.png", lens, (-0.5, -0.4, z), (-0.5, 0, z))
        for k, z in enumerate((-0.3, 0.3))
    ]
    taken = photos(face, views)
    made = make_texture(mesh, taken)
    assert made.report.texel_ratio < 1.3
    # All of it in the pixels of the close-ups would have many more texels.
    near = 0.4 / 280.0
    assert sum(w * h for w, h in made.report.pages) < 0.5 * 2.0 * 1.5 / near**2
    assert made.report.texel_m > 2 * near


def test_self_occluding_overhang_does_not_overlap_in_the_atlas(monkeypatch):
    """A sheet folded into an S: three layers along one direction, most of it out of sight."""
    monkeypatch.setattr("vomstudio.photogrammetry.surface.orientation.MAX_UNSEEN_SHARE", 1.0)
    s = np.linspace(0, 3, 61)
    x = np.where(s < 1, s, np.where(s < 2, 2 - s, s - 2))
    y = s * 0.2
    xx, zz = np.meshgrid(x, np.linspace(0, 1, 15))
    yy = np.broadcast_to(y, xx.shape)
    sheet = Mesh(np.stack([xx, yy, zz], -1).reshape(-1, 3), rock.grid_faces(*xx.shape))
    lens = cameras()[0].intrinsics
    view = rock.looking("a.png", lens, np.array([0.5, -3.0, 0.5]), np.array([0.5, 0.0, 0.5]))
    picture = np.full((SIZE[1], SIZE[0], 3), 120, np.uint8)
    made = make_texture(sheet, [rock.taken(view, picture)])
    for number, page in enumerate(made.pages):
        assert owners(made.mesh, number, page.shape[:2]).max() <= 1


@pytest.mark.parametrize("ending", [".obj", ".glb", ".ply"])
def test_a_texture_survives_writing_and_reading(tmp_path, rock_wall, ending):
    made = make_texture(wall(), rock_wall[3])
    path = tmp_path / f"wall{ending}"
    origin = (576_000, 5_188_000, 120)
    made.write(path, origin=origin, crs="EPSG:32632")
    loaded = read_model(path).data
    assert loaded.materials[0].texture is not None
    page = cv2.imread(str(loaded.materials[0].texture))[..., ::-1]
    assert np.abs(page.astype(int) - made.pages[0]).mean() < 2
    middle = loaded.vertices[loaded.faces].mean(axis=1)
    mine = made.mesh.vertices[made.mesh.faces].mean(axis=1)
    away = np.abs(middle[:, None] - origin - mine[None]).max(-1)
    match = away.argmin(1)
    assert away.min(1).max() < 2e-3
    third = np.full((len(mine), 2), 1 / 3)
    there = sample_pages(loaded, (page,), np.arange(len(middle)), third)
    here = sample_pages(made.mesh, made.pages, match, third)
    assert np.abs(there - here).mean() < 2
    if ending == ".obj":
        assert (tmp_path / "wall.mtl").exists()
        assert (tmp_path / "wall_1.jpg").exists()


def test_the_vertices_have_the_colours_of_the_texture(rock_wall):
    made = make_texture(wall(), rock_wall[3])
    corner = made.mesh.faces[:, 0]
    drawn = sample_pages(
        made.mesh, made.pages, np.arange(len(made.mesh.faces)), np.zeros((len(corner), 2))
    )
    assert made.mesh.colors is not None
    assert np.corrcoef(drawn[:, 1], made.mesh.colors[corner, 1])[0, 1] > 0.7


def test_threads_give_an_identical_texture(rock_wall):
    one = make_texture(wall(), rock_wall[3])
    two = make_texture(wall(), rock_wall[3], executor=Threads(2))
    for a, b in zip(one.pages, two.pages, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(one.mesh.uv, two.mesh.uv)


def test_far_coordinates_draw_the_same_texture(rock_wall):
    far = np.array([576_700.0, 5_188_150.0, 160.0])
    near = make_texture(wall(), rock_wall[3])
    moved = [
        SimpleNamespace(photo=p.photo, mask=None, view=p.view.moved(1.0, np.eye(3), far))
        for p in rock_wall[3]
    ]
    there = make_texture(Mesh(wall().vertices + far, wall().faces), moved)
    for a, b in zip(near.pages, there.pages, strict=True):
        assert np.abs(a.astype(int) - b).mean() < 0.1


def test_photos_that_see_nothing_are_reported(rock_wall):
    _, views, _, taken = rock_wall
    lens = views[0].intrinsics
    aside = rock.looking("aside.png", lens, np.array([0, -9.0, 0]), np.array([0, -20.0, 0]))
    away = SimpleNamespace(photo=taken[0].photo, mask=None, view=aside)
    with refused("texture.no-photo-sees", GeometryError):
        make_texture(wall(), [away])
    made = make_texture(wall(), [*taken, away])
    (finding,) = with_code(made.report.warnings, "texture.photo-sees-nothing")
    assert finding.values["photo"] == "aside.png"


def test_bad_photos_and_meshes_are_rejected(rock_wall):
    _, views, _, taken = rock_wall
    with refused("texture.no-photos", GeometryError):
        make_texture(wall(), [])
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    with refused("texture.no-triangles", GeometryError):
        make_texture(empty, taken)
    broken = SimpleNamespace(photo=taken[0].photo[:500], mask=None, view=views[0])
    with refused("photo.unreadable"):
        make_texture(wall(), [broken])
    small = rock.encoded(np.zeros((20, 30, 3), np.uint8))
    other = SimpleNamespace(photo=small, mask=None, view=views[0])
    with refused("photo.other-size"):
        make_texture(wall(), [other])


def test_cancelled_texturing_stops(rock_wall):
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        make_texture(wall(), rock_wall[3], progress=SilentProgress(token))
