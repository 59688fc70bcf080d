from __future__ import annotations

from pathlib import Path

import pytest
from pyproj import CRS

from vomstudio.core.errors import InputError
from vomstudio.io.gis.crs import crs_name, parse_crs, sidecar_crs, unit_in_metres, world_crs
from vomstudio.io.models.offset_file import read_offset
from vomstudio.io.models.opening import read_model

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.mark.parametrize("text", ["32633", "EPSG:32633", " epsg:32633 ", "WGS 84 / UTM zone 33N"])
def test_crs_is_parsed_from_code_or_name(text):
    assert parse_crs(text) == ("EPSG:32633", 1.0)
    assert crs_name("EPSG:32633") == "WGS 84 / UTM zone 33N"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("utm 15n", "EPSG:32615"),
        ("UTM 15N", "EPSG:32615"),
        ("UTM zone 33S", "EPSG:32733"),
        ("WGS84 / UTM zone 1 n", "EPSG:32601"),
        ("utm60s", "EPSG:32760"),
        ("utm 05n", "EPSG:32605"),
    ],
)
def test_common_zone_names_are_parsed(text, code):
    """The names in EPSG's register say the same."""
    from pyproj import CRS

    assert parse_crs(text) == (code, 1.0)
    assert CRS.from_user_input(code).utm_zone is not None


def test_crs_in_feet_reports_its_unit():
    code, unit = parse_crs("EPSG:2263")
    assert code == "EPSG:2263"
    assert unit == pytest.approx(1200 / 3937)


@pytest.mark.parametrize(
    "text", ["", "EPSG:4326", "EPSG:99999999", "north", "utm 61n", "utm 0n", "utm 15"]
)
def test_invalid_or_unprojected_crs_is_rejected(text):
    with pytest.raises(InputError) as error:
        parse_crs(text)
    assert error.value.field == "CRS"
    assert error.value.code in ("frame.unknown-crs", "frame.not-projected")


def test_prj_beside_a_model_gives_its_crs(tmp_path):
    from pyproj import CRS

    (tmp_path / "a.obj").write_text(OBJ)
    assert read_model(tmp_path / "a.obj").crs is None
    (tmp_path / "a.prj").write_text(CRS.from_epsg(32633).to_wkt("WKT1_ESRI"))
    assert sidecar_crs(tmp_path / "a.obj") == ("EPSG:32633", None)
    assert read_model(tmp_path / "a.obj").crs == "EPSG:32633"


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "frame.crs-unused"),
        (b"\xff\xfe\x00", "frame.crs-unreadable"),
        (b"EPSG:4326", "frame.crs-unused"),
        (b"x" * 200_000, "frame.crs-unreadable"),
    ],
)
def test_a_prj_that_cannot_be_used_is_reported_and_the_model_opens(tmp_path, content, code):
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "a.prj").write_bytes(content)
    loaded = read_model(tmp_path / "a.obj")
    assert loaded.crs is None
    (finding,) = (each for each in loaded.warnings if each.code.startswith("frame.crs"))
    assert (finding.code, finding.values["file"]) == (code, "a.prj")


@pytest.mark.parametrize("code", ["EPSG:2264", "EPSG:2256", "EPSG:2264+6360"])
def test_world_crs_of_crs_in_feet_is_the_same_projection_in_metres(code):
    """Against pyproj's own coordinates in feet, times the length of the foot."""
    from pyproj import CRS, Transformer

    unit = CRS.from_user_input(code).axis_info[0].unit_conversion_factor
    place = (-79.5, 35.5) if "2264" in code else (-111.0, 46.0)
    feet = Transformer.from_crs("EPSG:4269", code, always_xy=True).transform(*place)
    world = world_crs(code, unit)
    metres = Transformer.from_crs("EPSG:4269", world, always_xy=True).transform(*place)
    assert [v * unit for v in feet[:2]] == pytest.approx(metres[:2], abs=1e-3)
    assert parse_crs(world)[1] == 1.0
    assert world_crs("EPSG:32633", 1.0) == "EPSG:32633"
    assert world_crs(None, 0.3048) is None


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_prj_and_offset_may_use_any_unicode_encoding(tmp_path, encoding):
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "a.prj").write_bytes("EPSG:32633".encode(encoding))
    assert read_model(tmp_path / "a.obj").crs == "EPSG:32633"
    (tmp_path / "b.offset.txt").write_bytes("EPSG:32633 offset 100 200 300\n".encode(encoding))
    assert read_offset(tmp_path / "b.stl").origin == (100.0, 200.0, 300.0)


def test_prj_in_windows_code_page_is_parsed(tmp_path: Path) -> None:
    """As GIS under Windows wrote .prj files for years."""
    wkt = CRS.from_epsg(2263).to_wkt("WKT1_ESRI").replace("Island", "Gemäß")
    (tmp_path / "a.prj").write_bytes(wkt.encode("cp1252"))
    named, problem = sidecar_crs(tmp_path / "a.obj")
    assert problem is None
    assert named is not None
    assert parse_crs(named)[1] == pytest.approx(1200 / 3937, rel=1e-7)


@pytest.mark.parametrize("code", [*range(32601, 32661), *range(32701, 32761), 2227, 32662, 4326])
def test_unit_in_metres_matches_the_crs_axes(code: int) -> None:
    """Zones of WGS 84 are known without PROJ, whose own table they are held against here."""
    crs = CRS.from_epsg(code)
    stated = crs.axis_info[0].unit_conversion_factor if crs.is_projected else 1.0
    assert unit_in_metres(f"EPSG:{code}") == pytest.approx(stated, rel=1e-12)
