"""Search for photos by the names that tables and other programs use."""

from __future__ import annotations

from collections.abc import Callable, Sequence


def photo_finder(names: Sequence[str]) -> Callable[[str], int | None]:
    """Return a function that finds the number of a photo from its name.

    Names are matched exactly, then by file name, then by stem if one of the two names has no
    suffix. The latter two matches ignore case and must be unique. The function returns None if no
    name matches.
    """
    row_by_name = {name: row for row, name in enumerate(names)}
    tables: list[dict[str, list[int]]] = [{}, {}]
    stems: dict[str, list[int]] = {}
    for row, name in enumerate(names):
        keys = _keys(name)
        for table, key in zip(tables, keys, strict=True):
            table.setdefault(key, []).append(row)
        if keys[0] == keys[1]:
            stems.setdefault(keys[0], []).append(row)

    def find(name: str) -> int | None:
        if name in row_by_name:
            return row_by_name[name]
        file_name, stem = _keys(name)
        # An existing suffix is significant: a.jpg is not a.tif.
        candidates = tables if file_name == stem else tables[:1]
        for table in candidates:
            matches = table.get(file_name, [])
            if len(matches) == 1:
                return matches[0]
        # Camera names of other programs may have no suffix.
        matches = stems.get(stem, [])
        return matches[0] if len(matches) == 1 else None

    return find


def _keys(name: str) -> tuple[str, str]:
    file_name = name.rsplit("/", 1)[-1].casefold()
    return file_name, file_name.rpartition(".")[0] or file_name
