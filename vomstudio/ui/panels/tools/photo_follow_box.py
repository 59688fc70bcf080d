"""Box that enables path following in photos and shows the votes of other photos."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QCheckBox, QVBoxLayout, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.extraction.path_costs import COLOUR_COSTS
from vomstudio.studio.tools.followed_line import AUTO
from vomstudio.studio.tools.following import FollowingTool
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.studio import Studio


class PhotoFollowBox(QWidget):
    """Box with a check box, and below it the votes of the photos for the open feature."""

    def __init__(self, studio: Studio, tool: FollowingTool[Any]) -> None:
        super().__init__()
        self._studio, self._tool = studio, tool
        self.check = QCheckBox(tr("Follow in photos"))
        self.check.setObjectName(f"{tool.name}_in_photos")
        self.check.toggled.connect(tool.follow_in_photos)
        self.votes = Label()
        self.votes.setObjectName(f"{tool.name}_votes")
        self.votes.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.check)
        layout.addWidget(self.votes)
        studio.photo_links.changed.connect(self.refresh)
        self.refresh()

    def disabled_reason(self) -> Finding | None:
        """Return why paths cannot be followed in photos, or None if they can."""
        cost, links = self._tool.cost, self._studio.photo_links
        if self._tool.is_continued:
            return Finding("follow.continued")
        if cost is None:
            return Finding("follow.no-cost")
        if cost not in (*COLOUR_COSTS, AUTO):
            return Finding("follow.not-in-photos")
        if links.models():
            return None
        if links.busy():
            return Finding("follow.reading-cameras")
        problems = [p for model_id in self._studio.models if (p := links.problem(model_id))]
        if problems:
            return problems[0]
        return Finding("follow.no-cameras")

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        reason = self.disabled_reason()
        with QSignalBlocker(self.check):
            self.check.setChecked(self._tool.follows_photos)
        self.check.setEnabled(reason is None)
        self.check.setToolTip(
            str(reason)
            if reason is not None
            else tr("Follow lines at full photo resolution and project them onto the model.")
        )
        votes = self._tool.votes
        self.votes.setText(votes or "")
        self.votes.setVisible(votes is not None)
