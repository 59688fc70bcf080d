"""Foreground fattening: depths that a matching window at an edge gives to the sky behind it."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray

# Windows that are matched reach this far over an edge, pixels.
_REACH = 16
_WINDOW = 5
# Standard deviation in a window of what counts as bare, values of 0..255: half as much again as
# that of the barest parts of the photo, where only its noise is left, but within these.
_LEAST_BARE, _MOST_BARE = 2.0, 4.0
_BAREST_PERCENT = 2.0
_OPEN, _FREE_SHARE = 33, 0.85
# Beside an edge, where the window does not tell, what is as bright as the sky belongs to it.
_SAME = 15.0


def sky_fringe(gray: ByteArray, valid: BoolArray, has: BoolArray) -> BoolArray:
    """(h, w) the pixels with a depth that show sky: bare, bright, and beside much of the same that
    has none. A window on the sky that reaches the skyline looks alike at the depth of the rock.

    gray : (h, w) the photo. valid : (h, w) where it counts. has : (h, w) where it has depths
    """
    import cv2

    value = gray.astype(np.float32)
    size = (_WINDOW, _WINDOW)
    mean = cv2.blur(value, size)
    spread = np.sqrt(np.maximum(cv2.blur(value * value, size) - mean * mean, 0))
    noise = float(np.percentile(spread[::3, ::3], _BAREST_PERCENT))
    # Rock in deep shade is bare too, but dark.
    bare = spread < np.clip(1.5 * noise, _LEAST_BARE, _MOST_BARE)
    bare &= mean > np.median(gray[::3, ::3])
    # Mortar and plaster have holes too: sky is where a whole square is bare and without depth.
    square = (_OPEN, _OPEN)
    free = cv2.blur((bare & valid & ~has).astype(np.float32), square) > _FREE_SHARE
    grown = np.asarray(cv2.dilate(free.astype(np.uint8), np.ones(square, np.uint8)), np.uint8)
    reached = grown & ~has
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    for _ in range(_REACH):
        reached = np.where(bare, cv2.dilate(reached, cross), reached)
    fringe = np.asarray(has & (reached > 0))
    if not fringe.any():
        return fringe
    sky = (bare & (reached > 0)).astype(np.float32)
    near = (2 * _WINDOW - 1, 2 * _WINDOW - 1)
    share = cv2.blur(sky, near)
    tone = cv2.blur(sky * value, near) / np.maximum(share, 1e-6)
    beside = (share > 1e-3) & (np.abs(value - tone) < _SAME)
    return np.asarray(has & ((reached > 0) | beside))
