"""No row of a table of points is lost or read as something else without a word."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.messages import by_code, refused
from vomstudio.io.control.observation_tables import read_pairs, read_positions, read_scale_bars

HEADER = "label,model_x,model_y,model_z,x,y,z\n"


def rows(labels: list[str], form: str = "%.2f") -> str:
    values = np.random.default_rng(1).uniform(-50.0, 50.0, (len(labels), 6))
    return "".join(
        ",".join([label, *(form % value for value in each)]) + "\n"
        for label, each in zip(labels, values, strict=True)
    )


def written(folder: Path, text: str) -> Path:
    path = folder / "points.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize("header", [HEADER, ""])
def test_rows_commented_out_by_a_hash_label_are_reported(tmp_path: Path, header: str) -> None:
    labels = ["P1", "#2", "P3", "# 4", "P5"]
    read = read_pairs(written(tmp_path, header + rows(labels)))
    assert read.labels == ("P1", "P3", "P5")
    first = 1 + bool(header)
    assert by_code(read.notes)["table.commented-rows"]["lines"] == (first + 1, first + 3)
    quoted = rows(['"#1"', '"#2"', '"#3"'])
    assert read_pairs(written(tmp_path, header + quoted)).labels == ("#1", "#2", "#3")


@pytest.mark.parametrize("header", [HEADER, ""])
def test_table_of_only_hash_labels_explains_why_it_is_empty(tmp_path: Path, header: str) -> None:
    with refused("table.commented-rows"):
        read_pairs(written(tmp_path, header + rows(["#1", "#2", "#3"])))


def test_plain_comments_are_not_reported_as_rows(tmp_path: Path) -> None:
    text = "# made on 12, 5, 2024\n# a, b, c, d, e, f, g\n" + HEADER + rows(["P1", "P2", "P3"])
    notes = read_pairs(written(tmp_path, text)).notes
    assert [note.code for note in notes] == ["frame.assumed"]


def test_row_in_a_comment_is_not_used_as_header(tmp_path: Path) -> None:
    read = read_pairs(written(tmp_path, "#A,1,2,3,4,5,6\n" + rows(["B", "C", "D"])))
    assert read.labels == ("B", "C", "D")
    assert "table.commented-rows" in by_code(read.notes)


@pytest.mark.parametrize("form", ["%.1f", "%.2f", "%.3f"])
def test_decimal_commas_in_comma_table_without_header_are_rejected(
    tmp_path: Path, form: str
) -> None:
    plain = rows(["P1", "P2", "P3", "P4"], form)
    with refused("table.comma-delimiter"):
        read_pairs(written(tmp_path, plain.replace(".", ",")))
    assert len(read_pairs(written(tmp_path, plain)).labels) == 4


def test_decimal_commas_in_position_table_are_rejected(tmp_path: Path) -> None:
    text = "a.jpg,1234,50,4321,05,160,25\nb.jpg,1239,55,4327,15,161,30\n"
    with refused("table.comma-delimiter"):
        read_positions(written(tmp_path, text))


def test_integers_with_accuracies_are_not_taken_for_decimal_commas(tmp_path: Path) -> None:
    text = "a.jpg,398000,4980000,320,2,2,5\nb.jpg,398020,4980010,321,2,2,5\n"
    assert read_positions(written(tmp_path, text)).coordinates[0].tolist() == [398000, 4980000, 320]


@pytest.mark.parametrize(
    "names",
    ["Rechtswert,Hochwert,Höhe", "Ostwert,Nordwert,Hoehe", "Est,Nord,Hauteur", "Este,Norte,Cota"],
)
def test_column_names_of_other_languages_are_accepted(tmp_path: Path, names: str) -> None:
    header = f"Punkt,model_x,model_y,model_z,{names}\n"
    assert len(read_pairs(written(tmp_path, header + rows(["P1", "P2", "P3"]))).labels) == 3


def test_error_for_missing_column_lists_accepted_names(tmp_path: Path) -> None:
    text = HEADER.replace(",x,", ",abscissa,") + rows(["P1", "P2", "P3"])
    with refused("table.missing-column") as error:
        read_pairs(written(tmp_path, text))
    assert error.value.values["names"][:3] == ("x", "east", "easting")


def test_scale_bar_from_point_to_itself_is_rejected_with_line(tmp_path: Path) -> None:
    path = written(tmp_path, "from,to,length_m\nP1,P2,3\nP1,P1,5\n")
    with refused("control.bar-of-one-point", label="P1") as raised:
        read_scale_bars(path)
    assert (raised.value.line, raised.value.field) == (3, "to")
