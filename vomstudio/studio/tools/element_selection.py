"""Faces or points that were chosen by hand, and the steps in which they were."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, IntArray
from vomstudio.core.words import to_translate

Combine = Literal["new", "add", "subtract", "intersect"]

COMBINATIONS: dict[Combine, str] = {
    "new": to_translate("New"),
    "add": to_translate("Add"),
    "subtract": to_translate("Subtract"),
    "intersect": to_translate("Intersect"),
}
_STEPS = 30
_LONGEST = 4_000_000
"""Letters of a draft; what takes more is not worth the journal's room."""


def combined(before: BoolArray, found: BoolArray, how: Combine) -> BoolArray:
    """Of what was chosen before and what has been found now."""
    if how == "new":
        return found
    if how == "add":
        return before | found
    return before & (~found if how == "subtract" else found)


class ChosenElements:
    """Of one model. mask : (n,) which faces or points are chosen; count : how many

    The steps that were done are kept packed, so that each can be taken back.
    """

    def __init__(self, model_id: str, size: int) -> None:
        self.model_id = model_id
        self.mask: BoolArray = np.zeros(size, np.bool_)
        self.count = 0
        self._steps: list[tuple[str, ByteArray]] = []
        self._ahead: list[tuple[str, ByteArray]] = []

    @property
    def last_step(self) -> str | None:
        """What the last step was; None where there is none to take back."""
        return self._steps[-1][0] if self._steps else None

    @property
    def next_step(self) -> str | None:
        """What the step was that was taken back last; None where there is none."""
        return self._ahead[-1][0] if self._ahead else None

    def ids(self) -> IntArray:
        """(k,) of the chosen ones, sorted."""
        return np.flatnonzero(self.mask)

    def change(self, mask: BoolArray, step: str) -> bool:
        """Choose these and no others; False where these are chosen already."""
        if np.array_equal(mask, self.mask):
            return False
        self._steps = [*self._steps[1 - _STEPS :], (step, np.packbits(self.mask))]
        self._ahead = []
        self._take(mask)
        return True

    def change_last(self, mask: BoolArray) -> None:
        """Have the last step lead to these."""
        self._ahead = []
        self._take(mask)

    def before_last(self) -> BoolArray:
        """(n,) what was chosen before the last step."""
        return self._unpacked(self._steps[-1][1])

    def undo(self) -> bool:
        """Take the last step back; False where there is none."""
        if not self._steps:
            return False
        step, before = self._steps.pop()
        self._ahead.append((step, np.packbits(self.mask)))
        self._take(self._unpacked(before))
        return True

    def redo(self) -> bool:
        """Do the step again that was taken back last; False where there is none."""
        if not self._ahead:
            return False
        step, after = self._ahead.pop()
        self._steps.append((step, np.packbits(self.mask)))
        self._take(self._unpacked(after))
        return True

    def settle(self) -> None:
        """What was taken back is not done again."""
        self._ahead = []

    def _take(self, mask: BoolArray) -> None:
        self.mask, self.count = mask, int(np.count_nonzero(mask))

    def _unpacked(self, bits: ByteArray) -> BoolArray:
        return np.unpackbits(bits, count=len(self.mask)).view(np.bool_)

    # --- as a draft --------------------------------------------------------------------------
    def to_dict(self) -> dict[str, Any] | None:
        """What `from_dict` reads; None where it would be too long."""
        words = mask_to_dict(self.mask)
        return None if words is None else {"model_id": self.model_id, **words}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> ChosenElements:
        """Raises KeyError, TypeError or ValueError where it is none."""
        mask = mask_from_dict(values)
        made = cls(str(values["model_id"]), len(mask))
        made._take(mask)
        return made


def mask_to_dict(mask: BoolArray) -> dict[str, Any] | None:
    """What `mask_from_dict` reads, as plain data; None where it would be too long."""
    bits = base64.b64encode(zlib.compress(np.packbits(mask).tobytes(), 1)).decode()
    return None if len(bits) > _LONGEST else {"size": len(mask), "bits": bits}


def mask_from_dict(values: Mapping[str, Any]) -> BoolArray:
    """Raises KeyError, TypeError or ValueError where it is none."""
    size = int(values["size"])
    unpack = zlib.decompressobj()
    try:
        # What a damaged file says of its length must not fill the memory.
        raw = unpack.decompress(base64.b64decode(str(values["bits"])), max(size // 8 + 1, 1))
    except zlib.error as error:
        raise ValueError(str(error)) from error
    if len(raw) != -(-size // 8):
        raise ValueError(f"{len(raw)} bytes for {size} bits")
    return np.unpackbits(np.frombuffer(raw, np.uint8), count=size).view(np.bool_)
