"""Projected reference systems by name and area, from the PROJ database."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyproj.aoi import AreaOfUse


@dataclass(frozen=True)
class NamedCrs:
    """Projected CRS of the PROJ database.

    Parameters
    ----------
    code : str
        "EPSG:n".
    name : str
    area : str
        Description of the area of use.
    """

    code: str
    name: str
    area: str


@cache
def projected_systems() -> tuple[NamedCrs, ...]:
    """Return all valid systems by code, about 5000, which load once within half a second."""
    from pyproj.database import query_crs_info
    from pyproj.enums import PJType

    entries = query_crs_info(auth_name="EPSG", pj_types=[PJType.PROJECTED_CRS])
    systems = [
        NamedCrs(f"EPSG:{each.code}", each.name, _area(each.area_of_use))
        for each in entries
        if not each.deprecated
    ]
    return tuple(sorted(systems, key=lambda each: int(each.code[5:])))


def search_systems(text: str, max_count: int = 50) -> list[NamedCrs]:
    """Find systems whose code, name or area contains every word of a text.

    Systems with all words in code and name precede the others, and shorter names precede longer
    ones.

    Parameters
    ----------
    text : str
    max_count : int
        Maximum number of systems.
    """
    words = text.casefold().replace(",", " ").split()
    if not words:
        return []
    name_matches, area_matches = [], []
    for each in projected_systems():
        name = f"{each.code} {each.name}".casefold()
        if all(word in name for word in words):
            name_matches.append(each)
        else:
            description = f"{name} {each.area.casefold()}"
            if all(word in description for word in words):
                area_matches.append(each)
    return (sorted(name_matches, key=_length) + sorted(area_matches, key=_length))[:max_count]


def _area(area: AreaOfUse | None) -> str:
    return (area.name or "") if area is not None else ""


def _length(system: NamedCrs) -> int:
    return len(system.name)
