"""The plane tool: a click grows, a drag paints, shapes enclose, and Enter keeps the plane."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from tests.extraction.test_selection import corner_cloud, looking, sheet
from tests.geometry.test_brush import centre_of, grid
from tests.messages import refused
from tests.project.conftest import MODEL, MemoryJournal
from tests.samples import placed
from tests.studio.tools.fakes import Context
from vomstudio.core.errors import DocumentError, TargetError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.project import edits
from vomstudio.project.edit import change
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import Model
from vomstudio.project.session import Session
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.painted_area import patch_area
from vomstudio.studio.tools.plane import MAX_PLANE_ELEMENTS, PlaneTool

# One face of a dipping, slightly rough bed; some 1 600 squares of 10 cm.
DIP = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])
RELEASED = ((1.0, 1.0), (2.0, 1.0), (3.0, 1.0))


def bed() -> Mesh:
    flat = grid(41, 4.0, rough=0.004)
    return Mesh(flat.vertices @ DIP.T, flat.faces)


class WithSurface(Context):
    def __init__(self, session, journal, data=None) -> None:
        super().__init__(session, journal)
        data = data or bed()
        self.surfaces = {"m1": create_surface(data), "m2": create_surface(data)}
        for each in self.surfaces.values():
            each.build()
        self.elements.models = {"m1": data}

    def surface(self, model_id):
        return self.surfaces.get(model_id)


@pytest.fixture
def context() -> WithSurface:
    journal = MemoryJournal()
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    other = Model("m2", "wall", "w.obj", "mesh", "1" * 64, MODEL.placement)
    session.apply(edits.add_model(session.records, other))
    return WithSurface(session, journal)


@pytest.fixture
def tool(context) -> PlaneTool:
    made = PlaneTool(context)
    made.set_radius(0.3)
    return made


MESH = bed()


def at(
    kind,
    place,
    *,
    model_id="m1",
    ctrl=False,
    shift=False,
    alt=False,
    more=False,
    button=Button.LEFT,
) -> PointerEvent:
    """The cursor over the middle of the face nearest to (u, v) along the bed, or over nothing."""
    hit = None
    if place is not None:
        centres = MESH.vertices[MESH.faces].mean(axis=1) @ DIP
        face = int(np.linalg.norm(centres[:, :2] - place, axis=1).argmin())
        hit = Hit(model_id, "face", face, tuple(centre_of(MESH, face)))
    return PointerEvent(kind, 0.0, 0.0, button, shift, ctrl, hit, None, more, alt=alt)


def stroke(tool, *places, release=True, **more) -> None:
    tool.pointer(at(Pointer.DRAG_START, places[0], **more))
    for place in places[1:]:
        tool.pointer(at(Pointer.DRAG_MOVE, place, **more))
    if release:
        tool.pointer(at(Pointer.DRAG_END, places[-1], **more))


def wheel(tool, turns, **keys) -> None:
    tool.pointer(PointerEvent(Pointer.WHEEL, 0.0, 0.0, wheel_notches=turns, **keys))


def patches(context) -> list[Patch]:
    return context.session.of(Patch)


def within(place, radius=0.3) -> set[int]:
    hit = at(Pointer.MOVE, place).hit
    return set(create_surface(MESH).connected_ids_in_ball(hit.index, hit.position, radius).tolist())


def chosen(tool) -> set[int]:
    return set() if tool.selection is None else set(tool.selection.ids().tolist())


def ids(patch: Patch) -> set[int]:
    return set(runs_to_ids(patch.runs).tolist())


# --- growing -----------------------------------------------------------------------------------
def test_click_grows_the_planar_surface_and_enter_adds_its_plane(tool, context):
    tool.pointer(at(Pointer.CLICK, (2.0, 2.0)))
    grown = chosen(tool)
    assert len(grown) > 1000
    assert patches(context) == []
    preview = context.shown[-1]
    assert " ± " in preview.reading[0]
    assert preview.verdict == "good"
    made = tool.finish()
    (patch,) = patches(context)
    assert (patch.id, patch.name, patch.type_id) == (made, "B01", "bedding")
    assert ids(patch) == grown
    assert context.made == [made]
    assert not tool.is_open
    assert context.session.draft is None


def test_ten_planes_need_a_click_and_enter_each(tool, context):
    tool.set_tolerance(angle_deg=5.0, distance=0.002)
    for number in range(10):
        tool.pointer(at(Pointer.CLICK, (0.5 + 0.3 * number, 2.0)))
        tool.finish()
    assert len(patches(context)) == 10


def test_wheel_adjusts_the_grown_area_and_one_undo_removes_it(tool, context):
    tool.set_tolerance(angle_deg=2.0, distance=0.5)
    tool.pointer(at(Pointer.CLICK, (2.0, 2.0)))
    few = tool.count
    wheel(tool, 10.0, ctrl=True)
    assert tool.growth.angle_deg == 22.0
    assert tool.count > few
    wheel(tool, -40.0, shift=True)
    assert tool.count < len(MESH.faces)
    assert tool.undo()
    assert not tool.is_open
    # Now nothing follows it any more.
    wheel(tool, 1.0, ctrl=True)
    assert tool.count == 0
    tool.pointer(at(Pointer.CLICK, None))
    assert context.said[-1] == Finding("tool.no-surface")


def test_tolerances_that_select_nothing_or_everything_are_reported(tool, context):
    tool.set_tolerance(angle_deg=1.0, distance=1e-4)
    tool.pointer(at(Pointer.CLICK, (2.0, 2.0)))
    assert context.said[-1] == Finding("growth.isolated")
    tool.set_tolerance(angle_deg=90.0, distance=100.0)
    assert context.said[-1] == Finding("growth.whole-model")
    assert tool.selection.mask.all()


def test_clicks_wait_for_the_neighbour_graph_with_marks(tool, context):
    context.elements.is_slow = True
    tool.pointer(at(Pointer.CLICK, (1.0, 1.0)))
    assert tool.is_open
    assert len(context.shown[-1].pending_positions) == 1
    tool.finish()
    tool.pointer(at(Pointer.CLICK, (3.0, 3.0)))
    assert tool.is_finishing
    assert len(context.shown[-1].pending_positions) == 2
    assert patches(context) == []
    context.elements.be_done()
    assert len(patches(context)) == 1
    assert tool.count > 0
    assert not tool.is_finishing
    assert context.shown[-1].pending_positions is None


def test_undo_and_escape_remove_waiting_clicks_first(tool, context):
    context.elements.is_slow = True
    tool.pointer(at(Pointer.CLICK, (1.0, 1.0)))
    tool.finish()
    assert tool.undo()
    assert not tool.is_finishing
    assert tool.is_open
    tool.cancel()
    assert not tool.is_open
    context.elements.be_done()
    assert tool.count == 0


# --- painting ----------------------------------------------------------------------------------
def test_stroke_selects_all_faces_under_the_brush(tool, context):
    places = [(1.0, 1.0), (1.3, 1.0), (1.6, 1.2)]
    stroke(tool, *places)
    assert chosen(tool) == set().union(*(within(p) for p in places))
    tool.finish()
    (patch,) = patches(context)
    assert (patch.name, patch.type_id, patch.element) == ("B01", "bedding", "face")


def test_plane_is_fitted_to_the_selected_faces(tool, context):
    stroke(tool, (0.6, 0.6), (2.0, 2.0), (3.0, 1.0))
    tool.finish()
    (patch,) = patches(context)
    corners = MESH.vertices[MESH.faces[runs_to_ids(patch.runs)]]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert patch.area == pytest.approx(area.sum())
    weight = np.repeat(area / 3.0, 3)
    points = corners.reshape(-1, 3)
    centred = points - np.average(points, axis=0, weights=weight)
    normal = np.linalg.svd(np.sqrt(weight)[:, None] * centred)[2][2]
    measured = context.measure(patch)
    assert abs(measured.fit.normal @ normal) == pytest.approx(1.0, abs=1e-12)
    assert measured.fit.dip_deg == pytest.approx(np.degrees(np.arcsin(0.6)), abs=0.5)
    assert measured.resolution_m == pytest.approx(0.1, rel=0.1)
    distinct = np.unique(points, axis=0)
    assert patch.n == len(distinct)
    assert {tuple(p) for p in patch.outline} <= {tuple(p) for p in distinct}


def test_rotating_the_world_rotates_the_plane_of_a_patch(tool, context):
    stroke(tool, (0.6, 0.6), (2.0, 2.0), (3.0, 1.0))
    tool.finish()
    (patch,) = patches(context)
    before = context.measure(patch).fit
    turn = np.linalg.qr(np.random.default_rng(4).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    rows = np.eye(4)
    rows[:3, :3], rows[:3, 3] = 2.0 * turn, [5.0e5, 4.0e6, 100.0]
    session = context.session
    model = session.records["m1"]
    turned = placed(model, rows)
    session.apply(change(session.records, "turn", {"m1": turned}))
    after = context.measure(patch).fit
    assert abs(after.normal @ turn @ before.normal) == pytest.approx(1.0, abs=1e-9)
    assert after.max_confidence95_deg == pytest.approx(before.max_confidence95_deg, rel=1e-6)
    assert after.extent == pytest.approx(2.0 * before.extent)


@pytest.mark.parametrize("key", ["ctrl", "alt"])
def test_shift_adds_and_alt_or_ctrl_removes(tool, key):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (3.0, 3.0), shift=True)
    both = within((1.0, 1.0)) | within((3.0, 3.0))
    assert chosen(tool) == both
    stroke(tool, (1.2, 1.0), **{key: True})
    assert chosen(tool) == both - within((1.2, 1.0))
    stroke(tool, (3.0, 3.0), shift=True, **{key: True})
    assert chosen(tool) == within((3.0, 3.0))


def test_clicks_and_strokes_can_be_combined(tool):
    stroke(tool, (0.3, 0.3))
    tool.set_tolerance(angle_deg=5.0, distance=0.002)
    tool.pointer(at(Pointer.CLICK, (3.0, 3.0), shift=True))
    both = chosen(tool)
    assert within((0.3, 0.3)) < both
    stroke(tool, (0.3, 0.3), alt=True)
    assert chosen(tool) == both - within((0.3, 0.3))


def test_stroke_without_a_key_replaces_the_selection(tool):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (3.0, 3.0))
    assert chosen(tool) == within((3.0, 3.0))
    assert tool.undo()
    assert chosen(tool) == within((1.0, 1.0))


def test_combine_mode_of_the_panel_applies_without_a_key(tool):
    stroke(tool, (1.0, 1.0))
    tool.set_combine("subtract")
    stroke(tool, (1.2, 1.0))
    assert chosen(tool) == within((1.0, 1.0)) - within((1.2, 1.0))


def test_stroke_without_effect_is_not_an_undo_step(tool, context):
    stroke(tool, (1.0, 1.0))
    rows = len(context.journal.kept)
    stroke(tool, (1.0, 1.0), shift=True)
    stroke(tool, (3.0, 3.0), ctrl=True)
    stroke(tool, None, None)
    assert len(context.journal.kept) == rows
    assert chosen(tool) == within((1.0, 1.0))


def test_stroke_may_start_off_the_outcrop(tool):
    stroke(tool, None, (1.0, 1.0), None)
    assert chosen(tool) == within((1.0, 1.0))


def test_hidden_faces_are_not_painted(tool, context):
    hidden = np.zeros(len(MESH.faces), np.bool_)
    hidden[sorted(within((1.0, 1.0)))] = True
    context.elements.hide("m1", hidden)
    stroke(tool, (1.0, 1.0), (1.5, 1.0))
    assert chosen(tool) == (within((1.0, 1.0)) | within((1.5, 1.0))) - within((1.0, 1.0))


# --- shapes ------------------------------------------------------------------------------------
def test_rectangle_selects_the_faces_inside(tool, context):
    flat = sheet(41, y=lambda x, z: 0.02 * np.sin(9.0 * x))
    context.elements.models, context.elements.look = {"m1": flat}, looking()
    context.surfaces["m1"] = create_surface(flat)
    tool.set_mode("rectangle")
    for kind, x, y in (
        (Pointer.DRAG_START, 150, 100),
        (Pointer.DRAG_MOVE, 250, 200),
        (Pointer.DRAG_END, 250, 200),
    ):
        tool.pointer(PointerEvent(kind, x, y, Button.LEFT))
    expected = tool.selection.ids()
    assert len(expected) > 8
    before = context.session.undo_label
    assert tool.finish() == context.made[-1]
    (patch,) = patches(context)
    assert np.array_equal(runs_to_ids(patch.runs), expected)
    assert abs(context.measure(patch).fit.normal[1]) > 0.99
    context.session.undo()
    assert context.session.undo_label == before
    assert patches(context) == []


def test_enter_closes_a_polygon_before_it_adds_the_plane(tool, context):
    flat = sheet(41)
    context.elements.models, context.elements.look = {"m1": flat}, looking()
    context.surfaces["m1"] = create_surface(flat)
    tool.set_mode("polygon")
    for x, y in ((150, 100), (250, 100)):
        tool.pointer(PointerEvent(Pointer.CLICK, x, y, Button.LEFT))
    assert tool.finish_problem().code == "feature.too-few-points"
    assert tool.finish() is None
    assert tool.drawing
    tool.pointer(PointerEvent(Pointer.CLICK, 250, 200, Button.LEFT))
    assert tool.finish() is None
    assert tool.count > 0
    assert patches(context) == []
    assert tool.finish() is not None


# --- undo, redo, discarding --------------------------------------------------------------------
def test_strokes_can_be_undone_and_redone(tool, context):
    states = [set()]
    for place in RELEASED:
        stroke(tool, place, shift=True)
        states.append(chosen(tool))
    for state in reversed(states[:-1]):
        assert tool.undo_label == "Paint"
        assert tool.undo()
        assert chosen(tool) == state
    for state in states[1:]:
        assert tool.redo()
        assert chosen(tool) == state
    assert not tool.redo()


def test_undo_in_the_middle_of_a_stroke_does_nothing(tool):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (2.0, 1.0), release=False, shift=True)
    assert tool.undo_label is None
    assert not tool.undo()
    tool.pointer(at(Pointer.DRAG_END, (2.0, 1.0)))
    assert chosen(tool) == within((1.0, 1.0)) | within((2.0, 1.0))


def test_escape_during_a_stroke_discards_it_and_redo_restores_it(tool):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (2.0, 1.0), release=False, shift=True)
    tool.cancel()
    assert not tool.is_painting
    tool.pointer(at(Pointer.DRAG_MOVE, (3.0, 1.0)))
    tool.pointer(at(Pointer.DRAG_END, (3.0, 1.0)))
    assert chosen(tool) == within((1.0, 1.0))
    assert tool.redo()
    assert chosen(tool) == within((1.0, 1.0)) | within((2.0, 1.0))


def test_escape_during_the_first_stroke_discards_the_plane_and_undo_restores_it(tool, context):
    stroke(tool, (2.0, 1.0), release=False)
    tool.cancel()
    assert not tool.is_open
    assert context.feature_discarded[-1].restore_work()
    assert chosen(tool) == within((2.0, 1.0))


def test_discarded_plane_can_be_restored(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.cancel()
    assert not tool.is_open
    assert context.session.draft is None
    assert context.feature_discarded[-1].restore_work()
    assert chosen(tool) == within((1.0, 1.0))
    assert context.session.draft is not None


def test_leaving_the_tool_keeps_the_stroke(tool):
    stroke(tool, (1.0, 1.0), release=False)
    tool.leave()
    assert not tool.is_painting
    assert chosen(tool) == within((1.0, 1.0))


# --- changing a plane, types ---------------------------------------------------------------------
def finished(tool, context, place=(1.0, 1.0)) -> Patch:
    stroke(tool, place)
    id_ = tool.finish()
    return context.session.records[id_]


def test_a_changed_plane_keeps_its_id_name_and_attributes(tool, context):
    old = finished(tool, context)
    context.session.apply(edits.set_attributes(context.session.records, [old.id], notes="wet"))
    tool.continue_feature(old.id)
    assert tool.is_continued
    assert chosen(tool) == ids(old)
    context.set_next_type("joint", "J1")
    stroke(tool, (2.0, 1.0), shift=True)
    assert tool.finish() == old.id
    (after,) = patches(context)
    assert (after.id, after.name, after.type_id, after.set_name) == (old.id, "B01", "bedding", "")
    assert after.notes == "wet"
    assert ids(after) == within((1.0, 1.0)) | within((2.0, 1.0))
    context.session.undo()
    assert ids(patches(context)[0]) == ids(old)


def test_discarding_changes_leaves_the_plane_unchanged(tool, context):
    old = finished(tool, context)
    tool.continue_feature(old.id)
    tool.cancel()
    assert not tool.is_open
    assert context.feature_discarded == []
    tool.continue_feature(old.id)
    stroke(tool, (2.0, 1.0), shift=True)
    tool.cancel()
    assert patches(context) == [old]
    assert context.feature_discarded[-1].restore_work()
    assert tool.is_continued
    assert tool.finish() == old.id
    assert ids(patches(context)[0]) > ids(old)


def test_plane_gets_the_type_and_set_selected_at_finish(tool, context):
    stroke(tool, (1.0, 1.0))
    bedding = context.shown[-1].color
    context.set_next_type("joint", "J1")
    tool.set_type("joint", "J1")
    assert context.shown[-1].color != bedding
    tool.finish()
    (patch,) = patches(context)
    assert (patch.type_id, patch.set_name) == ("joint", "J1")


def test_brush_colour_follows_the_type_immediately(tool, context):
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0)))
    bedding = context.shown[-1].color
    context.set_next_type("joint", "")
    tool.set_type("joint", "")
    assert context.shown[-1].color != bedding


@pytest.mark.parametrize("id_", ["m1", "gone"])
def test_only_grown_or_painted_planes_can_be_changed(tool, id_):
    with refused("tool.other-kind", DocumentError):
        tool.continue_feature(id_)


def test_plane_without_its_open_model_cannot_be_edited(tool, context):
    old = finished(tool, context)
    context.surfaces.clear()
    with refused("model.not-open", DocumentError):
        tool.continue_feature(old.id)


# --- what is refused -----------------------------------------------------------------------------
def test_stroke_on_another_model_is_rejected_with_a_hint(tool, context):
    stroke(tool, (1.0, 1.0))
    said = len(context.said)
    stroke(tool, (2.0, 1.0), (2.1, 1.0), (2.2, 1.0), model_id="m2", shift=True)
    assert len(context.said) == said + 1
    assert context.said[-1] == Finding("tool.other-model")
    tool.pointer(at(Pointer.CLICK, (2.0, 1.0), model_id="m2", shift=True))
    assert context.said[-1] == Finding("tool.other-model")
    assert chosen(tool) == within((1.0, 1.0))


def test_stroke_dragged_onto_another_model_does_not_select_it(tool):
    tool.pointer(at(Pointer.DRAG_START, (1.0, 1.0)))
    tool.pointer(at(Pointer.DRAG_MOVE, (3.0, 1.0), model_id="m2"))
    tool.pointer(at(Pointer.DRAG_END, (3.0, 3.0), model_id="m2"))
    assert chosen(tool) == within((1.0, 1.0))


def test_subtracting_from_an_empty_selection_is_reported(tool, context):
    stroke(tool, (1.0, 1.0), ctrl=True)
    assert not tool.is_open
    assert context.said[-1] == Finding("selection.empty")


def test_plane_with_too_many_elements_is_rejected(tool, context, monkeypatch):
    assert MAX_PLANE_ELEMENTS > 1_000_000
    monkeypatch.setattr("vomstudio.studio.tools.plane.MAX_PLANE_ELEMENTS", 100)
    tool.changes.select_all()
    assert tool.finish() is None
    assert context.said[-1].code == "selection.too-many"
    assert context.said[-1].values["maximum"] == 100
    assert tool.is_open


def test_failed_write_keeps_the_painted_faces(tool, context):
    stroke(tool, (1.0, 1.0))
    context.journal.refuse = TargetError(Finding("disk.full"))
    assert tool.finish() is None
    assert context.said[-1].code == "disk.full"
    assert chosen(tool) == within((1.0, 1.0))
    context.journal.refuse = None
    assert tool.finish() is not None


# --- what is seen --------------------------------------------------------------------------------
def test_the_stroke_is_shown_live_with_its_fit(tool, context, monkeypatch):
    monkeypatch.setattr("vomstudio.studio.tools.brush_stroke.MAX_LIVE_SHARE", 1.0)
    stroke(tool, (1.0, 1.0), (1.5, 1.0), release=False)
    preview = context.shown[-1]
    touched = within((1.0, 1.0)) | within((1.5, 1.0))
    assert len(preview.stroke.corners) == len(touched)
    shown = {
        tuple(c)
        for c in np.round(preview.stroke.origin + preview.stroke.corners.reshape(-1, 3), 4).tolist()
    }
    there = MESH.vertices[MESH.faces[sorted(touched)]].reshape(-1, 3)
    assert shown == {tuple(c) for c in np.round(there, 4).tolist()}
    assert preview.brush.radius == 0.3
    assert " ± " in preview.reading[0]
    live = tool.measurement
    tool.pointer(at(Pointer.DRAG_END, (1.5, 1.0)))
    assert context.shown[-1].stroke is None
    assert len(context.shown[-1].area.corners) == len(touched)
    assert tool.measurement.fit.dip_deg == pytest.approx(live.fit.dip_deg, abs=1e-9)


def test_added_stroke_has_the_area_colour_and_an_erasing_stroke_is_white(tool, context):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (3.0, 1.0), release=False, shift=True)
    preview = context.shown[-1]
    assert [color for _, color in preview.areas()] == [preview.color] * 2
    tool.pointer(at(Pointer.DRAG_END, (3.0, 1.0)))
    stroke(tool, (1.0, 1.0), release=False, alt=True)
    assert context.shown[-1].areas()[1][1] == (1.0, 1.0, 1.0)


def test_slow_fit_is_postponed_to_the_end_of_the_stroke(tool, context, monkeypatch):
    monkeypatch.setattr("vomstudio.studio.tools.brush_stroke.MAX_LIVE_SHARE", 1e-9)
    stroke(tool, (1.0, 1.0), (2.0, 1.0), release=False)
    first = tool.measurement
    tool.pointer(at(Pointer.DRAG_MOVE, (3.0, 1.0)))
    assert tool.measurement is first
    assert len(context.shown[-1].stroke.corners) > len(within((1.0, 1.0)))
    tool.pointer(at(Pointer.DRAG_END, (3.0, 1.0)))
    assert tool.measurement.area_m2 > 2.0 * first.area_m2


def test_intermediate_drag_steps_are_not_shown(tool, context):
    tool.pointer(at(Pointer.DRAG_START, (1.0, 1.0)))
    shown = len(context.shown)
    for k in range(5):
        tool.pointer(at(Pointer.DRAG_MOVE, (1.0 + k / 10, 1.0), more=True))
    assert len(context.shown) == shown
    tool.pointer(at(Pointer.DRAG_MOVE, (1.6, 1.0)))
    assert len(context.shown) == shown + 1


def test_brush_ring_is_aligned_with_the_surface(tool, context):
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0)))
    ring = context.shown[-1].brush
    assert abs(ring.normal @ DIP[:, 2]) > 0.99
    assert not ring.is_removing
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0), alt=True))
    assert context.shown[-1].brush.is_removing
    tool.pointer(at(Pointer.MOVE, None))
    assert context.shown[-1] is None
    tool.set_mode("lasso")
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0)))
    assert context.shown[-1] is None


def test_default_brush_radius_suits_the_model(context):
    tool = PlaneTool(context)
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0)))
    assert tool.radius == pytest.approx(0.05)
    tool.enlarge_brush()
    assert tool.radius > 0.05
    tool.shrink_brush()
    assert tool.radius == pytest.approx(0.05, rel=0.05)


def test_patch_is_drawn_at_its_faces(tool, context):
    patch = finished(tool, context)
    area = patch_area(patch, MODEL, context.surface("m1"))
    there = MESH.vertices[MESH.faces[sorted(ids(patch))]]
    np.testing.assert_allclose(area.origin + area.corners, there, atol=1e-6)
    assert len(area.border)


# --- clouds --------------------------------------------------------------------------------------
def of_cloud(cloud: PointCloud) -> tuple[PlaneTool, WithSurface]:
    journal = MemoryJournal()
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    context = WithSurface(session, journal, cloud)
    return PlaneTool(context), context


def test_points_of_a_cloud_can_be_painted():
    cloud = PointCloud(MESH.vertices)
    tool, context = of_cloud(cloud)
    tool.set_radius(0.5)
    index = 40 * 20 + 20
    hit = Hit("m1", "point", index, tuple(cloud.points[index]))
    for kind in (Pointer.DRAG_START, Pointer.DRAG_END):
        tool.pointer(PointerEvent(kind, 0, 0, Button.LEFT, hit=hit))
    tool.finish()
    (patch,) = patches(context)
    near = np.linalg.norm(cloud.points - cloud.points[index], axis=1) <= 0.5
    assert ids(patch) == set(np.flatnonzero(near).tolist())
    assert (patch.element, patch.area, patch.n) == ("point", None, int(near.sum()))
    assert context.measure(patch).fit.dip_deg == pytest.approx(36.9, abs=2.0)
    area = patch_area(patch, MODEL, context.surface("m1"))
    assert area.corners.shape == (patch.n, 3)


@pytest.mark.full
def test_a_plane_grows_over_the_points_of_a_cloud():
    cloud, wall = corner_cloud()
    tool, context = of_cloud(cloud)
    seed = int(np.argmin(np.abs(cloud.points - cloud.points[wall].mean(axis=0)).sum(axis=1)))
    hit = Hit("m1", "point", seed, tuple(cloud.points[seed]))
    tool.set_tolerance(angle_deg=20.0, distance=0.02)
    tool.pointer(PointerEvent(Pointer.CLICK, 0, 0, Button.LEFT, hit=hit))
    assert tool.count > 1000
    assert tool.finish()
    (patch,) = patches(context)
    assert patch.element == "point"
    assert abs(context.measure(patch).fit.normal[1]) > 0.999


# --- the next start ------------------------------------------------------------------------------
def test_every_step_of_a_plane_is_restored_from_its_draft(tool, context):
    steps = [
        lambda: stroke(tool, (1.0, 1.0)),
        lambda: stroke(tool, (2.0, 1.0), shift=True),
        lambda: stroke(tool, (1.2, 1.0), alt=True),
        tool.undo,
        lambda: tool.finish(),
        lambda: tool.continue_feature(patches(context)[0].id),
        lambda: stroke(tool, (3.0, 3.0), shift=True),
        lambda: stroke(tool, (3.4, 3.0), release=False),
        lambda: tool.cancel(),
        lambda: tool.cancel(),
    ]
    context.set_next_type("joint", "J1")
    for step in steps:
        step()
        journal = MemoryJournal()
        journal.kept = copy.deepcopy(context.journal.kept)
        session = Session(journal)
        assert session.of(Patch) == patches(context)
        again = PlaneTool(WithSurface(session, journal))
        assert (session.draft is not None) is (tool.count > 0)
        if session.draft is not None:
            assert again.restore(session.draft.state)
        assert chosen(again) == chosen(tool)
        assert again.is_continued == tool.is_continued
        if again.is_open:
            assert again._context.next_type_id == "joint"


def test_draft_of_another_tool_or_a_removed_model_is_rejected(tool, context):
    stroke(tool, (1.0, 1.0))
    state = dict(context.session.draft.state)
    assert not tool.restore({"tool": "plane", "chosen": {"model_id": "m", "size": 3}})
    assert not tool.restore({**state, "chosen": {**state["chosen"], "bits": "?"}})
    assert not tool.restore({**state, "chosen": {**state["chosen"], "model_id": "gone"}})
    context.session.apply(edits.remove_model(context.session.records, "m1"))
    tool.document_changed()
    assert not tool.is_open
    assert context.session.draft is None
