"""Commands that fit or compare two models of the same rock."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import closed_model_finding, current_model
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks, WorkspaceSwitcher


def commands(
    studio: Studio,
    dialogs: OpenDialogs,
    workspaces: WorkspaceSwitcher,
    docks: Docks,
    parent: QWidget,
) -> list[Command]:
    """Create the commands that fit and compare models."""

    def fit() -> None:
        from vomstudio.ui.dialogs.model_fit.fit_dialog import FitDialog

        model = current_model(studio)
        if model is not None:
            dialogs.show(FitDialog, lambda: FitDialog(parent, studio, model), model.id)

    def compare() -> None:
        workspaces.switch("model")
        docks.bring_forward("compare")

    return [
        Command(
            "fit_model",
            tr("Fit to &model…"),
            fit,
            icon="vector-combine",
            tip=tr("Register the model by fitting it to another model."),
            disabled_reason=lambda: closed_model_finding(studio),
        ),
        Command(
            "compare_models",
            tr("Compare with &benchmark…"),
            compare,
            icon="compare-horizontal",
            tip=tr("Compute signed distances from a more accurate model, with their significance."),
            disabled_reason=lambda: closed_model_finding(studio),
        ),
    ]
