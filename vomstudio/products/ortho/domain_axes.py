"""The axis of each domain of an interpretation: along which it is projected, and looked at."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vomstudio.errors import UsageError
from vomstudio.geology.domains import ProjectionAxis, projection_axes
from vomstudio.products.ortho.interpretation import Item
from vomstudio.words import tr

BEDS, FAULTS = "bedding", "fault"
"""Types of feature whose planes tell the axes."""


def domains_of(items: Iterable[Item]) -> list[str]:
    return sorted({item.domain for item in items if item.domain})


def axes_of_domains(items: Iterable[Item], field: str) -> dict[str, ProjectionAxis]:
    """By the planes of bedding of each domain, and of all faults. field : of whoever asks. Raises
    UsageError where no feature is in a domain."""
    planes = [item for item in items if item.normal is not None and item.dip_deg is not None]
    beds: dict[str, list[Item]] = {name: [] for name in domains_of(planes)}
    if not beds:
        raise UsageError(
            tr(
                "No plane is in a domain. Give the features their domains first (Properties > "
                "Domain, or a column called domain)."
            ),
            field=field,
        )
    for item in planes:
        if item.domain and item.kind.casefold() in (BEDS, ""):
            beds[item.domain].append(item)
    faults = [item for item in planes if item.kind.casefold() == FAULTS]
    found = projection_axes(
        {name: _angles(own) for name, own in beds.items() if own},
        _angles(faults) if faults else None,
    )
    none = tr("no plane of bedding is in it")
    return {name: found.get(name, ProjectionAxis(None, None, none)) for name in beds}


def _angles(items: list[Item]) -> tuple[np.ndarray, np.ndarray]:
    return (
        np.array([item.dip_direction_deg for item in items], np.float64),
        np.array([item.dip_deg for item in items], np.float64),
    )
