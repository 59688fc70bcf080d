"""What the columns and cells of a field book are taken for, and that nothing is guessed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.messages import refused
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.project.imports.field_columns import guess
from vomstudio.project.imports.field_table import (
    FieldTable,
    is_orientation,
    parse_cell,
    read_field_table,
)
from vomstudio.project.imports.readings import (
    BadRow,
    FieldReadings,
    FieldRow,
    make_readings,
    missing_choice,
    read_readings,
)


@pytest.fixture
def book(tmp_path: Path) -> Path:
    return tmp_path / "book.csv"


def table_of(book: Path, text: str) -> FieldTable:
    book.write_text(text, encoding="utf-8")
    return read_field_table(book)


def roles(book: Path, header: str, *rows: str) -> tuple[dict[str, str], str | None]:
    """The name of the column that each role was given, and the notation."""
    width = header.count(",")
    table = table_of(book, "\n".join([header, *(rows or [",".join(["10"] * (width + 1))])]))
    found = guess(table)
    return {role: table.label(column) for role, column in found.columns.items()}, found.notation


def readings(book: Path, text: str, notation: str | None = None) -> FieldReadings:
    table = table_of(book, text)
    found = guess(table)
    chosen = notation or found.notation
    assert chosen is not None
    return read_readings(table, found.columns, chosen)


# --- columns -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("header", "expected", "notation"),
    [
        ("dip direction,dip", {"azimuth": "dip direction", "inclination": "dip"}, "dipdir/dip"),
        ("dip,dip direction", {"azimuth": "dip direction", "inclination": "dip"}, "dipdir/dip"),
        ("strike,dip", {"azimuth": "strike", "inclination": "dip"}, "strike/dip"),
        ("strike LHR,dip", {"azimuth": "strike LHR", "inclination": "dip"}, "strike/dip lhr"),
        (
            "strike left hand,dip",
            {"azimuth": "strike left hand", "inclination": "dip"},
            "strike/dip lhr",
        ),
        ("azimuth,dip", {"azimuth": "azimuth", "inclination": "dip"}, None),
        ("trend,plunge", {"azimuth": "trend", "inclination": "plunge"}, "trend/plunge"),
        ("azimuth,plunge", {"azimuth": "azimuth", "inclination": "plunge"}, "trend/plunge"),
        (
            "dip direction,dip,trend,plunge",
            {
                "azimuth": "dip direction",
                "inclination": "dip",
                "trend": "trend",
                "plunge": "plunge",
            },
            "dipdir/dip",
        ),
        (
            "strike,dip direction,dip",
            {"azimuth": "dip direction", "inclination": "dip"},
            "dipdir/dip",
        ),
    ],
)
def test_angle_columns_are_recognised_by_name(
    book: Path, header: str, expected: dict[str, str], notation: str | None
) -> None:
    assert roles(book, header) == (expected, notation)


def test_other_columns_are_recognised_by_name(book: Path) -> None:
    header = (
        "Station,type,set,element,comments,inverted,Easting,Northing,Elevation,dip direction,dip"
    )
    found, notation = roles(book, header)
    assert found == {
        "station": "Station",
        "type": "type",
        "set": "set",
        "element": "element",
        "notes": "comments",
        "overturned": "inverted",
        "x": "Easting",
        "y": "Northing",
        "z": "Elevation",
        "azimuth": "dip direction",
        "inclination": "dip",
    }
    assert notation == "dipdir/dip"


def test_single_letters_take_precedence_over_words_and_names_over_numbers(book: Path) -> None:
    found, _ = roles(book, "id,easting,x,y,northing,height,z,dip direction,dip,name")
    assert (found["x"], found["y"], found["z"], found["name"]) == ("x", "y", "z", "name")
    found, _ = roles(book, "id,dip direction,dip")
    assert found["name"] == "id"


@pytest.mark.parametrize(
    ("header", "degrees"),
    [
        ("lon,lat,z,dip direction,dip", True),
        ("x,lon,lat,z,dip direction,dip", True),
        ("y,lon,lat,z,dip direction,dip", True),
        ("x,y,lon,lat,z,dip direction,dip", False),
    ],
)
def test_degrees_are_used_only_without_a_complete_position(
    book: Path, header: str, degrees: bool
) -> None:
    found, _ = roles(book, header)
    assert ("longitude" in found, "latitude" in found) == (degrees, degrees)
    assert found["z"] == "z"


def test_no_column_has_two_roles(book: Path) -> None:
    found, _ = roles(book, "n,dip direction,dip,set,notes")
    assert len(set(found.values())) == len(found)
    # An azimuth that is the trend of the lines is not that of the planes as well.
    found, notation = roles(book, "quadrant,dip,trend,plunge")
    assert (found, notation) == (
        {"inclination": "dip", "quadrant": "quadrant", "trend": "trend", "plunge": "plunge"},
        None,
    )


def test_compass_points_beside_a_strike_are_its_quadrant(book: Path) -> None:
    """A column named dip direction may hold SE where the strike is a number."""
    found, notation = roles(book, "name,strike,dip,dip direction", "a,42,41,SE", "b,45,40,se")
    assert found == {
        "name": "name",
        "azimuth": "strike",
        "inclination": "dip",
        "quadrant": "dip direction",
    }
    assert notation == "quadrant"
    found, notation = roles(book, "name,strike,dip,dip direction", "a,42,41,SE", "b,45,40,135")
    assert (found["azimuth"], notation) == ("dip direction", "dipdir/dip")
    found, notation = roles(book, "name,strike,dip,dip direction", "a,42,41,", "b,45,40,")
    assert (found["azimuth"], notation) == ("dip direction", "dipdir/dip")


def test_right_hand_rule_applies_to_rows_without_a_quadrant(book: Path) -> None:
    found, notation = roles(book, "name,strike,dip,quadrant", "a,42,41,SE", "b,45,40,")
    assert (found["quadrant"], notation) == ("quadrant", "strike/dip")
    _, notation = roles(book, "name,strike,dip,quadrant", "a,42,41,SE")
    assert notation == "quadrant"
    found, _ = roles(book, "name,azimuth,dip,quadrant", "a,42,41,SE")
    assert found["azimuth"] == "azimuth"
    for row in ("a,N42E,41", "a,42,41SE"):
        _, notation = roles(book, "name,strike,dip", row)
        assert notation == "quadrant"


@pytest.mark.parametrize(
    ("header", "cell", "notation"),
    [
        ("orientation", "N42E 41SE", "quadrant"),
        ("orientation", "132/41", None),
        ("dip dir / dip", "132/41", "dipdir/dip"),
        ("strike / dip", "42/41", "strike/dip"),
        ("trend / plunge", "100/20", "trend/plunge"),
        ("lineation", "100/20", "trend/plunge"),
        ("plane", "132/41", None),
    ],
)
def test_two_angles_in_one_cell_follow_the_header_or_their_own_notation(
    book: Path, header: str, cell: str, notation: str | None
) -> None:
    found, said = roles(book, f"name,{header}", f"a,{cell}", "b,")
    assert (found["text"], said) == (header, notation)


def test_text_column_is_the_first_with_mostly_orientations(book: Path) -> None:
    found, _ = roles(book, "name,a,b", "1,N42E 41SE,N1E 5E", "2,x,N2E 5E", "3,N42E 41SE,N3E 5E")
    assert found["text"] == "a"
    found, _ = roles(book, "name,a,b", "1,N42E 41SE,N1E 5E", "2,x,N2E 5E")
    assert found["text"] == "b"
    found, notation = roles(book, "name,a", "1,x", "2,y")
    assert (found, notation) == ({"name": "name"}, None)


def test_one_bare_pair_among_quadrants_leaves_the_notation_open(book: Path) -> None:
    assert roles(book, "orientation,n", "N42E 41SE,1", "132/41,2")[1] is None
    assert roles(book, "orientation,n", "N42E 41SE,1", ",2")[1] == "quadrant"


@pytest.mark.parametrize(
    ("text", "columns", "notation"),
    [
        ("132,41\n120,30\n", (0, 1), None),
        ("1000,132,41\n1001,120,30\n", (1, 2), None),
        ("360,90\n0,0\n", (0, 1), None),
        ("361,41\n361,30\n", None, None),
        ("132,91\n120,91\n", None, None),
        ("-1,41\n-1,30\n", None, None),
        ("132,-1\n120,-1\n", None, None),
        ("1000,2,41\n1001,N42E,41SE\n", None, None),
        ("132,41\n120,30\n999,999\n", (0, 1), None),
        ("132,41\n999,999\n", None, None),
        ("1000,2,41\n1001,N42E,41SE\n1002,N10W,60W\n", (1, 2), "quadrant"),
    ],
)
def test_without_names_two_adjacent_angle_columns_are_used(
    book: Path, text: str, columns: tuple[int, int] | None, notation: str | None
) -> None:
    table = table_of(book, text)
    assert table.names is None
    found = guess(table)
    expected = (
        {} if columns is None else dict(zip(("azimuth", "inclination"), columns, strict=True))
    )
    assert (found.columns, found.notation) == (expected, notation)
    assert table.label(1) == "column 2"


def test_declinations_are_reported_with_their_value_or_number(book: Path) -> None:
    table = table_of(book, "dip direction,dip,mag dec\n1,2,2.6\n1,2,\n1,2,2.6\n")
    (finding,) = guess(table).findings
    assert finding.code == "reading.declination-column"
    assert finding.values == {"column": "mag dec", "count": 1, "first": "2.6"}
    table = table_of(book, "dip direction,dip,declination\n1,2,2.6\n1,2,2.7\n")
    (finding,) = guess(table).findings
    assert "(2 different values)" in finding.message
    assert guess(table_of(book, "dip direction,dip\n1,2\n")).findings == ()


# --- cells ---------------------------------------------------------------------------------------
def test_line_numbers_include_comments_and_blank_lines(book: Path) -> None:
    table = table_of(book, "# a book\n\ndip direction,dip\r\n132,41\n\n # later\n120,30\n")
    assert table.names == ("dip direction", "dip")
    assert (table.rows, table.lines) == ([["132", "41"], ["120", "30"]], [4, 7])
    assert (table.width, table.delimiter, dict(table.ragged_row_findings), table.notes) == (
        2,
        ",",
        {},
        (),
    )


def test_rows_of_another_width_are_reported_and_kept_in_their_columns(book: Path) -> None:
    table = table_of(book, "name,dip direction,dip\na,132,41,,\nb,132\nc,132,41,wet,cold\n")
    assert table.rows == [["a", "132", "41"], ["b", "132", ""], ["c", "132", "41"]]
    assert dict(table.ragged_row_findings) == {
        1: Finding("table.ragged-row", count=2, expected=3, delimiter="comma"),
        2: Finding("table.ragged-row", count=5, expected=3, delimiter="comma"),
    }
    table = table_of(book, "132,41\n120,30\n1,2,3\n5,6\n")
    assert (table.names, table.width, list(table.ragged_row_findings)) == (None, 2, [2])


def test_quotation_marks_keep_a_cell_together(book: Path) -> None:
    table = table_of(book, 'name,dip direction,dip,notes\na, 132,41, "wet, ""cold"" "\n')
    assert table.rows == [["a", "132", "41", 'wet, "cold"']]


def test_lines_with_one_reading_each_make_one_column(book: Path) -> None:
    table = table_of(book, "N42E 41SE\n N10W 60W \n")
    assert (table.names, table.rows, table.lines) == (None, [["N42E 41SE"], ["N10W 60W"]], [1, 2])
    table = table_of(book, "reading\nN42E 41SE\nN10W 60W\n")
    assert (table.names, table.rows) == (("reading",), [["N42E 41SE"], ["N10W 60W"]])
    # A single line of two cells is no list of readings.
    assert table_of(book, "132,41\n").rows == [["132", "41"]]


def test_names_with_spaces_are_joined_if_spaces_separate_the_cells(book: Path) -> None:
    table = table_of(book, "name dip direction dip\na 132 41\nb 120 30\n")
    assert table.width == 3
    assert guess(table).notation == "dipdir/dip"


def test_table_without_rows_is_rejected(book: Path) -> None:
    with refused("table.no-rows"):
        table_of(book, "# nothing\n\n")
    with refused("table.no-rows"):
        table_of(book, "strike,dip\n")


@pytest.mark.parametrize(
    ("text", "is_one"),
    [
        ("132/41", True),
        ("N42E 41SE", True),
        ("n42e 41se", True),
        ("132°, 41°", True),
        ("25 → 130°", True),
        ("132 41", False),
        ("132", False),
        ("west", False),
        ("a/b", False),
        ("", False),
    ],
)
def test_two_bare_numbers_are_not_taken_for_one_orientation(text: str, is_one: bool) -> None:
    assert is_orientation(text) is is_one


def test_cell_numbers_are_parsed_by_the_decimal_mark_of_the_table(book: Path) -> None:
    commas, points = table_of(book, "a,b\n1,2\n"), table_of(book, "a;b\n1,5;2\n")
    tabs = table_of(book, "a\tb\n1,5\t2\n")
    for cell in ("", "x", "nan", "inf", "-inf", "-"):
        assert parse_cell(cell, commas) is None
    assert parse_cell("41.5°", commas) == 41.5
    assert parse_cell("-1e2", commas) == -100.0
    assert parse_cell("1,5", commas) is None
    assert parse_cell("1,5", points) == parse_cell("1,5", tabs) == 1.5


# --- rows ----------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("columns", "notation", "expected"),
    [
        ({}, "dipdir/dip", ("azimuth", "inclination")),
        ({"azimuth": 0}, "dipdir/dip", ("inclination",)),
        ({"inclination": 0}, "dipdir/dip", ("azimuth",)),
        ({"azimuth": 0, "inclination": 1}, None, None),
        ({"text": 0}, None, None),
    ],
)
def test_missing_column_or_notation_is_requested(
    columns: dict[str, int], notation: str | None, expected: tuple[str, ...] | None
) -> None:
    finding = missing_choice(columns, notation)
    if expected is None:
        assert finding == Finding("reading.notation-missing")
    else:
        assert finding == Finding("reading.columns-missing", roles=expected)


def test_complete_choice_requests_nothing() -> None:
    assert missing_choice({"azimuth": 0, "inclination": 1}, "strike/dip") is None
    assert missing_choice({"text": 0}, "quadrant") is None


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("0,0", (0.0, 0.0)),
        ("132,0", (0.0, 0.0)),
        ("360,90", (0.0, 90.0)),
        ("359.5,0.5", (359.5, 0.5)),
        ("-1,5", None),
        ("361,5", {"angle": "azimuth", "value": 361}),
        ("360.5,5", {"angle": "azimuth", "value": 360.5}),
        ("5,91", None),
        ("5,-1", {"angle": "dip", "value": -1}),
        ("x,5", None),
        ("5,x", None),
        (",5", {"missing": ("azimuth",)}),
        ("5,", {"missing": ("inclination",)}),
        ("-,n/a", {"missing": ("azimuth", "inclination")}),
        (",", {"missing": ("azimuth", "inclination")}),
    ],
)
def test_plane_angles_are_limited_to_the_compass_range(
    book: Path, row: str, expected: tuple[float, float] | dict[str, Any] | None
) -> None:
    found = readings(book, f"name,dip direction,dip\na,1,2\nb,{row}\nc,3,4\n")
    if isinstance(expected, tuple):
        assert found.bad_rows == ()
        assert (found.rows[1].azimuth_deg, found.rows[1].inclination_deg) == expected
        assert found.rows[1].geometry == "plane"
    else:
        assert [bad_rows.line for bad_rows in found.bad_rows] == [3]
        if expected is not None:
            code = "reading.no-angle" if "missing" in expected else "angle.out-of-range"
            assert found.bad_rows[0].reason.code == code
            assert expected.items() <= found.bad_rows[0].reason.values.items()
        assert str(found.bad_rows[0]) == f"Line 3: {found.bad_rows[0].reason}"
        assert [r.line for r in found.rows] == [2, 4]


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("0,0", (0.0, 0.0)),
        ("360,90", (0.0, 90.0)),
        ("100,20", (100.0, 20.0)),
        ("10,-30", (190.0, 30.0)),
        ("350,-90", (170.0, 90.0)),
        ("N50W,25", (310.0, 25.0)),
        ("361,5", ("trend", 361.0)),
        ("-1,5", ("trend", -1.0)),
        ("-0.5,5", ("trend", -0.5)),
        ("5,91", ("plunge", 91.0)),
        ("5,-91", ("plunge", -91.0)),
        ("5,90.5", ("plunge", 90.5)),
    ],
)
def test_line_angles_are_limited_to_the_compass_range(
    book: Path, row: str, expected: tuple[float | str, float]
) -> None:
    found = readings(book, f"trend,plunge\n1,2\n{row}\n")
    if isinstance(expected[0], str):
        reason = found.bad_rows[0].reason
        assert reason.code == "angle.out-of-range"
        assert (reason.values["angle"], reason.values["value"]) == expected
        return
    assert found.bad_rows == ()
    made = found.rows[1]
    assert made.geometry == "line"
    assert made.inclination_deg == expected[1]
    assert made.inclination_deg == 90.0 or made.azimuth_deg == expected[0]
    upward = "-" in row
    assert _rows_of(found) == ([("reading.upward", (3,))] if upward else [])


@pytest.mark.parametrize(
    ("header", "row", "expected"),
    [
        ("strike,dip", "42,41", (132.0, 41.0)),
        ("strike,dip", "300,41", (30.0, 41.0)),
        ("strike lhr,dip", "42,41", (312.0, 41.0)),
        ("strike,dip,quadrant", "42,41,NW", (312.0, 41.0)),
        ("strike,dip,quadrant", "42,41,SE", (132.0, 41.0)),
        ("strike,dip", "N42E,41SE", (132.0, 41.0)),
    ],
)
def test_plane_follows_its_notation(
    book: Path, header: str, row: str, expected: tuple[float, float]
) -> None:
    (made,) = readings(book, f"{header}\n{row}\n").rows
    assert (made.azimuth_deg, made.inclination_deg) == pytest.approx(expected)


def test_quadrant_beside_a_dip_direction_is_ignored(book: Path) -> None:
    table = table_of(book, "a,b,c\n132,41,NW\n")
    columns = {"azimuth": 0, "inclination": 1, "quadrant": 2}
    (made,) = read_readings(table, columns, "dipdir/dip").rows
    assert (made.azimuth_deg, made.inclination_deg) == (132.0, 41.0)
    (made,) = read_readings(table, columns, "strike/dip").rows or (None,)
    assert made is None or made.azimuth_deg == pytest.approx(312.0 - 90.0)


def test_lines_among_planes_are_recognised_per_row(book: Path) -> None:
    header = "element,dip direction,dip,trend,plunge\n"
    found = readings(book, header + "line,132,41,100,20\nplane,132,41,100,20\n,132,41,,\n,,,9,8\n")
    assert [(r.geometry, r.azimuth_deg, r.inclination_deg) for r in found.rows] == [
        ("line", 100.0, 20.0),
        ("plane", 132.0, 41.0),
        ("plane", 132.0, 41.0),
        ("line", 9.0, 8.0),
    ]
    found = readings(
        book, "element,orientation\nline,100/20\nLineation,5/6\n,132/41\n", "dipdir/dip"
    )
    assert [(r.geometry, r.azimuth_deg) for r in found.rows] == [
        ("line", 100.0),
        ("line", 5.0),
        ("plane", 132.0),
    ]


def test_all_values_of_a_row_are_kept(book: Path) -> None:
    found = readings(
        book,
        "name,type,set,overturned,notes,x,y,z,dip direction,dip\n"
        "a,Bedding,J1,Yes,wet,1,2,3,132,41\nb,,,no,,,,,120,30\nc,,,X,,4,5,-6,1,2\n",
    )
    assert found.rows == (
        FieldRow(2, "a", "plane", 132.0, 41.0, "Bedding", "J1", (1.0, 2.0, 3.0), True, "wet"),
        FieldRow(3, "b", "plane", 120.0, 30.0),
        FieldRow(4, "c", "plane", 1.0, 2.0, position=(4.0, 5.0, -6.0), overturned=True),
    )
    assert (found.bad_rows, found.findings, found.type_names) == ((), (), ("Bedding",))


@pytest.mark.parametrize("word", ["1", "true", "YES", "y", "x", "overturned", "Inverted"])
def test_words_for_overturned_beds_are_recognised(book: Path, word: str) -> None:
    (made,) = readings(book, f"dip direction,dip,overturned\n1,2,{word}\n").rows
    assert made.overturned


def _rows_of(found: FieldReadings) -> list[tuple[str, tuple[int, ...]]]:
    """Codes and lines of the findings."""
    return [(each.code, each.values["rows"]) for each in found.findings]


@pytest.mark.parametrize("place", ["1e13,2,3", "1,-1e13,3", "1,2,1e13"])
def test_position_outside_the_earth_is_left_out_and_reported(book: Path, place: str) -> None:
    header = "x,y,z,dip direction,dip\n"
    found = readings(book, f"{header}{place},1,2\n1,2,3,1,2\n1e12,-1e12,0,1,2\n")
    assert [r.position for r in found.rows] == [None, (1.0, 2.0, 3.0), (1e12, -1e12, 0.0)]
    assert _rows_of(found) == [("reading.no-position", (2,))]
    assert "1e+13" in found.findings[0].values["reason"]
    found = readings(book, f"{header}{place},1,2\n{place},1,2\n")
    assert _rows_of(found) == [("reading.no-position", (2, 3))]


@pytest.mark.parametrize("place", ["1,2,", "1,,3", ",2,3"])
def test_incomplete_position_is_left_out_and_reported(book: Path, place: str) -> None:
    header = "x,y,z,dip direction,dip\n"
    found = readings(book, f"{header}{place},1,2\n1,2,3,1,2\n1e12,-1e12,0,1,2\n")
    assert [r.position for r in found.rows] == [None, (1.0, 2.0, 3.0), (1e12, -1e12, 0.0)]
    assert _rows_of(found) == [("reading.coordinate-missing", (2,))]
    found = readings(book, f"{header}{place},1,2\n{place},1,2\n")
    assert _rows_of(found) == [("reading.coordinate-missing", (2, 3))]


def test_height_alone_is_not_an_incomplete_position(book: Path) -> None:
    found = readings(book, "x,y,z,dip direction,dip\n,,3,1,2\n")
    assert (found.rows[0].position, found.findings) == (None, ())


def test_degrees_are_converted_to_project_metres_or_reported_as_left_out(book: Path) -> None:
    text = "lon,lat,z,dip direction,dip\n15,46,350,1,2\n15,91,350,1,2\n15,-90,350,1,2\n,46,1,1,2\n"
    table = table_of(book, text)
    columns = guess(table).columns
    found = read_readings(table, columns, "dipdir/dip", lambda lon, lat: (lon * 10, lat * 100))
    assert [r.position for r in found.rows] == [
        (150.0, 4600.0, 350.0),
        None,
        (150.0, -9000.0, 350.0),
        None,
    ]
    assert _rows_of(found) == [
        ("reading.coordinate-missing", (5,)),
        ("reading.no-position", (3,)),
    ]
    assert "latitude 91 " in found.findings[1].values["reason"]
    found = read_readings(table, columns, "dipdir/dip", lambda *_: None)
    assert [r.position for r in found.rows] == [None] * 4
    found = read_readings(table, columns, "dipdir/dip")
    assert _rows_of(found)[0] == ("reading.degrees-without-crs", (2, 4, 5))
    assert "(lines 2, 4 and 5)" in str(found.findings[0])
    found = read_readings(
        table_of(book, "lon,lat,dip direction,dip\n15,46,1,2\n"),
        {"longitude": 0, "latitude": 1, "azimuth": 2, "inclination": 3},
        "dipdir/dip",
    )
    assert _rows_of(found) == [("reading.degrees-without-crs", (2,))]


def test_metres_take_precedence_over_degrees(book: Path) -> None:
    table = table_of(book, "x,y,z,lon,lat,a,b\n1,2,3,15,46,1,2\n,,3,15,46,1,2\n")
    roles_ = ("x", "y", "z", "longitude", "latitude", "azimuth", "inclination")
    columns = {role: number for number, role in enumerate(roles_)}
    found = read_readings(table, columns, "dipdir/dip", lambda lon, lat: (lon, lat))
    assert [r.position for r in found.rows] == [(1.0, 2.0, 3.0), (15.0, 46.0, 3.0)]


def test_row_of_another_width_is_bad_and_unknown_notation_raises(book: Path) -> None:
    table = table_of(book, "dip direction,dip\n1,2,3\n4,5\n")
    found = read_readings(table, guess(table).columns, "dipdir/dip")
    assert found.bad_rows == (BadRow(2, table.ragged_row_findings[0]),)
    assert [r.line for r in found.rows] == [3]
    with pytest.raises(ValueError, match="nonsense"):
        read_readings(table, {}, "nonsense")


# --- records -------------------------------------------------------------------------------------
def test_reading_is_rotated_and_keeps_all_values_of_its_row() -> None:
    rows = [
        FieldRow(1, "a", "plane", 355.0, 41.0, "DYKE", "J1", (1.0, 2.0, 3.0), True, "wet"),
        FieldRow(2, "b", "line", 10.0, 20.0),
    ]
    first, second = make_readings(
        rows, type_ids={"dyke": "t9"}, type_id="joint", set_name="all", turn_deg=7.5, source="b.csv"
    )
    assert (first.name, first.type_id, first.geometry) == ("a", "t9", "plane")
    assert (first.azimuth_deg, first.inclination_deg, first.turned_deg) == (2.5, 41.0, 7.5)
    assert (first.position, first.source, first.set_name) == ((1.0, 2.0, 3.0), "b.csv", "J1")
    assert (first.overturned, first.notes) == (True, "wet")
    assert (second.type_id, second.geometry, second.azimuth_deg) == ("joint", "line", 17.5)
    assert (second.set_name, second.position, second.overturned, second.notes) == (
        "all",
        None,
        False,
        "",
    )
    assert first.id != second.id


@pytest.mark.parametrize(
    ("geometry", "inclination", "turned"),
    [("plane", 0.0, 0.0), ("plane", 90.0, 15.0), ("line", 90.0, 0.0), ("line", 0.0, 15.0)],
)
def test_only_readings_with_an_azimuth_are_rotated(
    geometry: str, inclination: float, turned: float
) -> None:
    (made,) = make_readings(
        [FieldRow(1, "a", geometry, 10.0, inclination)], type_ids={}, type_id="t", turn_deg=5.0
    )
    assert made.azimuth_deg == turned
    assert Plane(made.azimuth_deg, made.inclination_deg) or True
