"""Files of a model without scale and north say so, and never East, North and metres."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np
import pytest

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.units import UNPLACED_AXES, WORLD_AXES, Axes
from vomstudio.io.models.writing import write_model
from vomstudio.project.tables.orientation_table import write_orientation_csv

CLOUD = PointCloud(np.random.default_rng(0).normal(size=(50, 3)))
ENDINGS = (".ply", ".obj", ".dxf", ".glb")


def said_by(path: Path) -> str:
    """All that can be read of a file and of what lies beside it, coordinates apart."""
    texts = [p.read_bytes() for p in path.parent.glob(path.stem + ".*")]
    return b"\n".join(texts).decode("latin-1").casefold()


@pytest.mark.parametrize("ending", ENDINGS)
def test_unscaled_model_file_states_model_units_without_north(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"model{ending}"
    write_model(CLOUD, None, path, axes=UNPLACED_AXES)
    said = said_by(path)
    assert "model units" in said
    for wrong in ("metre", "east", "north, z up"):
        assert wrong not in said


@pytest.mark.parametrize("ending", ENDINGS)
def test_georeferenced_model_file_states_metres(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"model{ending}"
    write_model(CLOUD, "EPSG:32632", path)
    assert ("east" if ending == ".glb" else "metres") in said_by(path)
    assert "model units" not in said_by(path)


def test_table_header_states_units_of_its_models(tmp_path: Path) -> None:
    write_orientation_csv(tmp_path / "a.csv", [], axes=UNPLACED_AXES)
    head = (tmp_path / "a.csv").read_text().split("\nid")[0]
    assert f"in {UNPLACED_AXES.unit}" in head
    assert f"square {UNPLACED_AXES.unit}" in head
    assert "metres" not in head
    write_orientation_csv(tmp_path / "b.csv", [])
    assert WORLD_AXES.description in (tmp_path / "b.csv").read_text()


@pytest.mark.parametrize(
    ("axes", "unit", "east"),
    [
        (UNPLACED_AXES, "unknown", False),
        (Axes(True, False), "metre", False),
        (WORLD_AXES, "metre", True),
    ],
)
def test_geopackage_without_north_has_no_east_axis(
    tmp_path: Path, axes: Axes, unit: str, east: bool
) -> None:
    """By what GDAL writes of the CRS and what PROJ reads of it."""
    import shapely
    from pyogrio.raw import write
    from pyproj import CRS

    path = tmp_path / "a.gpkg"
    write(
        str(path),
        shapely.to_wkb(np.array([shapely.Point(1, 2, 3)])),
        [np.array([1])],
        np.array(["a"], object),
        layer="l",
        driver="GPKG",
        geometry_type="Point Z",
        crs=axes.wkt,
    )
    opened = sqlite3.connect(path)
    try:
        (found,) = opened.execute(
            "SELECT definition FROM gpkg_spatial_ref_sys WHERE srs_id = "
            "(SELECT srs_id FROM gpkg_geometry_columns)"
        ).fetchone()
    finally:
        opened.close()
    crs = CRS.from_wkt(found)
    assert crs.is_engineering
    assert {a.unit_name for a in crs.axis_info} == {unit}
    assert ({a.direction for a in crs.axis_info} == {"east", "north"}) == east


def test_a_view_plane_without_scale_is_not_in_metres(tmp_path: Path) -> None:
    from rasterio.crs import CRS

    from vomstudio.io.gis.raster import view_plane_crs

    assert "metre" in CRS.from_user_input(view_plane_crs(True)).to_wkt()
    assert "metre" not in CRS.from_user_input(view_plane_crs(False)).to_wkt()


def test_axis_titles_depend_on_known_unit_and_north():
    assert Axes().titles == ("E (m)", "N (m)", "Z (m)")
    assert Axes(metric=True, north=False).titles == ("x (m)", "y (m)", "z (m)")
    assert Axes(metric=False, north=False).titles == ("x (units)", "y (units)", "z (units)")
