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

from tests.messages import figures, shown_codes
from tests.project.test_bowed_models import registration
from vomstudio.geometry.frames import UNDECLARED_FRAME, Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits
from vomstudio.project.reconstructions import RECONSTRUCTIONS
from vomstudio.project.records import Model
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.plan_view import PlanView

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


@pytest.mark.full
def test_verdict_on_photos_is_replaced_by_warnings_about_their_model(
    window: Any, studio: Any, panel: Any
) -> None:
    survey = window.survey
    survey.verdict = "These photos should give a reliable model."
    survey.rows_changed.emit()
    add(studio, f"{RECONSTRUCTIONS}/{survey.output_folder().name}/model.obj")
    assert findings(panel) == [survey.verdict]
    assert studio.attempt(edits.set_registration, registration(-0.001), ["m1"])
    assert "registration.bowed" in shown_codes("\n".join(findings(panel)))
    assert survey.verdict not in findings(panel)
    n_warnings = sum(finding.severity != "info" for finding in survey.placement_findings())
    assert n_warnings >= 1
    assert figures(panel._verdict.text()) == [1, n_warnings]
    studio.undo()
    assert findings(panel) == [survey.verdict]
    assert figures(panel._verdict.text()) == [1, 0]
    # A registration without a warning does not contradict the verdict.
    assert studio.attempt(edits.set_registration, PLACED, ["m1"])
    assert findings(panel)[0] == survey.verdict


def test_plan_of_photos_is_empty_without_photos(qtbot: Any) -> None:
    plan = PlanView()
    qtbot.addWidget(plan)
    plan.resize(260, 220)

    def count_colors() -> int:
        image = plan.grab().toImage()
        return len({image.pixel(x, y) for x in range(image.width()) for y in range(image.height())})

    assert count_colors() == 1
    unplaced = PhotoRow("a.jpg", "a.jpg", 100, 80, "", "", "", False, None)
    plan.show_rows([unplaced], set(), None)
    assert count_colors() > 1
    plan.show_rows([], set(), None)
    assert count_colors() == 1
