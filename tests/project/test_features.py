"""Patches, lineations, readings, dimensions and intersections: kept, measured, turned, deleted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import by_code, refused, with_code
from tests.samples import bed, placed
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line, Plane, slip_from_rake
from vomstudio.geology.slip import slip_rake
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.patches import ids_to_runs, moments, outline
from vomstudio.geometry.planes import fit_plane
from vomstudio.project import codec, edits
from vomstudio.project.kinds import KINDS
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements, measure_all
from vomstudio.project.record_map import RecordMap
from vomstudio.project.records import DEFAULT_TYPES, FeatureType, Group, Model
from vomstudio.project.tables.project_table import project_table

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))


def on_plane(plane: Plane, seed: int, n: int = 60, rough: float = 0.002) -> np.ndarray:
    """Points of a plane, a few metres wide, with noise across it."""
    rng = np.random.default_rng(seed)
    along = rng.uniform(-2.0, 2.0, (n, 2)) @ np.array([plane.strike_vector(), plane.dip_vector()])
    return along + rough * rng.standard_normal((n, 1)) * plane.normal() + [100.0, 200.0, 30.0]


def trace(id_: str, plane: Plane, type_id: str, seed: int) -> Trace:
    return Trace(
        id_, id_, type_id, "m1", "0" * 64, tuple(map(tuple, on_plane(plane, seed).tolist()))
    )


def patch(points: np.ndarray) -> Patch:
    m = moments(points)
    return Patch(
        "p1",
        "J01",
        "joint",
        "m1",
        "0" * 64,
        "point",
        ids_to_runs(range(7, 7 + m.n)),
        m.n,
        m.mean,
        m.scatter,
        m.n_effective,
        outline(points, (0.0, 0.0, 1.0)),
    )


def lineation(direction: np.ndarray, plane_id: str = "", slip: str = "") -> Lineation:
    places = np.outer(np.linspace(0.0, 2.0, 5), direction) + [100.0, 200.0, 30.0]
    return Lineation(
        "l1",
        "L01",
        "lineation",
        "m1",
        "0" * 64,
        tuple(map(tuple, places.tolist())),
        plane_id=plane_id,
        slip=slip,
    )


def records(*features):
    return {r.id: r for r in (MODEL, *DEFAULT_TYPES, *features)}


BED, FAULT = Plane(120.0, 40.0), Plane(250.0, 65.0)


@pytest.mark.parametrize(
    "feature",
    [
        patch(on_plane(BED, 1)),
        lineation(Line(30.0, 20.0).vector(), "t1", "normal"),
        Reading("r1", "R1", "bedding", "plane", 120.0, 40.0, 1.8, (1.0, 2.0, 3.0), "a.csv", "A"),
        Dimension("d1", "D1", "area", "m1", "0" * 64, ((0.0, 0.0, 0.0), (1.0, 0.0, 2.0)), "t1"),
        Intersection("i1", "I1", "lineation", Group("t1"), Group("", "fault", "main")),
        FeatureType("slickenline", "Slickenline", "#123456", "star", "line"),
    ],
)
def test_every_record_survives_json(feature):
    import json

    assert codec.decode(json.loads(json.dumps(codec.encode(feature)))) == feature


def test_group_with_a_missing_field_is_reported_without_a_crash():
    plain = codec.encode(Intersection("i1", "I1", "lineation", Group("a"), Group("b")))
    with pytest.raises(DocumentError):
        codec.decode({**plain, "first": {"nonsense": 1}})


def test_patch_is_fitted_like_its_points_and_rotates_with_its_model():
    points = on_plane(BED, 3, n=400)
    feature = patch(points)
    measured = measure_all(records(feature), [feature])[0]
    outside = fit_plane(points, is_ordered=False)
    assert measured.fit.normal == pytest.approx(outside.normal, abs=1e-9)
    assert measured.fit.rms == pytest.approx(outside.rms, rel=1e-9)
    assert measured.max_confidence95_deg == pytest.approx(outside.max_confidence95_deg, rel=0.25)
    turn = Rotation.from_euler("z", -30.0, degrees=True).as_matrix()  # 30 degrees clockwise
    to_world = np.eye(4)
    to_world[:3, :3] = turn
    turned = placed(MODEL, to_world)
    after = measure_all({**records(feature), "m1": turned}, [feature])[0]
    shift = (after.plane.dip_direction_deg - measured.plane.dip_direction_deg) % 360.0
    assert shift == pytest.approx(30.0, abs=1e-9)
    assert after.plane.dip_deg == pytest.approx(measured.plane.dip_deg, abs=1e-9)


def test_a_patch_survives_a_missing_model():
    feature = patch(on_plane(BED, 3))
    without = {k: v for k, v in records(feature).items() if k != "m1"}
    assert measure_all(without, [feature])[0].fit is not None


def test_lineation_is_projected_onto_its_plane_and_has_a_rake():
    base = trace("t1", FAULT, "fault", 4)
    measured = measure_all(records(base), [base])[0]
    lift = np.radians(6.0)
    direction = np.cos(lift) * measured.plane.dip_vector() + np.sin(lift) * measured.plane.normal()
    feature = lineation(direction, "t1", "reverse")
    line = measure_all(records(base, feature), [feature])[0]
    assert line.off_plane_deg == pytest.approx(6.0, abs=1e-6)
    assert line.rake_deg == pytest.approx(90.0, abs=1e-6)
    assert line.slip_rake_deg == pytest.approx(90.0, abs=1e-6)
    assert abs(line.line.vector() @ measured.plane.normal()) < 1e-9
    table = project_table(records(base, feature))
    assert [row["element"] for row in table.rows] == ["plane", "line"]
    assert table.rows[1]["rake_deg"] == pytest.approx(90.0, abs=1e-6)


def test_slip_senses_move_the_hanging_wall_in_their_direction():
    """Down for normal, up for reverse; left-lateral and right-lateral by Aki & Richards."""
    plane = Plane(90.0, 60.0)  # strike north
    for rake in (20.0, 70.0, 110.0, 160.0):
        for sense in ("normal", "reverse", "sinistral", "dextral"):
            directed = slip_rake(plane, rake, sense)
            vector = slip_from_rake(plane, directed).vector()
            axis = np.cos(np.radians(rake)) * plane.strike_vector()
            axis = axis + np.sin(np.radians(rake)) * plane.dip_vector()
            assert abs(vector @ axis) == pytest.approx(1.0)
            if sense in ("normal", "reverse"):
                assert (vector[2] > 0) == (sense == "reverse")
            else:
                assert (vector @ plane.strike_vector() > 0) == (sense == "sinistral")
    assert slip_rake(plane, 0.0, "normal") is None
    assert slip_rake(plane, 90.0, "dextral") is None


def test_thickness_is_measured_across_its_plane():
    base = trace("t1", BED, "bedding", 5)
    normal = measure_all(records(base), [base])[0].plane.normal()
    step = 3.0 * BED.strike_vector() + 1.25 * normal
    inside = step - (step @ normal) * normal
    ends = (
        (100.0, 200.0, 30.0),
        tuple((np.array([100.0, 200.0, 30.0]) + inside + 1.25 * normal).tolist()),
    )
    feature = Dimension("d1", "D1", "thickness", "m1", "0" * 64, ends, "t1")
    figures = measure_all(records(base, feature), [feature])[0].dimension
    assert figures["thickness_m"] == pytest.approx(1.25, abs=1e-9)
    assert 0.0 < figures["thickness_error95_m"] < 0.05
    gone = measure_all(records(feature), [feature])[0]
    assert "thickness_m" not in gone.dimension
    assert gone.problem == Finding("thickness.plane-lost")


def test_intersection_follows_its_planes_and_reports_a_missing_one():
    a, b = trace("t1", BED, "bedding", 6), trace("t2", FAULT, "fault", 7)
    crossing = Intersection("i1", "I1", "lineation", Group("t1"), Group("", "fault"))
    kept = Measurements()
    all_ = records(a, b, crossing)
    first = kept.of(all_, ["i1"])["i1"]
    expected = Line.from_vector(np.cross(BED.normal(), FAULT.normal()))
    assert abs(first.line.vector() @ expected.vector()) > np.cos(np.radians(0.2))
    moved = trace("t1", Plane(10.0, 30.0), "bedding", 6)
    second = kept.of({**all_, "t1": moved}, ["i1"])["i1"]
    assert abs(second.line.vector() @ first.line.vector()) < 0.99
    without = {k: v for k, v in all_.items() if k != "t2"}
    assert kept.of(without, ["i1"])["i1"].problem is not None


def test_readings_are_rows_but_never_pooled_into_a_set():
    reading = Reading("r1", "R1", "fault", "plane", 250.0, 65.0)
    crossing = Intersection("i1", "I1", "lineation", Group("t1"), Group("", "fault"))
    all_ = records(trace("t1", BED, "bedding", 6), reading, crossing)
    table = project_table(all_)
    row = next(r for r in table.rows if r["id"] == "r1")
    assert (row["dip_direction_deg"], row["dip_deg"], row["method"]) == (250.0, 65.0, "compass")
    assert [s["id"] for s in table.skipped] == ["i1"], "a group of a type takes no readings"
    direct = replace(crossing, second=Group("r1"))
    assert Measurements().of({**all_, "i1": direct}, ["i1"])["i1"].line is not None


def test_types_are_added_changed_and_removed_only_while_unused():
    all_ = records(trace("t1", BED, "bedding", 6))
    mine = FeatureType("crack", "Crack", "#112233")
    edit = edits.add_type(all_, mine)
    edit.swap(all_)
    with refused("name.taken", DocumentError):
        edits.add_type(all_, FeatureType("other", "crack", "#112233"))
    with refused("type.colour", DocumentError):
        edits.change_type(all_, replace(mine, color="red"))
    with refused("type.in-use", DocumentError, count=1, type="Bedding"):
        edits.remove_type(all_, "bedding")
    edits.remove_type(all_, "crack").swap(all_)
    assert "crack" not in all_


def test_model_with_a_feature_on_it_is_not_removed():
    all_ = records(lineation(Line(30.0, 20.0).vector()))
    with refused("model.in-use", DocumentError, count=1, model="cliff"):
        edits.remove_model(all_, "m1")


def test_new_features_get_the_next_free_name_of_their_kind():
    all_ = records()
    line = replace(lineation(Line(30.0, 20.0).vector()), name="")
    edit = edits.add_features(all_, [line, replace(line, id="l2")])
    assert [r.name for r in edit.after.values()] == ["L01", "L02"]
    edit.swap(all_)
    with refused("feature.no-attribute", DocumentError, attribute="overturned"):
        edits.set_attributes(all_, ["l1"], overturned=True)


def test_intersection_with_a_folded_set_reports_its_scatter():
    limbs = [trace(f"t{i}", Plane(90.0 + 180.0 * (i % 2), 35.0), "bedding", i) for i in range(6)]
    fault = trace("f1", Plane(0.0, 70.0), "fault", 9)
    crossing = Intersection("i1", "I1", "lineation", Group("", "bedding"), Group("f1"))
    folded = Measurements().of(records(*limbs, fault, crossing), ["i1"])["i1"]
    (reason,) = with_code(folded.verdict.reasons, "line.scattered-set")
    assert reason.values["scatter_deg"] == pytest.approx(35.0, abs=1.0)
    limb = [t for i, t in enumerate(limbs) if i % 2]
    one = Measurements().of(records(*limb, fault, crossing), ["i1"])["i1"]
    assert not with_code(one.verdict.reasons, "line.scattered-set")


def test_lengths_of_a_model_of_unknown_scale_are_marked_as_units():
    """Declaring metres makes them metres, without north."""
    features = [
        trace("t1", Plane(120.0, 40.0), "bedding", 1),
        patch(on_plane(Plane(30.0, 60.0), 2)),
        lineation(np.array([1.0, 0.0, 0.0])),
    ]
    for kind, metric in (("undeclared", False), ("scaled", True), ("local", True)):
        frame = Frame(kind)
        records = {"m1": replace(MODEL, placement=frame), **{f.id: f for f in features}}
        assert {m.metric for m in measure_all(records, features)} == {metric}
        assert frame.has_north == (kind == "local")
    assert (
        codec.decode(codec.encode(replace(MODEL, placement=Frame("scaled")))).frame.kind == "scaled"
    )


def as_trace(id_: str, points: np.ndarray) -> Trace:
    return Trace(id_, id_, "joint", "m1", "0" * 64, tuple(map(tuple, points.tolist())))


def test_trace_that_scans_a_face_to_and_fro_is_questioned() -> None:
    """Whatever its size, place and attitude; a line, and once around a block, are none."""
    rows = np.repeat(np.linspace(0.0, 1.0, 10), 2)
    across = np.tile([0.0, 1.5, 1.5, 0.0], 5)
    scan = np.column_stack([rows, across, np.zeros(20)])
    t = np.linspace(0.0, 2.0 * np.pi, 60)
    around = np.column_stack([np.cos(t), np.sin(t), 0.0 * t])
    along = np.column_stack([t, np.sin(2.0 * t), 0.0 * t])
    turned = Rotation.from_euler("xyz", [40.0, 70.0, 10.0], degrees=True)
    rng = np.random.default_rng(2)
    traces = []
    for k, (size, at) in enumerate(((1.0, 0.0), (50.0, 4e5), (0.02, -30.0))):
        for name, points in (("scan", scan), ("around", around), ("along", along)):
            rough = points + 0.003 * rng.standard_normal(points.shape)
            moved = turned.apply(size * rough) + at
            traces.append(as_trace(f"{name}{k}", moved))
    # Each by itself is told the same as all at once.
    for asked in (traces, *([each] for each in traces)):
        for each, found in zip(asked, measure_all({"m1": MODEL}, asked), strict=True):
            assert found.verdict is not None
            is_asked = "plane.to-and-fro" in by_code(found.verdict.notes)
            assert is_asked == each.name.startswith("scan"), each.name


def test_patch_at_two_levels_stays_doubtful_and_its_gap_scales_with_the_model():
    from dataclasses import replace

    feature = replace(patch(on_plane(BED, 3, n=400)), level_gap=0.012)
    plain = replace(feature, level_gap=None)
    to_world = np.diag([2.0, 2.0, 2.0, 1.0])
    large = {**records(feature), "m1": placed(MODEL, to_world)}
    assert measure_all(records(plain), [plain])[0].verdict.quality == "good"
    for known, gap_m in ((records(feature), 0.012), (large, 0.024)):
        verdict = measure_all(known, [feature])[0].verdict
        assert verdict.quality == "doubtful"
        assert by_code(verdict.reasons)["plane.levels"] == {"gap_m": pytest.approx(gap_m)}


def test_replace_fields_equals_dataclasses_replace() -> None:
    # `Feature.but` creates no kind through its constructor.
    assert not [kind.name for kind in KINDS if hasattr(kind.record, "__post_init__")]
    trace = bed("t1")
    copy = trace.replace_fields(set_name="J1", notes="wet")
    assert copy == replace(trace, set_name="J1", notes="wet")
    assert (trace.set_name, trace.notes) == ("", "")
    with pytest.raises(TypeError):
        trace.replace_fields(no_such_field=1)


def test_records_are_selected_in_the_order_of_the_ids() -> None:
    traces = [bed(f"t{i}") for i in range(4)]
    records = RecordMap({trace.id: trace for trace in traces})
    assert records.select(["t3", "none", "t1"], Trace) == [traces[3], traces[1]]
    assert records.select(["t3"], FeatureType) == []
