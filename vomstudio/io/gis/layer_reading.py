"""Reading of layers of vector files with GDAL, restricted to the formats listed here.

GDAL chooses a driver by the content and not by the file name. Some drivers open other files or send
requests if the file refers to them: a virtual layer may be named `faults.geojson`, and the CRS of a
GeoJSON file may be the address of a web page. Here, nothing is loaded from the network.
"""

from __future__ import annotations

import contextlib
import os
import re
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import recognise_kind
from vomstudio.core.files.memory_limit import limit_for_file
from vomstudio.core.files.names import utf8_name
from vomstudio.core.files.regular import open_regular_file, read_json, require_regular_siblings
from vomstudio.core.files.untrusted.databases import SQLITE_SIGNATURE, require_geopackage
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gis.dxf_blocks import count_block_entities
from vomstudio.io.gis.dxf_splines import add_spline_control_points
from vomstudio.io.text.xml_tree import refuse_many_tags

OFFLINE_OPTIONS = {"GDAL_HTTP_PROXY": "127.0.0.1:9", "GDAL_HTTPS_PROXY": "127.0.0.1:9"}
"""GDAL options that send all requests to the discard port of this machine."""

SYMBOL_SUFFIX = "_symbols"
"""Suffix of the name of a layer that contains symbols for the features of another layer."""

_HEAD_BYTES = 4096
_NO_CRS = re.compile(rb'"crs"\s*:\s*null\b')
_SHAPEFILE = b"\0\0\x27\x0a"
_DXF = re.compile(rb"\s*\d{1,4}[ \t]*\r?\n|AutoCAD Binary DXF")
_BINARY_DXF = b"AutoCAD Binary DXF"
_JSON = re.compile(rb"(?:\xef\xbb\xbf)?\s*\{")
_KML = re.compile(rb"(?:\xef\xbb\xbf)?\s*<(?:[^>]*>\s*<)*?(?:kml:)?kml[\s>]", re.IGNORECASE)
_JSON_NAME = re.compile(rb'"([^"\n]{1,200})"\s*:')
_BLOCK_BYTES, _NAME_BYTES = 8 << 20, 1000
_MAX_KML_TAGS = 2_000_000
"""Maximum number of tags; GDAL stores all of them, using about 300 bytes for each."""
_MAX_ATTRIBUTES = 2000
"""Maximum number of columns of an SQLite table (SQLite: Limits in SQLite)."""
SPREADSHEETS = frozenset({"xlsx", "ods"})
"""Kinds of workbooks; their sheets are layers without geometry."""
_gdal_lock = threading.Lock()


@contextlib.contextmanager
def readable_layers(
    path: Path, reading_error: Callable[[], InputError], *, has_sheets: bool = False
) -> Iterator[Path]:
    """Yield a path from which pyogrio can read the layers of a file inside the block.

    Parameters
    ----------
    path : Path
    reading_error : callable
        Function that returns the error for a file that is not a valid GeoPackage, GeoJSON,
        shapefile, DXF or KML file.
    has_sheets : bool
        Whether the file may be a workbook.

    Raises
    ------
    InputError
        If the file has another format, is damaged, or would exceed the memory.
    """
    import pyogrio
    from pyogrio.errors import DataLayerError, DataSourceError, FeatureError, GeometryError

    require_regular_siblings(path)
    try:
        with open_regular_file(path) as file:
            header = file.read(_HEAD_BYTES)
        if not (is_vector_file(header) or (has_sheets and is_spreadsheet(header))):
            raise reading_error()
        if header.startswith(SQLITE_SIGNATURE):
            require_geopackage(path)
        elif _JSON.match(header):
            _refuse_many_attributes(path)
        elif _KML.match(header):
            with open_regular_file(path) as file:
                refuse_many_tags(iter(partial(file.read, _BLOCK_BYTES), b""), path, _MAX_KML_TAGS)
        elif _DXF.match(header):
            _refuse_truncated_dxf(path, header)
            _refuse_zero_bytes(path, header)
            count_block_entities(path)
        drawing_context = (
            add_spline_control_points(path) if _DXF.match(header) else contextlib.nullcontext(path)
        )
        with (
            drawing_context as source,
            utf8_name(source) as utf8_path,
            _gdal_lock,
            limit_for_file(path),
        ):
            pyogrio.set_gdal_config_options(OFFLINE_OPTIONS)
            # GDAL reports the faces of a DXF, which are valid rings that are not closed.
            warnings.filterwarnings("ignore", "Non closed ring detected", RuntimeWarning)
            try:
                yield utf8_path
            finally:
                pyogrio.set_gdal_config_options(dict.fromkeys(OFFLINE_OPTIONS))
    except MemoryError as error:
        raise InputError(Finding("file.memory-exceeded"), file=path) from error
    except (
        DataSourceError,
        DataLayerError,
        FeatureError,
        GeometryError,
        OSError,
        ValueError,
        # Raised in pyogrio if GDAL cannot write a damaged CRS as text.
        UnboundLocalError,
    ) as error:
        raise reading_error() from error


