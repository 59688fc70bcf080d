"""A model that is not metric is refused by the window and converted by one click."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pyproj import CRS, Transformer
from PySide6.QtWidgets import QAbstractButton

from tests.driver import wait
from vomstudio.document.records import Model

pytestmark = pytest.mark.full

ZONE = "EPSG:32632"


@pytest.mark.parametrize("crs", ["EPSG:3857", "EPSG:4326"])
def test_a_model_is_converted_by_the_button_beside_the_message(
    window, tmp_path: Path, crs: str
) -> None:
    steps = np.arange(0.0, 20.0, 0.5)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    metric = np.column_stack([500_000.0 + x, 5_094_000.0 + y, 300.0 - x])
    transformer = Transformer.from_crs(ZONE, crs, always_xy=True)
    east, north = transformer.transform(metric[:, 0], metric[:, 1])
    path = tmp_path / "bed.xyz"
    np.savetxt(path, np.column_stack([east, north, metric[:, 2]]), fmt="%.9f")
    path.with_suffix(".prj").write_text(CRS.from_user_input(crs).to_wkt())
    models = window.studio.workspace.models
    window.open_path(path)
    wait(lambda: models.convertible, "the refusal")
    assert not window.studio.session.of(Model)
    assert models.convertible == (path, ZONE)
    (button,) = (
        each
        for each in window.message_bar.findChildren(QAbstractButton)
        if each.isVisible() and "CRS" in each.text()
    )
    button.click()
    wait(lambda: window.studio.models, "the converted model")
    (model,) = window.studio.session.of(Model)
    assert model.frame.crs == ZONE
    (opened,) = window.studio.models.values()
    assert opened.data.bounds == pytest.approx(
        np.array([metric.min(axis=0), metric.max(axis=0)]), abs=0.01
    )
    assert models.convertible is None
