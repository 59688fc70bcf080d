"""Names of the symbols of feature types in menus and dialogs."""

from __future__ import annotations

from vomstudio.core.words import to_translate

SYMBOL_NAMES = {
    "circle": to_translate("Circle"),
    "square": to_translate("Square"),
    "triangle": to_translate("Triangle"),
    "diamond": to_translate("Diamond"),
    "pentagon": to_translate("Pentagon"),
    "star": to_translate("Star"),
}
"""Names by symbol code, which is one of `theme.SYMBOLS`; marked for translation."""
