"""Units of axes against pyproj, GDAL and laspy, and planes whose dip is known."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
import rasterio
from pyproj import CRS

import vomstudio as vs
from tests.io.models.copc_maker import write_copc
from tests.messages import codes, messages, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import InputError
from vomstudio.geometry.frames import Frame
from vomstudio.io.gis.axis_units import stated_axes
from vomstudio.io.gis.crs import parse_crs
from vomstudio.io.gis.geo_keys import Keys, decode_keys
from vomstudio.io.models import copc, model_cache
from vomstudio.io.models.frames import establish_frame, file_frame
from vomstudio.io.models.opening import describe, read_model
from vomstudio.io.models.preview import preview

FT, US_FT = 0.3048, 1200 / 3937
PROJECTED, LINEAR, VERTICAL, VERTICAL_UNIT = 3072, 3076, 4096, 4099
CAROLINA = [
    (3072, 0, 1, 32767),
    (2048, 0, 1, 4269),
    (3074, 0, 1, 32767),
    (3075, 0, 1, 8),
    (3076, 0, 1, 9003),
    (3078, 34736, 1, 0),
    (3079, 34736, 1, 1),
    (3081, 34736, 1, 2),
    (3080, 34736, 1, 3),
    (3082, 34736, 1, 4),
    (3083, 34736, 1, 5),
]
CAROLINA_NUMBERS = (36.166666666666664, 34.333333333333336, 33.75, -79.0, 2000000.0, 0.0)
"""EPSG:2264 by its parameters (EPSG Geodetic Parameter Dataset)."""


def slope(dip: float, flat_m: float, high_m: float, n: int = 400) -> np.ndarray:
    """Return (n, 3) points of a plane that dips east, in a file's units.

    In feet they lie in North Carolina, else in UTM zone 17.
    """
    north = 200_000 if flat_m == US_FT else 4_200_000
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0, 30, (2, n))
    metres = np.column_stack([x + 500_000, y + north, 400 - np.tan(np.radians(dip)) * x])
    return metres / [flat_m, flat_m, high_m]


def dip_of(points: np.ndarray) -> float:
    normal = np.linalg.svd(points - points.mean(axis=0))[2][2]
    return float(np.degrees(np.arccos(abs(normal[2]))))


def directory(keys: list[tuple[int, int, int, int]]) -> bytes:
    rows = sorted([(1024, 0, 1, 1), *keys])
    return struct.pack(f"<{4 + 4 * len(rows)}H", 1, 1, 0, len(rows), *[v for r in rows for v in r])


def write_las(
    path: Path,
    points: np.ndarray,
    wkt: str | None = None,
    keys: list[tuple[int, int, int, int]] | None = None,
    numbers: tuple[float, ...] = (),
) -> Path:
    header = laspy.LasHeader(version="1.4" if wkt else "1.2", point_format=6 if wkt else 1)
    header.offsets, header.scales = np.floor(points.mean(axis=0)), [1e-4] * 3
    records = [] if wkt is None else [(2112, wkt.encode() + b"\0")]
    if keys is not None:
        records = [(34735, directory(keys)), (34736, struct.pack(f"<{len(numbers)}d", *numbers))]
    for number, content in records:
        if content:
            header.vlrs.append(laspy.VLR("LASF_Projection", number, "", content))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T
    cloud.write(path)
    return path


def compound(flat: int, high: int) -> str:
    return CRS.from_user_input(f"EPSG:{flat}+{high}").to_wkt()


MIXED = {
    "compound WKT": {"wkt": compound(26917, 6360)},
    "vertical code": {"keys": [(PROJECTED, 0, 1, 26917), (VERTICAL, 0, 1, 6360)]},
    "vertical unit alone": {"keys": [(PROJECTED, 0, 1, 26917), (VERTICAL_UNIT, 0, 1, 9003)]},
    "code of metres with a unit of feet, as LAStools writes": {
        "keys": [(PROJECTED, 0, 1, 26917), (VERTICAL, 0, 1, 5703), (VERTICAL_UNIT, 0, 1, 9003)]
    },
}


@pytest.mark.parametrize("how", MIXED)
@pytest.mark.parametrize("ending", ["las", "laz"])
def test_heights_in_feet_with_horizontal_metres_keep_the_dip(
    tmp_path: Path, how: str, ending: str
) -> None:
    path = write_las(tmp_path / f"a.{ending}", slope(30, 1, US_FT), **MIXED[how])
    loaded = read_model(path)
    assert dip_of(loaded.data.points) == pytest.approx(30, abs=0.01)
    assert loaded.crs == "EPSG:26917"
    assert loaded.units == ("m", "m", "us-ft")
    (finding,) = (each for each in loaded.warnings if each.code == "frame.unit-converted")
    assert finding.values["height_unit"] == "US survey feet"
    with pytest.warns(vs.errors.VomWarning):
        world = vs.read(path)
    assert finding in world.warnings
    assert dip_of(world.points) == pytest.approx(30, abs=0.01)
    assert np.allclose(preview(path).points[:, 2].max(), loaded.data.points[:, 2].max(), atol=1)


@pytest.mark.parametrize(
    ("keys", "numbers", "unit", "metres"),
    [
        ([(PROJECTED, 0, 1, 2264)], (), "us-ft", US_FT),
        ([(PROJECTED, 0, 1, 26917), (LINEAR, 0, 1, 9003)], (), "us-ft", US_FT),
        ([(PROJECTED, 0, 1, 26917), (LINEAR, 0, 1, 9002)], (), "ft", FT),
        ([(PROJECTED, 0, 1, 26917), (LINEAR, 0, 1, 9001)], (), "m", 1.0),
        (CAROLINA, CAROLINA_NUMBERS, "us-ft", US_FT),
    ],
)
def test_geokey_unit_is_applied_to_world_coordinates(
    tmp_path: Path, keys, numbers, unit, metres
) -> None:
    path = write_las(tmp_path / "a.las", slope(30, metres, metres), keys=keys, numbers=numbers)
    loaded = read_model(path)
    assert loaded.units == (unit, unit, unit)
    assert loaded.unit_m == pytest.approx(metres, rel=1e-7)
    assert loaded.crs is not None
    assert parse_crs(loaded.crs)[1] == pytest.approx(metres, rel=1e-7)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vs.errors.VomWarning)
        world = vs.read(path)
    assert np.ptp(world.points[:, 1]) == pytest.approx(30, abs=0.3)
    assert dip_of(world.points) == pytest.approx(30, abs=0.01)


def test_crs_from_geokey_parameters_projects_like_its_epsg_code() -> None:
    """Against pyproj's own EPSG:2264, at a place in North Carolina."""
    from pyproj import Transformer

    wkt = decode_keys(Keys(directory(CAROLINA), struct.pack("<6d", *CAROLINA_NUMBERS))).crs
    ours = Transformer.from_crs("EPSG:4269", wkt, always_xy=True).transform(-79.5, 35.5)
    theirs = Transformer.from_crs("EPSG:4269", "EPSG:2264", always_xy=True).transform(-79.5, 35.5)
    assert ours == pytest.approx(theirs, abs=1e-3)


