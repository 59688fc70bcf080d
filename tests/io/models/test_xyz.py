"""Points as text: columns by name and by value, decimals, damage."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import by_code, refused
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.io.models.formats import _common, xyz
from vomstudio.io.models.opening import read_model


def cloud_of(
    folder: Path, content: str | bytes, name: str = "a.xyz"
) -> tuple[PointCloud, dict[str, dict[str, Any]]]:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    loaded = read_model(path)
    assert isinstance(loaded.data, PointCloud)
    return loaded.data, by_code(loaded.warnings)


def test_columns_are_found_by_their_names_in_any_order(tmp_path: Path) -> None:
    cloud, findings = cloud_of(
        tmp_path,
        "Intensity,Z,Y [m],X,Nx,Ny,Nz,Red,Green,Blue,name\n"
        "7,3,2,1,0,0,1,255,0,128,a\n8,6,5,4,0,1,0,0,1,2,b\n",
        "a.csv",
    )
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[255, 0, 128], [0, 1, 2]]
    assert cloud.normals is not None
    assert cloud.normals.tolist() == [[0, 0, 1], [0, 1, 0]]
    assert list(cloud.fields) == ["Intensity"]
    assert cloud.fields["Intensity"].tolist() == [7, 8]
    assert findings["model.columns-left-out"] == {"columns": ("name",)}


def test_utm_coordinates_are_the_nearest_float64(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    points = rng.random((500, 3)) * 1000 + [576000, 5188000, 100]
    text = "\n".join(" ".join(map(repr, row)) for row in points.tolist())
    assert np.array_equal(cloud_of(tmp_path, text)[0].points, points)


@pytest.mark.parametrize(
    ("rows", "rgb", "normals", "fields"),
    [
        ("1 2 3 10 20 30\n4 5 6 200 0 0\n", [10, 20, 30], None, []),
        ("1 2 3 0.2 0.4 1.0\n4 5 6 0 0.5 0\n", [51, 102, 255], None, []),
        ("1 2 3 0 0.6 -0.8\n4 5 6 1 0 0\n", None, [0, 0.6, -0.8], []),
        ("1 2 3 -17.5 10 20 30\n4 5 6 3.5 4 5 6\n", [10, 20, 30], None, ["column 4"]),
        ("1 2 3 10 20 30 0 0 1\n4 5 6 7 8 9 0 1 0\n", [10, 20, 30], [0, 0, 1], []),
        ("1 2 3 0.5\n4 5 6 0.7\n", None, None, ["column 4"]),
        ("2\n1 2 3 5 10 20 30\n4 5 6 -5 4 5 6\n", [10, 20, 30], None, ["column 4"]),
    ],
)
def test_unnamed_columns_are_identified_by_their_values(
    tmp_path: Path, rows: str, rgb: object, normals: object, fields: list[str]
) -> None:
    cloud, findings = cloud_of(tmp_path, rows, "a.pts")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert (None if cloud.colors is None else cloud.colors[0].tolist()) == rgb
    found = None if cloud.normals is None else cloud.normals[0].tolist()
    assert found == (None if normals is None else pytest.approx(normals))
    assert list(cloud.fields) == fields
    assert ("model.columns-as-colors" in findings) == (rgb is not None)
    assert ("model.columns-as-normals" in findings) == (normals is not None)


@pytest.mark.parametrize(
    "content",
    [
        b"// X Y Z\n1.5 2 3\n4 5 6\n",
        b"# a comment\n# x y z\n1.5 2 3\n\n4 5 6\n",
        b"x;y;z\n1,5;2;3\n4;5;6\n",
        b"\xef\xbb\xbfx\ty\tz\r\n1.5\t2\t3\r\n4\t5\t6",
        "x,y,z\n1.5,2,3\n4,5,6\n".encode("utf-16"),
        b"easting,northing,elevation\r1.5,2,3\r4,5,6\r",
        b'"x","y","z"\n"1.5","2","3"\n"4","5","6"\n',
        b"  1.5   2 3\n 4 5    6\n",
    ],
)
def test_common_point_formats_are_read(tmp_path: Path, content: bytes) -> None:
    cloud, findings = cloud_of(tmp_path, content)
    assert cloud.points.tolist() == [[1.5, 2, 3], [4, 5, 6]]
    assert findings == {}


def test_rows_without_coordinates_are_left_out_and_counted(tmp_path: Path) -> None:
    cloud, findings = cloud_of(tmp_path, "x,y,z\n1,2,3\n,5,6\nnan,1,1\n1e99,0,0\n7,8,9\n", "a.csv")
    assert cloud.points.tolist() == [[1, 2, 3], [7, 8, 9]]
    assert findings["model.points-invalid"] == {"count": 3}


@pytest.mark.parametrize(
    ("content", "code", "values"),
    [
        ("x,y,z\n1,2,3\n4,five,6\n", "table.not-a-number", {"line": 3, "cell": "five"}),
        ("1 2 3\n4 5 6 7\n8 9 10\n", "table.ragged-row", {"line": 2}),
        ("x,y\n1,2\n", "table.missing-column", {"column": "z"}),
        ("1 2\n3 4\n", "table.column-count", {"count": 2}),
        ("x,y,z\n", "table.no-rows", {"line": 1}),
        ("# nothing\n", "table.no-rows", {}),
        ("\0\1\2\3", "file.other-kind", {"kind": "binary"}),
        ("x y z\nnan nan nan\n", "model.no-points", {}),
    ],
)
def test_file_that_is_not_a_point_table_is_rejected_with_location(
    tmp_path: Path, content: str, code: str, values: dict[str, object]
) -> None:
    with refused(code, file=tmp_path / "a.xyz", **values):
        cloud_of(tmp_path, content)


def test_damaged_table_gives_points_or_input_error(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    rows = rng.random((40, 6)).round(4)
    content = ("x y z r g b\n" + "\n".join(" ".join(map(str, r)) for r in rows.tolist())).encode()
    for i in range(200):
        bad = bytearray(content[: rng.integers(1, len(content))])
        for at in rng.integers(0, len(bad), 3):
            bad[at] = rng.integers(0, 256)
        try:
            cloud_of(tmp_path, bytes(bad), f"{i % 2}.xyz")
        except InputError:
            continue


def layout(delimiter: str, decimal: str, width: int) -> xyz.Layout:
    return xyz.Layout(delimiter, decimal, None, 0, 0, width, [])


WHOLE = st.integers(-(10**12), 10**12).map(str)
FRACTION = st.tuples(st.integers(-(10**5) + 1, 10**6 - 1), st.integers(0, 10**7 - 1)).map(
    lambda parts: f"{parts[0]}.{parts[1]:07d}"
)


@given(
    columns=st.lists(
        st.sampled_from([WHOLE, FRACTION, st.one_of(WHOLE, FRACTION)]).flatmap(
            lambda cells: st.lists(cells, min_size=4, max_size=4)
        ),
        min_size=3,
        max_size=6,
    ),
    delimiter=st.sampled_from([" ", ",", ";", "\t"]),
    end=st.sampled_from(["\n", "\r\n"]),
)
def test_small_table_parser_matches_pandas_bit_for_bit(
    columns: list[list[str]], delimiter: str, end: str
) -> None:
    rows = [delimiter.join(cells) + end for cells in zip(*columns, strict=True)]
    found = xyz.parse_plain_numbers("".join(rows).encode(), layout(delimiter, ".", len(columns)))
    assert found is not None
    for i, cells in enumerate(columns):
        wanted = pandas.read_csv(io.StringIO("\n".join(cells)), header=None)[0].to_numpy()
        assert found[i].dtype == wanted.dtype
        assert found[i].tobytes() == wanted.tobytes()


def test_decimal_comma_is_parsed() -> None:
    found = xyz.parse_plain_numbers(b"1,5;2;-0,25\n", layout(";", ",", 3))
    assert found is not None
    assert [found[i].tolist() for i in range(3)] == [[1.5], [2], [-0.25]]


@pytest.mark.parametrize(
    "content",
    [
        b"1 2\n",
        b"1 2 3 4\n",
        b"1 2 3\n\n4 5 6\n",
        b"1 2 nan\n",
        b"1 2 3e2\n",
        b"1 2 # 3\n",
        b"007 2 3\n",
        b"1 2 0.12345678901234567\n",
        b"1 2 1234567890123456\n",
        b"1 2 +3\n",
        b"",
        b"1\x0b2 3 4\n",
        "1 2 ٣\n".encode(),
        b"1 2 '3'\n",
    ],
)
def test_complex_tables_are_left_to_pandas(content: bytes) -> None:
    assert xyz.parse_plain_numbers(content, layout(" ", ".", 3)) is None


@pytest.mark.parametrize("head", ["ncols 3\nnrows 2\n", "NCOLS        3\r\nNROWS        2\r\n"])
def test_height_grid_is_recognized_and_rejected(tmp_path: Path, head: str) -> None:
    """Its header was taken for names of columns, and its heights could be for coordinates."""
    path = tmp_path / "dem.asc"
    path.write_bytes(
        (head + "xllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9\n1 2 3\n4 5 6\n").encode()
    )
    with refused("file.other-kind", kind="esri-grid"):
        read_model(path)


@pytest.mark.parametrize("name", ["a.tsv", "a.TSV", "a.dat", "a.tab", "a.prn"])
def test_tab_separated_cloud_is_read_with_any_table_extension(tmp_path, name):
    (tmp_path / name).write_text("x\ty\tz\n1,5\t2\t3\n4\t5\t6\n")
    assert read_model(tmp_path / name).data.points.tolist() == [[1.5, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    "content",
    [
        "x,y,z\n1,5,0,0\n1,2,0\n2,1,0\n",  # a decimal comma between commas
        "x,y,z\n1,5,0,9\n1,2,0,9\n",
        "x,y,z,a\n1,2,0,4\n1,5,0\n2,1,0,3\n",
        "x,y,z\n1,2,0\n1,5\n2,1,0\n",
        "1,5,0,0\n1,2,0\n2,1,0\n",
        "1 5 0 0\n1 2 0\n2 1 0\n",
        "x y z\n1 5 0 0\n1 2 0\n",
        "x;y;z\n1;5;0\n# a comment; with; many; parts\n\n1;2\n2;1;0\n",
        "x,y,z,a\n" + "1,2,3,4\n" * 20_000 + "1,5,0\n",
    ],
)
def test_ragged_rows_are_rejected(tmp_path: Path, content: str) -> None:
    with refused("table.ragged-row"):
        cloud_of(tmp_path, content)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_empty_trailing_cells_do_not_make_a_row_ragged(tmp_path: Path, end: str) -> None:
    rows = ["x,y,z,a", "1,2,0,4", "1,5,0,", "# said, by, the, way, often", "", "2,1,0,3", "7,7,7,"]
    cloud, _ = cloud_of(tmp_path, end.join(rows) + end)
    assert cloud.points.tolist() == [[1, 2, 0], [1, 5, 0], [2, 1, 0], [7, 7, 7]]
    assert np.isnan(cloud.fields["a"]).tolist() == [False, True, False, True]


def test_trailing_delimiter_does_not_add_a_column(tmp_path: Path) -> None:
    cloud, findings = cloud_of(tmp_path, "x,y,z\n1,2,0,\n1,5,0,\n")
    assert (cloud.points.tolist(), findings) == ([[1, 2, 0], [1, 5, 0]], {})


@pytest.fixture(params=[1, 2, 3, 100])
def in_pieces(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables are read, and colours scaled, so many rows at once."""
    monkeypatch.setattr(xyz, "FEW_BYTES", 0)
    for module in (xyz, _common):
        monkeypatch.setattr(module, "BLOCK_ROWS", request.param)


