"""Files of programs with a comma locale: refused with line and number, never half read."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.messages import by_code
from vomstudio.core.errors import InputError
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.opening import read_model

FILES = {
    "a.obj": "v 0 0 0\nv 1,5 0 0\nv 1 1 0\nf 1 2 3\n",
    "a.ply": (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1,5 0 0\n1 1 0\n"
    ),
    "a.stl": (
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1,5 0 0\nvertex 1 1 0\n"
        "endloop\nendfacet\nendsolid a\n"
    ),
    "a.xyz": "1,5 0 0\n0 0 1\n1 1 0\n",
    "all.xyz": "0,5 1,25 2,75\n1,5 2,25 3,0\n",
    "a.pts": "3\n1,5 0 0 10 1 2 3\n0 0 0 10 1 2 3\n1 1 0 10 1 2 3\n",
}
LINES = {"a.obj": 2, "a.ply": 9, "a.stl": 5, "a.xyz": 1, "all.xyz": 1, "a.pts": 2}


@pytest.mark.parametrize("name", FILES)
def test_decimal_comma_is_reported_with_its_line(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(FILES[name], encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_model(path)
    assert caught.value.code in ("table.decimal-comma", "table.comma-delimiter")
    assert (caught.value.file, caught.value.line) == (str(path), LINES[name])


@pytest.mark.parametrize("name", FILES)
def test_same_file_with_decimal_points_is_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(FILES[name].replace(",", "."), encoding="utf-8")
    data = read_model(path).data
    points = data.vertices if isinstance(data, Mesh) else data.points
    assert float(points[:, 0].max()) == 1.5


def test_semicolon_separated_decimal_commas_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("0,5;1,25;2,75\n1,5;2,25;3,0\n", encoding="utf-8")
    assert read_model(path).data.points.tolist() == [[0.5, 1.25, 2.75], [1.5, 2.25, 3.0]]


def test_other_non_numeric_words_are_skipped_and_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv east 0 0\nv 1 1 0\nv 2 0 0\nf 1 3 4\n", encoding="utf-8")
    assert by_code(read_model(path).warnings)["model.values-not-numbers"]["line"] == 2
