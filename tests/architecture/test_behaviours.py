"""The command that finds the code of a behaviour by the names of tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.architecture.behaviours import find_behaviours

FILE = """
import numpy as np
from vomstudio.geometry.planes import fit_planes
from vomstudio.geology.orientation import Plane as Attitude

def rows():
    return fit_planes(np.eye(3), [0, 3])

def test_three_points_define_a_plane():
    assert rows()

def test_dip_is_positive():
    assert Attitude(10, 20).dip_deg > 0

def test_nothing_of_the_program():
    assert np.pi > 3
"""


@pytest.fixture
def tests(tmp_path: Path) -> Path:
    folder = tmp_path / "tests" / "geometry"
    folder.mkdir(parents=True)
    (folder / "test_planes.py").write_text(FILE)
    return tmp_path / "tests"


def test_names_with_all_words_are_listed_with_the_code_of_their_helpers(tests: Path) -> None:
    (line,) = find_behaviours(["Plane", "points"], tests)
    assert line.split() == [
        "tests/geometry/test_planes.py::test_three_points_define_a_plane",
        "vomstudio.geometry.planes.fit_planes",
    ]


def test_name_under_which_code_is_imported_does_not_matter(tests: Path) -> None:
    (line,) = find_behaviours(["dip_is"], tests)
    assert line.split()[1:] == ["vomstudio.geology.orientation.Plane"]


def test_all_imports_of_the_file_are_listed_if_a_test_uses_none(tests: Path) -> None:
    (line,) = find_behaviours(["nothing"], tests)
    assert len(line.split()) == 3


def test_words_may_be_in_the_name_of_the_file(tests: Path) -> None:
    (line,) = find_behaviours(["planes", "dip"], tests)
    assert "test_dip_is_positive" in line


def test_tests_with_most_words_are_listed_if_none_has_all(tests: Path) -> None:
    first, line = find_behaviours(["three", "plane", "missing"], tests)
    assert "::" not in first
    assert "test_three_points_define_a_plane" in line
    (only,) = find_behaviours(["missing"], tests)
    assert "::" not in only


def test_behaviours_of_this_project_are_found() -> None:
    (line,) = find_behaviours(["code_of_their_helpers"])
    assert "test_behaviours.py" in line
