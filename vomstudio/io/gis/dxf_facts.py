"""What a drawing for CAD says of itself that GDAL does not pass on: its unit, which layers are
hidden, and which entities are dimensions rather than lines of the drawing.

A DXF is a list of groups, a code and a value each: two lines of text, or a number and bytes.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.files.regular import read_small
from vomstudio.io.gis.layer_reading import symbol_layers
from vomstudio.words import tr, tr_n

Group = tuple[int, bytes | int | float]
Piece = tuple[bytes, Sequence[Group]]
"""What stands from one group of code 0 to the next: its value, and the groups behind it."""
Left = tuple[npt.NDArray[np.bool_], list[str]]

_LARGEST = 512 << 20
_UNITS = {1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144}
_UNITS |= {14: 0.1, 15: 10.0, 16: 100.0, 21: 1200 / 3937}
"""Metres in a unit by the number of $INSUNITS."""
_BINARY = b"AutoCAD Binary DXF\r\n\x1a\0"
_FROZEN = 1
_NO_LINES = (b"DIMENSION", b"LEADER", b"MULTILEADER", b"ARC_DIMENSION", b"LARGE_RADIAL_DIMENSION")
_TOLD = (b"SECTION", b"LAYER", b"SPLINE", *_NO_LINES)
# A code is a number: a line of 0 before one of letters is a code. A line of 60 may be a value.
_BEGINS = re.compile(rb"(?m)^[ \t]*0[ \t]*\r?\n[ \t]*([A-Z][A-Za-z0-9_]*)[ \t]*\r?\n")
_UNSEEN = re.compile(rb"(?m)^[ \t]*60[ \t]*\r?\n[ \t]*1[ \t]*\r?$")


@dataclass(frozen=True)
class DxfFacts:
    """unit_m : metres in a unit, None where it is not said; hidden : layers that are off or frozen,
    in small letters; notes : handles of dimensions and leaders; unseen : of entities that are
    invisible; fit_only : splines that have points to go through and no control points"""

    unit_m: float | None = None
    hidden: frozenset[str] = frozenset()
    notes: frozenset[str] = frozenset()
    unseen: frozenset[str] = frozenset()
    fit_only: int = 0


def dxf_facts(path: str | Path) -> DxfFacts:
    """Of a drawing; nothing of one that cannot be read. Raises InputError where it is too large."""
    try:
        data = read_small(path, _LARGEST)
    except OSError:
        return DxfFacts()
    try:
        return _found(_binary(data) if data.startswith(_BINARY) else _text(data))
    except (ValueError, struct.error, IndexError):
        return DxfFacts()


def features_of(path: Path, fields: Mapping[str, npt.NDArray[Any]], count: int) -> Left:
    """(n,) which of the entities that GDAL reads of a drawing are lines of it, and what was left
    out in words: symbols beside features, hidden layers, sheets (paper space), dimensions."""
    keep = np.ones(count, bool)
    layers = [str(name).casefold() for name in fields.get("Layer", np.full(count, ""))]
    symbols = symbol_layers(layers)
    if symbols:
        keep &= np.array([name not in symbols for name in layers], bool)
    facts = dxf_facts(path)
    handles = [str(handle).upper() for handle in fields.get("EntityHandle", np.full(count, ""))]
    classes = [str(name) for name in fields.get("SubClasses", np.full(count, ""))]
    paper = np.asarray(fields.get("PaperSpace", np.zeros(count)), np.float64) == 1.0
    off = np.array([name in facts.hidden for name in layers], bool)
    off |= np.array([handle in facts.unseen for handle in handles], bool)
    note = np.array([handle in facts.notes for handle in handles], bool)
    note |= np.array(["AcDbLeader" in c or "AcDbMLeader" in c for c in classes], bool)
    said = []
    for left, text in (
        (
            paper,
            tr_n(
                "{count} shape of a sheet (paper space) is left out.",
                "{count} shapes of sheets (paper space) are left out.",
                int((keep & paper).sum()),
            ),
        ),
        (
            off & ~paper,
            tr_n(
                "{count} shape that is hidden (off, frozen) is left out.",
                "{count} shapes that are hidden (off, frozen) are left out.",
                int((keep & off & ~paper).sum()),
            ),
        ),
        (
            note & ~off & ~paper,
            tr("The dimensions and leaders of the drawing are left out."),
        ),
    ):
        if (keep & left).any():
            said.append(text)
            keep = keep & ~left
    return keep, said


def why_unreadable(path: Path) -> str | None:
    """A sentence where GDAL cannot read a drawing, and it is known why."""
    if path.suffix.lower() != ".dxf" or not (count := dxf_facts(path).fit_only):
        return None
    return tr_n(
        "{count} spline has only the points that it goes through. Turn it into a polyline and save "
        "the drawing again.",
        "{count} splines have only the points that they go through. Turn them into polylines and "
        "save the drawing again.",
        count,
    )


def _found(pieces: Iterator[Piece]) -> DxfFacts:
    unit: float | None = None
    hidden, notes, unseen = set[str](), set[str](), set[str]()
    fit_only = 0
    section: object = b""
    for kind, groups in pieces:
        first: dict[int, Any] = {}
        for code, value in groups:
            first.setdefault(code, value)
        if kind == b"SECTION":
            section = first.get(2)
            if section == b"HEADER":
                unit = _unit(groups)
        elif kind == b"LAYER" and section == b"TABLES" and 2 in first:
            if int(first.get(70, 0)) & _FROZEN or int(first.get(62, 7)) < 0:
                hidden.update(_names(first[2]))
        elif section == b"ENTITIES" and 5 in first:
            handle = _bytes(first[5]).decode("latin-1").upper()
            if kind in _NO_LINES:
                notes.add(handle)
            if int(first.get(60, 0)) == 1:
                unseen.add(handle)
        if kind == b"SPLINE" and 11 in first and 10 not in first:
            fit_only += 1
    return DxfFacts(unit, frozenset(hidden), frozenset(notes), frozenset(unseen), fit_only)


def _unit(header: Sequence[Group]) -> float | None:
    of_unit = False
    for code, value in header:
        if code == 9:
            of_unit = value == b"$INSUNITS"
        elif code == 70 and of_unit:
            return _UNITS.get(int(value))
    return None


def _bytes(value: bytes | float) -> bytes:
    return value if isinstance(value, bytes) else str(value).encode()


def _names(value: bytes | float) -> set[str]:
    """What GDAL may call a layer: by the code page that the drawing names, right or wrong, and with
    letters that DXF spells (U+00E9)."""
    raw = _bytes(value)
    found = {raw.decode("utf-8", "replace"), raw.decode("cp1252", "replace"), raw.decode("latin-1")}
    found |= {
        re.sub(r"\\U\+([0-9A-Fa-f]{4})", lambda m: chr(int(m.group(1), 16)), t) for t in found
    }
    return {text.casefold() for text in found}


def _text(data: bytes) -> Iterator[Piece]:
    """Of a million entities only those that say something are taken apart."""
    kind, begin = b"", 0
    for found in chain(_BEGINS.finditer(data), (None,)):
        end = len(data) if found is None else found.start()
        if kind in _TOLD or _UNSEEN.search(data, begin, end):
            lines = data[begin:end].splitlines()
            pairs = zip(lines[0::2], lines[1::2], strict=False)
            yield kind, [(int(code), value.strip()) for code, value in pairs]
        if found is not None:
            kind, begin = found.group(1), found.end()


_SIZES = (
    (range(10), 0), (range(10, 60), 8), (range(60, 80), 2), (range(90, 100), 4),
    (range(100, 110), 0), (range(110, 160), 8), (range(160, 170), 8), (range(170, 180), 2),
    (range(210, 240), 8), (range(270, 290), 2), (range(290, 300), 1), (range(300, 310), 0),
    (range(310, 320), -1), (range(320, 370), 0), (range(370, 390), 2), (range(390, 400), 0),
    (range(400, 410), 2), (range(410, 420), 0), (range(420, 430), 4), (range(430, 440), 0),
    (range(440, 460), 4), (range(460, 470), 8), (range(470, 482), 0), (range(999, 1004), 0),
    (range(1004, 1005), -1), (range(1005, 1010), 0), (range(1010, 1060), 8),
    (range(1060, 1071), 2), (range(1071, 1072), 4),
)  # fmt: skip
"""Bytes of a value by its code: 0 for text up to a zero, -1 for a length and so many bytes."""


def _binary(data: bytes) -> Iterator[Piece]:
    kind, groups = b"", list[Group]()
    for code, value in _binary_groups(data):
        if code == 0:
            yield kind, groups
            kind, groups = _bytes(value), []
        else:
            groups.append((code, value))
    yield kind, groups


def _binary_groups(data: bytes) -> Iterator[Group]:
    at = len(_BINARY)
    sizes = {code: size for codes, size in _SIZES for code in codes}
    while at + 2 <= len(data):
        (code,) = struct.unpack_from("<H", data, at)
        at += 2
        size = sizes.get(code, 0)
        if size == 0:
            end = data.index(b"\0", at)
            yield code, data[at:end]
            at = end + 1
        elif size < 0:
            at += 1 + data[at]
        else:
            if size in (1, 2, 4):
                yield code, int.from_bytes(data[at : at + size], "little", signed=True)
            elif code < 60:
                yield code, 0.0
            at += size
