"""Cloud optimised point clouds: the octree of a `.copc.laz`, read node by node.

COPC 1.0 (https://copc.io). A node of the octree is a cube that holds a thin, even sample of the
points within it; its eight children fill in what is between. So the nodes of the first levels are a
picture of the whole, and nodes near the viewer, down to any level, the picture in full.
The same file read whole, as a LAZ file, goes through `vomstudio.io.models.formats.las`.

Its table is read here and not by laspy's CopcReader, which believes it: a file of 5,000 points in
which one node promises 2**31 makes laspy ask for 88 GiB. lazrs unpacks the points.
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
from vomstudio.core.files.regular import open_regular, require_regular
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.streaming.octree import (
    FETCHED_AT_ONCE,
    NodeStore,
    StreamedCloud,
    parents_of,
    parts_of,
)
from vomstudio.io.gis.axis_units import refusal, stated_axes, unit_findings
from vomstudio.io.gis.crs import sidecar_crs
from vomstudio.io.models.formats._las_header import (
    MAX_CHUNK_POINTS,
    Top,
    is_copc,
    is_sound_chunk,
    read_top,
    unpack,
)
from vomstudio.io.models.formats._las_records import (
    Choice,
    Layout,
    choose,
    cloud_of,
    layout_of,
    withheld_of,
)
from vomstudio.io.models.formats._las_reference import las_reference

Key = tuple[int, int, int, int]

_ENTRY = np.dtype([("key", "<i4", 4), ("offset", "<u8"), ("bytes", "<i4"), ("points", "<i4")])
_DEEPEST = 30
_INFO_BYTES = 160
_FEWEST_BYTES = 34
"""Of a chunk: one whole point, and its number of points."""


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes of the octree that hold points, coarse levels first.

    keys : (n, 4) int32, level and the number of the cube along x, y and z
    bounds : (n, 2, 3) float64, the cubes in the file's frame
    points : (n,) int64, how many each holds
    spacing : (n,) float64, about the distance of neighbouring points of the node
    """

    keys: Int32Array
    bounds: FloatArray
    points: IntArray
    spacing: FloatArray
    offsets: IntArray
    sizes: IntArray

    def __len__(self) -> int:
        return len(self.keys)

    def take(self, rows: AnyArray) -> Nodes:
        """Those of a mask, or of row numbers."""
        return Nodes(
            self.keys[rows],
            self.bounds[rows],
            self.points[rows],
            self.spacing[rows],
            self.offsets[rows],
            self.sizes[rows],
        )


