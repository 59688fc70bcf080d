"""Slips on planes of every attitude come out of files as they were worked out by hand.

A line is given by its rake r in the plane, so its vector is cos r along the strike and sin r down
the dip. Where the hanging wall goes was read off a sketch of each plane: down for normal, up for
reverse; for sinistral to the left of one who stands in front of the fault and looks across it. That
is along the line downward (slip rake -r), or against it (180 - r).
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.project.conftest import MODEL
from tests.tiers import first_in_default_tier
from vomstudio.geology.slip import CONFIDENCES, SlipConfidence, SlipSense
from vomstudio.geometry.frames import Frame
from vomstudio.project.exports.export import export_records
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.measurement_cache import measure_all
from vomstudio.project.records import Record

HASH = "0" * 64
HALF, HIGH = 0.5, math.sqrt(0.75)


@dataclass(frozen=True)
class Case:
    """plane: dip direction and dip. way: a vector (east, north, up) along the line, as a sketch
    gives it. trend, plunge, rake: of that line. slips: slip rake by sense; the others have none."""

    plane: tuple[float, float]
    way: tuple[float, float, float]
    trend: float
    plunge: float
    rake: float
    slips: dict[SlipSense, float]


# sin(plunge) = 0.433 of a line with rake 30 or 150 in a plane of 60; tan(trend) = 0.25 / 0.866.
OBLIQUE = math.degrees(math.asin(math.sqrt(3.0) / 4.0))
TURN = math.degrees(math.atan(HALF**2 / HIGH))
CASES = {
    # Dips east: the hanging wall is the eastern block, which goes north where it is sinistral.
    "east, down dip": Case((90, 60), (HALF, 0, -HIGH), 90, 60, 90, {"normal": -90, "reverse": 90}),
    "east, strike": Case((90, 60), (0, 1, 0), 0, 0, 0, {"sinistral": 0, "dextral": 180}),
    "east, oblique to the north": Case(
        (90, 60),
        (0.25, HIGH, -HALF * HIGH),
        TURN,
        OBLIQUE,
        30,
        {"normal": -30, "reverse": 150, "sinistral": -30, "dextral": 150},
    ),
    "east, oblique to the south": Case(
        (90, 60),
        (0.25, -HIGH, -HALF * HIGH),
        180 - TURN,
        OBLIQUE,
        150,
        {"normal": -150, "reverse": 30, "sinistral": 30, "dextral": -150},
    ),
    # Dips west, the net's other side: the western block goes south where it is sinistral.
    "west, down dip": Case(
        (270, 60), (-HALF, 0, -HIGH), 270, 60, 90, {"normal": -90, "reverse": 90}
    ),
    "west, strike": Case((270, 60), (0, 1, 0), 0, 0, 0, {"sinistral": 0, "dextral": 180}),
    "west, oblique to the south": Case(
        (270, 60),
        (-0.25, -HIGH, -HALF * HIGH),
        180 + TURN,
        OBLIQUE,
        30,
        {"normal": -30, "reverse": 150, "sinistral": -30, "dextral": 150},
    ),
    "west, oblique to the north": Case(
        (270, 60),
        (-0.25, HIGH, -HALF * HIGH),
        360 - TURN,
        OBLIQUE,
        150,
        {"normal": -150, "reverse": 30, "sinistral": 30, "dextral": -150},
    ),
    # A thrust over the foreland in the north-north-east.
    "a gentle thrust": Case(
        (200, 20),
        (
            math.sin(math.radians(20)) * math.cos(math.radians(20)),
            math.cos(math.radians(20)) ** 2,
            math.sin(math.radians(20)),
        ),
        200,
        20,
        90,
        {"normal": -90, "reverse": 90},
    ),
    # Vertical, striking north: the eastern block counts, whichever way the dip is written.
    "vertical, oblique": Case(
        (90, 90), (0, HIGH, -HALF), 0, 30, 30, {"sinistral": -30, "dextral": 150}
    ),
    "vertical, written west": Case(
        (270, 90), (0, HIGH, -HALF), 0, 30, 30, {"sinistral": -30, "dextral": 150}
    ),
    "vertical, strike": Case((90, 90), (0, -1, 0), 0, 0, 0, {"sinistral": 0, "dextral": 180}),
    # Up and down say nothing where no wall hangs over the other.
    "vertical, upright": Case((90, 90), (0, 0, 1), 0, 90, 90, {}),
    # Vertical, striking east: the southern block counts, and goes west where it is dextral.
    "vertical, to the west": Case(
        (180, 90), (-HALF, 0, -HIGH), 270, 60, 120, {"sinistral": 60, "dextral": -120}
    ),
    "vertical, written north": Case(
        (0, 90), (-HALF, 0, -HIGH), 270, 60, 120, {"sinistral": 60, "dextral": -120}
    ),
    # Horizontal: rakes count from the strike of a dip to the north, which is west; no sense holds.
    "horizontal, to the north-east": Case((0, 0), (1, 1, 0), 45, 0, 135, {}),
    "horizontal, to the north": Case((77, 0), (0, 1, 0), 0, 0, 90, {}),
}
SENSES: tuple[SlipSense, ...] = ("", "normal", "reverse", "sinistral", "dextral")
# A UTM place, since differences of such numbers are what is measured.
HERE = np.array([576_700.0, 5_188_100.0, 160.0])


def records_of(case: Case) -> dict[str, Record]:
    """The plane as a reading, and on it a line for each sense and one without."""
    model = replace(MODEL, placement=Frame("crs", "EPSG:32633"))
    ends = np.array([HERE, HERE + 4.0 * np.array(case.way)])
    vertices = tuple(map(tuple, ends.tolist()))
    found: dict[str, Record] = {
        model.id: model,
        "r1": Reading("r1", "F01", "fault", "plane", *map(float, case.plane)),
    }
    for sense in SENSES:
        id_ = sense or "none"
        found[id_] = Lineation(
            id_, id_, "fault", model.id, HASH, vertices, plane_id="r1", slip=sense
        )
    return found


def written(records: dict[str, Record], folder: Path) -> dict[str, dict[str, dict[str, Any]]]:
    """By file and layer, the rows of the lines by id; numbers as numbers, None where empty."""
    import pyogrio

    table, layers, shapes = folder / "t.csv", folder / "t.gpkg", folder / "t.shp"
    for format_, out in (("csv", table), ("gpkg", layers), ("shp", shapes)):
        export_records(records, format_, out)
    text = [t for t in table.read_text(encoding="utf-8").splitlines() if not t.startswith("#")]
    found = {"csv": {row["id"]: row for row in csv.DictReader(text)}}
    for file, layer in (
        (layers, "lines"),
        (layers, "lineations"),
        (shapes.with_stem("t_lines"), None),
        (shapes.with_stem("t_lineations"), None),
    ):
        meta, _, _, columns = pyogrio.raw.read(file, layer=layer)
        rows = [dict(zip(meta["fields"], row, strict=True)) for row in zip(*columns, strict=True)]
        found[layer or file.stem] = {row["id"]: row for row in rows}
    return {
        name: {
            id_: {column: plain(value) for column, value in row.items()}
            for id_, row in rows.items()
            if id_ != "r1"
        }
        for name, rows in found.items()
    }


def plain(value: Any) -> Any:
    if value is None or value == "" or value != value:
        return None
    try:
        return float(value)
    except ValueError:
        return value


SHORT = {
    "trend_deg": "trend",
    "plunge_deg": "plunge",
    "rake_deg": "rake",
    "slip_rake_deg": "slip_rake",
    "slip_sense": "slip_sense",
    "on_plane": "on_plane",
    "on_plane_dip_direction_deg": "onplane_dd",
    "on_plane_dip_deg": "onplanedip",
}


@pytest.mark.filterwarnings("ignore:'crs' was not provided:UserWarning")
@pytest.mark.parametrize("name", first_in_default_tier(CASES, 4))
def test_slip_is_the_same_in_every_table_and_layer(tmp_path: Path, name: str) -> None:
    case = CASES[name]
    found = written(records_of(case), tmp_path)
    assert set(found) == {"csv", "lines", "lineations", "t_lines", "t_lineations"}
    for file, rows in found.items():
        assert sorted(rows) == sorted(sense or "none" for sense in SENSES)
        for sense in SENSES:
            expected = {
                "trend_deg": case.trend,
                "plunge_deg": case.plunge,
                "rake_deg": case.rake,
                "slip_rake_deg": case.slips.get(sense),
                "slip_sense": sense or None,
                "on_plane": "F01",
                "on_plane_dip_direction_deg": case.plane[0] if case.plane[1] else 0.0,
                "on_plane_dip_deg": case.plane[1],
            }
            agree(file, rows[sense or "none"], expected)


def agree(file: str, row: dict[str, Any], expected: dict[str, Any]) -> None:
    """Whether a row of a table or layer says what was worked out by hand."""
    for column, value in expected.items():
        got = row[SHORT[column] if file.startswith("t_") else column]
        wanted = pytest.approx(value, abs=1e-6) if isinstance(value, float | int) else value
        assert got == wanted, (file, row, column)


@pytest.mark.filterwarnings("ignore:'crs' was not provided:UserWarning")
@pytest.mark.parametrize("name", first_in_default_tier(CASES, 4))
def test_slip_does_not_depend_on_line_direction_or_file_axes(tmp_path: Path, name: str) -> None:
    """The line is drawn from its other end, in a file with y up and z south, in feet."""
    case = CASES[name]
    records = records_of(case)
    records[MODEL.id] = replace(MODEL, placement=Frame("local", None, 0.3048, "y"))
    for sense in SENSES:
        line = records[sense or "none"]
        assert isinstance(line, Lineation)
        turned = [(east, up, -north) for east, north, up in reversed(line.vertices)]
        feet = tuple(tuple(float(value) / 0.3048 for value in point) for point in turned)
        records[line.id] = replace(line, vertices=feet)
    for file, rows in written(records, tmp_path).items():
        for sense in SENSES:
            expected = {"plunge_deg": case.plunge, "slip_rake_deg": case.slips.get(sense)}
            agree(file, rows[sense or "none"], expected)


@pytest.mark.parametrize("name", [n for n, case in CASES.items() if case.plane[1]])
def test_sense_that_leaves_the_direction_open_is_kept_and_reported(name: str) -> None:
    case, records = CASES[name], records_of(CASES[name])
    from vomstudio.project.tables.project_table import project_table

    rows = {row["id"]: row for row in project_table(records).rows}
    for sense in SENSES:
        said = "sense of slip does not determine" in (rows[sense or "none"]["notes"] or "")
        assert said == (bool(sense) and sense not in case.slips)
        assert rows[sense or "none"]["slip_sense"] == (sense or None)


def test_slip_on_a_traced_plane_refers_to_the_plane_stated_in_its_row(
    tmp_path: Path,
) -> None:
    """The plane is the fit of a trace, and its row and the line's say the same of it."""
    case = CASES["west, oblique to the north"]
    along, down = np.array([0.0, -1.0, 0.0]), np.array([-HALF, 0.0, -HIGH])
    places = [(0, 0), (3, 1), (5, -2), (9, 1), (11, 3), (14, -1)]
    vertices = tuple(tuple((HERE + a * along + d * down).tolist()) for a, d in places)
    records = records_of(case)
    records["r1"] = Trace("r1", "F01", "fault", MODEL.id, HASH, vertices)
    found = written(records, tmp_path)
    host = measure_all(records, [records["r1"]])[0].plane
    row = found["csv"]["reverse"]
    assert row["slip_rake_deg"] == pytest.approx(30.0, abs=1e-6)
    assert row["on_plane_dip_direction_deg"] == pytest.approx(host.dip_direction_deg, abs=1e-8)
    assert row["on_plane_dip_deg"] == pytest.approx(60.0, abs=1e-6)
    assert (row["on_plane"], found["lines"]["reverse"]["on_plane"]) == ("F01", "F01")


@pytest.mark.parametrize(("code", "_"), CONFIDENCES)
def test_slip_confidence_is_written_beside_the_sense(
    tmp_path: Path, code: SlipConfidence, _: str
) -> None:
    records = records_of(CASES["west, strike"])
    for id_ in ("dextral", "none"):
        records[id_] = replace(records[id_], slip_confidence=code)
    found = written(records, tmp_path)
    for file, rows in found.items():
        name = "slip_conf" if file.startswith("t_") else "slip_confidence"
        assert rows["dextral"][name] == (code or None)
        # Nothing is sure, or doubtful, where no sense was seen.
        assert rows["none"][name] is None


def test_line_with_a_deleted_plane_keeps_its_sense_and_has_no_rake(tmp_path: Path) -> None:
    records = records_of(CASES["east, down dip"])
    del records["r1"]
    row = written(records, tmp_path)["csv"]["normal"]
    assert row["slip_sense"] == "normal"
    for column in ("rake_deg", "slip_rake_deg", "on_plane", "on_plane_dip_deg"):
        assert row[column] is None
