"""Layers of vector files as arrays: here where a file is small, in a process of its own where it is
not.

GDAL reads as long as it takes, and Python stands still meanwhile: no thread of this process could
tell of progress or end the reading. What could take more than a moment is so read by a process that
can be ended at any time, and is held to the memory that the file can be worth.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.files import memory_limit
from vomstudio.files.regular import require_regular
from vomstudio.io.gis.dxf_blocks import refuse_endless_blocks
from vomstudio.io.gis.layer_reading import layers_of
from vomstudio.io.gis.layer_transport import packed, unpacked
from vomstudio.io.text.file_text import MOST_OBJECTS
from vomstudio.paths import import_folders
from vomstudio.progress import Progress, Silent
from vomstudio.words import tr

Shapes = npt.NDArray[np.object_]

_SMALL_BYTES = 2 << 20
"""Read in a fraction of a second by every driver (a DXF of so many entities unfolded, too)."""
_SMALL_DRAWING = 50_000
_LOOK_S = 0.5


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
    asked = {"wanted": list(names), "columns": sorted(columns), "flat": flat}
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
    said = _of_a_process({"path": os.fspath(path.absolute()), **asked}, watched, path)
    if said is None:
        raise InputError(
            tr("Reading this takes more memory than a file of its size can be worth."), file=path
        )
    header, arrays = unpacked(said)
    if header.get("unreadable"):
        raise unreadable()
    if "refused" in header:
        raise InputError(header["refused"], file=header.get("file") or path)
    return [
        VectorLayer(
            each["name"], each["kind"], tuple(each["fields"]), each["crs"], each["described"],
            next(arrays) if each["read"] else None,
            {name: next(arrays) for name in each["columns"]},
        )
        for each in header["layers"]
    ]  # fmt: skip


def _is_small(path: Path) -> bool:
    """With what belongs to it, and unfolded."""
    try:
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
    found, left = [], MOST_OBJECTS
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
                    most=MOST_OBJECTS,
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
def _of_a_process(asked: Mapping[str, Any], progress: Progress, path: Path) -> bytes | None:
    """What it answers; None where it came to no end of its own."""
    process = subprocess.Popen(
        # -P: a json.py beside the file is not Python's.
        [sys.executable, "-P", "-m", __name__],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(import_folders())},
    )
    said: list[bytes] = []
    question = json.dumps(asked).encode("ascii")
    talk = threading.Thread(
        target=lambda: said.append(process.communicate(question)[0]), daemon=True
    )
    talk.start()
    try:
        progress.stage(tr("Reading {file}", file=path.name))
        looks = 0
        while talk.is_alive():
            talk.join(_LOOK_S)
            looks += 1
            progress.step(looks)
    finally:
        if talk.is_alive():
            process.kill()
        talk.join()
    return said[0] if process.returncode == 0 and said else None


def _serve() -> int:
    """Read a question from stdin and write its answer to stdout."""
    out = os.fdopen(os.dup(1), "wb")
    # Libraries print to the other one.
    os.dup2(2, 1)
    asked = json.load(sys.stdin)
    path = Path(asked["path"])
    memory_limit.take_charge()
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
        answer = packed(header, arrays)
    except _Unreadable:
        answer = packed({"unreadable": True}, [])
    except InputError as error:
        answer = packed({"refused": error.message, "file": str(error.file or "")}, [])
    with out:
        out.write(answer)
    return 0


class _Unreadable(InputError):
    """The sentence is known to whoever asks."""


if __name__ == "__main__":
    raise SystemExit(_serve())
