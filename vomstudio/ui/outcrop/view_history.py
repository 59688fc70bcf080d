"""Back and forward through the views: camera, clipping box and what of the models is hidden, apart
from the undo of the work."""

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

_REST_MS = 500
_LONGEST = 100


class _Hidden:
    """masks : which faces or points of each model are hidden"""

    def __init__(self, masks: Mapping[str, BoolArray]) -> None:
        self.masks = dict(masks)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Hidden) or self.masks.keys() != other.masks.keys():
            return False
        return all(np.array_equal(mask, other.masks[id_]) for id_, mask in self.masks.items())

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True)
class _View:
    """camera : as `Camera.to_dict` gives it"""

    camera: dict[str, Any]
    box: ClipBox | None
    clipping: bool
    hidden: _Hidden


class ViewHistory(QObject):
    """A view counts once it has stood still for half a second, or when it is gone back from: a drag
    is one step, however long."""

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._viewport: Viewport | None = None
        self._now: _View | None = None
        self._back: list[_View] = []
        self._forward: list[_View] = []
        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(_REST_MS)
        self._rest.timeout.connect(self._settle)

    def watch(self, viewport: Viewport) -> None:
        """From now on the views of this viewport are kept."""
        self._viewport = viewport
        viewport.camera_changed.connect(self._rest.start)
        self._studio.display.changed.connect(self._displayed)
        self._studio.hidden_elements_changed.connect(self._hid)
        self._studio.project_opened.connect(self._forget)
        self._studio.model_loaded.connect(self._rest.start)

    def stop(self) -> None:
        self._rest.stop()

    def _forget(self) -> None:
        """The views of another project are of another outcrop."""
        self._now = None
        self._back.clear()
        self._forward.clear()
        self._rest.start()

    def _displayed(self, what: str) -> None:
        if what in ("clip", "box"):
            self._rest.start()

    def _hid(self, _: str) -> None:
        self._rest.start()

    def _view(self) -> _View | None:
        if self._viewport is None or not self._studio.models:
            return None
        shown = self._studio.display
        hidden = _Hidden(self._studio.workspace.elements.all_hidden())
        return _View(self._viewport.moves.camera_state(), shown.box, shown.clipping, hidden)

    def _settle(self) -> None:
        self._rest.stop()
        now = self._view()
        if now is None or now == self._now:
            return
        if self._now is not None:
            self._back = [*self._back[1 - _LONGEST :], self._now]
            self._forward.clear()
        self._now = now
        self.changed.emit()

    # --- back and forward --------------------------------------------------------------------
    def why_not_back(self) -> Finding | None:
        """Why there is no earlier view; None where there is one."""
        # What has moved a moment ago is a step already.
        moving = self._rest.isActive() and self._now is not None and self._view() != self._now
        return None if self._back or moving else Finding("view.no-earlier")

    def why_not_forward(self) -> Finding | None:
        """Why there is no later view; None where there is one."""
        return None if self._forward else Finding("view.no-later")

    def back(self) -> None:
        """Look as before the last change of the view."""
        self._settle()
        self._go(self._back, self._forward)

    def forward(self) -> None:
        """Look again as before going back."""
        self._settle()
        self._go(self._forward, self._back)

    def _go(self, source: list[_View], target: list[_View]) -> None:
        if self._viewport is None or self._now is None or not source:
            return
        view = source.pop()
        target.append(self._now)
        self._studio.display.set_clip(view.box, view.clipping)
        self._viewport.moves.set_camera_state(view.camera)
        self._studio.workspace.elements.hide_all(view.hidden.masks)
        # Axes that were made orthogonal again may differ in the last digit.
        self._now = self._view()
        self._rest.stop()
        self.changed.emit()
