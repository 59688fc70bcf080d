"""Drawing of tiles in several threads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from vomstudio.core.progress import Progress
from vomstudio.core.threads import PROCESSORS, map_unordered
from vomstudio.core.words import tr
from vomstudio.products.ortho.tiles import Drawer, Grid, Tile

MAX_THREADS = 8

Drawn = TypeVar("Drawn")


def draw_tiles(
    source: Drawer[Drawn], grid: Grid, progress: Progress, threads: int | None
) -> Iterator[tuple[Tile, Drawn]]:
    """Yield each tile with its drawing as soon as it is ready.

    Only a few tiles are drawn at a time, so that memory is bounded.
    """
    tiles = grid.tiles()
    progress.stage(tr("Casting rays"), len(tiles))
    workers = min(threads or PROCESSORS, MAX_THREADS, len(tiles))
    for done_count, (index, drawing) in enumerate(map_unordered(source.draw, tiles, workers), 1):
        yield tiles[index], drawing
        progress.step(done_count)
