"""The CRS of GeoTIFF keys, which LAS files carry too, named by GDAL.

The keys go into a picture of one pixel in memory, so that one reader names them all: codes, systems
that are defined by parameters (code 32767), units of length and vertical systems.
"""

from __future__ import annotations

import struct
import warnings

from vomstudio.errors import InputError
from vomstudio.geometry.units import METRES
from vomstudio.words import tr

COMPOUND = {"GTIFF_REPORT_COMPD_CS": "YES"}
"""GDAL leaves the vertical part out of files of GeoTIFF 1.0 unless it is asked for."""
_KEYS_AT_MOST = 1000
_VERTICAL_UNITS = 4099
_VERTICAL_CODES = {9001: "m", 9002: "ft", 9003: "us-ft"}
"""EPSG's codes of units of length."""


def crs_of_keys(directory: bytes, doubles: bytes = b"", texts: bytes = b"") -> str | None:
    """WKT of the CRS of the records GeoKeyDirectory, GeoDoubleParams and GeoAsciiParams; None where
    they name none. Raises InputError where they are damaged."""
    rows = _rows(directory)
    if not rows:
        return None
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError
    from rasterio.io import MemoryFile

    content = _picture(directory[: 8 + 8 * len(rows)], doubles[: len(doubles) // 8 * 8], texts)
    try:
        with warnings.catch_warnings(), rasterio.Env(**COMPOUND), MemoryFile(content) as file:
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with file.open(driver="GTiff") as dataset:
                return None if dataset.crs is None else str(dataset.crs.to_wkt())
    except (RasterioError, ValueError) as error:
        raise _damaged() from error


def vertical_unit_of_keys(directory: bytes) -> str | None:
    """The unit of heights that VerticalUnitsGeoKey names, a name of `METRES`; None without. GDAL
    does not use it beside the code of a vertical system, and LAStools writes both."""
    for key, location, _, value in _rows(directory):
        if key == _VERTICAL_UNITS and location == 0:
            name = _VERTICAL_CODES.get(value)
            return name if name in METRES else None
    return None


def _rows(directory: bytes) -> list[tuple[int, int, int, int]]:
    """(key, where its value is, how many, value or position) of each key."""
    if len(directory) < 8:
        return []
    count = struct.unpack_from("<H", directory, 6)[0]
    if count > _KEYS_AT_MOST or 8 + 8 * count > len(directory):
        raise _damaged()
    return [struct.unpack_from("<4H", directory, 8 + 8 * k) for k in range(count)]


def _damaged() -> InputError:
    return InputError(
        tr("The keys of the coordinate reference system are damaged. Declare the system yourself."),
        field="CRS",
    )


def _picture(directory: bytes, doubles: bytes, texts: bytes) -> bytes:
    """A TIFF of one pixel, by the TIFF 6.0 and GeoTIFF 1.1 specifications."""
    short, long, double, ascii_ = 3, 4, 12, 2
    small = {256: 1, 257: 1, 258: 8, 259: 1, 262: 1, 277: 1, 278: 1, 279: 1}
    large = {
        33550: (double, 3, struct.pack("<3d", 1, 1, 0)),
        33922: (double, 6, bytes(48)),
        34735: (short, len(directory) // 2, directory),
    }
    if doubles:
        large[34736] = (double, len(doubles) // 8, doubles)
    if texts:
        text = texts.rstrip(b"\0") + b"\0"
        # Four bytes or less would stand in the tag itself.
        text = text.ljust(5, b"\0")
        large[34737] = (ascii_, len(text), text)
    count = len(small) + 1 + len(large)
    at = 8 + 2 + 12 * count + 4
    tags = {tag: struct.pack("<HHIHH", tag, short, 1, value, 0) for tag, value in small.items()}
    body = b""
    for tag, (kind, n, content) in large.items():
        tags[tag] = struct.pack("<HHII", tag, kind, n, at + len(body))
        body += content + b"\0" * (len(content) % 2)
    tags[273] = struct.pack("<HHII", 273, long, 1, at + len(body))
    head = struct.pack("<2sHIH", b"II", 42, 8, count)
    return head + b"".join(tags[tag] for tag in sorted(tags)) + bytes(4) + body + b"\0\0"
