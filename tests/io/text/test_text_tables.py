"""Text tables as people have them: what is understood, what is refused, and by which words."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.messages import refused
from vomstudio.cli import main
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.spreadsheet_cells import unescape_formula
from vomstudio.io.text.column_names import normalise_name
from vomstudio.io.text.tables import PointGroups, read_points, read_table

TRIANGLE = np.array([[1.5, 2.0, 3.0], [4.0, 5.25, 6.0], [7.0, 8.0, -9.5]])


@pytest.fixture
def table(tmp_path: Path):  # type: ignore[no-untyped-def]
    def write(content: str | bytes, name: str = "points.txt") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def refusal_of(path: Path, by: str | None = None) -> InputError | UsageError:
    with pytest.raises((InputError, UsageError)) as caught:
        read_points(path, by)
    assert caught.value.file == str(path)
    assert "\n" not in str(caught.value)
    return caught.value


# ------------------------------------------------------------------------- what is understood


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " ", "   ", ", ", " \t "])
@pytest.mark.parametrize("header", ["", "x{0}y{0}z\n"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_every_delimiter_header_and_line_end_gives_the_same_points(
    table, delimiter: str, header: str, end: str
) -> None:
    rows = "".join(delimiter.join(f"{v:g}" for v in row) + "\n" for row in TRIANGLE)
    text = (header.format(delimiter) + rows).replace("\n", end)
    groups = read_points(table(text))
    np.testing.assert_array_equal(groups.points, TRIANGLE)
    assert groups.ids == ("1",)
    assert groups.warnings == ()


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_comma_is_parsed_with_semicolon_or_tab(table, delimiter: str) -> None:
    text = "\n".join(delimiter.join(f"{v:g}".replace(".", ",") for v in row) for row in TRIANGLE)
    np.testing.assert_array_equal(read_points(table(text)).points, TRIANGLE)


def test_decimal_commas_with_space_delimiter_are_rejected(table) -> None:
    error = refusal_of(table("1,5 2,0 3,0\n4,0 5,2 6,0\n7,0 8,0 9,0\n"))
    assert (error.line, error.code) == (1, "table.comma-delimiter")


def test_mixed_decimal_marks_in_one_column_are_rejected(table) -> None:
    error = refusal_of(table("1,5;2;3\n4,5;5;6\n1.234;8;9\n"))
    assert (error.line, error.field) == (3, "column 1")


def test_comments_and_blank_lines_are_skipped_and_counted_as_lines(table) -> None:
    path = table("# EPSG:32615\n\n1 2 3\n  # between\n4 5 6\n\n7 8 nine\n")
    error = refusal_of(path)
    assert (error.line, error.field) == (7, "column 3")
    assert (error.code, error.values) == ("table.not-a-number", {"cell": "nine"})
    assert read_table(path).comments == ("EPSG:32615", "between")


def test_the_first_row_is_a_header_only_if_a_cell_is_not_a_number(table) -> None:
    assert read_table(table("1,2,3\n4,5,6\n")).names is None
    assert read_table(table("1,2,c\n4,5,6\n")).names == ("1", "2", "c")
    assert read_table(table("nan,2,3\n4,5,6\n")).names is None
    assert read_table(table("1e3,-2.5E+2,.5\n4,5,6\n")).names is None


@pytest.mark.parametrize(
    "header",
    [
        "X,Y,Z",
        "x (m),y (m),z (m)",
        "easting,northing,elevation",
        "//X,Y,Z",
        "East,North,Up",
        "x_m,y_m,z_m",
        " x , y , z ",
        '"x","y","z"',
        "E,N,Height",
    ],
)
def test_coordinates_are_found_under_their_usual_names(table, header: str) -> None:
    rows = "\n".join(",".join(f"{v:g}" for v in row) for row in TRIANGLE)
    np.testing.assert_array_equal(read_points(table(f"{header}\n{rows}\n")).points, TRIANGLE)


def test_named_columns_may_be_in_any_order(table) -> None:
    path = table("id;z;quality;x;y\na;3;good;1;2\n")
    np.testing.assert_array_equal(read_points(path).points, [[1.0, 2.0, 3.0]])


def test_byte_order_mark_is_not_part_of_the_first_name(table) -> None:
    path = table("\ufeffx,y,z\n1,2,3\n".encode())
    assert read_table(path).names == ("x", "y", "z")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8"])
def test_group_names_in_any_script_are_kept(table, encoding: str) -> None:
    path = table("x\ty\tz\tträce\n1\t2\t3\t層\n4\t5\t6\tГеология\n".encode(encoding))
    assert read_points(path, "träce").ids == ("層", "Геология")


def test_non_utf8_text_is_read_as_windows_1252_and_reported(table) -> None:
    groups = read_points(table("x;y;z;Störung\n1;2;3;a\n".encode("cp1252")), "Störung")
    assert groups.ids == ("a",)
    assert groups.warnings[0].values == {"encoding": "Windows-1252"}


def test_quoted_cells_may_contain_delimiters_quotes_and_line_ends(table) -> None:
    path = table('x,y,z,trace\n1,2,3,"a, ""b"""\n# no\n4,5,6,"c\n# d"\n7,8,nine,e\n')
    error = refusal_of(path, "trace")
    assert (error.line, error.field) == (6, "z")
    path = table('x,y,z,trace\n1,2,3,"a, ""b"""\n# no\n4,5,6,"c\n# d"\n')
    assert read_points(path, "trace").ids == ('a, "b"', "c\n# d")


