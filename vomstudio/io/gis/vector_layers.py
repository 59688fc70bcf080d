"""Layers of vector files as arrays.

GeoPackages, and files that take GDAL more than a moment, are read in a process of their own
(`vomstudio.files.untrusted.reader_process`); small files of other formats are read here.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.files.regular import open_regular, require_regular
from vomstudio.files.untrusted import reader_process
from vomstudio.files.untrusted.databases import SQLITE_MARK
from vomstudio.io.gis.dxf_blocks import refuse_endless_blocks
from vomstudio.io.gis.layer_reading import layers_of
from vomstudio.io.gis.layer_transport import packed, unpacked
from vomstudio.io.text.file_text import MOST_OBJECTS
from vomstudio.progress import Progress, Silent
from vomstudio.words import tr

Shapes = npt.NDArray[np.object_]

_SMALL_BYTES = 2 << 20
"""Read in a fraction of a second by every driver (a DXF of so many entities unfolded, too)."""
_SMALL_DRAWING = 50_000


@dataclass(frozen=True, eq=False)
class VectorLayer:
    """kind : of its geometry, None for a table without any; fields : names of all columns; crs : as
    it states it; described : in words, "" mostly; shapes : (n,) WKB; columns : (n,) each, those
    that were wanted, by their names"""

    name: str
    kind: str | None
    fields: tuple[str, ...] = ()
    crs: str | None = None
    described: str = ""
    shapes: Shapes | None = None
    columns: Mapping[str, npt.NDArray[Any]] | None = None


def list_layers(
    path: Path, unreadable: Callable[[], InputError], progress: Progress | None = None
) -> list[VectorLayer]:
    """Names and kinds of the layers alone. unreadable : as of `layers_of`. Raises InputError, and
    Cancelled."""
    return _answered(path, {"wanted": []}, unreadable, progress)


def read_layers(
    path: Path,
    names: Iterable[str | None],
    columns: Collection[str],
    unreadable: Callable[[], InputError],
    progress: Progress | None = None,
    *,
    flat: bool = True,
) -> list[VectorLayer]:
    """The named layers (None: the only one) with those of their columns that have one of these
    names, in small letters: the others may be any number. flat : without heights. Raises as
    `list_layers`."""
    asked = {
        "wanted": list(names),
        "columns": sorted(columns),
        "flat": flat,
        "most": MOST_OBJECTS,
    }
    return _answered(path, asked, unreadable, progress)


def _answered(
    path: Path,
    asked: dict[str, Any],
    unreadable: Callable[[], InputError],
    progress: Progress | None,
) -> list[VectorLayer]:
    require_regular(path)
    watched = Silent() if progress is None else progress
    watched.step(0)
    if _is_small(path):
        with layers_of(path, unreadable) as named:
            return layers_read(path, named, asked)
    question = {"path": os.fspath(path.absolute()), **asked}
    header, arrays = unpacked(reader_process.ask(__name__, question, watched, path))
    if header.get("unreadable"):
        raise unreadable()
    if "refused" in header:
        raise _refusal(header["refused"], path)
    return [
        VectorLayer(
            each["name"], each["kind"], tuple(each["fields"]), each["crs"], each["described"],
            next(arrays) if each["read"] else None,
            {name: next(arrays) for name in each["columns"]},
        )
        for each in header["layers"]
    ]  # fmt: skip


def _refusal(refused: Mapping[str, Any], path: Path) -> InputError:
    """Return the error of the other process, which knows the file by its absolute path."""
    file = path if refused["file"] in (None, os.fspath(path.absolute())) else refused["file"]
    error = InputError(refused["message"], file=file, line=refused["line"], field=refused["field"])
    error.code = refused["code"]
    known = ("code", "file", "line", "field", "message")
    error.values = {name: value for name, value in refused.items() if name not in known}
    return error


def _is_small(path: Path) -> bool:
    """Return whether GDAL reads a file, with what belongs to it, in a moment."""
    try:
        with open_regular(path) as file:
            if file.read(len(SQLITE_MARK)) == SQLITE_MARK:
                return False
        size = sum(p.stat().st_size for p in path.parent.glob(f"{_plain(path.stem)}.*"))
        if max(size, path.stat().st_size) > _SMALL_BYTES:
            return False
        if path.suffix.lower() == ".dxf":
            return refuse_endless_blocks(path) <= _SMALL_DRAWING
    except (OSError, ValueError):
        # Its reader says why.
        pass
    return True


def _plain(stem: str) -> str:
    return "".join(f"[{sign}]" if sign in "*?[" else sign for sign in stem)


def layers_read(path: Path, named: Path, asked: Mapping[str, Any]) -> list[VectorLayer]:
    """By pyogrio, within `layers_of`, which named it. Raises InputError for more than can be
    worked with."""
    import pyogrio

    known = [(str(n), None if k is None else str(k)) for n, k in pyogrio.list_layers(named)]
    if not asked["wanted"]:
        return [VectorLayer(name, kind) for name, kind in known]
    if not known:
        return []
    kinds = dict(known)
    found, left = [], asked["most"]
    for layer in asked["wanted"]:
        info = pyogrio.read_info(named, layer=layer)
        fields = tuple(map(str, info["fields"]))
        wanted = [field for field in fields if field.casefold() in asked["columns"]]
        told, _, shapes, values = pyogrio.raw.read(
            named,
            layer=layer,
            columns=wanted,
            force_2d=asked["flat"],
            # Not every driver can say how many there are before they are read.
            max_features=left + 1,
        )
        left -= 0 if shapes is None else len(shapes)
        if left < 0:
            raise InputError(
                tr(
                    "The layers have more than {most:,} entries, which is more than can be read. "
                    "Divide them, or leave out what is not needed.",
                    most=asked["most"],
                ),
                file=path,
            )
        name = str(info.get("layer_name") or layer or (known[0][0] if known else ""))
        found.append(
            VectorLayer(
                name, kinds.get(name), fields, None if told["crs"] is None else str(told["crs"]),
                str((info.get("layer_metadata") or {}).get("DESCRIPTION", "")), shapes,
                dict(zip(map(str, told["fields"]), values, strict=True)),
            )
        )  # fmt: skip
    return found


# --- the process ----------------------------------------------------------------------------------
def _answer(asked: dict[str, Any]) -> bytes:
    """Answer a question in the process of its own."""
    path = Path(asked["path"])
    try:
        with layers_of(path, lambda: _Unreadable(path.name)) as named:
            layers = layers_read(path, named, asked)
        header: dict[str, Any] = {"layers": []}
        arrays = []
        for layer in layers:
            columns = layer.columns or {}
            about = {n: getattr(layer, n) for n in ("name", "kind", "fields", "crs", "described")}
            read = layer.shapes is not None
            header["layers"].append({**about, "read": read, "columns": list(columns)})
            arrays += [layer.shapes] * read + list(columns.values())
        return packed(header, arrays)
    except _Unreadable:
        return packed({"unreadable": True}, [])
    except InputError as error:
        return packed({"refused": error.as_dict()}, [])


class _Unreadable(InputError):
    """The sentence is known to whoever asks."""


if __name__ == "__main__":
    raise SystemExit(reader_process.serve(_answer))
