"""Lines followed in photos of an outcrop that is known by construction: a rough wall with beds,
rendered by following the lines of sight of distorted cameras to its formula."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.extraction.planes_by_construction import grid_mesh
from tests.messages import refused
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.extraction.calibrated_photos import CalibratedPhotos, open_photos
from vomstudio.extraction.photo_following import PhotoFollower
from vomstudio.extraction.photo_trace import photo_trace
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.planes import fit_plane
from vomstudio.io.photos.cameras_file import Cameras, write_cameras

LENS = Intrinsics("OPENCV", 640, 480, (560.0, 560.0, 322.0, 238.0, -0.09, 0.03, 0.0008, -0.0005))
SIZE = 4.0


@dataclass(frozen=True)
class Wall:
    """A face that looks along +z with relief h(x, y), and a dark bed in the plane n . x = d."""

    phases: np.ndarray
    normal: np.ndarray
    level: float
    half: float = 0.012

    def height(self, xy: np.ndarray) -> np.ndarray:
        x, y = xy[..., 0], xy[..., 1]
        total = np.zeros(x.shape)
        for k, (a, b, phase, size) in enumerate(self.phases):
            total = total + size * np.sin((k + 1.0) * (a * x + b * y) + phase)
        return total

    def mesh(self, step: float = 0.05) -> Mesh:
        count = round(SIZE / step) + 1
        y, x = np.mgrid[0:count, 0:count] * step
        return grid_mesh(self.height(np.stack([x, y], axis=-1)), step)

    def light(self, points: np.ndarray) -> np.ndarray:
        """Grey of the rock: mottled, so that photos can be compared, and dark on the bed."""
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        mottled = 12.0 * np.sin(23.0 * x + 3.0 * np.sin(9.0 * y)) * np.sin(19.0 * y + 7.0 * z)
        off = np.abs(points @ self.normal - self.level)
        return 165.0 + mottled - 105.0 / (1.0 + np.exp(np.minimum((off - self.half) / 0.003, 50.0)))

    def photo(self, view: View) -> np.ndarray:
        """(h, w, 3): each pixel's line of sight, followed to the face by halving."""
        y, x = np.mgrid[0 : view.intrinsics.height, 0 : view.intrinsics.width] + 0.5
        rays = view.rays(np.stack([x.ravel(), y.ravel()], axis=1))
        start = view.centre
        # The face lies between these two heights everywhere, and has no overhangs.
        near, far = ((start[2] - limit) / -rays[:, 2] for limit in (1.2, -1.2))
        for _ in range(24):
            half = 0.5 * (near + far)
            at = start + half[:, None] * rays
            above = at[:, 2] > self.height(at[:, :2])
            near, far = np.where(above, half, near), np.where(above, far, half)
        grey = np.clip(self.light(start + far[:, None] * rays), 0, 255)
        picture = np.repeat(grey[:, None], 3, axis=1).astype(np.uint8)
        return picture.reshape(view.intrinsics.height, view.intrinsics.width, 3)

    def on_bed(self, x: float) -> np.ndarray:
        """The place of the bed at this x."""
        y = np.linspace(0.0, SIZE, 40001)
        xy = np.stack([np.full_like(y, x), y], axis=-1)
        points = np.column_stack([xy, self.height(xy)])
        return points[np.argmin(np.abs(points @ self.normal - self.level))]


def looking(name: str, centre: np.ndarray, target: np.ndarray) -> View:
    forward = (target - centre) / np.linalg.norm(target - centre)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    rotation = np.array([right, np.cross(forward, right), forward])
    return View(name, LENS, rotation, -rotation @ centre)


def wall(seed: int) -> Wall:
    rng = np.random.default_rng(seed)
    turns = rng.uniform(0, 2 * np.pi, 5)
    sizes = np.array([0.16, 0.1, 0.06, 0.04, 0.03]) * rng.uniform(0.6, 1.2, 5)
    phases = np.column_stack(
        [np.cos(turns) * 1.3, np.sin(turns) * 1.3, rng.uniform(0, 6.3, 5), sizes]
    )
    normal = np.array([rng.uniform(-0.3, 0.3), 0.8, rng.uniform(0.4, 0.8)])
    normal /= np.linalg.norm(normal)
    return Wall(phases, normal, float(normal @ [2.0, 2.0, 0.0]))


