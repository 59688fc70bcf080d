"""Visibility of records, stored with the project as view state and not undoable."""

from __future__ import annotations

from collections.abc import Iterable

from vomstudio.core.signals import Signal
from vomstudio.project.kinds import visibility_group
from vomstudio.studio.projects import Projects

VIEW_KEY = "hidden"


class Visibility:
    """Visibility of records; `changed` emits the ids that were shown or hidden."""

    def __init__(self, projects: Projects) -> None:
        self.changed: Signal[tuple[str, ...]] = Signal()
        self._projects = projects
        self.hidden: set[str] = set()

    def load(self) -> None:
        """Read the state of the open project, without a signal."""
        self.hidden = {id_ for id_ in self._projects.view(VIEW_KEY, []) if isinstance(id_, str)}

    def visible(self, id_: str) -> bool:
        """Return whether a record, feature type or group is shown."""
        return id_ not in self.hidden

    def show_only(self, ids: Iterable[str]) -> None:
        """Show only these features and their types, without changing the models."""
        ids = set(ids)
        features = self._projects.session.features()
        groups = {visibility_group(f) for f in features if f.id in ids}
        hidden_ids = {f.id for f in features if f.id not in ids}
        changed_ids = (self.hidden & (ids | groups)) | (hidden_ids - self.hidden)
        self._set((self.hidden - ids - groups) | hidden_ids, changed_ids)

    def show_all(self) -> None:
        """Show everything."""
        self._set(set(), set(self.hidden))

    def set_visible(self, ids: Iterable[str], is_visible: bool) -> None:
        """Show or hide records, feature types or groups."""
        ids = set(ids)
        self._set(self.hidden - ids if is_visible else self.hidden | ids, ids)

    def _set(self, hidden_ids: set[str], changed_ids: set[str]) -> None:
        if changed_ids:
            self.hidden = hidden_ids
            self._projects.store_view(VIEW_KEY, sorted(hidden_ids))
            self.changed.emit(tuple(changed_ids))
