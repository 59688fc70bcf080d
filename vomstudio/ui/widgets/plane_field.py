"""Field for the attitude of a plane in the notation of the settings.

The attitude is typed, or taken from the selected plane or from the view.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plane, parse_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.vectors import wrap360
from vomstudio.ui.base.command_targets import current_measurement
from vomstudio.ui.base.controls import icon_button, set_enabled
from vomstudio.ui.base.studio import Studio

ViewDirection = Callable[[], tuple[float, float] | None]
"""Function that returns the trend and plunge of the view in degrees; None if no view."""


class PlaneField(QWidget):
    """Field for the attitude of a plane.

    Parameters
    ----------
    empty_text : str
        Placeholder of the empty field.
    view : callable, optional
        Returns the view direction or None, for a button that uses the plane perpendicular to
        the view.

    Attributes
    ----------
    changed : Signal
        Emitted when the text changes.
    """

    changed = Signal()

    def __init__(
        self, studio: Studio, name: str, empty_text: str = "", view: ViewDirection | None = None
    ) -> None:
        super().__init__()
        self._studio, self._empty_text, self._view = studio, empty_text, view
        self._notation = ""
        self.line = QLineEdit()
        self.line.setObjectName(name)
        self.line.textChanged.connect(lambda _: self.changed.emit())
        self.take_button = icon_button("cursor-default-click-outline", tr("Use selected"))
        self.take_button.setToolTip(tr("Use the attitude of the selected plane."))
        self.take_button.clicked.connect(lambda _=False: self._use_selection())
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(3)
        row.addWidget(self.line, 1)
        row.addWidget(self.take_button)
        if view is not None:
            self.view_button = icon_button("eye-outline", tr("Use this view"))
            self.view_button.setToolTip(tr("Use the plane perpendicular to the view."))
            self.view_button.clicked.connect(lambda _=False: self._take_view())
            row.addWidget(self.view_button)
        studio.settings_changed.connect(self._notation_changed)
        studio.selection_changed.connect(self._refresh)
        self._notation_changed()
        self._refresh()

    def plane(self) -> Plane | None:
        """Return the plane, or None if the field is empty. Raises InputError if it is invalid."""
        text = self.line.text().strip()
        return parse_plane(text, self._notation) if text else None

    def show_plane(self, plane: Plane, decimals: int = 1) -> None:
        self.line.setText(format_plane(plane, self._notation, decimals))

    def _notation_changed(self) -> None:
        """Rewrite the text in the new notation."""
        previous_notation, notation = self._notation, self._studio.settings.notation
        self._notation = notation
        example = tr("such as {example}", example=format_plane(Plane(135.0, 70.0), notation))
        self.line.setPlaceholderText(self._empty_text or example)
        if previous_notation and previous_notation != notation:
            with suppress(VomError):
                plane = parse_plane(self.line.text(), previous_notation)
                is_rounded = (plane.dip_direction_deg % 1.0, plane.dip_deg % 1.0) == (0.0, 0.0)
                self.show_plane(plane, 0 if is_rounded else 2)

    def _refresh(self) -> None:
        set_enabled(
            self.take_button,
            Finding("selection.no-plane") if self._selected_plane() is None else None,
        )

    def _selected_plane(self) -> Plane | None:
        measurement = current_measurement(self._studio)
        return None if measurement is None else measurement.plane

    def _use_selection(self) -> None:
        if (plane := self._selected_plane()) is not None:
            self.show_plane(plane)

    def _take_view(self) -> None:
        direction = None if self._view is None else self._view()
        if direction is not None:
            trend, plunge = direction
            # In a view from below, only a vertical plane can face the viewer with its upper
            # side.
            self.show_plane(Plane(wrap360(trend + 180.0), 90.0 - max(plunge, 0.0)))


def plane_text(plane: Plane) -> str:
    """Return a plane as dip direction and dip, in the form of command-line options."""
    return f"{plane.dip_direction_deg:.10g}/{plane.dip_deg:.10g}"
