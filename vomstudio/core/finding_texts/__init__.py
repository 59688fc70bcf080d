"""The catalogue of findings: severity and text of every code, in a module per subject.

A text states the event, the value or file, and the remedy, in at most 25 words (STYLE of the
project). Placeholders are those of `str.format`. A text that depends on a number is given twice:
for one and for several of the value ``count``.
"""

from __future__ import annotations

from vomstudio.core.finding_texts import (
    alignment,
    arguments,
    commands,
    control,
    drawings,
    edits,
    facets,
    files,
    fractures,
    frames,
    jobs,
    models,
    nets,
    notation,
    options,
    paths,
    photos,
    placing,
    planes,
    projects,
    reconstruction,
    registration,
    sections,
    sets,
    structures,
    surfaces,
    survey,
    tables,
    tools,
    views,
    workspace,
)
from vomstudio.core.finding_texts.entry import Entry, Severity

__all__ = ["SUBJECTS", "TEXTS", "Entry", "Severity", "texts_of"]

SUBJECTS = (
    alignment,
    arguments,
    commands,
    control,
    drawings,
    edits,
    facets,
    files,
    fractures,
    frames,
    jobs,
    models,
    nets,
    notation,
    options,
    paths,
    photos,
    placing,
    planes,
    projects,
    reconstruction,
    registration,
    sections,
    sets,
    structures,
    surfaces,
    survey,
    tables,
    tools,
    views,
    workspace,
)

TEXTS: dict[str, Entry] = {
    code: entry for subject in SUBJECTS for code, entry in subject.TEXTS.items()
}


def texts_of(code: str) -> tuple[str, ...]:
    """Return the text of a code, or its texts for one and for several."""
    return TEXTS[code][1:]