@pytest.mark.parametrize("version", ["WKT1_GDAL", "WKT1_ESRI", "WKT2_2019"])
@pytest.mark.parametrize(
    ("code", "units"),
    [
        ("EPSG:26917", ("m", "m", "m")),
        ("EPSG:2264", ("us-ft", "us-ft", "us-ft")),
        ("EPSG:2256", ("ft", "ft", "ft")),
        ("EPSG:26917+6360", ("m", "m", "us-ft")),
        ("EPSG:26917+8228", ("m", "m", "ft")),
        ("EPSG:2264+5703", ("us-ft", "us-ft", "m")),
        ("EPSG:4326", ("degree", "degree", "unknown")),
        ("EPSG:4979", ("degree", "degree", "m")),
        ("EPSG:4326+5773", ("degree", "degree", "m")),
        ("EPSG:4978", ("m", "m", "m")),
    ],
)
def test_axis_units_match_the_crs(version, code, units) -> None:
    # WKT 1 has no place for the third axis of these.
    three = code in ("EPSG:4978", "EPSG:4979")
    text = CRS.from_user_input(code).to_wkt("WKT2_2019" if three else version)
    assert stated_axes(text).units == units


def write_tif(path: Path, flat_m: float, high_m: float, crs: str | None, **more) -> Path:
    unit, kind = more.pop("unit", None), more.pop("kind", "float32")
    column = np.arange(60.0)
    north = 2e5 if flat_m == US_FT else 4.2e6
    heights = np.tile(400 - np.tan(np.radians(30)) * column, (50, 1)) / high_m
    with (
        rasterio.Env(**more.pop("env", {})),
        rasterio.open(
            path,
            "w",
            driver="GTiff",
            width=60,
            height=50,
            count=1,
            dtype=kind,
            crs=crs,
            transform=rasterio.Affine(1 / flat_m, 0, 5e5 / flat_m, 0, -1 / flat_m, north / flat_m),
            **more,
        ) as dataset,
    ):
        dataset.write(heights.astype(kind), 1)
        if unit is not None:
            dataset.units = [unit]
    return path


