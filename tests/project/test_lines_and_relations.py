"""Rakes, slips, thicknesses and intersections of a document's features."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code
from tests.project.conftest import MODEL
from tests.samples import placed
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import (
    Plane,
    line_from_rake,
    lines_to_vectors,
    slip_from_rake,
)
from vomstudio.geology.slip import slip_rake
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.lines import fit_line
from vomstudio.project import edits
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements, measure_all
from vomstudio.project.records import SURROUNDINGS_RULE, Group
from vomstudio.project.tables.orientation_table import write_orientation_csv
from vomstudio.project.tables.project_layers import project_layers
from vomstudio.project.tables.project_table import project_table

HASH = "0" * 64
FAULT = Plane(120.0, 60.0)


def points_on(plane: Plane, count=24, extent=10.0, rough=0.0, seed=1, centre=(0, 0, 0)) -> tuple:
    """A zigzag on a plane, each point off it by `rough`, one sigma."""
    chance = np.random.default_rng(seed)
    u = np.linspace(-0.5, 0.5, count) * extent
    v = 0.3 * extent * np.sin(np.linspace(0, 9, count))
    xyz = u[:, None] * plane.strike_vector() + v[:, None] * plane.dip_vector()
    xyz = xyz + chance.normal(0, rough, count)[:, None] * plane.normal() + np.asarray(centre)
    return tuple(map(tuple, xyz.tolist()))


def trace(id_: str, plane: Plane, type_id="fault", **more) -> Trace:
    set_name = more.pop("set_name", "")
    return Trace(id_, id_, type_id, "m1", HASH, points_on(plane, **more), set_name=set_name)


def lineation(points, plane_id="", slip="") -> Lineation:
    vertices = tuple(map(tuple, np.asarray(points, float).tolist()))
    return Lineation("l1", "L01", "lineation", "m1", HASH, vertices, None, plane_id, slip)


def along(plane: Plane, rake: float, count=2) -> np.ndarray:
    return np.linspace(0, 3, count)[:, None] * line_from_rake(plane, rake).vector()


def world(*features) -> dict:
    return {MODEL.id: MODEL, **{f.id: f for f in features}}


def measured(records: dict, id_: str):
    return measure_all(records, [records[id_]])[0]


# --- slip ----------------------------------------------------------------------------------------
@pytest.mark.parametrize("rake", [1.0, 30.0, 60.0, 89.0, 91.0, 120.0, 179.0])
@pytest.mark.parametrize("plane", [FAULT, Plane(5.0, 20.0), Plane(300.0, 89.0)])
def test_hanging_wall_moves_as_the_sense_of_slip_states(plane, rake):
    """Seen with the eye of the mind: the hanging wall lies on the side of the dip direction. Normal
    is down, reverse up; sinistral is to the left of one who looks across from the footwall."""
    up = np.array([0.0, 0.0, 1.0])
    across = lines_to_vectors(plane.dip_direction_deg, 0.0)
    left = np.cross(up, across)
    for sense, direction in (
        ("normal", -up),
        ("reverse", up),
        ("sinistral", left),
        ("dextral", -left),
    ):
        directed = slip_rake(plane, rake, sense)
        assert -180.0 < directed <= 180.0
        slip = slip_from_rake(plane, directed)
        assert slip.vector() @ direction > 0.0
        line = line_from_rake(plane, rake).vector()
        assert abs(line @ slip.vector()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("rake", "sense", "expected"),
    [
        (90.0, "normal", -90.0),
        (90.0, "reverse", 90.0),
        (0.0, "sinistral", 0.0),
        (0.0, "dextral", 180.0),
        (45.0, "normal", -45.0),
        (45.0, "reverse", 135.0),
        (45.0, "sinistral", -45.0),
        (45.0, "dextral", 135.0),
        (135.0, "normal", -135.0),
        (135.0, "reverse", 45.0),
        (135.0, "sinistral", 45.0),
        (135.0, "dextral", -135.0),
    ],
)
def test_directed_rakes_follow_aki_and_richards(rake, sense, expected):
    found = slip_rake(FAULT, rake, sense)
    assert found == expected
    assert math.copysign(1.0, found) == math.copysign(1.0, expected)


def test_sense_that_does_not_determine_the_direction_gives_no_slip_rake():
    assert slip_rake(FAULT, 0.0, "normal") is None
    assert slip_rake(FAULT, 90.0, "dextral") is None
    assert slip_rake(FAULT, 40.0, "") is None
    # No wall hangs over a vertical plane, and a horizontal one has no strike.
    assert slip_rake(Plane(120.0, 90.0), 40.0, "reverse") is None
    assert slip_rake(Plane(120.0, 90.0), 40.0, "dextral") == 140.0
    assert slip_rake(Plane(0.0, 0.0), 40.0, "sinistral") is None


# --- lines on planes -----------------------------------------------------------------------------
@pytest.mark.parametrize("rake", [0.0, 12.0, 90.0, 143.0])
def test_a_line_on_a_plane_has_its_rake(rake):
    records = world(trace("f1", FAULT), lineation(along(FAULT, rake), "f1"))
    found = measured(records, "l1")
    assert found.rake_deg == pytest.approx(rake, abs=1e-6)
    assert found.off_plane_deg == pytest.approx(0.0, abs=1e-6)
    expected = line_from_rake(FAULT, rake)
    assert found.line.vector() == pytest.approx(expected.vector(), abs=1e-8)


@pytest.mark.parametrize("off", [3.0, 8.0, 25.0])
def test_line_off_its_plane_is_projected_and_its_angle_reported(off):
    rad = math.radians(off)
    inside = line_from_rake(FAULT, 40.0).vector()
    out = math.cos(rad) * inside + math.sin(rad) * FAULT.normal()
    records = world(trace("f1", FAULT), lineation([[0, 0, 0], 4 * out], "f1"))
    found = measured(records, "l1")
    assert found.off_plane_deg == pytest.approx(off, abs=1e-6)
    assert found.rake_deg == pytest.approx(40.0, abs=1e-6)
    assert found.line.vector() == pytest.approx(inside, abs=1e-8)
    reasons = by_code(found.verdict.reasons)
    expected = {"angle_deg": pytest.approx(off, abs=1e-6)} if off > 10.0 else None
    assert reasons.get("line.off-plane") == expected


def test_deleted_plane_keeps_the_line_and_is_reported():
    found = measured(world(lineation(along(FAULT, 40.0), "f1", "normal")), "l1")
    assert found.rake_deg is None
    assert found.slip_rake_deg is None
    assert found.line is not None
    assert "line.plane-missing" in by_code(found.verdict.reasons)


def test_compass_reading_is_a_plane_of_unknown_error():
    reading = Reading("r1", "R01", "fault", "plane", 120.0, 60.0)
    chance = np.random.default_rng(3)
    points = along(FAULT, 40.0, 9) + chance.normal(0, 0.005, (9, 3))
    found = measured(world(reading, lineation(points, "r1", "normal")), "l1")
    assert found.slip_rake_deg == pytest.approx(-40.0, abs=1.0)
    assert found.max_confidence95_deg is None
    assert "line.plane-error-unknown" in by_code(found.verdict.reasons)


@pytest.mark.full
@pytest.mark.parametrize("n", [4, 12])
def test_region_of_a_line_on_a_plane_contains_it_in_95_percent_of_cases(n):
    """Both are picked anew in every run: the fault's trace and the striation on it."""
    chance = np.random.default_rng(n)
    truth, runs, held = line_from_rake(FAULT, 40.0).vector(), 500, 0
    for run in range(runs):
        points = along(FAULT, 40.0, n) + chance.normal(0, 0.02, (n, 3))
        fault = trace("f1", FAULT, count=20, extent=4.0, rough=0.04, seed=1000 * n + run)
        found = measured(world(fault, lineation(points, "f1")), "l1")
        v = found.line.vector()
        t = truth * np.sign(truth @ v)
        t = t / (t @ v) - v
        e2 = np.cross(v, found.confidence_axis)
        x = (t @ found.confidence_axis) / math.tan(math.radians(found.max_confidence95_deg))
        y = (t @ e2) / math.tan(math.radians(found.min_confidence95_deg))
        held += x * x + y * y <= 1.0
    assert 0.92 <= held / runs <= 0.985