def test_unclosed_quote_is_rejected_with_its_line(table) -> None:
    assert refusal_of(table('x,y,z,t\n1,2,3,"a\n4,5,6,b\n'), "t").line == 2


def test_trailing_spreadsheet_delimiters_are_ignored(table) -> None:
    path = table("1,2,3\n4,5,6,,,\n,,,\n7,8,9,\n")
    assert read_points(path).points.shape == (3, 3)


def test_trailing_end_of_file_mark_is_ignored(table) -> None:
    assert read_points(table("1,2,3\n4,5,6\n\x1a")).points.shape == (2, 3)


def test_fortran_exponents_are_numbers(table) -> None:
    path = table("1.0D+3 2.0d0 3\n")
    np.testing.assert_array_equal(read_points(path).points, [[1000.0, 2.0, 3.0]])


def test_nan_rows_are_dropped_and_counted_by_line(table) -> None:
    groups = read_points(table("x,y,z\n1,2,3\nnan,1,1\n4,,6\n7,8,9\n1,2,inf\n1,NA,3\n"))
    assert groups.dropped == (3, 4, 6, 7)
    assert groups.points.shape == (2, 3)
    assert groups.warnings[0].code == "table.rows-left-out"
    assert groups.warnings[0].values["lines"] == (3, 4, 6, 7)


def test_table_with_only_nan_rows_is_rejected(table) -> None:
    assert refusal_of(table("nan nan nan\nnan 1 2\n")).code == "table.no-valid-rows"


# ------------------------------------------------------------------------------------- groups


def test_groups_keep_the_order_of_the_file(table) -> None:
    path = table("x,y,z,trace\n1,0,0,b\n2,0,0,a\n3,0,0,b\n4,0,0,c\n5,0,0,a\n")
    groups = read_points(path, "trace")
    assert groups.ids == ("b", "a", "c")
    assert groups.offsets.tolist() == [0, 2, 4, 5]
    assert groups.points[:, 0].tolist() == [1, 3, 2, 5, 4]


@pytest.mark.parametrize("key", ["4", "Trace Id", "trace_id", "TRACE ID"])
def test_a_column_is_found_by_name_or_number(table, key: str) -> None:
    assert read_points(table("x,y,z,trace id\n1,2,3,a\n"), key).ids == ("a",)


def test_column_name_takes_precedence_over_column_number(table) -> None:
    assert read_points(table("x,y,z,1\n5,2,3,a\n"), "1").ids == ("a",)


def test_a_table_without_header_is_grouped_by_number_only(table) -> None:
    path = table("1 2 3 7\n4 5 6 7\n7 8 9 8\n")
    assert read_points(path, "4").ids == ("7", "8")
    for name in ("trace", "9"):
        error = refusal_of(path, name)
        assert error.code == "table.unknown-column"
        assert len(error.values["columns"]) == 4


def test_missing_column_is_rejected_with_the_available_columns(table) -> None:
    error = refusal_of(table("x,y,z,bed\n1,2,3,a\n"), "trace")
    assert error.field == "trace"
    assert error.values["columns"] == ("x", "y", "z", "bed")


def test_points_without_group_are_skipped_and_reported(table) -> None:
    groups = read_points(table("x,y,z,trace\n1,2,3,a\n1,2,3,\n1,2,3,a\n"), "trace")
    assert groups.offsets.tolist() == [0, 2]
    assert groups.warnings[0].values["lines"] == (3,)


def test_group_without_valid_coordinates_stays_as_empty_group(table) -> None:
    groups = read_points(table("x,y,z,t\n1,2,3,a\nnan,1,1,b\n"), "t")
    assert groups.ids == ("a", "b")
    assert groups.offsets.tolist() == [0, 1, 1]


