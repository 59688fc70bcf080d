"""Vector files that take time tell of progress and can be ended; of what they hold only that is
read which is asked for; and no file keeps its reader for ever."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyogrio
import pytest
import shapely

from tests.drawings import read_area, read_lines
from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, InputError, UsageError
from vomstudio.core.progress import CancelToken
from vomstudio.geometry.frames import Frame
from vomstudio.io.gis.line_reading import read_gis_lines
from vomstudio.io.gis.vector_layers import list_layers, read_layers
from vomstudio.project.imports.feature_lists import read_listed_features
from vomstudio.project.records import Model
from vomstudio.registration.by_model.stable import find_inside_polygons

COUNT = 60_000


class Watched:
    """When it was told of something; cancelled once so many seconds have gone."""

    def __init__(self, token: CancelToken | None = None) -> None:
        self.token, self.times = token, [time.monotonic()]

    def stage(self, name: str, total: int | None = None) -> None:
        self.step(0)

    def step(self, done: int) -> None:
        self.times.append(time.monotonic())
        if self.token is not None:
            self.token.check()


def _unreadable() -> InputError:
    return InputError("unreadable")


def _nested(path: Path, inside: int, times: int) -> Path:
    """A drawing of a block that is put in many places."""
    block = "".join(f"0\nLINE\n8\n0\n10\n{i}\n20\n0\n11\n{i + 1}\n21\n1\n" for i in range(inside))
    places = "".join(f"0\nINSERT\n8\n0\n2\nB\n10\n{i}\n20\n{i}\n" for i in range(times))
    path.write_text(
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n0\nENDSEC\n"
        f"0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n8\n0\n2\nB\n10\n0\n20\n0\n{block}0\nENDBLK\n0\nENDSEC\n"
        f"0\nSECTION\n2\nENTITIES\n{places}0\nENDSEC\n0\nEOF\n"
    )
    return path


def _written(path: Path, driver: str) -> Path:
    at = np.arange(COUNT, dtype=float)
    ends = np.stack([np.stack([at, at * 0], 1), np.stack([at + 1, at * 0 + 5.25], 1)], 1)
    names = np.array([None if i % 7 == 0 else f"n{i}é" for i in range(COUNT)], object)
    pyogrio.raw.write(
        path,
        shapely.to_wkb(shapely.linestrings(ends)),
        [names, at, np.arange(COUNT)],
        ["name", "length", "number"],
        geometry_type="LineString",
        driver=driver,
        crs="EPSG:32633",
    )
    return path


@pytest.mark.full
@pytest.mark.parametrize(
    ("name", "driver"),
    first_in_default_tier(
        [
            ("a.geojson", "GeoJSON"),
            ("a.gpkg", "GPKG"),
            ("a.shp", "ESRI Shapefile"),
            ("a.kml", "KML"),
        ],
        1,
    ),
)
def test_file_is_read_identically_in_a_subprocess(
    name: str, driver: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = _written(tmp_path / name, driver)
    assert path.stat().st_size > 2 << 20
    progress = Watched()
    columns = ("name", "length", "number")
    (apart,) = read_layers(path, [None], columns, _unreadable, progress)
    assert len(progress.times) > 2
    monkeypatch.setattr("vomstudio.io.gis.vector_layers._MAX_SMALL_BYTES", 1 << 40)
    (here,) = read_layers(path, [None], columns, _unreadable)
    assert (apart.name, apart.kind, apart.crs, apart.fields) == (
        here.name,
        here.kind,
        here.crs,
        here.fields,
    )
    assert apart.shapes is not None
    assert here.shapes is not None
    assert apart.shapes.tolist() == here.shapes.tolist()
    assert apart.columns is not None
    assert here.columns is not None
    assert list(apart.columns) == list(here.columns)
    for key, values in apart.columns.items():
        assert values.dtype == here.columns[key].dtype
        assert values.tolist() == here.columns[key].tolist()
    assert [layer.name for layer in list_layers(path, _unreadable)] == [here.name]


def test_large_drawing_reports_progress_and_can_be_cancelled(tmp_path: Path) -> None:
    """GDAL unfolds 900,000 entities in some seconds, in which Python stands still."""
    path = _nested(tmp_path / "a.dxf", 900, 1000)
    token, told = CancelToken(), threading.Event()
    progress = Watched(token)
    asked_at: list[float] = []

    def cancel() -> None:
        told.wait(60)
        asked_at.append(time.monotonic())
        token.cancel()

    threading.Timer(0.0, cancel).start()
    threading.Timer(1.0, told.set).start()
    with pytest.raises(Cancelled):
        read_gis_lines(path, progress)
    assert time.monotonic() - asked_at[0] < 3.0
    assert max(np.diff(progress.times)) < 5.0


def test_error_from_subprocess_matches_in_process_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = {"type": "FeatureCollection", "features": []}
    many = {f"n{i}": 1 for i in range(3000)}
    told["features"] = [{"type": "Feature", "properties": many, "geometry": None}] * 20  # type: ignore[assignment]
    path = tmp_path / "a.geojson"
    path.write_text(json.dumps(told))
    answers = []
    for limit in (0, 1 << 40):
        monkeypatch.setattr("vomstudio.io.gis.vector_layers._MAX_SMALL_BYTES", limit)
        with refused("file.too-many-parts", limit=2000) as error:
            read_gis_lines(path)
        answers.append(error.value.to_dict())
    assert answers[0] == answers[1]
    path.write_bytes(b"{" + bytes(range(32, 127)) * 40_000)
    monkeypatch.setattr("vomstudio.io.gis.vector_layers._MAX_SMALL_BYTES", 0)
    with refused("drawing.unreadable"):
        read_gis_lines(path)


def _listed(path: Path) -> object:
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("crs", "EPSG:32633"))
    return read_listed_features(path, model, {"m1": model}, "EPSG:32633")


READERS: list[Callable[[Path], object]] = [
    read_gis_lines,
    read_lines,
    read_area,
    _listed,
    lambda path: find_inside_polygons(np.zeros((3, 3)), path),
]


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("end", ["\r", "\n"])
def test_drawing_truncated_within_a_line_is_rejected(
    read: Callable[[Path], object], end: str, tmp_path: Path
) -> None:
    path = tmp_path / "contacts.dxf"
    path.write_bytes(f"0\r\nSECTION\r\n2\r\nENTITIES\r\n0\r\nLINE\r\n8\r\n0{end}".encode())
    with pytest.raises(InputError):
        read(path)
    if end == "\r":
        path.write_bytes(b"0\rSECTION\r2\rENTITIES\r0\rENDSEC\r0\rEOF\r")
        with pytest.raises(InputError):
            read(path)


@pytest.mark.parametrize("read", READERS)
def test_kml_without_layer_is_rejected(read: Callable[[Path], object], tmp_path: Path) -> None:
    path = tmp_path / "a.kml"
    path.write_text(
        '<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Document></Document>'
        "</kml>"
    )
    if read is read_gis_lines:
        assert read_gis_lines(path).lines == ()
        return
    with pytest.raises(InputError, match=r"a\.kml"):
        read(path)


def test_only_requested_columns_are_read(tmp_path: Path) -> None:
    lines = shapely.to_wkb([shapely.LineString([(0, 0), (1, k)]) for k in range(3)])
    names = np.array(["a", "b", "c"], object)
    pyogrio.raw.write(
        tmp_path / "t.gpkg",
        lines,
        [names, names, names],
        ["Set", "other", "repeat_of"],
        geometry_type="LineString",
        driver="GPKG",
        crs="EPSG:32633",
    )
    found = read_lines(tmp_path / "t.gpkg", columns=["set"])
    assert list(found.columns) == ["Set"]
    assert found.column("SET", "--set") == ["a", "b", "c"]
    assert found.fields == ("Set", "other", "repeat_of")
    with refused("table.unknown-column", UsageError, columns=("Set", "other", "repeat_of")):
        found.column("nothing", "--set")
