"""How kinds are drawn and what they say in words, where the answer is known beforehand."""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import replace
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest

from tests.messages import figures, shown_values
from tests.project.test_kinds import HASH, MODEL, ONE_OF_EACH, RECORDS_OF_ALL
from tests.samples import ZIGZAG, bed
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane, slip_from_rake
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.figures import Subject
from vomstudio.project.kind import (
    Attribute,
    GisLayer,
    KindGroup,
    NetAppearance,
    has_plane,
    is_picked_plane,
    may_have_plane,
    midpoint,
    select_plane_features,
    visibility_group,
)
from vomstudio.project.kinds import ATTRIBUTES, GROUPS, KINDS, find_kind, get_kind
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading, comparison_finding
from vomstudio.project.measurement import Measurement, NearestPick
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import DEFAULT_TYPES, Feature, Group, Record

SQUARE = ((0.0, 0.0, 1.0), (2.0, 0.0, 1.0), (2.0, 2.0, 1.0), (0.0, 2.0, 1.0))
HALVED = replace(MODEL, placement=Frame("local", unit_m=0.5))


def seen(feature: Feature, *others: Record, model=MODEL, **more: Any) -> Subject:
    records = {r.id: r for r in (*DEFAULT_TYPES, model, *others, feature)}
    return Subject(feature, measure_all(records, [feature])[0], records, **more)


def drawn(subject: Subject):
    def measured(id_: str) -> Measurement | None:
        record = subject.records.get(id_)
        return measure_all(subject.records, [record])[0] if isinstance(record, Feature) else None

    return get_kind(subject.feature).sketch(subject, measured)


def words(subject: Subject) -> list[str]:
    return get_kind(subject.feature).words(subject.measured)


# --- what is said of all kinds ---------------------------------------------------------------
EVERY_ATTRIBUTE = [
    pytest.param(kind, attribute, id=f"{kind.name}-{attribute.field}")
    for kind in KINDS
    for attribute in kind.attributes
]


@pytest.mark.parametrize(("kind", "attribute"), EVERY_ATTRIBUTE)
def test_every_attribute_has_a_form_suitable_for_its_field(kind, attribute: Attribute):
    """The window builds a widget after the form; a choice offers what a record can hold."""
    hint = get_type_hints(kind.record)[attribute.field]
    form = "type" if attribute.field == "type_id" else "flag" if hint is bool else None
    if form is None:
        form = "choice" if get_args(hint) else "plane" if attribute.field == "plane_id" else "text"
    if attribute.field == "notes":
        form = "lines"
    if attribute.form == "word":
        # Words that are proposed, where a file may bring others.
        assert hint is str
        form = "word"
    assert attribute.form == form
    assert 0 < len(attribute.title) <= 12
    assert attribute.title[0].isupper()
    assert bool(attribute.choices) == (form in ("choice", "word"))
    if form == "choice":
        assert [value for value, _ in attribute.choices] == list(get_args(hint))
    if attribute.choices:
        said = [text for _, text in attribute.choices]
        assert len(set(said)) == len(said)
    assert bool(attribute.text) == (form == "flag")
    assert isinstance(attribute.text, str)


