"""What is seen of a large cloud while it is read."""

from __future__ import annotations

import laspy
import numpy as np
import pytest

from tests import driver
from tests.driver import wait
from vomstudio.rendering.view.drawing import PREVIEW
from vomstudio.studio import model_loading

pytestmark = pytest.mark.full


def write_cloud(path, count: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    x, z = rng.uniform(0.0, 30.0, count), rng.uniform(0.0, 20.0, count)
    points = np.stack([x, np.sin(x), z], 1) + [576_700.0, 5_188_100.0, 180.0]
    header = laspy.LasHeader(point_format=3, version="1.4")
    header.scales, header.offsets = [0.001] * 3, points[0].round()
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.intensity = rng.integers(0, 60_000, count)
    las.write(path)
    return points


@pytest.fixture
def cloud(tmp_path, monkeypatch):
    monkeypatch.setattr(model_loading, "PREVIEW_BYTES", 0)
    path = tmp_path / "cloud.laz"
    write_cloud(path, 400_000)
    return path


def previews(window) -> list[str]:
    return [i for i in window.viewport.scene.models if i.startswith(PREVIEW)]


def test_cloud_preview_is_shown_until_the_cloud_is_loaded(window, cloud):
    told = []
    window.studio.loader.previewed.connect(lambda key, data: told.append(data))
    stages = []
    window.viewport.model_stage.connect(lambda key, stage: stages.append((key, stage)))
    window.open_path(cloud)
    wait(lambda: told, "a preview")
    assert 1_000 < len(told[0].points) <= 200_000
    driver.declare(window)
    model_id = driver.settled(window)
    wait(lambda: not previews(window), "the end of the preview")
    first = [key for key, stage in stages if stage == "shown"]
    assert first[0].startswith(PREVIEW)
    assert first[-1] == model_id
    assert (
        window.viewport.pick(window.viewport.width() / 2, window.viewport.height() / 2).model_id
        == model_id
    )


def test_preview_is_never_picked_and_is_removed_with_a_stopped_job(window, cloud):
    viewport = window.viewport
    window.studio.loader.previewed.connect(lambda *_: window.studio.loader.forget_all())
    window.open_path(cloud)
    seen = []
    viewport.model_stage.connect(lambda key, stage: seen.append(key))
    driver.pause(50)
    wait(lambda: not window.studio.loader.busy, "the end of the job")
    driver.pause(300)
    assert not previews(window)
    assert not window.studio.models
    assert viewport.pick(viewport.width() / 2, viewport.height() / 2) is None


def test_invalid_cloud_file_leaves_no_preview(window, tmp_path, monkeypatch):
    monkeypatch.setattr(model_loading, "PREVIEW_BYTES", 0)
    path = tmp_path / "broken.laz"
    path.write_bytes(b"LASF" + bytes(400))
    problems = []
    window.studio.loader.problem.connect(problems.append)
    window.open_path(path)
    wait(lambda: problems, "the reason")
    assert not previews(window)
