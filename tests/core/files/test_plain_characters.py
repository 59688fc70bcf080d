"""Names with characters that no file of text can hold: what is written can be read."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.specimens.figures import copy_of
from vomstudio.cli import main
from vomstudio.core.files.plain_characters import replace_control_characters
from vomstudio.io.exchange.columns import delimited_text
from vomstudio.io.gate.orientation_files import read_orientations
from vomstudio.project import edits
from vomstudio.project.exports.export import export_project
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.records import Feature

NAME = "bed\x0b\x00 </text><script>\x1b[31m\x7f\ufffe"


def test_control_characters_are_replaced_by_spaces() -> None:
    assert replace_control_characters(NAME) == "bed   </text><script> [31m  "
    words = "Störung 60°\tשכבה\n地層\r\U0001f5fa"
    assert replace_control_characters(words) == words


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = copy_of("schema1", tmp_path)
    opened = ProjectFolder.open(folder)
    session = opened.session
    for feature in session.of(Feature):
        words = {"name": f"{feature.name} {NAME}", "notes": NAME}
        words |= {"set_name": NAME} if hasattr(feature, "set_name") else {}
        session.apply(edits.set_attributes(session.records, [feature.id], **words))
    session.save()
    opened.close()
    return folder


def test_exported_tables_contain_no_control_characters(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    export_project(project, "csv", out)
    read = read_orientations(out)
    assert {" ".join(replace_control_characters(NAME).split())} == {
        " ".join(name.split()) for name in read.sets if name
    }
    text = delimited_text(("name",), [(NAME,)], ",")
    assert next(csv.reader([text.splitlines()[1]])) == [
        " ".join(replace_control_characters(NAME).split())
    ]


def test_drawings_and_maps_are_valid_xml(project: Path, tmp_path: Path) -> None:
    face = project / "models" / "face" / "face.obj"
    section = ["section", str(face), "--plane", "110/90", "--through", "364534,4721858,852"]
    assert main([*section, "--project", str(project), "-o", str(tmp_path / "cut.svg")]) == 0
    view = ["ortho", str(face), "--trend", "31", "--plunge", "11", "--gsd", "0.2"]
    assert main([*view, "--draw", str(project), "-o", str(tmp_path / "o.tif")]) == 0
    export_project(project, "gpkg", tmp_path / "out.gpkg")
    named = 0
    for path in tmp_path.glob("*.*"):
        if path.suffix in (".svg", ".qgs"):
            root = ElementTree.fromstring(path.read_bytes())
            assert not [each for each in root.iter() if each.tag.endswith("script")]
            named += "&lt;script&gt;" in path.read_text("utf-8")
    assert named


def test_net_is_valid_xml(tmp_path: Path) -> None:
    table, net = tmp_path / "planes.csv", tmp_path / "net.svg"
    rows = [f"<a>\ufffe\uffff,{90 + k},{30 + k % 3}" for k in range(6)]
    table.write_text("set,dip_direction,dip\n" + "\n".join(rows) + "\n", "utf-8")
    assert main(["stereonet", str(table), "--by", "set", "-o", str(net)]) == 0
    ElementTree.fromstring(net.read_bytes())
    assert re.search("&lt;a&gt;", net.read_text("utf-8"))
    assert np.isfinite(read_orientations(table).dip_deg).all()
