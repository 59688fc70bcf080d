"""Writing of GeoTIFFs, tile by tile, with rasterio.

GDAL reports a full disk late or only in its log, so each file is verified after it has been
written.
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
from vomstudio.core.files.regular import require_regular_siblings
from vomstudio.core.files.untrusted.pictures import check_raster
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

BLOCK_SIZE_PX = 512
"""Side length of the blocks in the files, in pixels."""


_BAND_NAMES = {"f": "F", "i": "I", "u": "I"}

Affine = tuple[float, float, float, float, float, float]
"""(a, b, c, d, e, f): x = a column + b row + c, y = d column + e row + f; the outer corner of the
top-left pixel is (c, f)."""


_VIEW_PLANE = "VOM Studio view plane"


def is_view_plane(crs: str | None) -> bool:
    """Return whether a CRS is that of a picture, as returned by `view_plane_crs`."""
    return crs is not None and _VIEW_PLANE in crs


def view_plane_crs(is_metric: bool, picture: str = "") -> str:
    """Return the CRS of the plane of a picture, with x to the right and y up.

    It is an engineering CRS, so that GIS programs do not place it on a map.

    Parameters
    ----------
    is_metric : bool
        Whether lengths are in metres. If False, they are in model units.
    picture : str
        Identifier of the picture, with which drawings on it can be recognised.
    """
    name = " ".join([_VIEW_PLANE, *([picture] if picture else [])])
    if is_metric:
        return f'LOCAL_CS["{name}",UNIT["metre",1]]'
    return f'LOCAL_CS["{name}, model units",UNIT["unknown",1]]'


@dataclass(frozen=True)
class Raster:
    """Properties of a GeoTIFF to be written.

    Parameters
    ----------
    width, height : int
        Size in pixels.
    kind : {"rgba", "float", "grey"}
        Four uint8 bands, the last one opacity; one float32 band with NaN for no data; or one uint8
        band with 0 for no data.
    transform : Affine
    crs : str or None
        "EPSG:n" or WKT, or None if unknown.
    tags : mapping of str to str
        Metadata to be written to the file.
    """

    width: int
    height: int
    kind: Literal["rgba", "float", "grey"]
    transform: Affine
    crs: str | None = None
    tags: Mapping[str, str] = field(default_factory=dict)


@contextlib.contextmanager
def open_geotiff(
    path: Path, raster: Raster, display_path: str | Path | None = None
) -> Iterator[Any]:
    """Yield a rasterio dataset into which windows can be written with `write_tile`.

    Parameters
    ----------
    path : Path
        Path of the file, usually a temporary name.
    raster : Raster
    display_path : str or Path, optional
        File name for error messages.

    Raises
    ------
    TargetError
        If the file cannot be written completely.
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
        "blockxsize": BLOCK_SIZE_PX,
        "blockysize": BLOCK_SIZE_PX,
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
            tiles = _checksums[id(dataset)] = {}
            try:
                dataset.update_tags(**raster.tags)
                yield dataset
            finally:
                del _checksums[id(dataset)]
                with silence_libtiff():
                    dataset.close()
        with rasterio.Env(), rasterio.open(path, num_threads="all_cpus") as saved_dataset:
            is_complete = _is_complete(saved_dataset, path.stat().st_size) and _has_tiles(
                saved_dataset, tiles
            )
    except RasterioError as error:
        raise _incomplete_error(display_path or path) from error
    if not is_complete:
        raise _incomplete_error(display_path or path)


def read_size_and_bands(path: Path) -> tuple[int, int, list[str]]:
    """Return the width, height and band types of a GeoTIFF, named as in Pillow.

    Raises
    ------
    InputError
        If the file cannot be opened.
    """
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    require_regular_siblings(path)
    check_raster(path)
    try:
        with warnings.catch_warnings(), silence_libtiff(), rasterio.Env():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with (
                utf8_name(path) as safe_path,
                rasterio.open(safe_path, driver="GTiff") as dataset,
            ):
                kinds = [np.dtype(kind) for kind in dataset.dtypes]
                return (
                    dataset.width,
                    dataset.height,
                    [_BAND_NAMES.get(kind.kind, kind.name) for kind in kinds],
                )
    except RasterioError as error:
        raise InputError(
            Finding("file.damaged", format="GeoTIFF", reason=tr("its data cannot be decoded")),
            file=path,
        ) from error


@contextlib.contextmanager
def silence_libtiff() -> Iterator[None]:
    """Suppress messages of libtiff, which bypass the handlers of GDAL.

    On a full disk, libtiff prints a line per block to stderr; instead, the user gets a single
    error.
    """
    try:
        saved_descriptor = os.dup(2)
    except OSError:  # closed by the caller
        yield
        return
    null_descriptor = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null_descriptor, 2)
        yield
    finally:
        os.dup2(saved_descriptor, 2)
        os.close(saved_descriptor)
        os.close(null_descriptor)


def _is_complete(dataset: Any, size: int) -> bool:
    """Return whether all blocks are within the file."""
    for row in range(-(-dataset.height // BLOCK_SIZE_PX)):
        for column in range(-(-dataset.width // BLOCK_SIZE_PX)):
            tile_location = [
                dataset.get_tag_item(f"BLOCK_{domain}_{column}_{row}", "TIFF", bidx=1)
                for domain in ("OFFSET", "SIZE")
            ]
            if None in tile_location or sum(map(int, tile_location)) > size:
                return False
    return True


_checksums: dict[int, dict[tuple[int, int, int, int], int]] = {}
"""Checksums of the tiles of each open dataset by column, row, width and height."""


def _has_tiles(dataset: Any, tiles: Mapping[tuple[int, int, int, int], int]) -> bool:
    """Return whether all tiles are stored as they were written.

    If writing a block fails while the file is being closed, GDAL does not report it and leaves the
    block empty.
    """
    return all(
        zlib.crc32(dataset.read(window=_window(*tile_position))) == checksum
        for tile_position, checksum in tiles.items()
    )


def _window(column: int, row: int, width: int, height: int) -> Any:
    from rasterio.windows import Window

    return Window(column, row, width, height)  # type: ignore[call-arg, unused-ignore]


def _incomplete_error(path: str | Path) -> TargetError:
    return TargetError(
        Finding("output.unwritable", reason=tr("it is incomplete; the disk may be full")),
        file=path,
    )


def write_tile(dataset: Any, column: int, row: int, values: np.ndarray[Any, Any]) -> None:
    """Write a tile.

    Parameters
    ----------
    dataset : rasterio dataset
    column, row : int
        Position of the top-left pixel.
    values : (h, w, 4) or (h, w) array
    """
    height, width = values.shape[:2]
    window = (column, row, width, height)
    if values.ndim == 3:
        bands = np.ascontiguousarray(np.moveaxis(values, 2, 0))
    else:
        bands = np.ascontiguousarray(values[None])
    if (tiles := _checksums.get(id(dataset))) is not None:
        tiles[window] = zlib.crc32(bands.astype(dataset.dtypes[0], copy=False).data)
    with silence_libtiff():
        dataset.write(bands, window=_window(*window))


def world_file(transform: Affine) -> str:
    """Return the six lines of a world file; the last two are the centre of the top-left pixel."""
    a, b, c, d, e, f = transform
    x, y = a * 0.5 + b * 0.5 + c, d * 0.5 + e * 0.5 + f
    return "".join(f"{value:.10f}\n" for value in (a, d, b, e, x, y))