def is_vector_file(head: bytes) -> bool:
    """Return whether a file is a vector file that GDAL may read.

    Parameters
    ----------
    head : bytes
        First bytes of the file.
    """
    return head.startswith((SQLITE_SIGNATURE, _SHAPEFILE)) or (
        any(kind.match(head) for kind in (_JSON, _DXF, _KML)) and b"<OGRVRT" not in head
    )


def is_spreadsheet(head: bytes) -> bool:
    """Return whether a file is a workbook.

    Parameters
    ----------
    head : bytes
        First bytes of the file.

    Returns
    -------
    bool
    """
    kind = recognise_kind(head)
    return kind is not None and kind.key in SPREADSHEETS


def _refuse_truncated_dxf(path: Path, head: bytes) -> None:
    """Raise InputError for a text DXF file that ends with a carriage return.

    GDAL would not terminate on such a file.
    """
    if head.startswith(_BINARY_DXF):
        return
    with open_regular_file(path) as file:
        file.seek(-1, os.SEEK_END)
        last_byte = file.read(1)
    if last_byte == b"\r":
        raise InputError(
            Finding("file.damaged", format="DXF", reason=tr("it ends in the middle of a line")),
            file=path,
        )


def _refuse_zero_bytes(path: Path, head: bytes) -> None:
    """Raise InputError for a text DXF file with zero bytes before its end.

    GDAL would not terminate on such a file.
    """
    if head.startswith(_BINARY_DXF):
        return
    last_bytes, offset = b"", 0
    with open_regular_file(path) as file:
        while block := file.read(_BLOCK_BYTES):
            position = block.find(b"\0")
            last_bytes = (
                last_bytes + (block if position < 0 else block[:position])[-_LAST_WORD_BYTES:]
            )[-_LAST_WORD_BYTES:]
            if position >= 0 and last_bytes.split()[-1:] != [b"EOF"]:
                raise InputError(Finding("file.blank", byte=offset + position + 1), file=path)
            if position >= 0:
                return
            offset += len(block)


_LAST_WORD_BYTES = 16


def _refuse_many_attributes(path: Path) -> None:
    """Raise InputError for a GeoJSON file with too many attribute names.

    Each name becomes a column of every shape, so a short file could exhaust the memory.
    """
    names: set[bytes] = set()
    with open_regular_file(path) as file:
        while block := file.read(_BLOCK_BYTES):
            # Read to the end of the line so that no name is split.
            block += file.readline(_NAME_BYTES)
            names.update(_JSON_NAME.findall(block))
            if len(names) > _MAX_ATTRIBUTES:
                raise InputError(
                    Finding("file.too-many-parts", limit=_MAX_ATTRIBUTES, parts=tr("attributes")),
                    file=path,
                )


def symbol_layers(names: Iterable[str]) -> set[str]:
    """Return the names of the layers that contain symbols, in lower case.

    For example, `bedding_symbols` is returned if there is a layer `bedding` or `bedding_planes`.
    """
    all_names = {name.casefold() for name in names}
    layers = set()
    for name in all_names:
        base = name.removesuffix(SYMBOL_SUFFIX)
        has_base = any(
            other_name == base or other_name.startswith(f"{base}_")
            for other_name in all_names - {name}
        )
        if base and base != name and has_base:
            layers.add(name)
    return layers


def is_geojson_without_crs(path: Path) -> bool:
    """Return whether a file is GeoJSON without a member `crs`, which GDAL reads as degrees."""
    if path.suffix.lower() not in (".json", ".geojson"):
        return False
    try:
        content = read_json(path)
    except (OSError, ValueError):
        # A sequence of GeoJSON lines cannot have this member.
        return True
    return not (isinstance(content, dict) and "crs" in content)


def is_local_geojson(path: Path) -> bool:
    """Return whether a file is GeoJSON whose `crs` is null, so that its CRS is unknown.

    GDAL reads such coordinates as degrees.

    Parameters
    ----------
    path : Path

    Returns
    -------
    bool
    """
    if path.suffix.lower() not in (".json", ".geojson"):
        return False
    with open_regular_file(path) as file:
        return _NO_CRS.search(file.read(_HEAD_BYTES)) is not None
