"""Models that are placed by planes and lines of the project that were read by compass."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.messages import refused, with_code
from vomstudio.core.errors import DocumentError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import NorthReference
from vomstudio.io.control.observation_tables import Pairs, read_compass
from vomstudio.io.control.writing import write_compass
from vomstudio.project import compass_edits, edits
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import DEFAULT_TYPES, Compass, Model, compass_id
from vomstudio.registration.register_options import RegisterOptions
from vomstudio.studio.placing.known_lines import line_residuals
from vomstudio.studio.placing.known_planes import (
    compass_table,
    create_reading,
    field_text,
    measure_directions,
    parse_reading,
    parse_sigma,
    reading_problem,
)
from vomstudio.studio.placing.read_north import north_inputs, resolve_north, to_register_options
from vomstudio.studio.placing.register_order import register_model
from vomstudio.studio.placing.registering import create_registration, place_by_points

BARE = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64)
NO_PAIRS = Pairs((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, bool))
TURN = Rotation.from_euler("xyz", [8.0, -5.0, 30.0], degrees=True).as_matrix()
"""From World to the file."""
SCALE = 0.25
EXTENT = np.random.default_rng(3).uniform(-20.0, 20.0, (50, 3))
PLANES = {"B01": (213.0, 45.0), "B02": (132.0, 71.0), "J01": (20.0, 83.0), "F01": (301.0, 30.0)}


def in_file(world: np.ndarray) -> tuple:
    return tuple(map(tuple, (world @ TURN.T / SCALE).tolist()))


def trace(name: str, azimuth: float, dip: float, noise: float = 0.0) -> Trace:
    """Nine points on a plane, in the file."""
    plane = Plane(azimuth, dip)
    normal = plane.normal()
    strike = np.cross(normal, [0.0, 0.0, 1.0])
    strike /= np.linalg.norm(strike)
    down = np.cross(normal, strike)
    rng = np.random.default_rng(len(name) + int(azimuth))
    places = [a * strike + b * down for a in (-2.0, 0.0, 2.0) for b in (-2.0, 0.1 * a, 2.0)]
    places = np.array(places) + noise * rng.normal(size=(9, 1)) * normal
    return Trace(f"t-{name}", name, "bedding", "m1", BARE.content_hash, in_file(places))


def project(noise: float = 0.0, planes=PLANES) -> dict:
    return {
        "m1": BARE,
        **{kind.id: kind for kind in DEFAULT_TYPES},
        **{f"t-{n}": trace(n, a, d, noise) for n, (a, d) in planes.items()},
    }


def measured_in(records: dict) -> dict:
    features = [r for id_, r in records.items() if id_.startswith(("t-", "l-"))]
    return dict(zip([f.id for f in features], measure_all(records, features), strict=True))


def readings(records: dict, said: dict, sigma: float | None = 3.0) -> list[KnownLine]:
    found = measured_in(records)
    made: list[KnownLine] = []
    for name, text in said.items():
        feature = next(r for r in records.values() if getattr(r, "name", "") == name)
        kind = "lineation" if isinstance(feature, Lineation) else "plane"
        typed = replace(parse_reading(text, kind, "dipdir/dip"), sigma_deg=sigma)
        made.append(create_reading(feature, found[feature.id], typed, [r.name for r in made]))
    return made


RIGHT = {name: f"{a:g}/{d:g}" for name, (a, d) in PLANES.items()}


def placed(records, lines, turned=0.0, doubt=0.0, pairs=NO_PAIRS, model=BARE):
    seen = measure_directions(lines, measured_in(records), model)
    table = compass_table(lines, seen)
    found = place_by_points(pairs, None, model, None, EXTENT, lines, doubt, table, turned)
    return found, seen


def test_compass_readings_of_planes_restore_the_model_orientation() -> None:
    records = project()
    lines = readings(records, RIGHT)
    found, seen = placed(records, lines)
    turn = found.matrix[:3, :3] / found.scale
    assert turn @ TURN == pytest.approx(np.eye(3), abs=1e-6)
    assert found.known == found.known.__class__(True, True, False, False)
    deviation = {miss.id: miss.deviation for miss in line_residuals(lines, found, seen)}
    assert [deviation[line.id] for line in lines] == pytest.approx([0.0] * 4, abs=1e-4)
    record = create_registration(found, NO_PAIRS, BARE, None, read_north=NorthReference("grid"))
    assert record.method == "lines"
    assert record.frame == Frame("oriented")


def test_readings_offset_by_30_degrees_rotate_the_model_by_30_degrees() -> None:
    records = project()
    farther = {n: f"{(a + 30.0) % 360.0:g}/{d:g}" for n, (a, d) in PLANES.items()}
    found, _ = placed(records, readings(records, farther))
    turn = found.matrix[:3, :3] / found.scale @ TURN
    expected = Rotation.from_euler("z", -30.0, degrees=True).as_matrix()
    assert turn == pytest.approx(expected, abs=1e-6)
    # So does what is added to them.
    again, _ = placed(records, readings(records, RIGHT), turned=30.0)
    assert again.matrix == pytest.approx(found.matrix, abs=1e-9)


def test_command_with_the_written_table_gives_the_same_placement(tmp_path: Path) -> None:
    records = project(noise=0.02)
    axis = Line(77.0, 20.0).vector()
    records["l-1"] = Lineation(
        "l-1",
        "L01",
        "lineation",
        "m1",
        BARE.content_hash,
        in_file(np.array([-2.0, 0.0, 1.0, 2.0])[:, None] * axis),
    )
    lines = readings(records, {**RIGHT, "B02": "135/68", "L01": "079/21"})
    lines[0] = replace(lines[0], sigma=None)
    found, seen = placed(records, lines, doubt=0.5)
    file = tmp_path / "readings.csv"
    write_compass(file, compass_table(lines, seen))
    told = register_model(
        "-", RegisterOptions(orientations=str(file), north_sigma_deg=0.5), None
    ).placed
    ours = found.matrix[:3, :3] / found.scale
    assert ours == pytest.approx(told.matrix[:3, :3] / told.scale, abs=1e-9)
    shape = np.array(found.covariance)[:3, :3]
    assert shape == pytest.approx(np.array(told.covariance)[:3, :3], rel=1e-6)
    read = read_compass(file)
    assert read.labels == tuple(line.name for line in lines)
    assert read.is_plane.tolist() == [True] * 4 + [False]
    assert np.isnan(read.sigma[0])


def test_plane_error_is_added_to_the_reading_error() -> None:
    """The error of a reading is 3 degrees; that of the trace is added as squares are."""
    records = project(noise=0.3)
    lines = readings(records, RIGHT)
    seen = measure_directions(lines, measured_in(records), BARE)
    table = compass_table(lines, seen)
    for line, sigma in zip(lines, table.sigma, strict=True):
        own = seen[line.id].sigma_deg
        assert own > 1.0
        assert sigma == pytest.approx(np.hypot(3.0, own))


def test_measured_directions_do_not_depend_on_the_placement() -> None:
    records = project(noise=0.1)
    lines = readings(records, RIGHT)
    before = measure_directions(lines, measured_in(records), BARE)
    found, _ = placed(records, lines)
    after_model = replace(
        BARE,
        placement=create_registration(
            found, NO_PAIRS, BARE, None, read_north=NorthReference("grid")
        ),
    )
    after = measure_directions(lines, measured_in({**records, "m1": after_model}), after_model)
    for id_, each in before.items():
        assert abs(each.direction @ after[id_].direction) == pytest.approx(1.0, abs=1e-9)
    # To place it again changes nothing.
    again, _ = placed({**records, "m1": after_model}, lines, model=after_model)
    assert again.matrix[:3, :3] == pytest.approx(found.matrix[:3, :3], abs=1e-6)


def test_points_and_planes_are_fitted_together_and_a_strike_is_reported() -> None:
    records = project()
    world = np.array([[0, 0, 0], [9, 1, 0], [1, 8, 2], [4, 4, 6], [7, 7, 1]], float)
    pairs = Pairs(
        tuple(f"P{i}" for i in range(5)),
        np.array(in_file(world)),
        world,
        np.full((5, 3), 0.01),
        np.zeros(5, bool),
    )
    strike = {**RIGHT, "B02": "042/71"}
    lines = readings(records, strike)
    found, seen = placed(records, lines, pairs=pairs)
    assert found.known.all
    assert [blunder.label for blunder in found.blunders] == ["B02"]
    (finding,) = with_code(found.warnings, "compass.other-azimuth")
    assert finding.values["labels"] == ("B02",)
    assert finding.values["turn_deg"] == 90.0
    turn = found.matrix[:3, :3] / found.scale @ TURN
    assert turn == pytest.approx(np.eye(3), abs=0.01)
    deviation = {miss.id: miss.deviation for miss in line_residuals(lines, found, seen)}
    assert deviation[lines[1].id] > 60.0
    # What is not ticked judges, and places nothing.
    lines[1] = replace(lines[1], check=True)
    found, seen = placed(records, lines, pairs=pairs)
    assert not found.blunders
    assert len(line_residuals(lines, found, seen)) == 4


@pytest.mark.full
def test_strike_among_planes_is_reported_with_the_placement_without_it() -> None:
    records = project(planes={**PLANES, "B03": (250.0, 55.0), "B04": (80.0, 40.0)})
    said = {**RIGHT, "B03": "160/55", "B04": "080/40"}
    found, _ = placed(records, readings(records, said))
    assert found.without[0].label == "B03"
    assert found.without[0].suspect
    assert found.without[0].azimuth_off_deg == 90.0


def test_compass_uncertainty_is_not_reduced_by_more_readings() -> None:
    records = project()
    lines = readings(records, RIGHT, sigma=0.2)
    found, _ = placed(records, lines, doubt=4.0)
    assert found.rotation_error_deg.about_up == pytest.approx(4.0, rel=0.01)
    assert found.rotation_error_deg.about_east < 0.5


# --- north ----------------------------------------------------------------------------------------
def compass(**more) -> Compass:
    return Compass(compass_id("m1"), "m1", **more)


def test_magnetic_north_is_corrected_for_dated_declination_and_convergence() -> None:
    """IGRF-14 by IAGA's own code is held against its published values elsewhere; the convergence by
    PROJ."""
    from datetime import date

    from pyproj import Proj

    from vomstudio.registration.north import declination_deg

    said = compass(north="magnetic", day="2024-05-12", place=(11.35, 46.5))
    in_crs = replace(BARE, placement=Frame("crs", crs="EPSG:32632"))
    used, words = resolve_north(said, north_inputs(said, in_crs, None, NO_PAIRS, None))
    expected = declination_deg(11.35, 46.5, date(2024, 5, 12))
    convergence = Proj("EPSG:32632").get_factors(11.35, 46.5).meridian_convergence
    assert used.declination_deg == pytest.approx(expected)
    assert used.turned_deg == pytest.approx(expected - convergence, abs=1e-6)
    assert used.doubt_deg == 2.0
    assert not used.stated
    assert used.day == "2024-05-12"
    for part in (f"{expected:+.2f}°", "IGRF-14", "2024-05-12", f"{convergence:+.2f}°"):
        assert part in words
    # A local frame has true north up.
    used, _ = resolve_north(said, north_inputs(said, BARE, None, NO_PAIRS, None))
    assert used.turned_deg == pytest.approx(expected)


def test_stated_declination_takes_precedence_and_missing_inputs_raise() -> None:
    said = compass(north="magnetic", declination_deg=-7.5, doubt_deg=1.0)
    used, words = resolve_north(said, north_inputs(said, BARE, None, NO_PAIRS, None))
    assert (used.turned_deg, used.stated, used.doubt_deg) == (-7.5, True, 1.0)
    assert "-7.50°" in words
    for lacking in (
        compass(north="magnetic", day="2024-05-12"),
        compass(north="magnetic", place=(11.0, 46.0)),
    ):
        with refused("north.no-declination", VomError):
            resolve_north(lacking, north_inputs(lacking, BARE, None, NO_PAIRS, None))
    old = compass(north="magnetic", day="1850-01-01", place=(11.0, 46.0))
    with pytest.raises(VomError, match="1850"):
        resolve_north(old, north_inputs(old, BARE, None, NO_PAIRS, None))
    with refused("date.invalid", VomError):
        north_inputs(compass(day="2024-13-40"), BARE, None, NO_PAIRS, None)


def test_register_options_reproduce_the_north_correction_or_are_omitted() -> None:
    stated = compass(north="magnetic", declination_deg=3.25)
    used, _ = resolve_north(stated, north_inputs(stated, BARE, None, NO_PAIRS, None))
    options = to_register_options(stated, used, NO_PAIRS, None)
    assert options == RegisterOptions(north="magnetic", declination_deg=3.25, north_sigma_deg=2.0)
    placed_by = compass(north="magnetic", day="2024-05-12", place=(11.35, 46.5))
    used, _ = resolve_north(placed_by, north_inputs(placed_by, BARE, None, NO_PAIRS, None))
    assert to_register_options(placed_by, used, NO_PAIRS, None) is None
    grid = compass(doubt_deg=2.0)
    used, _ = resolve_north(grid, north_inputs(grid, BARE, None, NO_PAIRS, None))
    assert to_register_options(grid, used, NO_PAIRS, None) == RegisterOptions(north_sigma_deg=2.0)
    assert to_register_options(None, NorthReference("grid"), NO_PAIRS, None) == RegisterOptions()


def test_compass_is_removed_with_its_model() -> None:
    records = {"m1": BARE}
    edit = compass_edits.set_compass(records, compass(north="true"))
    edit.swap(records)
    assert compass_edits.get_compass(records, "m1").north == "true"
    gone = edits.remove_model(records, "m1")
    gone.swap(records)
    assert not records
    with pytest.raises(DocumentError):
        compass_edits.set_compass(records, compass())


# --- what is typed --------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "notation", "expected"),
    [
        ("213/45 ± 3", "dipdir/dip", (213.0, 45.0, 3.0)),
        ("213/45 +- 3", "dipdir/dip", (213.0, 45.0, 3.0)),
        ("213/45 +/- 2.5°", "dipdir/dip", (213.0, 45.0, 2.5)),
        ("213/45", "dipdir/dip", (213.0, 45.0, None)),
        ("123/45", "strike/dip", (213.0, 45.0, None)),
        ("123/45 RHR ±3", "dipdir/dip", (213.0, 45.0, 3.0)),
        ("303/45 LHR", "dipdir/dip", (213.0, 45.0, None)),
        ("N57W 45SW", "quadrant", (213.0, 45.0, None)),
        ("horizontal", "dipdir/dip", (0.0, 0.0, None)),
    ],
)
def test_readings_are_parsed_in_every_notation(text, notation, expected) -> None:
    said = parse_reading(text, "plane", notation)
    assert (said.azimuth_deg, said.inclination_deg, said.sigma_deg) == expected


@pytest.mark.parametrize(
    "text",
    ["", "213", "400/45", "213/95", "213/45 ± 0", "213/45 ± 120", "213/45 ± east", "45 / north"],
)
def test_invalid_plane_reading_is_rejected_with_a_message(text) -> None:
    with pytest.raises(VomError) as refused:
        parse_reading(text, "plane", "dipdir/dip")
    assert len(refused.value.message.split()) > 4


def test_upward_lines_and_invalid_errors_are_rejected() -> None:
    assert parse_reading("130/25 ± 2", "lineation", "dipdir/dip").sigma_deg == 2.0
    with refused("reading.points-up", VomError):
        parse_reading("130/-25", "lineation", "dipdir/dip")
    with refused("reading.invalid-error", VomError):
        parse_sigma("nan")


def test_reading_requires_a_feature_on_the_same_model() -> None:
    records = project()
    found = measured_in(records)
    assert reading_problem(records["t-B01"], BARE, found["t-B01"]) is None
    other = replace(BARE, id="m2", name="quarry")
    elsewhere = Finding("feature.on-other-model", feature="B01", model="quarry")
    assert reading_problem(records["t-B01"], other, found["t-B01"]) == elsewhere
    reading = Reading("r1", "R01", "bedding", "plane", 10.0, 20.0)
    unplaced = Finding("feature.not-on-model", feature="R01")
    assert reading_problem(reading, BARE, None) == unplaced
    nothing = Finding("selection.no-feature-read")
    assert reading_problem(None, BARE, None) == nothing
    assert reading_problem(BARE, BARE, None) == nothing
    lines = readings(records, RIGHT)
    assert reading_problem(lines[0], BARE, None) == nothing


def test_repeated_readings_of_a_plane_get_unique_names() -> None:
    records = project()
    found = measured_in(records)
    typed = parse_reading("213/45", "plane", "dipdir/dip")
    names = [
        create_reading(records["t-B01"], found["t-B01"], typed, taken).name
        for taken in ((), ("B01",), ("B01", "B01 (2)"))
    ]
    assert names == ["B01", "B01 (2)", "B01 (3)"]


def test_deleted_features_and_empty_readings_are_ignored() -> None:
    records = project()
    lines = readings(records, RIGHT)
    del records["t-B01"]
    lines[1] = replace(lines[1], value=None)
    seen = measure_directions(lines, measured_in(records), BARE)
    table = compass_table(lines, seen)
    assert table.labels == ("J01", "F01")


def test_lines_of_known_azimuth_get_the_same_north_correction() -> None:
    """A level model whose only azimuth was read 7.5 degrees east of north."""
    east = in_file(np.array([[1.0, 2.0, 3.0], [11.0, 2.0, 3.0]]))
    north = in_file(np.array([[1.0, 2.0, 3.0], [1.0, 12.0, 3.0]]))
    level = [
        KnownLine(f"k{i}", f"K{i}", "level", "m1", BARE.content_hash, ends)
        for i, ends in enumerate((east, north))
    ]
    azimuth = KnownLine("a", "A", "azimuth", "m1", BARE.content_hash, north, 352.5)
    lines = [*level, azimuth]
    found = place_by_points(NO_PAIRS, None, BARE, None, EXTENT, lines, 0.5, turned_deg=7.5)
    turn = found.matrix[:3, :3] / found.scale @ TURN
    assert turn == pytest.approx(np.eye(3), abs=1e-6)
    deviation = {miss.id: miss.deviation for miss in line_residuals(lines, found, turned_deg=7.5)}
    assert deviation["a"] == pytest.approx(0.0, abs=1e-4)
    assert found.rotation_error_deg.about_up > 0.5


def test_readings_and_their_north_are_saved_with_the_project(tmp_path: Path) -> None:
    from vomstudio.project.folder import ProjectFolder

    records = project()
    lines = readings(records, RIGHT)
    found, _ = placed(records, lines)
    north = NorthReference("magnetic", 3.2, 3.4, False, "2024-05-12", 0.5)
    record = create_registration(found, NO_PAIRS, BARE, None, read_north=north)
    said = compass(north="magnetic", day="2024-05-12", place=(11.35, 46.5), doubt_deg=0.5)
    one = ProjectFolder.create(tmp_path / "readings.vom")
    session = one.session
    session.apply(edits.add_model(session.records, BARE))
    traces = [r for r in records.values() if isinstance(r, Trace)]
    session.apply(edits.add_features(session.records, [*traces, *lines]))
    session.apply(compass_edits.set_compass(session.records, said))
    session.apply(edits.set_registration(session.records, record, ["m1"]))
    session.save()
    one.close()
    again = ProjectFolder.open(tmp_path / "readings.vom")
    kept = again.session.records
    assert compass_edits.get_compass(kept, "m1") == said
    assert [kept[line.id] for line in lines] == lines
    assert kept["m1"].registration.read_north == north
    again.close()


def test_registration_summary_states_the_north_of_its_readings() -> None:
    from vomstudio.registration.summary import summarize_registration

    records = project()
    found, _ = placed(records, readings(records, RIGHT))
    north = NorthReference("magnetic", 3.2, 3.4, False, "2024-05-12", 0.5)
    record = create_registration(found, NO_PAIRS, BARE, None, read_north=north)
    facts = {fact.code: fact for fact in summarize_registration(record).facts}
    assert facts["azimuths-read-from"].values == {"north": "magnetic", "turned_deg": 3.2}
    declination = {"angle_deg": 3.4, "stated": False, "day": "2024-05-12"}
    assert facts["declination"].values == declination
    assert facts["declination"].text.startswith("+3.40°")
    assert facts["north-error"].values == {"sigma_deg": 0.5}


def test_single_or_parallel_planes_leave_rotation_about_the_normal_free() -> None:
    """About its own normal a plane says nothing; what is left free stays as it stands."""
    records = project(planes={"B01": (213.0, 45.0), "B02": (213.0, 45.0)})
    for said in ({"B01": "213/45"}, {"B01": "213/45", "B02": "213/45"}):
        lines = readings(records, said)
        found, seen = placed(records, lines)
        assert not (found.known.north and found.known.vertical)
        deviation = [miss.deviation for miss in line_residuals(lines, found, seen)]
        assert deviation == pytest.approx([0.0] * len(lines), abs=1e-3)


def test_points_and_magnetic_readings_match_the_register_command(tmp_path: Path) -> None:
    """Day and place by the points: the command finds the same declination and convergence."""
    from vomstudio.io.control.writing import write_pairs
    from vomstudio.studio.placing.registering import place_by_points as by_points

    records = project(noise=0.02)
    corners = np.array([[0, 0, 0], [9, 1, 0], [1, 8, 2], [4, 4, 6], [7, 7, 1]], float)
    world = corners + [500_000.0 + 60_000.0, 5_150_000.0, 800.0]
    pairs = Pairs(
        tuple(f"P{i}" for i in range(5)),
        np.array(in_file(corners)),
        world,
        np.full((5, 3), 0.02),
        np.zeros(5, bool),
    )
    said = compass(north="magnetic", day="2024-05-12", doubt_deg=0.7)
    used, _ = resolve_north(said, north_inputs(said, BARE, None, pairs, "EPSG:32632"))
    read = {n: f"{(a - used.turned_deg) % 360.0:.2f}/{d:g}" for n, (a, d) in PLANES.items()}
    lines = readings(records, read)
    seen = measure_directions(lines, measured_in(records), BARE)
    table = compass_table(lines, seen)
    found = by_points(
        pairs, None, BARE, "EPSG:32632", EXTENT, lines, used.doubt_deg, table, used.turned_deg
    )
    write_pairs(tmp_path / "pairs.csv", pairs)
    write_compass(tmp_path / "readings.csv", table)
    options = to_register_options(said, used, pairs, "EPSG:32632")
    assert options is not None
    assert given_options(options).keys() == {"north", "date", "north_sigma_deg"}
    options = replace(
        options,
        pairs=str(tmp_path / "pairs.csv"),
        orientations=str(tmp_path / "readings.csv"),
        crs="EPSG:32632",
    )
    told = register_model("-", options, None).placed
    assert found.matrix == pytest.approx(told.matrix, abs=1e-9)
    assert not told.blunders
    assert max(miss.deviation for miss in line_residuals(lines, found, seen, used.turned_deg)) < 1.5


def test_readings_without_an_id_are_labelled_by_name(tmp_path: Path) -> None:
    file = tmp_path / "read.csv"
    file.write_text(
        "name,dip_direction,dip,model_x,model_y,model_z\nB01,213,45,0,0,1\n,10,20,1,0,0\n"
    )
    assert read_compass(file).labels == ("B01", "2")


def test_reading_is_drawn_at_its_plane_with_the_read_angles() -> None:
    """Dip and dip direction with an arrow between them are taken for nothing else in any
    notation."""
    records = project()
    line = readings(records, {"B01": "213/45"})[0]
    measured = measure_all({**records, line.id: line}, [line])[0]
    middle = measure_all(records, [records["t-B01"]])[0].fit.centroid
    assert measured.points == pytest.approx(middle[None])
    assert measured.text == "compass reading 45 → 213"
    for notation in ("dipdir/dip", "strike/dip"):
        again = parse_reading("45 → 213", "plane", notation)
        assert (again.azimuth_deg, again.inclination_deg) == (213.0, 45.0)


def test_field_text_undoes_the_north_correction() -> None:
    field = Reading("r1", "R01", "bedding", "plane", 2.5, 45.0, turned_deg=4.0)
    measured = measure_all(project(), [field])[0]
    assert field_text(measured, "plane", 4.0, "dipdir/dip") == "358.5/45.0"
    assert field_text(measured, "plane", 4.0, "strike/dip") == "268.5/45.0"
    assert field_text(measured, "lineation", 4.0, "dipdir/dip") == ""


@pytest.mark.slow
def test_stated_error_covers_the_true_rotation_for_rough_traces() -> None:
    """Readings good to 3 degrees of five traces that are themselves known to some 4: of 100 drawn
    placements 90 to 99 hold the truth, each axis by itself."""
    rng = np.random.default_rng(5)
    inside = np.zeros(3)
    for _ in range(100):
        planes = {f"B{i}": (rng.uniform(0, 360), rng.uniform(25, 85)) for i in range(5)}
        records, said = project(planes=planes), {}
        for name, (azimuth, dip) in planes.items():
            normal = Plane(azimuth, dip).normal()
            bare = records[f"t-{name}"]
            world = np.array(bare.vertices) * SCALE @ TURN
            world += rng.normal(0.0, 0.25, (len(world), 1)) * normal
            records[bare.id] = replace(bare, vertices=in_file(world))
            across = np.cross(normal, [0.3, 0.5, 0.8])
            across /= np.linalg.norm(across)
            deviation = rng.normal(0.0, np.radians(3.0), 2) @ [across, np.cross(normal, across)]
            read = Plane.from_normal(Rotation.from_rotvec(deviation).apply(normal))
            said[name] = f"{read.dip_direction_deg % 360.0:.3f}/{read.dip_deg:.3f}"
        found, _ = placed(records, readings(records, said))
        turn = Rotation.from_matrix(found.matrix[:3, :3] / found.scale @ TURN)
        stated = found.rotation_error_95_deg
        limits = [stated.about_east, stated.about_north, stated.about_up]
        inside += np.abs(np.degrees(turn.as_rotvec())) <= limits
    assert (inside >= 90).all(), inside
    assert (inside <= 99).all(), inside