def test_attributes_are_offered_only_where_they_apply():
    asked = [
        (ONE_OF_EACH["lineation"], {"slip": True, "slip_confidence": False}),
        (
            replace(ONE_OF_EACH["lineation"], slip="normal"),
            {"slip": True, "slip_confidence": True, "plane_id": True},
        ),
        (
            replace(ONE_OF_EACH["lineation"], plane_id="", slip="normal"),
            {"slip": False, "slip_confidence": False, "plane_id": True},
        ),
        (ONE_OF_EACH["dimension"], {"plane_id": True}),
        (replace(ONE_OF_EACH["dimension"], kind="polyline"), {"plane_id": False}),
    ]
    asked += [
        (f, {"overturned": getattr(f, "type_id", "") == "bedding"})
        for name, f in ONE_OF_EACH.items()
        if name not in ("lineation", "dimension")
    ]
    for feature, special in asked:
        for attribute in get_kind(feature).attributes:
            assert attribute.applies(feature) is special.get(attribute.field, True)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_properties_of_a_kind_match_its_record(kind):
    assert find_kind(kind.name) is kind
    assert kind.title[0].isupper()
    assert kind.icon
    assert re.fullmatch("|#[0-9a-f]{6}", kind.color)
    # What has no feature type has a colour and a group of its own.
    assert bool(kind.color) == (not kind.has_feature_type) == (kind.group is not None)
    assert kind.evidence in ("", "picked", "read", "derived")
    assert kind.evidence == {
        "trace": "picked",
        "lineation": "picked",
        "patch": "picked",
        "reading": "read",
        "intersection": "derived",
        "dimension": "",
        "control_point": "",
        "contact": "",
        "lithology": "",
        "station": "",
        "known_line": "",
    }.get(kind.name, kind.evidence)
    assert bool(kind.orientations) == bool(kind.evidence) == (kind.net is not None)
    # Only what is clicked or painted is made with a tool.
    assert bool(kind.tool) == (kind.name not in ("reading", "intersection"))
    assert kind.has_dynamic_dependencies == (kind.name == "intersection")
    assert kind.parts == ({"first": Group, "second": Group} if kind.name == "intersection" else {})


def test_unknown_kind_is_none():
    assert find_kind("dyke") is None


def test_features_have_the_noun_of_their_kind():
    for name, feature in ONE_OF_EACH.items():
        what = {"dimension": "thickness", "station": "sample"}.get(name, name)
        assert get_kind(feature).noun(feature) == what
    for what in ("distance", "polyline", "area", "thickness"):
        feature = replace(ONE_OF_EACH["dimension"], kind=what, name="")
        assert get_kind(feature).noun(feature) == what
        added = edits.add_features({"m1": MODEL}, [feature])
        assert added.after["d1"].name == f"{what[0].upper()}01"


def test_readings_and_derived_lines_have_separate_sets_on_the_net():
    """In sets of its own, with a marker that no feature type has."""
    looks = {kind.name: kind.net for kind in KINDS if kind.net is not None}
    for name in ("trace", "lineation", "patch"):
        assert (looks[name].suffix, looks[name].marker) == ("", "")
    apart = [looks["reading"], looks["intersection"]]
    assert [look.suffix for look in apart] == [" (compass)", " (intersections)"]
    assert len({look.marker for look in apart} - {kind.symbol for kind in DEFAULT_TYPES}) == 2
    assert all(len(look.marker) == 1 for look in apart)
    assert NetAppearance() == looks["trace"]


def test_one_layer_is_main_and_only_untyped_layers_omit_columns():
    layers: list[GisLayer] = [kind.layer for kind in KINDS if kind.layer is not None]
    assert [layer.name for layer in layers if layer.main] == ["traces"]
    sparse = [kind for kind in KINDS if kind.layer is not None and kind.layer.sparse]
    assert {kind.name for kind in sparse} >= {"dimension", "control_point", "known_line"}
    assert not any(kind.has_feature_type for kind in sparse)
    geometries = {layer.name: layer.geometry for layer in layers}
    assert set(geometries.values()) == {"line", "ring", "point"}
    assert (
        geometries.items()
        >= {
            "traces": "line",
            "contacts": "line",
            "lineations": "line",
            "patches": "ring",
            "lithologies": "ring",
            "dimensions": "line",
            "stations": "point",
            "control_points": "point",
            "known_lines": "line",
        }.items()
    )
    for kind in KINDS:
        if kind.layer is not None:
            names = [figure.name for figure in kind.layer.figures]
            assert len(set(names)) == len(names)
            shape = kind.layer.shape(seen(ONE_OF_EACH[kind.name], bed("t1")))
            assert shape.shape[1] == 3


def test_untyped_kinds_are_listed_and_hidden_by_group():
    assert GROUPS[1] == KindGroup(id="dimensions", title="Measurements", icon="ruler")
    untyped = [ONE_OF_EACH[kind.name] for kind in KINDS if not kind.has_feature_type]
    assert [visibility_group(feature) for feature in untyped] == [group.id for group in GROUPS]
    assert visibility_group(ONE_OF_EACH["contact"]) == "fault"


