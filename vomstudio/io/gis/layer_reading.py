"""Layers of vector files through GDAL: of the formats that are named here, and of no other.

GDAL chooses a driver by the content, whatever the file is called. Some of its drivers open other
files, or ask servers, because the file says so: a virtual layer may be called `faults.geojson`, and
the CRS of a real GeoJSON may be the address of a page. Nothing is fetched from the network here.
"""

from __future__ import annotations

import contextlib
import os
import re
import threading
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.memory_limit import limited_by
from vomstudio.core.files.names import utf8_name
from vomstudio.core.files.regular import open_regular, read_json, require_regular_beside
from vomstudio.core.files.untrusted.databases import SQLITE_MARK, require_geopackage
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.gis.dxf_blocks import refuse_endless_blocks
from vomstudio.io.gis.dxf_splines import with_control_points
from vomstudio.io.text.xml_tree import refuse_many_tags

NO_NETWORK = {"GDAL_HTTP_PROXY": "127.0.0.1:9", "GDAL_HTTPS_PROXY": "127.0.0.1:9"}
"""Options of GDAL: whatever is asked for goes to the port of this machine that discards it."""

SYMBOLS = "_symbols"
"""At the end of the name of a layer: what stands beside the features of another one, to be looked
at."""

_HEAD = 4096
_SHAPEFILE = b"\0\0\x27\x0a"
_DXF = re.compile(rb"\s*\d{1,4}[ \t]*\r?\n|AutoCAD Binary DXF")
_BINARY_DXF = b"AutoCAD Binary DXF"
_JSON = re.compile(rb"(?:\xef\xbb\xbf)?\s*\{")
_KML = re.compile(rb"(?:\xef\xbb\xbf)?\s*<(?:[^>]*>\s*<)*?(?:kml:)?kml[\s>]", re.IGNORECASE)
_JSON_NAME = re.compile(rb'"([^"\n]{1,200})"\s*:')
_BLOCK, _NAME_BYTES = 8 << 20, 1000
_MOST_TAGS = 2_000_000
"""Of KML, of which GDAL keeps all at once, some 300 bytes for each."""
_MOST_NAMES = 2000
"""As many columns as a table of SQLite has at most (SQLite: Limits in SQLite)."""
_options = threading.Lock()


@contextlib.contextmanager
def layers_of(path: Path, unreadable: Callable[[], InputError]) -> Iterator[Path]:
    """A name of the file under which pyogrio may be asked for its layers inside.

    unreadable : the sentence for what is no GeoPackage, GeoJSON, shapefile, DXF or KML, or cannot
        be read as one. Raises InputError.
    """
    import pyogrio
    from pyogrio.errors import DataLayerError, DataSourceError, FeatureError, GeometryError

    require_regular_beside(path)
    try:
        with open_regular(path) as file:
            head = file.read(_HEAD)
        if not _is_known(head):
            raise unreadable()
        if head.startswith(SQLITE_MARK):
            require_geopackage(path)
        elif _JSON.match(head):
            _refuse_names_without_end(path)
        elif _KML.match(head):
            with open_regular(path) as file:
                refuse_many_tags(iter(partial(file.read, _BLOCK), b""), path, _MOST_TAGS)
        elif _DXF.match(head):
            _refuse_lost_line_feed(path, head)
            _refuse_zeros(path, head)
            refuse_endless_blocks(path)
        drawing = with_control_points(path) if _DXF.match(head) else contextlib.nullcontext(path)
        with drawing as given, utf8_name(given) as named, _options, limited_by(path):
            pyogrio.set_gdal_config_options(NO_NETWORK)
            try:
                yield named
            finally:
                pyogrio.set_gdal_config_options(dict.fromkeys(NO_NETWORK))
    except MemoryError as error:
        raise InputError(Finding("file.memory-exceeded"), file=path) from error
    except (
        DataSourceError,
        DataLayerError,
        FeatureError,
        GeometryError,
        OSError,
        ValueError,
        # pyogrio's own, where GDAL cannot write a damaged CRS as text.
        UnboundLocalError,
    ) as error:
        raise unreadable() from error


def _is_known(head: bytes) -> bool:
    return head.startswith((SQLITE_MARK, _SHAPEFILE)) or (
        any(kind.match(head) for kind in (_JSON, _DXF, _KML)) and b"<OGRVRT" not in head
    )


def _refuse_lost_line_feed(path: Path, head: bytes) -> None:
    """GDAL never comes to the end of a drawing whose last byte is a carriage return. Raises
    InputError."""
    if head.startswith(_BINARY_DXF):
        return
    with open_regular(path) as file:
        file.seek(-1, os.SEEK_END)
        last = file.read(1)
    if last == b"\r":
        raise InputError(
            Finding("file.damaged", format="DXF", reason=tr("it ends in the middle of a line")),
            file=path,
        )


def _refuse_zeros(path: Path, head: bytes) -> None:
    """GDAL never comes to the end of a drawing in text with zero bytes in it; what follows its end
    is not read. Raises InputError."""
    if head.startswith(_BINARY_DXF):
        return
    before, begin = b"", 0
    with open_regular(path) as file:
        while block := file.read(_BLOCK):
            at = block.find(b"\0")
            before = (before + (block if at < 0 else block[:at])[-_LAST_WORD:])[-_LAST_WORD:]
            if at >= 0 and before.split()[-1:] != [b"EOF"]:
                raise InputError(Finding("file.blank", byte=begin + at + 1), file=path)
            if at >= 0:
                return
            begin += len(block)


_LAST_WORD = 16


def _refuse_names_without_end(path: Path) -> None:
    """Each name in a JSON becomes a column of every shape: a short file fills any memory so. Raises
    InputError."""
    names: set[bytes] = set()
    with open_regular(path) as file:
        while block := file.read(_BLOCK):
            # To the end of the line or of the value, so that no name is cut.
            block += file.readline(_NAME_BYTES)
            names.update(_JSON_NAME.findall(block))
            if len(names) > _MOST_NAMES:
                raise InputError(
                    Finding("file.too-many-parts", limit=_MOST_NAMES, parts=tr("attributes")),
                    file=path,
                )


def symbol_layers(names: Iterable[str]) -> set[str]:
    """Of the layers of a drawing those that only hold symbols: `bedding_symbols` beside `bedding`
    or `bedding_planes`."""
    every = {name.casefold() for name in names}
    found = set()
    for name in every:
        base = name.removesuffix(SYMBOLS)
        beside = any(other == base or other.startswith(f"{base}_") for other in every - {name})
        if base and base != name and beside:
            found.add(name)
    return found


def names_no_crs(path: Path) -> bool:
    """Whether this is a GeoJSON without a `crs` member, which GDAL takes to be in degrees."""
    if path.suffix.lower() not in (".json", ".geojson"):
        return False
    try:
        told = read_json(path)
    except (OSError, ValueError):
        # Lines of GeoJSON one after the other have no place for the member.
        return True
    return not (isinstance(told, dict) and told.get("crs"))
