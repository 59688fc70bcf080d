"""Properties of DXF drawings that GDAL does not report: unit, hidden layers, dimensions."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.io.gis.dxf_groups import DxfPiece, Groups, Value, dxf_pieces, text_of
from vomstudio.io.gis.layer_reading import symbol_layers

Left = tuple[BoolArray, list[Finding]]

_UNITS = {1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144}
_UNITS |= {14: 0.1, 15: 10.0, 16: 100.0, 21: 1200 / 3937}
"""Metres per unit by the value of $INSUNITS."""
ENTITY_COLUMNS = ("paperspace", "subclasses", "entityhandle")
"""Columns of GDAL for an entity besides its layer, in lower case."""
_FROZEN = 1
_NO_LINES = (b"DIMENSION", b"LEADER", b"MULTILEADER", b"ARC_DIMENSION", b"LARGE_RADIAL_DIMENSION")
_PARSED_KINDS = (b"SECTION", b"LAYER", b"SPLINE", b"POLYLINE", *_NO_LINES)
_BODIES = frozenset(
    (b"3DSOLID", b"BODY", b"REGION", b"SURFACE", b"EXTRUDEDSURFACE", b"LOFTEDSURFACE", b"MESH")
    + (b"REVOLVEDSURFACE", b"SWEPTSURFACE", b"PLANESURFACE", b"NURBSURFACE")
    + (b"ACAD_PROXY_ENTITY", b"ACAD_PROXY_OBJECT")
)
"""Entities without lines that GDAL skips without a message."""
POLYGON_MESH, POLYFACE_MESH = 16, 64
"""Flags of a POLYLINE that is a surface."""


@dataclass(frozen=True)
class DxfFacts:
    """Properties of a drawing.

    unit_m : metres per unit, None if not stated; hidden : layers that are off or frozen, in lower
    case; notes : handles of dimensions and leaders; unseen : handles of invisible entities
    fit_only : number of splines with fit points but no control points
    bodies : number of solids, surfaces and proxies by entity name
    """

    unit_m: float | None = None
    hidden: frozenset[str] = frozenset()
    notes: frozenset[str] = frozenset()
    unseen: frozenset[str] = frozenset()
    fit_only: int = 0
    bodies: Mapping[str, int] = field(default_factory=dict)


def dxf_facts(path: str | Path) -> DxfFacts:
    """Read the properties of a drawing, defaults if it cannot be read.

    Raises InputError if it is too large.
    """
    try:
        return _collect_facts(dxf_pieces(path))
    except (OSError, ValueError):
        return DxfFacts()


def select_lines(path: Path, fields: Mapping[str, AnyArray], surfaces: IntArray) -> Left:
    """Select the entities of a drawing, as read by GDAL, that are lines.

    Parameters
    ----------
    path : Path
    fields : mapping of str to (n,) array
        Columns of GDAL.
    surfaces : (n,) array of int
        Number of surfaces in each entity (`vomstudio.io.gis.wkb_shapes`).

    Returns
    -------
    keep : (n,) array of bool
    messages : list of Finding
        About excluded sheets (paper space), hidden layers, dimensions and bodies.
    """
    count = len(surfaces)
    keep = np.ones(count, bool)
    layers = [str(name).casefold() for name in fields.get("Layer", np.full(count, ""))]
    symbols = symbol_layers(layers)
    if symbols:
        keep &= np.array([name not in symbols for name in layers], bool)
    facts = dxf_facts(path)
    handles = [str(handle).upper() for handle in fields.get("EntityHandle", np.full(count, ""))]
    classes = [str(name) for name in fields.get("SubClasses", np.full(count, ""))]
    paper = np.asarray(fields.get("PaperSpace", np.zeros(count)), np.float64) == 1.0
    hidden = np.array([name in facts.hidden for name in layers], bool)
    hidden |= np.array([handle in facts.unseen for handle in handles], bool)
    is_note = np.array([handle in facts.notes for handle in handles], bool)
    is_note |= np.array(["AcDbLeader" in c or "AcDbMLeader" in c for c in classes], bool)
    messages: list[Finding] = []
    for excluded, finding in (
        (
            paper,
            Finding("drawing.paper-space", count=int((keep & paper).sum())),
        ),
        (
            hidden & ~paper,
            Finding("drawing.hidden", count=int((keep & hidden & ~paper).sum())),
        ),
        (is_note & ~hidden & ~paper, Finding("drawing.dimensions")),
    ):
        if (keep & excluded).any():
            messages.append(finding)
            keep = keep & ~excluded
    bodies = dict(facts.bodies)
    if number_of_surfaces := int(surfaces[keep].sum()):
        bodies["surface"] = number_of_surfaces
    if bodies:
        entities = [f"{number} {name}" for name, number in sorted(bodies.items())]
        messages.append(Finding("drawing.no-lines", count=sum(bodies.values()), entities=entities))
    return keep, messages


def why_unreadable(path: Path) -> Finding | None:
    """Return the reason why GDAL cannot read a drawing, None if it is not known."""
    if path.suffix.lower() != ".dxf" or not (count := dxf_facts(path).fit_only):
        return None
    return Finding("drawing.splines", count=count)


def _collect_facts(pieces: Iterator[DxfPiece]) -> DxfFacts:
    unit: float | None = None
    hidden, notes, unseen = set[str](), set[str](), set[str]()
    fit_only = 0
    bodies = Counter[str]()
    section: object = b""
    for piece in pieces:
        kind = piece.kind
        if kind in _BODIES and section == b"ENTITIES":
            bodies[kind.decode("ascii")] += 1
        if not (kind in _PARSED_KINDS or piece.may_be_unseen):
            continue
        groups = piece.groups()
        first: dict[int, Any] = {}
        for code, value in groups:
            first.setdefault(code, value)
        if kind == b"SECTION":
            section = first.get(2)
            if section == b"HEADER":
                unit = _unit(groups)
        is_layer = kind == b"LAYER" and section == b"TABLES" and 2 in first
        if is_layer and (int(first.get(70, 0)) & _FROZEN or int(first.get(62, 7)) < 0):
            hidden.update(_names(first[2]))
        flags = text_of(first.get(70, 0))
        is_mesh = kind == b"POLYLINE" and flags.isdigit() and int(flags) & POLYGON_MESH
        if is_mesh and section == b"ENTITIES":
            # GDAL skips these as well, but not polyface meshes.
            bodies["polygon mesh"] += 1
        if section == b"ENTITIES" and 5 in first:
            handle = text_of(first[5]).decode("latin-1").upper()
            if kind in _NO_LINES:
                notes.add(handle)
            if int(first.get(60, 0)) == 1:
                unseen.add(handle)
        if kind == b"SPLINE" and 11 in first and 10 not in first:
            fit_only += 1
    return DxfFacts(
        unit, frozenset(hidden), frozenset(notes), frozenset(unseen), fit_only, dict(bodies)
    )


def _unit(header: Groups) -> float | None:
    of_unit = False
    for code, value in header:
        if code == 9:
            of_unit = value == b"$INSUNITS"
        elif code == 70 and of_unit:
            return _UNITS.get(int(value))
    return None


def _names(value: Value) -> set[str]:
    """Return the names that GDAL may give a layer, for several code pages and escapes (U+00E9)."""
    raw = text_of(value)
    found = {raw.decode("utf-8", "replace"), raw.decode("cp1252", "replace"), raw.decode("latin-1")}
    found |= {
        re.sub(r"\\U\+([0-9A-Fa-f]{4})", lambda m: chr(int(m.group(1), 16)), t) for t in found
    }
    return {text.casefold() for text in found}
