"""Faces or points that were chosen by hand, and the steps in which they were."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from vomstudio.words import to_translate

Mask = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]
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


def combined(before: Mask, found: Mask, how: Combine) -> Mask:
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
        self.mask: Mask = np.zeros(size, np.bool_)
        self.count = 0
        self._steps: list[tuple[str, npt.NDArray[np.uint8]]] = []

    @property
    def last_step(self) -> str | None:
        """What the last step was; None where there is none to take back."""
        return self._steps[-1][0] if self._steps else None

    def ids(self) -> Ints:
        """(k,) of the chosen ones, sorted."""
        return np.flatnonzero(self.mask)

    def change(self, mask: Mask, step: str) -> bool:
        """Choose these and no others; False where these are chosen already."""
        if np.array_equal(mask, self.mask):
            return False
        self._steps = [*self._steps[1 - _STEPS :], (step, np.packbits(self.mask))]
        self._take(mask)
        return True

    def change_last(self, mask: Mask) -> None:
        """Have the last step lead to these."""
        self._take(mask)

    def before_last(self) -> Mask:
        """(n,) what was chosen before the last step."""
        return self._unpacked(self._steps[-1][1])

    def undo(self) -> bool:
        """Take the last step back; False where there is none."""
        if not self._steps:
            return False
        self._take(self._unpacked(self._steps.pop()[1]))
        return True

    def _take(self, mask: Mask) -> None:
        self.mask, self.count = mask, int(np.count_nonzero(mask))

    def _unpacked(self, bits: npt.NDArray[np.uint8]) -> Mask:
        return np.unpackbits(bits, count=len(self.mask)).view(np.bool_)

    # --- as a draft --------------------------------------------------------------------------
    def as_dict(self) -> dict[str, Any] | None:
        """What `from_dict` reads; None where it would be too long."""
        bits = base64.b64encode(zlib.compress(np.packbits(self.mask).tobytes(), 1)).decode()
        if len(bits) > _LONGEST:
            return None
        return {"model_id": self.model_id, "size": len(self.mask), "bits": bits}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> ChosenElements:
        """Raises KeyError, TypeError or ValueError where it is none."""
        made = cls(str(values["model_id"]), int(values["size"]))
        try:
            raw = zlib.decompress(base64.b64decode(str(values["bits"])))
        except zlib.error as error:
            raise ValueError(str(error)) from error
        made._take(made._unpacked(np.frombuffer(raw, np.uint8)))
        return made
