"""Catalogue of findings: severity and text of every code, with one module per subject.

A text states the event, the value or file, and the remedy, in at most 25 words (see the project's
STYLE). Placeholders are those of `str.format`. A text that depends on a number is given in two
forms, singular and plural, which are selected by the value ``count``.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from vomstudio.core.finding_texts.entry import Entry, Severity

__all__ = ["SUBJECTS", "TEXTS", "Entry", "Severity", "get_texts"]

_names = sorted(module.name for module in pkgutil.iter_modules(__path__))
_modules = [import_module(f"{__name__}.{name}") for name in _names]
SUBJECTS = tuple(module for module in _modules if hasattr(module, "TEXTS"))

TEXTS: dict[str, Entry] = {
    code: entry for subject in SUBJECTS for code, entry in subject.TEXTS.items()
}


def get_texts(code: str) -> tuple[str, ...]:
    """Return the text of a code, or its singular and plural texts."""
    return TEXTS[code][1:]
