"""Projected reference systems by name and area, from the PROJ database."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyproj.aoi import AreaOfUse

_DEFAULT_DATUM = "WGS 84 /"
"""Datum that precedes the others because satellite receivers and drones use it."""


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
    """Return all valid projected systems (about 5000), in the order of their codes.

    They are loaded once, which takes up to half a second.
    """
    from pyproj.database import query_crs_info
    from pyproj.enums import PJType

    entries = query_crs_info(auth_name="EPSG", pj_types=[PJType.PROJECTED_CRS])
    # A system with several areas of use has several entries.
    systems = {
        int(item.code): NamedCrs(f"EPSG:{item.code}", item.name, _area(item.area_of_use))
        for item in reversed(entries)
        if not item.deprecated
    }
    return tuple(systems[code] for code in sorted(systems))


def search_systems(
    text: str, max_count: int = 50, *, preferred_names: Collection[str] = ()
) -> list[NamedCrs]:
    """Find systems whose code, name or area contains every word of a text.

    Systems that contain all words in code and name precede those that contain some
    only in the area. The former are sorted by preference, then by an exact code, then by the datum
    WGS 84, then by the length of the name; the latter by the length of the name. Returns an empty
    list for an empty text.

    Parameters
    ----------
    text : str
    max_count : int
        Maximum number of systems.
    preferred_names : collection of str
        Codes of systems that precede the others, such as the CRS of the project.
    """
    search_words = text.casefold().replace(",", " ").split()
    if not search_words:
        return []

    def rank(candidate: NamedCrs) -> tuple[bool, bool, bool, int]:
        code = candidate.code.rpartition(":")[2]
        is_wgs84 = candidate.name.startswith(_DEFAULT_DATUM)
        return (
            candidate.code not in preferred_names,
            code not in search_words,
            not is_wgs84,
            len(candidate.name),
        )

    name_matches, area_matches = [], []
    for item in projected_systems():
        name = f"{item.code} {item.name}".casefold()
        if all(word in name for word in search_words):
            name_matches.append(item)
        else:
            description = f"{name} {item.area.casefold()}"
            if all(word in description for word in search_words):
                area_matches.append(item)
    return (
        sorted(name_matches, key=rank) + sorted(area_matches, key=lambda system: len(system.name))
    )[:max_count]


def _area(area: AreaOfUse | None) -> str:
    return (area.name or "") if area is not None else ""