@pytest.mark.parametrize(
    "text",
    ["x,y,z,trace\n" + "1,2,3,a\n" * 3 + "1,2,3,b\n" * 3, "1 2 3 1\n" * 3 + "1 2 3 2\n" * 3],
)
def test_column_resembling_groups_is_reported_and_not_used(table, text: str) -> None:
    groups = read_points(table(text))
    assert groups.ids == ("1",)
    assert groups.warnings[0].code == "table.groups"


def test_colours_beside_the_points_do_not_look_like_groups(table) -> None:
    rng = np.random.default_rng(1)
    rows = "\n".join(f"1 2 3 {r} {g} {b}" for r, g, b in rng.integers(0, 255, (60, 3)))
    assert read_points(table(rows)).warnings == ()


def test_separator_lines_split_points_only_on_request(table) -> None:
    path = table("1 2 3\n4 5 6\n---\n7 8 9\n")
    whole = read_points(path)
    assert whole.ids == ("1",)
    assert whole.points.shape == (3, 3)
    assert whole.warnings[0].code == "table.segments"
    parts = read_points(path, "segment")
    assert parts.ids == ("1", "2")
    assert parts.offsets.tolist() == [0, 2, 3]


# ------------------------------------------------------------------------------------ refusals


@pytest.mark.parametrize(
    ("content", "line", "code", "value"),
    [
        (b"", None, "file.empty", None),
        (b" \n\n", None, "file.empty", None),
        (b"# only\n# comments\n", None, "table.no-rows", None),
        (b"x,y,z\n", 1, "table.no-rows", None),
        (b"\xff\xfe1\x00 ", None, "file.damaged", "UTF-16"),
        (b"1 2\n3 4\n", 1, "table.column-count", 2),
        (b"1\n2\n3\n", 1, "table.column-count", 1),
        (b"1 2 3\n4 5\n6 7 8\n", 2, "table.ragged-row", 2),
        (b"1 2 3\n4 5 6\n6 7 8 9\n", 3, "table.ragged-row", 4),
        (b"x,y,z\n1,2,3\n4,5\n", 3, "table.ragged-row", 2),
        (b"x,y,z\n1,2,3\n4;5;6\n", 3, "table.ragged-row", 1),
        (b"a,b,c\n1,2,3\n", 1, "table.missing-column", "x"),
        (b"x,y\n1,2\n", 1, "table.missing-column", "z"),
        (b"x,x,y,z\n1,2,3,4\n", 1, "table.repeated-column", "x"),
        (b"x,y,z\n1,2,3\n4,five,6\n", 3, "table.not-a-number", "five"),
        (b"x,y,z\n1,2,0x10\n", 2, "table.not-a-number", "0x10"),
        (b"x,y,z\n1,2,1_000\n", 2, "table.not-a-number", "1_000"),
        (b"1 2 3\n4 5 6,5\n", 2, "table.comma-delimiter", None),
        (b"1 2 3\n4 1e308 6\n", 2, "coordinate.out-of-range", 1e308),
    ],
)
def test_file_that_is_not_a_point_table_is_rejected_with_line_and_reason(
    table, content: bytes, line: int | None, code: str, value: object
) -> None:
    error = refusal_of(table(content))
    assert (error.code, error.line) == (code, line)
    assert value is None or value in error.values.values()


def test_missing_file_is_reported(tmp_path: Path) -> None:
    assert refusal_of(tmp_path / "missing.txt").code == "file.missing"


def test_folder_is_rejected(tmp_path: Path) -> None:
    assert refusal_of(tmp_path).code == "file.is-folder"


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no devices here")
def test_an_endless_device_is_not_read() -> None:
    assert refusal_of(Path("/dev/zero")).code == "file.not-regular"


def test_file_name_with_null_byte_is_rejected() -> None:
    with pytest.raises(InputError):
        read_table("a\0b")


def test_very_long_line_is_rejected(table) -> None:
    error = refusal_of(table("1 2 3\n" + "4 " * 1_000_000 + "\n"))
    assert error.line == 2


def test_very_long_quoted_cell_is_rejected(table) -> None:
    error = refusal_of(table('x,y,z,t\n1,2,3,"' + "a" * 500_000 + '"\n'), "t")
    assert error.line == 2


def test_empty_group_column_is_rejected(table) -> None:
    assert refusal_of(table("x,y,z,t\n1,2,3,\n"), "t").field == "t"


# --------------------------------------------------------------------------------- laws, speed

cells = st.floats(-1e12, 1e12)


