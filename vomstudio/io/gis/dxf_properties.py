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
from vomstudio.io.gis.dxf_groups import DxfPiece, Groups, Value, dxf_pieces, value_text
from vomstudio.io.gis.layer_reading import symbol_layers

Selection = tuple[BoolArray, list[Finding]]

_UNITS = {1: 0.0254, 2: 0.3048, 3: 1609.344, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144}
_UNITS |= {14: 0.1, 15: 10.0, 16: 100.0, 21: 1200 / 3937}
"""Metres per unit by the value of $INSUNITS."""
ENTITY_COLUMNS = ("paperspace", "subclasses", "entityhandle")
"""GDAL columns of an entity other than its layer, in lower case."""
_FROZEN_FLAG = 1
_ANNOTATIONS = (
    b"DIMENSION",
    b"LEADER",
    b"MULTILEADER",
    b"ARC_DIMENSION",
    b"LARGE_RADIAL_DIMENSION",
)
_PARSED_KINDS = (b"SECTION", b"LAYER", b"SPLINE", b"POLYLINE", *_ANNOTATIONS)
_BODY_KINDS = frozenset(
    (b"3DSOLID", b"BODY", b"REGION", b"SURFACE", b"EXTRUDEDSURFACE", b"LOFTEDSURFACE", b"MESH")
    + (b"REVOLVEDSURFACE", b"SWEPTSURFACE", b"PLANESURFACE", b"NURBSURFACE")
    + (b"ACAD_PROXY_ENTITY", b"ACAD_PROXY_OBJECT")
)
"""Entities without lines that GDAL skips without a message."""
POLYGON_MESH, POLYFACE_MESH = 16, 64
"""Flags of a POLYLINE entity that represents a surface."""


@dataclass(frozen=True)
class DxfProperties:
    """Properties of a drawing.

    Parameters
    ----------
    unit_m : float or None
        Metres per unit, or None if not stated.
    hidden_layers : frozenset of str
        Layers that are off or frozen, in lower case.
    note_handles : frozenset of str
        Handles of dimensions and leaders.
    invisible_handles : frozenset of str
        Handles of invisible entities.
    fit_spline_count : int
        Number of splines with fit points but no control points.
    bodies : mapping of str to int
        Number of solids, surfaces and proxies by entity name.
    """

    unit_m: float | None = None
    hidden_layers: frozenset[str] = frozenset()
    note_handles: frozenset[str] = frozenset()
    invisible_handles: frozenset[str] = frozenset()
    fit_spline_count: int = 0
    bodies: Mapping[str, int] = field(default_factory=dict)


def read_dxf_properties(path: str | Path) -> DxfProperties:
    """Read the properties of a drawing, or return defaults if it cannot be read.

    Raises
    ------
    InputError
        If the file is too large.
    """
    try:
        return _collect_properties(dxf_pieces(path))
    except (OSError, ValueError):
        return DxfProperties()


def select_lines(path: Path, fields: Mapping[str, AnyArray], surfaces: IntArray) -> Selection:
    """Select the entities of a drawing, as read by GDAL, that may be lines of the model.

    Parameters
    ----------
    path : Path
    fields : mapping of str to (n,) array
        GDAL columns.
    surfaces : (n,) array of int
        Number of surfaces in each entity (`vomstudio.io.gis.wkb_shapes`).

    Returns
    -------
    is_kept : (n,) array of bool
        False for symbols, dimensions, and entities in paper space or on hidden layers.
    findings : list of Finding
        Findings about excluded sheets (paper space), hidden layers, dimensions and bodies.
    """
    count = len(surfaces)
    is_kept = np.ones(count, bool)
    layers = [str(name).casefold() for name in fields.get("Layer", np.full(count, ""))]
    symbols = symbol_layers(layers)
    if symbols:
        is_kept &= np.array([name not in symbols for name in layers], bool)
    properties = read_dxf_properties(path)
    handles = [str(handle).upper() for handle in fields.get("EntityHandle", np.full(count, ""))]
    classes = [str(name) for name in fields.get("SubClasses", np.full(count, ""))]
    is_in_paper_space = np.asarray(fields.get("PaperSpace", np.zeros(count)), np.float64) == 1.0
    is_hidden = np.array([name in properties.hidden_layers for name in layers], bool)
    is_hidden |= np.array([handle in properties.invisible_handles for handle in handles], bool)
    is_note = np.array([handle in properties.note_handles for handle in handles], bool)
    is_note |= np.array(
        ["AcDbLeader" in class_ or "AcDbMLeader" in class_ for class_ in classes], bool
    )
    findings: list[Finding] = []
    for is_excluded, finding in (
        (
            is_in_paper_space,
            Finding("drawing.paper-space", count=int((is_kept & is_in_paper_space).sum())),
        ),
        (
            is_hidden & ~is_in_paper_space,
            Finding("drawing.hidden", count=int((is_kept & is_hidden & ~is_in_paper_space).sum())),
        ),
        (is_note & ~is_hidden & ~is_in_paper_space, Finding("drawing.dimensions")),
    ):
        if (is_kept & is_excluded).any():
            findings.append(finding)
            is_kept = is_kept & ~is_excluded
    bodies = dict(properties.bodies)
    if surface_count := int(surfaces[is_kept].sum()):
        bodies["surface"] = surface_count
    if bodies:
        entities = [f"{count} {name}" for name, count in sorted(bodies.items())]
        findings.append(Finding("drawing.no-lines", count=sum(bodies.values()), entities=entities))
    return is_kept, findings