def test_lines_rotate_with_the_world():
    """A turn about the vertical adds to every azimuth and leaves rakes, errors and lengths."""
    chance = np.random.default_rng(11)
    points = along(FAULT, 40.0, 7) + chance.normal(0, 0.02, (7, 3))
    records = world(trace("f1", FAULT, rough=0.02), lineation(points, "f1", "reverse"))
    plain = measured(records, "l1")
    for turn in (30.0, 145.0, 270.0):
        rad = math.radians(turn)
        rows = (
            (math.cos(rad), math.sin(rad), 0.0, 4e5),
            (-math.sin(rad), math.cos(rad), 0.0, 5e6),
            (0.0, 0.0, 1.0, 800.0),
            (0.0, 0.0, 0.0, 1.0),
        )
        found = measured({**records, MODEL.id: placed(MODEL, rows)}, "l1")
        assert (found.line.trend_deg - plain.line.trend_deg) % 360.0 == pytest.approx(turn)
        assert found.line.plunge_deg == pytest.approx(plain.line.plunge_deg, abs=1e-6)
        assert found.rake_deg == pytest.approx(plain.rake_deg, abs=1e-6)
        assert found.slip_rake_deg == pytest.approx(plain.slip_rake_deg, abs=1e-6)
        assert found.max_confidence95_deg == pytest.approx(plain.max_confidence95_deg, rel=1e-5)


