"""A model that is not metric is refused by the window and converted by one click."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QAbstractButton

from tests.driver import wait
from tests.frames import ZONE, bed_grid, convert, write_cloud
from vomstudio.project.records import Model

pytestmark = pytest.mark.full


@pytest.mark.parametrize("crs", ["EPSG:3857", "EPSG:4326"])
def test_button_beside_the_message_converts_the_model(window, tmp_path: Path, crs: str) -> None:
    metric = bed_grid()
    path = write_cloud(tmp_path / "bed.xyz", convert(metric, crs), crs)
    models = window.studio.workspace.models
    window.open_path(path)
    wait(lambda: models.conversion_available, "the refusal")
    assert not window.studio.session.of(Model)
    assert models.conversion_available == (path, ZONE)
    (button,) = (
        each
        for each in window.message_bar.findChildren(QAbstractButton)
        if each.isVisible() and "metric" in each.text()
    )
    button.click()
    wait(lambda: window.studio.models, "the converted model")
    (model,) = window.studio.session.of(Model)
    assert model.frame.crs == ZONE
    (opened,) = window.studio.models.values()
    assert opened.data.bounds == pytest.approx(
        np.array([metric.min(axis=0), metric.max(axis=0)]), abs=0.01
    )
    assert models.conversion_available is None
