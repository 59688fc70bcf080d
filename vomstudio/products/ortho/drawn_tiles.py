"""Drawing of tiles in several threads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from vomstudio.core.progress import Progress
from vomstudio.core.threads import PROCESSOR_COUNT, map_unordered
from vomstudio.core.words import tr
from vomstudio.products.ortho.tiles import Drawer, Grid, Tile

MAX_THREADS = 8

TileResult = TypeVar("TileResult")


def draw_tiles(
    source: Drawer[TileResult], grid: Grid, progress: Progress, threads: int | None
) -> Iterator[tuple[Tile, TileResult]]:
    """Yield each tile with its drawing as soon as it is ready.

    Only a few tiles are drawn at a time, so that memory is bounded.
    """
    tiles = grid.tiles()
    progress.stage(tr("Casting rays"), len(tiles))
    worker_count = min(threads or PROCESSOR_COUNT, MAX_THREADS, len(tiles))
    for done_count, (index, drawing) in enumerate(
        map_unordered(source.draw, tiles, worker_count), 1
    ):
        yield tiles[index], drawing
        progress.step(done_count)