def written(output: Wall, folder: Path, shift: np.ndarray | None = None, count: int = 3) -> Path:
    """Three photos and their cameras; shift : of World from the wall's own frame."""
    folder.mkdir(parents=True, exist_ok=True)
    target = np.array([2.0, 2.0, 0.0])
    views = [
        looking(f"p{i}.png", np.array(c), target)
        for i, c in enumerate([(2.0, 1.2, 4.2), (0.7, 1.6, 4.0), (3.4, 2.4, 4.1)])
    ][:count]
    for view in views:
        Image.fromarray(output.photo(view)).save(folder / view.name)
    x, y, z = (0, 0, 0) if shift is None else (int(v) for v in shift)
    write_cameras(folder / "cameras.json", Cameras(tuple(views), folder, (x, y, z)), force=True)
    return folder


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> tuple[Wall, Path]:
    output = wall(4)
    return output, written(output, tmp_path_factory.mktemp("wall"))


def opened(scene: tuple[Wall, Path], photo: str = "p0.png") -> CalibratedPhotos:
    output, folder = scene
    return open_photos(output.mesh(), 0.05, folder / photo, folder / "cameras.json")


def clicks(output: Wall) -> np.ndarray:
    return np.array([output.on_bed(x) for x in (1.0, 2.0, 3.0)])


@pytest.mark.full
@pytest.mark.parametrize("cost", ["colour", "dark"])
def test_line_follows_the_bed_to_the_pixel(scene: tuple[Wall, Path], cost: str) -> None:
    output = scene[0]
    photos = opened(scene)
    path = PhotoFollower(photos, cost).follow(photos.views.pixels(0, clicks(output)))
    # A pixel is 8 mm on the face, the bed 24 mm wide, the mesh off by some millimetres.
    off = np.abs(path.points @ output.normal - output.level)
    assert np.median(off) < 0.006
    assert np.percentile(off, 95) < 0.016
    x = path.points[:, 0]
    assert x.min() == pytest.approx(1.0, abs=0.02)
    assert x.max() == pytest.approx(3.0, abs=0.02)
    # Every vertex is the end of its pixel's line of sight through the distorted lens.
    back = photos.views.pixels(0, path.points)
    assert np.abs(back - path.pixels).max() < 1e-6
    assert np.allclose(path.pixels % 1.0, 0.5)


def test_other_photos_agree_and_are_listed(scene: tuple[Wall, Path]) -> None:
    photos = opened(scene)
    path = PhotoFollower(photos).follow(photos.views.pixels(0, clicks(scene[0])))
    assert sorted(path.voters) == ["p1.png", "p2.png"]
    assert np.median(path.seen) == 2
    assert (2 * path.agreeing >= path.seen).mean() > 0.9


@pytest.mark.full
def test_feature_visible_in_one_photo_only_is_not_followed(scene: tuple[Wall, Path]) -> None:
    """A cable before the lens: a dark line in one photo that is on no rock, and shorter."""
    output = scene[0]
    photos = opened(scene)
    inputs = photos.views.pixels(0, clicks(output)[[0, 2]])
    picture = photos.pixels(0).copy()
    along = np.linspace(0.0, 1.0, 4000)[:, None]
    cable = inputs[0] + along * (inputs[1] - inputs[0])
    cable += 30.0 * np.sin(np.pi * along) * np.array([[0.0, -1.0]])
    for down in (-2, -1, 0, 1, 2):
        x, y = np.floor(cable + [0.0, down]).astype(int).T
        picture[y, x] = 60
    spoilt = _Painted(photos, picture)

    def share_on_cable(voting: bool) -> float:
        path = PhotoFollower(spoilt, "dark", uses_votes=voting).follow(inputs)
        on_it = np.interp(path.pixels[:, 0], cable[:, 0], cable[:, 1])
        return float((np.abs(path.pixels[:, 1] - on_it) < 4.0).mean())

    assert share_on_cable(False) > 0.8
    assert share_on_cable(True) < 0.4


