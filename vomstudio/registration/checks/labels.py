"""Labels and coordinates that two points have in common."""

from __future__ import annotations

import re
from collections.abc import Sequence

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding

_MAX_LISTED = 8


def similar_label_findings(labels: Sequence[str]) -> list[Finding]:
    """Return findings about labels that differ only in case, spaces and leading zeros.

    Parameters
    ----------
    labels : sequence of str

    Returns
    -------
    list of Finding
    """
    groups: dict[str, list[str]] = {}
    for label in labels:
        # 1-1 is not 11, nor A' (the end of a profile) A.
        plain_label = re.sub(r"(?<!\d)[\s_-]+|[\s_-]+(?!\d)", "", label.casefold())
        plain_label = re.sub(r"(?<!\d)0+(?=\d)", "", plain_label)
        groups.setdefault(plain_label, []).append(label)
    similar_groups = [
        group for plain_label, group in groups.items() if plain_label and len(group) > 1
    ]
    if not similar_groups:
        return []
    return [
        Finding(
            "control.similar-labels",
            labels="; ".join(
                ", ".join(f"“{label}”" for label in group) for group in similar_groups[:_MAX_LISTED]
            ),
        )
    ]


def coincident_point_findings(labels: Sequence[str], world: FloatArray) -> list[Finding]:
    """Return findings about points with the same coordinates.

    Parameters
    ----------
    labels : sequence of str
    world : (n, 3) ndarray

    Returns
    -------
    list of Finding
    """
    positions: dict[tuple[float, ...], list[str]] = {}
    for label, position in zip(labels, world.tolist(), strict=True):
        positions.setdefault(tuple(position), []).append(label)
    return [
        Finding("control.same-coordinates", labels=group)
        for group in positions.values()
        if len(group) > 1
    ]
