"""How the models are shown: what is kept, what is refused and why, and what the panel says."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.messages import shown_codes
from tests.studio.loop import Loop
from tests.ui.conftest import add_cliff
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.rendering.view.scalars import FieldStyle
from vomstudio.studio import display
from vomstudio.studio.display import Display, mode_problem
from vomstudio.studio.model_loading import OpenModel
from vomstudio.ui.commands import display as display_commands
from vomstudio.ui.panels.surface.fields_panel import FieldsPanel

BOX = ClipBox((0.0, 1.0, 2.0), (10.0, 11.0, 12.0))


def mesh(**more) -> Mesh:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1]])
    return Mesh(corners, np.array([[0, 1, 2]], np.int32), **more)


def cloud(**more) -> PointCloud:
    return PointCloud(np.random.default_rng(0).normal(0, 1, (50, 3)), **more)


def textured(tmp_path) -> Mesh:
    return mesh(
        materials=(Material("m", tmp_path / "t.jpg"),),
        material_offsets=np.array([0, 1]),
        uv=np.zeros((3, 2), np.float32),
    )


def attach(studio, data) -> None:
    add_cliff(studio)
    studio.models["m1"] = OpenModel(data, None, (), None, None, "0" * 64)  # type: ignore[arg-type]
    studio.model_loaded.emit("m1")


# --- what is kept ----------------------------------------------------------------------------
def test_saved_display_is_restored(qapp):
    kept: list[dict] = []
    shown = Display(kept.append, Loop().later)
    shown.show_field("m1", FieldStyle("intensity", 1.0, 9.0))
    shown.set_lit("field", True)
    shown.set_point_size(3.0)
    shown.set_eye_dome(True)
    shown.set_clip(BOX, True)
    shown.set_handles(False)
    shown.flush()
    again = Display(kept.append, Loop().later)
    again.load(kept[-1])
    assert again.to_dict() == shown.to_dict()
    assert again.mode == "field"
    assert again.effective_clip == BOX


@pytest.mark.parametrize(
    "kept",
    [
        None,
        [],
        {"mode": "nonsense", "fields": {"m1": {"name": 3}}, "box": {"low": [0]}, "point_size": "x"},
        {"mode": 7, "fields": [], "lit": 3, "clipping": True},
    ],
)
def test_unreadable_display_state_gives_the_defaults(qapp, kept):
    shown, fresh = Display(lambda _: None, Loop().later), Display(lambda _: None, Loop().later)
    shown.load(kept)
    assert shown.to_dict() == fresh.to_dict()


def test_display_is_saved_with_the_project(window, studio):
    attach(studio, cloud())
    studio.display.show_field("m1", FieldStyle("elevation"))
    studio.display.flush()
    assert studio.project.journal.view("display")["fields"]["m1"]["name"] == "elevation"
    studio.new_project()
    assert studio.display.mode == "textured"
    assert not studio.display.styles


# --- what is refused -------------------------------------------------------------------------
def test_unavailable_display_mode_has_a_reason(tmp_path):
    assert mode_problem("vertex_colors", [mesh()]) == Finding("display.no-colours")
    assert mode_problem("textured", [mesh(), cloud()]) == Finding("display.no-textures")
    assert mode_problem("wireframe", [cloud()]) == Finding("display.cloud-without-faces")
    assert mode_problem("points", []) == Finding("action.no-model")
    with_texture = textured(tmp_path)
    for mode in ("textured", "vertex_colors", "plain shaded", "wireframe", "points", "field"):
        assert mode_problem(mode, [with_texture]) is None
    assert mode_problem("vertex_colors", [mesh(colors=np.zeros((3, 3), np.uint8))]) is None


def test_effective_mode_depends_on_the_model_data(tmp_path):
    assert display.effective_mode("textured", [mesh()]) == "plain shaded"
    assert display.effective_mode("textured", [cloud(colors=np.zeros((50, 3), np.uint8))]) == (
        "vertex_colors"
    )
    assert display.effective_mode("textured", [textured(tmp_path)]) == "textured"


def test_default_appearance_depends_on_the_model_data(tmp_path):
    assert display.default_appearance([textured(tmp_path)]) == "Photo texture"
    coloured = cloud(colors=np.zeros((50, 3), np.uint8))
    assert display.default_appearance([coloured]) == "Vertex colours"
    assert (
        display.default_appearance([mesh()])
        == display.default_appearance([cloud()])
        == "No colours"
    )


def test_field_panel_restores_the_colours_of_a_cloud(window, studio):
    attach(studio, cloud(colors=np.zeros((50, 3), np.uint8)))
    window.actions_table.run("surface_fields")
    panel = window.findChild(FieldsPanel)
    panel.update_widgets()
    assert panel.reset_button.text() == "Vertex colours"
    assert not panel.reset_button.isEnabled()
    studio.display.set_mode("field")
    assert panel.reset_button.isEnabled()
    # However it came about: by this button, the menu, or another panel.
    studio.display.set_mode("textured")
    assert not panel.reset_button.isEnabled()


@pytest.mark.full
def test_disabled_display_actions_state_their_reason(window, studio):
    attach(studio, cloud())
    actions = window.actions_table.all
    assert "display.cloud-without-faces" in shown_codes(actions["display_wireframe"].toolTip())
    assert "display.no-colours" in shown_codes(actions["display_colors"].toolTip())
    assert "display.cloud-not-lit" in shown_codes(actions["display_lit"].toolTip())
    assert actions["display_eye_dome"].isEnabled()


def test_default_field_is_the_most_informative_one():
    count = np.arange(50)
    fields = {"gps_time": count, "intensity": count, "classification": count}
    assert display.default_field(cloud(fields=fields)) == "classification"
    assert display.default_field(cloud(fields={"gps_time": count})) == "gps_time"
    assert display.default_field(cloud()) == "elevation"


# --- panel -----------------------------------------------------------------------------------
def test_field_range_can_be_typed_and_reset(window, studio):
    attach(studio, cloud(fields={"intensity": np.arange(50)}))
    panel = window.display_panel
    window.docks.bring_forward("display")
    display_commands.choose_field(studio, window.docks)
    assert studio.display.styles["m1"] == FieldStyle("intensity")
    for edit, text in ((panel.low, "5,5"), (panel.high, "40")):
        edit.setFocus()
        QTest.keyClicks(edit, text)
        QTest.keyClick(edit, Qt.Key.Key_Return)
    style = studio.display.styles["m1"]
    assert (style.low, style.high) == (5.5, 40.0)
    panel.low.setFocus()
    panel.low.selectAll()
    QTest.keyClicks(panel.low, "nonsense")
    QTest.keyClick(panel.low, Qt.Key.Key_Return)
    assert studio.display.styles["m1"] == style
    assert "not a number" in studio.notices[-1].text
    panel.reset_range.click()
    assert studio.display.styles["m1"] == FieldStyle("intensity")


def test_choosing_a_field_shows_it(window, studio):
    attach(studio, cloud(fields={"intensity": np.arange(50)}))
    panel = window.display_panel
    panel.field.setCurrentIndex(panel.field.findData("elevation"))
    panel.field.activated.emit(panel.field.currentIndex())
    assert studio.display.mode == "field"
    assert studio.display.styles["m1"].name == "elevation"
    assert panel.mode.currentData() == "field"


def test_missing_field_is_reported(window, studio):
    attach(studio, cloud(fields={"intensity": np.arange(50)}))
    panel = window.display_panel
    window.docks.bring_forward("display")
    style = FieldStyle("distance to a plane", -0.052350204440, 1234567.891)
    studio.display.show_field("m1", style)
    panel.refresh()
    assert panel.field.currentData() == style.name
    missing = Finding("field.not-calculated", field=style.name)
    assert panel.field.currentText() == missing.message
    assert panel.low.text() == "-0.0523502"
    assert panel.high.text() == "1234567.891"
    assert panel.low.cursorPosition() == 0
    assert studio.display.styles["m1"] == style


def test_typed_box_faces_cannot_cross(window, studio):
    attach(studio, cloud())
    studio.display.set_clip(BOX, True)
    panel = window.display_panel
    assert [spin.value() for spin in panel.faces] == [0.0, 10.0, 1.0, 11.0, 2.0, 12.0]
    panel.faces[1].setValue(4.0)
    assert studio.display.box == BOX.move_face(0, 1, 4.0)
    panel.faces[1].setValue(-3.0)
    assert studio.display.box.low[0] < studio.display.box.high[0] < 0.1
    assert window.actions_table.all["clipping_box"].isChecked()
