"""DXF drawings as models: points as a cloud or faces as a mesh.

Faces are 3DFACE, polyface and polygon meshes (POLYLINE) and MESH; each layer becomes a material
(AutoCAD DXF Reference). For the reasons stated in `vomstudio.io.gis.dxf`, the file is not parsed by
a library. It is read in blocks, so that only one block is in memory as text.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import recognise_kind
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.io.gis.axis_units import UNKNOWN_UNITS, Units
from vomstudio.io.gis.dxf import WHITE_COLOR_NUMBER, color_table
from vomstudio.io.gis.dxf_groups import binary_groups, is_binary, value_text
from vomstudio.io.gis.dxf_properties import POLYFACE_MESH, POLYGON_MESH
from vomstudio.io.models.formats._common import (
    BLOCK_BYTES,
    drop_invalid_points,
    drop_invalid_vertices,
    join_corners,
    read_whole_file,
)
from vomstudio.io.models.reader import LoadedModel, Reader

_UNITS: dict[int, str] = {2: "ft", 4: "mm", 5: "cm", 6: "m", 7: "km", 21: "us-ft"}
"""Unit names from `vomstudio.geometry.units.METRES_PER_UNIT` by the value of $INSUNITS."""
_FROZEN_FLAG, _INVISIBLE_FLAG, _PAPER_SPACE_FLAG = 1, 1, 1
_BYLAYER_COLOR_NUMBER = 256
_CLOSED_M_FLAG, _CLOSED_N_FLAG = 1, 32
_FACE_RECORD_FLAG, _MESH_VERTEX_FLAG, _CONTROL_POINT_FLAG = 128, 64, 16
_STRUCTURE_KINDS = {b"SECTION", b"ENDSEC", b"VERTEX", b"SEQEND", b"EOF"}
_GROUPS_PER_BLOCK = 400_000


@dataclass
class _Block:
    """Groups of a part of the drawing that contains only complete entities."""

    codes: IntArray
    values: list[bytes]
    starts: IntArray
    kinds: npt.NDArray[np.bytes_]

    @classmethod
    def create(cls, codes: IntArray, values: list[bytes]) -> _Block:
        starts = np.flatnonzero(codes == 0)
        kinds = np.array([values[i].upper() for i in starts.tolist()] or [b""], np.bytes_)
        return cls(codes, values, starts, kinds[: len(starts)])

    def groups(self, entity: int) -> Iterator[tuple[int, bytes]]:
        """Yield the groups of one entity after the first group."""
        start = int(self.starts[entity]) + 1
        end = int(self.starts[entity + 1]) if entity + 1 < len(self.starts) else len(self.codes)
        return zip(self.codes[start:end].tolist(), self.values[start:end], strict=True)

    def numbers(
        self, entities: IntArray, codes: tuple[int, ...], default: float = np.nan
    ) -> FloatArray:
        """Return the first value (n, k) of each code for entities in ascending order."""
        numbers = np.full((len(entities), len(codes)), default)
        offset, row = self._group_rows(entities)
        slots = np.full(1 + max(codes), -1, np.int64)
        slots[list(codes)] = np.arange(len(codes))
        group = self.codes[offset]
        is_selected = (group >= 0) & (group < len(slots))
        is_selected[is_selected] = slots[group[is_selected]] >= 0
        offset, row = offset[is_selected], row[is_selected]
        values = np.array([_number(self.values[i]) for i in offset.tolist()], np.float64)
        # Assigned in reverse order so that the first value of a code is kept.
        numbers[row[::-1], slots[self.codes[offset[::-1]]]] = values[::-1]
        return numbers

    def layers(self, entities: IntArray) -> list[bytes]:
        """Return the layer of each entity in ascending order, or "0" if it has none."""
        layers = [b"0"] * len(entities)
        offset, row = self._group_rows(entities)
        is_layer_name = self.codes[offset] == 8
        for group, entity in zip(
            offset[is_layer_name].tolist(), row[is_layer_name].tolist(), strict=True
        ):
            layers[entity] = self.values[group]
        return layers

    def _group_rows(self, entities: IntArray) -> tuple[IntArray, IntArray]:
        """Return the group numbers of entities, and the row in `entities` of each group."""
        if not len(entities):
            return np.empty(0, np.int64), np.empty(0, np.int64)
        ends = np.append(self.starts, len(self.codes))
        counts = ends[entities + 1] - ends[entities]
        row = np.repeat(np.arange(len(entities)), counts)
        first_rows = np.cumsum(counts) - counts
        return np.arange(len(row)) - first_rows[row] + ends[entities][row], row


def _number(value: bytes) -> float:
    try:
        return float(value)
    except ValueError:
        return np.nan


def _integer(value: bytes, default: int = 0) -> int:
    """Return a 32-bit integer, or the default for other values."""
    number = _number(value)
    return int(number) if abs(number) < 2.0**31 else default


def _integers(values: FloatArray) -> IntArray:
    """Return values as integers, or 0 if they exceed 32 bits."""
    return np.asarray(np.where(np.abs(values) < 2.0**31, values, 0.0), np.int64)


@dataclass
class _Drawing:
    """Content that has been read so far.

    Attributes
    ----------
    colors : dict of bytes to int
        Colour number of each layer.
    hidden_layers : set of bytes
        Layers that are off or frozen.
    """

    colors: dict[bytes, int] = field(default_factory=dict)
    hidden_layers: set[bytes] = field(default_factory=set)
    unit: str | None = None
    section: bytes = b""
    corners: list[FloatArray] = field(default_factory=list)
    owners: list[IntArray] = field(default_factory=list)
    order: list[IntArray] = field(default_factory=list)
    layers: dict[bytes, int] = field(default_factory=dict)
    points: list[FloatArray] = field(default_factory=list)
    point_colors: list[IntArray] = field(default_factory=list)
    skipped_entities: Counter[str] = field(default_factory=Counter)

    def add_triangles(self, corners: FloatArray, layers: list[bytes], entities: IntArray) -> None:
        """Add triangles (n, 3, 3) with their layers and their entities in the block."""
        if len(corners):
            layer_numbers = [self.layers.setdefault(name, len(self.layers)) for name in layers]
            self.corners.append(corners)
            self.owners.append(np.array(layer_numbers, np.int64))
            self.order.append(entities)

    def sort_block(self) -> None:
        """Sort the triangles of a block, which were read by kind, into the order of the file."""
        n = len(self.order)
        if n > 1:
            order = np.argsort(np.concatenate(self.order), kind="stable")
            self.corners[-n:] = [np.concatenate(self.corners[-n:])[order]]
            self.owners[-n:] = [np.concatenate(self.owners[-n:])[order]]
        self.order.clear()


def matches(path: Path, head: bytes) -> bool:
    """Return whether the content is certainly that of a drawing."""
    kind = recognise_kind(head)
    return kind is not None and kind.key == "dxf"


def read(path: Path, progress: Progress) -> LoadedModel:
    """Read the points or faces of a drawing.

    Faces become a mesh: they are triangulated, equal corners are merged, and each layer is one
    material. In a drawing without faces, points become a cloud.

    Raises
    ------
    InputError
        If the file is not a drawing, or contains neither points nor faces (``model.no-entities``).
    """
    drawing = _Drawing()
    data = read_whole_file(path, progress).tobytes()
    progress.stage(tr("Reading the entities"), len(data))
    for block, done_count in _blocks(data, path):
        _read_block(block, drawing)
        progress.step(done_count)
    del data
    findings: list[Finding] = []
    if not drawing.corners and not drawing.points:
        entities = _entity_counts(drawing.skipped_entities) or [tr("nothing")]
        raise InputError(Finding("model.no-entities", entities=entities), file=path)
    model: Mesh | PointCloud
    if drawing.corners:
        if drawing.points:
            drawing.skipped_entities["POINT"] += sum(map(len, drawing.points))
        model = drop_invalid_vertices(_mesh(drawing), findings, path)
    else:
        model = drop_invalid_points(_cloud(drawing), findings, path)
    if drawing.skipped_entities:
        findings.append(
            Finding(
                "model.entities-left-out",
                count=sum(drawing.skipped_entities.values()),
                entities=_entity_counts(drawing.skipped_entities),
            )
        )
    units: Units = UNKNOWN_UNITS if drawing.unit is None else (drawing.unit,) * 3
    kind = "mesh" if isinstance(model, Mesh) else "cloud"
    return LoadedModel(model, kind, None, tuple(findings), path, units=units)  # type: ignore[arg-type]


def _entity_counts(entities: Counter[str]) -> list[str]:
    return [f"{count} {name}" for name, count in sorted(entities.items())]


# --- groups ------------------------------------------------------------------------------------


def _blocks(data: bytes, path: Path) -> Iterator[tuple[_Block, int]]:
    """Yield the groups in blocks of complete entities, and the number of bytes read."""
    codes: list[int] = []
    values: list[bytes] = []
    searched_count = 0
    for next_codes, next_values, done_count in _groups(data, path):
        codes += next_codes
        values += next_values
        code_array = np.array(codes, np.int64)
        ends = [
            i
            for i in np.flatnonzero(code_array[searched_count:] == 0) + searched_count
            if values[i].upper() not in (b"VERTEX", b"SEQEND")
        ]
        searched_count = len(codes)
        if not ends or not ends[-1]:
            continue
        end = int(ends[-1])
        yield _Block.create(code_array[:end], values[:end]), done_count
        codes, values, searched_count = codes[end:], values[end:], 0
    yield _Block.create(np.array(codes, np.int64), values), len(data)


def _groups(data: bytes, path: Path) -> Iterator[tuple[list[int], list[bytes], int]]:
    """Yield codes and values, and the number of bytes read. Raises InputError."""
    if is_binary(data):
        codes, values = [], []
        for code, value in binary_groups(data):
            codes.append(code)
            values.append(value_text(value))
            if len(codes) >= _GROUPS_PER_BLOCK:
                yield codes, values, 0
                codes, values = [], []
        yield codes, values, len(data)
        return
    if b"\n" not in data[:BLOCK_BYTES]:
        data = data.replace(b"\r", b"\n")
    offset, line_offset, remaining_bytes = 0, 0, b""
    while offset < len(data):
        block = remaining_bytes + data[offset : offset + BLOCK_BYTES]
        offset += BLOCK_BYTES
        end = len(block) if offset >= len(data) else block.rfind(b"\n") + 1
        remaining_bytes, lines = block[end:], block[:end].split(b"\n")
        if not end:
            continue
        if lines[-1] == b"" and offset < len(data):
            lines.pop()
        if len(lines) % 2 and offset < len(data):
            remaining_bytes = lines.pop() + b"\n" + remaining_bytes
        code_lines = lines[0::2]
        try:
            codes = list(map(int, code_lines[: len(lines) // 2]))
        except ValueError as error:
            invalid_row = next(i for i, code in enumerate(code_lines) if not code.strip().isdigit())
            if any(line.strip() for line in lines[2 * invalid_row :]):
                raise InputError(
                    Finding(
                        "file.damaged", format="DXF", reason=tr("this line is not a group code")
                    ),
                    file=path,
                    line=line_offset + 2 * invalid_row + 1,
                ) from error
            codes = list(map(int, code_lines[:invalid_row]))
        yield (
            codes,
            [line.strip() for line in lines[1 : 2 * len(codes) : 2]],
            min(offset, len(data)),
        )
        line_offset += len(lines)


# --- entities ----------------------------------------------------------------------------------


def _read_block(block: _Block, drawing: _Drawing) -> None:
    is_inside = np.zeros(len(block.starts), np.bool_)
    kinds = block.kinds
    marks = np.flatnonzero(np.isin(kinds, (b"SECTION", b"ENDSEC"))).tolist()
    section_start = 0
    for mark in [*marks, len(kinds)]:
        is_inside[section_start:mark] = drawing.section == b"ENTITIES"
        if drawing.section == b"TABLES":
            for entity in (
                np.flatnonzero(kinds[section_start:mark] == b"LAYER") + section_start
            ).tolist():
                _read_layer(dict(block.groups(entity)), drawing)
        if mark == len(kinds):
            break
        drawing.section = b""
        if kinds[mark] == b"SECTION":
            groups = list(block.groups(mark))
            drawing.section = next((value.upper() for code, value in groups if code == 2), b"")
            if drawing.section == b"HEADER":
                drawing.unit = _header_unit(groups)
        section_start = mark + 1
    entities = np.flatnonzero(is_inside)
    entities = entities[~np.isin(kinds[entities], tuple(_STRUCTURE_KINDS))]
    if not len(entities):
        return
    entities = _visible_entities(block, entities, drawing)
    entity_kinds = kinds[entities]
    _read_faces(block, entities[entity_kinds == b"3DFACE"], drawing)
    _read_points(block, entities[entity_kinds == b"POINT"], drawing)
    for entity in entities[entity_kinds == b"POLYLINE"].tolist():
        _read_polyline(block, entity, drawing)
    for entity in entities[entity_kinds == b"MESH"].tolist():
        _read_mesh(block, entity, drawing)
    drawing.sort_block()
    is_other_entity = ~np.isin(entity_kinds, (b"3DFACE", b"POINT", b"POLYLINE", b"MESH"))
    drawing.skipped_entities.update(
        kind.decode("latin-1") for kind in entity_kinds[is_other_entity].tolist()
    )


def _read_layer(groups: dict[int, bytes], drawing: _Drawing) -> None:
    name, color = groups.get(2, b"0"), _integer(groups.get(62, b"7"), WHITE_COLOR_NUMBER)
    drawing.colors[name] = abs(color) if abs(color) < _BYLAYER_COLOR_NUMBER else WHITE_COLOR_NUMBER
    if color < 0 or _integer(groups.get(70, b"0")) & _FROZEN_FLAG:
        drawing.hidden_layers.add(name)


def _header_unit(header: list[tuple[int, bytes]]) -> str | None:
    is_unit_variable = False
    for code, value in header:
        if code == 9:
            is_unit_variable = value == b"$INSUNITS"
        elif code == 70 and is_unit_variable:
            return _UNITS.get(_integer(value))
    return None


def _visible_entities(block: _Block, entities: IntArray, drawing: _Drawing) -> IntArray:
    """Return the entities that are visible and not in paper space."""
    flags = block.numbers(entities, (60, 67), 0.0)
    is_visible = (flags[:, 0] != _INVISIBLE_FLAG) & (flags[:, 1] != _PAPER_SPACE_FLAG)
    if drawing.hidden_layers:
        layers = block.layers(entities)
        is_visible &= np.array([name not in drawing.hidden_layers for name in layers], np.bool_)
    if not is_visible.all():
        drawing.skipped_entities[tr("hidden")] += int((~is_visible).sum())
    return np.asarray(entities[is_visible], np.int64)


def _read_faces(block: _Block, entities: IntArray, drawing: _Drawing) -> None:
    if not len(entities):
        return
    codes = tuple(axis + corner for corner in range(4) for axis in (10, 20, 30))
    corners = block.numbers(entities, codes).reshape(-1, 4, 3)
    heights = corners[:, :, 2]
    heights[np.isnan(heights) & ~np.isnan(corners[:, :, 0])] = 0.0
    is_triangle = np.isnan(corners[:, 3]).all(axis=1)
    corners[is_triangle, 3] = corners[is_triangle, 2]
    _add_quads(corners, block.layers(entities), entities, drawing)


def _add_quads(
    corners: FloatArray, layers: list[bytes], entities: IntArray, drawing: _Drawing
) -> None:
    """Add faces (n, 4, 3); for a triangle, the last corner is repeated."""
    pairs = corners[:, [[0, 1, 2], [0, 2, 3]]]
    is_kept = np.ones((len(corners), 2), np.bool_)
    is_kept[:, 1] = (corners[:, 3] != corners[:, 2]).any(axis=1)
    names = [
        name
        for name, is_quad in zip(layers, is_kept[:, 1].tolist(), strict=True)
        for name in ((name, name) if is_quad else (name,))
    ]
    drawing.add_triangles(pairs[is_kept], names, np.repeat(entities, is_kept.sum(axis=1)))


def _read_points(block: _Block, entities: IntArray, drawing: _Drawing) -> None:
    if not len(entities):
        return
    points = block.numbers(entities, (10, 20, 30))
    points[np.isnan(points[:, 2]) & ~np.isnan(points[:, 0]), 2] = 0.0
    point_colors = block.numbers(entities, (62,), _BYLAYER_COLOR_NUMBER)[:, 0]
    colors = _integers(
        np.where(
            (point_colors > 0) & (point_colors < _BYLAYER_COLOR_NUMBER),
            point_colors,
            _BYLAYER_COLOR_NUMBER,
        )
    )
    layer_color_rows = np.flatnonzero(colors == _BYLAYER_COLOR_NUMBER)
    if len(layer_color_rows):
        layers = block.layers(entities)
        # Negative for the colour of the layer, so that clouds without point colours are recognised.
        colors[layer_color_rows] = [
            -drawing.colors.get(layers[i], WHITE_COLOR_NUMBER) for i in layer_color_rows.tolist()
        ]
    drawing.points.append(points)
    drawing.point_colors.append(colors)


def _read_polyline(block: _Block, entity: int, drawing: _Drawing) -> None:
    first_values = dict(reversed(list(block.groups(entity))))
    flags = _integer(first_values.get(70, b"0"))
    if not flags & (POLYFACE_MESH | POLYGON_MESH):
        drawing.skipped_entities["POLYLINE"] += 1
        return
    end = entity + 1
    while end < len(block.kinds) and block.kinds[end] == b"VERTEX":
        end += 1
    vertices = np.arange(entity + 1, end)
    vertex_values = block.numbers(vertices, (10, 20, 30, 70, 71, 72, 73, 74), 0.0)
    kinds = _integers(vertex_values[:, 3])
    layer = first_values.get(8, b"0")
    if flags & POLYFACE_MESH:
        positions = vertex_values[(kinds & _MESH_VERTEX_FLAG) > 0, :3]
        is_face = ((kinds & _FACE_RECORD_FLAG) > 0) & ((kinds & _MESH_VERTEX_FLAG) == 0)
        # A negative number marks an invisible edge.
        rows = np.abs(_integers(vertex_values[is_face, 4:]))
        rows[:, 3] = np.where(rows[:, 3] > 0, rows[:, 3], rows[:, 2])
        is_valid = ((rows > 0) & (rows <= len(positions))).all(axis=1)
        if not is_valid.all():
            drawing.skipped_entities[tr("faces with invalid vertex numbers")] += int(
                (~is_valid).sum()
            )
        corners = positions[rows[is_valid] - 1]
    else:
        positions = vertex_values[(kinds & _CONTROL_POINT_FLAG) == 0, :3]
        corners = _grid_quads(positions, first_values, flags)
        if not len(corners):
            drawing.skipped_entities["POLYLINE"] += 1
    rows = np.full(len(corners), entity)
    _add_quads(corners.reshape(-1, 4, 3), [layer] * len(corners), rows, drawing)


def _grid_quads(positions: FloatArray, first_values: dict[int, bytes], flags: int) -> FloatArray:
    """Return the quadrilaterals (n, 4, 3) of a mesh with M × N vertices."""
    is_smooth = _integer(first_values.get(75, b"0")) != 0
    m, n = (
        _integer(first_values.get(code, b"0")) for code in ((73, 74) if is_smooth else (71, 72))
    )
    if m < 2 or n < 2 or m * n != len(positions):
        return np.empty((0, 4, 3))
    rows = np.arange(m * n).reshape(m, n)
    if flags & _CLOSED_M_FLAG:
        rows = np.vstack([rows, rows[:1]])
    if flags & _CLOSED_N_FLAG:
        rows = np.hstack([rows, rows[:, :1]])
    quads = np.stack([rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]], -1)
    return np.asarray(positions[quads.reshape(-1, 4)], np.float64)


def _read_mesh(block: _Block, entity: int, drawing: _Drawing) -> None:
    """Read a MESH at subdivision level 0."""
    positions: list[list[float]] = []
    face_lists: list[int] = []
    expected_count = 0
    layer = b"0"
    for code, value in block.groups(entity):
        if code == 8:
            layer = value
        elif code == 10:
            positions.append([_number(value), np.nan, 0.0])
        elif code in (20, 30) and positions:
            positions[-1][code // 10 - 1] = _number(value)
        elif code == 93:
            expected_count = _integer(value)
        elif code == 90 and len(face_lists) < expected_count:
            face_lists.append(_integer(value))
    points = np.array(positions, np.float64).reshape(-1, 3)
    triangles: list[tuple[int, int, int]] = []
    offset = 0
    while offset < len(face_lists):
        size = face_lists[offset]
        ring = face_lists[offset + 1 : offset + 1 + size]
        if size < 3 or len(ring) < size or not all(0 <= i < len(points) for i in ring):
            break
        triangles += [(ring[0], ring[k], ring[k + 1]) for k in range(1, size - 1)]
        offset += 1 + size
    if offset < len(face_lists) or not triangles:
        drawing.skipped_entities["MESH"] += 1
    corners = points[np.array(triangles, np.int64).reshape(-1, 3)]
    drawing.add_triangles(corners, [layer] * len(corners), np.full(len(corners), entity))


# --- models ------------------------------------------------------------------------------------


def _mesh(drawing: _Drawing) -> Mesh:
    corners, owners = np.concatenate(drawing.corners), np.concatenate(drawing.owners)
    drawing.corners.clear()
    names = list(drawing.layers)
    face_colors = [drawing.colors.get(name, WHITE_COLOR_NUMBER) for name in names]
    vertices, faces = join_corners(corners.reshape(-1, 3))
    if len(names) == 1 and face_colors[0] == WHITE_COLOR_NUMBER:
        return Mesh(vertices, faces)
    order = np.argsort(owners, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(np.bincount(owners, minlength=len(names)))])
    table = color_table()
    materials = tuple(
        Material(
            name.decode("utf-8", "replace"),
            None,
            None if number == WHITE_COLOR_NUMBER else tuple((table[number] / 255.0).tolist()),
        )
        for name, number in zip(names, face_colors, strict=True)
    )
    return Mesh(vertices, faces[order], materials, offsets.astype(np.int64))


def _cloud(drawing: _Drawing) -> PointCloud:
    points, colors = np.concatenate(drawing.points), np.concatenate(drawing.point_colors)
    if (colors <= 0).all() and len(np.unique(colors)) == 1:
        return PointCloud(points)
    table = color_table()
    return PointCloud(points, table[np.abs(colors)])


READER = Reader(to_translate("DXF points or faces"), (".dxf",), matches, read)
