"""Which picks are offered for a second time."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding

SHARE = 0.1


def select_for_repetition(
    ids: Collection[str], share: float = SHARE, seed: str = ""
) -> tuple[str, ...]:
    """A random share of the picks, at least one, in random order.

    The same for the same ids and seed, in whatever order these come; further picks leave the order
    of those that were there as it is. Raises UsageError for a share that is none.
    """
    if not 0.0 < share <= 1.0:
        raise UsageError(
            Finding("option.out-of-range", value=share, minimum=0, maximum=1), field="share"
        )
    wanted = math.ceil(share * len(ids) - 1e-9)
    return tuple(sorted(ids, key=lambda id_: (_draw(seed, id_), id_))[:wanted])


def _draw(seed: str, id_: str) -> bytes:
    """A number between 0 and 1, as it were, that only the two decide."""
    return hashlib.sha256(f"{seed}\0{id_}".encode()).digest()