def test_kinds_with_and_without_planes_are_distinguished():
    line_read = replace(ONE_OF_EACH["reading"], id="r2", geometry="line")
    records = {**RECORDS_OF_ALL, "r2": line_read}
    having = {i for i, r in records.items() if has_plane(r)}
    assert having == {"t1", "p1", "r1"}
    assert {i for i, r in records.items() if may_have_plane(r)} == {*having, "r2"}
    assert {i for i, r in records.items() if is_picked_plane(r)} == {"t1", "p1"}
    assert not has_plane(None)
    assert not may_have_plane(None)
    assert not is_picked_plane(None)
    found = select_plane_features(records, ["r1", "m1", "gone", "l1", "t1", "d1", "r2"])
    assert [r.id for r in found] == ["r1", "t1", "r2"]


def test_every_attribute_occurs_once_in_the_merged_list():
    assert {a.field for a in ATTRIBUTES} == {a.field for k in KINDS for a in k.attributes}
    fields = [a.field for a in ATTRIBUTES]
    assert fields.index("method") < fields.index("notes")
    assert fields.index("plane_id") < fields.index("slip")


# --- shapes ----------------------------------------------------------------------------------
def test_midpoint_is_at_half_the_length_of_the_line():
    line = np.array([[0, 0, 0], [0, 0, 4], [0, 4, 4], [8, 4, 4]], float)
    assert midpoint(line).tolist() == [0.0, 4.0, 4.0]
    assert midpoint(line[:3]).tolist() == [0.0, 0.0, 4.0]
    assert midpoint(np.array([[1.0, 2, 3], [3, 6, 9]])).tolist() == [2.0, 4.0, 6.0]


def test_trace_is_drawn_through_its_points_and_labelled_at_the_nearest_one():
    rng = np.random.default_rng(0)
    subject = seen(bed("t1"))
    sketch = drawn(subject)
    points = np.array(ZIGZAG)
    nearest = points[np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))]
    assert sketch.line.tolist() == points.tolist()
    assert sketch.anchor.tolist() == sketch.sign.tolist() == nearest.tolist()
    assert sketch.faces is sketch.label is None
    halved = drawn(seen(bed("t1"), model=HALVED))
    assert halved.line.tolist() == (0.5 * points).tolist()
    # Of many shapes, too: the vertex nearest the centroid, not one of a lowest coordinate.
    for _ in range(5):
        cloud = tuple(map(tuple, rng.uniform(-5.0, 5.0, (9, 3)).tolist()))
        own = np.array(cloud)
        away = np.linalg.norm(own - own.mean(axis=0), axis=1)
        anchor = drawn(seen(bed("t1", vertices=cloud))).anchor
        assert anchor.tolist() == own[np.argmin(away)].tolist()


def test_feature_without_points_is_not_drawn():
    for name in ("trace", "contact", "lineation", "lithology", "dimension", "station"):
        empty = replace(ONE_OF_EACH[name], vertices=())
        assert drawn(seen(empty)) is None
    assert drawn(seen(replace(ONE_OF_EACH["reading"], position=None))) is None
    adrift = Intersection("i1", "I", "lineation", Group("gone"), Group("t1"))
    assert drawn(seen(adrift)) is None


@pytest.mark.parametrize("name", ["trace", "contact", "lineation", "dimension"])
def test_single_click_is_drawn_as_a_point_without_a_line(name):
    one = replace(ONE_OF_EACH[name], vertices=((1.0, 2.0, 3.0),))
    subject = seen(one)
    assert get_kind(one).layer.shape(subject) is None
    sketch = drawn(subject)
    assert sketch.line.tolist() == [[1.0, 2.0, 3.0]]
    assert sketch.anchor.tolist() == [1.0, 2.0, 3.0]
    two = replace(one, vertices=((1.0, 2.0, 3.0), (2.0, 2.0, 3.0)))
    assert len(get_kind(two).layer.shape(seen(two))) == 2


