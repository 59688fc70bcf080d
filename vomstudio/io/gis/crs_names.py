"""Projected reference systems by name and area, as PROJ's database has them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache


@dataclass(frozen=True)
class NamedCrs:
    """code : "EPSG:n"; area : where it is used, in words"""

    code: str
    name: str
    area: str


@cache
def projected_systems() -> tuple[NamedCrs, ...]:
    """All that are in use, by their codes; some five thousand, read within half a second once."""
    from pyproj.database import query_crs_info
    from pyproj.enums import PJType

    found = query_crs_info(auth_name="EPSG", pj_types=[PJType.PROJECTED_CRS])
    systems = [
        NamedCrs(f"EPSG:{each.code}", each.name, each.area_of_use.name if each.area_of_use else "")
        for each in found
        if not each.deprecated
    ]
    return tuple(sorted(systems, key=lambda each: int(each.code[5:])))


def matching(text: str, most: int = 50) -> list[NamedCrs]:
    """Those whose code, name or area holds every word of the text; first those that have all of
    them in code and name, the shorter names before the longer ones."""
    words = text.casefold().replace(",", " ").split()
    if not words:
        return []
    by_name, by_area = [], []
    for each in projected_systems():
        name = f"{each.code} {each.name}".casefold()
        if all(word in name for word in words):
            by_name.append(each)
        else:
            all_of_it = f"{name} {each.area.casefold()}"
            if all(word in all_of_it for word in words):
                by_area.append(each)
    return (sorted(by_name, key=_length) + sorted(by_area, key=_length))[:most]


def _length(system: NamedCrs) -> int:
    return len(system.name)
