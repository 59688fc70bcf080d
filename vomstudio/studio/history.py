"""Undo and redo of all user actions, including steps within an unfinished feature.

Each action reports what it has undone or redone.
"""

from __future__ import annotations

from vomstudio.core.findings import Finding
from vomstudio.studio.editing import Editing
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects
from vomstudio.studio.tool_host import ToolHost
from vomstudio.studio.tools.interaction_types import DiscardedFeature
from vomstudio.studio.tools.tool_context import Tool

MAX_DISCARDED = 100


class History:
    """Undo and redo of all actions in chronological order.

    A discarded feature is stored with the edit that preceded it, and is restored when undo
    reaches that edit. The same applies to redoing a feature whose steps were all undone. While a
    feature has steps, only these can be undone and redone, because undo could not reach an edit
    that was redone in the meantime.
    """

    def __init__(
        self, projects: Projects, editing: Editing, tools: ToolHost, notices: Notices
    ) -> None:
        self._projects, self._editing = projects, editing
        self._tools, self._notices = tools, notices
        self._discarded_works: list[tuple[int, DiscardedFeature]] = []
        self._restored_work: tuple[int, DiscardedFeature] | None = None
        self._emptied_tool: tuple[int, Tool] | None = None
        tools.feature_discarded.connect(self._store_discarded)

    def clear_state(self) -> None:
        """Clear the history because another project is opened."""
        self._discarded_works.clear()
        self._restored_work = self._emptied_tool = None

    def _store_discarded(self, discarded_work: DiscardedFeature) -> None:
        top = self._top if discarded_work.after is None else discarded_work.after
        self._discarded_works = [*self._discarded_works[1 - MAX_DISCARDED :], (top, discarded_work)]
        self._restored_work = self._emptied_tool = None

    @property
    def _top(self) -> int:
        return self._projects.session.top

    def _restorable_work(self) -> DiscardedFeature | None:
        """Return the feature discarded last, or None if an edit followed or a feature is open."""
        if self._tools.open_tool is not None or not self._discarded_works:
            return None
        top, discarded_work = self._discarded_works[-1]
        return discarded_work if top == self._top else None

    def _discardable_work(self) -> DiscardedFeature | None:
        if self._restored_work is None:
            return None
        top, discarded_work = self._restored_work
        return discarded_work if top == self._top and discarded_work.is_untouched() else None

    # --- undo ---------------------------------------------------------------------------------
    @property
    def undo_label(self) -> str | None:
        """Label of the action that `undo` would undo, or None if nothing can be undone."""
        if self._tools.has_waiting_clicks:
            return "Click"
        tool = self._tools.open_tool
        if tool is not None and (tool.can_paint or tool.undo_label is not None):
            # A stroke that is being painted is not a step yet; it must be kept or discarded
            # first.
            return tool.undo_label
        if (discarded_work := self._restorable_work()) is not None:
            return discarded_work.label
        return self._projects.session.undo_label

    def undo(self) -> None:
        """Undo the last action: a step of the unfinished feature, a discard or an edit."""
        label, discarded_work = self.undo_label, self._restorable_work()
        tool = self._tools.open_tool
        if label is None:
            return
        if self._tools.has_waiting_clicks:
            self._tools.undo_click()
            is_undone = True
        elif tool is not None and tool.undo_label is not None:
            was_finishing = tool.is_finishing
            is_undone = tool.undo()
            if was_finishing and tool.is_open and not tool.is_finishing:
                # Another tool may have been activated in the meantime.
                self._tools.activate(tool.name)
            self._emptied_tool = None if tool.is_open else (self._top, tool)
        elif discarded_work is not None:
            is_undone = self._restore_work(discarded_work)
        else:
            self.undo_edit()
            return
        if is_undone:
            self._notices.info(Finding("edit.undone", edit=step_title(label)))

    def undo_edit(self) -> None:
        """Undo the last edit, even if a feature is unfinished on the outcrop.

        Views that do not show the outcrop use it.
        """
        label = self._projects.session.undo_label
        if label is not None and self._editing.undo():
            self._notices.info(Finding("edit.undone", edit=step_title(label)))

    def redo_edit(self) -> None:
        """Redo the last undone edit, even if a feature is unfinished on the outcrop."""
        label = self._projects.session.redo_label
        if label is not None and self._editing.redo():
            self._notices.info(Finding("edit.redone", edit=step_title(label)))

    def _restore_work(self, discarded_work: DiscardedFeature) -> bool:
        entry = self._discarded_works.pop()
        self._tools.activate(discarded_work.tool)
        if not discarded_work.restore_work():
            self._discarded_works.append(entry)
            return False
        self._restored_work = entry
        return True

    # --- redo ---------------------------------------------------------------------------------
    def _steppable_tool(self) -> Tool | None:
        """Return the tool (open, or with all steps undone) that can redo a step, or None."""
        tool = self._tools.open_tool
        if tool is None and self._emptied_tool is not None and self._emptied_tool[0] == self._top:
            tool = self._emptied_tool[1]
        return None if tool is None or tool.redo_label is None else tool

    @property
    def redo_label(self) -> str | None:
        """Label of the action that `redo` would redo, or None if nothing can be redone."""
        if (stepped_tool := self._steppable_tool()) is not None:
            return stepped_tool.redo_label
        if (discarded_work := self._discardable_work()) is not None:
            return discarded_work.label
        tool = self._tools.open_tool
        if tool is not None and (tool.can_paint or tool.undo_label is not None):
            return None
        return self._projects.session.redo_label

    def redo(self) -> None:
        """Redo the last undone action: a step of the unfinished feature, a discard or an edit."""
        label = self.redo_label
        if label is None:
            return
        is_redone = True
        if (stepped_tool := self._steppable_tool()) is not None:
            self._tools.activate(stepped_tool.name)
            is_redone = stepped_tool.redo()
        elif self._discardable_work() is not None:
            self._tools.cancel()
        else:
            self.redo_edit()
            return
        if is_redone:
            self._notices.info(Finding("edit.redone", edit=step_title(label)))


def step_title(label: str) -> str:
    """Return the label of a step for undo and redo, capitalised and without the word "Add"."""
    title = label.removeprefix("Add ")
    return title[:1].upper() + title[1:]
