"""Profiles of `vomstudio section` in the systems and units of GIS and CAD files."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import pandas as pd
import pyogrio
import pytest
import shapely
from pyproj import Transformer

from tests.messages import codes
from tests.tiers import first_in_default_tier

UTM = np.array([500_000.0, 4_100_000.0, 100.0])
LINE = np.array([[2.0, 5.0], [18.0, 5.0]])


@pytest.fixture
def slope(tmp_path: Path) -> Path:
    """From 105 m down to 100 m over 20 m toward East, on the map."""
    corners = np.array([[0, 0, 5], [20, 0, 0], [20, 10, 0], [0, 10, 5]]) + UTM
    text = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners.tolist())
    path = tmp_path / "slope.obj"
    path.write_text(text + "f 1 2 3\nf 1 3 4\n")
    return path


def layer(path: Path, xy: np.ndarray, crs: str | None) -> Path:
    if path.suffix == ".dxf":
        document = ezdxf.new("R2010")
        document.header["$INSUNITS"] = 4
        document.modelspace().add_lwpolyline(xy)
        document.saveas(path)
    else:
        pyogrio.raw.write(
            path,
            shapely.to_wkb(shapely.linestrings(xy[None])),
            [],
            [],
            geometry_type="LineString",
            crs=crs,
        )
    return path


def moved(target: str | int) -> np.ndarray:
    turn = Transformer.from_crs(32633, target, always_xy=True)
    return np.stack(turn.transform(*(LINE + UTM[:2]).T), 1)


@pytest.mark.parametrize(
    ("name", "xy", "crs", "code"),
    first_in_default_tier(
        [
            ("utm.gpkg", LINE + UTM[:2], "EPSG:32633", None),
            ("degrees.gpkg", moved(4326), "EPSG:4326", "frame.reprojected"),
            ("degrees.geojson", moved(4326), None, "frame.reprojected"),
            ("zone32.shp", moved(32632), "EPSG:32632", "frame.reprojected"),
            ("metres.dxf", LINE + UTM[:2], None, None),
            ("millimetres.dxf", 1000 * (LINE + UTM[:2]), None, "frame.unit-converted"),
        ],
        2,
    ),
)
@pytest.mark.filterwarnings("ignore:'crs' was not provided")
def test_profile_is_read_in_its_own_crs(run, slope, tmp_path, name, xy, crs, code) -> None:  # type: ignore[no-untyped-def]
    path = layer(tmp_path / name, xy, crs)
    out = tmp_path / "s.csv"
    ran = run("section", slope, "--crs", "32633", "--section-line", path, "-o", out, "--json")
    assert ran.code == 0, ran.err
    assert code is None or code in codes(ran.json)
    assert ran.json["length_m"] == pytest.approx(16 * np.hypot(20, 5) / 20, abs=1e-3)
    table = pd.read_csv(out, comment="#")
    assert table["distance_m"].to_numpy()[[0, -1]] == pytest.approx([0, 16], abs=1e-3)
    assert table[["x", "y"]].to_numpy()[[0, -1]] == pytest.approx(LINE + UTM[:2], abs=1e-3)
    assert table["height_m"].to_numpy()[[0, -1]] == pytest.approx([104.5, 100.5], abs=1e-3)


def test_profile_in_degrees_is_refused_for_model_without_crs(run, slope, tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = layer(tmp_path / "d.gpkg", moved(4326), "EPSG:4326")
    ran = run("section", slope, "--section-line", path, "-o", tmp_path / "s.csv", "--json")
    assert (ran.code, ran.json["error"]["code"]) == (2, "frame.degrees")


def test_table_with_two_lines_is_refused_as_profile(run, slope, tmp_path) -> None:  # type: ignore[no-untyped-def]
    """As `trace -o` writes several lines."""
    path = tmp_path / "lines.csv"
    rows = [f"{k},{x + UTM[0]},{y + UTM[1]},100" for k in (1, 2) for x, y in LINE.tolist()]
    path.write_text("line,x,y,z\n" + "\n".join(rows) + "\n")
    ran = run("section", slope, "--section-line", path, "-o", tmp_path / "s.csv", "--json")
    assert ran.code == 2
    error = ran.json["error"]
    assert (error["code"], error["count"]) == ("section.several-lines", 2)
