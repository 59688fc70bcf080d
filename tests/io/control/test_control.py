"""Tables of control points and of their marks."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.io.control.control_files import agreed_crs, read_control, read_crs, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_control, write_marks
from vomstudio.io.gis.crs import parse_crs


def written(folder: Path, text: str) -> Path:
    path = folder / "table.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_points_are_read_with_their_error_and_use(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "label,x,y,z,sigma,use\nA,500000.25,5000000.5,120,0.01,control\n7,1,2,3,,check\n"
        "C,4,5,6,0.02,\n",
    )
    assert read_control(path) == [
        ControlPoint("A", (500000.25, 5000000.5, 120.0), 0.01),
        ControlPoint("7", (1.0, 2.0, 3.0), None, True),
        ControlPoint("C", (4.0, 5.0, 6.0), 0.02),
    ]


def test_error_and_use_are_optional_and_semicolons_are_accepted(tmp_path: Path) -> None:
    path = written(tmp_path, "Label;X;Y;Z\nA;1,5;2;3\nB;2;2;3\n")
    assert read_control(path)[0] == ControlPoint("A", (1.5, 2.0, 3.0))


@pytest.mark.parametrize(
    "header",
    [
        "#Label,X/Easting,Y/Northing,Z/Altitude,Accuracy_X,Accuracy_Y,Accuracy_Z\n",
        "#Label\tX/Easting\tY/Northing\tZ/Altitude\tAccuracy_X\tAccuracy_Y\tAccuracy_Z\n",
        "# exported\n# marker  east  north  height  sx  sy  sz\n",
        "Point ID;Easting (m);Northing (m);Elevation (m);sigma_e;sigma_n;sigma_h\n",
    ],
)
def test_column_names_of_other_programs_are_accepted(tmp_path: Path, header: str) -> None:
    between = "\t" if "\t" in header else ";" if ";" in header else " " if "  " in header else ","
    rows = [("T1", 1, 2, 3, 0.03, 0.03, 0.03), ("T2", 4, 5, 6, 0.03, 0.04, 0.05)]
    text = header + "".join(between.join(map(str, row)) + "\n" for row in rows)
    first, second = read_control(written(tmp_path, text))
    assert first == ControlPoint("T1", (1.0, 2.0, 3.0), 0.03)
    assert second.position == (4.0, 5.0, 6.0)
    assert second.sigma_m == pytest.approx((0.005 / 3) ** 0.5)


def test_points_without_header_use_default_column_order(tmp_path: Path) -> None:
    assert read_control(written(tmp_path, "T1 1.5 2 3\nT2 4 5 6\n")) == [
        ControlPoint("T1", (1.5, 2.0, 3.0)),
        ControlPoint("T2", (4.0, 5.0, 6.0)),
    ]


def test_marks_are_read(tmp_path: Path) -> None:
    path = written(tmp_path, "label,photo,x,y\nA,images\\one.jpg,10.5,20\nA,two.jpg,1,2\n")
    assert read_marks(path) == [
        Mark("A", "images/one.jpg", 10.5, 20.0),
        Mark("A", "two.jpg", 1.0, 2.0),
    ]


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        ("label,x,y\nA,1,2\n", "table.missing-column", {"column": "z"}),
        ("1,2,3\n5,6,7\n", "table.no-header", {}),
        ("label,x,y,z\nA,1,2,\n", "table.value-missing", {"line": 2, "field": "z"}),
        ("label,x,y,z\nA,1,2,high\n", "table.not-a-number", {"cell": "high"}),
        (
            "label,x,y,z\nA,1,2,3\nA,1,2,4\n",
            "table.repeated-label",
            {"line": 3, "field": "label", "label": "A", "first_line": 2},
        ),
        ("label,x,y,z,sigma\nA,1,2,3,0\n", "table.not-positive", {"field": "sigma"}),
        ("label,x,y,z,use\nA,1,2,3,maybe\n", "table.unknown-word", {"cell": "maybe"}),
        ("label,x,y,z\n,1,2,3\n", "table.value-missing", {"line": 2, "field": "label"}),
    ],
)
def test_table_errors_are_reported_with_location(
    tmp_path: Path, text: str, code: str, values: dict[str, object]
) -> None:
    path = written(tmp_path, text)
    with refused(code, file=path, **values):
        read_control(path)


def test_point_marked_twice_in_one_photo_is_rejected(tmp_path: Path) -> None:
    path = written(tmp_path, "label,photo,x,y\nA,a.jpg,1,2\nA,b.jpg,1,2\nA,a.jpg,3,4\n")
    with refused("control.mark-repeated", photo="a.jpg", first_line=2):
        read_marks(path)


RUNS = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
labels = st.text(
    st.characters(exclude_categories=("C", "Z")) | st.just(" "), min_size=1, max_size=8
).filter(lambda text: text == text.strip())
numbers = st.floats(-1e7, 1e7)


@RUNS
@given(
    st.lists(
        st.builds(
            ControlPoint,
            labels,
            st.tuples(numbers, numbers, numbers),
            st.none() | st.floats(1e-4, 10),
            st.booleans(),
        ),
        min_size=1,
        max_size=5,
        unique_by=lambda point: point.label,
    )
)
def test_written_points_round_trip(tmp_path: Path, points: list[ControlPoint]) -> None:
    assert write_control(tmp_path / "control.csv", points) is None
    assert read_control(tmp_path / "control.csv") == points


@RUNS
@given(
    st.lists(
        st.builds(
            Mark,
            labels,
            st.sampled_from(["a.jpg", "left; right/b, c.JPG", "ü.tif"]),
            numbers,
            numbers,
        ),
        min_size=1,
        max_size=6,
        unique_by=lambda mark: (mark.label, mark.photo),
    )
)
def test_written_marks_round_trip(tmp_path: Path, marks: list[Mark]) -> None:
    assert write_marks(tmp_path / "marks.csv", marks) is None
    assert read_marks(tmp_path / "marks.csv") == marks


def test_table_with_foreign_content_is_backed_up_before_overwriting(tmp_path: Path) -> None:
    path = written(tmp_path, "label,x,y,z,who\nA,1,2,3,Anna\n")
    kept = write_control(path, [ControlPoint("A", (1.0, 2.0, 4.0))])
    assert kept == tmp_path / "table.csv.bak"
    assert "Anna" in kept.read_text()
    assert write_control(path, [ControlPoint("A", (1.0, 2.0, 5.0))]) is None, "this one is ours"
    path.write_text("# levelled\nlabel,x,y,z,sigma,use\nA,1,2,3,,\n")
    assert write_control(path, []) == tmp_path / "table.csv.bak2"
    assert not path.exists(), "a table without points would be refused by its reader"


def test_a_crs_without_a_code_is_kept(tmp_path: Path) -> None:
    site = "+proj=tmerc +lat_0=45 +lon_0=12.3 +k=1 +x_0=5000 +y_0=5000 +ellps=GRS80 +units=m"
    crs, _ = parse_crs(site)
    assert crs.startswith("PROJCRS["), "it has no code"
    path, points = tmp_path / "control.csv", [ControlPoint("A", (1.0, 2.0, 3.0))]
    for _ in range(2):
        assert write_control(path, points, crs) is None, "a table with its CRS is ours"
        assert read_crs(path) == crs
        assert read_control(path) == points
    assert agreed_crs(path, site) == crs


def test_table_that_cannot_be_removed_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "control.csv"
    write_control(path, [ControlPoint("A", (1.0, 2.0, 3.0))])

    def deny(self: Path, missing_ok: bool = False) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "unlink", deny)
    with refused("file.not-removed", TargetError, file=path):
        write_control(path, [])


@pytest.mark.parametrize("value", ["1e30", "-1e13", "1e300"])
def test_point_with_invalid_coordinates_is_rejected_by_label(tmp_path: Path, value: str) -> None:
    path = written(tmp_path, f"label,x,y,z\nA,1,2,3\nB,4,{value},6\n")
    with refused("coordinate.out-of-range", file=path, field="B"):
        read_control(path)
