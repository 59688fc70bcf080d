"""Readings beside picks, and the edit that adds readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.messages import refused
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.reading_comparison import NearestPick, nearest_picks, summary
from vomstudio.project.records import DEFAULT_TYPES, FeatureType, Model

LOCAL = Frame("local")
MODEL = Model("m", "cliff", "c.obj", "mesh", "0" * 64, LOCAL)


def records(*more):
    return {r.id: r for r in (*DEFAULT_TYPES, MODEL, *more)}


def trace(id_: str, dip_direction: float, dip: float, at=(0.0, 0.0, 0.0), **more) -> Trace:
    """Four corners of a plane around a place."""
    a = np.radians(dip_direction)
    down = np.array([np.sin(a), np.cos(a), -np.tan(np.radians(dip))])
    along = np.array([np.cos(a), -np.sin(a), 0.0])
    corners = [
        np.asarray(at) + s * down + t * along for s, t in ((-1, -1), (1, -1), (1, 1), (0, 2))
    ]
    points = tuple(tuple(float(v) for v in c) for c in corners)
    return Trace(id_, id_, more.pop("type_id", "bedding"), "m", "0" * 64, points, **more)


def reading(azimuth: float, steep: float, at=None, **more) -> Reading:
    return Reading(
        "r",
        "R",
        more.pop("type_id", "bedding"),
        more.pop("geometry", "plane"),
        azimuth,
        steep,
        position=at,
        **more,
    )


def comparison_text(*more):
    return nearest_picks(records(*more), Measurements()).get("r")


@pytest.mark.parametrize(
    ("first", "second", "angle"),
    [
        ((90.0, 30.0), (90.0, 50.0), 20.0),  # the same strike: the difference of the dips
        ((90.0, 30.0), (270.0, 30.0), 60.0),  # two limbs: their sum
        ((0.0, 89.0), (180.0, 89.0), 2.0),  # steep to either side: axial
        ((0.0, 45.0), (90.0, 45.0), 60.0),  # acos(cos2 45 + sin2 45 cos 90)
    ],
)
def test_angle_between_planes_ignores_normal_direction(first, second, angle):
    found = comparison_text(trace("a", *first), reading(*second))
    assert found.angle_deg == pytest.approx(angle, abs=1e-6)
    assert found.distance_m is None


def test_reading_with_position_is_matched_to_the_nearest_pick_in_space():
    near, alike = trace("near", 90, 30, (0, 0, 0)), trace("alike", 90, 50, (100, 0, 0))
    found = comparison_text(near, alike, reading(90, 50, near.vertices[0]))
    assert (found.pick_id, found.distance_m) == ("near", 0.0)
    assert found.angle_deg == pytest.approx(20.0)
    assert comparison_text(near, alike, reading(90, 50)).pick_id == "alike"


def test_the_distance_is_to_the_nearest_point_in_world_metres():
    millimetres = Frame("local", unit_m=0.001)
    model = replace(MODEL, placement=millimetres)
    own = records(trace("a", 90, 30), reading(90, 30, (0.0, 0.0, 5.0)))
    own["m"] = model
    found = nearest_picks(own, Measurements())["r"]
    assert found.distance_m == pytest.approx(5.0, abs=2e-3)


def test_only_picks_of_the_same_type_and_geometry_are_compared():
    assert comparison_text(trace("a", 90, 30, type_id="fault"), reading(90, 30)) is None
    assert comparison_text(trace("a", 90, 30), reading(90, 30, geometry="line")) is None


def test_pick_without_north_is_not_compared():
    own = records(trace("a", 90, 30), reading(90, 30))
    own["m"] = replace(MODEL, placement=Frame("undeclared"))
    assert nearest_picks(own, Measurements()) == {}


def test_lines_are_compared_with_lineations():
    line = Lineation("l", "L", "lineation", "m", "0" * 64, ((0, 0, 0), (10.0, 0, 0)))
    found = comparison_text(line, reading(0, 0, type_id="lineation", geometry="line"))
    assert found.angle_deg == pytest.approx(90.0)
    assert comparison_text(
        line, reading(270, 10, type_id="lineation", geometry="line")
    ).angle_deg == (pytest.approx(10.0))


def test_distance_to_a_patch_is_measured_to_its_outline():
    square = ((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (10.0, 10.0, 0.0), (0.0, 10.0, 0.0))
    scatter = ((8.0, 0.0, 0.0), (0.0, 8.0, 0.0), (0.0, 0.0, 0.01))
    patch = Patch(
        "p",
        "P",
        "bedding",
        "m",
        "0" * 64,
        "face",
        ((0, 100),),
        100,
        (5.0, 5.0, 0.0),
        scatter,
        100.0,
        outline=square,
    )
    found = comparison_text(patch, reading(0, 0, (13.0, 10.0, 4.0)))
    assert found.distance_m == pytest.approx(5.0)
    assert found.angle_deg == pytest.approx(0.0, abs=1e-6)


def test_summary_reports_median_angle_and_unmatched_readings():
    own = records(trace("a", 90, 30))
    readings = [replace(reading(90, 30 + d), id=f"r{d}") for d in (2, 6, 20)]
    readings.append(replace(reading(90, 30, type_id="fault"), id="f"))
    own |= {r.id: r for r in readings}
    ids = [r.id for r in readings]
    picks = nearest_picks(own, Measurements())
    assert _compared(summary(ids[:3], picks)) == (3, 3, pytest.approx(6.0))
    assert _compared(summary(ids, picks)) == (4, 3, pytest.approx(6.0))
    assert summary(["f"], picks) == Finding("readings.no-picks", count=1)


def _compared(finding: Finding) -> tuple[int, int, float]:
    assert finding.code == "readings.compared"
    values = finding.values
    return values["count"], values["compared"], values["median_deg"]


# --- edits -----------------------------------------------------------------------------------
def test_readings_and_their_new_types_are_added_in_one_edit():
    dyke = FeatureType("d", "Dyke", "#332288")
    own = [replace(reading(10, 20), id="r1", name=""), replace(reading(1, 2), id="r2", name="")]
    own.append(replace(reading(1, 2, type_id="d"), id="r3", name="K"))
    edit = edits.add_readings(records(), own, [dyke])
    assert set(edit.after) == {"d", "r1", "r2", "r3"}
    assert [edit.after[i].name for i in ("r1", "r2", "r3")] == ["B01", "B02", "K"]
    changed = dict(records())
    edit.swap(changed)
    edit.inverse().swap(changed)
    assert changed == records()


def test_existing_type_name_is_rejected():
    with refused("name.taken", DocumentError):
        edits.add_readings(records(), [reading(1, 2)], [FeatureType("x", "bedding", "#000000")])
    with pytest.raises(DocumentError):
        edits.add_readings(records(), [])


def test_a_suggested_type_has_a_colour_of_its_own():
    own = records()
    for name in ("Dyke", "Cleavage", "Stylolite"):
        kind = edits.suggest_type(own, name)
        assert kind.color not in {k.color for k in own.values() if isinstance(k, FeatureType)}
        edits.add_type(own, kind).swap(own)


# --- which pick ------------------------------------------------------------------------------
def test_each_reading_is_matched_to_the_pick_at_its_position():
    """Among picks of many points and few, whichever came first."""
    picks = [trace(f"t{k}", 40.0 * k, 30.0, at=(100.0 * k, 0.0, 0.0)) for k in range(4)]
    picks[2] = replace(picks[2], vertices=(*picks[2].vertices, *picks[2].vertices[:3]))
    own = records(*picks)
    for k in range(4):
        id_ = f"r{k}"
        own[id_] = replace(reading(40.0 * k, 35.0, (100.0 * k, 0.0, 2.0)), id=id_)
    found = nearest_picks(own, Measurements())
    assert {id_: pick.pick_id for id_, pick in found.items()} == {
        f"r{k}": f"t{k}" for k in range(4)
    }
    for id_, pick in found.items():
        assert pick.name == pick.pick_id
        assert pick.angle_deg == pytest.approx(5.0)
        away = np.array(own[pick.pick_id].vertices) - own[id_].position
        assert pick.distance_m == pytest.approx(np.linalg.norm(away, axis=1).min())


def test_reading_without_position_is_matched_to_the_most_similar_pick():
    own = (trace("a", 90, 30), trace("b", 270, 85), trace("c", 0, 60))
    assert comparison_text(*own, reading(90, 85)).pick_id == "b"
    assert comparison_text(*own, reading(90, 30)).pick_id == "a"
    assert comparison_text(*own, reading(10, 50)).pick_id == "c"


def test_readings_are_compared_with_picks_of_their_own_type():
    own = records(trace("a", 90, 30), trace("f", 90, 80, type_id="fault"))
    own |= {
        "r1": replace(reading(90, 33), id="r1"),
        "r2": replace(reading(90, 73, type_id="fault"), id="r2"),
        "r3": replace(reading(90, 73, type_id="joint"), id="r3"),
    }
    found = nearest_picks(own, Measurements())
    assert {id_: (p.pick_id, round(p.angle_deg, 6)) for id_, p in found.items()} == {
        "r1": ("a", 3.0),
        "r2": ("f", 7.0),
    }


def test_invalid_picks_are_not_matched():
    line = tuple((float(i), 2.0 * i, 3.0 * i) for i in range(5))
    straight = replace(trace("a", 90, 30), vertices=line)
    assert comparison_text(straight, reading(90, 30)) is None
    assert comparison_text(straight, trace("b", 90, 40), reading(90, 30)).pick_id == "b"
    lost = replace(trace("a", 90, 30), model_id="gone")
    assert comparison_text(lost, reading(90, 30)) is None
    # Another reading is no pick, nor is a lineation of a plane's type.
    assert comparison_text(replace(reading(90, 30), id="r9"), reading(90, 30)) is None
    streak = Lineation("l", "L", "bedding", "m", "0" * 64, ((0, 0, 0), (10.0, 0, 0)))
    assert comparison_text(streak, reading(90, 30)) is None
    assert comparison_text(streak, reading(90, 30, geometry="line")).angle_deg == pytest.approx(
        30.0
    )
    assert nearest_picks(records(trace("a", 90, 30)), Measurements()) == {}


def test_summary_counts_compared_readings():
    def pick(angle: float) -> NearestPick:
        return NearestPick("a", "B01", angle, None)

    picks = {"r1": pick(4.0), "r2": pick(7.4), "r3": pick(20.0)}
    one = summary(["r1"], picks)
    assert _compared(one) == (1, 1, 4.0)
    assert _compared(summary(["r1", "r2", "r3"], picks)) == (3, 3, 7.4)
    assert _compared(summary(["r1", "x"], picks)) == (2, 1, 4.0)
    assert summary([], {}) == Finding("readings.no-picks", count=0)
    assert summary(["x"], picks) == Finding("readings.no-picks", count=1)
