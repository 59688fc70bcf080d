"""Cloud-optimised point clouds: octree of a `.copc.laz` file, read node by node.

COPC 1.0 (https://copc.io). A node of the octree is a cube with an even sample of its points; its
eight children add the points in between. Therefore the first levels are an overview of the cloud,
and nodes near the viewer show all points. Complete LAZ files are read by
`vomstudio.io.models.formats.las`.

The node table is read here and not by laspy's CopcReader, which trusts it: for a file of 5,000
points in which one node claims 2**31 points, laspy allocates 88 GiB. The points are decompressed by
lazrs.
"""

from __future__ import annotations

import struct
import threading
import weakref
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray, Int32Array, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file, require_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.streaming.octree import (
    FETCH_BATCH_POINTS,
    NodeStore,
    StreamedCloud,
    parent_rows,
    split_cloud,
)
from vomstudio.io.gis.axis_units import axes_problem, stated_axes, unit_findings
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.formats._las_header import (
    MAX_CHUNK_POINTS,
    LasHeader,
    decompress,
    is_copc,
    is_valid_chunk,
    read_las_header,
)
from vomstudio.io.models.formats._las_records import (
    FieldSelection,
    RecordLayout,
    build_cloud,
    choose_fields,
    record_layout,
    withheld_mask,
)
from vomstudio.io.models.formats._las_reference import las_reference

Key = tuple[int, int, int, int]

_ENTRY = np.dtype([("key", "<i4", 4), ("offset", "<u8"), ("bytes", "<i4"), ("points", "<i4")])
MAX_LEVEL = 30
_INFO_BYTES = 160
MIN_CHUNK_BYTES = 34
"""Minimum size of a chunk: one complete point and the number of points."""


@dataclass(frozen=True, eq=False)
class OctreeNodes:
    """Octree nodes that contain points, coarse levels first.

    Attributes
    ----------
    keys : (n, 4) int32
        Level of each node, and number of its cube along x, y and z.
    bounds : (n, 2, 3) float64
        Bounds of the cubes in the frame of the file.
    points : (n,) int64
        Number of points of each node.
    spacing : (n,) float64
        Approximate distance between neighbouring points of each node.
    """

    keys: Int32Array
    bounds: FloatArray
    points: IntArray
    spacing: FloatArray
    offsets: IntArray
    sizes: IntArray

    def __len__(self) -> int:
        return len(self.keys)

    def select_rows(self, rows: AnyArray) -> OctreeNodes:
        """Return the nodes selected by a mask or by row numbers."""
        return OctreeNodes(
            self.keys[rows],
            self.bounds[rows],
            self.points[rows],
            self.spacing[rows],
            self.offsets[rows],
            self.sizes[rows],
        )