@pytest.mark.parametrize("kind", first_in_default_tier(["float32", "float64"]))
@pytest.mark.parametrize("geotiff", first_in_default_tier(["1.0", "1.1"]))
@pytest.mark.parametrize(
    ("crs", "flat", "high", "unit", "units"),
    first_in_default_tier(
        [
            ("EPSG:26917+6360", 1.0, US_FT, None, ("m", "m", "us-ft")),
            ("EPSG:26917+8228", 1.0, FT, None, ("m", "m", "ft")),
            ("EPSG:2264", US_FT, US_FT, None, ("us-ft", "us-ft", "us-ft")),
            ("EPSG:2264+5703", US_FT, 1.0, None, ("us-ft", "us-ft", "m")),
            ("EPSG:2264", US_FT, 1.0, "m", ("us-ft", "us-ft", "m")),
        ]
    ),
)
def test_height_models_in_feet_are_converted(
    tmp_path, kind, geotiff, crs, flat, high, unit, units
) -> None:
    path = write_tif(
        tmp_path / "a.tif", flat, high, crs, unit=unit, kind=kind, GEOTIFF_VERSION=geotiff
    )
    found = describe(path)
    assert found["units"] == list(units)
    with pytest.warns(vs.errors.VomWarning):
        world = vs.read(path)
    assert "frame.unit-converted" in [each.code for each in world.warnings]
    assert dip_of(world.points) == pytest.approx(30, abs=0.01)
    assert np.ptp(world.points[:, 0]) == pytest.approx(59, abs=1e-3)
    # In metres, as World is.
    assert np.ptp(np.array(found["bounds"])[:, 0]) == pytest.approx(59, abs=1e-3)
    assert found["resolution_m"] == pytest.approx(1.2, abs=0.2)


def test_copc_streams_in_one_unit(tmp_path: Path) -> None:
    whole = write_las(tmp_path / "a.las", slope(30, 1, US_FT, 4000), wkt=compound(26917, 6360))
    las = laspy.read(whole)
    path = tmp_path / "a.copc.laz"
    write_copc(path, las, crs="EPSG:26917+6360")
    cloud = copc.stream(path, 100_000)
    assert dip_of(cloud.points) == pytest.approx(30, abs=0.01)
    read = read_model(path).data
    assert np.allclose(cloud.bounds, read.bounds, atol=1e-6)
    with copc.CopcFile(path) as file:
        nodes = file.nodes()
        for row in range(len(nodes)):
            points = file.read(nodes.select_rows(np.array([row]))).points
            assert (points >= nodes.bounds[row, 0] - 1e-3).all()
            assert (points <= nodes.bounds[row, 1] + 1e-3).all()
    assert copc.read_crs(path)[0] == "EPSG:26917"


