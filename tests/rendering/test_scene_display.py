"""Fields, clipping, light and eye-dome lighting in what VTK draws, and in what is picked."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from matplotlib import colormaps

from tests.rendering.test_scene import SIZE, UTM, rest, show, wall
from tests.tiers import first_in_default_tier
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare import preparation
from vomstudio.rendering.scene.canvas import BACKGROUND
from vomstudio.rendering.scene.frame_drawing import bands
from vomstudio.rendering.scene.scene import Scene
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.rendering.view.scalars import FieldStyle
from vomstudio.studio.tools.interaction_types import Area


@pytest.fixture
def scene() -> Iterator[Scene]:
    made = Scene()
    made.start(*SIZE)
    yield made
    made.close()


def give_field(scene: Scene, model_id: str, style: FieldStyle) -> None:
    model = scene.models[model_id]
    preparation.prepare_field(
        model.data,
        style,
        model.to_world,
        [p.rows for p in model.proxies],
        [p.rows for p in model.parts],
        threading.Event(),
        lambda event: scene.take(model_id, event),
    )


def face(scene: Scene, points: np.ndarray, *, orthographic: bool = True) -> None:
    """Look North at these points."""
    scene.camera.orthographic = orthographic
    scene.camera.look_along(0.0, 0.0)
    scene.camera.fit(points, SIZE)


def sheet(y: float = 0.0, n: int = 60, **fields: np.ndarray) -> PointCloud:
    """A closed upright sheet of points 10 m wide and 8 m high, facing South."""
    x, z = np.meshgrid(np.linspace(0, 10, n), np.linspace(0, 8, n))
    points = np.stack([x, np.full_like(x, y), z], -1).reshape(-1, 3) + UTM
    return PointCloud(points, np.full((n * n, 3), 200, np.uint8), fields=fields)


def colors_at(scene: Scene, picture: np.ndarray, points: np.ndarray) -> np.ndarray:
    pixels, _ = scene.camera.project(points, SIZE)
    columns, rows = np.round(pixels).astype(int).T
    return picture[rows, columns]


def test_cloud_field_is_drawn_in_matplotlib_colours(scene: Scene) -> None:
    values = np.linspace(0.0, 50.0, 3600)
    values[1800] = np.nan
    cloud = sheet(depth=values)
    show(scene, "c", cloud)
    face(scene, cloud.points)
    scene.set_point_size(1.0)
    scene.set_mode("field")
    give_field(scene, "c", FieldStyle("depth", 10.0, 40.0))
    picture = rest(scene)
    rows = np.array([61, 700, 1830, 1950, 2777, 3400])
    found = colors_at(scene, picture, cloud.points[rows])
    # A pixel beside the rounded one may be hit: the nearest of nine.
    near = []
    for row, point in zip(rows, cloud.points[rows], strict=True):
        expected = colormaps["viridis"]((values[row] - 10.0) / 30.0, bytes=True)[:3]
        pixels, _ = scene.camera.project(point[None], SIZE)
        x, y = np.round(pixels[0]).astype(int)
        from_points = picture[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
        near.append(np.abs(from_points - np.array(expected, int)).max(axis=1).min())
    assert max(near) <= 1, (near, found)


def test_original_colours_are_restored_and_field_memory_is_freed(scene: Scene) -> None:
    cloud = sheet(depth=np.linspace(0.0, 50.0, 3600))
    show(scene, "c", cloud)
    face(scene, cloud.points)
    before = rest(scene)
    scene.set_mode("field")
    give_field(scene, "c", FieldStyle("depth"))
    assert np.abs(rest(scene) - before).max() > 60
    scene.set_mode("textured")
    assert np.array_equal(rest(scene), before)
    scene.set_field("c", None)
    for part in scene.models["c"].parts:
        assert part.point_scalars is None
        data = part.actor.GetMapper().GetInput()
        assert data.GetPointData().GetNumberOfArrays() == 1


def test_field_colours_do_not_change_the_point_size(scene: Scene) -> None:
    cloud = sheet(depth=np.linspace(0.0, 50.0, 3600))
    show(scene, "c", cloud)
    face(scene, cloud.points)
    rest(scene)
    (part,) = scene.models["c"].parts
    size = part.actor.GetProperty().GetPointSize()
    assert size > 3.0
    scene.set_mode("field")
    give_field(scene, "c", FieldStyle("depth"))
    rest(scene)
    assert part.is_tinted
    assert part.actor.GetProperty().GetPointSize() == size


def test_mesh_and_its_proxy_show_elevation(scene: Scene) -> None:
    n = 300
    mesh = wall(n)
    show(scene, "w", mesh)
    assert scene.models["w"].proxies
    face(scene, mesh.vertices)
    scene.set_mode("field")
    give_field(scene, "w", FieldStyle("elevation", percentiles=(0.0, 100.0)))
    scene.picture.draw(is_moving=True)
    assert scene.picture.is_proxy_shown
    moving = scene.canvas.pixels()[::-1, :, :3].astype(int)
    whole = rest(scene)
    for height in (1.0, 4.0, 7.0):
        point = UTM + [5.0, 0.0, height]
        expected = np.array(colormaps["viridis"](height / 8.0, bytes=True)[:3], int)
        for picture, off in ((whole, 6), (moving, 12)):
            assert np.abs(colors_at(scene, picture, point[None])[0] - expected).max() <= off


def test_field_colours_of_an_outdated_model_are_rejected(scene: Scene) -> None:
    show(scene, "w", wall())
    scene.set_mode("field")
    give_field(scene, "w", FieldStyle("elevation"))
    ready = scene.models["w"].field
    show(scene, "w", wall())
    assert ready is not None
    scene.models["w"].parts.append(scene.models["w"].parts[0])
    with pytest.raises(ValueError, match="state"):
        scene.set_field("w", ready)
    scene.models["w"].parts.pop()


def test_plain_mode_is_shaded_and_light_can_be_switched_off(scene: Scene) -> None:
    mesh = wall()
    show(scene, "w", mesh)
    face(scene, mesh.vertices)
    middle = (slice(180, 300), slice(250, 390))
    scene.set_mode("plain shaded")
    assert rest(scene)[middle].std() > 5.0
    scene.set_lit("plain shaded", False)
    assert rest(scene)[middle].reshape(-1, 3).std(axis=0).max() == 0.0
    scene.set_mode("field")
    give_field(scene, "w", FieldStyle("elevation"))
    flat = rest(scene)[middle]
    scene.set_lit("field", True)
    lit = rest(scene)[middle]
    assert lit.sum() < flat.sum()


def test_point_size_can_be_set(scene: Scene) -> None:
    cloud = PointCloud(UTM + np.array([[0.0, 0, 0], [10, 0, 8], [5, 0, 4]]))
    show(scene, "c", cloud)
    face(scene, cloud.points)
    scene.set_mode("plain shaded")
    counts = []
    for size in (2.0, 6.0):
        scene.set_point_size(size)
        picture = rest(scene)
        counts.append(int((np.abs(picture - picture[0, 0]).max(axis=2) > 8).sum()))
    assert counts == [3 * 4, 3 * 36]


# -- eye-dome lighting


def test_eye_dome_lighting_darkens_the_far_side_of_an_edge_only(scene: Scene) -> None:
    """Two sheets, one a metre before the other: the rear one darkens along the edge of the first,
    the first and all that is level keep their colour."""
    x, z = np.meshgrid(np.linspace(0, 10, 300), np.linspace(0, 8, 240))
    y = np.where(x < 5.0, 0.0, 1.0)
    points = np.stack([x, y, z], -1).reshape(-1, 3) + UTM
    cloud = PointCloud(points, np.full((len(points), 3), 200, np.uint8))
    show(scene, "c", cloud)
    face(scene, points)
    plain = rest(scene)
    scene.set_eye_dome(True)
    shaded = rest(scene)
    assert scene.picture.is_complete
    step, _ = scene.camera.project(UTM[None] + [5.0, 0.0, 4.0], SIZE)
    column, row = np.round(step[0]).astype(int)
    for level in (slice(column - 40, column - 5), slice(column + 10, column + 40)):
        assert np.array_equal(shaded[row, level], plain[row, level])
    assert (plain - shaded)[row, column - 2 : column + 6].max() > 25
    assert (shaded[0, 0] == plain[0, 0]).all()


def test_eye_dome_lighting_is_drawn_at_rest_only(scene: Scene) -> None:
    show(scene, "c", sheet())
    rest(scene)
    scene.set_eye_dome(True)
    scene.picture.draw(is_moving=True)
    assert not scene.picture.is_complete
    rest(scene)
    assert scene.picture.is_complete


def test_features_over_a_shaded_cloud_keep_their_colour(scene: Scene) -> None:
    cloud = sheet()
    show(scene, "c", cloud)
    face(scene, cloud.points)
    line = UTM + np.array([[1.0, -0.2, 4.0], [9.0, -0.2, 4.0]])
    scene.set_features({"f": FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "", line[0])})
    scene.set_eye_dome(True)
    picture = rest(scene)
    assert (np.abs(picture - [255, 0, 0]).max(axis=2) < 4).sum() > 300
    scene.set_features({"f": None})
    scene.picture.draw_features()
    assert scene.picture.is_complete
    bare = scene.canvas.pixels()[::-1, :, :3].astype(int)
    assert (np.abs(bare - [255, 0, 0]).max(axis=2) < 4).sum() == 0


def test_bands_cover_every_row_once() -> None:
    for height, count in ((900, 6), (7, 6), (480, 1)):
        rows = [r for first, last in bands(height, count) for r in range(first, last)]
        assert rows == list(range(height))


# -- clipping box


def two_walls() -> Mesh:
    """Two level sheets of a mesh, 2 m apart, seen from the South."""
    front, back = wall(20, relief=0.0), wall(20, relief=0.0)
    return Mesh(
        np.concatenate([front.vertices, back.vertices + [0.0, 2.0, 0.0]]),
        np.concatenate([front.faces, back.faces + len(front.vertices)]),
        colors=np.repeat(np.array([[230, 30, 30], [30, 200, 30]], np.uint8), 441, axis=0),
    )


def background(picture: np.ndarray) -> np.ndarray:
    return np.asarray(np.abs(picture - np.round(np.array(BACKGROUND) * 255)).max(axis=2) <= 1)


@pytest.mark.parametrize("orthographic", first_in_default_tier([False, True], 2))
@pytest.mark.parametrize("kind", first_in_default_tier(["mesh", "cloud"], 2))
@pytest.mark.parametrize("located", first_in_default_tier([False, True], 2))
def test_surface_behind_a_clipped_one_is_drawn_and_picked(
    scene: Scene, orthographic: bool, kind: str, located: bool
) -> None:
    if kind == "mesh":
        data: Mesh | PointCloud = two_walls()
        points = data.vertices  # type: ignore[union-attr]
    else:
        near, far = sheet(n=150), sheet(2.0, n=150)
        points = np.concatenate([near.points, far.points])
        colors = np.repeat(np.array([[230, 30, 30], [30, 200, 30]], np.uint8), 150**2, axis=0)
        data = PointCloud(points, colors)
    show(scene, "m", data)
    if not located:
        scene.models["m"].locators = []
    face(scene, points, orthographic=orthographic)
    # The near sheet is cut away East of its middle.
    box = ClipBox.from_points(points)
    cut = ClipBox((box.low[0], UTM[1] + 1.0, box.low[2]), box.high)
    pixels, _ = scene.camera.project(UTM[None] + [6.0, 0.0, 4.0], SIZE)
    x, y = pixels[0]
    hit = scene.pick(x, y, SIZE)
    assert hit is not None
    assert hit.position[1] == pytest.approx(UTM[1], abs=1e-6)
    assert rest(scene)[round(y), round(x), 0] > 200
    scene.set_clip(cut)
    hit = scene.pick(x, y, SIZE)
    assert hit is not None
    assert hit.position[1] == pytest.approx(UTM[1] + 2.0, abs=1e-6)
    assert rest(scene)[round(y), round(x), 1] > 170
    scene.set_clip(None)
    assert rest(scene)[round(y), round(x), 0] > 200


def test_nothing_outside_the_box_is_drawn_or_picked(scene: Scene) -> None:
    mesh = wall(40, relief=0.0)
    show(scene, "w", mesh)
    face(scene, mesh.vertices)
    half = ClipBox(tuple(UTM + [-1, -1, -1]), tuple(UTM + [4.0, 1.0, 5.0]))  # type: ignore[arg-type]
    scene.set_clip(half)
    picture = rest(scene)
    empty = background(picture)
    world = UTM + np.array([[2.0, 0, 2], [3.8, 0, 4.8], [4.2, 0, 2], [2, 0, 5.2], [9, 0, 7]])
    pixels, _ = scene.camera.project(world, SIZE)
    for (x, y), inside in zip(pixels, half.contains(world), strict=True):
        assert empty[round(y), round(x)] != inside
        assert (scene.pick(x, y, SIZE) is not None) == inside


def test_features_are_clipped_at_the_box(scene: Scene) -> None:
    mesh = wall(20, relief=0.0)
    show(scene, "w", mesh)
    face(scene, mesh.vertices)
    line = UTM + np.array([[1.0, -0.3, 4.0], [9.0, -0.3, 4.0]])
    scene.set_features({"f": FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "", line[0])})
    box = (
        ClipBox.from_points(mesh.vertices)
        .move_face(0, 1, UTM[0] + 5.0)
        .move_face(1, 0, UTM[1] - 1.0)
    )
    scene.set_clip(box)
    picture = rest(scene)
    red = np.abs(picture - [255, 0, 0]).max(axis=2) < 30
    columns = np.flatnonzero(red.any(axis=0))
    ends, _ = scene.camera.project(UTM + np.array([[1.0, 0, 4], [5.0, 0, 4]]), SIZE)
    assert columns.min() == pytest.approx(ends[0, 0], abs=4)
    assert columns.max() == pytest.approx(ends[1, 0], abs=4)


def test_clipping_box_stays_in_place_when_the_scene_origin_changes(scene: Scene) -> None:
    """The box of an opened project is there before the model that gives the scene its origin."""
    mesh = wall(20, relief=0.0)
    scene.set_clip(ClipBox(tuple(UTM + [-1, -1, -1]), tuple(UTM + [4.0, 1.0, 9.0])))  # type: ignore[arg-type]
    show(scene, "w", mesh)
    face(scene, mesh.vertices)
    empty = background(rest(scene))
    pixels, _ = scene.camera.project(UTM + np.array([[3.5, 0, 4], [4.5, 0, 4]]), SIZE)
    (x0, y0), (x1, y1) = np.round(pixels).astype(int)
    assert not empty[y0, x0]
    assert empty[y1, x1]


def test_painted_areas_are_clipped_at_the_box(scene: Scene) -> None:
    mesh = wall(20, relief=0.0)
    show(scene, "w", mesh)
    face(scene, mesh.vertices)
    before = rest(scene)
    origin = np.round(UTM)
    corners = (mesh.vertices[mesh.faces] - origin).astype(np.float32)
    area = Area(origin, corners, corners[:, :2])
    drawing = FeatureDrawing("f", mesh.vertices[:1], None, (1.0, 0.0, 0.0), "", UTM, area=area)
    # The box cuts the area, but not the wall, which lies within it otherwise.
    box = ClipBox.from_points(mesh.vertices).move_face(0, 1, UTM[0] + 5.0)
    for clipped in (box, None):
        scene.set_clip(clipped)
        scene.set_features({"f": drawing})
        picture = rest(scene)
        pixels, _ = scene.camera.project(UTM + np.array([[2.0, 0, 4], [8.0, 0, 4]]), SIZE)
        for (x, y), inside in zip(pixels, (True, clipped is None), strict=True):
            tint = picture[round(y), round(x)] - before[round(y), round(x)]
            assert (tint[0] > tint[1] + 20) == inside


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("ahead", [0.0, 0.04])
def test_colours_of_a_comparison_are_drawn_over_the_benchmark(
    scene: Scene, orthographic: bool, ahead: float
) -> None:
    """The benchmark is at the same place, or in front by less than the largest distance shown."""
    mesh = wall(relief=0.02)
    distances = np.linspace(-0.05, 0.05, len(mesh.vertices)).astype(np.float32)
    show(scene, "compared", replace(mesh, fields={"distance_m": distances}))
    face(scene, mesh.vertices, orthographic=orthographic)
    scene.set_mode("field")
    give_field(scene, "compared", FieldStyle("distance_m", -0.05, 0.05))
    alone = rest(scene)
    show(scene, "benchmark", replace(mesh, vertices=mesh.vertices - [0.0, ahead, 0.0]))
    differs = np.abs(rest(scene) - alone).max(axis=2) > 8
    # At the edges of folds the benchmark may stand out.
    assert differs.mean() < 0.02
    scene.set_mode("textured")
    scene.set_visible("compared", False)
    benchmark = rest(scene)
    assert (np.abs(benchmark - alone).max(axis=2) > 8).mean() > 0.2
