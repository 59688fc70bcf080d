"""Finding the format of a file of ground control, ours or somebody else's."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from vomstudio.io.control import formats, registry
from vomstudio.io.control.control_files import (
    find_control,
    marks_path,
    read_control,
    read_crs,
    read_marks,
)
from vomstudio.io.control.formats import metashape, tables
from vomstudio.io.control.points import ControlPoint, Mark

THEIRS = """
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.points import ControlPoint, Mark

CONTROL_FORMAT = ControlFormat(
    "list of a total station",
    matches=lambda path: path.is_file() and path.read_bytes().startswith(b"<station"),
    points=lambda path: [ControlPoint("A", (1.0, 2.0, 3.0), 0.002)],
    marks=lambda path: [Mark("A", "a.jpg", 10.0, 20.0)],
    crs=lambda path: "EPSG:32633",
    has_marks=True,
    default_names=("station.xml",),
)
"""


@pytest.fixture(autouse=True)
def _fresh_formats() -> Iterator[None]:
    registry.find_formats.cache_clear()
    yield
    registry.find_formats.cache_clear()


def offer(monkeypatch: pytest.MonkeyPatch, *values: str) -> None:
    points = [EntryPoint(f"p{i}", value, registry.GROUP) for i, value in enumerate(values)]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: points)


def require_theirs_is_read(photos: Path) -> None:
    """Although it is XML, which MicMac's format takes where nobody knows it better."""
    path = photos / "station.xml"
    path.write_text("<station/>")
    assert read_control(path) == [ControlPoint("A", (1.0, 2.0, 3.0), 0.002)]
    assert read_marks(path) == [Mark("A", "a.jpg", 10.0, 20.0)]
    assert read_crs(path) == "EPSG:32633"
    assert marks_path(path) == path
    assert find_control(photos) == (path, path)


def test_format_can_be_a_module_in_the_formats_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a_station.py").write_text(THEIRS)
    (tmp_path / "_part.py").write_text("raise AssertionError\n")
    monkeypatch.setattr(formats, "__path__", [*formats.__path__, str(tmp_path)])
    require_theirs_is_read(tmp_path)


def test_a_format_of_another_package_reads_its_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "their_control_package.py").write_text(THEIRS)
    monkeypatch.syspath_prepend(tmp_path)
    offer(monkeypatch, "their_control_package:CONTROL_FORMAT")
    require_theirs_is_read(tmp_path)


def test_broken_plugin_does_not_disable_builtin_formats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    offer(monkeypatch)
    names = [one.name for one in registry.find_formats().all]
    assert {metashape.CONTROL_FORMAT.name, tables.CONTROL_FORMAT.name} <= set(names)
    registry.find_formats.cache_clear()
    offer(monkeypatch, "no_such_package:CONTROL_FORMAT", "math:pi")
    assert [one.name for one in registry.find_formats().all] == names
    said = registry.find_formats().problems
    assert [each.code for each in said] == ["plugin.not-loaded", "plugin.other-kind"]
    assert said[1].values["kind"] == "ControlFormat"
    path = tmp_path / "control.csv"
    path.write_text("label,x,y,z\nA,1,2,3\n")
    assert read_control(path) == [ControlPoint("A", (1.0, 2.0, 3.0))]


def test_micmac_marks_are_found_by_content(tmp_path: Path) -> None:
    points, marks = tmp_path / "Ground-Pts3D.xml", tmp_path / "measures.XML"
    points.write_text("<DicoAppuisFlottant></DicoAppuisFlottant>")
    (tmp_path / "camera.xml").write_text("<ExportAPERO></ExportAPERO>")
    assert marks_path(points) == tmp_path / "marks.csv"
    marks.write_text("<SetOfMesureAppuisFlottants></SetOfMesureAppuisFlottants>")
    assert marks_path(points) == marks
    # Of two files nobody knows which.
    (tmp_path / "other.xml").write_text("<SetOfMesureAppuisFlottants></SetOfMesureAppuisFlottants>")
    assert marks_path(points) == tmp_path / "marks.csv"
