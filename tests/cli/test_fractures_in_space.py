"""`vomstudio fractures` of lines in space: cliffs, pavements, windows, outlines, every door."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pyogrio
import pytest
import shapely
from scipy.spatial.transform import Rotation

import vomstudio as vs
from tests.messages import codes

CRS = "EPSG:32633"
AT = np.array([500_000.0, 5_000_000.0, 100.0])
pytestmark = pytest.mark.filterwarnings("ignore::vomstudio.core.errors.VomWarning")
CLIFF = [
    [(0, 0, 0), (10, 0, 0)],
    [(5, 0, -5), (5, 0, 5)],  # vertical: a point on the map
    [(0, 0, -5), (10, 0, 5)],  # the first one, on the map
    [(1, 0, 2), (6, 0, 4)],
    [(8, 0, -4), (8, 0.01, 4)],
    [(2, 0, -3), (4, 0, 3)],
]
"""Traces on a face that dips 90 degrees to the south, relative to `AT`."""
FACE = [(-1, 0, -6), (11, 0, -6), (11, 0, 6), (-1, 0, 6)]


PLANAR = [*CLIFF[:4], [(8, 0, -4), (8, 0, 4)], CLIFF[5]]


def lines(rows=CLIFF) -> list[np.ndarray]:
    return [np.array(row, float) + AT for row in rows]


def save(path: Path, shapes: list, crs: str | None = CRS) -> Path:
    if path.suffix == ".dxf":
        drawing = ezdxf.new(units=6)
        for shape in shapes:
            drawing.modelspace().add_polyline3d(shapely.get_coordinates(shape, include_z=True))
        drawing.saveas(path)
        return path
    wkb = shapely.to_wkb(np.array(shapes, object))
    pyogrio.raw.write(path, wkb, [], [], geometry_type="Unknown", crs=crs)
    return path


def shapes(rows=CLIFF) -> list[shapely.LineString]:
    return [shapely.LineString(row) for row in lines(rows)]


def figures(found: Any) -> dict[str, Any]:
    """All figures that do not depend on the frame; where circles of `P21_by_size` lie does."""
    answer = found.to_dict()
    for name in ("plane", "warnings", "mended", "P21_by_size"):
        answer.pop(name, None)
    return json.loads(json.dumps(answer))


def assert_same(one: Any, other: Any) -> None:
    """Equal but for rounding."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            assert_same(one[name], other[name])
    elif isinstance(one, list):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_same(a, b)
    else:
        assert one == (
            pytest.approx(other, rel=1e-5, abs=1e-9) if isinstance(one, float) else other
        )


@pytest.mark.parametrize("ending", ["gpkg", "dxf"])
def test_cliff_traces_are_measured_on_the_face(run, tmp_path: Path, ending: str) -> None:
    ran = run("fractures", save(tmp_path / f"cliff.{ending}", shapes()), "--json")
    assert ran.code == 0, ran.err
    told = ran.json
    assert told["traces"] == 6
    assert told["length"]["naive_mean_m"] == pytest.approx(53.852 / 6, abs=2e-4)
    assert told["plane"]["dip_deg"] == pytest.approx(90, abs=0.1)
    assert told["plane"]["azimuths_from"] == "up"
    finding = next(w for w in told["warnings"] if w["code"] == "lines.not-planar")
    assert finding["plane"] in ("180/90", "000/90")
    assert finding["lines"] == 6
    assert 0 < finding["scatter_m"] < 0.01


@pytest.mark.full
def test_output_and_figure_state_reference_of_angles(run, tmp_path: Path) -> None:
    path = save(tmp_path / "cliff.gpkg", shapes())
    picture = tmp_path / "p.svg"
    ran = run("fractures", path, "--strikes", "350-010,080-100", "--plot", picture)
    assert ran.code == 0, ran.err
    assert "/90, scatter" in ran.out
    assert "from up" in ran.out
    assert ">Pitch " in picture.read_text()
    # On the face the first trace is level and the second upright.
    sets = run("fractures", path, "--strikes", "350-010,080-100", "--json").json["sets"]
    assert {s["name"]: s["n"] for s in sets} == {"080-100": 1, "350-010": 2, "unassigned": 3}