@settings(max_examples=60, deadline=None)
@given(
    rows=st.lists(st.tuples(cells, cells, cells), min_size=1, max_size=12),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
)
def test_numbers_round_trip_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory,
    rows: list[tuple[float, float, float]],
    delimiter: str,
) -> None:
    path = tmp_path_factory.mktemp("t") / "p.txt"
    path.write_text("\n".join(delimiter.join(map(repr, row)) for row in rows))
    np.testing.assert_array_equal(read_points(path).points, np.array(rows))


words = st.text(
    st.characters(blacklist_categories=("Cs", "Cc")) | st.sampled_from(',;"\t #'),
    min_size=1,
    max_size=8,
).filter(lambda w: w.strip() == w and w != "")


@settings(max_examples=60, deadline=None)
@given(names=st.lists(words, min_size=1, max_size=8, unique=True))
def test_any_group_name_written_by_the_csv_module_round_trips(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    # An apostrophe before a sign is how tables keep spreadsheets from evaluating a name.
    assume(all(unescape_formula(name) == name for name in names))
    buffer = io.StringIO()
    writer = csv.writer(buffer, quoting=csv.QUOTE_ALL)
    writer.writerow(["x", "y", "z", "trace"])
    for i, name in enumerate(names):
        writer.writerow([i, 0, 0, name])
    path = tmp_path_factory.mktemp("t") / "p.csv"
    path.write_text(buffer.getvalue(), encoding="utf-8", newline="")
    assert read_points(path, "trace").ids == tuple(names)


def read_or_refused(path: Path, by: str | None = None) -> PointGroups | None:
    """What comes of any file: points, or an error that names it; any other exception escapes."""
    try:
        return read_points(path, by)
    except (InputError, UsageError) as error:
        named = error.file
    assert named == str(path)
    return None


@settings(max_examples=150, deadline=None)
@given(content=st.binary(max_size=200))
def test_arbitrary_bytes_are_read_or_rejected_by_name(
    tmp_path_factory: pytest.TempPathFactory, content: bytes
) -> None:
    path = tmp_path_factory.mktemp("t") / "p.txt"
    path.write_bytes(content)
    read_or_refused(path)


@settings(max_examples=150, deadline=None)
@given(
    content=st.text('0123456789.,;-+e \t\n"#xyzN>', max_size=80), by=st.sampled_from([None, "4"])
)
def test_table_like_text_is_read_or_rejected_by_name(
    tmp_path_factory: pytest.TempPathFactory, content: str, by: str | None
) -> None:
    path = tmp_path_factory.mktemp("t") / "p.txt"
    path.write_text(content)
    groups = read_or_refused(path, by)
    if groups is not None:
        assert groups.offsets[-1] == len(groups.points)
        assert len(groups.offsets) == len(groups.ids) + 1


@pytest.mark.parametrize(
    ("name", "same"),
    [
        ("Dip direction (deg)", "dipdirection"),
        ("DIP_DIRECTION_DEG", "dipdirection"),
        ("Dip-Dir [°]", "dipdir"),
        ("x_m", "x"),
        ("dip, degrees", "dip"),
        ("m", "m"),
    ],
)
def test_case_separators_and_units_in_column_names_are_ignored(name: str, same: str) -> None:
    assert normalise_name(name) == same


def test_scientific_notation_labels_become_integers(table) -> None:
    rows = np.column_stack([np.vstack([TRIANGLE, TRIANGLE + 1]), [1, 1, 1, 20, 20, 20]])
    path = table("")
    np.savetxt(path, rows)
    assert read_points(path, "4").ids == ("1", "20")
    names = "\n".join(f"{x},{y},{z},12E4" for x, y, z in TRIANGLE)
    assert read_points(table(f"x,y,z,sample\n{names}"), "sample").ids == ("12E4",)


@pytest.mark.parametrize(
    ("content", "command", "line"),
    [
        ("A 1 2 3\nB 2 3 5\nC 4 4 1\nD 7 1 2\n", "fit {t}", 1),
        ("# survey\nA,1,2,3\nB,2,3,5\nC,4,4,1\n", "threepoint {t}", 2),
        ("A;1,5;2;3\nB;2;3;5\nC;4;4;1\n", "log {t} --bed 90/30", 1),
        ("A,45,30\nB,50,33\n", "stats {t}", 1),
        ("A,45,30\nB,50,33\n", "fit {t} --by trace", 1),
        ("A,45,30,20,N\nB,50,33,2,R\n", "slip {t}", 1),
    ],
)
def test_data_row_taken_for_a_header_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str, command: str, line: int
) -> None:
    path = tmp_path / "t.csv"
    path.write_text(content)
    assert main([*command.format(t=path).split(), "--json"]) == 2
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["code"] == "table.doubtful-header"
    assert (error["header_line"], error["cell"]) == (line, "A")
    # Of a header of words alone there is no doubt.
    path.write_text("name,colour,size\nA,2,3\nB,3,4\nC,5,6\n")
    assert main([*command.format(t=path).split(), "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["error"]["code"] != "table.doubtful-header"


@pytest.mark.parametrize("first", ["sep=;", "SEP=;", '"sep=;"', "\ufeffsep=;"])
def test_excel_sep_line_is_not_a_row(tmp_path: Path, first: str) -> None:
    path = tmp_path / "t.csv"
    path.write_text(f"{first}\nstrike;dip\n30,5;45\n31;44\n", encoding="utf-8")
    table = read_table(path)
    assert table.names == ("strike", "dip")
    assert table.numbers([0, 1]).tolist() == [[30.5, 45.0], [31.0, 44.0]]
    assert table.line_numbers.tolist() == [3, 4]
    path.write_text("sep=\\t\na\tb\n1\t2\n", encoding="utf-8")
    assert read_table(path).names == ("a", "b")


# ------------------------------------------------------------------------- very many rows


@pytest.fixture(scope="module")
def sound() -> dict[str, dict[str, bytes]]:
    from tests.fuzz.kinds import seeds

    return seeds()


def of_many(kind: str, lines: int, files: dict[str, bytes], folder: Path) -> Path:
    """The sound file of a kind, with its last row again and again."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
    data = files[kind]
    rows = data.splitlines(keepends=True)
    (folder / kind).write_bytes(data + rows[-1] * (lines - len(rows)))
    return folder / kind


@pytest.mark.parametrize(
    "kind",
    [
        "t.csv",
        "field.csv",
        "slips.txt",
        "log.csv",
        "geo.txt",
        "positions.csv",
        "pairs.csv",
        "bars.csv",
        "levels.csv",
        "compass.csv",
        "attitudes.csv",
        "centres.csv",
        "marks.csv",
        "control.csv",
        "stations.csv",
    ],
)
def test_excessive_row_count_is_rejected(
    kind: str, sound: dict[str, dict[str, bytes]], tmp_path: Path
) -> None:
    from tests.fuzz.kinds import READERS

    path = of_many(kind, 300_010, sound[kind], tmp_path)
    with refused("table.too-many-rows", limit=300000) as caught:
        READERS[kind][1](path)
    assert caught.value.file == str(path)


def test_numeric_tables_may_have_more_rows(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y,z\n" + "1,2,3\n" * 400_000)
    assert len(read_points(path).points) == 400_000
    path.write_text("x,y,z\n" + "1,2,3\n" * 2_000_001)
    with refused("table.too-many-rows", count=2000002, limit=2000000):
        read_points(path)


def test_tables_with_quoted_cells_may_have_fewer_rows(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("x,y,z,pick\n" + '1,2,3,"a"\n' * 1_000_000)
    with refused("table.too-many-rows", count=1000001, limit=1000000):
        read_points(path)


def test_rows_between_comments_and_separators_keep_their_line_numbers(tmp_path: Path) -> None:
    path = tmp_path / "mixed.csv"
    path.write_text("# head\n\nid,x,y,z\na,1,2,3\n---\nb,4,5,6\n-7,1,2,3\n\n# end\nc,7,8,9")
    table = read_table(path)
    assert table.line_numbers.tolist() == [4, 6, 7, 10]
    assert table.separators == (5,)
    assert table.cells(0) == ["a", "b", "-7", "c"]
    assert table.cells(3, 2) == ["3", "6"]


@settings(deadline=None, max_examples=60)
@given(
    cells=st.lists(st.sampled_from(["a", "b", "ä", "ab", "1.000000e+00", "1", "", " a "])),
    column=st.integers(0, 2),
    delimiter=st.sampled_from(",;\t "),
    quoted=st.booleans(),
)
def test_label_codes_match_labels_of_single_cells(
    cells: list[str], column: int, delimiter: str, quoted: bool
) -> None:
    import tempfile

    if delimiter == " ":
        cells = [cell.strip() or "a" for cell in cells]
    rows = [["0.5", "7"] for _ in cells]
    for row, cell in zip(rows, cells, strict=True):
        row.insert(column, f'"{cell}"' if quoted else cell)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "table.csv")
        lines = [["u", "v", "w"], ["0", "0", "0"], *rows]
        path.write_text("".join(delimiter.join(row) + "\n" for row in lines), encoding="utf-8")
        result = read_table(path)
    names, codes = result.label_codes(column)
    labels = result.labels(column)
    assert [names[code] for code in codes] == labels
    assert names == list(dict.fromkeys(labels))
