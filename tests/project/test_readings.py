"""Field measurements from a table: what is read, what is refused, and how azimuths are turned."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.notation import NOTATIONS, format_plane
from vomstudio.geology.orientation import Plane, angle_between_planes
from vomstudio.io.gis.crs import convergence_deg, degrees_to_grid
from vomstudio.project.imports.field_columns import guess
from vomstudio.project.imports.field_table import read_field_table
from vomstudio.project.imports.readings import (
    make_readings,
    missing_choice,
    read_readings,
)
from vomstudio.project.kinds.reading import Reading
from vomstudio.project.tables.orientation_table import orientation_row, write_orientation_csv


@pytest.fixture(scope="module")
def mplstereonet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import mplstereonet
    return mplstereonet


PLANES = ((132.0, 41.0), (5.0, 88.0), (270.0, 12.0), (359.0, 60.0), (90.0, 90.0))


def table_of(tmp_path, text: str, name: str = "book.csv"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return read_field_table(path)


def read(tmp_path, text: str, notation: str | None = None, name: str = "book.csv"):
    table = table_of(tmp_path, text, name)
    found = guess(table)
    notation = notation or found.notation
    assert missing_choice(found.columns, notation) is None
    return read_readings(table, found.columns, notation)


def angles(understood) -> list[tuple[float, float]]:
    return [(r.azimuth_deg, r.inclination_deg) for r in understood.rows]


# --- notations -------------------------------------------------------------------------------
def test_strikes_are_converted_to_dip_directions_as_in_mplstereonet(tmp_path, mplstereonet):
    strikes = [(strike, dip) for strike in (0, 42, 180, 275, 359) for dip in (5, 41, 90)]
    rows = "\n".join(f"{s},{d}" for s, d in strikes)
    ours = angles(read(tmp_path, f"strike,dip\n{rows}\n"))
    for (azimuth, dip), (strike, given_dip) in zip(ours, strikes, strict=True):
        plunge, bearing = mplstereonet.pole2plunge_bearing(strike, given_dip)
        assert dip == pytest.approx(90.0 - plunge[0])
        off = (azimuth - bearing[0] + 180.0) % 360.0 - 180.0
        assert abs(off) == pytest.approx(180.0, abs=1e-6)


def test_quadrant_texts_are_read_as_mplstereonet_reads_them(tmp_path, mplstereonet):
    texts = ["N42E 41SE", "N42E 41NW", "N10W 60W", "N80W 5N"]
    rows = "\n".join(f"{i},{t}" for i, t in enumerate(texts))
    understood = read(tmp_path, f"station,orientation\n{rows}\n")
    for row, text in zip(understood.rows, texts, strict=True):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            strike, dip = mplstereonet.parse_strike_dip(*text.split())
        theirs = Plane.from_strike(strike, dip)
        assert angle_between_planes(Plane(row.azimuth_deg, row.inclination_deg), theirs) < 1e-6


@pytest.mark.parametrize("notation", NOTATIONS)
def test_printed_orientations_are_read_back(tmp_path, notation):
    text = "\n".join(format_plane(Plane(*p), notation) for p in PLANES)
    understood = read(
        tmp_path,
        "id;orientation\n" + "\n".join(f"{i};{line}" for i, line in enumerate(text.splitlines())),
        notation,
    )
    assert not understood.bad_rows
    for row, plane in zip(understood.rows, PLANES, strict=True):
        back = Plane(row.azimuth_deg, row.inclination_deg)
        assert angle_between_planes(back, Plane(*plane)) < 1e-6


def test_lines_of_bare_text_need_no_header(tmp_path):
    understood = read(tmp_path, "N42E 41SE\nN10W 60W\n", name="book.txt")
    assert angles(understood) == [(132.0, 41.0), (260.0, 60.0)]
    understood = read(tmp_path, "132/41\n012/5\n", "dipdir/dip")
    assert angles(understood) == [(132.0, 41.0), (12.0, 5.0)]


def test_exported_orientation_table_is_read_back(tmp_path):
    rows = [
        orientation_row(
            Plane(*p),
            id=f"i{k}",
            name=f"B{k}",
            kind="bedding",
            set="upper",
            x=1.0,
            y=2.0,
            z=3.0,
            notes="a, b",
        )
        for k, p in enumerate(PLANES)
    ]
    write_orientation_csv(tmp_path / "out.csv", rows, crs=None, north="grid north")
    table = read_field_table(tmp_path / "out.csv")
    found = guess(table)
    assert found.notation == "dipdir/dip"
    understood = read_readings(table, found.columns, found.notation)
    assert angles(understood) == [pytest.approx(p) for p in PLANES]
    assert {r.name for r in understood.rows} == {f"B{k}" for k in range(5)}
    assert {(r.type_name, r.set_name, r.notes) for r in understood.rows} == {
        ("bedding", "upper", "a, b")
    }
    assert {r.position for r in understood.rows} == {(1.0, 2.0, 3.0)}


def test_lines_and_planes_are_distinguished_by_their_columns(tmp_path):
    understood = read(
        tmp_path, "name,dip direction,dip,trend,plunge\nB1,132,41,,\nL1,,,100,20\nL2,,,10,-30\n"
    )
    assert [(r.geometry, r.azimuth_deg, r.inclination_deg) for r in understood.rows] == [
        ("plane", 132.0, 41.0),
        ("line", 100.0, 20.0),
        ("line", 190.0, 30.0),
    ]
    (finding,) = understood.findings
    assert (finding.code, finding.values["rows"]) == ("reading.upward", (4,))


def test_decimal_commas_are_read_in_semicolon_separated_tables(tmp_path):
    understood = read(tmp_path, "dip direction;dip;x;y;z\n132,5;41,5;1,5;2,5;3\n")
    assert angles(understood) == [(132.5, 41.5)]
    assert understood.rows[0].position == (1.5, 2.5, 3.0)


# --- what only the user can say --------------------------------------------------------------
def test_ambiguous_azimuth_requires_a_notation(tmp_path):
    for text in ("azimuth,dip\n132,41\n", "132,41\n120,30\n", "id,orientation\n1,132/41\n"):
        found = guess(table_of(tmp_path, text))
        assert found.notation is None
        choice = missing_choice(found.columns, found.notation)
        assert choice.code == "reading.notation-missing"


def test_missing_angle_column_is_requested(tmp_path):
    found = guess(table_of(tmp_path, "name,dip\na,41\n"))
    assert missing_choice(found.columns, "dipdir/dip").values == {"roles": ("azimuth",)}
    assert missing_choice({}, "dipdir/dip")


def test_declination_column_is_reported_but_not_applied(tmp_path):
    found = guess(table_of(tmp_path, "dip direction,dip,declination\n132,41,2.6\n"))
    assert found.findings[0].code == "reading.declination-column"
    assert found.findings[0].values["first"] == "2.6"


# --- bad rows --------------------------------------------------------------------------------
def test_invalid_rows_are_reported_by_line_and_valid_rows_are_read(tmp_path):
    understood = read(
        tmp_path,
        "# north limb\n"
        "name,dip direction,dip,notes\n"
        "a,132,41,\n"
        "b,132,,\n"
        "c,400,20,\n"
        "d,132,95,\n"
        "e,north,20,\n"
        "f,120,30,covered, wet\n"
        '\ng,120,30,"covered, wet"\n',
    )
    assert [r.name for r in understood.rows] == ["a", "g"]
    assert understood.rows[1].notes == "covered, wet"
    assert [b.line for b in understood.bad_rows] == [4, 5, 6, 7, 8]
    missing, azimuth, dip, word, cells = (bad_rows.reason for bad_rows in understood.bad_rows)
    assert missing == Finding("reading.no-angle", missing=("inclination",))
    assert (azimuth.code, azimuth.values["value"]) == ("angle.out-of-range", 400.0)
    assert "95" in dip.message
    assert "NORTH" in word.message
    assert cells == Finding("table.ragged-row", count=5, expected=4, delimiter="comma")


def test_dip_quadrant_inconsistent_with_strike_is_rejected(tmp_path):
    understood = read(tmp_path, "strike,dip,quadrant\n42,41,SE\n42,41,NE\n")
    assert len(understood.rows) == 1
    assert understood.bad_rows[0].line == 3


def test_incomplete_position_is_omitted_and_reported(tmp_path):
    understood = read(tmp_path, "dip direction,dip,x,y,z\n132,41,1,2,\n132,41,1,2,3\n132,41,,,\n")
    assert [r.position for r in understood.rows] == [None, (1.0, 2.0, 3.0), None]
    (finding,) = understood.findings
    assert (finding.code, finding.values["rows"]) == ("reading.coordinate-missing", (2,))


def test_position_in_degrees_is_projected_to_the_crs(tmp_path):
    text = "dipAzimuth,dip,latitude,longitude,altitude\n132,41,46.0,15.0,350\n"
    table = table_of(tmp_path, text)
    found = guess(table)
    assert found.notation == "dipdir/dip"
    with_crs = read_readings(table, found.columns, found.notation, degrees_to_grid("EPSG:32633"))
    x, y, z = with_crs.rows[0].position
    assert (x, z) == (pytest.approx(500_000.0, abs=1e-3), 350.0)  # on the central meridian
    # The meridian's arc from the equator, integrated over WGS 84, times 0.9996.
    assert y == pytest.approx(5_096_085.926 * 0.9996, abs=0.01)
    without = read_readings(table, found.columns, found.notation)
    assert without.rows[0].position is None
    assert without.findings[0].code == "reading.degrees-without-crs"


@pytest.mark.parametrize("text", ["", "# only\n", "strike,dip\n"])
def test_table_without_rows_is_rejected(tmp_path, text):
    with pytest.raises(InputError):
        table_of(tmp_path, text)


# --- north -----------------------------------------------------------------------------------
@given(
    azimuth=st.floats(0, 360),
    dip=st.floats(0.5, 90),
    declination=st.floats(-180, 180),
    convergence=st.floats(-5, 5),
)
def test_subtracting_the_correction_restores_the_azimuth(azimuth, dip, declination, convergence):
    from vomstudio.project.imports.readings import FieldRow

    turned = declination - convergence
    there = make_readings(
        [FieldRow(1, "a", "plane", azimuth, dip)], type_ids={}, type_id="bedding", turn_deg=turned
    )[0]
    assert 0.0 <= there.azimuth_deg < 360.0
    assert there.turned_deg == turned
    back = (there.azimuth_deg - there.turned_deg - azimuth + 180.0) % 360.0 - 180.0
    assert abs(back) < 1e-9
    assert there.inclination_deg == dip


def test_azimuths_of_horizontal_planes_and_vertical_lines_stay_zero(tmp_path):
    flat = read(tmp_path, "dip direction,dip\n132,0\n")
    upright = read(tmp_path, "trend,plunge\n132,90\n")
    made = make_readings([*flat.rows, *upright.rows], type_ids={}, type_id="bedding", turn_deg=5.0)
    assert [r.azimuth_deg for r in made] == [0.0, 0.0]


@pytest.mark.parametrize(("longitude", "latitude"), [(18.0, 46.0), (12.1, 46.0), (15.0, 10.0)])
def test_convergence_is_the_angle_between_true_north_and_grid_north(longitude, latitude):
    """Against its definition, by differences: grid azimuth of true north = - convergence."""
    from pyproj import Transformer

    to_grid = Transformer.from_crs(4326, 32633, always_xy=True)
    x, y = to_grid.transform(longitude, latitude)
    x2, y2 = to_grid.transform(longitude, latitude + 1e-4)
    grid_azimuth_of_north = np.degrees(np.arctan2(x2 - x, y2 - y))
    assert convergence_deg("EPSG:32633", x, y) == pytest.approx(-grid_azimuth_of_north, abs=1e-4)


def test_position_outside_the_crs_area_has_no_convergence():
    assert convergence_deg("EPSG:32633", 1e9, 1e9) is None


# --- records ---------------------------------------------------------------------------------
def test_types_and_sets_in_the_table_override_the_defaults(tmp_path):
    understood = read(
        tmp_path,
        "type,dip direction,dip,set,overturned\nBedding,1,2,upper,yes\nDYKE,1,2,,\n,1,2,,no\n",
    )
    assert understood.type_names == ("Bedding", "DYKE")
    made = make_readings(
        understood.rows,
        type_ids={"bedding": "bedding", "dyke": "t9"},
        type_id="joint",
        set_name="J1",
        source="book.csv",
    )
    assert [(r.type_id, r.set_name, r.overturned) for r in made] == [
        ("bedding", "upper", True),
        ("t9", "J1", False),
        ("joint", "J1", False),
    ]
    assert {type(r) for r in made} == {Reading}
    assert {r.source for r in made} == {"book.csv"}


@pytest.mark.parametrize(
    ("header", "cells", "code", "value"),
    [
        ("x,y,z", "1e30,2,3", "coordinate.out-of-range", 1e30),
        ("x,y,z", "1,-1e13,3", "coordinate.out-of-range", -1e13),
        ("latitude,longitude,altitude", "95,15,350", "coordinate.latitude", 95.0),
        ("latitude,longitude,altitude", "46,1500,350", "coordinate.longitude", 1500.0),
    ],
)
def test_invalid_position_is_reported_by_line_and_the_reading_is_kept(
    tmp_path, header, cells, code, value
):
    table = table_of(tmp_path, f"dip direction,dip,{header}\n132,41,{cells}\n132,41,46,15,350\n")
    found = guess(table)
    understood = read_readings(table, found.columns, "dipdir/dip", degrees_to_grid("EPSG:32633"))
    assert understood.bad_rows == ()
    assert understood.rows[0].position is None
    assert understood.rows[1].position is not None
    (finding,) = understood.findings
    assert (finding.code, finding.values["rows"]) == ("reading.no-position", (2,))
    assert finding.values["reason_code"] == code
    assert f"{value:g}" in finding.values["reason"]
