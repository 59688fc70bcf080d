"""Selection shared by net, table, tree and 3-D view; it is view state and not undone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from vomstudio.core.signals import Signal


class Selection:
    """IDs of the selected records; the `changed` signal reports changes."""

    def __init__(self) -> None:
        self.changed: Signal[tuple[str, ...]] = Signal()
        self._ids: tuple[str, ...] = ()

    @property
    def ids(self) -> tuple[str, ...]:
        """IDs in the order of selection; the last one is the current one."""
        return self._ids

    @property
    def current(self) -> str | None:
        return self._ids[-1] if self._ids else None

    def set(self, ids: Iterable[str]) -> None:
        new_ids = tuple(dict.fromkeys(ids))
        if new_ids != self._ids:
            self._ids = new_ids
            self.changed.emit(new_ids)

    def toggle(self, id_: str) -> None:
        if id_ in self._ids:
            self.set(i for i in self._ids if i != id_)
        else:
            self.set((*self._ids, id_))

    def retain(self, ids: Iterable[str]) -> None:
        """Deselect all records that are not in `ids`."""
        known_ids = ids if isinstance(ids, Mapping) else set(ids)
        self.set(i for i in self._ids if i in known_ids)