@pytest.mark.parametrize("dip_deg", [15.0, 30.0, 44.0])
def test_traces_on_slope_keep_their_strikes(dip_deg: float) -> None:
    """Each trace is a set of its own, with the azimuth of its ends in World."""
    slope = Rotation.from_euler("xz", [dip_deg - 90.0, 25.0], degrees=True)
    rows = [slope.apply(np.array(row, float)) for row in PLANAR]
    for turn_deg in (0.0, 30.0):
        turned = [Rotation.from_euler("z", -turn_deg, degrees=True).apply(row) for row in rows]
        found = vs.fractures([row + AT for row in turned], by=[str(i) for i in range(len(rows))])
        plane = found.plane
        if plane is not None:
            assert plane.azimuths_from == "north"
            assert plane.dip_deg == pytest.approx(dip_deg, abs=1e-6)
        for one in found.sets:
            first, last = turned[int(one.name)][[0, -1]]
            east, north, _ = last - first
            strike = np.degrees(np.arctan2(east, north))
            assert np.sin(np.radians(one.strike_deg - strike)) == pytest.approx(0.0, abs=1e-6)


def test_rotating_cliff_about_vertical_changes_no_results() -> None:
    turn = Rotation.from_euler("z", 30, degrees=True)
    turned = [turn.apply(np.array(row, float)) + AT for row in CLIFF]
    one = vs.fractures(lines(), area=np.array(FACE, float) + AT)
    two = vs.fractures(turned, area=turn.apply(np.array(FACE, float)) + AT)
    assert one.area_m2 == pytest.approx(144)
    assert one.P21_1_per_m == pytest.approx(53.852 / 144, abs=1e-4)
    assert one.nodes.X > 3
    assert_same(figures(one), figures(two))


def test_cliff_and_equivalent_pavement_give_equal_results() -> None:
    upright = vs.fractures(lines(PLANAR), area=np.array(FACE, float) + AT)
    down = [np.array(row, float)[:, [0, 2, 1]] + AT for row in PLANAR]
    pavement = vs.fractures(down, area=np.array(FACE, float)[:, [0, 2, 1]] + AT)
    assert pavement.plane is None
    assert_same(figures(upright), figures(pavement))


@pytest.mark.full
def test_pavement_with_heights_gives_same_results_as_its_map(run, tmp_path: Path) -> None:
    """To the last digit, with its rough relief and a trace that climbs out of a crack."""
    rng = np.random.default_rng(2)
    rows = [
        np.column_stack([np.linspace(a, b, 12), rng.normal(0, 0.05, 12)]) + AT
        for a, b in rng.uniform(0, 20, (25, 2, 2))
    ]
    rows.append(np.array([[1, 1, -1], [1, 1, 0]]) + AT)
    relief = [shapely.LineString(row) for row in rows]
    area = save(tmp_path / "area.gpkg", [shapely.box(*(AT[:2]), *(AT[:2] + 20))])
    with_heights = run("fractures", save(tmp_path / "z.gpkg", relief), "--area", area, "--json")
    flat = save(tmp_path / "xy.gpkg", [shapely.force_2d(line) for line in relief])
    assert with_heights.json == run("fractures", flat, "--area", area, "--json").json
    assert "plane" not in with_heights.json


def test_given_plane_is_used(run, tmp_path: Path) -> None:
    path = save(tmp_path / "cliff.gpkg", shapes())
    told = run("fractures", path, "--plane", "180/60", "--json").json
    assert (told["plane"]["dip_direction_deg"], told["plane"]["dip_deg"]) == (180, 60)
    # Traces in the plane keep their lengths; those across are shortened.
    slope = Rotation.from_euler("x", -30, degrees=True)
    inclined = [slope.apply(np.array(row, float)) + AT for row in CLIFF]
    told = vs.fractures(inclined, plane="180/60")
    assert told.length.naive_mean_m == pytest.approx(53.852 / 6, abs=2e-4)
    assert vs.fractures(inclined, plane=(180, 90)).length.naive_mean_m < 8.5
    # The map is what it was.
    on_map = run("fractures", path, "--plane", "000/00", "--json").json
    assert (on_map["traces"], "plane" in on_map) == (4, False)
    assert on_map["length"]["naive_mean_m"] == pytest.approx(4.252, abs=1e-3)


