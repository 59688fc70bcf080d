"""A second scene draws the same pictures as its source from the same data."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.rendering.test_scene import SIZE, UTM, rest, scene, show, wall
from tests.tiers import first_in_default_tier
from vomstudio.geometry.cloud import PointCloud
from vomstudio.rendering.scene.appearance import DISPLAY_MODES
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.scene import Scene
from vomstudio.rendering.scene.shared_scene import SharedScene
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.drawing import FeatureDrawing

__all__ = ["scene"]


@pytest.fixture
def second(scene: Scene) -> Iterator[SharedScene]:
    made = SharedScene(scene, Camera(), Canvas())
    made.start(*SIZE)
    yield made
    made.close()


def textured_wall(folder: Path):  # type: ignore[no-untyped-def]
    path = folder / "t.png"
    noise = np.random.default_rng(0).integers(0, 255, (64, 64, 3), np.uint8)
    Image.fromarray(noise).save(path)
    return wall(textures=[path])


def look(scene: Scene, second: SharedScene) -> None:
    """Look at everything from the same place."""
    scene.camera.look_along(10.0, 15.0)
    scene.camera.fit(scene.corners(), SIZE)
    second.camera.restore(scene.camera.to_dict())


def everything(_: str) -> bool:
    return True


@pytest.mark.parametrize(
    "mode", first_in_default_tier([mode for mode in DISPLAY_MODES if mode != "field"], 2)
)
def test_both_scenes_draw_the_same_picture_in_every_mode(scene, second, tmp_path, mode) -> None:
    show(scene, "m", textured_wall(tmp_path))
    line = UTM + np.array([[1.0, -1.0, 1.0], [5.0, -1.0, 4.0], [9.0, -1.0, 7.0]])
    drawing = FeatureDrawing("f", line, None, (1.0, 0.0, 0.0), "", line[0])
    scene.set_features({"f": drawing})
    scene.set_selected(["f"])
    scene.set_mode(mode)
    scene.set_clip(ClipBox.from_points(UTM + np.array([[1.0, -3.0, 1.0], [8.0, 3.0, 7.0]])))
    look(scene, second)
    assert second.follow(everything)
    assert second.follow_features()
    assert np.array_equal(rest(scene), rest(second))
    # Nothing has changed since.
    assert not second.follow(everything)
    assert not second.follow_features()
    assert second.picture.is_complete


def test_cloud_is_drawn_the_same_in_both_scenes(scene, second) -> None:
    rng = np.random.default_rng(1)
    points = UTM + rng.uniform([0, 0, 0], [10, 1, 8], (5000, 3))
    show(scene, "c", PointCloud(points, rng.integers(0, 255, (5000, 3), np.uint8)))
    look(scene, second)
    second.follow(everything)
    assert np.array_equal(rest(scene), rest(second))


def test_scenes_share_data_but_not_actors(scene, second, tmp_path) -> None:
    show(scene, "m", textured_wall(tmp_path))
    second.follow(everything)
    model, twin = scene.models["m"], second.models["m"]
    assert twin.data is model.data
    pairs = list(zip(model.parts + model.proxies, twin.parts + twin.proxies, strict=True))
    assert pairs
    for part, copy in pairs:
        assert part.actor is not copy.actor
        assert part.actor.GetMapper().GetInput() is copy.actor.GetMapper().GetInput()
    for material, skin in model.gpu_textures.items():
        assert twin.gpu_textures[material] is not skin
        assert twin.gpu_textures[material].texture is skin.texture


def test_a_second_scene_follows_placement_visibility_hidden_faces_and_removal(
    scene, second
) -> None:
    show(scene, "m", wall())
    look(scene, second)
    second.follow(everything)
    x, y = SIZE[0] / 2, SIZE[1] / 2
    assert second.pick(x, y, SIZE).model_id == "m"
    first = scene.pick(x, y, SIZE)
    assert second.pick(x, y, SIZE) == first

    assert second.follow(lambda _: False)
    assert second.pick(x, y, SIZE) is None
    assert scene.pick(x, y, SIZE) == first
    background = rest(second)
    assert (background == background[0, 0]).all()

    second.follow(everything)
    hidden = np.zeros(len(scene.models["m"].data.faces), np.bool_)
    hidden[first.index] = True
    scene.set_hidden("m", hidden)
    assert second.follow(everything)
    assert second.pick(x, y, SIZE) == scene.pick(x, y, SIZE) != first
    moved = np.eye(4)
    moved[2, 3] = 1000.0
    scene.set_to_world("m", moved)
    assert second.follow(everything)
    np.testing.assert_allclose(second.corners(), scene.corners())
    scene.remove_model("m")
    assert second.follow(everything)
    assert not second.models


def test_second_scene_adopts_late_chunks(scene, second) -> None:
    show(scene, "m", wall())
    scene.models["m"].has_all_chunks = False
    second.follow(everything)
    second.picture.draw(is_moving=False)
    scene.models["m"].has_all_chunks = True
    # The end of the chunks alone completes the picture.
    assert second.follow(everything)
