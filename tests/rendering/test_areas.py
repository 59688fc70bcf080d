"""Painted areas over the models: seen in their colour where the surface is seen, and cheap."""

from __future__ import annotations

import numpy as np
import pytest

from tests.rendering.test_scene import SIZE, UTM, rest, scene, show, wall  # noqa: F401
from tests.tiers import first_in_default_tier
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.scene.area_layer import OPACITY
from vomstudio.rendering.scene.scene import Scene
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area

BLUE, GREEN = (0.0, 0.2, 1.0), (0.0, 1.0, 0.2)


def area(mesh: Mesh, faces: np.ndarray) -> Area:
    corners = mesh.vertices[mesh.faces[faces]]
    middle = corners.mean(axis=(0, 1))
    return Area(middle, (corners - middle).astype(np.float32), np.zeros((0, 2, 3), np.float32))


def drawing(id_: str, of: Area | None, color=BLUE, **more) -> FeatureDrawing:
    return FeatureDrawing(id_, np.zeros((0, 3)), None, color, "", UTM, area=of, **more)


def before(scene: Scene) -> None:  # noqa: F811
    scene.camera.look_along(0.0, 0.0)
    scene.camera.fit(scene.corners(), SIZE)


def strength(picture: np.ndarray) -> np.ndarray:
    """How much bluer than red each pixel is."""
    return picture[..., 2] - picture[..., 0]


def upper(mesh: Mesh, part: float) -> np.ndarray:
    height = mesh.vertices[mesh.faces].mean(axis=1)[:, 2]
    return np.flatnonzero(height > UTM[2] + 8.0 * part)


@pytest.mark.parametrize("orthographic", first_in_default_tier([False, True], 1))
def test_area_tints_only_its_own_faces(scene: Scene, orthographic: bool) -> None:  # noqa: F811
    mesh = wall()
    show(scene, "m", mesh)
    scene.camera.orthographic = orthographic
    before(scene)
    plain = rest(scene)
    scene.set_features({"p": drawing("p", area(mesh, upper(mesh, 0.6)))})
    scene.picture.draw_features()
    painted = scene.canvas.pixels()[::-1, :, :3].astype(int)
    tinted = strength(painted) - strength(plain) > 15
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    pixels, _ = scene.camera.project(centres, SIZE)
    seen = scene.visibility(centres)
    x, y = np.round(pixels).astype(int).T
    well_in = centres[:, 2] > UTM[2] + 8.0 * 0.64
    well_out = centres[:, 2] < UTM[2] + 8.0 * 0.56
    assert tinted[y[seen & well_in], x[seen & well_in]].mean() > 0.99
    assert tinted[y[seen & well_out], x[seen & well_out]].mean() < 0.01
    # The rock shows through.
    at = y[seen & well_in], x[seen & well_in]
    mixed = (1.0 - OPACITY) * plain[at] + OPACITY * 255.0 * np.array(BLUE)
    assert np.median(np.abs(painted[at] - mixed)) < 3.0


def test_area_behind_the_surface_is_not_visible(scene: Scene) -> None:  # noqa: F811
    mesh = wall(relief=0.05)
    show(scene, "m", mesh)
    before(scene)
    plain = rest(scene)
    back = Mesh(mesh.vertices + [0.0, 1.0, 0.0], mesh.faces)
    scene.set_features({"p": drawing("p", area(back, np.arange(len(back.faces))))})
    scene.picture.draw_features()
    painted = scene.canvas.pixels()[::-1, :, :3].astype(int)
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    x, y = np.round(scene.camera.project(centres, SIZE)[0]).astype(int).T
    assert np.abs(painted[y, x] - plain[y, x]).max() < 3


def test_changing_one_area_does_not_redraw_the_others(scene: Scene) -> None:  # noqa: F811
    mesh = wall()
    show(scene, "m", mesh)
    before(scene)
    rest(scene)
    layer = scene.features.areas
    scene.set_features(
        {f"p{k}": drawing(f"p{k}", area(mesh, np.arange(k, 3200, 40))) for k in range(40)}
    )
    scene.picture.draw_features()
    inputs = {n: p.fill.GetMapper().GetInput() for n, p in layer._bins.items()}
    assert len(inputs) > 10
    scene.set_features({"p3": drawing("p3", area(mesh, np.arange(50)), GREEN)})
    scene.picture.draw_features()
    changed = [n for n, p in layer._bins.items() if p.fill.GetMapper().GetInput() is not inputs[n]]
    assert len(changed) == 1
    # The same area once more, as after a change of its name, builds nothing.
    inputs = {n: p.fill.GetMapper().GetInput() for n, p in layer._bins.items()}
    scene.set_features({"p3": drawing("p3", scene.features.drawings["p3"].area, GREEN)})
    scene.set_selected(["p5"])
    scene.picture.draw_features()
    assert all(p.fill.GetMapper().GetInput() is inputs[n] for n, p in layer._bins.items())
    total = sum(p.fill.GetMapper().GetInput().GetNumberOfCells() for p in layer._bins.values())
    assert total == 39 * 80 + 50
    assert layer._selected_piece.fill.GetMapper().GetInput().GetNumberOfCells() == 80


def test_hidden_or_removed_area_is_not_drawn(scene: Scene) -> None:  # noqa: F811
    mesh = wall()
    show(scene, "m", mesh)
    before(scene)
    plain = rest(scene)
    one = area(mesh, np.arange(len(mesh.faces)))
    for gone in (drawing("p", one, visible=False), None):
        scene.set_features({"p": drawing("p", one)})
        scene.picture.draw_features()
        assert (scene.canvas.pixels()[::-1, :, :3] != plain).any()
        scene.set_features({"p": gone})
        scene.picture.draw_features()
        assert (scene.canvas.pixels()[::-1, :, :3] == plain).all()


def test_preview_area_is_shown_and_cleared(scene: Scene) -> None:  # noqa: F811
    mesh = wall()
    show(scene, "m", mesh)
    before(scene)
    plain = rest(scene)
    scene.features.areas.set_preview_areas([(area(mesh, np.arange(400)), GREEN)])
    scene.picture.draw_features()
    assert (scene.canvas.pixels()[::-1, :, :3] != plain).any()
    scene.features.areas.set_preview_areas([])
    scene.picture.draw_features()
    assert (scene.canvas.pixels()[::-1, :, :3] == plain).all()


@pytest.mark.parametrize("count", [2_000, 20_000])
def test_dots_tint_a_cloud_without_hiding_it_at_any_density(scene: Scene, count: int) -> None:  # noqa: F811
    rng = np.random.default_rng(1)
    flat = np.column_stack(
        [rng.uniform(0, 10, 60_000), rng.normal(0, 0.01, 60_000), rng.uniform(0, 8, 60_000)]
    )
    points = flat + UTM
    show(scene, "m", PointCloud(points, np.full((len(points), 3), 128, np.uint8)))
    before(scene)
    plain = rest(scene)
    chosen = points[:count]
    of = Area(UTM, (chosen - UTM).astype(np.float32), np.zeros((0, 2, 3), np.float32))
    scene.set_features({"p": drawing("p", of)})
    scene.picture.draw_features()
    painted = scene.canvas.pixels()[::-1, :, :3].astype(int)
    surface = (np.abs(plain - 128).max(axis=2) < 40) & (np.abs(strength(plain)) < 5)
    middle = np.zeros_like(surface)
    middle[150:330, 200:440] = True
    tint = strength(painted)[surface & middle].mean()
    assert 20 < tint < 150
