"""GeoTIFF out: pictures and grids with their place, written tile by tile through rasterio.

GDAL reports a full disk late, or only in its log, so a finished file is looked over once.
"""

from __future__ import annotations

import contextlib
import math
import os
import warnings
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.names import utf8_name
from vomstudio.core.files.regular import require_regular_beside
from vomstudio.core.files.untrusted.pictures import check_raster
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

BLOCK = 512
"""Side of the blocks inside the files, pixels."""


_BANDS = {"f": "F", "i": "I", "u": "I"}

Affine = tuple[float, float, float, float, float, float]
"""(a, b, c, d, e, f): x = a column + b row + c, y = d column + e row + f; the outer corner of the
top left pixel is (c, f)."""


_VIEW_PLANE = "VOM Studio view plane"


def is_view_plane(crs: str | None) -> bool:
    """Return whether a CRS is that of a picture, of `view_plane_crs`."""
    return crs is not None and _VIEW_PLANE in crs


def view_plane_crs(metric: bool, picture: str = "") -> str:
    """A picture's own plane: x right, y up, in metres or in units of the model. Engineering, so
    that no GIS puts it on a map. picture : by which drawings on it are known to be drawn on it"""
    name = " ".join([_VIEW_PLANE, *([picture] if picture else [])])
    if metric:
        return f'LOCAL_CS["{name}",UNIT["metre",1]]'
    return f'LOCAL_CS["{name}, model units",UNIT["unknown",1]]'


@dataclass(frozen=True)
class Raster:
    """What a GeoTIFF shall be.

    kind : "rgba", four bands of uint8, the last one opacity; "float", one float32 band, NaN where
        there is nothing; or "grey", one of uint8, 0 where there is nothing
    crs : "EPSG:n", WKT, or None where it is not known
    tags : texts that go into the file
    """

    width: int
    height: int
    kind: Literal["rgba", "float", "grey"]
    transform: Affine
    crs: str | None = None
    tags: Mapping[str, str] = field(default_factory=dict)


@contextlib.contextmanager
def open_geotiff(path: Path, raster: Raster, shown: str | Path | None = None) -> Iterator[Any]:
    """Yield a rasterio dataset to write windows into; use `write_tile`.

    `path` is where it is written (a temporary name); `shown` is the name that errors give. Raises
    TargetError where the file cannot be written whole.
    """
    import rasterio
    from rasterio.crs import CRS
    from rasterio.errors import RasterioError

    profile: dict[str, Any] = {
        "driver": "GTiff",
        "width": raster.width,
        "height": raster.height,
        "transform": rasterio.Affine(*raster.transform),
        "crs": None if raster.crs is None else CRS.from_user_input(raster.crs),
        "tiled": True,
        "blockxsize": BLOCK,
        "blockysize": BLOCK,
        "compress": "deflate",
        "zlevel": 3,
        "num_threads": "all_cpus",
        "bigtiff": "IF_SAFER",
    }
    if raster.kind == "rgba":
        profile |= {"count": 4, "dtype": "uint8", "photometric": "RGB", "alpha": "YES"}
        profile |= {"interleave": "pixel", "predictor": 2}
    elif raster.kind == "grey":
        profile |= {"count": 1, "dtype": "uint8", "nodata": 0, "predictor": 2}
    else:
        profile |= {"count": 1, "dtype": "float32", "nodata": math.nan, "predictor": 3}
    try:
        with rasterio.Env():
            dataset = rasterio.open(path, "w", **profile)
            tiles = _sums[id(dataset)] = {}
            try:
                dataset.update_tags(**raster.tags)
                yield dataset
            finally:
                del _sums[id(dataset)]
                with libtiff_silent():
                    dataset.close()
        with rasterio.Env(), rasterio.open(path) as written:
            whole = _is_whole(written, path.stat().st_size) and _holds(written, tiles)
    except RasterioError as error:
        raise _not_whole(shown or path) from error
    if not whole:
        raise _not_whole(shown or path)


def size_and_bands(path: Path) -> tuple[int, int, list[str]]:
    """Width, height and the bands of a GeoTIFF by name, "F" for one of numbers, as Pillow calls it.
    Raises InputError where it cannot be opened."""
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    require_regular_beside(path)
    check_raster(path)
    try:
        with warnings.catch_warnings(), libtiff_silent(), rasterio.Env():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with (
                utf8_name(path) as named,
                rasterio.open(named, driver="GTiff") as dataset,
            ):
                kinds = [np.dtype(kind) for kind in dataset.dtypes]
                return dataset.width, dataset.height, [_BANDS.get(k.kind, k.name) for k in kinds]
    except RasterioError as error:
        raise InputError(
            Finding("file.damaged", format="GeoTIFF", reason=tr("its data cannot be decoded")),
            file=path,
        ) from error


@contextlib.contextmanager
def libtiff_silent() -> Iterator[None]:
    """Of a full disk libtiff prints a line per block to descriptor 2 itself, past GDAL's handlers;
    the user is told in one sentence instead."""
    try:
        saved = os.dup(2)
    except OSError:  # closed by the caller
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nowhere)


def _is_whole(dataset: Any, size: int) -> bool:
    """Whether all blocks lie within the file."""
    for row in range(-(-dataset.height // BLOCK)):
        for column in range(-(-dataset.width // BLOCK)):
            place = [
                dataset.get_tag_item(f"BLOCK_{what}_{column}_{row}", "TIFF", bidx=1)
                for what in ("OFFSET", "SIZE")
            ]
            if None in place or sum(map(int, place)) > size:
                return False
    return True


_sums: dict[int, dict[tuple[int, int, int, int], int]] = {}
"""Of the tiles of each dataset that is being written, by column, row, width and height."""


def _holds(dataset: Any, tiles: Mapping[tuple[int, int, int, int], int]) -> bool:
    """Whether each tile is there as it was written: GDAL says nothing of a block that the disk
    refused once while the file was closed, and leaves an empty one."""
    return all(
        zlib.crc32(dataset.read(window=_window(*place)).tobytes()) == total
        for place, total in tiles.items()
    )


def _window(column: int, row: int, width: int, height: int) -> Any:
    from rasterio.windows import Window

    return Window(column, row, width, height)  # type: ignore[call-arg, unused-ignore]


def _not_whole(path: str | Path) -> TargetError:
    return TargetError(
        Finding("output.unwritable", reason=tr("it is not complete, the disk may be full")),
        file=path,
    )


def write_tile(dataset: Any, column: int, row: int, values: np.ndarray[Any, Any]) -> None:
    """Put (h, w, 4) or (h, w) values with their top left pixel at (column, row)."""
    height, width = values.shape[:2]
    place = (column, row, width, height)
    if values.ndim == 3:
        bands = np.ascontiguousarray(np.moveaxis(values, 2, 0))
    else:
        bands = np.ascontiguousarray(values[None])
    if (tiles := _sums.get(id(dataset))) is not None:
        tiles[place] = zlib.crc32(bands.astype(dataset.dtypes[0], copy=False).tobytes())
    with libtiff_silent():
        dataset.write(bands, window=_window(*place))


def world_file(transform: Affine) -> str:
    """The text of a world file: six lines, the last two the centre of the top left pixel."""
    a, b, c, d, e, f = transform
    x, y = a * 0.5 + b * 0.5 + c, d * 0.5 + e * 0.5 + f
    return "".join(f"{value:.10f}\n" for value in (a, d, b, e, x, y))