def unreadable_reason(path: Path) -> Finding | None:
    """Return the reason why GDAL cannot read a drawing, or None if it is unknown."""
    if path.suffix.lower() != ".dxf" or not (count := read_dxf_properties(path).fit_spline_count):
        return None
    return Finding("drawing.splines", count=count)


def _collect_properties(pieces: Iterator[DxfPiece]) -> DxfProperties:
    unit: float | None = None
    hidden_names, note_handles, invisible_handles = set[str](), set[str](), set[str]()
    fit_spline_count = 0
    bodies = Counter[str]()
    section: object = b""
    for piece in pieces:
        kind = piece.kind
        if kind in _BODY_KINDS and section == b"ENTITIES":
            bodies[kind.decode("ascii")] += 1
        if not (kind in _PARSED_KINDS or piece.may_be_invisible):
            continue
        groups = piece.groups()
        first_values: dict[int, Any] = {}
        for code, value in groups:
            first_values.setdefault(code, value)
        if kind == b"SECTION":
            section = first_values.get(2)
            if section == b"HEADER":
                unit = _header_unit_m(groups)
        is_layer = kind == b"LAYER" and section == b"TABLES" and 2 in first_values
        if is_layer and (
            int(first_values.get(70, 0)) & _FROZEN_FLAG or int(first_values.get(62, 7)) < 0
        ):
            hidden_names.update(_layer_names(first_values[2]))
        flags = value_text(first_values.get(70, 0))
        is_mesh = kind == b"POLYLINE" and flags.isdigit() and int(flags) & POLYGON_MESH
        if is_mesh and section == b"ENTITIES":
            # GDAL also skips these, but not polyface meshes.
            bodies["polygon mesh"] += 1
        if section == b"ENTITIES" and 5 in first_values:
            handle = value_text(first_values[5]).decode("latin-1").upper()
            if kind in _ANNOTATIONS:
                note_handles.add(handle)
            if int(first_values.get(60, 0)) == 1:
                invisible_handles.add(handle)
        if kind == b"SPLINE" and 11 in first_values and 10 not in first_values:
            fit_spline_count += 1
    return DxfProperties(
        unit,
        frozenset(hidden_names),
        frozenset(note_handles),
        frozenset(invisible_handles),
        fit_spline_count,
        dict(bodies),
    )


def _header_unit_m(header: Groups) -> float | None:
    is_unit_variable = False
    for code, value in header:
        if code == 9:
            is_unit_variable = value == b"$INSUNITS"
        elif code == 70 and is_unit_variable:
            return _UNITS.get(int(value))
    return None


def _layer_names(value: Value) -> set[str]:
    """Return the names that GDAL may give to a layer.

    These names result from several code pages and from escapes (U+00E9).
    """
    raw_value_text = value_text(value)
    names = {
        raw_value_text.decode("utf-8", "replace"),
        raw_value_text.decode("cp1252", "replace"),
        raw_value_text.decode("latin-1"),
    }
    names |= {
        re.sub(r"\\U\+([0-9A-Fa-f]{4})", lambda match: chr(int(match.group(1), 16)), name)
        for name in names
    }
    return {text.casefold() for text in names}