class CopcFile:
    """Reader of an open COPC file.

    Each page of its node table is read once, when it is first needed.
    """

    def __init__(self, path: str | Path) -> None:
        """Open the file. Raises InputError if it is damaged or not a COPC file."""
        self.path = Path(path)
        require_regular_file(self.path)
        if not is_copc(path):
            raise InputError(Finding("file.other-format", format="COPC"), file=path)
        self.top: LasHeader = read_las_header(self.path)
        self._convert_axes()
        info = self.top.records.get(("copc", 1), b"")
        if len(info) < _INFO_BYTES or self.top.layer_count == 0:
            raise self._damage_error(tr("the first record is truncated"))
        x, y, z, half_size, spacing, offset, size = struct.unpack_from("<5d2Q", info)
        if not np.isfinite([x, y, z, half_size, spacing]).all() or half_size <= 0 or spacing <= 0:
            raise self._damage_error(tr("the bounding cube is not valid"))
        self._root_corner = np.array([x, y, z]) - half_size
        self._root_size, self._root_spacing = 2.0 * half_size, spacing
        self._layout: RecordLayout = record_layout(self.top, self.path)
        self._field_selection: FieldSelection | None = None
        self._pages: list[tuple[int, int, Key]] = [(offset, size, (0, 0, 0, 0))]
        self._read_offsets: set[int] = set()
        self._entries: dict[Key, tuple[int, int, int]] = {}
        self._file: BinaryIO = open_regular_file(self.path)
        try:
            self._load_pages(range(1), None)
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> CopcFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()

    @property
    def points(self) -> int:
        """Number of points stated in the header."""
        return self.top.points

    @property
    def bounds(self) -> FloatArray:
        """Bounds (2, 3) of all points, as stated in the header."""
        return self.top.bounds

    @property
    def crs(self) -> str | None:
        """CRS as in LoadedModel, or None if the file does not state a projected CRS."""
        return self._axes.crs if self.refusal_finding is None else None

    def _convert_axes(self) -> None:
        """Convert heights to the unit of x and y, as `vomstudio.io.models.opening` does."""
        reference = las_reference(self.path)
        findings, text = list(reference.warnings), reference.text
        if text is None:
            text, problem = sidecar_crs(self.path, self.top.bounds)
            findings += [problem] if problem else []
        self._axes = stated_axes(text, reference.height_unit)
        self.refusal_finding = axes_problem(self._axes, self.top.bounds)
        self.warnings = (
            *findings,
            *(unit_findings(self._axes) if self.refusal_finding is None else ()),
        )
        horizontal_factor = self._axes.unit_factor
        self._factors = np.array(
            [horizontal_factor, horizontal_factor, horizontal_factor * self._axes.height_factor]
        )
        if (self._factors != 1.0).any():
            top, factors = self.top, self._factors
            self.top = replace(
                top,
                scales=top.scales * factors,
                offsets=top.offsets * factors,
                bounds=top.bounds * factors,
            )

    def nodes(self, levels: range | None = None, bounds: AnyArray | None = None) -> OctreeNodes:
        """Return the nodes of `levels` whose cubes intersect `bounds` (2, 3); None means all.

        Raises InputError if the node table is damaged.
        """
        self._load_pages(levels, bounds)
        keys = np.array(list(self._entries), np.int32).reshape(-1, 4)
        values = np.array(list(self._entries.values()), np.int64).reshape(-1, 3)
        order = np.lexsort((values[:, 0], keys[:, 0]))
        keys, values = keys[order], values[order]
        is_selected = values[:, 2] > 0
        if levels is not None:
            is_selected &= (keys[:, 0] >= levels.start) & (keys[:, 0] < levels.stop)
        cubes = self._cubes(keys)
        if bounds is not None:
            is_selected &= _intersect(cubes, bounds)
        spacing = self._root_spacing * self._factors[0] / 2.0 ** keys[:, 0]
        return OctreeNodes(
            keys, cubes, values[:, 2], spacing, values[:, 0], values[:, 1]
        ).select_rows(is_selected)

    def overview(self, count: int) -> OctreeNodes:
        """Return the nodes of the first levels, with a total of about `count` points.

        The first level is always returned, and further levels up to a total of 1.5 times `count`.
        """
        selected_nodes = self.nodes(range(1))
        for level in range(1, MAX_LEVEL):
            candidates = self.nodes(range(level + 1))
            if len(candidates) == len(selected_nodes) or candidates.points.sum() > 1.5 * count:
                break
            selected_nodes = candidates
        return selected_nodes

    def read(self, nodes: OctreeNodes) -> PointCloud:
        """Read the points of nodes, in the order of `nodes`.

        The colours and fields are those of the root node, so that pieces can be joined. Raises
        InputError if a node is damaged.
        """
        if self._field_selection is None:
            root = self.nodes(range(1))
            sample_nodes = root if len(root) else self.nodes().select_rows(np.arange(1))
            self._field_selection = choose_fields(self._records(sample_nodes), self._layout)
        return build_cloud(self._records(nodes), self._layout, self.top, self._field_selection)

    def has_withheld(self) -> bool:
        """Return whether any points of the first level are marked as withheld."""
        return bool(withheld_mask(self._records(self.nodes(range(1))), self._layout).any())

    def _records(self, nodes: OctreeNodes) -> AnyArray:
        point_count = int(nodes.points.sum())
        if point_count > self.top.points:
            raise self._damage_error(tr("the nodes contain more points than the whole file"))
        chunks: list[bytes] = []
        for offset, size, points in zip(nodes.offsets, nodes.sizes, nodes.points, strict=True):
            try:
                self._file.seek(int(offset))
                chunk = self._file.read(int(size))
            except OSError as error:
                raise InputError(
                    Finding("file.unreadable", reason=error.strerror), file=self.path
                ) from error
            if len(chunk) != size or not is_valid_chunk(chunk, int(points), self.top):
                raise self._damage_error(tr("a node does not match the hierarchy"))
            chunks.append(chunk)
        records = decompress(chunks, nodes.points.tolist(), self.top, FETCH_BATCH_POINTS)
        if records is None:
            raise self._damage_error(tr("a node cannot be decompressed"))
        return records.reshape(-1).view(self._layout.kind)

    def _load_pages(self, levels: range | None, bounds: AnyArray | None) -> None:
        """Read the unread pages that may contain nodes within these levels and bounds."""
        while True:
            requested_pages = [
                page for page in self._pages if self._is_requested(page[2], levels, bounds)
            ]
            if not requested_pages:
                return
            self._pages = [page for page in self._pages if page not in requested_pages]
            for offset, size, _ in requested_pages:
                self._load_page(offset, size)

    def _load_page(self, offset: int, size: int) -> None:
        if offset in self._read_offsets or offset + size > self.top.size or size % _ENTRY.itemsize:
            raise self._damage_error(tr("the hierarchy of nodes is truncated or circular"))
        self._read_offsets.add(offset)
        self._file.seek(offset)
        page = np.frombuffer(self._file.read(size), _ENTRY)
        level = page["key"][:, 0]
        if len(page) * _ENTRY.itemsize != size or not ((level >= 0) & (level <= MAX_LEVEL)).all():
            raise self._damage_error(tr("the hierarchy of nodes is not valid"))
        if (page["key"][:, 1:] < 0).any() or (page["key"][:, 1:] >> level[:, None]).any():
            raise self._damage_error(tr("the hierarchy has nodes outside the bounding cube"))
        has_points = page["points"] > 0
        end = page["offset"].astype(np.float64) + page["bytes"]
        if (
            (page["bytes"][has_points] < MIN_CHUNK_BYTES).any()
            or (end[has_points] > self.top.size).any()
            or (page["points"][has_points] > MAX_CHUNK_POINTS).any()
        ):
            raise self._damage_error(tr("the hierarchy of nodes refers to data outside the file"))
        for key, node_offset, length, points in page.tolist():
            node = (int(key[0]), int(key[1]), int(key[2]), int(key[3]))
            if points == -1:
                self._pages.append((node_offset, max(length, 0), node))
            else:
                self._entries[node] = (node_offset if points > 0 else 0, length, max(points, 0))

    def _is_requested(self, key: Key, levels: range | None, bounds: AnyArray | None) -> bool:
        if levels is not None and key[0] >= levels.stop:
            return False
        return bounds is None or bool(
            _intersect(self._cubes(np.array([key], np.int32)), bounds).all()
        )

    def _cubes(self, keys: AnyArray) -> AnyArray:
        cube_size = self._root_size / 2.0 ** keys[:, :1]
        low = self._root_corner + keys[:, 1:] * cube_size
        cubes: AnyArray = np.stack([low, low + cube_size], axis=1) * self._factors
        return cubes

    def _damage_error(self, reason: str) -> InputError:
        return InputError(Finding("file.damaged", reason=reason, format="COPC"), file=self.path)


