"""Parallel execution of kernels, each on a part of the elements."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from vomstudio.core.threads import PROCESSOR_COUNT, thread_pool

MIN_PIECE_SIZE = 50_000
"""Minimum number of elements per piece; passing a piece to a thread takes tens of microseconds."""

Run = Callable[[Callable[[int, int], object]], None]


@contextmanager
def split_work(count: int) -> Iterator[Run]:
    """Yield a function that runs ``work(first, last)`` over pieces of a range.

    There are as many pieces as processors; a small number of elements forms one piece, which runs
    in this thread. The work is a kernel that releases the GIL and writes to its own elements only.

    Parameters
    ----------
    count : int
        Number of elements.
    """
    pieces = min(PROCESSOR_COUNT, count // MIN_PIECE_SIZE)
    if pieces < 2:
        yield partial(_run_in_one_piece, count)
        return
    ends = [count * i // pieces for i in range(pieces + 1)]
    with thread_pool(pieces - 1) as pool:

        def run(work: Callable[[int, int], object]) -> None:
            futures = [pool.submit(work, *ends[i : i + 2]) for i in range(1, pieces)]
            work(ends[0], ends[1])
            for future in futures:
                future.result()

        yield run


def _run_in_one_piece(count: int, kernel: Callable[[int, int], object]) -> None:
    kernel(0, count)
