"""Where a plane could be measured: typed, of a set, of the selected feature; painted, kept, and
worked out anew where the plane has changed."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.journeys.test_fields_in_window import choose, panel_of, shown, values
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.geology.orientation import Plane
from vomstudio.products.surface.measurable_map import measurable_map, share_findings
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.ui.panels.surface.fields_panel import FieldsPanel
from vomstudio.ui.panels.surface.measurable_plane import SET_PREFIX


@pytest.fixture
def panel(window, outcrop) -> FieldsPanel:
    driver.open_outcrop(window, outcrop)
    made = panel_of(window)
    choose(made, "measurable")
    return made


def press(window, panel) -> None:
    driver.wait(panel.start.isEnabled, "what it is of")
    driver.click(panel.start, panel.start.rect().center())


def next_of(box) -> None:
    """Choose the entry below in the list that is let down."""
    box.showPopup()
    QTest.keyClick(box.view(), Qt.Key.Key_Down)
    QTest.keyClick(box.view(), Qt.Key.Key_Return)


def wait_for(window, panel, title: str) -> None:
    driver.wait(lambda: (s := shown(window)) and s.title.startswith(title), title, 60.0)
    driver.settled(window)


@pytest.mark.full
def test_measurability_of_a_typed_plane_is_shown(window, panel) -> None:
    asked = panel.measurable
    assert asked.attitude.isVisible()
    assert not panel.start.isEnabled()
    assert "315/38" in panel.start.toolTip()
    asked.attitude.setFocus()
    QTest.keyClicks(asked.attitude, "110/40")
    asked.options.show_value("length_m", 4.0)
    press(window, panel)
    wait_for(window, panel, "measurable, 110/40")
    assert [c.name for c in shown(window).categories][-1] == "good"
    said = panel.figures.text()
    mesh = window.studio.models[driver.model(window).id].data
    told = measurable_map(mesh, Plane(110, 40), MeasurableOptions(length_m=4.0))
    found = told.as_fields()
    assert np.array_equal(values(window, "measurable"), found["measurable"], equal_nan=True)
    for line in map(str, share_findings(told)):
        assert line in said
    driver.keep_picture(window, "measurable-typed")
    # The other field of the map needs no work.
    choose(panel, "expected_error")
    wait_for(window, panel, "95 % error, 110/40")
    assert (shown(window).low, shown(window).high, shown(window).unit) == (0.0, 15.0, "°")
    assert panel._fields.running is None
    driver.keep_picture(window, "measurable-error")


@pytest.mark.full
def test_invalid_plane_text_disables_the_start_button(window, panel) -> None:
    for text in ("", "abc", "315", "315/95", "400/38"):
        panel.measurable.attitude.setText(text)
        assert not panel.start.isEnabled(), text
        assert "315/38" in panel.start.toolTip()


@pytest.mark.full
def test_measurability_of_selected_feature_and_its_set_is_shown(window, panel, picks) -> None:
    studio, model = window.studio, driver.model(window)
    for i, (name, points) in enumerate(list(picks.items())[:3]):
        rows = tuple(map(tuple, points))
        trace = Trace(f"t{i}", name, "bedding", model.id, model.content_hash, rows, set_name="S0")
        assert studio.attempt(edits.add_trace, trace)
    studio.selection.set(["t1"])
    source = panel.measurable.source
    driver.wait(lambda: source.count() == 3, "set and feature")
    next_of(source)
    assert source.currentData() == f"{SET_PREFIX}S0"
    panel.measurable.options.show_value("length_m", 4.0)
    press(window, panel)
    fits = [studio.measured([f"t{i}"])[f"t{i}"].plane for i in range(3)]
    normals = np.array([plane.normal() for plane in fits])
    mean = Plane.from_normal(np.linalg.svd(normals)[2][0])
    title = f"measurable, {mean.dip_direction_deg:03.0f}/{mean.dip_deg:02.0f}"
    wait_for(window, panel, title)
    next_of(source)
    press(window, panel)
    one = fits[1]
    title = f"measurable, {one.dip_direction_deg:03.0f}/{one.dip_deg:02.0f}"
    wait_for(window, panel, title)
    # The feature is turned: the map follows.
    trace = studio.records["t1"]
    middle = np.mean(trace.vertices, axis=0)
    off = np.asarray(trace.vertices) - middle
    turned = middle + np.column_stack([-off[:, 1], off[:, 0], off[:, 2]])
    rows = tuple(map(tuple, turned.tolist()))
    assert studio.attempt(edits.set_vertices, "t1", rows, resolution=None, outcrop_normal=None)
    wanted = (one.dip_direction_deg - 90.0) % 360.0
    wait_for(window, panel, f"measurable, {wanted:03.0f}")
