"""Python's garbage collector, kept from looking through records while many are made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_collection(*, stays: bool = False) -> Iterator[None]:
    """Records, figures and rows hold no circles, so there is nothing to be found among them; yet
    the collector looks through all of them again and again while their number grows, which takes
    up to half of the time.

    stays : what is made is kept for long, and is not looked through afterwards either, which stops
        every thread for 30 ms where it is thousands of records. It still goes with the last that
        refers to it
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if stays:
            gc.freeze()
        if was_on:
            gc.enable()
