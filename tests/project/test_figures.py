"""Figures in words, and what every column says of features whose answers are known."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from tests.project.test_kinds import HASH, MODEL, ONE_OF_EACH, RECORDS_OF_ALL
from tests.samples import ZIGZAG, bed, placed
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import format_error_deg
from vomstudio.geology.orientation import Line, Plane, line_from_rake
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.lines import fit_line
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.rotation_errors import CHI2_TWO
from vomstudio.project import catalogue as of
from vomstudio.project import slip_figures as slip
from vomstudio.project.catalogue import GRID_NORTH_TEXT
from vomstudio.project.figures import Figure, Form, Subject, Unit, number
from vomstudio.project.kinds import FIGURES, KINDS
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.measurement import NearestPick
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import DEFAULT_TYPES, Feature, Group, ModelFeature, Record

EVERY = tuple(
    {
        id(figure): figure
        for kind in KINDS
        for figure in (*kind.figures, *(kind.layer.figures if kind.layer else ()))
    }.values()
) + tuple(f for f in of.ORIENTATION if f.name not in FIGURES)


# --- in words --------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (0.0, "0.00°"),
        (0.052, "0.05°"),
        (0.4, "0.40°"),
        (0.6, "0.60°"),
        (0.994, "0.99°"),
        (0.995, "1.0°"),
        (1.0, "1.0°"),
        (1.5, "1.5°"),
        (5.04, "5.0°"),
        (7.0, "7.0°"),
        (9.94, "9.9°"),
        (9.95, "10°"),
        (10.4, "10°"),
        (15.2, "15°"),
        (19.0, "19°"),
        (120.4, "120°"),
    ],
)
def test_error_is_written_with_two_significant_digits(value, text):
    assert format_error_deg(value) == text


@pytest.mark.parametrize("digits", [2, 3])
def test_number_has_exactly_its_significant_digits(digits):
    for value in (
        0.000123456,
        0.0999,
        0.1,
        0.5,
        1.0,
        1.25,
        9.876,
        9.996,
        12.34,
        77.7,
        123.456,
        -4.321,
    ):
        text = number(value, digits)
        assert float(text) == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits))
        shown = text.lstrip("-0.").replace(".", "")
        assert len(shown) == max(digits, len(str(int(abs(float(text))))))
    assert number(1.0) == "1.00"
    assert number(-12.34) == "-12.3"


def test_large_numbers_are_whole_and_very_large_ones_have_an_exponent():
    assert [number(v) for v in (1234.4, 12345.4, 600000.2, 999999.0)] == [
        "1234",
        "12345",
        "600000",
        "999999",
    ]
    assert [number(v) for v in (1e6, 1.5e6, -3e7)] == ["1e+06", "1.5e+06", "-3e+07"]
    assert number(0.0) == "0"
    assert (number(None), number(math.inf)) == ("–", "∞")


def test_figure_is_formatted_by_its_form():
    def words(form: Form, value: Any, **more: Any) -> str:
        return Figure("a", "A", "", lambda s: value, form).value_text(value, **more)

    assert (words("text", None), words("text", "wet"), words("text", 3)) == ("", "wet", "3")
    assert (words("flag", True), words("flag", False), words("flag", None)) == ("yes", "", "")
    assert (words("length", 2.0), words("length", None)) == ("2.00 m", "–")
    assert words("length", 2.0, is_metric=False) == "2.00 units"
    assert (words("area", 2.0), words("area", None)) == ("2.00 m²", "–")
    assert words("area", 2.0, is_metric=False) == "2.00 units²"
    assert (words("count", 1200), words("count", None)) == ("1200", "–")
    assert (words("index", 1.23456), words("ratio", 1.23456)) == ("1.23", "1.2")
    assert (words("index", math.inf), words("ratio", None)) == ("∞", "–")
    for form in ("azimuth", "angle", "error"):
        assert (words(form, 12.3), words(form, 1.234), words(form, None)) == ("12°", "1.2°", "–")


def test_lengths_of_a_model_of_unknown_scale_are_in_units():
    for frame, unit in ((Frame("scaled"), "m"), (Frame("undeclared"), "units")):
        subject = seen(bed("t1"), frame=frame)
        assert of.EXTENT.text(subject).split()[1] == unit


# --- columns ---------------------------------------------------------------------------------
@pytest.mark.parametrize("figure", EVERY, ids=lambda figure: figure.name)
def test_every_figure_has_a_name_title_explanation_and_filter_words(figure):
    """The name heads columns of files, the title those of the window, where room is short."""
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", figure.name)
    assert 0 < len(figure.title) <= 14
    assert "_" not in figure.title
    assert len(figure.explanation) >= len(figure.title)
    assert figure.form in get_args(Form)
    assert figure.unit in get_args(Unit)
    assert re.fullmatch(r"[A-Za-z0-9_]{0,10}", figure.short)
    assert all(re.fullmatch(r"[a-z0-9_/]+", word.casefold()) for word in figure.words)
    assert callable(figure.value)
    assert figure.format_text is None or callable(figure.format_text)


@pytest.mark.parametrize("figure", EVERY, ids=lambda figure: figure.name)
def test_column_name_states_the_unit(figure):
    """A reader of a CSV file has nothing but the header."""
    places = {"x": "m", "y": "m", "z": "m"}
    found = re.search(r"_(deg|m2|m)$", figure.name)
    assert figure.unit == places.get(figure.name, found.group(1) if found else "")
    assert (figure.unit == "m2") == (figure.form == "area")
    assert (figure.unit == "deg") == (figure.form in ("azimuth", "angle", "error"))
    if figure.form == "length":
        assert figure.unit == "m"
    assert (figure.form == "azimuth") == (
        figure.name
        in (
            "dip_direction_deg",
            "strike_rhr_deg",
            "pole_trend_deg",
            "trend_deg",
            "on_plane_dip_direction_deg",
        )
    )


def test_editable_figure_belongs_to_an_attribute_of_its_kind():
    for kind in KINDS:
        own = {attribute.field for attribute in kind.attributes}
        for figure in kind.figures:
            assert not figure.attribute or figure.attribute in own


# --- values ----------------------------------------------------------------------------------
def seen(feature: Feature | None, *others: Record, frame: Frame | None = None, **more) -> Subject:
    model = MODEL if frame is None else replace(MODEL, placement=frame)
    records = {r.id: r for r in (*DEFAULT_TYPES, model, *others, feature)}
    return Subject(feature, measure_all(records, [feature])[0], records, **more)


def values(subject: Subject) -> dict[str, Any]:
    return {figure.name: figure.value(subject) for figure in of.ORIENTATION}


def test_every_column_of_a_trace_matches_its_plane():
    rng = np.random.default_rng(4)
    points = np.array(ZIGZAG * 3) * [1.0, 1.5, 1.0] + 0.05 * rng.standard_normal((15, 3))
    trace = replace(
        bed("t1", vertices=tuple(map(tuple, points.tolist()))),
        name="B01",
        set_name="S1",
        notes="wet",
        overturned=True,
        resolution=0.1,
        outcrop_normal=tuple(fit_plane(points).normal.tolist()),
    )
    turn = np.diag([2.0, 2.0, 2.0, 1.0])
    turn[:3, 3] = (100.0, 200.0, 300.0)
    model = placed(replace(MODEL, placement=Frame("crs", "EPSG:32633")), turn)
    records = {r.id: r for r in (*DEFAULT_TYPES, model, trace)}
    subject = Subject(trace, measure_all(records, [trace])[0], records)
    fit = fit_plane(2.0 * points + [100.0, 200.0, 300.0])
    found = values(subject)
    expected = {
        "id": "t1",
        "name": "B01",
        "kind": "bedding",
        "element": "plane",
        "set": "S1",
        "overturned": True,
        "undefined": False,
        "notes": "wet",
        "model": "cliff",
        "dip_direction_deg": fit.dip_direction_deg,
        "dip_deg": fit.dip_deg,
        "strike_rhr_deg": (fit.dip_direction_deg - 90.0) % 360.0,
        "pole_trend_deg": (fit.dip_direction_deg + 180.0) % 360.0,
        "pole_plunge_deg": 90.0 - fit.dip_deg,
        "trend_deg": None,
        "plunge_deg": None,
        **dict.fromkeys(figure.name for figure in slip.SLIP),
        "n_points": 15,
        "extent_m": fit.extent,
        "area_m2": None,
        "rms_m": fit.rms,
        "coplanarity": fit.coplanarity,
        "collinearity": fit.collinearity,
        "M": fit.M,
        "K": fit.K,
        "max_angular_error_deg": fit.max_angular_error_deg,
        "min_angular_error_deg": fit.min_angular_error_deg,
        "max_confidence95_deg": fit.max_confidence95_deg,
        "min_confidence95_deg": fit.min_confidence95_deg,
        "error_rake_deg": fit.error_rake_deg,
        "dip_error_deg": fit.dip_error_deg,
        "dip_direction_error_deg": fit.dip_direction_error_deg,
        "registration_error_deg": None,
        "total95_deg": total_error_deg(fit, 0.2),
        "resolution_m": 0.2,
        "extent_over_resolution": fit.extent / 0.2,
        "bend_deg": None,
        "attitude_scale": "local" if fit.long_roughness else "regional",
        "method": "pca",
        "frame": "EPSG:32633, grid north",
        **dict(zip("xyz", fit.centroid, strict=True)),
        **{f"normal_{axis}": v for axis, v in zip("xyz", fit.normal, strict=True)},
        **{f"lambda{i}": v for i, v in enumerate(fit.eigenvalues, 1)},
    }
    tilt = line_from_rake(Plane(fit.dip_direction_deg, fit.dip_deg), fit.error_rake_deg).vector()
    sigmas = np.radians([expected["total95_deg"], fit.min_confidence95_deg]) / np.sqrt(CHI2_TWO)
    axes = np.array([tilt, np.cross(fit.normal, tilt)]) * sigmas[:, None]
    covariance = axes.T @ axes
    expected |= {
        f"normal_cov_{'enu'[i]}{'enu'[j]}": covariance[i, j] for i in range(3) for j in range(i, 3)
    }
    verdict = subject.measured.verdict
    expected |= {
        "quality": verdict.quality,
        "quality_reason": " ".join(each.message for each in verdict.reasons),
        "reason_codes": " ".join(each.code for each in verdict.reasons),
        "quality_notes": " ".join(each.message for each in verdict.notes),
        "profile": "error",
    }
    assert list(found) == [figure.name for figure in of.ORIENTATION]
    assert set(found) == set(expected)
    for name, value in expected.items():
        wanted = pytest.approx(value, rel=1e-6) if isinstance(value, float) else value
        assert found[name] == wanted, name
    assert len(verdict.reasons) + len(verdict.notes) > 1


def test_every_column_of_a_line_matches_its_line():
    points = np.array([[0, 0, 0], [1, 0.1, -1], [2, 0, -2.1], [3, 0, -3]], float)
    line = Lineation("l1", "L1", "lineation", "m1", HASH, tuple(map(tuple, points.tolist())))
    fit = fit_line(points)
    found = values(seen(line))
    down = Line.from_vector(fit.direction)
    assert {name: value for name, value in found.items() if value is not None} == {
        "id": "l1",
        "name": "L1",
        "kind": "lineation",
        "element": "line",
        "undefined": False,
        "trend_deg": down.trend_deg,
        "plunge_deg": down.plunge_deg,
        "n_points": 4,
        "extent_m": fit.length,
        "rms_m": fit.rms,
        "max_confidence95_deg": fit.confidence95_deg,
        "min_confidence95_deg": fit.confidence95_deg,
        "total95_deg": pytest.approx(fit.confidence95_deg),
        "method": "line",
        "model": "cliff",
        "frame": Frame("local").name(),
        "quality": found["quality"],
        "quality_reason": found["quality_reason"],
        "reason_codes": found["reason_codes"],
        "quality_notes": "",
        "profile": "error",
        "x": 1.5,
        "y": pytest.approx(0.025),
        "z": pytest.approx(-1.525),
    }


def test_line_has_an_axial_rake_and_a_directed_slip_rake():
    base = bed("t1")
    points = ((0.0, 0.0, 0.0), (1.0, 0.3, 0.5), (2.0, 0.5, 1.0))
    line = Lineation("l1", "L1", "fault", "m1", HASH, points, plane_id="t1")
    axial = seen(line, base)
    rake = axial.measured.rake_deg
    assert 0.0 < rake < 180.0
    assert (slip.RAKE.value(axial), slip.SLIP_RAKE.value(axial)) == (rake, None)
    assert (slip.SLIP_SENSE.value(axial), slip.SLIP_SENSE.text(axial)) == (None, "")
    slips = seen(replace(line, slip="dextral"), base)
    directed = -rake if rake > 90.0 else 180.0 - rake
    assert (slip.RAKE.value(slips), slip.SLIP_RAKE.value(slips)) == (rake, directed)
    assert (slip.SLIP_SENSE.value(slips), slip.SLIP_SENSE.text(slips)) == (
        "dextral",
        "dextral (right-lateral)",
    )


def test_line_row_states_the_plane_of_the_line():
    base = replace(bed("t1"), name="F01")
    line = Lineation(
        "l1", "L1", "fault", "m1", HASH, ((0.0, 0.0, 0.0), (2.0, 0.5, 1.0)), plane_id="t1"
    )
    on_it = seen(line, base)
    of_base = seen(base)
    assert slip.ON_PLANE.value(on_it) == "F01"
    assert slip.ON_PLANE_DIP_DIRECTION.value(on_it) == of.DIP_DIRECTION.value(of_base)
    assert slip.ON_PLANE_DIP.value(on_it) == of.DIP.value(of_base)
    assert slip.ON_PLANE.value(seen(line, replace(base, name=""))) == "t1"
    for alone in (seen(line), seen(replace(line, plane_id=""), base), seen(base)):
        assert [figure.value(alone) for figure in slip.SLIP] == [None] * 7


def test_a_negative_rake_is_written_with_the_digits_of_a_positive_one():
    assert (format_error_deg(-40.2), format_error_deg(-4.26), format_error_deg(-0.5)) == (
        "-40°",
        "-4.3°",
        "-0.50°",
    )


def test_every_column_of_a_reading_matches_the_compass_values():
    reading = Reading("r1", "R1", "joint", "plane", 200.0, 30.0, position=(1.0, 2.0, 3.0))
    found = values(seen(reading))
    normal = Plane(200.0, 30.0).normal()
    assert {name: value for name, value in found.items() if value is not None} == {
        "id": "r1",
        "name": "R1",
        "kind": "joint",
        "element": "plane",
        "undefined": False,
        "overturned": False,
        "dip_direction_deg": 200.0,
        "dip_deg": 30.0,
        "strike_rhr_deg": 110.0,
        "pole_trend_deg": 20.0,
        "pole_plunge_deg": 60.0,
        "x": 1.0,
        "y": 2.0,
        "z": 3.0,
        "normal_x": normal[0],
        "normal_y": normal[1],
        "normal_z": normal[2],
        "frame": GRID_NORTH_TEXT,
    }
    nowhere = values(seen(replace(reading, position=None, geometry="line")))
    assert (nowhere["element"], nowhere["trend_deg"], nowhere["plunge_deg"]) == (
        "line",
        200.0,
        30.0,
    )
    assert nowhere["x"] is nowhere["normal_z"] is nowhere["dip_deg"] is None


def test_undefined_azimuth_is_flagged():
    for geometry, steep, undefined in (
        ("plane", 0.0, True),
        ("plane", 90.0, False),
        ("line", 90.0, True),
        ("line", 0.0, False),
    ):
        subject = seen(Reading("r1", "R1", "joint", geometry, 10.0, steep))
        assert of.UNDEFINED.value(subject) is undefined
    flat = bed("t1", vertices=((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 2.0, 1.0)))
    assert of.UNDEFINED.value(seen(flat)) is True


def test_missing_values_are_shown_as_text():
    gone = ONE_OF_EACH["trace"]
    records = {"t1": gone}
    alone = Subject(gone, measure_all(records, [gone])[0], records)
    assert of.FRAME.value(alone) == of.MISSING_MODEL_TEXT
    assert of.MODEL.value(alone) is None
    # A type that is gone is told by its id in files; the window leaves it out.
    assert (of.KIND.value(alone), of.KIND.text(alone)) == ("bedding", "")
    kept = seen(gone)
    assert (of.KIND.value(kept), of.KIND.text(kept)) == ("bedding", "Bedding")
    custom = replace(DEFAULT_TYPES[0], id="type-1", name="Dyke Margin")
    named = seen(replace(gone, type_id="type-1"), custom)
    assert (of.KIND.value(named), of.KIND.text(named)) == ("dyke margin", "Dyke Margin")
    assert (of.SET.value(kept), of.NOTES.value(kept)) == (None, None)
    assert of.QUALITY.text(kept) == kept.measured.verdict.quality
    flat = Lineation("l1", "L1", "lineation", "m1", HASH, ((0.0, 0.0, 0.0),) * 3)
    broken = seen(flat)
    assert (of.QUALITY.value(broken), of.QUALITY.text(broken)) == (None, "no plane")
    assert broken.measured.problem == Finding("points.coincident")
    assert of.REASONS.value(broken) == broken.measured.problem.message
    assert of.UNDEFINED.value(broken) is of.ELEMENT.value(broken) is None
    read = seen(ONE_OF_EACH["reading"])
    assert (of.QUALITY.text(read), of.REASONS.value(read)) == ("–", None)


def test_extent_is_divided_by_a_known_resolution_only():
    trace = bed("t1")
    assert of.EXTENT_OVER_RESOLUTION.value(seen(trace)) is None
    assert of.EXTENT_OVER_RESOLUTION.value(seen(replace(trace, resolution=0.0))) is None
    fine = seen(replace(trace, resolution=0.01))
    assert of.EXTENT_OVER_RESOLUTION.value(fine) == pytest.approx(
        fine.measured.fit.extent / 0.01, rel=1e-9
    )
    endless = replace(fine.measured, fit=replace(fine.measured.fit, extent=math.inf))
    assert of.EXTENT_OVER_RESOLUTION.value(replace(fine, measured=endless)) is None


def test_angle_to_the_nearest_pick_is_computed_on_demand():
    reading = ONE_OF_EACH["reading"]
    pick = NearestPick("t1", "B01", 12.5, None)
    assert of.ANGLE_TO_PICK.value(seen(reading, nearest=lambda: pick)) == 12.5
    assert of.ANGLE_TO_PICK.value(seen(reading)) is None
    meets = Intersection("i1", "I", "lineation", Group("a"), Group("b"))
    level = Reading("a", "A", "joint", "plane", 90.0, 0.0)
    steep = replace(level, id="b", inclination_deg=35.0)
    assert of.ANGLE.value(seen(meets, level, steep)) == pytest.approx(35.0)


def test_a_patch_counts_its_points_and_has_an_area_in_square_metres():
    patch = replace(ONE_OF_EACH["patch"], area=6.0)
    assert isinstance(patch, Patch)
    subject = seen(patch, frame=Frame("local", unit_m=0.5))
    assert of.AREA.value(subject) == pytest.approx(1.5)
    assert of.N_POINTS.value(subject) == 9
    assert of.AREA.value(seen(replace(patch, area=None))) is None


def test_layers_count_the_clicked_points():
    """Even where no plane or line can be fitted."""
    for name, count in (("trace", 5), ("lineation", 3), ("patch", 9)):
        (kind,) = [kind for kind in KINDS if kind.name == name]
        (own,) = [f for f in kind.layer.figures if f.name == "n_points"]
        subject = Subject(
            ONE_OF_EACH[name], measure_all(RECORDS_OF_ALL, [ONE_OF_EACH[name]])[0], RECORDS_OF_ALL
        )
        assert own.value(subject) == count
    broken = seen(Lineation("l1", "L1", "lineation", "m1", HASH, ((0.0, 0.0, 0.0),) * 3))
    (kind,) = [kind for kind in KINDS if kind.name == "lineation"]
    (own,) = [f for f in kind.layer.figures if f.name == "n_points"]
    assert own.value(broken) == 3


def test_subject_has_its_type_and_model_if_they_exist():
    subject = seen(bed("t1"))
    assert (subject.type, subject.model) == (DEFAULT_TYPES[0], MODEL)
    length = seen(ONE_OF_EACH["dimension"], bed("t1"))
    assert (length.type, length.model) == (None, MODEL)
    read = seen(ONE_OF_EACH["reading"])
    assert not isinstance(read.feature, ModelFeature)
    assert (read.type, read.model) == (DEFAULT_TYPES[0], None)
    nothing = Subject(None, subject.measured)
    assert (nothing.type, nothing.model, nothing.nearest()) == (None, None, None)
