"""Edits of the open project that report why they failed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from vomstudio.core.errors import VomError
from vomstudio.project.edit import Edit
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects


class Editing:
    """Access to edits: a rejected edit shows a notice instead of raising an error."""

    def __init__(self, projects: Projects, notices: Notices) -> None:
        self._projects, self._notices = projects, notices

    def apply(self, edit: Edit) -> bool:
        """Apply an edit. Return False, after showing the reason, if it is rejected."""
        return self._do(lambda: self._projects.session.apply(edit))

    def attempt(self, make: Callable[..., Edit], *args: Any, **values: Any) -> bool:
        """Create an edit with a function of `project.edits`, and apply it.

        Return False, after showing the reason, if it is rejected.
        """
        return self._do(
            lambda: self._projects.session.apply(make(self._projects.records, *args, **values))
        )

    def undo(self) -> bool:
        """Undo the last edit. Return False, after showing the reason, if it cannot be written."""
        return self._do(self._projects.session.undo)

    def redo(self) -> bool:
        """Redo the last undone edit. Return False, after showing the reason, if it fails."""
        return self._do(self._projects.session.redo)

    def _do(self, action: Callable[[], object]) -> bool:
        try:
            action()
        except VomError as error:
            self._notices.fail(error)
            return False
        return True