# --- thickness -----------------------------------------------------------------------------------
def thickness(ends, plane_id="f1") -> Dimension:
    vertices = tuple(map(tuple, np.asarray(ends, float).tolist()))
    return Dimension("d1", "T01", "thickness", "m1", HASH, vertices, plane_id)


@pytest.mark.parametrize("plane", [Plane(0, 0), FAULT, Plane(45, 90), Plane(200, 12)])
def test_thickness_is_perpendicular_to_the_plane_for_any_end_points(plane):
    chance = np.random.default_rng(5)
    records = world(trace("f1", plane))
    for _ in range(10):
        s, d = chance.uniform(-5, 5, 2)
        end = 1.8 * plane.normal() + s * plane.strike_vector() + d * plane.dip_vector()
        found = measured({**records, "d1": thickness([[0, 0, 0], end])}, "d1").dimension
        assert found["thickness_m"] == pytest.approx(1.8)
        assert found["thickness_error95_m"] == pytest.approx(0.0, abs=1e-6)
        assert found["distance_m"] == pytest.approx(np.linalg.norm(end))
        back = measured({**records, "d1": thickness([end, [0, 0, 0]])}, "d1").dimension
        assert back["thickness_m"] == pytest.approx(1.8)


@pytest.mark.full
@pytest.mark.parametrize("apart", first_in_default_tier([0.0, 6.0], 1))
def test_thickness_error_contains_the_truth_in_95_percent_of_cases(apart):
    """The bed is picked anew in every run, and both ends lie on uneven surfaces."""
    chance = np.random.default_rng(17)
    rough, runs, held = 0.03, 600, 0
    n = FAULT.normal()
    for run in range(runs):
        bed = trace("f1", FAULT, count=20, extent=4.0, rough=rough, seed=run)
        base = rough * chance.normal() * n
        top = (1.8 + rough * chance.normal()) * n + apart * FAULT.strike_vector()
        figures = measured(world(bed, thickness([base, top])), "d1").dimension
        held += abs(figures["thickness_m"] - 1.8) <= figures["thickness_error95_m"]
    assert 0.925 <= held / runs <= 0.975


