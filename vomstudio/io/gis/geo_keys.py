"""CRS of GeoTIFF keys, which are also used in LAS files, decoded by GDAL.

The keys are written into an in-memory image of one pixel, so that a single reader decodes all of
them: codes, systems defined by parameters (code 32767), units of length and vertical systems.
"""

from __future__ import annotations

import struct
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gis.axis_units import stated_axes

COMPOUND_CRS_OPTIONS = {"GTIFF_REPORT_COMPD_CS": "YES"}
"""GDAL option that includes the vertical part of GeoTIFF 1.0 files."""
_MAX_KEYS = 1000
_SYSTEM_KEYS = {"projected": 3072, "geographic": 2048}
_UNIT_KEY, _UNIT_SIZE_KEY, _VERTICAL_UNIT_KEY = 3076, 3077, 4099
_UNITS = {9001: "m", 9002: "ft", 9003: "us-ft"}
"""Units of length by EPSG code."""
_USER_DEFINED = 32767


@dataclass(frozen=True)
class Keys:
    """Records GeoKeyDirectory, GeoDoubleParams and GeoAsciiParams of a file."""

    directory: bytes
    doubles: bytes = b""
    texts: bytes = b""


@dataclass(frozen=True)
class DecodedKeys:
    """Meaning of GeoTIFF keys.

    Parameters
    ----------
    crs : str or None
        CRS as WKT, or None if the keys do not state a known system.
    height_unit : str or None
        Unit of heights that is stated in addition to the CRS, as a key of `METRES_PER_UNIT`.
    warnings : tuple of Finding
        Findings about statements that cannot be used.
    """

    crs: str | None = None
    height_unit: str | None = None
    warnings: tuple[Finding, ...] = ()


def decode_keys(keys: Keys) -> DecodedKeys:
    """Decode GeoTIFF keys.

    Raises
    ------
    InputError
        If the keys are damaged.
    """
    rows = _rows(keys.directory)
    if not rows:
        return DecodedKeys()
    text = _decode_with_gdal(keys, rows)
    # GDAL ignores the unit if a vertical system is stated, but LAStools writes both.
    height_unit = _UNITS.get(_value(rows, _VERTICAL_UNIT_KEY))
    if text is None:
        return DecodedKeys(None, height_unit)
    axes = stated_axes(text)
    vertical_unit = axes.units[2]
    if axes.kind != "local":
        return DecodedKeys(text, None if height_unit == vertical_unit else height_unit)
    if height_unit is None and axes.has_heights and vertical_unit in METRES_PER_UNIT:
        height_unit = vertical_unit
    # GDAL's fallback is in metres, regardless of the keys.
    codes = [_value(rows, key) for key in _SYSTEM_KEYS.values()]
    code = next((code for code in codes if code not in (0, _USER_DEFINED)), None)
    warnings = () if code is None else (Finding("frame.crs-unreadable", crs=f"EPSG:{code}"),)
    return DecodedKeys(_local_crs(keys, rows), height_unit, warnings)


def read_tiff_keys(path: Path) -> Keys:
    """Return the keys of the first picture of a GeoTIFF; empty if they cannot be read."""
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    try:
        with open_regular_file(path) as file, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # truncated tags
            header = file.read(8)
            header += file.read(8) if header[2:4] in (b"+\0", b"\0+") else b""
            tags = ImageFileDirectory_v2(header)
            file.seek(tags.next)
            tags.load(file)
            shorts, doubles = tags.get(34735, ()), tags.get(34736, ())
            texts = str(tags.get(34737, ""))
        return Keys(
            struct.pack(f"<{len(shorts)}H", *shorts),
            struct.pack(f"<{len(doubles)}d", *doubles),
            texts.encode("latin-1", "replace"),
        )
    except (InputError, OSError, ValueError, SyntaxError, KeyError, TypeError, struct.error):
        return Keys(b"")


def _value(rows: Sequence[tuple[int, int, int, int]], target_key: int) -> int:
    """Return the value of a key that stores a code, or 0 if the key is missing."""
    return next((value for key, offset, _, value in rows if key == target_key and offset == 0), 0)


