"""Edits of the open project; where one fails, the reason is shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from vomstudio.core.errors import VomError
from vomstudio.project.edit import Edit
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects


class Editing:
    """Applies edits; a refused one becomes a notice instead of an exception."""

    def __init__(self, projects: Projects, notices: Notices) -> None:
        self._projects, self._notices = projects, notices

    def apply(self, edit: Edit) -> bool:
        """Apply an edit; False, with the reason shown, where it is refused."""
        return self._do(lambda: self._projects.session.apply(edit))

    def attempt(self, make: Callable[..., Edit], *args: Any, **values: Any) -> bool:
        """Make an edit of `project.edits` and apply it."""
        return self._do(
            lambda: self._projects.session.apply(make(self._projects.records, *args, **values))
        )

    def undo(self) -> bool:
        """Undo the last edit; False, with the reason shown, where it cannot be written."""
        return self._do(self._projects.session.undo)

    def redo(self) -> bool:
        """Redo the last undone edit; False as for `undo`."""
        return self._do(self._projects.session.redo)

    def _do(self, do: Callable[[], object]) -> bool:
        try:
            do()
        except VomError as error:
            self._notices.fail(error)
            return False
        return True