def test_degrees_are_rejected_by_reader_and_reported_by_describe(tmp_path: Path) -> None:
    points = np.array([[10.0, 45.0, 100.0], [10.001, 45.0, 101.0], [10.0, 45.001, 102.0]])
    path = write_las(tmp_path / "a.las", points, keys=[(1024, 0, 1, 2), (2048, 0, 1, 4326)])
    wkt = write_las(tmp_path / "b.las", points, wkt=CRS.from_epsg(4326).to_wkt())
    for file in (wkt, path):
        with pytest.raises(InputError) as caught:
            read_model(file)
        assert (caught.value.code, caught.value.file) == ("frame.degrees", str(file))
        assert caught.value.values["suggested_crs"] == "EPSG:32632"
        found = describe(file)
        assert found["units"] == ["degree", "degree", "unknown"]
        assert found["resolution_m"] is None
        assert found["resolution"] > 0
        assert found["bounds"][0] == pytest.approx([10, 45, 100])
        assert codes(found) == ["frame.degrees"]


def test_local_crs_in_feet_is_converted_to_metres(tmp_path: Path) -> None:
    wkt = 'LOCAL_CS["site",UNIT["foot",0.3048],AXIS["x",EAST],AXIS["y",NORTH]]'
    loaded = read_model(write_las(tmp_path / "a.las", slope(30, FT, FT), wkt=wkt))
    assert loaded.crs is None
    assert loaded.units == ("ft", "ft", "ft")
    assert np.ptp(loaded.data.points[:, 1]) == pytest.approx(30, abs=0.3)
    assert "frame.unit-converted" in [each.code for each in loaded.warnings]


def test_crs_is_read_from_extended_record_after_the_points(tmp_path: Path) -> None:
    points = slope(30, 1, US_FT)
    path = write_las(tmp_path / "a.las", points, wkt=CRS.from_epsg(26917).to_wkt())
    cloud = laspy.read(path)
    cloud.header.vlrs.clear()
    content = compound(26917, 6360).encode() + b"\0"
    cloud.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("LASF_Projection", 2112, "", content)])
    cloud.write(path)
    assert read_model(path).units == ("m", "m", "us-ft")


def test_a_prj_of_a_mixed_system_scales_heights_too(tmp_path: Path) -> None:
    points = slope(30, 1, US_FT)
    np.savetxt(tmp_path / "a.xyz", points, fmt="%.4f")
    (tmp_path / "a.prj").write_text(compound(26917, 6360))
    loaded = read_model(tmp_path / "a.xyz")
    assert dip_of(loaded.data.points) == pytest.approx(30, abs=0.01)
    assert (loaded.crs, loaded.units) == ("EPSG:26917", ("m", "m", "us-ft"))


def test_crs_with_two_units_cannot_be_declared() -> None:
    with refused("frame.other-height-unit"):
        parse_crs("EPSG:26917+6360")


@pytest.mark.parametrize("content", [b"", b"\1\0", b"\1\0\1\0\0\0\xff\xff", bytes(40)])
def test_damaged_geokeys_do_not_affect_the_points(tmp_path: Path, content: bytes) -> None:
    points = slope(30, 1, 1)
    path = write_las(tmp_path / "a.las", points, keys=[(PROJECTED, 0, 1, 26917)])
    raw = bytearray(path.read_bytes())
    good = directory([(PROJECTED, 0, 1, 26917)])
    at = raw.index(good)
    raw[at : at + len(good)] = (content + bytes(len(good)))[: len(good)]
    path.write_bytes(raw)
    loaded = read_model(path)
    assert len(loaded.data.points) == len(points)
    assert loaded.crs is None


