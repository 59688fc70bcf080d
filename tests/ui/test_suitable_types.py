"""Types and attributes are offered only where they apply."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests import driver
from tests.geometry.test_brush import grid
from tests.samples import ONE_OF_EACH
from tests.ui.conftest import add_bed, add_cliff, add_open_cliff
from vomstudio.project import edits
from vomstudio.project.kind import may_be_overturned
from vomstudio.project.records import FeatureType
from vomstudio.ui.panels.surface.facets_panel import FacetsPanel
from vomstudio.ui.panels.surface.traces_panel import TracesPanel
from vomstudio.ui.panels.three_points_panel import ThreePointsPanel
from vomstudio.ui.panels.tools.contact import ContactPanel
from vomstudio.ui.panels.tools.plane import PlanePanel
from vomstudio.ui.panels.tools.trace import TracePanel


def offered(box) -> set[str]:
    return {box.itemData(row) for row in range(box.count())}


def add_line(studio) -> str:
    line = replace(ONE_OF_EACH["lineation"], model_id="m1", plane_id="", slip="")
    assert studio.attempt(edits.add_features, [line])
    return line.id


@pytest.mark.full
def test_only_beds_can_be_overturned(window, studio):
    add_cliff(studio)
    bed = add_bed(studio, "t1")
    joint = add_bed(studio, "t2", type_id="joint")
    form, flag = window.properties._form, window.properties.fields["overturned"]
    rows = {}
    for trace in (bed, joint):
        studio.selection.set([trace.id])
        rows[trace.id] = form.isRowVisible(flag)
    assert rows == {"t1": True, "t2": False}
    overturned = {row.feature.id: row.overturned for row in window.table.model._rows}
    assert overturned == {"t1": False, "t2": None}
    # A flag that was set before the type was changed can be removed.
    assert studio.attempt(edits.set_attributes, ["t2"], overturned=True)
    assert form.isRowVisible(flag)
    assert may_be_overturned(replace(joint, type_id="my own type"))


def test_planes_are_offered_plane_types_and_lines_line_types(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    line = add_line(studio)
    types = studio.session.of(FeatureType)
    box = window.properties.fields["type_id"]
    for id_, geometry in (("t1", "plane"), (line, "line")):
        studio.selection.set([id_])
        assert offered(box) == {kind.id for kind in types if kind.geometry == geometry}
    studio.selection.set(["t1", line])
    assert offered(box) == {kind.id for kind in types}


@pytest.mark.full
def test_every_panel_of_planes_offers_only_plane_types(window, studio):
    add_open_cliff(studio, grid(11, 4.0))
    boxes = {}
    for tool, kind in (("trace", TracePanel), ("plane", PlanePanel), ("contact", ContactPanel)):
        studio.activate(tool)
        boxes[tool] = driver.tool_panel(window, kind).type_box
    studio.activate("navigate")
    for page in ("surface", "three_points"):
        window.docks.bring_forward(page)
    for page, kind in (
        ("facets", FacetsPanel),
        ("traces", TracesPanel),
        ("three_points", ThreePointsPanel),
    ):
        boxes[page] = window.findChild(kind).type
    planes = {kind.id for kind in studio.session.of(FeatureType) if kind.geometry == "plane"}
    lines = {kind.id for kind in studio.session.of(FeatureType) if kind.geometry == "line"}
    assert lines
    studio.set_next_type("joint", "")
    assert boxes["facets"].currentData() == boxes["traces"].currentData() == "joint"
    for name, box in boxes.items():
        assert offered(box) == planes, name
    for id_ in sorted(planes | lines):
        names = [action.text() for action in window._menus.create_menu(id_).actions()]
        assert ("Use for &next" in names) == (id_ in planes), id_
    # A line type, such as that of a stored project, is not taken over for proposals.
    studio.set_next_type(sorted(lines)[0], "")
    for name in ("facets", "traces", "three_points"):
        assert offered(boxes[name]) == planes, name
    assert boxes["facets"].currentData() == boxes["traces"].currentData() == "joint"


def test_type_of_another_geometry_is_rejected(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    line = add_line(studio)
    said = []
    studio.notice.connect(lambda notice: said.append(notice.message.code))
    window._menus.change_type(["t1", line], "joint")
    assert studio.records["t1"].type_id == "joint"
    assert studio.records[line].type_id != "joint"
    assert said[-1] == "type.other-geometry"


def test_the_menu_offers_suitable_types_and_known_sets(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", set_name="east")
    add_bed(studio, "t2")
    menu = window._menus.create_menu("t2")
    assert studio.selection.ids == ("t2",)
    submenus = {a.text(): a.menu() for a in menu.actions() if a.menu() is not None}
    names = {a.text() for a in submenus["&Type"].actions()}
    assert "Joint" in names
    assert "Lineation" not in names
    sets = {a.text(): a for a in submenus["&Set"].actions()}
    assert sets["none"].isChecked()
    sets["east"].trigger()
    assert studio.records["t2"].set_name == "east"
