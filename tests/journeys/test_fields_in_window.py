"""Fields of the outcrop, asked for with mouse and keys, painted on it, and there again later."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.messages import shown_codes
from vomstudio.extraction.surface_fields import surface_fields
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.model_transform import transform_model
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.rendering.view.scalars import colormap_table
from vomstudio.ui.panels.surface.fields_panel import FieldsPanel

UP = 0.02


@pytest.fixture
def panel(window, outcrop) -> FieldsPanel:
    driver.open_outcrop(window, outcrop)
    return panel_of(window)


def panel_of(window) -> FieldsPanel:
    window.actions_table.run("surface_fields")
    made = window.findChild(FieldsPanel)
    driver.wait(made.isVisible, "the panel")
    driver.settled(window)
    driver.wait(made.start.isEnabled, "the model")
    return made


def shown(window):
    """The scale of the colours."""
    return window.viewport.display.color_scale(driver.model(window).id)


def choose(panel: FieldsPanel, kind: str) -> None:
    """As with the arrow keys in the list."""
    panel.kind.setFocus()
    while (place := panel.kind.findData(kind)) != panel.kind.currentIndex():
        down = place > panel.kind.currentIndex()
        QTest.keyClick(panel.kind, Qt.Key.Key_Down if down else Qt.Key.Key_Up)


def show(window, panel, kind: str, title: str) -> None:
    choose(panel, kind)
    driver.wait(panel.start.isEnabled, "what it is of")
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(lambda: (s := shown(window)) and s.title.startswith(title), kind, 60.0)
    driver.settled(window)


def values(window, name: str) -> np.ndarray:
    """Of the field of the first model whose name begins so."""
    fields = window.studio.models[driver.model(window).id].data.fields
    (found,) = [v for key, v in fields.items() if key.startswith(name)]
    return np.asarray(found)


@pytest.mark.full
def test_every_field_is_painted_with_its_name_and_unit(window, panel) -> None:
    radius = f", r {panel.radius.value():g} m"
    assert panel.radius.value() > 0.0
    for kind, title, unit in (
        ("dip", "dip", "°"),
        ("dip_direction", "dip direction", "°"),
        ("steepness", "steepness", "°"),
        ("curvature", "curvature", "1/m"),
        ("roughness", "roughness", "m"),
        ("coplanarity", "coplanarity M", ""),
        ("collinearity", "collinearity K", ""),
    ):
        show(window, panel, kind, title)
        scale = shown(window)
        assert (scale.title, scale.unit) == (title + radius, unit)
        driver.keep_picture(window, f"fields-{kind}")
    mesh = read_model(window.studio.project.find_model(driver.model(window))).data
    found = surface_fields(mesh, panel.radius.value()).values
    assert np.array_equal(values(window, "roughness"), found["roughness"], equal_nan=True)
    # Every field of the radius is there: another one needs no work.
    choose(panel, "dip")
    driver.wait(lambda: shown(window).title.startswith("dip,"), "the dip", 5.0)
    assert panel._fields.running is None
    # A field of another radius takes the place of these.
    panel.radius.setValue(2.0 * panel.radius.value())
    show(window, panel, "roughness", f"roughness, r {panel.radius.value():g} m")
    values(window, "roughness")
    driver.click(panel.reset_button, panel.reset_button.rect().center())
    driver.wait(lambda: shown(window) is None, "the photo texture")


@pytest.mark.full
def test_dip_directions_have_the_colours_of_the_wheel(window, panel) -> None:
    show(window, panel, "dip_direction", "dip direction")
    assert panel.wheel.isVisible()
    assert shown(window).kind == "cyclic"
    north, east, south = (panel.wheel.color_at(a).getRgb()[:3] for a in (0.0, 90.0, 180.0))
    table = shown(window).colors(np.array([0.0, 90.0, 180.0, 360.0]))
    assert [tuple(row) for row in table.tolist()] == [north, east, south, north]
    # Drawn with North up: the colour of the East is at the right.
    picture = panel.wheel.grab().toImage()
    at = panel.wheel.rect().center()
    seen = picture.pixelColor(at.x() + 28, at.y()).getRgb()[:3]
    assert np.abs(np.array(seen) - east).max() < 25
    driver.click(panel.color_blind_box, QPoint(8, panel.color_blind_box.rect().center().y()))
    wanted = colormap_table("twilight")
    driver.wait(lambda: np.array_equal(shown(window).table, wanted), "other colours")
    assert panel.wheel.map_name == "twilight"
    driver.settled(window)
    driver.keep_picture(window, "fields-colour-blind")


@pytest.mark.full
def test_the_distance_to_a_plane_follows_the_feature(window, panel, picks) -> None:
    studio, model = window.studio, driver.model(window)
    choose(panel, "plane")
    assert not panel.start.isEnabled()
    assert "selection.no-trace-or-patch" in shown_codes(panel.start.toolTip())
    points = next(iter(picks.values()))
    trace = Trace("t1", "B01", "bedding", model.id, model.content_hash, tuple(map(tuple, points)))
    assert studio.attempt(edits.add_trace, trace)
    studio.selection.set(["t1"])
    driver.wait(lambda: "B01" in panel.plane.text(), "the plane")
    show(window, panel, "plane", "distance to plane of B01")
    assert shown(window).unit == "m"
    fit = studio.measured(["t1"])["t1"].fit
    normal = fit.normal if fit.normal[2] >= 0.0 else -fit.normal
    mesh = studio.models[model.id].data
    wanted = (mesh.vertices - fit.centroid) @ normal
    assert np.abs(values(window, "distance") - wanted).max() < 1e-4
    driver.keep_picture(window, "fields-plane")
    # The trace is moved up by a metre: so is the plane.
    higher = tuple((x, y, z + 1.0) for x, y, z in points.tolist())
    assert studio.attempt(edits.set_vertices, "t1", higher, resolution=None, outcrop_normal=None)
    wanted -= normal[2]
    driver.wait(
        lambda: shown(window) and np.abs(values(window, "distance") - wanted).max() < 1e-3,
        "the other plane",
    )
    # Without the trace there is no such field.
    studio.selection.set(["t1"])
    studio.delete_selected()
    driver.wait(lambda: shown(window) is None, "no field")
    fields = studio.models[model.id].data.fields
    assert not any(name.startswith("distance") for name in fields)


@pytest.mark.full
def test_distance_to_another_model_is_shown(window, panel, outcrop, tmp_path) -> None:
    mesh = read_model(outcrop).data
    path = tmp_path / "survey.ply"
    write_model(replace(mesh, vertices=mesh.vertices + [0.0, 0.0, UP]), None, path)
    studio, own = window.studio, driver.model(window)
    studio.open_model(path, reference_id=own.id)
    driver.wait(lambda: len(studio.models) == 2, "the other model")
    studio.selection.set([own.id])
    # The panel follows a little later; before that it speaks of the new model.
    driver.wait(lambda: panel.title.text() == f"On {own.name}", "the outcrop")
    driver.wait(lambda: panel.other_model.itemText(0) == "survey", "the list of others")
    show(window, panel, "model", "distance to survey")
    far = values(window, "distance")
    assert 0.0 < np.nanmax(np.abs(far)) <= UP + 1e-5


@pytest.mark.full
def test_fields_are_recomputed_if_the_model_frame_changes(window, panel) -> None:
    show(window, panel, "dip_direction", "dip direction")
    studio, before = window.studio, values(window, "dip direction").copy()
    model = driver.model(window)
    assert studio.attempt(edits.declare_frame, model.id, Frame("local", up_axis="y"))
    model = driver.model(window)
    wanted = surface_fields(
        transform_model(read_model(studio.project.find_model(model)).data, model.to_world),
        panel.radius.value(),
    ).values["dip_direction"]
    assert not np.array_equal(wanted, before, equal_nan=True)
    driver.wait(
        lambda: (
            shown(window)
            and np.array_equal(values(window, "dip direction"), wanted, equal_nan=True)
        ),
        "the fields as it stands now",
        60.0,
    )


@pytest.mark.full
def test_field_is_restored_when_the_project_reopens(window, panel, tmp_path: Path) -> None:
    panel.radius.setValue(1.25)
    show(window, panel, "curvature", "curvature, r 1.25 m")
    before = values(window, "curvature").copy()
    folder = tmp_path / "kept.vom"
    studio = window.studio
    studio.save_as(folder)
    studio.new_project()
    driver.wait(lambda: not studio.session.of(Model), "a new project")
    studio.open_project(folder)
    driver.settled(window)
    driver.wait(lambda: (s := shown(window)) and s.title == "curvature, r 1.25 m", "the field", 60)
    assert np.array_equal(values(window, "curvature"), before, equal_nan=True)
    panel = panel_of(window)
    panel.refresh()
    assert panel.radius.value() == 1.25
    assert panel.kind.currentData() == "curvature"


@pytest.mark.full
def test_field_computation_can_be_stopped_and_restarted(window, panel) -> None:
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == "Stop"
    driver.click(panel.start, panel.start.rect().center())
    assert panel.start.text() == "Show"
    assert "job.stopped" in shown_codes(panel.figures.text())
    assert shown(window) is None
    show(window, panel, "dip", "dip")


@pytest.mark.full
def test_radius_below_face_size_is_reported(window, panel) -> None:
    panel.radius.setValue(0.001)
    driver.click(panel.start, panel.start.rect().center())
    driver.wait(
        lambda: "fields.radius-below-faces" in shown_codes(panel.figures.text()), "the reason", 60.0
    )
    assert panel.start.isEnabled()