def _local_crs(keys: Keys, rows: Sequence[tuple[int, int, int, int]]) -> str | None:
    """Return a local CRS with the stated unit of length, or None if no unit is stated."""
    code = _value(rows, _UNIT_KEY)
    name, size = _UNITS.get(code, ""), METRES_PER_UNIT.get(_UNITS.get(code, ""), 0.0)
    for key, offset, _, position in rows:
        if code == _USER_DEFINED and key == _UNIT_SIZE_KEY and offset == 34736:
            name, size = "unit of the file", _read_double(keys.doubles, position)
    if not (isfinite(size) and size > 0):
        return None
    return f'LOCAL_CS["Without a place",UNIT["{name}",{size!r}]]'


def _read_double(doubles: bytes, position: int) -> float:
    if len(doubles) < 8 * position + 8:
        return 0.0
    return float(struct.unpack_from("<d", doubles, 8 * position)[0])


def _decode_with_gdal(keys: Keys, rows: Sequence[tuple[int, int, int, int]]) -> str | None:
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError
    from rasterio.io import MemoryFile

    directory = keys.directory[: 8 + 8 * len(rows)]
    content = _tiff_bytes(directory, keys.doubles[: len(keys.doubles) // 8 * 8], keys.texts)
    try:
        with (
            warnings.catch_warnings(),
            rasterio.Env(**COMPOUND_CRS_OPTIONS),
            MemoryFile(content) as file,
        ):
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with file.open(driver="GTiff") as dataset:
                return None if dataset.crs is None else str(dataset.crs.to_wkt())
    except (RasterioError, ValueError) as error:
        raise _damage_error() from error


def _rows(directory: bytes) -> list[tuple[int, int, int, int]]:
    """Return (key, tag that stores its value or 0, count, value or position) of each key."""
    if len(directory) < 8:
        return []
    count = struct.unpack_from("<H", directory, 6)[0]
    if count > _MAX_KEYS or 8 + 8 * count > len(directory):
        raise _damage_error()
    return [struct.unpack_from("<4H", directory, 8 + 8 * k) for k in range(count)]


def _damage_error() -> InputError:
    return InputError(Finding("frame.damaged-keys"), field="CRS")


def _tiff_bytes(directory: bytes, doubles: bytes, texts: bytes) -> bytes:
    """Return a TIFF of one pixel according to the TIFF 6.0 and GeoTIFF 1.1 specifications."""
    short_type, long_type, double_type, ascii_type = 3, 4, 12, 2
    short_tags = {256: 1, 257: 1, 258: 8, 259: 1, 262: 1, 277: 1, 278: 1, 279: 1}
    long_tags = {
        33550: (double_type, 3, struct.pack("<3d", 1, 1, 0)),
        33922: (double_type, 6, bytes(48)),
        34735: (short_type, len(directory) // 2, directory),
    }
    if doubles:
        long_tags[34736] = (double_type, len(doubles) // 8, doubles)
    if texts:
        text = texts.rstrip(b"\0") + b"\0"
        # Data of four bytes or less would be stored in the tag itself.
        text = text.ljust(5, b"\0")
        long_tags[34737] = (ascii_type, len(text), text)
    count = len(short_tags) + 1 + len(long_tags)
    offset = 8 + 2 + 12 * count + 4
    tags = {
        tag: struct.pack("<HHIHH", tag, short_type, 1, value, 0)
        for tag, value in short_tags.items()
    }
    body = b""
    for tag, (kind, n, content) in long_tags.items():
        tags[tag] = struct.pack("<HHII", tag, kind, n, offset + len(body))
        body += content + b"\0" * (len(content) % 2)
    tags[273] = struct.pack("<HHII", 273, long_type, 1, offset + len(body))
    header = struct.pack("<2sHIH", b"II", 42, 8, count)
    return header + b"".join(tags[tag] for tag in sorted(tags)) + bytes(4) + body + b"\0\0"
