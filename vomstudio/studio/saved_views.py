"""Named views, which store the camera and clipping box with the project."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

VIEW_KEY = "named_views"
MAX_VIEWS = 200
MAX_NAME_LENGTH = 80


@dataclass(frozen=True)
class SavedView:
    """Named view: state of the camera, and clipping box (None if clipping was off)."""

    name: str
    camera: dict[str, Any]
    box: dict[str, Any] | None


class SavedViews:
    """Named views of the open project, in the order in which they were saved.

    `read_value(key)` and `write_value(key, value)` access the view state of the project.
    """

    def __init__(
        self, read_value: Callable[[str], object], write_value: Callable[[str, object], None]
    ) -> None:
        self._read_value, self._write_value = read_value, write_value

    def all(self) -> list[SavedView]:
        """Return all readable views."""
        stored_views = self._read_value(VIEW_KEY)
        views: dict[str, SavedView] = {}
        for item in stored_views if isinstance(stored_views, list) else []:
            if not isinstance(item, Mapping):
                continue
            name, camera, box = item.get("name"), item.get("camera"), item.get("box")
            if isinstance(name, str) and name and isinstance(camera, dict):
                views[name] = SavedView(name, camera, box if isinstance(box, dict) else None)
        return list(views.values())[:MAX_VIEWS]

    def save(self, view: SavedView) -> None:
        """Save a view, replacing an existing view with the same name.

        Raises
        ------
        UsageError
            If the name is empty or too long, or there are too many views.
        """
        name = " ".join(view.name.split())
        if not name or len(name) > MAX_NAME_LENGTH:
            raise UsageError(
                Finding("view.name-length", maximum=MAX_NAME_LENGTH),
                field=tr("name"),
            )
        other_views = [item for item in self.all() if item.name != name]
        if len(other_views) >= MAX_VIEWS:
            raise UsageError(
                Finding("view.too-many", maximum=MAX_VIEWS),
                field=tr("name"),
            )
        self._write([*other_views, SavedView(name, view.camera, view.box)])

    def delete(self, name: str) -> None:
        self._write([item for item in self.all() if item.name != name])

    def _write(self, views: list[SavedView]) -> None:
        self._write_value(
            VIEW_KEY, [{"name": v.name, "camera": v.camera, "box": v.box} for v in views]
        )
