"""Manual selection of faces or points, with undo and redo."""

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
MAX_STEPS = 30
MAX_DRAFT_LENGTH = 4_000_000
"""Maximum length of a draft in characters, which limits the size of the journal."""


def combine_masks(previous: BoolArray, addition: BoolArray, combination: Combine) -> BoolArray:
    """Combine the previous selection with an addition."""
    if combination == "new":
        return addition
    if combination == "add":
        return previous | addition
    return previous & (~addition if combination == "subtract" else addition)


class ElementSelection:
    """Selection on one model; `mask` (n,) marks the selected faces or points.

    For undo, the mask before each of the last `MAX_STEPS` steps is stored as packed bits.
    """

    def __init__(self, model_id: str, size: int) -> None:
        self.model_id = model_id
        self.mask: BoolArray = np.zeros(size, np.bool_)
        self.count = 0
        self._steps: list[tuple[str, ByteArray]] = []
        self._undone_steps: list[tuple[str, ByteArray]] = []

    @property
    def last_step(self) -> str | None:
        """Label of the last step, or None if no step can be undone."""
        return self._steps[-1][0] if self._steps else None

    @property
    def next_step(self) -> str | None:
        """Label of the last undone step, or None if no step can be redone."""
        return self._undone_steps[-1][0] if self._undone_steps else None

    def ids(self) -> IntArray:
        """Return the sorted indices (k,) of the selected elements."""
        return np.flatnonzero(self.mask)

    def start(self, mask: BoolArray) -> None:
        """Select exactly the marked elements, as the state before the first step."""
        self._set_mask(mask)

    def change(self, mask: BoolArray, step: str) -> bool:
        """Select exactly the marked elements. Return False if the selection is unchanged."""
        if np.array_equal(mask, self.mask):
            return False
        self._steps = [*self._steps[1 - MAX_STEPS :], (step, np.packbits(self.mask))]
        self._undone_steps = []
        self._set_mask(mask)
        return True

    def change_last_step(self, mask: BoolArray) -> None:
        """Replace the result of the last step."""
        self._undone_steps = []
        self._set_mask(mask)

    def mask_before_last_step(self) -> BoolArray:
        """Return the selection (n,) before the last step."""
        return self._unpack(self._steps[-1][1])

    def undo(self) -> bool:
        """Undo the last step. Return False if no step can be undone."""
        if not self._steps:
            return False
        step, mask_before = self._steps.pop()
        self._undone_steps.append((step, np.packbits(self.mask)))
        self._set_mask(self._unpack(mask_before))
        return True

    def redo(self) -> bool:
        """Redo the last undone step. Return False if no step can be redone."""
        if not self._undone_steps:
            return False
        step, mask_after = self._undone_steps.pop()
        self._steps.append((step, np.packbits(self.mask)))
        self._set_mask(self._unpack(mask_after))
        return True

    def discard_undone_steps(self) -> None:
        """Discard the undone steps."""
        self._undone_steps = []

    def _set_mask(self, mask: BoolArray) -> None:
        self.mask, self.count = mask, int(np.count_nonzero(mask))

    def _unpack(self, packed_mask: ByteArray) -> BoolArray:
        return np.unpackbits(packed_mask, count=len(self.mask)).view(np.bool_)

    # --- drafts -------------------------------------------------------------------------------
    def to_dict(self) -> dict[str, Any] | None:
        """Return plain data for `from_dict`, or None if it would be too long."""
        encoded_mask = mask_to_dict(self.mask)
        return None if encoded_mask is None else {"model_id": self.model_id, **encoded_mask}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> ElementSelection:
        """Restore a draft. Raises KeyError, TypeError or ValueError if it is not valid."""
        mask = mask_from_dict(values)
        selection = cls(str(values["model_id"]), len(mask))
        selection._set_mask(mask)
        return selection


def mask_to_dict(mask: BoolArray) -> dict[str, Any] | None:
    """Return plain data for `mask_from_dict`, or None if it would be too long."""
    encoded_mask = base64.b64encode(zlib.compress(np.packbits(mask).tobytes(), 1)).decode()
    return (
        None if len(encoded_mask) > MAX_DRAFT_LENGTH else {"size": len(mask), "bits": encoded_mask}
    )


def mask_from_dict(values: Mapping[str, Any]) -> BoolArray:
    """Restore a mask. Raises KeyError, TypeError or ValueError if the data is not valid."""
    size = int(values["size"])
    unpack = zlib.decompressobj()
    try:
        # A wrong length in a damaged file must not exhaust memory.
        raw = unpack.decompress(base64.b64decode(str(values["bits"])), max(size // 8 + 1, 1))
    except zlib.error as error:
        raise ValueError(str(error)) from error
    if len(raw) != -(-size // 8):
        raise ValueError(f"{len(raw)} bytes for {size} bits")
    return np.unpackbits(np.frombuffer(raw, np.uint8), count=size).view(np.bool_)
