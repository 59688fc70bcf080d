"""Polylines that the user draws for a panel; they remain features of the project."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from vomstudio.project.edit import Edit
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.records import get
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.ui.base.studio import Studio


class DrawnLine(QObject):
    """Request for a polyline that the user draws for a panel.

    Parameters
    ----------
    parent : QObject
    studio : Studio

    Attributes
    ----------
    finished : Signal
        Emitted with the `Dimension` of the finished polyline.
    """

    finished = Signal(object)

    def __init__(self, parent: QObject, studio: Studio) -> None:
        super().__init__(parent)
        self._studio, self._is_waiting = studio, False
        studio.edited.connect(self._follow_edit)

    def begin(self) -> None:
        """Open the measure tool, and wait for a polyline."""
        self._studio.get_tool(MeasureTool).choose(kind="polyline")
        self._studio.activate("measure")
        self._is_waiting = True

    def _follow_edit(self, edit: Edit) -> None:
        if not self._is_waiting:
            return
        new_dimensions = [
            get(edit.after, i, Dimension) for i in edit.after if edit.before[i] is None
        ]
        drawn_lines = [
            item for item in new_dimensions if item is not None and item.kind == "polyline"
        ]
        if drawn_lines:
            self._is_waiting = False
            self.finished.emit(drawn_lines[-1])
