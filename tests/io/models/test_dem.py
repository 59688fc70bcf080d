"""Height models in GeoTIFF: in place, with their holes, and never a picture by mistake."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from rasterio.transform import Affine

from tests.messages import by_code, refused
from vomstudio.core.errors import Cancelled, InputError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.formats import dem
from vomstudio.io.models.model_copy import copy_model
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.writing import write_model

# rasterio multiplies transforms in a way that affine 3 warns of.
pytestmark = pytest.mark.filterwarnings("ignore:Use `@` matmul:PendingDeprecationWarning")

NORTH_UP = Affine(0.5, 0.0, 576000.25, 0.0, -0.5, 5188100.75)
COS, SIN = 0.5 * np.cos(0.5), 0.5 * np.sin(0.5)
ROTATED = Affine(COS, SIN, 576000.25, SIN, -COS, 5188100.75)


def heights(rows: int = 40, columns: int = 60) -> np.ndarray:
    y, x = np.mgrid[0:rows, 0:columns] * 0.5
    return 150.0 + 3 * np.sin(x / 4) + 0.3 * y


def write(path: Path, values: np.ndarray, transform: Affine | None = NORTH_UP, **more) -> Path:
    bands = values if values.ndim == 3 else values[None]
    profile = {"crs": "EPSG:32615", "nodata": -9999.0} | more
    tags = profile.pop("units", None)
    scale = profile.pop("scale", None)
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        count=len(bands),
        height=bands.shape[1],
        width=bands.shape[2],
        dtype=bands.dtype,
        transform=transform,
        **profile,
    ) as dataset:
        dataset.write(bands)
        if tags:
            dataset.units = [tags]
        if scale:
            dataset.scales, dataset.offsets = [scale[0]], [scale[1]]
    return path


def surface(path: Path) -> tuple[Mesh, dict[str, dict[str, Any]]]:
    loaded = read_model(path)
    assert isinstance(loaded.data, Mesh)
    return loaded.data, by_code(loaded.warnings)


def normals(mesh: Mesh) -> np.ndarray:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("transform", [NORTH_UP, ROTATED, Affine(0.5, 0, 5e5, 0, 0.5, 4e6)])
def test_heights_are_at_pixel_centres(tmp_path: Path, transform: Affine) -> None:
    values = heights().astype(np.float64)
    path = write(tmp_path / "a.tif", values, transform)
    mesh, findings = surface(path)
    assert findings == {}
    assert read_model(path).crs == "EPSG:32615"
    with rasterio.open(path) as dataset:
        rows, columns = np.mgrid[0:40, 0:60]
        x, y = dataset.xy(rows.ravel(), columns.ravel())
    expected = np.column_stack([x, y, values.ravel()])
    assert np.abs(mesh.vertices - expected).max() < 1e-8
    assert len(mesh.faces) == 2 * 39 * 59
    across = normals(mesh)
    assert (across[:, 2] > 0).all()
    # Together they cover the ground once.
    assert across[:, 2].sum() / 2 == pytest.approx(39 * 59 * abs(transform.determinant))


def test_pixels_without_a_value_are_holes(tmp_path: Path) -> None:
    values = heights().astype(np.float32)
    values[10:20, 10:30] = -9999
    values[0, 0] = -9999
    values[30, 40] = np.nan
    mesh, findings = surface(write(tmp_path / "a.tif", values))
    assert findings == {}
    assert len(mesh.vertices) == 40 * 60 - 200 - 2
    assert mesh.vertices[:, 2].min() > 100
    # Nothing spans the hole; of each missing corner half a square is left.
    lost = 11 * 21 - 4 + 4 * 0.5 + 0.5 + 4 * 0.5
    assert normals(mesh)[:, 2].sum() / 2 == pytest.approx((39 * 59 - lost) * 0.25)


def test_undeclared_no_data_values_are_reported(tmp_path: Path) -> None:
    values = heights().astype(np.float32)
    values[:5] = -9999
    values[6, :3] = 3e38
    mesh, findings = surface(write(tmp_path / "a.tif", values, nodata=None))
    assert findings["dem.no-data-value"] == {"value": -9999, "count": 300}
    assert findings["dem.pixels-left-out"] == {"count": 3}
    assert mesh.vertices[:, 2].min() > 100


def test_integers_with_a_scale_and_feet_become_metres(tmp_path: Path) -> None:
    values = heights()
    stored = np.rint((values - 100) * 100).astype(np.int16)
    path = write(tmp_path / "a.tif", stored, nodata=-32768, scale=(0.01, 100.0))
    assert np.abs(surface(path)[0].vertices[:, 2] - values.ravel()).max() < 0.00501
    path = write(tmp_path / "b.tif", values / 0.3048, units="ft")
    mesh, findings = surface(path)
    assert np.abs(mesh.vertices[:, 2] - values.ravel()).max() < 1e-9
    assert findings["frame.unit-converted"]["height_unit"] == "feet"


def test_huge_grid_is_thinned_and_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dem, "MAX_VERTICES", 300)
    monkeypatch.setattr(dem, "PIXELS_PER_STEP", 500)
    values = heights()
    mesh, findings = surface(write(tmp_path / "a.tif", values))
    assert findings["dem.reduced"]["step"] == 3
    assert len(mesh.vertices) == 14 * 20
    assert np.abs(mesh.vertices[:, 2] - values[::3, ::3].ravel()).max() < 1e-12
    x = NORTH_UP.c + (np.arange(0, 60, 3) + 0.5) * 0.5
    assert np.abs(mesh.vertices[:20, 0] - x).max() < 1e-8


def test_tiled_and_compressed_grids_are_the_same(tmp_path: Path) -> None:
    values = heights(300, 400).astype(np.float32)
    more = {"tiled": True, "blockxsize": 128, "blockysize": 128, "compress": "deflate"}
    tiled, _ = surface(write(tmp_path / "a.tif", values, predictor=3, **more))
    assert np.array_equal(tiled.vertices[:, 2], values.ravel().astype(float))


@pytest.mark.parametrize(
    ("values", "more", "code"),
    [
        (np.zeros((3, 9, 9), np.uint8), {"nodata": None}, "dem.picture"),
        (np.zeros((3, 9, 9), np.uint16), {"nodata": None}, "dem.picture"),
        (np.zeros((9, 9), np.uint8), {"nodata": None}, "dem.picture"),
        (np.ones((9, 9), np.complex64), {"nodata": None}, "dem.not-heights"),
        (heights(), {"transform": None, "crs": None}, "dem.no-place"),
        (heights(), {"crs": "EPSG:4326"}, "frame.not-degrees"),
        (heights(), {"crs": 'LOCAL_CS["VOM Studio view plane",UNIT["metre",1]]'}, "dem.depths"),
        (np.full((9, 9), -9999.0), {}, "model.no-points"),
        (heights(1, 9), {}, "dem.too-small"),
    ],
)
@pytest.mark.filterwarnings("ignore:The given matrix:rasterio.errors.NotGeoreferencedWarning")
@pytest.mark.filterwarnings("ignore:Dataset has no:rasterio.errors.NotGeoreferencedWarning")
def test_file_that_is_not_a_height_model_is_rejected(
    tmp_path: Path, values: np.ndarray, more: dict, code: str
) -> None:
    path = write(tmp_path / "a.tif", values, **more)
    with refused(code, file=path):
        read_model(path)


@pytest.mark.full
def test_truncated_grid_is_rejected_without_console_output(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    values = heights(100, 90).astype(np.float32)
    content = write(tmp_path / "a.tif", values, compress="deflate").read_bytes()
    path = tmp_path / "cut.tif"
    for n in [*range(0, 600, 41), *range(600, len(content) - 10, 1203)]:
        path.write_bytes(content[:n])
        with pytest.raises(InputError):
            read_model(path)
    rng = np.random.default_rng(1)
    for _ in range(200):
        bad = bytearray(content)
        for at in rng.integers(0, 700, 2):
            bad[at] = rng.integers(0, 256)
        path.write_bytes(bad)
        try:
            read_model(path)
        except InputError:
            continue
    assert capfd.readouterr().err == ""


def test_header_with_excessive_size_is_rejected(tmp_path: Path) -> None:
    path = write(tmp_path / "a.tif", heights().astype(np.float32))
    content = bytearray(path.read_bytes())
    (directory,) = struct.unpack_from("<I", content, 4)
    for at in range(directory + 2, directory + 2 + 2 * 12, 12):
        tag = struct.unpack_from("<H", content, at)[0]
        assert tag in (256, 257)
        struct.pack_into("<HII", content, at + 2, 4, 1, 2_000_000)
    path.write_bytes(content)
    with pytest.raises(InputError):
        read_model(path)


def test_reading_stops_when_it_is_cancelled(tmp_path: Path) -> None:
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        read_model(write(tmp_path / "a.tif", heights()), SilentProgress(token))


@pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
def test_world_file_and_prj_are_used_and_copied_along(tmp_path: Path) -> None:
    values = heights()
    write(tmp_path / "a.tif", values, None, crs=None)
    (tmp_path / "a.tfw").write_text("0.5\n0\n0\n-0.5\n576000.5\n5188100.5\n")
    (tmp_path / "a.prj").write_text("EPSG:32615\n")
    (tmp_path / "copy").mkdir()
    for path in (tmp_path / "a.tif", copy_model(tmp_path / "a.tif", tmp_path / "copy")):
        loaded = read_model(path)
        assert loaded.crs == "EPSG:32615"
        assert isinstance(loaded.data, Mesh)
        assert np.abs(loaded.data.vertices[0] - [576000.5, 5188100.5, values[0, 0]]).max() < 1e-9


def test_trimesh_agrees_on_the_surface(tmp_path: Path) -> None:
    import trimesh

    path = write(tmp_path / "a.tif", heights())
    write_model(read_model(path).data, None, tmp_path / "a.ply")
    theirs = trimesh.load(tmp_path / "a.ply")
    mesh, _ = surface(path)
    assert theirs.area == pytest.approx(np.linalg.norm(normals(mesh), axis=1).sum() / 2)
    assert theirs.euler_number == 1
    assert theirs.is_winding_consistent


def test_zero_scale_is_ignored_and_reported(tmp_path: Path) -> None:
    values = heights().astype(np.float32)
    path = write(tmp_path / "a.tif", values)
    with rasterio.open(path, "r+") as dataset:
        dataset.scales = [0.0]
    mesh, findings = surface(path)
    assert "dem.scale-unused" in findings
    assert mesh.vertices[:, 2].max() == values.max()