def test_an_area_is_drawn_closed_and_a_length_open():
    area = Dimension("d1", "A01", "area", "m1", HASH, SQUARE)
    assert drawn(seen(area)).line.tolist() == [list(p) for p in (*SQUARE, SQUARE[0])]
    assert drawn(seen(area)).anchor.tolist() == [2.0, 2.0, 1.0]
    assert drawn(seen(area)).sign is None
    corner = replace(area, vertices=SQUARE[:3])
    assert len(drawn(seen(corner)).line) == 4
    assert len(drawn(seen(replace(area, vertices=SQUARE[:2]))).line) == 2
    assert len(drawn(seen(replace(area, kind="polyline"))).line) == 4


def patch(n: int = 4, **more: Any) -> Patch:
    made = ONE_OF_EACH["patch"]
    assert isinstance(made, Patch)
    return replace(made, outline=SQUARE[:n], **more)


def test_patch_is_drawn_as_its_outline_or_a_point():
    for n in (3, 4):
        subject = seen(patch(n), model=HALVED)
        ring = 0.5 * np.array(SQUARE[:n])
        sketch = drawn(subject)
        assert sketch.line.tolist() == [*ring.tolist(), ring[0].tolist()]
        assert sketch.faces is subject.feature
        assert sketch.anchor.tolist() == sketch.sign.tolist() == [0.5, 1.0, 1.5]
        assert get_kind(subject.feature).layer.shape(subject).tolist() == ring.tolist()
    for n in (0, 2):
        subject = seen(patch(n))
        assert drawn(subject).line.tolist() == [[1.0, 2.0, 3.0]]
        assert get_kind(subject.feature).layer.shape(subject) is None
    places = get_kind(patch()).places
    assert places(seen(patch(2))).tolist() == [[1.0, 2.0, 3.0], *map(list, SQUARE[:2])]
    assert places(seen(patch(0))).tolist() == [[1.0, 2.0, 3.0]]


def test_readings_and_intersections_are_drawn_at_their_positions():
    subject = seen(replace(ONE_OF_EACH["reading"], position=(4.0, 5.0, 6.0)))
    assert subject.measured.metric
    read = drawn(subject)
    assert read.line.tolist() == [[4.0, 5.0, 6.0]]
    assert read.anchor.tolist() == read.sign.tolist() == [4.0, 5.0, 6.0]
    meets = drawn(seen(ONE_OF_EACH["intersection"], ONE_OF_EACH["trace"], ONE_OF_EACH["patch"]))
    assert meets.anchor == pytest.approx(meets.line.mean(axis=0))
    assert meets.sign == pytest.approx(meets.anchor)


FAULT = Plane(90.0, 60.0)


START = np.array([100.0, 200.0, 30.0])


def striation(rake: float, slip: str, n: int = 3, size: float = 4.0) -> Lineation:
    radians = math.radians(rake)
    way = math.cos(radians) * FAULT.strike_vector() + math.sin(radians) * FAULT.dip_vector()
    points = START + np.linspace(0.0, size, n)[:, None] * way
    return Lineation(
        "l1",
        "L01",
        "fault",
        "m1",
        HASH,
        tuple(map(tuple, points.tolist())),
        plane_id="r1",
        slip=slip,
    )


@pytest.mark.parametrize("slip", ["normal", "reverse", "sinistral", "dextral"])
@pytest.mark.parametrize(("rake", "n", "size"), [(20.0, 2, 0.5), (130.0, 4, 4.0)])
def test_slip_arrow_points_in_the_movement_of_the_hanging_wall(
    rake: float, n: int, size: float, slip: str
):
    reading = Reading("r1", "R", "fault", "plane", 90.0, 60.0)
    subject = seen(striation(rake, slip, n, size), reading)
    way = slip_from_rake(FAULT, subject.measured.slip_rake_deg).vector()
    sketch = drawn(subject)
    assert len(sketch.line) == n + 3
    start, *_, end, left, head, right = sketch.line
    assert (end - start) @ way == pytest.approx(size)
    assert head.tolist() == end.tolist()
    # The wings lie in the plane, to either side, behind the head; it is seen and hides no line.
    for wing in (left, right):
        assert (wing - head) @ FAULT.normal() == pytest.approx(0.0, abs=1e-9)
        assert 0.1 < ((head - wing) @ way) / size < 0.3
    across = np.cross(FAULT.normal(), way)
    sides = [(wing - head) @ across for wing in (left, right)]
    assert sides[0] == pytest.approx(-sides[1])
    assert 0.3 < abs(sides[0]) / ((head - left) @ way) < 0.8
    middle = subject.measured.points.mean(axis=0)
    assert sketch.anchor == pytest.approx(middle)
    assert sketch.sign == pytest.approx(middle)


