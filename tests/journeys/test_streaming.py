"""A COPC file larger than may be held: opened, picked, painted and opened again."""

from __future__ import annotations

import numpy as np
import pytest

from tests import driver
from tests.driver import pause, wait
from tests.io.models.test_copc import N, make
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.io.models import copc
from vomstudio.io.models.opening import file_hash, read_model
from vomstudio.project.records import Model
from vomstudio.rendering.view.drawing import PREVIEW
from vomstudio.rendering.view.scalars import FieldStyle


@pytest.fixture
def cliff(tmp_path, monkeypatch):
    monkeypatch.setattr(copc, "OVERVIEW_POINTS", 3000)
    return make(tmp_path / "cliff.copc.laz", split=2)


def settle(window, model_id: str) -> None:
    scene, viewport = window.viewport.scene, window.viewport
    wait(lambda: model_id in scene.models and scene.models[model_id].streamer, "a stream")
    pause(350)
    wait(lambda: viewport.is_still and scene.nodes.is_settled, "all nodes")
    assert not viewport.models.work.is_waiting


@pytest.mark.full
def test_large_copc_file_is_streamed_with_the_points_of_the_file(window, cliff):
    studio, viewport = window.studio, window.viewport
    studio.settings.point_budget = 30_000
    problems = []
    viewport.problem.connect(problems.append)
    window.open_path(cliff)
    wait(lambda: studio.models, "the model")
    (model_id,) = studio.models
    opened = studio.models[model_id]
    record = studio.records[model_id]
    assert isinstance(opened.data, StreamedCloud)
    assert isinstance(record, Model)
    assert record.content_hash == file_hash(cliff)
    assert record.frame.crs == "EPSG:32615"
    settle(window, model_id)
    wait(lambda: not any(i.startswith(PREVIEW) for i in viewport.scene.models), "one picture")
    whole = read_model(cliff).data
    x, y = viewport.width() / 2, viewport.height() / 2
    hit = viewport.pick(x, y)
    assert hit is not None
    assert np.array_equal(hit.position, whole.points[hit.index])
    before = len(opened.data.store.loaded_nodes())
    for _ in range(5):
        viewport.camera.zoom(0.6, viewport.world_position(hit))
        viewport.moves.redraw()
        driver.pause(20)
    settle(window, model_id)
    assert len(opened.data.store.loaded_nodes()) > before
    scene = viewport.scene.models[model_id]
    assert {p.row for p in scene.parts} == set(opened.data.store.loaded_nodes())
    assert sum(p.elements for p in scene.parts) <= 30_000
    assert len(scene.parts) == len(scene.point_chunks)
    hit = viewport.pick(x, y)
    assert hit is not None
    assert np.array_equal(hit.position, whole.points[hit.index])
    surface = studio.surface(model_id)
    ids = surface.connected_ids_in_ball(hit.index, hit.position, 2.0)
    assert hit.index in ids
    assert len(ids) > 3
    assert np.linalg.norm(whole.points[ids] - hit.position, axis=1).max() <= 2.0
    # A field's colours follow the nodes that come.
    studio.display.show_field(model_id, FieldStyle("intensity"))
    wait(lambda: viewport.display.color_scale(model_id) is not None, "the field")
    viewport.moves.home()
    driver.pause(300)
    settle(window, model_id)
    shown = [p for p in scene.parts if p.row in scene.shown_rows]
    assert shown
    assert all(p.is_tinted for p in shown)
    studio.display.set_mode("textured")
    driver.pause(100)
    settle(window, model_id)
    assert not any(p.is_tinted for p in scene.parts)
    assert problems == []


def test_a_project_with_a_streamed_model_opens_again(window, cliff, tmp_path):
    studio = window.studio
    studio.settings.point_budget = 30_000
    window.open_path(cliff)
    wait(lambda: studio.models, "the model")
    (model_id,) = studio.models
    studio.save_as(tmp_path / "p.vom")
    studio.new_project()
    wait(lambda: not studio.models, "an empty project")
    studio.open_project(tmp_path / "p.vom")
    wait(lambda: model_id in studio.models, "the model again")
    assert isinstance(studio.models[model_id].data, StreamedCloud)
    settle(window, model_id)


@pytest.mark.full
def test_small_copc_file_is_loaded_whole(window, cliff):
    window.open_path(cliff)
    wait(lambda: window.studio.models, "the model")
    (opened,) = window.studio.models.values()
    assert not isinstance(opened.data, StreamedCloud)
    assert len(opened.data.points) == N