def test_thickness_without_a_plane_reports_the_reason():
    gone = measured(world(thickness([[0, 0, 0], [0, 0, 1]])), "d1")
    assert gone.problem == Finding("thickness.plane-lost")
    none = measured(world(thickness([[0, 0, 0], [0, 0, 1]], "")), "d1")
    assert none.problem == Finding("thickness.no-plane")


# --- what rests on a trace that tells no plane ----------------------------------------------------
RESOLUTION = 0.05


def straight(id_: str, seed: int = 3, rule: int = SURROUNDINGS_RULE) -> Trace:
    """Along a level line to the east, which strays along the flat wall by half a resolution."""
    chance = np.random.default_rng(seed)
    points = np.zeros((30, 3))
    points[:, 0] = np.linspace(-4.0, 4.0, 30)
    points[:, 1] = chance.normal(0.0, 0.05 * RESOLUTION, 30)
    points[:, 2] = chance.normal(0.0, 0.5 * RESOLUTION, 30)
    vertices = tuple(map(tuple, points.tolist()))
    wall = (0.0, 1.0, 0.0)
    return Trace(id_, id_, "bedding", "m1", HASH, vertices, RESOLUTION, wall, rule=rule)


def test_results_from_a_poorly_constrained_plane_are_rated_poor():
    records = world(straight("b"), trace("f1", FAULT, rough=0.01))
    bed = measured(records, "b")
    assert bed.verdict.quality == "poor"
    meeting = Intersection("x", "X01", "intersection", Group("b"), Group("f1"))
    found = measured({**records, "x": meeting}, "x")
    assert found.max_confidence95_deg > 60.0
    assert found.verdict.quality == "poor"
    striae = lineation(np.array([[0, 0, 0], [1, 0.2, 0.4], [2, 0.4, 0.8]]), "b")
    found = measured({**records, "l1": striae}, "l1")
    assert found.max_confidence95_deg > 60.0
    assert found.verdict.quality == "poor"


@pytest.mark.parametrize("seed", range(5))
def test_thickness_error_covers_every_rotation_of_a_poorly_constrained_plane(seed):
    end = np.array([0.5, 1.0, 2.0])
    records = world(straight("b", seed), thickness([[0, 0, 0], end], "b"))
    found = measured(records, "d1").dimension
    for turn in np.radians(range(0, 180, 5)):
        possible = abs(end @ [0.0, math.cos(turn), math.sin(turn)])
        assert abs(found["thickness_m"] - possible) <= found["thickness_error95_m"] + 0.05


def test_resolution_by_an_earlier_rule_does_not_change_results():
    meeting = Intersection("x", "X01", "intersection", Group("b"), Group("f1"))
    fault = trace("f1", FAULT, rough=0.01)
    earlier = measured(world(straight("b", rule=0), fault, meeting), "x")
    unknown = measured(world(replace(straight("b"), resolution=None), fault, meeting), "x")
    assert earlier.max_confidence95_deg == unknown.max_confidence95_deg


# --- intersections -------------------------------------------------------------------------------
BED = Plane(30.0, 25.0)


def test_intersection_of_two_picked_planes_is_the_true_line():
    records = world(
        trace("f1", FAULT),
        trace("b1", BED, "bedding"),
        Intersection("i1", "I01", "lineation", Group("f1"), Group("b1")),
    )
    found = measured(records, "i1")
    truth = np.cross(FAULT.normal(), BED.normal())
    truth /= np.linalg.norm(truth)
    assert abs(found.line.vector() @ truth) == pytest.approx(1.0)
    # Both pass the origin: the drawn line does, and is as long as the longer of the two.
    start, end = found.points
    assert np.linalg.norm(np.cross(end - start, start)) == pytest.approx(0.0, abs=1e-6)
    longest = max(measured(records, i).fit.extent for i in ("f1", "b1"))
    assert np.linalg.norm(end - start) == pytest.approx(longest)


