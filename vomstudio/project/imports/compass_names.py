"""Names of the objects of CloudCompare's Compass plugin."""

from __future__ import annotations

import re

_GENERATED_NAME = re.compile(
    r"(?:^|\.)(?:Trace|\d{2}/\d{3}|-?\d+\.\d on -?\d+->-?\d+)$", re.IGNORECASE
)
"""Names that the plugin generates for traces, planes and lineations."""


def object_name(name: str) -> str:
    """Return the name of an object, or "" if the plugin generated it.

    Parameters
    ----------
    name : str
        Name in the file.
    """
    return "" if _GENERATED_NAME.search(name) else name


def split_path(path: str) -> tuple[str, tuple[str, ...]]:
    """Split the name in a table, which begins with the names of the groups.

    Parameters
    ----------
    path : str
        Names separated by dots.

    Returns
    -------
    name : str
        Name of the object, or "" if the plugin generated it.
    groups : tuple of str
        Names of the groups, the innermost last.
    """
    match = _GENERATED_NAME.search(path)
    if match is not None:
        return "", tuple(filter(None, path[: match.start()].split(".")))
    *groups, name = path.split(".")
    return name, tuple(groups)
