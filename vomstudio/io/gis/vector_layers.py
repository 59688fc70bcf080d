"""Layers of vector files as arrays.

GeoPackages and large files are read in a separate process
(`vomstudio.core.files.untrusted.reader_process`), small files of other formats in this one.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.arrays import AnyArray, ObjectArray
from vomstudio.core.errors import InputError, from_dict
from vomstudio.core.files.file_kinds import find_file_kind
from vomstudio.core.files.regular import open_regular_file, require_regular_file
from vomstudio.core.files.untrusted import reader_process
from vomstudio.core.files.untrusted.databases import SQLITE_SIGNATURE
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.io.gis.dxf_blocks import count_block_entities
from vomstudio.io.gis.layer_reading import SPREADSHEETS, is_local_geojson, readable_layers
from vomstudio.io.gis.layer_transport import pack, unpack
from vomstudio.io.text.file_text import MAX_OBJECTS

_MAX_SMALL_BYTES = 2 << 20
"""Maximum size of a file that every driver reads in a fraction of a second."""
_ZIP_MARK = b"PK\x03\x04"
"""First bytes of a workbook, which is compressed."""
_MAX_SMALL_ENTITIES = 50_000
"""Maximum number of entities of a DXF, with its blocks inserted, that are read as fast."""


@dataclass(frozen=True, eq=False)
class VectorLayer:
    """Layer of a vector file.

    Parameters
    ----------
    name : str
    kind : str or None
        Geometry type, or None for a table without geometry.
    fields : tuple of str
        Names of all columns.
    crs : str or None
        CRS as stated by the file.
    described : str
        Description of the layer; empty if it has none.
    shapes : (n,) array of bytes or None
        Geometries as WKB.
    columns : mapping of str to (n,) array or None
        Requested columns by name; None if not read.
    """

    name: str
    kind: str | None
    fields: tuple[str, ...] = ()
    crs: str | None = None
    described: str = ""
    shapes: ObjectArray | None = None
    columns: Mapping[str, AnyArray] | None = None


def list_layers(
    path: Path,
    reading_error: Callable[[], InputError],
    progress: Progress | None = None,
    *,
    has_sheets: bool = False,
) -> list[VectorLayer]:
    """List the names and kinds of the layers of a file.

    Parameters
    ----------
    path : Path
    reading_error : callable
        As for `readable_layers`.
    progress : Progress, optional
    has_sheets : bool
        Whether the file may be a workbook, whose sheets are layers.

    Raises
    ------
    InputError
        If the file cannot be read.
    Cancelled
    """
    return _request_layers(path, {"names": [], "sheets": has_sheets}, reading_error, progress)


def read_layers(
    path: Path,
    names: Iterable[str | None],
    columns: Collection[str] | None,
    reading_error: Callable[[], InputError],
    progress: Progress | None = None,
    *,
    is_flat: bool = True,
    has_sheets: bool = False,
) -> list[VectorLayer]:
    """Read layers by name.

    Parameters
    ----------
    path : Path
    names : iterable of str or None
        Names of the layers; None for the only layer.
    columns : collection of str or None
        Names of the columns to read, in lower case; None for all.
    reading_error, progress
        As for `list_layers`.
    is_flat : bool
        Whether to drop heights.
    has_sheets : bool
        Whether the file may be a workbook. All rows of its sheets, including a header, are read as
        text.

    Raises
    ------
    InputError
        If the file cannot be read or has too many features.
    Cancelled
    """
    request = {
        "names": list(names),
        "columns": None if columns is None else sorted(columns),
        "flat": is_flat,
        "sheets": has_sheets,
        "max_features": MAX_OBJECTS,
    }
    return _request_layers(path, request, reading_error, progress)


def _request_layers(
    path: Path,
    request: dict[str, Any],
    reading_error: Callable[[], InputError],
    progress: Progress | None,
) -> list[VectorLayer]:
    require_regular_file(path)
    reporter = SilentProgress() if progress is None else progress
    reporter.step(0)
    if _is_small(path):
        with readable_layers(path, reading_error, has_sheets=request["sheets"]) as readable_path:
            return read_named_layers(path, readable_path, request)
    message = {"path": os.fspath(path.absolute()), **request}
    header, arrays = unpack(reader_process.run_reader(__name__, message, reporter, path))
    if header.get("unreadable"):
        raise reading_error()
    if "refused" in header:
        raise _reader_error(header["refused"], path)
    return [
        VectorLayer(
            item["name"],
            item["kind"],
            tuple(item["fields"]),
            item["crs"],
            item["described"],
            next(arrays) if item["read"] else None,
            {name: next(arrays) for name in item["columns"]},
        )
        for item in header["layers"]
    ]


def _reader_error(error_fields: dict[str, Any], path: Path) -> InputError:
    """Return the error of the reader process, which contains the absolute path of the file."""
    error = from_dict(error_fields, InputError.exit_code)
    file = path if error.file in (None, os.fspath(path.absolute())) else error.file
    return InputError(error, file=file, line=error.line, field=error.field)


def _is_small(path: Path) -> bool:
    """Return whether GDAL reads a file and its sidecar files in a fraction of a second."""
    try:
        with open_regular_file(path) as file:
            mark = file.read(len(SQLITE_SIGNATURE))
            if mark == SQLITE_SIGNATURE or mark.startswith(_ZIP_MARK):
                return False
        size = sum(path.stat().st_size for path in path.parent.glob(f"{_escape_glob(path.stem)}.*"))
        if max(size, path.stat().st_size) > _MAX_SMALL_BYTES:
            return False
        if path.suffix.lower() == ".dxf":
            return count_block_entities(path) <= _MAX_SMALL_ENTITIES
    except (OSError, ValueError):
        # The reader reports the error.
        pass
    return True


def _escape_glob(stem: str) -> str:
    return "".join(f"[{character}]" if character in "*?[" else character for character in stem)


def read_named_layers(
    path: Path, readable_path: Path, request: Mapping[str, Any]
) -> list[VectorLayer]:
    """Read layers with pyogrio inside a `readable_layers` block.

    Parameters
    ----------
    path : Path
        Path of the file, for error messages.
    readable_path : Path
        Path yielded by `readable_layers`.
    request : mapping
        Request built by `read_layers`.

    Raises
    ------
    InputError
        If there are too many features.
    """
    import pyogrio

    listed_layers = [
        (str(n), None if k is None else str(k)) for n, k in pyogrio.list_layers(readable_path)
    ]
    if not request["names"]:
        return [VectorLayer(name, kind) for name, kind in listed_layers]
    if not listed_layers:
        return []
    kinds = dict(listed_layers)
    kind = find_file_kind(readable_path)
    is_spreadsheet = kind is not None and kind.key in SPREADSHEETS
    # Otherwise, GDAL guesses the header and the types of the columns.
    options = {"HEADERS": "DISABLE", "FIELD_TYPES": "STRING"} if is_spreadsheet else {}
    layers, remaining_count = [], request["max_features"]
    is_local = is_local_geojson(readable_path)
    for layer in request["names"]:
        info = pyogrio.read_info(readable_path, layer=layer, **options)
        fields = tuple(map(str, info["fields"]))
        names = request["columns"]
        columns = [field for field in fields if names is None or field.casefold() in names]
        metadata, _, shapes, values = pyogrio.raw.read(
            readable_path,
            layer=layer,
            columns=columns,
            force_2d=request["flat"],
            # Not every driver can count features before reading them.
            max_features=remaining_count + 1,
            **options,
        )
        remaining_count -= len(next(iter(values), ())) if shapes is None else len(shapes)
        if remaining_count < 0:
            raise InputError(
                Finding("file.too-many-parts", limit=request["max_features"], parts=tr("entries")),
                file=path,
            )
        name = str(
            info.get("layer_name") or layer or (listed_layers[0][0] if listed_layers else "")
        )
        crs = None if metadata["crs"] is None or is_local else str(metadata["crs"])
        layers.append(
            VectorLayer(
                name,
                kinds.get(name),
                fields,
                crs,
                str((info.get("layer_metadata") or {}).get("DESCRIPTION", "")),
                shapes,
                dict(zip(map(str, metadata["fields"]), values, strict=True)),
            )
        )
    return layers


# --- the process ----------------------------------------------------------------------------------
def _process_request(request: dict[str, Any]) -> bytes:
    """Process a request in the reader process."""
    path = Path(request["path"])
    try:
        with readable_layers(
            path, lambda: _Unreadable(path.name), has_sheets=request["sheets"]
        ) as readable_path:
            layers = read_named_layers(path, readable_path, request)
        header: dict[str, Any] = {"layers": []}
        arrays = []
        for layer in layers:
            columns = layer.columns or {}
            properties = {
                n: getattr(layer, n) for n in ("name", "kind", "fields", "crs", "described")
            }
            is_read = layer.shapes is not None
            header["layers"].append({**properties, "read": is_read, "columns": list(columns)})
            arrays += [layer.shapes] * is_read + list(columns.values())
        return pack(header, arrays)
    except _Unreadable:
        return pack({"unreadable": True}, [])
    except InputError as error:
        return pack({"refused": error.to_dict()}, [])


class _Unreadable(InputError):
    """Error for an unreadable file; the requesting process produces the message."""


if __name__ == "__main__":
    # If pyogrio finds these modules it imports them, which takes longer than reading most files.
    for module_name in ("pandas", "pyarrow", "pyproj"):
        sys.modules[module_name] = None  # type: ignore[assignment]
    raise SystemExit(reader_process.serve(_process_request))