def nodes(
    path: str | Path, levels: range | None = None, bounds: AnyArray | None = None
) -> OctreeNodes:
    """Return the nodes of a file; see `CopcFile.nodes`."""
    with CopcFile(path) as file:
        return file.nodes(levels, bounds)


def read_crs(path: str | Path) -> tuple[str | None, tuple[Finding, ...]]:
    """Return the CRS of a COPC file or its `NAME.prj`, and findings about it.

    Raises InputError if the coordinates cannot be used, for example if they are in degrees.
    """
    with CopcFile(path) as file:
        if file.refusal_finding is not None:
            raise InputError(file.refusal_finding, file=path, field="CRS")
        hidden_findings = (Finding("model.withheld-hidden"),) if file.has_withheld() else ()
        return file.crs, (*file.warnings, *hidden_findings)


OVERVIEW_POINTS = 200_000


def point_count(path: str | Path) -> int:
    """Return the number of points stated by a COPC file, or 0 for other files."""
    if not is_copc(path):
        return 0
    try:
        return read_las_header(Path(path)).points
    except InputError:
        return 0


def stream(path: str | Path, budget: int) -> StreamedCloud:
    """Open a COPC file for streaming with a maximum of `budget` points in memory.

    The first levels are read immediately. The file stays open as long as the cloud exists. Raises
    InputError.
    """
    file = CopcFile(path)
    try:
        nodes = file.nodes()
        if file.refusal_finding is not None:
            raise InputError(file.refusal_finding, file=path, field="CRS")
        if not len(nodes) or not np.isfinite(file.bounds).all():
            raise InputError(Finding("model.no-points"), file=path)
        order = np.argsort(nodes.offsets)
        starts = np.empty(len(nodes), np.int64)
        starts[order] = np.concatenate([[0], np.cumsum(nodes.points[order])[:-1]])
        rows = _first_levels(nodes, OVERVIEW_POINTS)
        overview = file.read(nodes.select_rows(np.array(rows)))
    except BaseException:
        file.close()
        raise
    lock = threading.Lock()

    def read(rows: Sequence[int]) -> PointCloud:
        # Only one thread at a time, because threads share the file position.
        with lock:
            return file.read(nodes.select_rows(np.array(rows)))

    store = NodeStore(
        nodes.bounds,
        nodes.spacing,
        nodes.points,
        starts,
        parent_rows(nodes.keys),
        read,
        budget,
        rows,
    )
    weakref.finalize(store, file.close)
    for row, part in zip(
        rows, split_cloud(overview, nodes.points[list(rows)].tolist()), strict=True
    ):
        store.store_node(row, part)
    return StreamedCloud(
        overview.points,
        overview.colors,
        None,
        overview.fields,
        store=store,
        box=file.bounds,
    )


def _first_levels(nodes: OctreeNodes, count: int) -> tuple[int, ...]:
    """Return the rows of the first levels with about `count` points, at least one level."""
    levels = nodes.keys[:, 0]
    is_selected = levels == levels.min()
    for level in range(int(levels.min()) + 1, int(levels.max()) + 1):
        candidates = levels <= level
        if nodes.points[candidates].sum() > 1.5 * count:
            break
        is_selected = candidates
    return tuple(np.flatnonzero(is_selected).tolist())


def _intersect(cubes: AnyArray, bounds: AnyArray) -> AnyArray:
    low, high = np.asarray(bounds, np.float64)
    result: AnyArray = ((cubes[:, 0] <= high) & (cubes[:, 1] >= low)).all(axis=1)
    return result
