"""A kernel over many elements at once on all processors, each over a piece of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from vomstudio.core.threads import PROCESSORS, thread_pool

_SMALLEST = 50_000
"""Elements of a piece: to hand it to a thread costs some tens of microseconds."""

Run = Callable[[Callable[[int, int], object]], None]


@contextmanager
def in_pieces(count: int) -> Iterator[Run]:
    """What runs work(first, last) over pieces of `count` elements, as many as there are processors,
    and returns when all are done. Few elements are one piece, in this thread. The work is a kernel,
    which lets go of the GIL, and writes to its own elements only.
    """
    pieces = min(PROCESSORS, count // _SMALLEST)
    if pieces < 2:
        yield partial(_alone, count)
        return
    ends = [count * i // pieces for i in range(pieces + 1)]
    with thread_pool(pieces - 1) as pool:

        def run(work: Callable[[int, int], object]) -> None:
            others = [pool.submit(work, *ends[i : i + 2]) for i in range(1, pieces)]
            work(ends[0], ends[1])
            for other in others:
                other.result()

        yield run


def _alone(count: int, work: Callable[[int, int], object]) -> None:
    work(0, count)
