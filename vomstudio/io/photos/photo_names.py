"""Photos by the names that tables and other programs give them."""

from __future__ import annotations

from collections.abc import Callable, Sequence


def photo_finder(names: Sequence[str]) -> Callable[[str], int | None]:
    """What finds the number of a photo by its name as it stands in `names`, else by the last part
    of it, else by that without its ending, where one of the two has none; the latter two whatever
    their case, and only where they are those of one photo."""
    exact = {name: number for number, name in enumerate(names)}
    looser: list[dict[str, list[int]]] = [{}, {}]
    bare: dict[str, list[int]] = {}
    for number, name in enumerate(names):
        keys = _keys(name)
        for table, key in zip(looser, keys, strict=True):
            table.setdefault(key, []).append(number)
        if keys[0] == keys[1]:
            bare.setdefault(keys[0], []).append(number)

    def find(name: str) -> int | None:
        if name in exact:
            return exact[name]
        last, stem = _keys(name)
        # An ending that is there counts: a.jpg is not a.tif.
        tables = looser if last == stem else looser[:1]
        for table in tables:
            same = table.get(last, [])
            if len(same) == 1:
                return same[0]
        # Names of other programs' cameras may have none.
        same = bare.get(stem, [])
        return same[0] if len(same) == 1 else None

    return find


def _keys(name: str) -> tuple[str, str]:
    last = name.rsplit("/", 1)[-1].casefold()
    return last, last.rpartition(".")[0] or last