def test_a_line_without_a_slip_has_no_arrow():
    reading = Reading("r1", "R", "fault", "plane", 90.0, 60.0)
    for feature, others in (
        (striation(20.0, ""), [reading]),
        (striation(20.0, "normal"), []),
        (replace(striation(20.0, "normal"), plane_id=""), [reading]),
    ):
        subject = seen(feature, *others)
        assert drawn(subject).line.tolist() == subject.measured.points.tolist()
    # Nor where the plane is not at hand while the line is drawn.
    subject = seen(striation(20.0, "normal"), reading)
    bare = get_kind(subject.feature).sketch(subject, lambda id_: None)
    assert bare.line.tolist() == subject.measured.points.tolist()


# --- where planes meet -----------------------------------------------------------------------
def wall(id_: str, plane: Plane, centre, size: float = 10.0):
    """A square of four corners and its middle, on a plane."""
    u, v = 0.5 * size * plane.strike_vector(), 0.5 * size * plane.dip_vector()
    corners = [np.asarray(centre) + a * u + b * v for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    vertices = tuple(map(tuple, np.array(corners).tolist()))
    return replace(bed(id_), name=id_, vertices=vertices)


def meeting(*planes: Feature, first: str = "a", second: str = "b") -> Subject:
    crossing = Intersection("i1", "I01", "lineation", Group(first), Group(second))
    return seen(crossing, *planes)


def length(points: np.ndarray) -> float:
    return float(np.linalg.norm(points[1] - points[0]))


def test_intersection_line_is_drawn_where_the_planes_meet():
    a = wall("a", Plane(90.0, 90.0), (0.0, 0.0, 3.0))
    b = wall("b", Plane(180.0, 30.0), (5.0, 0.0, 0.0), size=14.0)
    subject = meeting(a, b)
    points = subject.measured.points
    extents = [seen(f).measured.fit.extent for f in (a, b)]
    assert length(points) == pytest.approx(max(extents))
    # On both planes, and nearest the middle of the two.
    normal_b = Plane(180.0, 30.0).normal()
    assert points[:, 0] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert (points - [5.0, 0.0, 0.0]) @ normal_b == pytest.approx([0.0, 0.0], abs=1e-9)
    middle, between = points.mean(axis=0), np.array([2.5, 0.0, 1.5])
    assert (middle - between) @ (points[1] - points[0]) == pytest.approx(0.0, abs=1e-9)


def test_intersection_far_from_its_planes_is_drawn_midway():
    a = wall("a", Plane(90.0, 10.0), (1000.0, 2000.0, 0.0))
    b = wall("b", Plane(90.0, 12.0), (1000.0, 2000.0, 10.0))
    points = meeting(a, b).measured.points
    assert points.mean(axis=0) == pytest.approx([1000.0, 2000.0, 5.0], abs=1e-6)
    assert length(points) == pytest.approx(max(seen(f).measured.fit.extent for f in (a, b)))
    # As far as their size and distance reach together, it is where they meet: 20 m aside.
    apart = 2 * 20.0 * math.tan(math.radians(25.0))
    a = wall("a", Plane(90.0, 25.0), (0.0, 0.0, 0.0), size=30.0)
    b = wall("b", Plane(270.0, 25.0), (0.0, 0.0, -apart), size=30.0)
    assert meeting(a, b).measured.points.mean(axis=0)[0] == pytest.approx(20.0)


def test_intersection_of_readings_has_the_size_of_a_picked_plane():
    read = Reading("b", "b", "bedding", "plane", 0.0, 45.0)
    for place in (None, (7.0, 8.0, 9.0)):
        own = replace(read, position=place)
        found = meeting(own, replace(own, id="a", azimuth_deg=90.0)).measured
        assert found.points.shape == (0, 3)
        assert found.line is not None
        assert found.metric
    a = wall("a", Plane(90.0, 60.0), (7.0, 8.0, 9.0))
    points = meeting(a, read).measured.points
    assert points.mean(axis=0) == pytest.approx([7.0, 8.0, 9.0])
    assert length(points) == pytest.approx(seen(a).measured.fit.extent)
    # A reading with a place has its plane go through that place.
    placed = replace(read, position=(7.0, 0.0, 9.0))
    points = meeting(a, placed).measured.points
    assert (points - [7.0, 0.0, 9.0]) @ Plane(0.0, 45.0).normal() == pytest.approx(
        [0.0, 0.0], abs=1e-9
    )
    assert (points - [7.0, 8.0, 9.0]) @ Plane(90.0, 60.0).normal() == pytest.approx(
        [0.0, 0.0], abs=1e-9
    )


def test_group_contains_the_picks_of_its_type_and_set():
    subject = seen(
        Intersection("i1", "I", "lineation", Group("", "bedding", "A"), Group("r1")),
        replace(wall("a", Plane(90.0, 30.0), (0, 0, 0)), set_name="A"),
        replace(wall("b", Plane(90.0, 60.0), (0, 0, 0)), set_name="B"),
        replace(wall("c", Plane(90.0, 80.0), (0, 0, 0)), set_name="A", type_id="fault"),
        Reading("r1", "R", "bedding", "plane", 0.0, 30.0, set_name="A"),
    )
    kind = get_kind(subject.feature)

    def below(**group: str) -> list[str]:
        feature = replace(subject.feature, first=Group(**group))
        return [f.id for f in kind.dependencies(subject.records, feature)]

    assert below(type_id="bedding", set_name="A") == ["a", "r1"]
    assert below(type_id="bedding", set_name="B") == ["b", "r1"]
    assert below(type_id="bedding") == ["a", "b", "r1"]
    assert below(type_id="fault") == ["c", "r1"]
    assert below(feature_id="c", type_id="bedding") == ["c", "r1"]
    assert list(kind.dependency_ids(subject.feature)) == ["r1"]
    both = replace(subject.feature, first=Group("a"))
    assert list(kind.dependency_ids(both)) == ["a", "r1"]


def test_parallel_planes_do_not_intersect():
    a = wall("a", Plane(90.0, 30.0), (0.0, 0.0, 0.0))
    found = meeting(a, wall("b", Plane(90.0, 30.0), (0.0, 0.0, 5.0))).measured
    assert found.problem == Finding("planes.parallel")
    assert found.line is found.verdict is None
    assert found.points.shape == (0, 3)
    assert found.kind == "intersection"
    assert words(meeting(a, wall("b", Plane(90.0, 30.0), (0.0, 0.0, 5.0)))) == []


# --- lengths and areas -----------------------------------------------------------------------
def dimension(kind: str, *vertices: tuple[float, float, float], **more: Any) -> Dimension:
    return Dimension("d1", "D01", kind, "m1", HASH, vertices, **more)


def test_lengths_match_the_right_triangle():
    ends = ((1.0, 1.0, 1.0), (4.0, 5.0, 13.0))
    for model, scale in ((MODEL, 1.0), (HALVED, 0.5)):
        found = seen(dimension("distance", *ends), model=model).measured
        assert found.dimension == {
            "distance_m": 13.0 * scale,
            "horizontal_m": 5.0 * scale,
            "vertical_m": 12.0 * scale,
            "trend_deg": pytest.approx(180.0 + math.degrees(math.atan2(3.0, 4.0))),
            "plunge_deg": pytest.approx(math.degrees(math.atan2(12.0, 5.0))),
        }
        back = seen(dimension("distance", *ends[::-1]), model=model).measured
        assert back.dimension == {**found.dimension, "vertical_m": -12.0 * scale}
    walk = dimension("polyline", ends[0], (1.0, 5.0, 1.0), (4.0, 5.0, 1.0), ends[1])
    straight = seen(dimension("distance", *ends)).measured.dimension
    lengths = {name: straight[name] for name in ("distance_m", "horizontal_m", "vertical_m")}
    assert seen(walk).measured.dimension == {**lengths, "length_m": 19.0}


def test_area_matches_that_of_its_ring():
    found = seen(dimension("area", *SQUARE), model=HALVED).measured
    assert found.dimension == {"area_m2": 1.0, "perimeter_m": 4.0}
    half = seen(dimension("area", *SQUARE[:3])).measured
    assert half.dimension == pytest.approx({"area_m2": 2.0, "perimeter_m": 4.0 + math.sqrt(8.0)})
    assert half.problem is None


def test_too_few_points_are_reported():
    for kind, few, minimum in (
        ("area", 2, 3),
        ("distance", 1, 2),
        ("polyline", 1, 2),
        ("thickness", 1, 2),
    ):
        why = Finding("feature.too-few-points", count=1, minimum=minimum)
        found = seen(dimension(kind, *SQUARE[:few])).measured
        assert (found.problem, found.dimension) == (why, None)
        assert get_kind(ONE_OF_EACH["dimension"]).headline(found) is None
        assert get_kind(ONE_OF_EACH["dimension"]).words(found) == []


def test_headline_of_a_dimension_is_its_main_value():
    level = Reading("r1", "R", "bedding", "plane", 0.0, 0.0)
    up = ((0.0, 0.0, 0.0), (3.0, 0.0, 4.0))
    headline = get_kind(ONE_OF_EACH["dimension"]).headline
    for feature, main, lines in (
        (
            dimension("distance", *up),
            "5.00 m",
            ["Distance 5.00 m", "Horizontal 3.00 m, upward 4.00 m", "Trend/plunge 270/53"],
        ),
        (
            dimension("distance", *up[::-1]),
            "5.00 m",
            ["Distance 5.00 m", "Horizontal 3.00 m, downward 4.00 m", "Trend/plunge 270/53"],
        ),
        (
            dimension("distance", (0.0, 0.0, 0.0), (2.0, 0.0, 0.0)),
            "2.00 m",
            ["Distance 2.00 m", "Horizontal 2.00 m, upward 0 mm", "Trend/plunge 090/00"],
        ),
        (
            dimension("polyline", up[0], (3.0, 0.0, 0.0), up[1]),
            "7.00 m",
            ["Length along the line 7.00 m", "Distance 5.00 m", "Horizontal 3.00 m, upward 4.00 m"],
        ),
        (dimension("area", *SQUARE), "4.00 m²", ["4.00 m²", "Perimeter 8.00 m"]),
        (
            dimension("thickness", *up, plane_id="r1"),
            "4.00 m",
            [
                "Thickness 4.00 m, 95 % error unknown",
                "Distance 5.00 m",
                "Horizontal 3.00 m, upward 4.00 m",
            ],
        ),
        (
            dimension("thickness", *up, plane_id="gone"),
            "5.00 m",
            ["Distance 5.00 m", "Horizontal 3.00 m, upward 4.00 m"],
        ),
    ):
        subject = seen(feature, level)
        assert headline(subject.measured) == main
        assert words(subject) == lines
        units = replace(subject.measured, metric=False)
        assert headline(units).endswith(" units²" if feature.kind == "area" else " units")
        lengths = [line for line in get_kind(feature).words(units) if "Trend" not in line]
        assert all("units" in line for line in lengths)


def test_thickness_is_shown_with_its_error():
    found = replace(
        seen(dimension("thickness", *SQUARE[:2])).measured,
        dimension={
            "thickness_m": 4.0,
            "thickness_error95_m": 0.1234,
            "distance_m": 5.0,
            "horizontal_m": 5.0,
            "vertical_m": 0.0,
        },
    )
    kind = get_kind(ONE_OF_EACH["dimension"])
    assert kind.headline(found) == "4.00 m ± 12 cm"
    assert figures(kind.words(found)[0]) == [4.0, 95.0, 12.0]


def test_every_value_of_a_dimension_is_in_its_own_column():
    feature = dimension("thickness", (0.0, 0.0, 0.0), (3.0, 4.0, 12.0), plane_id="t1")
    subject = seen(feature, bed("t1"))
    both = {**subject.measured.dimension, "length_m": 1.0, "area_m2": 2.0, "perimeter_m": 3.0}
    subject = replace(subject, measured=replace(subject.measured, dimension=both))
    kind = get_kind(feature)
    columns = {figure.name: figure.value(subject) for figure in kind.layer.figures}
    assert {name: columns[name] for name in both} == both
    assert columns["kind"] == "thickness"
    assert {figure.name for figure in kind.figures} >= set(both)
    titles = [figure.title for figure in kind.figures]
    assert len(set(titles)) == len(titles)


# --- other words -----------------------------------------------------------------------------
def test_intersection_shows_the_angle_between_its_planes() -> None:
    flat = wall("a", Plane(90.0, 30.0), (0.0, 0.0, 0.0))
    steep = wall("b", Plane(90.0, 50.0), (0.0, 0.0, 5.0))
    (line,) = words(meeting(flat, steep))
    assert figures(line) == [20.0]


def test_line_on_a_plane_shows_its_rake_and_slip() -> None:
    reading = Reading("r1", "R", "fault", "plane", 90.0, 60.0)
    rake, slip = words(seen(striation(20.0, "normal"), reading))
    assert figures(rake) == [20.0, 0.0]
    assert slip.endswith(" -20°")
    assert words(seen(striation(20.0, ""), reading)) == [rake]
    assert words(seen(striation(20.0, ""))) == []


def test_reading_shows_its_source_and_nearest_pick():
    reading = ONE_OF_EACH["reading"]
    kind = get_kind(reading)
    near, alike = NearestPick("t1", "B01", 12.34, 3.456), NearestPick("t1", "B01", 2.34, None)
    assert comparison_finding(None) == Finding("reading.no-pick")
    compared = {"angle": "12°", "angle_deg": 12.34, "pick": "B01"}
    away = {"distance": "3.46 m", "distance_m": 3.456}
    assert comparison_finding(near) == Finding("reading.nearest-pick", **compared, **away)
    compared = {"angle": "2.3°", "angle_deg": 2.34, "pick": "B01"}
    assert comparison_finding(alike) == Finding("reading.similar-pick", **compared)
    plain = seen(reading)
    assert (kind.remarks(plain), kind.about(plain)) == ([], [comparison_finding(None).message])
    turned = seen(replace(reading, turned_deg=-1.5, source="a.csv"), nearest=lambda: near)
    angle, nearest = kind.remarks(turned)
    assert angle.endswith(" -1.50 deg")
    assert figures(nearest) == [12.3, 3.46]
    compared, angle, source = kind.about(turned)
    assert compared == comparison_finding(near).message
    assert shown_values(angle, "reading.turned") == {"turned_deg": "-1.50"}
    assert source.endswith(" a.csv")
    similar = seen(reading, nearest=lambda: alike)
    assert figures(kind.remarks(similar)[0]) == [2.3]
    assert kind.about(similar) == [comparison_finding(alike).message]


def test_kinds_without_remarks_return_no_text():
    for name in ("trace", "lineation", "patch", "dimension", "intersection"):
        subject = seen(ONE_OF_EACH[name], ONE_OF_EACH["trace"], ONE_OF_EACH["patch"])
        kind = get_kind(subject.feature)
        assert kind.remarks(subject) == kind.about(subject) == []
        if name != "dimension":
            assert kind.headline(subject.measured) is None
    assert words(seen(ONE_OF_EACH["trace"])) == words(seen(ONE_OF_EACH["reading"])) == []


def test_records_of_every_kind_are_frozen():
    """What is in the history must not change behind its back."""
    for feature in ONE_OF_EACH.values():
        with pytest.raises(dataclasses.FrozenInstanceError):
            feature.name = "other"
