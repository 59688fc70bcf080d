"""Command that opens the dialog for an orthophoto."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_to_screen
from vomstudio.ui.outcrop.outcrop_view import OutcropView
from vomstudio.ui.panels.view.view_panel import ViewPanel


def commands(
    studio: Studio, view: OutcropView, directions: ViewPanel, parent: QWidget
) -> list[Command]:
    """Create the orthophoto command."""

    def open_dialog() -> None:
        from vomstudio.ui.dialogs.orthophoto_dialog import OrthoDialog

        if view.viewport is not None:
            dialog = OrthoDialog(parent, studio, view.viewport, directions)
            fit_to_screen(dialog)
            dialog.open()

    return [
        Command(
            "orthophoto",
            tr("&Orthophoto…"),
            open_dialog,
            icon="camera-metering-matrix",
            shortcut="Ctrl+P",
            tip=tr("Make a true-to-scale picture along the current view, as GeoTIFF."),
            disabled_reason=view.disabled_reason,
        ),
    ]
