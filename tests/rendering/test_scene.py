"""What VTK draws off screen agrees with what the program computes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy

from tests.messages import with_code
from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.rendering.prepare import events, preparation
from vomstudio.rendering.scene import feature_layer, frame_drawing
from vomstudio.rendering.scene.appearance import DISPLAY_MODES
from vomstudio.rendering.scene.scene import Scene
from vomstudio.rendering.view.drawing import FeatureDrawing

SIZE = (640, 480)
UTM = np.array([576_712.0, 5_188_140.0, 183.0])


@pytest.fixture
def scene() -> Iterator[Scene]:
    made = Scene()
    made.start(*SIZE)
    yield made
    made.close()


def show(scene: Scene, model_id: str, data: Mesh | PointCloud, to_world=None) -> list[str]:  # type: ignore[no-untyped-def]
    """Prepare a model in this thread; returns the problems told."""
    stop = threading.Event()
    points = data.vertices if isinstance(data, Mesh) else data.points
    bounds = preparation.finite_bounds(points, stop)
    origin = np.round(bounds.mean(axis=0))
    scene.add_model(model_id, data, np.eye(4) if to_world is None else to_world, bounds, origin)
    told: list[Finding] = []

    def emit(event: events.Event) -> None:
        if isinstance(event, events.Problem):
            told.append(event.finding)
        else:
            scene.take(model_id, event)

    if isinstance(data, Mesh):
        preparation.prepare_mesh(data, origin, stop, emit)
        preparation.prepare_textures(data, scene.canvas.texture_limit, stop, emit)
    else:
        preparation.prepare_cloud(data, origin, stop, emit, lambda job: job())
    return told


def rest(scene: Scene) -> np.ndarray:
    scene.picture.begin_rest()
    while not scene.picture.refine():
        pass
    return scene.canvas.pixels()[::-1, :, :3].astype(int)


def wall(n: int = 40, *, textures: list[Path] | None = None, relief: float = 0.3) -> Mesh:
    """A rough wall 10 m wide and 8 m high at UTM coordinates, seen from the south."""
    rng = np.random.default_rng(0)
    x, z = np.meshgrid(np.linspace(0, 10, n + 1), np.linspace(0, 8, n + 1))
    y = rng.normal(0, relief, x.shape)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3) + UTM
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)]
    ).astype(np.int32)
    uv = np.stack([x / 10, z / 8], -1).reshape(-1, 2).astype(np.float32)
    if textures is None:
        return Mesh(vertices, faces)
    middle = np.linspace(0, len(faces), len(textures) + 1).astype(np.int64)
    materials = tuple(Material(f"m{i}", p) for i, p in enumerate(textures))
    return Mesh(vertices, faces, materials, middle, uv)


@pytest.mark.parametrize("orthographic", [False, True])
def test_drawn_points_match_the_projection(scene: Scene, orthographic: bool) -> None:
    marks = UTM + np.array([[1.0, 0.0, 1.0], [9.0, 3.0, 7.0], [5.0, -2.0, 4.0], [2.0, 1.0, 6.5]])
    colors = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]], np.uint8)
    show(scene, "c", PointCloud(marks, colors))
    scene.look.point_scale = 4.0
    scene.set_mode("textured")
    scene.camera.orthographic = orthographic
    scene.camera.look_along(20.0, 15.0)
    scene.camera.fit(marks, SIZE)
    scene.camera.zoom(1.4, scene.camera.pivot)
    picture = rest(scene)
    pixels, _ = scene.camera.project(marks, SIZE)
    for mark, color in zip(pixels, colors, strict=True):
        found = np.argwhere((np.abs(picture - color) < 12).all(axis=2))
        assert len(found) >= 16
        middle = found.mean(axis=0)[::-1] + 0.5
        assert np.abs(middle - mark).max() < 0.75


def test_frame_drawn_in_parts_equals_frame_drawn_at_once(scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "t.png"
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
    Image.fromarray(noise).save(path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(preparation, "FACES_PER_CHUNK", 200)
        show(scene, "w", wall(textures=[path]))
    assert len(scene.models["w"].parts) == 16
    scene.camera.fit(scene.corners(), SIZE)
    pieces = rest(scene)
    assert not scene.picture.is_slow
    scene.picture.draw(is_moving=False)
    whole = scene.canvas.pixels()[::-1, :, :3].astype(int)
    assert scene.picture.is_complete
    assert np.abs(pieces - whole).max() <= 2


def test_features_over_a_cached_surface_equal_a_full_redraw(scene: Scene) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    line = UTM + np.array([[1.0, 0.0, 1.0], [9.0, 0.0, 7.0]])
    ring = UTM + np.array([[3.0, -1.0, 3.0], [6.0, -1.0, 3.0], [6.0, -1.0, 6.0]])
    bare = rest(scene)
    frames = scene.canvas.frames
    scene.set_features({"f": FeatureDrawing("f", line, ring, (1.0, 0.5, 0.0), "f", line[0])})
    scene.picture.draw_features()
    assert scene.canvas.frames == frames + 1
    over = scene.canvas.pixels()[::-1, :, :3].astype(int)
    again = rest(scene)
    assert np.abs(over - again).max() <= 2
    assert (np.abs(over - bare).max(axis=2) > 40).sum() > 1000
    scene.set_features({"f": None})
    scene.picture.draw_features()
    assert np.abs(scene.canvas.pixels()[::-1, :, :3].astype(int) - bare).max() <= 2


def test_selection_over_cached_features_equals_a_full_redraw(scene: Scene) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    drawings = {}
    for k, height in enumerate((2.0, 4.0, 6.0)):
        line = UTM + np.array([[1.0, 0.0, height], [9.0, 0.0, height + 0.5]])
        drawings[f"f{k}"] = FeatureDrawing(f"f{k}", line, None, (1.0, 0.5, 0.0), "", line[0])
    scene.set_features(drawings)
    bare = rest(scene)
    for chosen in (["f0"], ["f1", "f2"], []):
        scene.set_selected(chosen)
        with pytest.MonkeyPatch.context() as patch:
            # All lines but those of the selection stay as they are.
            patch.setattr(
                scene.features, "_update_lines", only_emphasis(scene.features._update_lines)
            )
            scene.picture.draw_features()
        over = scene.canvas.pixels()[::-1, :, :3].astype(int)
        assert (np.abs(over - bare).max(axis=2) > 40).any() == bool(chosen)
        assert np.abs(over - rest(scene)).max() <= 2
    # A feature that changes is drawn anew, selected or not.
    scene.set_selected(["f0"])
    scene.set_features({"f0": None, "f1": None})
    scene.picture.draw_features()
    over = scene.canvas.pixels()[::-1, :, :3].astype(int)
    assert (np.abs(over - bare).max(axis=2) > 40).sum() > 500
    assert np.abs(over - rest(scene)).max() <= 2


@pytest.mark.parametrize("orthographic", first_in_default_tier([True, False], 1))
@pytest.mark.parametrize("near", first_in_default_tier([1.0, 0.7], 1))
def test_changing_one_of_many_features_equals_a_full_redraw(
    scene: Scene, orthographic: bool, near: float
) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.orthographic = orthographic
    scene.camera.fit(scene.corners(), SIZE)
    scene.camera.orbit(25.0, 10.0)
    scene.camera.zoom(near, UTM + np.array([6.0, 0.0, 4.0]))
    rng = np.random.default_rng(5)

    def some(name: str) -> FeatureDrawing:
        line = UTM + rng.uniform((0, -0.3, 0), (10, 0.3, 8)) + rng.normal(0, 0.4, (6, 3))
        ring = line[:4] + (0.0, 0.3, 0.0) if rng.random() < 0.5 else None
        color = (1.0, float(rng.random()), 0.2)
        return FeatureDrawing(name, line, ring, color, "", line[0], visible=rng.random() < 0.9)

    scene.set_features({f"f{k}": some(f"f{k}") for k in range(400)})
    scene.set_selected(["f3", "f7", "f350"])
    rest(scene)
    drawn = []
    for step in range(12):
        name = f"f{rng.integers(400)}"
        gone = step % 3 == 0
        scene.set_features({name: None if gone else some(name)})
        if not gone:
            scene.set_features({f"n{step}": some("n")})
        frames = scene.canvas.frames
        scene.picture.draw_features()
        assert scene.canvas.frames == frames + 1
        over = scene.canvas.pixels()[::-1, :, :3].astype(int)
        drawn.append(lines_drawn(scene))
        # All of them, over the same picture of the wall.
        scene.set_scale(1.0)
        scene.picture.draw_features()
        whole = scene.canvas.pixels()[::-1, :, :3].astype(int)
        assert np.array_equal(over, whole), step
    # Otherwise this would be two times the same.
    assert min(drawn) < 0.5 * lines_drawn(scene)


@pytest.mark.full
@pytest.mark.parametrize("orthographic", [True, False])
def test_features_drawn_in_bands_equal_those_drawn_at_once(
    scene: Scene, orthographic: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.orthographic = orthographic
    scene.camera.fit(scene.corners(), SIZE)
    scene.camera.orbit(25.0, 10.0)
    rng = np.random.default_rng(7)

    def some(name: str) -> FeatureDrawing:
        line = UTM + rng.uniform((0, -0.3, 0), (10, 0.3, 8)) + rng.normal(0, 0.4, (6, 3))
        ring = line[:4] + (0.0, 0.3, 0.0) if rng.random() < 0.5 else None
        return FeatureDrawing(name, line, ring, (1.0, float(rng.random()), 0.2), "", line[0])

    def steps(ask: Callable[[], object]) -> tuple[int, np.ndarray]:
        """How often bands had to be asked for, and the picture."""
        ask()
        count = 0
        while scene.picture.is_layering:
            assert not scene.picture.is_complete
            scene.picture.draw_band()
            count += 1
        return count, scene.canvas.pixels()[::-1, :, :3].astype(int)

    scene.set_features({f"f{k}": some(f"f{k}") for k in range(300)})
    scene.set_selected(["f3", "f7", "f299"])
    whole = {
        "rest": rest(scene),
        "draw": steps(lambda: scene.picture.draw(is_moving=False)),
        "features": steps(scene.picture.draw_features),
    }
    assert whole["draw"][0] == whole["features"][0] == 0

    monkeypatch.setattr(frame_drawing, "BAND_POINTS", 400)
    scene.canvas.is_software = True
    rested = rest(scene)
    assert scene.picture.is_complete
    assert np.array_equal(rested, whole["rest"])
    for name, ask in {
        "draw": lambda: scene.picture.draw(is_moving=False),
        "features": lambda: (scene.set_scale(1.0), scene.picture.draw_features()),
    }.items():
        count, picture = steps(ask)
        assert count == 5
        assert np.array_equal(picture, whole[name][1]), name
    # One that changes between two bands is in the picture, and so is one after the last.
    scene.set_scale(1.0)
    scene.picture.draw_features()
    scene.picture.draw_band()
    scene.set_features({"f5": some("f5"), "f9": None})
    _, over = steps(scene.picture.draw_features)
    scene.set_features({"f11": some("f11")})
    count, once_more = steps(scene.picture.draw_features)
    assert count == 0
    monkeypatch.setattr(frame_drawing, "BAND_POINTS", 10**9)
    assert np.array_equal(once_more, rest(scene))
    assert not np.array_equal(once_more, over)


def test_large_selection_drawn_in_bands_equals_one_drawn_at_once(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    rng = np.random.default_rng(9)
    lines = {f"f{k}": UTM + rng.uniform((0, -0.3, 0), (10, 0.3, 8), (6, 3)) for k in range(60)}
    scene.set_features(
        {
            k: FeatureDrawing(k, line, None, (1.0, 0.4, 0.2), "", line[0])
            for k, line in lines.items()
        }
    )
    scene.canvas.is_software = True
    rest(scene)
    pictures: dict[bool, list[np.ndarray]] = {}
    for uses_bands in (False, True):
        monkeypatch.setattr(frame_drawing, "MAX_EMPHASISED_AT_ONCE", 5 if uses_bands else 10**9)
        monkeypatch.setattr(frame_drawing, "BAND_POINTS", 100)
        pictures[uses_bands] = []
        for names in (["f1", "f2"], [f"f{k}" for k in range(0, 60, 2)], []):
            scene.set_selected(names)
            scene.picture.draw_features()
            assert scene.picture.shows_simple_emphasis == (uses_bands and len(names) > 5)
            while scene.picture.is_layering:
                scene.picture.draw_band()
            assert scene.picture.is_complete
            pictures[uses_bands].append(scene.canvas.pixels().astype(int))
        scene.set_selected([f"f{k}" for k in range(0, 60, 3)])
        pictures[uses_bands].append(rest(scene))
    assert all(map(np.array_equal, pictures[False], pictures[True]))
    assert not np.array_equal(pictures[True][0], pictures[True][1])


@pytest.mark.full
def test_lines_simplified_in_a_moving_view_are_complete_at_rest(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(feature_layer, "MIN_THIN_POINTS", 10)
    show(scene, "w", wall(relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    line = UTM + np.stack([np.linspace(0, 10, 80), np.zeros(80), np.linspace(0, 8, 80)], axis=1)
    scene.set_features({"f": FeatureDrawing("f", line, None, (1.0, 0.4, 0.2), "", line[0])})
    rested = rest(scene)
    scene.picture.draw(is_moving=True)
    assert not scene.picture.is_complete
    assert np.array_equal(rest(scene), rested)
    assert scene.picture.is_complete


def test_features_changed_during_a_banded_frame_are_drawn(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame_drawing, "BAND_POINTS", 40)
    scene.canvas.is_software = True
    show(scene, "w", wall(relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    rng = np.random.default_rng(8)

    def some(name: str) -> FeatureDrawing:
        line = UTM + rng.uniform((0, -0.3, 0), (10, 0.3, 8), (6, 3))
        return FeatureDrawing(name, line, None, (1.0, 0.4, 0.2), "", line[0])

    scene.set_features({f"f{k}": some(f"f{k}") for k in range(40)})
    # The depths that are drawn reach no further with the others.
    line = UTM + np.array([[0.0, -0.3, 0.0], [10.0, 0.3, 8.0]])
    scene.set_features({"all": FeatureDrawing("all", line, None, (1.0, 0.4, 0.2), "", line[0])})
    scene.picture.begin_rest()
    while not scene.picture.is_layering:
        assert not scene.picture.refine()
    scene.picture.refine()
    scene.set_features({f"f{k}": some(f"f{k}") for k in range(0, 40, 2)})
    scene.picture.draw_features()
    while not scene.picture.refine():
        pass
    changed = scene.canvas.pixels()[::-1, :, :3].astype(int)
    monkeypatch.setattr(frame_drawing, "BAND_POINTS", 10**9)
    assert np.array_equal(changed, rest(scene))


def lines_drawn(scene: Scene) -> int:
    """Points of the lines that the scene drew last."""
    return int(scene.features._actors["line"].GetMapper().GetInput().GetNumberOfPoints())


def only_emphasis(style_part: Callable[..., None]) -> Callable[..., None]:
    def checked(mark: str, *values: object) -> None:
        assert mark == "+"
        style_part(mark, *values)

    return checked


def test_line_behind_the_surface_is_drawn_faintly(scene: Scene) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.orthographic = True
    scene.camera.fit(scene.corners(), SIZE)
    bare = rest(scene)
    strength = []
    for depth in (0.0, 2.0):
        line = UTM + np.array([[1.0, depth, 4.0], [9.0, depth, 4.0]])
        scene.set_features({"f": FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "", line[0])})
        scene.picture.draw_features()
        picture = scene.canvas.pixels()[::-1, :, :3].astype(int)
        column = picture[:, 320] - bare[:, 320]
        strength.append(np.abs(column).max())
    assert strength[0] > 100
    assert 15 < strength[1] < 0.6 * strength[0]


def test_warming_up_the_driver_does_not_move_features(
    scene: Scene,
) -> None:
    line = UTM + np.array([[1.0, 0.0, 1.0], [9.0, 0.0, 7.0]])
    scene.set_features({"f": FeatureDrawing("f", line, None, (1.0, 0.5, 0.0), "f", line[0])})
    scene.camera.fit(line, SIZE)
    before = rest(scene)
    assert (np.abs(before - before[2, 2]).max(axis=2) > 40).sum() > 500
    for _ in scene.warm_up():
        pass
    assert np.array_equal(rest(scene), before)


def test_feature_outside_the_model_depth_range_is_drawn(scene: Scene) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.orthographic = True
    scene.camera.fit(scene.corners(), SIZE)
    bare = rest(scene)
    line = UTM + np.array([[1.0, -40.0, 4.0], [9.0, -40.0, 4.0]])
    scene.set_features({"f": FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "", line[0])})
    scene.picture.draw_features()
    picture = scene.canvas.pixels()[::-1, :, :3].astype(int)
    assert np.abs(picture[:, 320] - bare[:, 320]).max() > 100


def test_hidden_and_visible_points_are_distinguished(scene: Scene) -> None:
    show(scene, "w", wall(relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    rest(scene)
    points = UTM + np.array([[5.0, 0.0, 4.0], [5.0, 1.0, 4.0], [5.0, -1.0, 4.0], [500.0, 0, 0]])
    assert scene.visibility(points).tolist() == [True, False, True, False]


@pytest.mark.parametrize("mode", DISPLAY_MODES)
def test_every_display_mode_shows_something(scene: Scene, tmp_path: Path, mode: str) -> None:
    path = tmp_path / "t.png"
    Image.new("RGB", (8, 8), (200, 80, 20)).save(path)
    show(scene, "w", wall(textures=[path]))
    scene.camera.fit(scene.corners(), SIZE)
    scene.set_mode(mode)
    picture = rest(scene)
    changed = np.abs(picture - picture[2, 2]).max(axis=2) > 10
    assert changed.mean() > (0.02 if mode in ("wireframe", "points") else 0.4)
    if mode == "textured":
        np.testing.assert_allclose(picture[240, 320], (200, 80, 20), atol=3)


def test_each_of_several_textures_is_drawn(scene: Scene, tmp_path: Path) -> None:
    paths = []
    for i in range(4):
        paths.append(tmp_path / f"{i}.png")
        Image.new("RGB", (8, 8), (40 + 50 * i, 10, 200 - 40 * i)).save(paths[-1])
    show(scene, "w", wall(textures=paths, relief=0.0))
    scene.camera.fit(scene.corners(), SIZE)
    picture = rest(scene)
    for i in range(4):
        wanted = np.array([40 + 50 * i, 10, 200 - 40 * i])
        assert (np.abs(picture - wanted).max(axis=2) <= 3).sum() > 2000


@pytest.mark.parametrize("sides", [(64, 64), (65, 50)])
def test_tiled_texture_equals_the_whole_texture(
    scene: Scene, tmp_path: Path, sides: tuple[int, int]
) -> None:
    path = tmp_path / "t.png"
    noise = np.random.default_rng(0).integers(0, 255, (sides[1], sides[0], 3), np.uint8)
    Image.fromarray(noise).save(path)
    mesh = wall(textures=[path], relief=0.0)
    assert mesh.uv is not None
    # Beyond 0..1 a texture repeats.
    uv = mesh.uv * np.float32(1.5) - np.float32(0.2)
    mesh = Mesh(mesh.vertices, mesh.faces, mesh.materials, mesh.material_offsets, uv)
    show(scene, "w", mesh)
    scene.camera.fit(scene.corners(), SIZE)
    whole = rest(scene)
    show(scene, "w", mesh)
    stop = threading.Event()
    preparation.prepare_textures(mesh, 4096, stop, lambda e: scene.take("w", e), 32)
    (skin,) = scene.models["w"].gpu_textures.values()
    assert len(skin.texture.levels[0].tiles) == 4
    quarters = rest(scene)
    assert scene.picture.is_complete
    assert whole.std() > 40
    assert np.abs(quarters - whole).max() <= 1


def test_unreadable_texture_is_reported_and_the_surface_is_drawn(
    scene: Scene, tmp_path: Path
) -> None:
    good, torn = tmp_path / "good.png", tmp_path / "torn.jpg"
    Image.new("RGB", (8, 8), (200, 80, 20)).save(good)
    torn.write_bytes(b"\xff\xd8\xff\xe0 this is no picture")
    told = show(scene, "w", wall(textures=[good, torn, tmp_path / "absent.png"]))
    assert len(told) == 2
    unreadable = with_code(told, "display.texture-unreadable")
    assert [Path(each.values["file"]).name for each in unreadable] == ["torn.jpg", "absent.png"]
    scene.camera.fit(scene.corners(), SIZE)
    picture = rest(scene)
    assert (np.abs(picture - picture[2, 2]).max(axis=2) > 10).mean() > 0.4


def test_texture_too_large_for_the_gpu_is_reduced_and_reported(tmp_path: Path) -> None:
    from vomstudio.rendering.prepare.textures import load_texture

    path = tmp_path / "large.jpg"
    Image.new("RGB", (600, 300), (90, 120, 30)).save(path)
    texture = load_texture(path, 256)
    assert max(texture.levels[0].tiles[0].shape[:2]) <= 256
    assert texture.note.code == "display.texture-reduced"
    assert (texture.note.values["width"], texture.note.values["height"]) == (600, 300)
    assert load_texture(path, 1024).note is None
    # One side is shorter than the reduction.
    Image.new("RGB", (3, 2000), (90, 120, 30)).save(path)
    assert load_texture(path, 256).levels[0].width == 1


def test_models_in_distant_frames_are_aligned_in_world(scene: Scene) -> None:
    first = wall(relief=0.0)
    shift = np.eye(4)
    shift[:3, 3] = UTM
    second = Mesh(first.vertices - UTM, first.faces)
    show(scene, "utm", first)
    show(scene, "local", second, shift)
    scene.camera.orthographic = True
    scene.camera.fit(scene.corners(), SIZE)
    for model_id in ("utm", "local"):
        scene.set_visible("utm", model_id == "utm")
        scene.set_visible("local", model_id == "local")
        hit = scene.pick(301.3, 222.7, SIZE)
        assert hit is not None
        assert hit.model_id == model_id
        m = scene.models[model_id].to_world
        world = m[:3, :3] @ np.array(hit.position) + m[:3, 3]
        pixels, _ = scene.camera.project(world[None], SIZE)
        np.testing.assert_allclose(pixels[0], (301.3, 222.7), atol=1e-3)


@pytest.mark.parametrize("located", [True, False])
@pytest.mark.parametrize("orthographic", [False, True])
def test_a_pick_projects_back_to_its_pixel_and_lies_on_its_face(
    scene: Scene, located: bool, orthographic: bool
) -> None:
    mesh = wall()
    show(scene, "w", mesh)
    if not located:
        scene.models["w"].locators = []
    scene.camera.orthographic = orthographic
    scene.camera.look_along(25.0, 30.0)
    scene.camera.fit(scene.corners(), SIZE)
    hits = 0
    for x, y in np.random.default_rng(5).uniform(0, 1, (80, 2)) * SIZE:
        hit = scene.pick(x, y, SIZE)
        if hit is None:
            continue
        hits += 1
        assert hit.barycentric is not None
        corners = mesh.vertices[mesh.faces[hit.index]]
        np.testing.assert_allclose(np.array(hit.barycentric) @ corners, hit.position, atol=1e-9)
        pixels, _ = scene.camera.project(np.array(hit.position)[None], SIZE)
        np.testing.assert_allclose(pixels[0], (x, y), atol=0.01)
    assert hits > 20


def test_pick_on_a_cloud_returns_a_point_of_its_front(scene: Scene) -> None:
    rng = np.random.default_rng(0)
    front = rng.uniform(0, 1, (40_000, 3)) * [10.0, 0.02, 8.0]
    back = front + np.array([0.0, 3.0, 0.0])
    cloud = PointCloud(np.concatenate([back, front]) + UTM)
    show(scene, "c", cloud)
    scene.camera.fit(scene.corners(), SIZE)
    hit = scene.pick(320.0, 240.0, SIZE)
    assert hit is not None
    assert hit.element == "point"
    assert hit.index >= len(back)
    np.testing.assert_array_equal(hit.position, cloud.points[hit.index])
    pixels, _ = scene.camera.project(np.array(hit.position)[None], SIZE)
    assert np.hypot(*(pixels[0] - (320.0, 240.0))) < 6.0
    assert scene.pick(2.0, 2.0, SIZE) is None


def cliff(count: int) -> PointCloud:
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 1, (count, 3)) * [10.0, 0.5, 8.0] + UTM
    return PointCloud(points, rng.integers(40, 255, (count, 3), np.uint8))


def test_cloud_is_drawn_before_preparation_finishes(scene: Scene) -> None:
    cloud = cliff(300_000)
    bounds = preparation.finite_bounds(cloud.points, threading.Event())
    origin = np.round(bounds.mean(axis=0))
    scene.add_model("c", cloud, np.eye(4), bounds, origin)
    first = True

    def emit(event: events.Event) -> None:
        nonlocal first
        if first:
            assert isinstance(event, events.NodeReady)
            assert len(event.chunk.points) < 60_000
            scene.take("c", event)
            scene.camera.fit(scene.corners(), SIZE)
            scene.picture.draw(is_moving=False)
            picture = scene.canvas.pixels()[::-1, :, :3].astype(int)
            assert (np.abs(picture - picture[2, 2]).max(axis=2) > 10).mean() > 0.2
        first = False

    preparation.prepare_cloud(cloud, origin, threading.Event(), emit, lambda job: job())
    assert not first


def test_number_of_drawn_cloud_points_follows_the_pixel_count(scene: Scene) -> None:
    count = 1_200_000
    show(scene, "c", cliff(count))
    scene.camera.fit(scene.corners(), SIZE)
    scene.camera.zoom(6.0, UTM + np.array([5.0, 0.25, 4.0]))
    state = scene.camera.to_dict()

    def drawn() -> int:
        parts = [p for p in scene.models["c"].parts if p.row in scene.models["c"].shown_rows]
        return sum(p.elements for p in parts)

    rest(scene)
    rest(scene)
    far = drawn()
    assert 5_000 < far < 0.3 * count
    scene.camera.zoom(0.02, UTM + np.array([5.0, 0.25, 4.0]))
    rest(scene)
    assert scene.picture.is_complete
    assert scene.nodes.is_settled
    parts = scene.models["c"].parts
    shown = [p.spacing for p in parts if p.row in scene.models["c"].shown_rows]
    assert min(shown) < 0.05
    scene.camera.restore(state)
    scene.picture.draw(is_moving=True)
    assert drawn() == far


def test_coarse_nodes_close_the_surface_until_finer_ones_arrive(scene: Scene) -> None:
    cloud = cliff(400_000)
    origin = np.round(cloud.bounds.mean(axis=0))
    scene.add_model("c", cloud, np.eye(4), cloud.bounds, origin)
    later: list[Callable[[], None]] = []
    preparation.prepare_cloud(
        cloud, origin, threading.Event(), lambda event: scene.take("c", event), later.append
    )
    scene.camera.fit(scene.corners(), SIZE)
    model = scene.models["c"]
    coarse = {part.row for part in model.parts}
    scene.picture.draw(is_moving=False)
    assert not scene.nodes.is_settled
    assert scene.nodes.is_waiting
    before = {row: model.shown_rows[row] for row in coarse}
    sizes = [part.actor.GetProperty().GetPointSize() for part in model.parts]
    assert len(later) == 1
    later[0]()
    assert scene.nodes.is_settled
    assert not scene.picture.is_complete
    rest(scene)
    assert scene.picture.is_complete
    assert {part.row for part in model.parts} >= set(model.shown_rows)
    assert all(model.shown_rows[row] < spacing for row, spacing in before.items())
    assert [p.actor.GetProperty().GetPointSize() for p in model.parts if p.row in coarse] < sizes
    # A view at rest asks for nothing more.
    rest(scene)
    scene.picture.draw(is_moving=False)
    assert len(later) == 1


def test_bounds_ignore_non_finite_points() -> None:
    points = np.random.default_rng(0).normal(0, 5, (2000, 3)) + UTM
    request_photos = np.stack([points.min(axis=0), points.max(axis=0)])
    holed = np.insert(points, [0, 700, 1990], np.nan, axis=0)
    for some in (holed, holed[: len(holed) // 512 * 512], holed[:100]):
        got = preparation.finite_bounds(some, threading.Event())
        np.testing.assert_array_equal(got[0], np.nanmin(some, axis=0))
        np.testing.assert_array_equal(got[1], np.nanmax(some, axis=0))
    np.testing.assert_array_equal(
        preparation.finite_bounds(holed, threading.Event()), request_photos
    )


def test_proxy_of_a_large_mesh_is_small_coloured_and_aligned(tmp_path: Path) -> None:
    n = 500
    x, z = np.meshgrid(np.linspace(0, 10, n + 1), np.linspace(0, 8, n + 1))
    points = np.stack([x, np.sin(x), z], -1).reshape(-1, 3).astype(np.float32)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)]
    ).astype(np.int32)
    colors = np.full((len(points), 3), (10, 200, 30), np.uint8)
    made = preparation.make_proxy(points, faces, colors, threading.Event())
    assert made is not None
    proxy, rows = made
    assert np.array_equal(vtk_to_numpy(proxy.GetPoints().GetData()), points[rows])
    assert proxy is not None
    assert 0.5 < proxy.GetNumberOfCells() / preparation.PROXY_FACES < 1.3
    assert proxy.GetNumberOfPoints() < proxy.GetNumberOfCells()
    np.testing.assert_allclose(proxy.GetBounds(), (0, 10, -1, 1, 0, 8), atol=0.1)
    assert proxy.GetPointData().GetScalars().GetTuple(0) == (10.0, 200.0, 30.0)
    few = slice(0, 1000)
    assert preparation.make_proxy(points, faces[few], colors, threading.Event()) is None


def test_nine_textures_of_a_real_outcrop_are_drawn(scene: Scene, data_dir: Path) -> None:
    from vomstudio.io.models.opening import read_model

    loaded = read_model(data_dir / "brighton_model" / "brighton_utm15n.obj")
    told = show(scene, "b", loaded.data)
    assert told == []
    assert len(scene.models["b"].gpu_textures) == 9
    scene.camera.look_along(0.0, 90.0)
    scene.camera.fit(scene.corners(is_closed=True), SIZE)
    picture = rest(scene)
    assert scene.picture.is_complete
    assert all(s.level is not None for s in scene.models["b"].gpu_textures.values())
    drawn = np.abs(picture - picture[2, 2]).max(axis=2) > 8
    assert drawn.mean() > 0.3
    assert picture[drawn].mean() > 50
    # Grass, asphalt and gravel: a photograph, not one colour.
    assert picture[drawn].std(axis=0).min() > 20
