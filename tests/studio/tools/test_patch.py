"""The patch tool: strokes of a brush, each an edit."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from tests.geometry.test_brush import centre_of, grid
from tests.messages import refused
from tests.project.conftest import MODEL, MemoryJournal
from tests.samples import placed
from tests.studio.tools.fakes import Context
from vomstudio.core.errors import DocumentError
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
from vomstudio.studio.tools.patch import PatchTool

# One face of a dipping, slightly rough bed; some 1 600 squares of 10 cm.
DIP = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])


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
def tool(context) -> PatchTool:
    made = PatchTool(context)
    made.set_radius(0.3)
    return made


MESH = bed()


def at(kind, place, *, model_id="m1", ctrl=False, more=False, button=Button.LEFT) -> PointerEvent:
    """The cursor over the middle of the face nearest to (u, v) along the bed, or over nothing."""
    hit = None
    if place is not None:
        centres = MESH.vertices[MESH.faces].mean(axis=1) @ DIP
        face = int(np.linalg.norm(centres[:, :2] - place, axis=1).argmin())
        hit = Hit(model_id, "face", face, tuple(centre_of(MESH, face)))
    return PointerEvent(kind, 0.0, 0.0, button, False, ctrl, hit, None, more)


def stroke(tool, *places, release=True, **more) -> None:
    tool.pointer(at(Pointer.DRAG_START, places[0], **more))
    for place in places[1:]:
        tool.pointer(at(Pointer.DRAG_MOVE, place, **more))
    if release:
        tool.pointer(at(Pointer.DRAG_END, places[-1], **more))


def patches(context) -> list[Patch]:
    return context.session.of(Patch)


def within(place, radius=0.3) -> set[int]:
    hit = at(Pointer.MOVE, place).hit
    return set(create_surface(MESH).within(hit.index, hit.position, radius).tolist())


def ids(patch: Patch) -> set[int]:
    return set(runs_to_ids(patch.runs).tolist())


# --- strokes -----------------------------------------------------------------------------------
def test_the_first_stroke_makes_a_patch_of_all_that_the_brush_touched(tool, context):
    places = [(1.0, 1.0), (1.3, 1.0), (1.6, 1.2)]
    rows = len(context.journal.kept)
    stroke(tool, *places)
    assert len(context.journal.kept) == rows + 1
    (patch,) = patches(context)
    assert ids(patch) == set().union(*(within(p) for p in places))
    assert (patch.name, patch.type_id, patch.element) == ("B01", "bedding", "face")
    assert context.made == [patch.id]
    assert tool.current == patch
    assert not tool.open


def test_the_plane_is_that_of_the_chosen_faces(tool, context):
    stroke(tool, (0.6, 0.6), (2.0, 2.0), (3.0, 1.0))
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


def test_turning_the_world_turns_the_plane_of_a_patch(tool, context):
    stroke(tool, (0.6, 0.6), (2.0, 2.0), (3.0, 1.0))
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


def test_later_strokes_add_to_the_current_patch_and_with_ctrl_take_away(tool, context):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (3.0, 3.0))
    (patch,) = patches(context)
    assert ids(patch) == within((1.0, 1.0)) | within((3.0, 3.0))
    stroke(tool, (1.2, 1.0), ctrl=True)
    (after,) = patches(context)
    assert after.id == patch.id
    assert ids(after) == ids(patch) - within((1.2, 1.0))


def test_the_toggle_takes_away_and_ctrl_then_adds(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.set_removing(True)
    stroke(tool, (1.2, 1.0))
    (patch,) = patches(context)
    assert ids(patch) == within((1.0, 1.0)) - within((1.2, 1.0))
    stroke(tool, (3.0, 1.0), ctrl=True)
    assert ids(patches(context)[0]) == ids(patch) | within((3.0, 1.0))


def test_a_new_patch_begins_with_adding(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.set_removing(True)
    tool.finish()
    stroke(tool, (3.0, 3.0))
    assert len(patches(context)) == 2


def test_a_click_is_a_stroke_of_one_place(tool, context):
    tool.pointer(at(Pointer.CLICK, (1.0, 1.0)))
    assert ids(patches(context)[0]) == within((1.0, 1.0))
    tool.pointer(at(Pointer.CLICK, (1.0, 1.0), button=Button.RIGHT))
    tool.pointer(at(Pointer.CLICK, None))
    assert context.said[-1] == Finding("tool.no-surface")
    assert len(patches(context)) == 1


def test_a_stroke_that_changes_nothing_is_no_edit(tool, context):
    stroke(tool, (1.0, 1.0))
    rows = len(context.journal.kept)
    stroke(tool, (1.0, 1.0))
    stroke(tool, (3.0, 3.0), ctrl=True)
    stroke(tool, None, None)
    assert len(context.journal.kept) == rows


def test_a_stroke_may_begin_beside_the_outcrop(tool, context):
    stroke(tool, None, (1.0, 1.0), None)
    assert ids(patches(context)[0]) == within((1.0, 1.0))


def test_taking_the_last_face_away_deletes_the_patch(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.set_radius(1.0)
    stroke(tool, (1.0, 1.0), ctrl=True)
    assert patches(context) == []
    assert tool.current is None
    context.session.undo()
    assert len(patches(context)) == 1


def test_finish_lets_the_next_stroke_make_another_patch(tool, context):
    assert tool.why_not_finish() is not None
    stroke(tool, (1.0, 1.0))
    assert tool.why_not_finish() is None
    first = tool.finish()
    assert tool.current is None
    assert tool.finish() is None
    stroke(tool, (3.0, 1.0))
    assert patches(context)[0].id == first
    assert len(patches(context)) == 2


# --- undo, redo, giving up ------------------------------------------------------------------------
def test_undo_takes_back_strokes_and_redo_brings_them(tool, context):
    states = [[]]
    for place in ((1.0, 1.0), (2.0, 1.0), (3.0, 1.0)):
        stroke(tool, place)
        states.append([ids(p) for p in patches(context)])
    for state in reversed(states[:-1]):
        assert not tool.undo()
        context.session.undo()
        assert [ids(p) for p in patches(context)] == state
    for state in states[1:]:
        context.session.redo()
        assert [ids(p) for p in patches(context)] == state
    assert tool.current is not None
    stroke(tool, (1.0, 3.0))
    assert ids(tool.current) == states[-1][0] | within((1.0, 3.0))


def test_a_stroke_after_its_patch_was_undone_makes_a_new_one(tool, context):
    stroke(tool, (1.0, 1.0))
    context.session.undo()
    tool.document_changed()
    assert tool.current is None
    stroke(tool, (3.0, 1.0))
    assert ids(patches(context)[0]) == within((3.0, 1.0))


def test_undo_in_the_middle_of_a_stroke_is_swallowed(tool, context):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (2.0, 1.0), release=False)
    assert tool.open
    assert tool.undo()
    assert tool.open
    tool.pointer(at(Pointer.DRAG_END, (2.0, 1.0)))
    assert ids(patches(context)[0]) == within((1.0, 1.0)) | within((2.0, 1.0))


def test_escape_in_the_middle_of_a_stroke_abandons_the_stroke(tool, context):
    stroke(tool, (1.0, 1.0))
    rows = len(context.journal.kept)
    stroke(tool, (2.0, 1.0), release=False)
    tool.cancel()
    assert not tool.open
    tool.pointer(at(Pointer.DRAG_MOVE, (3.0, 1.0)))
    tool.pointer(at(Pointer.DRAG_END, (3.0, 1.0)))
    assert len(context.journal.kept) == rows
    assert ids(tool.current) == within((1.0, 1.0))
    assert context.shown[-1].area is None


def test_giving_up_a_new_patch_deletes_it_and_undo_brings_it_back(tool, context):
    stroke(tool, (1.0, 1.0))
    stroke(tool, (2.0, 1.0))
    tool.cancel()
    assert patches(context) == []
    assert tool.current is None
    assert context.said[-1].code == "feature.discarded"
    context.session.undo()
    assert len(patches(context)) == 1


def test_giving_up_a_continued_patch_leaves_it_as_it_was(tool, context):
    stroke(tool, (1.0, 1.0))
    before = patches(context)[0]
    tool.finish()
    tool.continue_patch(before.id)
    assert tool.continued
    stroke(tool, (2.0, 1.0))
    context.session.apply(edits.set_attributes(context.session.records, [before.id], notes="wet"))
    tool.cancel()
    (after,) = patches(context)
    assert ids(after) == ids(before)
    assert after.mean == before.mean
    assert after.notes == "wet"


def test_leaving_the_tool_keeps_the_stroke(tool, context):
    stroke(tool, (1.0, 1.0), release=False)
    tool.leave()
    assert ids(patches(context)[0]) == within((1.0, 1.0))
    assert not tool.open
    assert tool.current is None
    assert context.shown[-1] is None


# --- continuing, types ------------------------------------------------------------------------
def test_a_continued_patch_keeps_its_id_name_and_attributes(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.finish()
    (old,) = patches(context)
    tool.continue_patch(old.id)
    tool.set_type("joint", "J1")
    stroke(tool, (2.0, 1.0))
    (after,) = patches(context)
    assert (after.id, after.name, after.type_id, after.set_name) == (old.id, "B01", "bedding", "")
    assert ids(after) == within((1.0, 1.0)) | within((2.0, 1.0))


def test_type_and_set_chosen_while_a_new_patch_is_painted_become_its_own(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.set_type("joint", "J1")
    (patch,) = patches(context)
    assert (patch.type_id, patch.set_name) == ("joint", "J1")


@pytest.mark.parametrize("id_", ["m1", "gone"])
def test_only_patches_can_be_taken_up(tool, id_):
    with refused("tool.other-kind", DocumentError):
        tool.continue_patch(id_)


def test_a_patch_without_its_model_cannot_be_taken_up(tool, context):
    stroke(tool, (1.0, 1.0))
    tool.finish()
    context.surfaces.clear()
    with refused("model.not-open", DocumentError):
        tool.continue_patch(patches(context)[0].id)


# --- what is refused -----------------------------------------------------------------------------
def test_another_models_surface_is_refused_with_a_hint(tool, context):
    stroke(tool, (1.0, 1.0))
    rows, said = len(context.journal.kept), len(context.said)
    stroke(tool, (2.0, 1.0), (2.1, 1.0), (2.2, 1.0), model_id="m2")
    assert len(context.journal.kept) == rows
    assert len(context.said) == said + 1
    assert context.said[-1] == Finding("tool.other-model")
    assert not tool.open


def test_a_stroke_that_strays_onto_another_model_leaves_it_alone(tool, context):
    tool.pointer(at(Pointer.DRAG_START, (1.0, 1.0)))
    tool.pointer(at(Pointer.DRAG_MOVE, (3.0, 1.0), model_id="m2"))
    tool.pointer(at(Pointer.DRAG_END, (3.0, 3.0), model_id="m2"))
    assert ids(patches(context)[0]) == within((1.0, 1.0))


def test_there_is_nothing_to_take_away_from_at_first(tool, context):
    stroke(tool, (1.0, 1.0), ctrl=True)
    assert patches(context) == []
    assert context.said[-1] == Finding("tool.no-patch")


def test_what_cannot_be_written_is_not_done(tool, context):
    from vomstudio.core.errors import TargetError

    stroke(tool, (1.0, 1.0))
    context.journal.refuse = TargetError(Finding("disk.full"))
    stroke(tool, (2.0, 1.0))
    assert ids(tool.current) == within((1.0, 1.0))
    assert context.said[-1].code == "disk.full"
    assert not tool.open


# --- what is seen --------------------------------------------------------------------------------
def test_the_stroke_is_shown_live_with_its_fit_and_is_gone_with_its_release(
    tool, context, monkeypatch
):
    monkeypatch.setattr("vomstudio.studio.tools.brush_stroke.MAX_LIVE_SHARE", 1.0)
    stroke(tool, (1.0, 1.0), (1.5, 1.0), release=False)
    preview = context.shown[-1]
    assert len(preview.area.corners) == len(within((1.0, 1.0)) | within((1.5, 1.0)))
    shown = {
        tuple(c)
        for c in np.round(preview.area.origin + preview.area.corners.reshape(-1, 3), 4).tolist()
    }
    chosen = sorted(within((1.0, 1.0)) | within((1.5, 1.0)))
    there = MESH.vertices[MESH.faces[chosen]].reshape(-1, 3)
    assert shown == {tuple(c) for c in np.round(there, 4).tolist()}
    assert preview.brush.radius == 0.3
    assert " ± " in preview.reading[0]
    live = tool.measurement
    tool.pointer(at(Pointer.DRAG_END, (1.5, 1.0)))
    assert context.shown[-1].area is None
    assert tool.measurement.fit.dip_deg == pytest.approx(live.fit.dip_deg, abs=1e-9)
    assert len(context.shown[-1].reading) > 2


def test_a_fit_that_takes_long_is_left_out_until_it_is_its_turn(tool, context, monkeypatch):
    monkeypatch.setattr("vomstudio.studio.tools.brush_stroke.MAX_LIVE_SHARE", 1e-9)
    stroke(tool, (1.0, 1.0), (2.0, 1.0), release=False)
    first = tool.measurement
    tool.pointer(at(Pointer.DRAG_MOVE, (3.0, 1.0)))
    assert tool.measurement is first
    assert len(context.shown[-1].area.corners) > len(within((1.0, 1.0)))
    tool.pointer(at(Pointer.DRAG_END, (3.0, 1.0)))
    assert tool.measurement.area_m2 > 2.0 * first.area_m2


def test_steps_that_others_follow_are_not_shown(tool, context):
    tool.pointer(at(Pointer.DRAG_START, (1.0, 1.0)))
    shown = len(context.shown)
    for k in range(5):
        tool.pointer(at(Pointer.DRAG_MOVE, (1.0 + k / 10, 1.0), more=True))
    assert len(context.shown) == shown
    tool.pointer(at(Pointer.DRAG_MOVE, (1.6, 1.0)))
    assert len(context.shown) == shown + 1


def test_the_ring_of_the_brush_lies_on_the_surface(tool, context):
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0)))
    ring = context.shown[-1].brush
    assert abs(ring.normal @ DIP[:, 2]) > 0.99
    assert not ring.removes
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0), ctrl=True))
    assert context.shown[-1].brush.removes
    tool.pointer(at(Pointer.MOVE, None))
    assert context.shown[-1] is None


def test_the_first_brush_suits_the_model(context):
    tool = PatchTool(context)
    tool.pointer(at(Pointer.MOVE, (1.0, 1.0)))
    assert tool.radius == pytest.approx(0.05)
    tool.larger()
    assert tool.radius > 0.05
    tool.smaller()
    assert tool.radius == pytest.approx(0.05, rel=0.05)


def test_a_patch_is_drawn_where_its_faces_are(tool, context):
    stroke(tool, (1.0, 1.0))
    (patch,) = patches(context)
    area = patch_area(patch, MODEL, context.surface("m1"))
    there = MESH.vertices[MESH.faces[sorted(ids(patch))]]
    np.testing.assert_allclose(area.origin + area.corners, there, atol=1e-6)
    assert len(area.border)


# --- clouds --------------------------------------------------------------------------------------
def test_points_of_a_cloud_are_painted_like_faces():
    journal = MemoryJournal()
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    cloud = PointCloud(MESH.vertices)
    context = WithSurface(session, journal, cloud)
    tool = PatchTool(context)
    tool.set_radius(0.5)
    index = 40 * 20 + 20
    event = PointerEvent(
        Pointer.CLICK, 0, 0, Button.LEFT, hit=Hit("m1", "point", index, tuple(cloud.points[index]))
    )
    tool.pointer(event)
    (patch,) = patches(context)
    near = np.linalg.norm(cloud.points - cloud.points[index], axis=1) <= 0.5
    assert ids(patch) == set(np.flatnonzero(near).tolist())
    assert (patch.element, patch.area, patch.n) == ("point", None, int(near.sum()))
    assert context.measure(patch).fit.dip_deg == pytest.approx(36.9, abs=2.0)
    area = patch_area(patch, MODEL, context.surface("m1"))
    assert area.corners.shape == (patch.n, 3)


# --- the next start ------------------------------------------------------------------------------
def test_after_every_stroke_the_next_start_has_the_same_patches(tool, context):
    steps = [
        lambda: stroke(tool, (1.0, 1.0)),
        lambda: stroke(tool, (2.0, 1.0)),
        lambda: stroke(tool, (1.2, 1.0), ctrl=True),
        context.session.undo,
        lambda: tool.set_type("joint", "J1"),
        lambda: tool.finish(),
        lambda: stroke(tool, (3.0, 3.0), (3.2, 3.0)),
        lambda: stroke(tool, (3.4, 3.0), release=False),
        lambda: tool.cancel(),
        lambda: tool.cancel(),
    ]
    for step in steps:
        step()
        journal = MemoryJournal()
        journal.kept = copy.deepcopy(context.journal.kept)
        again = Session(journal)
        assert again.of(Patch) == patches(context)
        assert again.draft is None
