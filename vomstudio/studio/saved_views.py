"""Views that a user has named: camera and clipping box, kept with the project as view state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

_KEY = "named_views"
_MOST = 200
_LONGEST = 80


@dataclass(frozen=True)
class SavedView:
    """camera : as the viewport tells it; box : of the clipping box, None where it was off"""

    name: str
    camera: dict[str, Any]
    box: dict[str, Any] | None


class SavedViews:
    """In the order in which they were saved. `read` and `keep` are of the project that is open:
    read(key) and keep(key, value) of its view state."""

    def __init__(self, read: Callable[[str], object], keep: Callable[[str, object], None]) -> None:
        self._read, self._keep = read, keep

    def all(self) -> list[SavedView]:
        """What cannot be understood is left out: a lost view is no loss of work."""
        kept = self._read(_KEY)
        found: dict[str, SavedView] = {}
        for each in kept if isinstance(kept, list) else []:
            if not isinstance(each, Mapping):
                continue
            name, camera, box = each.get("name"), each.get("camera"), each.get("box")
            if isinstance(name, str) and name and isinstance(camera, dict):
                found[name] = SavedView(name, camera, box if isinstance(box, dict) else None)
        return list(found.values())[:_MOST]

    def save(self, view: SavedView) -> None:
        """Keep a view; one of the same name is replaced. Raises UsageError for a name that is none,
        or where there are too many."""
        name = " ".join(view.name.split())
        if not name or len(name) > _LONGEST:
            raise UsageError(
                Finding("view.name-length", maximum=_LONGEST),
                field=tr("name"),
            )
        others = [each for each in self.all() if each.name != name]
        if len(others) >= _MOST:
            raise UsageError(
                Finding("view.too-many", maximum=_MOST),
                field=tr("name"),
            )
        self._write([*others, SavedView(name, view.camera, view.box)])

    def delete(self, name: str) -> None:
        self._write([each for each in self.all() if each.name != name])

    def _write(self, views: list[SavedView]) -> None:
        self._keep(_KEY, [{"name": v.name, "camera": v.camera, "box": v.box} for v in views])
