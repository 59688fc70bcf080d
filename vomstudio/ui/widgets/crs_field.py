"""Field for a projected coordinate reference system, by code, name or country."""

from __future__ import annotations

from collections.abc import Collection

from vomstudio.core.words import tr
from vomstudio.io.gis.crs_names import search_systems
from vomstudio.ui.widgets.search_field import Match, SearchField

_MIN_LETTERS = 2


class CrsField(SearchField):
    """Field that searches codes, names and areas; a selected match is replaced by its code.

    Parameters
    ----------
    code : str
        Initial text.
    preferred_names : collection of str
        Codes of systems that precede the other matches, such as the CRS of the project.
    """

    def __init__(self, code: str = "", preferred_names: Collection[str] = ()) -> None:
        super().__init__(self._find_matches, code)
        self.setToolTip(tr("Code, name or country, such as “32633”, “UTM 33N” or “Iceland”."))
        self.preferred_names = preferred_names

    def _find_matches(self, text: str) -> list[Match]:
        if len(text.strip()) < _MIN_LETTERS:
            return []
        systems = search_systems(text, preferred_names=self.preferred_names)
        return [(f"{item.name}  ({item.code}; {item.area})", item.code) for item in systems]