class _Painted(CalibratedPhotos):
    """The photos with something drawn in one of them."""

    def __init__(self, photos: CalibratedPhotos, picture: np.ndarray) -> None:
        super().__init__(photos.views, photos.view_row, photos.files, photos.cameras)
        object.__setattr__(self, "picture", picture)

    def pixels(self, view: int) -> np.ndarray:
        return self.picture if view == self.view_row else super().pixels(view)  # type: ignore[attr-defined]


@pytest.mark.full
def test_long_line_is_searched_in_reduced_images_first(
    scene: tuple[Wall, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    from vomstudio.extraction import photo_following

    output = scene[0]
    photos = opened(scene)
    inputs = photos.views.pixels(0, clicks(output)[[0, 2]])
    whole = PhotoFollower(photos, "dark").follow(inputs)
    monkeypatch.setattr(photo_following, "_MAX_NODES", 4000)
    coarse = PhotoFollower(photos, "dark").follow(inputs)
    off = np.abs(coarse.points @ output.normal - output.level)
    assert np.percentile(off, 95) < 0.016
    assert len(coarse.pixels) == pytest.approx(len(whole.pixels), rel=0.05)


@pytest.mark.full
def test_a_shifted_world_shifts_the_trace(scene: tuple[Wall, Path], tmp_path: Path) -> None:
    output = scene[0]
    shift = np.array([364_000.0, 4_721_000.0, 800.0])
    written(output, tmp_path, shift)
    mesh = output.mesh()
    moved = replace(mesh, vertices=mesh.vertices + shift)
    here, there = (
        opened(scene),
        open_photos(moved, 0.05, tmp_path / "p0.png", tmp_path / "cameras.json"),
    )
    one = PhotoFollower(here, "dark").follow(here.views.pixels(0, clicks(output)))
    other = PhotoFollower(there, "dark").follow(there.views.pixels(0, clicks(output) + shift))
    assert np.allclose(other.points - shift, one.points, atol=1e-6)


def test_cameras_use_frame_of_model_file(scene: tuple[Wall, Path]) -> None:
    """The model in feet and with y up is brought to World, and its cameras with it."""
    output, folder = scene
    turn = np.array([[0.3048, 0, 0, 0], [0, 0, -0.3048, 0], [0, 0.3048, 0, 0], [0, 0, 0, 1]])
    mesh = output.mesh()
    world = mesh.vertices @ turn[:3, :3].T
    here = opened(scene)
    there = open_photos(
        replace(mesh, vertices=world),
        0.05 * 0.3048,
        folder / "p0.png",
        folder / "cameras.json",
        turn,
    )
    points = clicks(output)
    assert np.allclose(
        there.views.pixels(0, points @ turn[:3, :3].T), here.views.pixels(0, points), atol=1e-6
    )


@pytest.mark.slow
def test_stated_95_percent_error_of_photo_traces_is_reliable(tmp_path: Path) -> None:
    held, count = 0, 30
    for seed in range(count):
        output = wall(100 + seed)
        folder = written(output, tmp_path / str(seed), count=1)
        photos = opened((output, folder))
        path = PhotoFollower(photos, "colour").follow(photos.views.pixels(0, clicks(output)))
        fit = fit_plane(path.points)
        total = total_error_deg(fit, 0.05)
        cosine = min(abs(float(fit.normal @ output.normal)), 1.0)
        held += total is not None and np.degrees(np.arccos(cosine)) <= total
    assert held / count >= 0.93


@pytest.mark.full
def test_world_and_pixel_way_points_give_same_trace(scene: tuple[Wall, Path]) -> None:
    output = scene[0]
    surface, photos = SurfaceGraph(output.mesh()), opened(scene)
    requests = {"cost": "dark", "resolution": 0.05, "model": "wall", "frame": "local"}
    inputs = clicks(output)
    one = photo_trace(surface, photos, inputs, **requests)  # type: ignore[arg-type]
    other = photo_trace(surface, photos, photos.views.pixels(0, inputs), **requests)  # type: ignore[arg-type]
    assert np.array_equal(one.points, other.points)
    assert one.snap_m < 0.02
    assert one.plane is not None
    assert one.photo == "p0.png"
    assert one.agreeing_share is not None
    assert one.to_dict().keys().isdisjoint({"points", "pixels", "seen", "agreeing"})


def test_untraceable_photo_requests_are_refused(scene: tuple[Wall, Path], tmp_path: Path) -> None:
    output, folder = scene
    photos = opened(scene)
    with refused("option.not-a-choice", UsageError, value="curvature", field="--cost"):
        PhotoFollower(photos, "curvature")
    follower = PhotoFollower(photos)
    with refused("feature.too-few-points", GeometryError, count=1, minimum=2):
        follower.follow(np.array([[10.0, 10.0]]))
    with refused("path.outside-photo", GeometryError, number=2, photo="p0.png"):
        follower.follow(np.array([[300.0, 200.0], [700.0, 200.0]]))
    with refused("points.coincident", GeometryError):
        follower.follow(np.array([[300.2, 200.2], [300.3, 200.3]]))
    ends = np.array([[2.0, 4.4], [2.0, 2.0]])
    ends = np.column_stack([ends, output.height(ends)])
    with refused("path.not-shown", GeometryError, number=1, photo="p0.png"):
        photo_trace(
            SurfaceGraph(output.mesh()),
            photos,
            ends,
            cost="dark",
            resolution=0.05,
            model="",
            frame="local",
        )
    with refused("photo.no-camera", UsageError, photo="other.png", cameras="cameras.json"):
        open_photos(output.mesh(), 0.05, folder / "other.png", folder / "cameras.json")
    with refused("file.missing", file=tmp_path / "p0.png"):
        open_photos(output.mesh(), 0.05, tmp_path / "p0.png", _alone(folder, tmp_path))
    Image.new("RGB", (100, 100)).save(tmp_path / "p0.png")
    wrong = open_photos(output.mesh(), 0.05, tmp_path / "p0.png", folder / "cameras.json")
    with pytest.raises(InputError, match="100 x 100 pixels"):
        PhotoFollower(wrong)


def _alone(folder: Path, where: Path) -> Path:
    """The cameras without their photos."""
    from vomstudio.io.photos.cameras_file import read_cameras

    result = read_cameras(folder / "cameras.json")
    path = where / "cameras.json"
    write_cameras(path, replace(result, photos=where / "none"), force=True)
    return path


def test_cameras_without_lens_and_damaged_photos_are_refused(
    scene: tuple[Wall, Path], tmp_path: Path
) -> None:
    output, folder = scene
    centres = tmp_path / "centres.csv"
    centres.write_text("name,x,y,z\np0.png,2.0,1.2,4.2\np1.png,0.7,1.6,4.0\n")
    with refused("cameras.no-poses", file=centres):
        open_photos(output.mesh(), 0.05, folder / "p0.png", centres)
    damaged = tmp_path / "p0.png"
    damaged.write_bytes((folder / "p0.png").read_bytes()[:2000])
    photos = open_photos(output.mesh(), 0.05, damaged, folder / "cameras.json")
    with pytest.raises(InputError, match=r"p0\.png"):
        PhotoFollower(photos)


def test_unreadable_voting_photo_is_reported_and_left_out(
    scene: tuple[Wall, Path], tmp_path: Path
) -> None:
    output, folder = scene
    for name in ("p0.png", "p1.png", "p2.png", "cameras.json"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "p1.png").write_bytes(b"no picture")
    photos = open_photos(output.mesh(), 0.05, tmp_path / "p0.png", tmp_path / "cameras.json")
    path = PhotoFollower(photos).follow(photos.views.pixels(0, clicks(output)))
    assert path.voters == ("p2.png",)
    (left_out,) = path.warnings
    name = Path(left_out.values["file"]).name
    assert (left_out.code, name) == ("picture.unknown-kind", "p1.png")


def test_downsized_photo_is_followed_with_its_camera(
    scene: tuple[Wall, Path], tmp_path: Path
) -> None:
    output, folder = scene
    with Image.open(folder / "p0.png") as image:
        image.resize((320, 240), Image.Resampling.BOX).save(tmp_path / "p0.png")
    photos = open_photos(output.mesh(), 0.05, tmp_path / "p0.png", folder / "cameras.json")
    path = PhotoFollower(photos, "dark").follow(photos.views.pixels(0, clicks(output)))
    off = np.abs(path.points @ output.normal - output.level)
    assert np.median(off) < 0.012
    assert path.pixels.max() < 320
