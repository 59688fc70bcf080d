"""What a spreadsheet would calculate is written as text and read back unchanged."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from vomstudio.files.spreadsheet_cells import guarded, unguarded
from vomstudio.geology.orientation import Plane
from vomstudio.io.control.control_files import read_control, read_marks
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.writing import write_control, write_marks
from vomstudio.io.text.orientation_reading import read_orientations
from vomstudio.io.text.tables import read_points
from vomstudio.tables.orientation_table import orientation_row, write_orientation_csv

FORMULAS = ['=HYPERLINK("http://x","J")', "+1+1", "-2+3", "@SUM(1)", "'quoted", "'=1", "-", "'"]
PLAIN = ["J1", "it's", "a=b", "", "1.5", "’=1", "'a"]


@pytest.mark.parametrize("text", FORMULAS + PLAIN + ["\t=1", "\r=1"])
def test_every_text_comes_back(text: str) -> None:
    assert unguarded(guarded(text)) == text


def test_no_written_cell_begins_as_a_formula(tmp_path: Path) -> None:
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


def test_labels_of_control_come_back(tmp_path: Path) -> None:
    labels = [text for text in FORMULAS if text != "-"]
    control, marks = tmp_path / "control.csv", tmp_path / "marks.csv"
    write_control(control, [ControlPoint(label, (-1.0, 2.0, 3.0)) for label in labels])
    write_marks(marks, [Mark(label, "-a.jpg", 4.0, 5.0) for label in labels])
    assert [point.label for point in read_control(control)] == labels
    assert [(mark.label, mark.photo) for mark in read_marks(marks)] == [
        (label, "-a.jpg") for label in labels
    ]


def test_marked_numbers_among_points_are_numbers(tmp_path: Path) -> None:
    """A spreadsheet that took a column for text writes the apostrophe before negative numbers."""
    path = tmp_path / "points.csv"
    path.write_text("name,x,y,z\n'=a,'-1,2,3\nb,4,5,6\n")
    groups = read_points(path)
    np.testing.assert_array_equal(groups.points, [[-1, 2, 3], [4, 5, 6]])
