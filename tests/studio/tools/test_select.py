"""The tool that chooses faces and points, without a window."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.test_selection import looking, sheet
from tests.project.conftest import MODEL, MemoryJournal
from tests.studio.tools.test_plane import WithSurface
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.session import Session
from vomstudio.studio.tools.element_selection import ElementSelection, combine_masks
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.select import SelectTool
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
    made = SelectTool(context)
    made.set_target("surface")
    return made


def event(kind, x=0.0, y=0.0, *, face=None, shift=False, ctrl=False, turns=0.0) -> PointerEvent:
    hit = None
    if face is not None:
        place = MESH.vertices[MESH.faces[face]].mean(axis=0)
        hit = Hit("m1", "face", face, tuple(place))
    return PointerEvent(kind, x, y, Button.LEFT, shift, ctrl, hit, wheel_notches=turns)


def drag(tool, x0, y0, x1, y1, **keys) -> None:
    tool.pointer(event(Pointer.DRAG_START, x0, y0, **keys))
    tool.pointer(event(Pointer.DRAG_MOVE, x1, y1, **keys))
    tool.pointer(event(Pointer.DRAG_END, x1, y1, **keys))


def test_keys_and_buttons_set_how_selections_are_combined(tool):
    tool.set_mode("rectangle")
    tool.set_select_through(True)
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
    assert not tool.is_open
    assert tool.cancel() is None


def test_empty_shape_is_reported_and_changes_nothing(tool, context):
    tool.set_mode("rectangle")
    drag(tool, 1, 1, 2, 2)
    assert tool.selection is None
    assert context.said[-1] == Finding("selection.nothing-inside", through=False)
    tool.set_select_through(True)
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
    assert not tool.is_open


def test_shape_cannot_be_drawn_over_a_photo(tool, context):
    tool.set_mode("rectangle")
    tool.pointer(PointerEvent(Pointer.DRAG_START, 10, 10, Button.LEFT, is_in_photo=True))
    assert not tool.drawing
    assert context.said[-1] == Finding("selection.not-in-photo")


def test_selection_can_be_expanded_inverted_hidden_and_cut(tool, context):
    tool.set_mode("rectangle")
    drag(tool, 150, 100, 250, 200)
    first = tool.selection.mask.copy()
    tool.changes.expand()
    expand = tool.selection.mask.copy()
    assert (first & ~expand).sum() == 0
    assert expand.sum() > first.sum()
    tool.changes.shrink()
    assert np.array_equal(tool.selection.mask, first)
    tool.changes.cut_out()
    model_id, mask = context.elements.cut[-1]
    assert model_id == "m1"
    assert np.array_equal(mask, first)
    tool.hide_selected()
    assert tool.selection is None
    assert np.array_equal(context.elements.hidden("m1"), first)
    # What is hidden is not chosen again, by whatever way.
    tool.changes.select_all()
    assert np.array_equal(tool.selection.mask, ~first)
    tool.cancel()
    assert context.feature_discarded[0].label == UNDO_LABELS["hide"]
    assert context.feature_discarded[0].restore_work()
    assert context.elements.hidden("m1") is None
    assert np.array_equal(tool.selection.mask, first)
    tool.changes.invert()
    assert np.array_equal(tool.selection.mask, ~first)
    tool.changes.isolate()
    assert np.array_equal(context.elements.hidden("m1"), first)
    tool.changes.show_all()
    assert not tool.changes.has_hidden_elements()
    # A key pressed by mistake: what was hidden with care is hidden again.
    assert context.feature_discarded[-1].label == UNDO_LABELS["show"]
    assert context.feature_discarded[-1].restore_work()
    assert np.array_equal(context.elements.hidden("m1"), first)


def test_selecting_by_field_and_by_colour(tool, context):
    height = MESH.vertices[MESH.faces].mean(axis=1)[:, 2]
    low, high = np.quantile(height, [0.4, 0.6])
    tool.changes.select_by_field("elevation", low, high)
    assert np.array_equal(tool.selection.mask, (height >= low) & (height <= high))
    tool.changes.select_by_field("elevation", 1e6, 2e6)
    assert context.said[-1] == Finding("selection.no-such-value")
    tool.changes.select_by_colour(10.0)
    assert "needs colours" in str(context.said[-1])


def test_removing_a_model_clears_its_selection(tool, context):
    tool.changes.select_all()
    assert context.session.draft is not None
    context.session.apply(edits.remove_model(context.session.records, "m1"))
    tool.document_changed()
    assert not tool.is_open
    assert context.session.draft is None


def test_masks_are_combined_and_selection_steps_undone():
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


def test_features_inside_a_shape_are_selected(tool, context):
    vertices = tuple(map(tuple, MESH.vertices[[0, 900, 1600]]))
    trace = Trace("t1", "B01", "bedding", "m1", "0" * 64, vertices)
    context.session.apply(edits.add_features(context.session.records, [trace]))
    tool.set_target("features")
    assert tool.selects_feature
    (place,) = context.feature_positions().values()
    x, y = context.elements.look.pixels(place[None])[0]
    drag(tool, x - 9, y - 9, x + 9, y + 9)
    assert context.selected == [(("t1",), "new")]
    drag(tool, x + 9, y + 9, x + 20, y + 20, shift=True)
    drag(tool, x - 9, y - 9, x + 9, y + 9, ctrl=True)
    assert context.selected[1:] == [((), "add"), (("t1",), "subtract")]
    drag(tool, x + 9, y + 9, x + 20, y + 20)
    assert context.said[-1].code == "selection.no-feature-inside"
    # The clicks of a polygon are its corners.
    tool.set_mode("polygon")
    assert not tool.selects_feature


def test_enter_without_a_shape_does_nothing(tool):
    tool.changes.select_all()
    assert tool.finish_problem().code == "tool.no-shape"
    assert tool.finish() is None
    assert tool.count == len(MESH.faces)


def test_face_pixels_are_inside_the_outline_that_selects_them(context):
    view = context.elements.look
    centres = MESH.vertices[MESH.faces].mean(axis=1)
    pixels = view.pixels(centres)
    outline_mask = view.outline_mask([(150, 100), (250, 100), (250, 200), (150, 200)])
    inside = view.inside(MESH, np.eye(4), outline_mask, is_through=True)
    rows, columns = pixels[inside].astype(int).T[::-1]
    assert outline_mask[rows, columns].all()
    assert np.isnan(view.pixels(view.position[None] - view.direction)).all() or view.parallel
