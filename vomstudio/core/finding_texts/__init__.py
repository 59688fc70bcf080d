"""The catalogue of findings: severity and text of every code, in a module per subject.

A text states the event, the value or file, and the remedy, in at most 25 words (STYLE of the
project). Placeholders are those of `str.format`. A text that depends on a number is given twice:
for one and for several of the value ``count``.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from vomstudio.core.finding_texts.entry import Entry, Severity

__all__ = ["SUBJECTS", "TEXTS", "Entry", "Severity", "texts_of"]

_names = sorted(module.name for module in pkgutil.iter_modules(__path__))
_modules = [import_module(f"{__name__}.{name}") for name in _names]
SUBJECTS = tuple(module for module in _modules if hasattr(module, "TEXTS"))

TEXTS: dict[str, Entry] = {
    code: entry for subject in SUBJECTS for code, entry in subject.TEXTS.items()
}


def texts_of(code: str) -> tuple[str, ...]:
    """Return the text of a code, or its texts for one and for several."""
    return TEXTS[code][1:]
