"""Selection of the picks to repeat."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding

SHARE = 0.1


def select_repeats(ids: Collection[str], share: float = SHARE, seed: str = "") -> tuple[str, ...]:
    """Select a random share of the picks in random order, at least one.

    The selection depends on ids and seed only, not on their order, and further picks do not change
    the order of the previous ones.

    Parameters
    ----------
    ids : collection of str
    share : float
        Share of the picks, above 0 and at most 1.
    seed : str

    Returns
    -------
    tuple of str

    Raises
    ------
    UsageError
        If the share is out of range.
    """
    if not 0.0 < share <= 1.0:
        raise UsageError(
            Finding("option.out-of-range", value=share, minimum=0, maximum=1), field="share"
        )
    count = math.ceil(share * len(ids) - 1e-9)
    return tuple(sorted(ids, key=lambda id_: (_draw(seed, id_), id_))[:count])


def _draw(seed: str, id_: str) -> bytes:
    """Return a pseudorandom key that depends on seed and id only."""
    return hashlib.sha256(f"{seed}\0{id_}".encode()).digest()