class CopcFile:
    """An open COPC file. Pages of its table of nodes are read once, when they are first needed."""

    def __init__(self, path: str | Path) -> None:
        """Raises InputError where it is no COPC file, or a damaged one."""
        self.path = Path(path)
        require_regular(self.path)
        if not is_copc(path):
            raise InputError(Finding("file.other-format", format="COPC"), file=path)
        self.top: Top = read_top(self.path)
        self._settle_axes()
        info = self.top.records.get(("copc", 1), b"")
        if len(info) < _INFO_BYTES or self.top.layers == 0:
            raise self._damaged(tr("the first record is truncated"))
        x, y, z, half, spacing, at, size = struct.unpack_from("<5d2Q", info)
        if not np.isfinite([x, y, z, half, spacing]).all() or half <= 0 or spacing <= 0:
            raise self._damaged(tr("the bounding cube is not valid"))
        self._low = np.array([x, y, z]) - half
        self._side, self._spacing = 2.0 * half, spacing
        self._layout: Layout = layout_of(self.top, self.path)
        self._choice: Choice | None = None
        self._pages: list[tuple[int, int, Key]] = [(at, size, (0, 0, 0, 0))]
        self._seen: set[int] = set()
        self._entries: dict[Key, tuple[int, int, int]] = {}
        self._file: BinaryIO = open_regular(self.path)
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
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()

    @property
    def points(self) -> int:
        """How many the whole file promises."""
        return self.top.points

    @property
    def bounds(self) -> FloatArray:
        """(2, 3) of all points, as the header says."""
        return self.top.bounds

    @property
    def crs(self) -> str | None:
        """As LoadedModel's; None where the file names no projected one."""
        return self._axes.crs if self.refused is None else None

    def _settle_axes(self) -> None:
        """Heights in the unit of x and y, as `vomstudio.io.models.opening` has them."""
        stated = las_reference(self.path)
        messages, text = list(stated.warnings), stated.text
        if text is None:
            text, problem = sidecar_crs(self.path, self.top.bounds)
            messages += [problem] if problem else []
        self._axes = stated_axes(text, stated.height_unit)
        self.refused = refusal(self._axes, self.top.bounds)
        self.warnings = (*messages, *(unit_findings(self._axes) if self.refused is None else ()))
        flat = self._axes.unit_factor
        self._factors = np.array([flat, flat, flat * self._axes.height_factor])
        if (self._factors != 1.0).any():
            top, factors = self.top, self._factors
            self.top = replace(
                top,
                scales=top.scales * factors,
                offsets=top.offsets * factors,
                bounds=top.bounds * factors,
            )

    def nodes(self, levels: range | None = None, bounds: AnyArray | None = None) -> Nodes:
        """The nodes of `levels` whose cubes touch `bounds` (2, 3); all of them without. Raises
        InputError where the table of nodes is damaged."""
        self._load_pages(levels, bounds)
        keys = np.array(list(self._entries), np.int32).reshape(-1, 4)
        rest = np.array(list(self._entries.values()), np.int64).reshape(-1, 3)
        order = np.lexsort((rest[:, 0], keys[:, 0]))
        keys, rest = keys[order], rest[order]
        keep = rest[:, 2] > 0
        if levels is not None:
            keep &= (keys[:, 0] >= levels.start) & (keys[:, 0] < levels.stop)
        cubes = self._cubes(keys)
        if bounds is not None:
            keep &= _touches(cubes, bounds)
        spacing = self._spacing * self._factors[0] / 2.0 ** keys[:, 0]
        return Nodes(keys, cubes, rest[:, 2], spacing, rest[:, 0], rest[:, 1]).take(keep)

    def overview(self, count: int) -> Nodes:
        """The first levels: as many as hold about `count` points together, at least one."""
        chosen = self.nodes(range(1))
        for level in range(1, _DEEPEST):
            more = self.nodes(range(level + 1))
            if len(more) == len(chosen) or more.points.sum() > 1.5 * count:
                break
            chosen = more
        return chosen

    def read(self, nodes: Nodes) -> PointCloud:
        """Their points, one node after the other in the order of `nodes`. Colours and fields are
        those of the root node, so that pieces can be joined. Raises InputError where a node is
        damaged."""
        if self._choice is None:
            root = self.nodes(range(1))
            first = root if len(root) else self.nodes().take(np.arange(1))
            self._choice = choose(self._records(first), self._layout)
        return cloud_of(self._records(nodes), self._layout, self.top, self._choice)

    def has_withheld(self) -> bool:
        """Whether points of the first level are marked as not to be used."""
        return bool(withheld_of(self._records(self.nodes(range(1))), self._layout).any())

    def _records(self, nodes: Nodes) -> AnyArray:
        total = int(nodes.points.sum())
        if total > self.top.points:
            raise self._damaged(tr("the nodes hold more points than the whole file"))
        chunks: list[bytes] = []
        for at, size, points in zip(nodes.offsets, nodes.sizes, nodes.points, strict=True):
            try:
                self._file.seek(int(at))
                chunk = self._file.read(int(size))
            except OSError as error:
                raise InputError(
                    Finding("file.unreadable", reason=error.strerror), file=self.path
                ) from error
            if len(chunk) != size or not is_sound_chunk(chunk, int(points), self.top):
                raise self._damaged(tr("a node does not agree with the hierarchy"))
            chunks.append(chunk)
        found = unpack(chunks, nodes.points.tolist(), self.top, FETCHED_AT_ONCE)
        if found is None:
            raise self._damaged(tr("a node cannot be decompressed"))
        return found.reshape(-1).view(self._layout.kind)

    def _load_pages(self, levels: range | None, bounds: AnyArray | None) -> None:
        """Read what pages are still unread and may name nodes of these levels and bounds."""
        while True:
            wanted = [page for page in self._pages if self._is_wanted(page[2], levels, bounds)]
            if not wanted:
                return
            self._pages = [page for page in self._pages if page not in wanted]
            for at, size, _ in wanted:
                self._load_page(at, size)

    def _load_page(self, at: int, size: int) -> None:
        if at in self._seen or at + size > self.top.size or size % _ENTRY.itemsize:
            raise self._damaged(tr("the hierarchy of nodes is truncated or circular"))
        self._seen.add(at)
        self._file.seek(at)
        page = np.frombuffer(self._file.read(size), _ENTRY)
        level = page["key"][:, 0]
        if len(page) * _ENTRY.itemsize != size or not ((level >= 0) & (level <= _DEEPEST)).all():
            raise self._damaged(tr("the hierarchy of nodes is not valid"))
        if (page["key"][:, 1:] < 0).any() or (page["key"][:, 1:] >> level[:, None]).any():
            raise self._damaged(tr("the hierarchy has nodes outside of the bounding cube"))
        held = page["points"] > 0
        end = page["offset"].astype(np.float64) + page["bytes"]
        if (
            (page["bytes"][held] < _FEWEST_BYTES).any()
            or (end[held] > self.top.size).any()
            or (page["points"][held] > MAX_CHUNK_POINTS).any()
        ):
            raise self._damaged(tr("the hierarchy of nodes points outside of the file"))
        for key, offset, length, points in page.tolist():
            place = (int(key[0]), int(key[1]), int(key[2]), int(key[3]))
            if points == -1:
                self._pages.append((offset, max(length, 0), place))
            else:
                self._entries[place] = (offset if points > 0 else 0, length, max(points, 0))

    def _is_wanted(self, key: Key, levels: range | None, bounds: AnyArray | None) -> bool:
        if levels is not None and key[0] >= levels.stop:
            return False
        return bounds is None or bool(
            _touches(self._cubes(np.array([key], np.int32)), bounds).all()
        )

    def _cubes(self, keys: AnyArray) -> AnyArray:
        side = self._side / 2.0 ** keys[:, :1]
        low = self._low + keys[:, 1:] * side
        cubes: AnyArray = np.stack([low, low + side], axis=1) * self._factors
        return cubes

    def _damaged(self, why: str) -> InputError:
        return InputError(Finding("file.damaged", reason=why, format="COPC"), file=self.path)


