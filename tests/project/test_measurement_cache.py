"""Measurements of a document: what they rest on, when they are made anew, and what they carry."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from tests.messages import by_code
from tests.project.test_kinds import HASH, MODEL, ONE_OF_EACH, RECORDS_OF_ALL
from tests.samples import ZIGZAG, bed, placed
from vomstudio.core.errors import GeometryError
from vomstudio.geology.intersections import deviation95
from vomstudio.geology.orientation import Plane, line_from_rake
from vomstudio.geology.profiles import Thresholds
from vomstudio.geology.quality import governing_confidence_deg
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.planes import fit_plane, fit_planes
from vomstudio.project import edits
from vomstudio.project.kind import get_kind
from vomstudio.project.kinds import trace
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.measurement import (
    MeasurementContext,
    empty_measurement,
    fit_fields,
    is_metric,
    length_in_metres,
    matrix_to_world,
    plane_with_error,
    world_points,
)
from vomstudio.project.measurement_cache import (
    LABEL_FIELDS,
    Measurements,
    depends_on,
    get_sources,
    measure_all,
    measure_feature,
)
from vomstudio.project.records import DEFAULT_TYPES, Group, ModelFeature

COLLINEAR = tuple((float(i), 2.0 * i, 3.0 * i) for i in range(5))
ROUGH = tuple(
    (x, y, z + 0.05 * (-1) ** i * (1 + i % 3)) for i, (x, y, z) in enumerate((*ZIGZAG, *ZIGZAG))
)
TURNED = placed(
    replace(MODEL, placement=Frame("local")),
    [[0, -2, 0, 100], [2, 0, 0, 200], [0, 0, 2, 300], [0, 0, 0, 1]],
)


# --- what was measured before it came ----------------------------------------------------------
def test_measurement_of_a_new_feature_is_reused_when_it_is_added():
    """As long as it is judged by the same limits, and stays what it was."""
    patch = replace(ONE_OF_EACH["patch"], id="new", name="B99")
    own = Thresholds()
    given = measure_all(RECORDS_OF_ALL, [patch], own)[0]
    after = {**RECORDS_OF_ALL, "new": patch}
    keep = Measurements(own)
    keep.keep(RECORDS_OF_ALL, [(patch, given)], own)
    assert keep.of(after, ["new"])["new"] is given
    changed = replace(patch, scatter=tuple(tuple(4.0 * v for v in row) for row in patch.scatter))
    assert keep.of({**after, "new": changed}, ["new"])["new"].fit != given.fit
    stricter = replace(own, good_confidence95_deg=0.01, poor_confidence95_deg=0.02)
    other = Measurements(stricter)
    other.keep(RECORDS_OF_ALL, [(patch, given)], own)
    judged = other.of(after, ["new"])["new"]
    assert judged is not given
    assert judged.verdict != given.verdict


# --- kept as long as nothing changes ---------------------------------------------------------
def test_measurement_is_kept_until_one_of_its_dependencies_changes():
    keep = Measurements()
    first = keep.of(RECORDS_OF_ALL, RECORDS_OF_ALL)
    assert list(first) == list(ONE_OF_EACH[k].id for k in ONE_OF_EACH)
    again = keep.of(dict(RECORDS_OF_ALL), RECORDS_OF_ALL)
    assert all(again[id_] is first[id_] for id_ in first)
    for changed, anew in (
        ("m1", {"i1", *(f.id for f in ONE_OF_EACH.values() if isinstance(f, ModelFeature))}),
        ("t1", {"t1", "l1", "d1", "i1"}),
        ("p1", {"p1", "i1"}),
        ("r1", {"r1"}),
        ("l1", {"l1"}),
    ):
        keep = Measurements()
        first = keep.of(RECORDS_OF_ALL, RECORDS_OF_ALL)
        other = {"m1": {"path": "there.obj"}}.get(changed, {"type_id": "other"})
        records = {**RECORDS_OF_ALL, changed: replace(RECORDS_OF_ALL[changed], **other)}
        after = keep.of(records, records)
        assert {id_ for id_ in after if after[id_] is not first[id_]} == anew


@pytest.mark.parametrize("name", ONE_OF_EACH)
def test_labels_do_not_change_any_measurement(name):
    feature = ONE_OF_EACH[name]
    labels = LABEL_FIELDS & {field.name for field in fields(feature)}
    other = replace(feature, **dict.fromkeys(labels, "other"))
    records = {**RECORDS_OF_ALL, feature.id: other}
    for before, after in zip(
        vars(measure_all(RECORDS_OF_ALL, [feature])[0]).values(),
        vars(measure_all(records, [other])[0]).values(),
        strict=True,
    ):
        assert repr(before) == repr(after)
    keep = Measurements()
    first = keep.of(RECORDS_OF_ALL, [feature.id])[feature.id]
    if not get_kind(feature).has_dynamic_dependencies:
        assert keep.of(records, [feature.id])[feature.id] is first
        # The labels are compared with the newest ones.
        assert keep.of(RECORDS_OF_ALL, [feature.id])[feature.id] is first


def test_only_features_are_measured_and_each_under_its_own_id():
    keep = Measurements()
    found = keep.of(RECORDS_OF_ALL, ["gone", "p1", "m1", "t1"])
    assert list(found) == ["p1", "t1"]
    assert (found["p1"].kind, found["t1"].kind) == ("patch", "trace")
    assert keep.of({}, ["t1"]) == {}


def test_deleted_feature_is_forgotten_and_measured_again_when_restored():
    keep = Measurements()
    first = keep.of(RECORDS_OF_ALL, ["t1", "p1"])
    keep.keep_after_edit({"p1": RECORDS_OF_ALL["p1"]}, ["t1"])
    again = keep.of(RECORDS_OF_ALL, ["t1", "p1"])
    assert again["p1"] is first["p1"]
    assert again["t1"] is not first["t1"]


def test_feature_outside_the_document_is_measured_without_being_stored():
    keep = Measurements()
    loose = replace(ONE_OF_EACH["lineation"], id="loose")
    found = keep.measure(RECORDS_OF_ALL, loose)
    assert found.rake_deg == keep.of(RECORDS_OF_ALL, ["l1"])["l1"].rake_deg is not None
    assert keep.of(RECORDS_OF_ALL, ["loose"]) == {}


def test_known_measurements_are_reused():
    known = {"t1": replace(measure_all(RECORDS_OF_ALL, [bed("t1")])[0], plane=None)}
    line = ONE_OF_EACH["lineation"]
    assert measure_all(RECORDS_OF_ALL, [line])[0].rake_deg is not None
    assert measure_all(RECORDS_OF_ALL, [line], known_measurements=known)[0].rake_deg is None


def test_only_the_changed_plane_of_a_set_is_fitted_again(monkeypatch):
    """An intersection of sets may rest on thousands of planes: dragging one must stay quick."""
    fitted = []

    def counted(points, starts, **more):
        fitted.append(len(starts) - 1)
        return fit_planes(points, starts, **more)

    monkeypatch.setattr(trace, "fit_planes", counted)
    beds = {f"b{i}": bed(f"b{i}", shift=float(i)) for i in range(5)}
    steep = Reading("r1", "R", "fault", "plane", 90.0, 80.0)
    crossing = Intersection("i1", "I", "lineation", Group("", "bedding"), Group("r1"))
    records = {"m1": MODEL, **beds, "r1": steep, "i1": crossing}
    keep = Measurements()
    keep.of(records, ["i1"])
    keep.of(records, beds)
    assert sum(fitted) == 5
    keep.of({**records, "b2": bed("b2", shift=9.0)}, ["i1"])
    assert sum(fitted) == 6


@pytest.mark.parametrize("name", ["trace", "patch", "lineation", "intersection"])
def test_user_thresholds_apply_to_every_kind(name):
    strict, lax = Thresholds(0.0, 0.0, 1e9, -1e9, 1e9), Thresholds(90.0, 90.0, -1e9, 1e9, 0.0, 0.0)
    rough = {**RECORDS_OF_ALL, "t1": bed("t1", vertices=ROUGH)}
    rough["l1"] = replace(rough["l1"], vertices=ZIGZAG)
    feature = rough[ONE_OF_EACH[name].id]
    found = {}
    for words, thresholds in (("strict", strict), ("lax", lax)):
        found[words] = measure_all(rough, [feature], thresholds)[0].verdict.quality
        assert Measurements(thresholds).measure(rough, feature).verdict.quality == found[words]
    assert found["strict"] == "poor"
    assert found["lax"] != "poor"


def test_feature_depends_on_its_model_and_the_records_it_names():
    records = RECORDS_OF_ALL
    for name, below in (
        ("trace", ["t1", "m1"]),
        ("patch", ["p1", "m1"]),
        ("reading", ["r1"]),
        ("lineation", ["l1", "m1", "t1", "m1"]),
        ("dimension", ["d1", "m1", "t1", "m1"]),
        ("intersection", ["i1", "t1", "m1", "p1", "m1"]),
    ):
        feature = ONE_OF_EACH[name]
        assert [r.id for r in get_sources(records, feature)] == below
    alone = {"t1": records["t1"]}
    assert get_sources(alone, records["t1"]) == (records["t1"], None)


def test_feature_is_affected_only_by_edits_of_its_sources():
    for name in ("trace", "patch", "lineation", "dimension", "reading"):
        assert not depends_on(RECORDS_OF_ALL, ONE_OF_EACH[name], {"x1", "vein"})
    # Its type's colour, the plane it lies on, and what that plane rests on all show.
    line = ONE_OF_EACH["lineation"]
    assert all(depends_on(RECORDS_OF_ALL, line, {id_}) for id_ in ("lineation", "t1", "m1", "l1"))
    other = replace(bed("t1"), model_id="m2")
    across = {**RECORDS_OF_ALL, "t1": other, "m2": replace(MODEL, id="m2")}
    assert depends_on(across, line, {"m2"})
    assert not depends_on(RECORDS_OF_ALL, replace(line, plane_id=""), {"t1"})


def test_feature_without_a_fit_is_rejected_with_its_name():
    for name, said in (("B07", "B07"), ("", None)):
        with pytest.raises(GeometryError) as refused:
            measure_feature(replace(bed("t1", vertices=COLLINEAR), name=name), MODEL)
        assert refused.value.field == said
    assert measure_feature(bed("t1"), None).points.tolist() == [list(p) for p in ZIGZAG]
    assert measure_feature(bed("t1"), TURNED).points[0].tolist() == [100.0, 200.0, 300.0]
    strict = measure_feature(bed("t1"), MODEL, Thresholds(0.0, 0.0))
    assert strict.verdict.quality == "poor"


def test_changed_vertices_are_checked_in_world_coordinates():
    """A trace whose model shrinks it to a point has no plane there, as when it was added."""
    tiny = replace(MODEL, placement=Frame("local", unit_m=1e-300))
    records = {**RECORDS_OF_ALL, "bedding": DEFAULT_TYPES[0], "m1": tiny}
    more = {"resolution": None, "outcrop_normal": None}
    with pytest.raises(GeometryError):
        edits.set_vertices(records, "t1", ZIGZAG, **more)
    with pytest.raises(GeometryError):
        edits.add_trace(records, bed("new"))
    del records["m1"]
    edits.set_vertices(records, "t1", ZIGZAG, **more)
    edits.set_vertices({**records, "m1": bed("m1")}, "t1", ZIGZAG, **more)


# --- from the file to World ------------------------------------------------------------------
def test_points_and_lengths_are_transformed_to_world():
    feature = bed("t1")
    assert world_points(feature, None).tolist() == [list(p) for p in ZIGZAG]
    found = world_points(feature, TURNED)
    assert found[1] == pytest.approx([100.0 - 0.4, 200.0 + 2.0, 300.0 + 1.02])
    assert matrix_to_world(None).tolist() == np.eye(4).tolist()
    assert matrix_to_world(TURNED)[:3, 3].tolist() == [100.0, 200.0, 300.0]
    assert length_in_metres(0.25, matrix_to_world(TURNED)) == pytest.approx(0.5)
    assert length_in_metres(None, matrix_to_world(TURNED)) is None
    assert is_metric(None)
    assert not is_metric(replace(MODEL, placement=Frame("undeclared")))


@pytest.mark.parametrize("name", ["trace", "patch", "lineation"])
def test_the_resolution_of_a_feature_is_in_metres(name):
    feature = replace(ONE_OF_EACH[name], resolution=0.25)
    records = {**RECORDS_OF_ALL, "m1": TURNED}
    assert measure_all(records, [feature])[0].resolution_m == pytest.approx(0.5)
    none = replace(feature, resolution=None)
    assert measure_all(records, [none])[0].resolution_m is None


@pytest.mark.parametrize("name", ["trace", "patch", "lineation", "dimension"])
def test_unmeasurable_feature_keeps_its_points_and_reports_the_reason(name):
    feature = ONE_OF_EACH[name]
    if name == "patch":
        flat = replace(feature, n=2)
    else:
        flat = replace(feature, vertices=((1.0, 2.0, 3.0),))
    if name != "dimension":
        flat = replace(flat, resolution=0.25)
    for model, metric in ((TURNED, True), (replace(MODEL, placement=Frame()), False)):
        found = measure_all({**RECORDS_OF_ALL, "m1": model}, [flat])[0]
        assert found.problem
        assert (found.kind, found.metric) == (name, metric)
        assert found.fit is found.line is found.plane is found.verdict is None
        assert found.outcrop_normal is None
        assert len(found.points) == 1
    assert found.resolution_m == (None if name == "dimension" else 0.25)
    assert found.points[0].tolist() == [1.0, 2.0, 3.0]


def test_empty_measurement_contains_only_points_and_the_reason():
    points = np.array([[1.0, 2.0, 3.0]])
    found = empty_measurement(points, 0.5, "why", kind="lineation")
    assert (found.resolution_m, found.problem, found.kind) == (0.5, "why", "lineation")
    assert found.metric
    assert found.points is points
    assert found.fit is found.verdict is found.line_fit is found.outcrop_normal is None
    assert not empty_measurement(points, None, None, kind="x", metric=False).metric
    assert fit_fields(None) == {}


# --- traces ----------------------------------------------------------------------------------
def test_each_trace_is_fitted_by_its_own_method():
    tilted = tuple((x, y, z + 0.3 * (-1) ** i) for i, (x, y, z) in enumerate(ZIGZAG))
    pca = bed("t1", vertices=tilted)
    regression = replace(pca, id="t2", method="regression")
    bad = bed("t3", vertices=COLLINEAR)
    batch = [regression, pca, bad, replace(bad, id="t4", method="regression"), regression, pca]
    found = measure_all({"m1": MODEL}, batch)
    for feature, measured in zip(batch, found, strict=True):
        if feature.vertices == COLLINEAR:
            assert measured.fit is None
            assert measured.problem
            continue
        fit = fit_plane(tilted, method=feature.method)
        assert measured.fit.normal == pytest.approx(fit.normal)
        assert measured.fit.method == feature.method
        assert measured.plane.dip_deg == pytest.approx(fit.dip_deg)
        assert measured.max_confidence95_deg == fit.max_confidence95_deg
        assert measured.min_confidence95_deg == fit.min_confidence95_deg
        assert measured.problem is None
    assert found[0].plane != found[1].plane


def test_outcrop_face_rotates_with_its_model_and_warns_of_a_trace_within_it():
    fit = fit_plane(ZIGZAG)
    within = replace(bed("t1"), outcrop_normal=tuple(fit.normal.tolist()))
    found = measure_all({"m1": TURNED}, [within])[0]
    x, y, z = fit.normal
    assert found.outcrop_normal == pytest.approx([-y, x, z])
    assert by_code(found.verdict.reasons)["plane.in-face"] == {
        "angle_deg": pytest.approx(0.0, abs=0.05)
    }
    plain = measure_all({"m1": TURNED}, [bed("t1")])[0]
    assert plain.outcrop_normal is None
    assert "plane.in-face" not in by_code(plain.verdict.reasons)


OF_RESOLUTION = {"plane.resolution", "plane.too-small"}


def test_too_coarse_resolution_is_a_reason_in_the_verdict():
    for name in ("trace", "patch"):
        coarse = replace(ONE_OF_EACH[name], resolution=1.0)
        found = measure_all(RECORDS_OF_ALL, [coarse])[0]
        assert OF_RESOLUTION & by_code(found.verdict.reasons).keys()
        unknown = measure_all(RECORDS_OF_ALL, [ONE_OF_EACH[name]])[0]
        assert not OF_RESOLUTION & by_code(unknown.verdict.reasons).keys()


# --- planes with their error -----------------------------------------------------------------
def test_plane_has_the_error_and_roughness_of_its_points():
    measured = measure_all({"m1": MODEL}, [bed("t1", vertices=ROUGH)])[0]
    fit = measured.fit
    found = plane_with_error(measured)
    assert found.normal == pytest.approx(fit.normal)
    # The tilt is largest along the rake that is told, by the angle that is told.
    worst = line_from_rake(measured.plane, fit.error_rake_deg).vector()
    stated = math.degrees(math.atan(deviation95(found, worst)))
    assert stated == pytest.approx(governing_confidence_deg(fit))
    best = np.cross(found.normal, worst)
    assert math.degrees(math.atan(deviation95(found, best))) == pytest.approx(
        fit.min_confidence95_deg
    )
    # Three of the points' freedoms went into the plane.
    off = (np.array(ROUGH) - fit.centroid) @ fit.normal
    assert found.roughness == pytest.approx(math.sqrt((off**2).sum() / (len(ROUGH) - 3)))
    assert found.degrees_of_freedom == pytest.approx(max(fit.n_effective - 3.0, 1.0))


def test_error_has_at_least_one_degree_of_freedom():
    measured = measure_all({"m1": MODEL}, [bed("t1", vertices=ROUGH)])[0]
    for n, free in ((None, 1.0), (3.2, 1.0), (4.5, 1.5), (13.0, 10.0)):
        other = replace(measured, fit=replace(measured.fit, n_effective=n))
        assert plane_with_error(other).degrees_of_freedom == pytest.approx(free)
    four = bed("t1", vertices=((0, 0, 0.1), (1, 0, -0.1), (1, 1, 0.1), (0, 1, -0.1)))
    found = measure_all({"m1": MODEL}, [four])[0]
    assert plane_with_error(found).roughness == pytest.approx(2.0 * found.fit.rms)
    smooth = replace(measured, fit=replace(measured.fit, rms=None))
    assert plane_with_error(smooth).roughness == 0.0


def test_plane_of_unknown_error_has_no_spread_and_a_line_is_not_a_plane():
    reading = Reading("r1", "R", "bedding", "plane", 100.0, 30.0)
    read = measure_all({}, [reading])[0]
    assert plane_with_error(read).normal == pytest.approx(Plane(100.0, 30.0).normal())
    assert plane_with_error(read).spread95 is None
    three = bed("t1", vertices=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.5)))
    assert plane_with_error(measure_all({"m1": MODEL}, [three])[0]).spread95 is None
    line = measure_all({}, [replace(reading, geometry="line")])[0]
    assert plane_with_error(line) is None
    at = MeasurementContext(RECORDS_OF_ALL, Thresholds(), {"r1": read, "l": line})
    assert at.plane("r1").normal == pytest.approx(Plane(100.0, 30.0).normal())
    assert at.plane("l") is at.plane("gone") is None
    assert (at.model("m1"), at.model("t1"), at.model("m2")) == (MODEL, None, None)


def test_patch_error_is_the_one_used_for_its_verdict():
    """Its points are neighbours: the hyperbolic error counts where it is the wider one."""
    many = replace(ONE_OF_EACH["patch"], n=100000, n_effective=100000.0)
    measured = measure_all(RECORDS_OF_ALL, [many])[0]
    fit = measured.fit
    assert fit.max_angular_error_deg > fit.max_confidence95_deg
    worst = line_from_rake(measured.plane, fit.error_rake_deg).vector()
    found = math.degrees(math.atan(deviation95(plane_with_error(measured), worst)))
    assert found == pytest.approx(fit.max_angular_error_deg)


@pytest.mark.parametrize("better", ["line", "plane"])
def test_wider_error_of_a_line_on_a_plane_is_in_the_less_certain_direction(better):
    """Along the plane a line strays with its own points, across it with the plane."""
    rough_line, rough_plane = (0.001, 0.2) if better == "line" else (0.2, 0.001)
    rng = np.random.default_rng(8)
    plane = Plane(120.0, 50.0)
    u, v = plane.strike_vector(), plane.dip_vector()
    points = rng.uniform(-3.0, 3.0, (30, 2)) @ np.array([u, v])
    points = points + rough_plane * rng.standard_normal((30, 1)) * plane.normal()
    base = bed("t1", vertices=tuple(map(tuple, points.tolist())))
    way = (u + v) / math.sqrt(2.0)
    clicks = np.linspace(0, 4, 9)[:, None] * way + rough_line * rng.standard_normal((9, 3))
    line = Lineation(
        "l1", "L", "lineation", "m1", HASH, tuple(map(tuple, clicks.tolist())), plane_id="t1"
    )
    records = {"m1": MODEL, "t1": base, "l1": line}
    found = measure_all(records, [line])[0]
    fitted = plane_with_error(measure_all(records, [base])[0])
    across = math.degrees(math.atan(deviation95(fitted, found.line.vector())))
    within = found.line_fit.confidence95_deg
    assert found.max_confidence95_deg == pytest.approx(max(across, within))
    assert found.min_confidence95_deg == pytest.approx(min(across, within))
    out = abs(found.confidence_axis @ fitted.normal)
    assert out == pytest.approx(1.0 if better == "line" else 0.0, abs=1e-9)
    assert found.confidence_axis @ found.line.vector() == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(found.confidence_axis) == pytest.approx(1.0)
    assert get_kind(line).name == found.kind


def test_two_click_line_on_a_plane_has_no_error():
    records = {"m1": MODEL, "t1": bed("t1")}
    line = replace(ONE_OF_EACH["lineation"], vertices=ZIGZAG[:2])
    found = measure_all(records, [line])[0]
    assert found.max_confidence95_deg is found.min_confidence95_deg is None
    assert found.confidence_axis is None
    assert found.rake_deg is not None
    free = measure_all(records, [replace(line, plane_id="", vertices=ZIGZAG)])[0]
    assert free.max_confidence95_deg == free.min_confidence95_deg is not None
    assert free.confidence_axis is None


def test_missing_plane_is_reported_only_for_a_line_with_a_plane_id():
    line = ONE_OF_EACH["lineation"]
    without = {"m1": MODEL}
    for records, plane_id, gone in (
        (RECORDS_OF_ALL, "t1", False),
        (without, "t1", True),
        (RECORDS_OF_ALL, "", False),
        (RECORDS_OF_ALL, "m1", True),
    ):
        found = measure_all(records, [replace(line, plane_id=plane_id)])[0]
        reasons = by_code(found.verdict.reasons)
        assert ("line.plane-missing" in reasons) == gone
        # On a plane of known error, or on none, nothing is missing for its own.
        assert "line.plane-error-unknown" not in reasons
