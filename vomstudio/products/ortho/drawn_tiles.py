"""Tiles drawn by several threads."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TypeVar

from vomstudio.products.ortho.tiles import Drawer, Grid, Tile
from vomstudio.progress import Progress
from vomstudio.words import tr

MAX_THREADS = 8

Drawn = TypeVar("Drawn")


def drawn_tiles(
    source: Drawer[Drawn], grid: Grid, progress: Progress, threads: int | None
) -> Iterator[tuple[Tile, Drawn]]:
    """Yield (tile, what was drawn) as they are done, a few at a time: memory stays bounded."""
    tiles = grid.tiles()
    progress.stage(tr("Casting rays"), len(tiles))
    workers = max(1, min(threads or os.cpu_count() or 1, MAX_THREADS, len(tiles)))
    waiting = iter(tiles)
    running: dict[Future[Drawn], Tile] = {}
    done = 0
    with ThreadPoolExecutor(workers) as pool:
        try:
            while True:
                for tile in waiting:
                    running[pool.submit(source.draw, tile)] = tile
                    if len(running) > workers:
                        break
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
                    done += 1
                    progress.step(done)
        finally:
            for future in running:
                future.cancel()