@pytest.mark.usefixtures("in_pieces")
def test_blockwise_read_matches_whole_table_read(tmp_path: Path) -> None:
    """Whole numbers that become others, gaps and words come in pieces of their own; a row of
    dark colours does not say that they go to 1."""
    rows = [
        "X,Y,Z,R,G,B,whole,later,gap,large,word,yes",
        "1,2,3,1,0,1,1,1,1,1,1,True",
        "4,5,6,10,20,30,2,2,,9007199254740993,2,False",
        "7.25,8,9,200,23,255,3,3.5,3,3,a,3",
        "10,11.5,12,0,1,0,4,4,4,4,4,True",
    ]
    cloud, findings = cloud_of(tmp_path, "\n".join(rows) + "\n", "a.csv")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6], [7.25, 8, 9], [10, 11.5, 12]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[1, 0, 1], [10, 20, 30], [200, 23, 255], [0, 1, 0]]
    assert list(cloud.fields) == ["whole", "later", "gap", "large"]
    assert cloud.fields["whole"].dtype.kind == "i"
    assert cloud.fields["later"].tolist() == [1, 2, 3.5, 4]
    assert np.isnan(cloud.fields["gap"][1])
    assert cloud.fields["gap"][[0, 2, 3]].tolist() == [1, 3, 4]
    assert cloud.fields["large"].tolist() == [1, 9007199254740993, 3, 4]
    assert findings["model.columns-left-out"] == {"columns": ("word", "yes")}


@pytest.mark.usefixtures("in_pieces")
def test_row_with_too_many_cells_is_rejected_in_any_block(tmp_path: Path) -> None:
    rows = ["1 2 3"] * 20
    rows[13] = "1 2 3 4"
    with refused("table.ragged-row", count=4):
        cloud_of(tmp_path, "\n".join(rows) + "\n")


@pytest.mark.usefixtures("in_pieces")
def test_reading_a_table_can_be_cancelled_between_blocks(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("1.5 2.5 3.5\n" * 1_000)
    token = CancelToken()
    steps: list[int] = []

    class Watching(SilentProgress):
        def step(self, done: int) -> None:
            super().step(done)
            steps.append(done)
            if len(steps) > 5:
                token.cancel()

    with pytest.raises(Cancelled):
        xyz.read(path, Watching(token))