def nodes(path: str | Path, levels: range | None = None, bounds: AnyArray | None = None) -> Nodes:
    """The nodes of a file; see `CopcFile.nodes`."""
    with CopcFile(path) as file:
        return file.nodes(levels, bounds)


def crs_of(path: str | Path) -> tuple[str | None, tuple[Finding, ...]]:
    """The reference system of a COPC file, or of `NAME.prj` beside it, and what is to be said of
    it. Raises InputError where x and y are in degrees."""
    with CopcFile(path) as file:
        if file.refused is not None:
            raise InputError(file.refused, file=path, field="CRS")
        hidden = (Finding("model.withheld-hidden"),) if file.has_withheld() else ()
        return file.crs, (*file.warnings, *hidden)


OVERVIEW_POINTS = 200_000


def points_in(path: str | Path) -> int:
    """How many points a COPC file promises; 0 where it is none."""
    if not is_copc(path):
        return 0
    try:
        return read_top(Path(path)).points
    except InputError:
        return 0


def stream(path: str | Path, budget: int) -> StreamedCloud:
    """A COPC file of which at most `budget` points are to be held, with its first levels read.

    The file stays open as long as the cloud is there. Raises InputError.
    """
    file = CopcFile(path)
    try:
        found = file.nodes()
        if file.refused is not None:
            raise InputError(file.refused, file=path, field="CRS")
        if not len(found) or not np.isfinite(file.bounds).all():
            raise InputError(Finding("model.no-points"), file=path)
        order = np.argsort(found.offsets)
        starts = np.empty(len(found), np.int64)
        starts[order] = np.concatenate([[0], np.cumsum(found.points[order])[:-1]])
        rows = _first(found, OVERVIEW_POINTS)
        overview = file.read(found.take(np.array(rows)))
    except BaseException:
        file.close()
        raise
    lock = threading.Lock()

    def read(rows: Sequence[int]) -> PointCloud:
        # One thread at a time: they share the place in the file.
        with lock:
            return file.read(found.take(np.array(rows)))

    store = NodeStore(
        found.bounds,
        found.spacing,
        found.points,
        starts,
        parents_of(found.keys),
        read,
        budget,
        rows,
    )
    weakref.finalize(store, file.close)
    for row, part in zip(rows, parts_of(overview, found.points[list(rows)].tolist()), strict=True):
        store.put(row, part)
    return StreamedCloud(
        overview.points,
        overview.colors,
        None,
        overview.fields,
        store=store,
        box=file.bounds,
    )


def _first(found: Nodes, count: int) -> tuple[int, ...]:
    """Rows of the first levels, as many as hold about `count` points together, at least one."""
    levels = found.keys[:, 0]
    chosen = levels == levels.min()
    for level in range(int(levels.min()) + 1, int(levels.max()) + 1):
        more = levels <= level
        if found.points[more].sum() > 1.5 * count:
            break
        chosen = more
    return tuple(np.flatnonzero(chosen).tolist())


def _touches(cubes: AnyArray, bounds: AnyArray) -> AnyArray:
    low, high = np.asarray(bounds, np.float64)
    touches: AnyArray = ((cubes[:, 0] <= high) & (cubes[:, 1] >= low)).all(axis=1)
    return touches
