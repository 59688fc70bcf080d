"""Properties and Photos show that a model was placed: scale, north and resolution in metres."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import QLabel

from tests.messages import figures
from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits
from vomstudio.project.reconstructions import RECONSTRUCTIONS
from vomstudio.project.records import Model
from vomstudio.ui.panels.photos.photo_row import PhotoRow

SCALE, RESOLUTION = 0.25, 0.08
PLACED = Registration(
    "r1",
    "points on model",
    "points",
    Frame("crs", "EPSG:32633"),
    tuple(map(tuple, np.diag([SCALE, SCALE, SCALE, 1.0]).tolist())),
    scale_error=1e-3,
)
MESH = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))


def add(studio: Any, path: str) -> None:
    model = Model("m1", "wall", path, "mesh", "0" * 64, UNDECLARED_FRAME)
    assert studio.attempt(edits.add_model, model)
    studio.models["m1"] = SimpleNamespace(data=MESH, resolution=RESOLUTION, warnings=())


def rows(text: str) -> dict[str, str]:
    """Return the values of the lines "name: value" of a text."""
    return dict(line.split(": ", 1) for line in re.split(r"<br>|\n", text) if ": " in line)


def texts(window: Any) -> str:
    return "\n".join(label.text() for label in window.properties.findChildren(QLabel))


def test_properties_of_a_registered_model_are_in_metres(window: Any, studio: Any) -> None:
    add(studio, "wall.ply")
    studio.selection.set(["m1"])
    assert rows(texts(window))["Scale"] == "unknown"
    assert "Resolution: 0.0800 units" in texts(window)
    assert studio.attempt(edits.set_registration, PLACED, ["m1"])
    shown = texts(window)
    assert figures(rows(shown)["Scale"]) == [25.0]
    assert rows(shown)["Scale"].endswith(" cm")
    assert rows(shown)["North"].endswith("EPSG:32633")
    assert "Resolution: 2.00 cm" in shown
    studio.undo()
    assert "Resolution: 0.0800 units" in texts(window)


@pytest.fixture
def panel(window: Any, tmp_path: Path) -> Any:
    """The Photos panel with a photo whose pixels have a size in units of the model."""
    survey = window.survey
    survey.folder = tmp_path / "photos"
    survey.rows = [PhotoRow("a.jpg", "a.jpg", 100, 80, "", "", "", False, None, gsd=0.04)]
    survey.rows_changed.emit()
    return window.photos_panel


def findings(panel: Any) -> list[str]:
    listed = panel._findings
    return [listed.item(row).text() for row in range(listed.count())]


def test_photos_panel_shows_the_registration_of_its_model(
    window: Any, studio: Any, panel: Any
) -> None:
    out = window.survey.output_folder()
    add(studio, f"{RECONSTRUCTIONS}/{out.name}/model.obj")
    assert findings(panel) == []
    assert "units" in panel.table.item(0, 1).text()
    assert studio.attempt(edits.set_registration, PLACED, ["m1"])
    (text,) = findings(panel)
    for part in ("wall", "25.00 cm", "grid north of EPSG:32633", "Resolution: 2.00 cm"):
        assert part in text
    assert panel.table.item(0, 1).text() == "1.0 cm"
    # Another scale is shown at once, and once.
    matrix = tuple(map(tuple, np.diag([0.5, 0.5, 0.5, 1.0]).tolist()))
    assert studio.attempt(edits.set_registration, replace(PLACED, matrix=matrix), ["m1"])
    (text,) = findings(panel)
    assert "Resolution: 4.00 cm" in text
    studio.undo()
    studio.undo()
    assert findings(panel) == []
    assert "units" in panel.table.item(0, 1).text()


def test_a_model_of_other_photos_is_not_shown(window: Any, studio: Any, panel: Any) -> None:
    add(studio, f"{RECONSTRUCTIONS}/others-high/model.obj")
    assert studio.attempt(edits.set_registration, PLACED, ["m1"])
    assert findings(panel) == []