def test_window_and_project_use_the_unit_of_the_crs(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.las", slope(30, US_FT, US_FT), keys=[(PROJECTED, 0, 1, 2264)])
    frame = file_frame(path, read_model(path).crs)
    assert frame.unit_m == pytest.approx(US_FT)
    assert frame == establish_frame(read_model(path)).frame


def test_cache_keeps_units_and_detects_a_prj_added_later(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.xyz", slope(30, 1, US_FT), fmt="%.4f")
    assert model_cache.load(tmp_path / "a.xyz", tmp_path / "cache").units == ("unknown",) * 3
    (tmp_path / "a.prj").write_text(compound(26917, 6360))
    for _ in range(2):
        loaded = model_cache.load(tmp_path / "a.xyz", tmp_path / "cache")
        assert (loaded.units, loaded.unit_m) == (("m", "m", "us-ft"), 1.0)
        assert dip_of(loaded.data.points) == pytest.approx(30, abs=0.01)


def test_labels_show_the_name_of_a_crs_without_code() -> None:
    wkt = decode_keys(Keys(directory([(PROJECTED, 0, 1, 26917), (LINEAR, 0, 1, 9002)]))).crs
    assert Frame("crs", wkt, FT).name() == "NAD83 / UTM zone 17N, grid north"
    assert Frame("crs", "EPSG:32633").name() == "EPSG:32633, grid north"


def test_a_shift_to_another_datum_does_not_hide_the_code() -> None:
    from pyproj import CRS
    from pyproj.crs import BoundCRS
    from pyproj.crs.coordinate_operation import ToWGS84Transformation

    plain = CRS.from_epsg(2903)
    bound = BoundCRS(plain, CRS.from_epsg(4326), ToWGS84Transformation(plain.geodetic_crs))
    assert stated_axes(bound.to_wkt()) == stated_axes("EPSG:2903")


def two_references(
    path: Path, wkt: str, keys: list[tuple[int, int, int, int]], *, version: str = "1.4", form=6
) -> Path:
    """A LAS file of which laspy writes both records, and the header's bit."""
    points = slope(30, 1, 1)
    header = laspy.LasHeader(version=version, point_format=form)
    header.offsets, header.scales = np.floor(points.mean(axis=0)), [1e-4] * 3
    header.global_encoding.wkt = form >= 6
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "", wkt.encode() + b"\0"))
    header.vlrs.append(laspy.VLR("LASF_Projection", 34735, "", directory(keys)))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = points.T
    cloud.write(path)
    # laspy 2.5 sets the bit for every file with WKT.
    content = bytearray(path.read_bytes())
    content[6] = content[6] & ~0x10 | (0x10 if form >= 6 else 0)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize(("form", "wanted"), [(6, "EPSG:32633"), (1, "EPSG:32632")])
def test_header_decides_between_conflicting_wkt_and_geokeys(tmp_path: Path, form, wanted) -> None:
    """LAS 1.4 R15: the bit of the global encoding; formats from 6 on have WKT."""
    wkt = CRS.from_epsg(32633).to_wkt()
    found = describe(two_references(tmp_path / "a.las", wkt, [(PROJECTED, 0, 1, 32632)], form=form))
    assert found["crs"] == wanted
    (said,) = messages(found)
    assert "zone 33N" in said
    assert "zone 32N" in said


@pytest.mark.parametrize("other", [32633, 25833])
def test_nearly_identical_wkt_and_geokeys_are_not_reported(tmp_path: Path, other: int) -> None:
    """WGS 84 and ETRS89 lie some decimetres apart."""
    wkt = CRS.from_epsg(32633).to_wkt()
    found = describe(two_references(tmp_path / "a.las", wkt, [(PROJECTED, 0, 1, other)]))
    assert messages(found) == []


@pytest.mark.parametrize("more", [(VERTICAL, 0, 1, 6360), (VERTICAL_UNIT, 0, 1, 9003)])
def test_geokeys_complete_missing_wkt_units(
    tmp_path: Path, more: tuple[int, int, int, int]
) -> None:
    wkt, keys = CRS.from_epsg(26917).to_wkt(), [(PROJECTED, 0, 1, 26917), more]
    found = describe(two_references(tmp_path / "a.las", wkt, keys))
    assert found["units"] == ["m", "m", "us-ft"]


