"""Random selection of picks to repeat."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding

DEFAULT_SHARE = 0.1


def select_repeats(
    ids: Collection[str], share: float = DEFAULT_SHARE, seed: str = ""
) -> tuple[str, ...]:
    """Select a random share of the picks in random order, but at least one pick.

    The selection depends only on the ids and the seed, not on the order of the ids. Additional
    picks do not change the relative order of previous ones.

    Parameters
    ----------
    ids : collection of str
    share : float
        Share of the picks, greater than 0 and at most 1.
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
    """Return a pseudorandom sort key that depends only on the seed and the id."""
    return hashlib.sha256(f"{seed}\0{id_}".encode()).digest()
