"""Undo and redo over everything that the user does: steps of an open feature, unfinished features
that were discarded, and edits of the document. Each says what it took back or brought."""

from __future__ import annotations

from vomstudio.core.findings import Finding
from vomstudio.studio.editing import Editing
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects
from vomstudio.studio.tool_host import ToolHost
from vomstudio.studio.tools.interaction_types import Discarded
from vomstudio.studio.tools.tool_context import Tool

_LONGEST = 100


class History:
    """A discarded feature lies between two edits of the document, and comes back when undo has come
    to the place where it was discarded. So do the steps of a feature all of which were undone:
    redo brings them when it has come to their place. While a feature has steps they alone are
    undone and done again: what would come back into the document then, undo would not take back.
    """

    def __init__(
        self, projects: Projects, editing: Editing, tools: ToolHost, notices: Notices
    ) -> None:
        self._projects, self._editing = projects, editing
        self._tools, self._notices = tools, notices
        self._discarded: list[tuple[int, Discarded]] = []
        self._brought_back: tuple[int, Discarded] | None = None
        self._emptied: tuple[int, Tool] | None = None
        tools.let_go.connect(self._let_go)

    def forget(self) -> None:
        """Another project takes the place of this one."""
        self._discarded.clear()
        self._brought_back = self._emptied = None

    def _let_go(self, discarded: Discarded) -> None:
        top = self._top if discarded.after is None else discarded.after
        self._discarded = [*self._discarded[1 - _LONGEST :], (top, discarded)]
        self._brought_back = self._emptied = None

    @property
    def _top(self) -> int:
        return self._projects.session.top

    def _to_bring_back(self) -> Discarded | None:
        """What was discarded last, where no edit was made since and nothing else is open."""
        if self._tools.open_tool is not None or not self._discarded:
            return None
        top, discarded = self._discarded[-1]
        return discarded if top == self._top else None

    def _to_discard_again(self) -> Discarded | None:
        if self._brought_back is None:
            return None
        top, discarded = self._brought_back
        return discarded if top == self._top and discarded.untouched() else None

    # --- back --------------------------------------------------------------------------------
    @property
    def undo_label(self) -> str | None:
        """What would be undone; None where there is nothing."""
        tool = self._tools.open_tool
        if tool is not None and (tool.paints or tool.undo_label is not None):
            # What is being painted is let go or kept first: it is no step yet.
            return tool.undo_label
        if (discarded := self._to_bring_back()) is not None:
            return discarded.label
        return self._projects.session.undo_label

    def undo(self) -> None:
        """Undo the last step of the unfinished feature, else bring back the one that was discarded
        last, else undo the last edit."""
        label, discarded = self.undo_label, self._to_bring_back()
        tool = self._tools.open_tool
        if label is None:
            return
        if tool is not None and tool.undo_label is not None:
            done = tool.undo()
            self._emptied = None if tool.open else (self._top, tool)
        elif discarded is not None:
            done = self._bring_back(discarded)
        else:
            self.undo_edit()
            return
        if done:
            self._notices.info(Finding("edit.undone", edit=step_words(label)))

    def undo_edit(self) -> None:
        """Undo the last edit of the document, whatever is unfinished on the outcrop: for what is
        drawn elsewhere, where that is not seen."""
        label = self._projects.session.undo_label
        if label is not None and self._editing.undo():
            self._notices.info(Finding("edit.undone", edit=step_words(label)))

    def redo_edit(self) -> None:
        """Redo the last undone edit of the document, as `undo_edit` undoes it."""
        label = self._projects.session.redo_label
        if label is not None and self._editing.redo():
            self._notices.info(Finding("edit.redone", edit=step_words(label)))

    def _bring_back(self, discarded: Discarded) -> bool:
        entry = self._discarded.pop()
        self._tools.activate(discarded.tool)
        if not discarded.bring_back():
            self._discarded.append(entry)
            return False
        self._brought_back = entry
        return True

    # --- forth -------------------------------------------------------------------------------
    def _to_step_again(self) -> Tool | None:
        """The tool with a step that undo took back: the open one, or the one that has none left."""
        tool = self._tools.open_tool
        if tool is None and self._emptied is not None and self._emptied[0] == self._top:
            tool = self._emptied[1]
        return None if tool is None or tool.redo_label is None else tool

    @property
    def redo_label(self) -> str | None:
        """What would be redone; None where there is nothing."""
        if (stepping := self._to_step_again()) is not None:
            return stepping.redo_label
        if (discarded := self._to_discard_again()) is not None:
            return discarded.label
        tool = self._tools.open_tool
        if tool is not None and (tool.paints or tool.undo_label is not None):
            return None
        return self._projects.session.redo_label

    def redo(self) -> None:
        """Do the step of the unfinished feature again that was undone last, else discard again what
        undo has just brought back, else redo the last undone edit."""
        label = self.redo_label
        if label is None:
            return
        done = True
        if (stepping := self._to_step_again()) is not None:
            self._tools.activate(stepping.name)
            done = stepping.redo()
        elif self._to_discard_again() is not None:
            self._tools.cancel()
        else:
            self.redo_edit()
            return
        if done:
            self._notices.info(Finding("edit.redone", edit=step_words(label)))


def step_words(label: str) -> str:
    """The label of a step as undo and redo name it: what was added is named itself."""
    words = label.removeprefix("Add ")
    return words[:1].upper() + words[1:]