def unreadable_crs(description: dict[str, Any]) -> list[str]:
    """Return the CRS of every ``frame.crs-unreadable``."""
    findings = list(description["warnings"])
    return [each.values["crs"] for each in findings if each.code == "frame.crs-unreadable"]


@pytest.mark.parametrize(
    ("keys", "unit"),
    [
        ([(PROJECTED, 0, 1, 9999)], "unknown"),
        ([(PROJECTED, 0, 1, 9999), (LINEAR, 0, 1, 9003)], "us-ft"),
        ([(PROJECTED, 0, 1, 32767), (LINEAR, 0, 1, 9002)], "ft"),
        ([(LINEAR, 0, 1, 9002)], "ft"),
        ([(2048, 0, 1, 4326)], "unknown"),
        ([], "unknown"),
    ],
)
def test_geokeys_without_known_crs_state_their_own_unit(tmp_path, keys, unit) -> None:
    """GDAL falls back to metres there."""
    found = describe(write_las(tmp_path / "a.las", slope(30, 1, 1), keys=keys))
    assert found["units"] == [unit] * 3
    assert found["crs"] is None
    if keys and keys[0][0] != LINEAR and keys[0][3] != 32767:
        assert unreadable_crs(found) == [f"EPSG:{keys[0][3]}"]


@pytest.mark.parametrize(
    ("keys", "unit"), [([(3072, 9999)], "unknown"), ([(3072, 9999), (3076, 9003)], "us-ft")]
)
def test_a_geotiff_of_an_unknown_code_states_its_own_unit(tmp_path: Path, keys, unit) -> None:
    """Written by Pillow, without GDAL."""
    from PIL import Image
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    rows = [(1024, 1), *keys]
    tags = ImageFileDirectory_v2()
    tags[33550], tags[33922] = (1.0, 1.0, 0.0), (0.0, 0.0, 0.0, 5e5, 2e5, 0.0)
    tags[34735] = (1, 1, 0, len(rows), *[v for key, value in rows for v in (key, 0, 1, value)])
    tags.tagtype[34735] = 3
    heights = np.add.outer(np.zeros(8), np.arange(9)).astype(np.float32)
    Image.fromarray(heights).save(tmp_path / "a.tif", tiffinfo=tags)
    found = describe(tmp_path / "a.tif")
    assert found["units"] == [unit] * 3
    assert unreadable_crs(found) == ["EPSG:9999"]


def test_vertical_crs_alone_leaves_horizontal_units_unknown(tmp_path: Path) -> None:
    found = describe(write_las(tmp_path / "a.las", slope(30, 1, 1), CRS.from_epsg(6360).to_wkt()))
    assert found["units"] == ["unknown", "unknown", "us-ft"]
    assert "frame.height-unit-only" in codes(found)


def test_depths_are_rejected_instead_of_read_as_heights(tmp_path: Path) -> None:
    path = write_las(tmp_path / "a.las", slope(30, 1, 1), compound(32633, 5715))
    with refused("frame.depths"):
        read_model(path)
    with refused("frame.other-axes"):
        parse_crs("EPSG:32633+5715")


@pytest.mark.parametrize("code", [2053, 5513, 29385])
def test_axes_toward_west_and_south_are_rejected(tmp_path: Path, code: int) -> None:
    path = write_las(tmp_path / "a.las", slope(30, 1, 1), CRS.from_epsg(code).to_wkt())
    with refused("frame.other-axes"):
        read_model(path)
    with refused("frame.other-axes"):
        parse_crs(f"EPSG:{code}")


def test_negative_coordinates_in_south_oriented_crs_read_as_north_oriented(tmp_path: Path) -> None:
    points = slope(30, 1, 1) - [600_000, 5_400_000, 0]
    loaded = read_model(write_las(tmp_path / "a.las", points, CRS.from_epsg(5513).to_wkt()))
    assert loaded.crs is None
    assert loaded.units == ("m", "m", "m")
    assert [finding.code for finding in loaded.warnings] == ["frame.axes-unused"]