@pytest.mark.full
def test_region_of_an_intersection_contains_the_true_line():
    truth = np.cross(FAULT.normal(), BED.normal())
    truth /= np.linalg.norm(truth)
    runs, held = 400, 0
    crossing = Intersection("i1", "I01", "lineation", Group("f1"), Group("b1"))
    for run in range(runs):
        records = world(
            trace("f1", FAULT, extent=4.0, rough=0.03, seed=run),
            trace("b1", BED, "bedding", extent=5.0, rough=0.05, seed=9000 + run),
            crossing,
        )
        found = measured(records, "i1")
        v = found.line.vector()
        t = truth * np.sign(truth @ v)
        t = t / (t @ v) - v
        x = (t @ found.confidence_axis) / math.tan(math.radians(found.max_confidence95_deg))
        other = np.cross(v, found.confidence_axis)
        y = (t @ other) / math.tan(math.radians(found.min_confidence95_deg))
        held += x * x + y * y <= 1.0
    assert 0.92 <= held / runs <= 0.99


def test_an_intersection_follows_its_sets():
    """A bed more, one less, a set renamed: nothing of it is stored."""
    keep = Measurements()
    beds = [trace(f"b{i}", Plane(30.0 + i, 25.0 - i), "bedding", set_name="A") for i in range(4)]
    crossing = Intersection(
        "i1", "I01", "lineation", Group(type_id="fault"), Group(type_id="bedding", set_name="A")
    )
    records = world(trace("f1", FAULT), *beds, crossing)
    first = keep.of(records, ["i1"])["i1"]
    assert keep.of(dict(records), ["i1"])["i1"] is first
    fewer = {k: v for k, v in records.items() if k != "b3"}
    assert keep.of(fewer, ["i1"])["i1"].line != first.line
    other = {**records, "b3": replace(records["b3"], set_name="B")}
    assert keep.of(other, ["i1"])["i1"].line == keep.of(fewer, ["i1"])["i1"].line
    empty = {k: v for k, v in records.items() if not k.startswith("b")}
    assert keep.of(empty, ["i1"])["i1"].problem == Finding("sets.no-members")


def test_bedding_and_fault_of_the_sample_intersect_in_the_true_axis():
    from vomstudio.core.paths import resource

    with resource("sample", "picks.csv").open(newline="") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    names = dict.fromkeys(r["pick"] for r in rows if r["kind"] in ("bedding", "fault"))
    records = {MODEL.id: MODEL}
    for name in names:
        own = [r for r in rows if r["pick"] == name]
        points = tuple((float(r["x"]), float(r["y"]), float(r["z"])) for r in own)
        records[name] = Trace(
            name, name, own[0]["kind"], "m1", HASH, points, set_name=own[0]["set"]
        )
    axis = lines_to_vectors(31.0, 11.0)  # truth.csv, the fold axis
    for name in [n for n in names if n.startswith("B")]:
        crossing = Intersection("i", "I", "lineation", Group(name), Group("F01"))
        found = measure_all(records, [crossing])[0]
        off = math.degrees(math.acos(min(1.0, abs(found.line.vector() @ axis))))
        assert off <= 2.0 * found.max_confidence95_deg, name
    crossing = Intersection(
        "i",
        "I",
        "lineation",
        Group(type_id="bedding", set_name="1 west limb"),
        Group(type_id="fault"),
    )
    found = measure_all(records, [crossing])[0]
    off = math.degrees(math.acos(min(1.0, abs(found.line.vector() @ axis))))
    assert off <= found.max_confidence95_deg


