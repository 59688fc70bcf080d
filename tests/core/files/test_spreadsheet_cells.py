"""What a spreadsheet would calculate is written as text and read back unchanged."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.core.files.spreadsheet_cells import comment_line, escape_formula, unescape_formula
from vomstudio.geology.orientation import Plane
from vomstudio.io.control.control_files import read_control, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_control, write_marks
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.io.text.tables import read_points
from vomstudio.project.tables.orientation_table import orientation_row, write_orientation_csv

FORMULAS = ['=HYPERLINK("http://x","J")', "+1+1", "-2+3", "@SUM(1)", "'quoted", "'=1", "-", "'"]
PLAIN = ["J1", "it's", "a=b", "", "1.5", "’=1", "'a"]


@pytest.mark.parametrize("text", FORMULAS + PLAIN + ["\t=1", "\r=1"])
def test_escaped_formula_round_trips(text: str) -> None:
    assert unescape_formula(escape_formula(text)) == text


def test_written_cells_never_start_like_formulas(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    names = [*FORMULAS, *(name for name in PLAIN if name)]
    rows = [
        orientation_row(
            Plane(10.0 * i, 40.0), id=f"p{i}", name=name, set=name, x=-1.5, y=0.0, z=1.0
        )
        for i, name in enumerate(names)
    ]
    write_orientation_csv(path, rows)

    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    cells = list(csv.DictReader(lines))
    assert all(row["name"][0] not in "=+-@\t\r" for row in cells)
    assert all(float(row["x"]) == -1.5 for row in cells), "numbers stay numbers"

    table = read_orientations(path)
    assert table.table.cells(list(table.table.names or ()).index("name")) == names
    assert table.sets == tuple(names)


def test_labels_like_formulas_round_trip(tmp_path: Path) -> None:
    labels = [text for text in FORMULAS if text != "-"]
    control, marks = tmp_path / "control.csv", tmp_path / "marks.csv"
    write_control(control, [ControlPoint(label, (-1.0, 2.0, 3.0)) for label in labels])
    write_marks(marks, [Mark(label, "-a.jpg", 4.0, 5.0) for label in labels])
    assert [point.label for point in read_control(control)] == labels
    assert [(mark.label, mark.photo) for mark in read_marks(marks)] == [
        (label, "-a.jpg") for label in labels
    ]


def test_numbers_with_apostrophe_are_read_as_numbers(tmp_path: Path) -> None:
    """A spreadsheet that took a column for text writes the apostrophe before negative numbers."""
    path = tmp_path / "points.csv"
    path.write_text("name,x,y,z\n'=a,'-1,2,3\nb,4,5,6\n")
    groups = read_points(path)
    np.testing.assert_array_equal(groups.points, [[-1, 2, 3], [4, 5, 6]])


def cells_of(path: Path, delimiter: str = ",") -> list[str]:
    """As a spreadsheet cuts a file, which knows no comments."""
    lines = path.read_text().splitlines()
    return [cell for row in csv.reader(lines, delimiter=delimiter) for cell in row]


def calculated(cells: list[str]) -> list[str]:
    found = [cell.strip() for cell in cells if cell.strip()[:1] in tuple("=+-@")]
    return [cell for cell in found if not is_number(cell.rstrip("])"))]


def is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


NAME = '=HYPERLINK("http://x")'


@pytest.mark.parametrize(
    "form",
    first_in_default_tier(["orient", "gems", "gempy", "loopstructural", "stereonet", "csv"], 2),
)
def test_exported_tables_contain_no_formulas(form: str, tmp_path: Path) -> None:
    from tests.specimens.figures import copy_of
    from vomstudio.project import edits
    from vomstudio.project.exports.export import export_project
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.records import Feature

    folder = copy_of("schema1", tmp_path)
    project = ProjectFolder.open(folder)
    session = project.session
    for feature in session.of(Feature):
        ids = [feature.id]
        words = {"name": NAME, "notes": "@SUM(1)"}
        words |= {"set_name": "+A1"} if hasattr(feature, "set_name") else {}
        session.apply(edits.set_attributes(session.records, ids, **words))
    session.save()
    project.close()
    out = tmp_path / f"out.{form}"
    export_project(folder, form, out)
    made = [path for path in tmp_path.glob("out*") if path.suffix != ".json"]
    sign = "\t" if form in ("orient", "stereonet") else ","
    told = [cell for path in made for cell in cells_of(path, sign)]
    assert form == "loopstructural" or any("HYPERLINK" in c or "+A1" in c for c in told)
    assert calculated(told) == []


def test_table_with_sets_keeps_text_and_numbers(tmp_path: Path) -> None:
    from vomstudio.cli import main

    path, out = tmp_path / "planes.csv", tmp_path / "sets.csv"
    rows = [f"{90 + k},{30 + k % 3},-{k}.5,-,'=1+{k}" for k in range(12)]
    rows += [f"{270 + k},{60 + k % 3},+{k},,@SUM({k})" for k in range(12)]
    path.write_text("# of a,=1+1,b\ndip_direction,dip,x,none,=notes\n" + "\n".join(rows) + "\n")
    assert main(["sets", str(path), "-o", str(out)]) == 0
    assert calculated(cells_of(out)) == ["-"] * 12
    table, before = read_orientations(out).table, read_orientations(path).table
    for name in ("x", "none", "=notes"):
        assert table.cells(table.find(name)) == before.cells(before.find(name))


@pytest.mark.parametrize(
    "words", ["lines of a,=1+1,b.ply", "x; @SUM(1)", 'PROJCRS["a","=1"]', "a,-1+1|x!A0", "a\n=1"]
)
def test_comment_lines_contain_no_formulas(words: str, tmp_path: Path) -> None:
    path = tmp_path / "head.csv"
    path.write_text(comment_line(words))
    assert calculated(cells_of(path)) == []
    assert calculated(cells_of(path, ";")) == []


@pytest.mark.parametrize(
    "words", ["CRS: EPSG:32633", "rotation [0.1, -0.2, -3e-05], north -0.5", "a = b, c@d, -7"]
)
def test_comment_lines_with_numbers_are_unchanged(words: str) -> None:
    assert comment_line(words) == f"# {words}\n"
