"""The tool that chooses faces and points, without a window."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.test_selection import looking, sheet
from tests.project.conftest import MODEL, MemoryJournal
from tests.studio.tools.test_patch import WithSurface
from vomstudio.core.findings import Finding
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.project import edits
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.session import Session
from vomstudio.studio.tools.element_selection import ElementSelection, combine_masks
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.select import MAX_PATCH_ELEMENTS, SelectTool
from vomstudio.studio.tools.selection_messages import UNDO_LABELS

# The model stands in World as it does in its file.
MESH = sheet(41, y=lambda x, z: 0.02 * np.sin(9.0 * x))


@pytest.fixture
def context() -> WithSurface:
    journal = MemoryJournal()
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    made = WithSurface(session, journal, MESH)
    made.elements.models["m1"] = MESH
    made.elements.look = looking()
    return made


@pytest.fixture
def tool(context) -> SelectTool:
    return SelectTool(context)


def event(kind, x=0.0, y=0.0, *, face=None, shift=False, ctrl=False, turns=0.0) -> PointerEvent:
    hit = None
    if face is not None:
        place = MESH.vertices[MESH.faces[face]].mean(axis=0)
        hit = Hit("m1", "face", face, tuple(place))
    return PointerEvent(kind, x, y, Button.LEFT, shift, ctrl, hit, turns=turns)


def drag(tool, x0, y0, x1, y1, **keys) -> None:
    tool.pointer(event(Pointer.DRAG_START, x0, y0, **keys))
    tool.pointer(event(Pointer.DRAG_MOVE, x1, y1, **keys))
    tool.pointer(event(Pointer.DRAG_END, x1, y1, **keys))


def test_keys_and_buttons_say_what_is_done_with_what_is_found(tool):
    tool.set_mode("rectangle")
    tool.set_through(True)
    drag(tool, 150, 100, 250, 200)
    first = tool.selection.mask.copy()
    drag(tool, 240, 100, 300, 200, shift=True)
    both = tool.selection.mask.copy()
    assert (first & ~both).sum() == 0
    assert both.sum() > first.sum()
    drag(tool, 150, 100, 200, 200, ctrl=True)
    assert 0 < tool.count < both.sum()
    drag(tool, 240, 100, 250, 200, shift=True, ctrl=True)
    assert (tool.selection.mask & ~first).sum() == 0
    for _ in range(3):
        assert tool.undo()
    assert np.array_equal(tool.selection.mask, first)
    tool.set_combine("intersect")
    drag(tool, 0, 0, 10, 10)
    assert tool.count == 0
    assert not tool.open
    assert tool.cancel() is None


def test_a_shape_of_nothing_says_so_and_changes_nothing(tool, context):
    tool.set_mode("rectangle")
    drag(tool, 1, 1, 2, 2)
    assert tool.selection is None
    assert context.said[-1] == Finding("selection.nothing-inside", through=False)
    tool.set_through(True)
    drag(tool, 1, 1, 2, 2)
    assert context.said[-1] == Finding("selection.nothing-inside", through=True)
    drag(tool, 100, 100, 200, 200, ctrl=True)
    assert context.said[-1] == Finding("selection.empty")
    tool.set_mode("lasso")
    tool.pointer(event(Pointer.CLICK, 100, 100))
    assert context.said[-1] == Finding("selection.hold-button")
    tool.set_mode("polygon")
    for x in (100.0, 200.0):
        tool.pointer(event(Pointer.CLICK, x, 100.0))
    assert tool.finish() is None
    assert context.said[-1] == Finding("feature.too-few-points", count=1, minimum=3)
    tool.undo()
    tool.undo()
    assert not tool.open


def test_a_piece_follows_the_wheel_and_one_undo_takes_it_back(tool, context):
    tool.set_mode("grow")
    tool.set_tolerance(angle_deg=2.0, distance=0.5)
    tool.pointer(event(Pointer.CLICK, face=800))
    few = tool.count
    tool.pointer(event(Pointer.WHEEL, ctrl=True, turns=10.0))
    assert tool.growth.angle_deg == 22.0
    assert tool.count > few
    tool.pointer(event(Pointer.WHEEL, shift=True, turns=-40.0))
    assert tool.count < len(MESH.faces)
    assert tool.undo()
    assert not tool.open
    # Now nothing follows it any more.
    tool.pointer(event(Pointer.WHEEL, ctrl=True, turns=1.0))
    assert tool.count == 0
    tool.pointer(event(Pointer.CLICK))
    assert context.said[-1] == Finding("tool.no-surface")


def test_thresholds_that_take_nothing_or_everything_are_said(tool, context):
    tool.set_tolerance(angle_deg=1.0, distance=1e-4)
    tool.pointer(event(Pointer.CLICK, face=800))
    assert context.said[-1] == Finding("growth.isolated")
    tool.set_tolerance(angle_deg=90.0, distance=100.0)
    assert context.said[-1] == Finding("growth.whole-model")
    assert tool.selection.mask.all()


def test_enter_makes_one_patch_of_what_is_chosen(tool, context):
    tool.set_mode("rectangle")
    drag(tool, 150, 100, 250, 200)
    ids = tool.selection.ids()
    before = context.session.undo_label
    assert tool.finish() == context.made[-1]
    (patch,) = context.session.of(Patch)
    assert np.array_equal(runs_to_ids(patch.runs), ids)
    assert patch.element == "face"
    measured = context.measure(patch)
    assert abs(measured.fit.normal[1]) > 0.99
    assert context.session.draft is None
    context.session.undo()
    assert context.session.undo_label == before
    assert context.session.of(Patch) == []


def test_far_too_many_are_no_patch(tool, context, monkeypatch):
    assert MAX_PATCH_ELEMENTS > 1_000_000
    monkeypatch.setattr("vomstudio.studio.tools.select.MAX_PATCH_ELEMENTS", 100)
    tool.changes.everything()
    assert tool.finish() is None
    assert context.said[-1].code == "selection.too-many"
    assert context.said[-1].values["maximum"] == 100
    assert tool.open


def test_no_shape_is_drawn_over_a_photo(tool, context):
    tool.set_mode("rectangle")
    tool.pointer(PointerEvent(Pointer.DRAG_START, 10, 10, Button.LEFT, in_photo=True))
    assert not tool.drawing
    assert context.said[-1] == Finding("selection.not-in-photo")


def test_rings_inversion_hiding_and_cutting(tool, context):
    tool.set_mode("rectangle")
    drag(tool, 150, 100, 250, 200)
    first = tool.selection.mask.copy()
    tool.changes.wider()
    wider = tool.selection.mask.copy()
    assert (first & ~wider).sum() == 0
    assert wider.sum() > first.sum()
    tool.changes.narrower()
    assert np.array_equal(tool.selection.mask, first)
    tool.changes.cut_out()
    model_id, mask = context.elements.cut[-1]
    assert model_id == "m1"
    assert np.array_equal(mask, first)
    tool.hide_selected()
    assert tool.selection is None
    assert np.array_equal(context.elements.hidden("m1"), first)
    # What is hidden is not chosen again, by whatever way.
    tool.changes.everything()
    assert np.array_equal(tool.selection.mask, ~first)
    tool.cancel()
    assert context.let_go[0].label == UNDO_LABELS["hide"]
    assert context.let_go[0].bring_back()
    assert context.elements.hidden("m1") is None
    assert np.array_equal(tool.selection.mask, first)
    tool.changes.invert()
    assert np.array_equal(tool.selection.mask, ~first)
    tool.changes.isolate()
    assert np.array_equal(context.elements.hidden("m1"), first)
    tool.changes.show_all()
    assert not tool.changes.anything_hidden()
    # A key pressed by mistake: what was hidden with care is hidden again.
    assert context.let_go[-1].label == UNDO_LABELS["show"]
    assert context.let_go[-1].bring_back()
    assert np.array_equal(context.elements.hidden("m1"), first)


def test_by_field_and_by_colour(tool, context):
    height = MESH.vertices[MESH.faces].mean(axis=1)[:, 2]
    low, high = np.quantile(height, [0.4, 0.6])
    tool.changes.select_by_field("elevation", low, high)
    assert np.array_equal(tool.selection.mask, (height >= low) & (height <= high))
    tool.changes.select_by_field("elevation", 1e6, 2e6)
    assert context.said[-1] == Finding("selection.no-such-value")
    tool.changes.select_by_colour(10.0)
    assert "no colours" in str(context.said[-1])


def test_a_model_that_goes_takes_what_is_chosen_with_it(tool, context):
    tool.changes.everything()
    assert context.session.draft is not None
    context.session.apply(edits.remove_model(context.session.records, "m1"))
    tool.document_changed()
    assert not tool.open
    assert context.session.draft is None


def test_steps_and_combinations():
    one = np.array([True, True, False, False])
    two = np.array([False, True, True, False])
    assert combine_masks(one, two, "new").tolist() == two.tolist()
    assert combine_masks(one, two, "add").tolist() == [True, True, True, False]
    assert combine_masks(one, two, "subtract").tolist() == [True, False, False, False]
    assert combine_masks(one, two, "intersect").tolist() == [False, True, False, False]
    chosen = ElementSelection("m1", 4)
    assert chosen.change(one, "one")
    assert not chosen.change(one.copy(), "again")
    assert chosen.change(two, "two")
    assert np.array_equal(ElementSelection.from_dict(chosen.to_dict()).mask, two)
    assert chosen.undo()
    assert chosen.mask.tolist() == one.tolist()
    assert chosen.undo()
    assert not chosen.undo()
    with pytest.raises(ValueError, match=r".+"):
        ElementSelection.from_dict({"model_id": "m", "size": 4, "bits": "AAAA"})


def test_points_of_a_cloud_are_chosen_too(context):
    from tests.extraction.test_selection import corner_cloud

    cloud, wall = corner_cloud()
    context.elements.models["m1"] = cloud
    context.surfaces["m1"] = create_surface(cloud)
    tool = SelectTool(context)
    seed = int(np.argmin(np.abs(cloud.points - cloud.points[wall].mean(axis=0)).sum(axis=1)))
    hit = Hit("m1", "point", seed, tuple(cloud.points[seed]))
    tool.set_tolerance(angle_deg=20.0, distance=0.02)
    tool.pointer(PointerEvent(Pointer.CLICK, 0, 0, Button.LEFT, hit=hit))
    assert tool.count > 1000
    assert tool.finish()
    (patch,) = context.session.of(Patch)
    assert patch.element == "point"
    assert abs(context.measure(patch).fit.normal[1]) > 0.999