@pytest.mark.full
def test_lines_without_heights_have_no_plane(run, tmp_path: Path) -> None:
    flat = save(tmp_path / "xy.gpkg", [shapely.force_2d(line) for line in shapes()])
    refused = run("fractures", flat, "--plane", "180/90", "--json")
    assert (refused.code, refused.json["error"]["code"]) == (2, "lines.no-heights")
    level = [[(0, 0, z), (10, 0, z)] for z in range(4)]
    mixed = save(
        tmp_path / "mixed.gpkg", [*shapes(level), *shapes(), shapely.force_2d(shapes()[0])]
    )
    told = run("fractures", mixed, "--json").json
    assert told["traces"] == 9  # the level one at height 0 is in both
    assert next(w for w in told["warnings"] if w["code"] == "lines.no-heights")["lines"] == 1
    straight = save(tmp_path / "one.gpkg", shapes(CLIFF[2:3]))
    refused = run("fractures", straight, "--json")
    assert (refused.code, refused.json["error"]["code"]) == (2, "lines.no-plane")


@pytest.mark.full
def test_map_windows_seen_edge_on_are_refused(run, tmp_path: Path) -> None:
    path = save(tmp_path / "cliff.gpkg", shapes())
    box = save(tmp_path / "box.gpkg", [shapely.box(*(AT[:2] - 1), *(AT[:2] + 11))])
    line = save(tmp_path / "line.gpkg", [shapely.force_2d(shapes()[0])])
    for option, given in (("area", box), ("scanline", line), ("circle", "500005,5000000,3")):
        refused = run("fractures", path, f"--{option}", given, "--json")
        error = refused.json["error"]
        assert (refused.code, error["code"], error["option"]) == (2, "lines.edge-on", option)


@pytest.mark.full
def test_windows_with_heights_are_used_on_the_face(run, tmp_path: Path) -> None:
    path = save(tmp_path / "cliff.gpkg", shapes())
    corners = np.array(FACE, float) + AT
    area = save(tmp_path / "area.gpkg", [shapely.Polygon(corners)])
    outline = save(tmp_path / "area.dxf", [shapely.LineString([*corners, corners[0]])])
    for given in (area, outline):
        told = run("fractures", path, "--area", given, "--json").json
        assert told["area_m2"] == pytest.approx(144)
        assert told["P20_1_per_m2"] == pytest.approx(6 / 144)
    told = run("fractures", path, "--circle", "500005,5000000,100,5", "--json").json
    assert told["area_m2"] == pytest.approx(np.pi * 25)
    # A level scanline at the height of the traces meets the steep ones.
    across = save(tmp_path / "s.gpkg", shapes([[(0, 0, 1), (10, 0, 1)]]))
    assert run("fractures", path, "--scanline", across, "--json").json["scanline"]["n"] == 4


def test_outlines_among_traces_are_left_out_and_reported(run, tmp_path: Path) -> None:
    ring = [(3, 0, 0), (4, 0, 0), (4, 1, 1), (3, 1, 1), (3, 0, 0)]
    path = save(tmp_path / "cliff.gpkg", [*shapes(), *shapes([ring])])
    told = run("fractures", path, "--json").json
    assert told["traces"] == 6
    assert next(w for w in told["warnings"] if w["code"] == "lines.closed")["lines"] == 1
    # On a pavement those on a layer of patches are; other closed lines may be traces.
    drawing = ezdxf.new(units=6)
    for name in ("Bedding_patches", "joints"):
        points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 0, 0)]
        drawing.modelspace().add_polyline3d(points, dxfattribs={"layer": name})
        drawing.modelspace().add_line(
            (0, len(name)), (4, len(name)), dxfattribs={"layer": "joints"}
        )
    drawing.saveas(tmp_path / "pavement.dxf")
    told = run("fractures", tmp_path / "pavement.dxf", "--json").json
    assert told["traces"] == 3
    assert "lines.closed" in codes(told)


def test_heights_in_another_unit_are_converted(run, tmp_path: Path) -> None:
    """x and y in metres, heights in US survey feet (EPSG:6360)."""
    rows = [np.array(row, float) + AT for row in CLIFF]
    for row in rows:
        row[:, 2] *= 3937 / 1200
    path = save(tmp_path / "cliff.gpkg", [shapely.LineString(r) for r in rows], "EPSG:32633+6360")
    told = run("fractures", path, "--json").json
    assert told["length"]["naive_mean_m"] == pytest.approx(53.852 / 6, abs=2e-4)
    assert "frame.unit-converted" in codes(told)