# --- edits and tables ----------------------------------------------------------------------------
def test_changing_vertices_of_a_line_keeps_other_fields_and_can_be_undone(session):
    session.apply(edits.add_trace(session.records, trace("f1", FAULT)))
    line = lineation(along(FAULT, 40.0), "f1", "normal")
    session.apply(edits.add_features(session.records, [line]))
    other = tuple(map(tuple, along(FAULT, 80.0, 3).tolist()))
    session.apply(edits.set_line(session.records, "l1", other, resolution=0.02))
    assert session.records["l1"] == replace(line, vertices=other, resolution=0.02)
    session.undo()
    assert session.records["l1"] == line
    session.redo()
    session.undo()
    session.undo()
    assert "l1" not in session.records
    with pytest.raises(DocumentError):
        edits.set_line(session.records, "f1", other)


def test_the_table_has_trend_plunge_and_rake_of_lines(tmp_path: Path):
    crossing = Intersection("i1", "I01", "lineation", Group("f1"), Group("b1"))
    records = world(
        trace("f1", FAULT),
        trace("b1", BED, "bedding"),
        crossing,
        lineation(along(FAULT, 40.0, 5), "f1", "normal"),
    )
    table = project_table(records)
    out = tmp_path / "out.csv"
    write_orientation_csv(out, table.rows, crs=table.crs, north=table.north)
    with out.open(newline="", encoding="utf-8-sig") as stream:
        lines = [line for line in stream if not line.startswith("#")]
    rows = {r["id"]: r for r in csv.DictReader(lines)}
    line = line_from_rake(FAULT, 40.0)
    assert float(rows["l1"]["trend_deg"]) == pytest.approx(line.trend_deg)
    assert float(rows["l1"]["plunge_deg"]) == pytest.approx(line.plunge_deg)
    assert float(rows["l1"]["rake_deg"]) == pytest.approx(40.0)
    assert float(rows["l1"]["slip_rake_deg"]) == pytest.approx(-40.0)
    assert rows["l1"]["element"] == rows["i1"]["element"] == "line"
    assert rows["i1"]["rake_deg"] == ""
    assert rows["f1"]["trend_deg"] == ""
    found = measured(records, "i1").line
    assert float(rows["i1"]["trend_deg"]) == pytest.approx(found.trend_deg)


def test_layers_contain_lines_and_dimensions(tmp_path: Path):
    import pyogrio

    from vomstudio.project.exports.geopackage import write_layers

    crossing = Intersection("i1", "I01", "lineation", Group("f1"), Group("b1"))
    records = world(
        trace("f1", FAULT),
        trace("b1", BED, "bedding"),
        crossing,
        lineation(along(FAULT, 40.0, 5), "f1", "normal"),
        thickness([[0, 0, 0], 1.8 * FAULT.normal()]),
    )
    records[MODEL.id] = replace(MODEL, placement=Frame("crs", "EPSG:32633"))
    out = tmp_path / "out.gpkg"
    table = project_table(records)
    write_layers(out, records, table, project_layers(records, table, Measurements()))
    assert {"planes", "traces", "lines", "lineations", "dimensions"} <= {
        name for name, _ in pyogrio.list_layers(out)
    }
    fields, _, geometry, values = pyogrio.raw.read(out, layer="dimensions")[:4]
    row = dict(zip(fields["fields"], (v[0] for v in values), strict=True))
    assert row["thickness_m"] == pytest.approx(1.8)
    fields, _, geometry, values = pyogrio.raw.read(out, layer="lineations")[:4]
    row = dict(zip(fields["fields"], (v[0] for v in values), strict=True))
    assert row["rake_deg"] == pytest.approx(40.0)
    assert row["slip_rake_deg"] == pytest.approx(-40.0)
    assert len(geometry) == 1
    fields, _, geometry, values = pyogrio.raw.read(out, layer="lines")[:4]
    assert sorted(values[list(fields["fields"]).index("id")]) == ["i1", "l1"]


def test_a_straight_line_has_the_direction_of_the_line_fit():
    points = along(FAULT, 40.0, 6)
    found = measured(world(lineation(points)), "l1")
    assert found.line.vector() == pytest.approx(fit_line(points).direction)
    assert found.rake_deg is None
