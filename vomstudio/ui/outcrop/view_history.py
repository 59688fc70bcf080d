"""History of views, each with the camera, clipping box and hidden elements.

It is separate from the undo history of edits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.core.arrays import BoolArray
from vomstudio.core.findings import Finding
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.clipping import ClipBox
from vomstudio.ui.base.studio import Studio

_RECORD_DELAY_MS = 500
_MAX_VIEWS = 100


class _HiddenElements:
    """Hidden faces or points of each model.

    Parameters
    ----------
    masks : mapping of str to bool array
        Mask of the hidden elements, by the id of the model.
    """

    def __init__(self, masks: Mapping[str, BoolArray]) -> None:
        self.masks = dict(masks)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _HiddenElements) or self.masks.keys() != other.masks.keys():
            return False
        return all(np.array_equal(mask, other.masks[id_]) for id_, mask in self.masks.items())

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True)
class _View:
    """State of a view; `camera` is the result of `Camera.to_dict`."""

    camera: dict[str, Any]
    box: ClipBox | None
    is_clipping: bool
    hidden_elements: _HiddenElements


class ViewHistory(QObject):
    """History that records a view after half a second without changes, or when it is used.

    A drag is therefore one step.
    """

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._viewport: Viewport | None = None
        self._current_view: _View | None = None
        self._previous_views: list[_View] = []
        self._next_views: list[_View] = []
        self._record_timer = QTimer(self, singleShot=True, interval=_RECORD_DELAY_MS)
        self._record_timer.timeout.connect(self._record_view)

    def watch(self, viewport: Viewport) -> None:
        """Start recording the views of a viewport."""
        self._viewport = viewport
        viewport.camera_changed.connect(self._record_timer.start)
        self._studio.display.changed.connect(self._follow_display)
        self._studio.hidden_elements_changed.connect(self._follow_hiding)
        self._studio.project_opened.connect(self._clear)
        self._studio.model_loaded.connect(self._record_timer.start)

    def stop(self) -> None:
        self._record_timer.stop()

    def _clear(self) -> None:
        """Clear the history after another project has been opened."""
        self._current_view = None
        self._previous_views.clear()
        self._next_views.clear()
        self._record_timer.start()

    def _follow_display(self, setting: str) -> None:
        if setting in ("clip", "box"):
            self._record_timer.start()

    def _follow_hiding(self, _: str) -> None:
        self._record_timer.start()

    def _capture_view(self) -> _View | None:
        if self._viewport is None or not self._studio.models:
            return None
        display = self._studio.display
        hidden_elements = _HiddenElements(self._studio.workspace.elements.get_hidden_masks())
        return _View(
            self._viewport.moves.camera_state(), display.box, display.clipping, hidden_elements
        )

    def _record_view(self) -> None:
        self._record_timer.stop()
        view = self._capture_view()
        if view is None or view == self._current_view:
            return
        if self._current_view is not None:
            self._previous_views = [*self._previous_views[1 - _MAX_VIEWS :], self._current_view]
            self._next_views.clear()
        self._current_view = view
        self.changed.emit()

    # --- back and forward --------------------------------------------------------------------
    def back_problem(self) -> Finding | None:
        """Return the reason why `go_back` is not possible, or None if it is possible."""
        # A camera move that is not recorded yet is also a step.
        is_moving = (
            self._record_timer.isActive()
            and self._current_view is not None
            and self._capture_view() != self._current_view
        )
        return None if self._previous_views or is_moving else Finding("view.no-earlier")

    def forward_problem(self) -> Finding | None:
        """Return the reason why `go_forward` is not possible, or None if it is possible."""
        return None if self._next_views else Finding("view.no-later")

    def go_back(self) -> None:
        """Restore the view before the last change."""
        self._record_view()
        self._restore_view(self._previous_views, self._next_views)

    def go_forward(self) -> None:
        """Restore the view that was shown before `go_back`."""
        self._record_view()
        self._restore_view(self._next_views, self._previous_views)

    def _restore_view(self, source: list[_View], target: list[_View]) -> None:
        if self._viewport is None or self._current_view is None or not source:
            return
        view = source.pop()
        target.append(self._current_view)
        self._studio.display.set_clip(view.box, view.is_clipping)
        self._viewport.moves.set_camera_state(view.camera)
        self._studio.workspace.elements.hide_all(view.hidden_elements.masks)
        # Orthogonalised axes may differ in the last digit.
        self._current_view = self._capture_view()
        self._record_timer.stop()
        self.changed.emit()