@pytest.mark.parametrize("code", [3031, 3413, 5041, 5514, 31467, 32733])
def test_polar_and_other_crs_are_not_rejected_for_their_axes(code: int) -> None:
    assert parse_crs(f"EPSG:{code}") == (f"EPSG:{code}", 1.0)


def test_band_height_unit_overrides_crs_height_unit(tmp_path: Path) -> None:
    """The unit of the band goes before that of the CRS, and is said."""
    heights = np.add.outer(np.zeros(8), np.arange(9)).astype(np.float32)
    profile = {"driver": "GTiff", "width": 9, "height": 8, "count": 1, "dtype": "float32"}
    transform = rasterio.Affine(1, 0, 5e5, 0, -1, 2e5)
    with rasterio.open(
        tmp_path / "a.tif", "w", crs=compound(26917, 6360), transform=transform, **profile
    ) as dataset:
        dataset.write(heights, 1)
        dataset.units = ("m",)
    loaded = read_model(tmp_path / "a.tif")
    assert (loaded.crs, loaded.units) == ("EPSG:26917", ("m", "m", "m"))
    assert "frame.height-unit-replaced" in [each.code for each in loaded.warnings]


@pytest.mark.parametrize("written", ["[ft]", "Foot (International)", "US-survey-foot", "Foot_US"])
def test_spellings_of_feet_are_recognized(written: str) -> None:
    from vomstudio.io.models.formats.dem import parse_unit

    assert parse_unit(written) == ("ft" if "US" not in written else "us-ft")


def test_wkt_in_utf_16_is_read(tmp_path: Path) -> None:
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales = [1e-3] * 3
    content = CRS.from_epsg(2263).to_wkt().encode("utf-16")
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "", content))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.arange(30.0).reshape(3, 10)
    cloud.write(tmp_path / "a.las")
    assert describe(tmp_path / "a.las")["crs"] == "EPSG:2263"


@pytest.mark.parametrize("size", [0, 3, 50, 104, 150, 226])
def test_truncated_header_gives_no_crs(tmp_path: Path, size: int) -> None:
    from vomstudio.io.models.formats._las_reference import las_reference

    path = write_las(tmp_path / "a.las", slope(30, 1, 1), CRS.from_epsg(2263).to_wkt())
    path.write_bytes(path.read_bytes()[:size])
    assert las_reference(path).text is None


@pytest.mark.parametrize(
    ("system", "origin", "step", "code"),
    [
        ("EPSG:4326", (12.5, 41.9, 100.0), (1e-5, 1e-5, 1.0), "frame.degrees"),
        ("EPSG:4979", (-71.3, -16.4, 2300.0), (1e-5, 1e-5, 1.0), "frame.degrees"),
        ("EPSG:4978", (4.64e6, 1.03e6, 4.23e6), (1.0, 1.0, 1.0), "frame.geocentric"),
        # Metres of a model of its own, beside which such a file lies by mistake.
        ("EPSG:4326", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), None),
        ("EPSG:4978", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), None),
        ("EPSG:4326", (500_000.0, 4_649_776.0, 100.0), (1.0, 1.0, 1.0), None),
    ],
)
def test_prj_in_degrees_is_used_if_coordinates_are_degrees(
    tmp_path: Path,
    system: str,
    origin: tuple[float, ...],
    step: tuple[float, ...],
    code: str | None,
) -> None:
    from pyproj import CRS

    points = np.random.default_rng(2).uniform(0, 9, (50, 3)) * step + origin
    np.savetxt(tmp_path / "a.xyz", points, fmt="%.9f")
    (tmp_path / "a.prj").write_text(CRS.from_user_input(system).to_wkt())
    if code is None:
        loaded = read_model(tmp_path / "a.xyz")
        assert loaded.crs is None
        assert "frame.crs-unused" in [each.code for each in loaded.warnings]
        return
    with pytest.raises(InputError) as refused:
        read_model(tmp_path / "a.xyz")
    assert refused.value.code == code
