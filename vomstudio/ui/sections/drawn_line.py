"""A line that a panel lets the user draw on the outcrop, and that stays a feature."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from vomstudio.document.edit import Edit
from vomstudio.document.kinds.dimension import Dimension
from vomstudio.document.records import get
from vomstudio.tools.measure import MeasureTool
from vomstudio.ui.common.studio import Studio


class DrawnLine(QObject):
    """drawn : a measured polyline is finished"""

    drawn = Signal(object)

    def __init__(self, parent: QObject, studio: Studio) -> None:
        super().__init__(parent)
        self._studio, self._waiting = studio, False
        studio.edited.connect(self._edited)
        studio.project_opened.connect(self.cancel)

    def begin(self) -> None:
        """Open the measure tool for a polyline."""
        self._studio.tool_of(MeasureTool).choose(kind="polyline")
        self._studio.activate("measure")
        self._waiting = True

    def cancel(self) -> None:
        """Wait for no line any more."""
        self._waiting = False

    def _edited(self, edit: Edit) -> None:
        if not self._waiting:
            return
        new = [get(edit.after, i, Dimension) for i in edit.after if edit.before[i] is None]
        drawn = [each for each in new if each is not None and each.kind == "polyline"]
        if drawn:
            self._waiting = False
            self.drawn.emit(drawn[-1])
