"""Commands that analyse the surface of a patch and extend a plane through its model."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.kinds import has_plane
from vomstudio.project.records import Feature, ModelFeature, PaintedFeature
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_to_screen


def selected_patch(studio: Studio) -> PaintedFeature | None:
    """Return the selected feature if it is a patch and the only one selected, else None."""
    ids = studio.selection.ids
    record = studio.records.get(ids[0]) if len(ids) == 1 else None
    return record if isinstance(record, PaintedFeature) else None


def selected_plane(studio: Studio) -> Feature | None:
    """Return the selected feature if it has a plane and is the only one, else None."""
    ids = studio.selection.ids
    record = studio.records.get(ids[0]) if len(ids) == 1 else None
    return record if isinstance(record, Feature) and has_plane(record) else None


def commands(studio: Studio, parent: QWidget) -> list[Command]:
    """Create the commands for the selected patch or plane."""

    def patch_problem() -> Finding | None:
        patch = selected_patch(studio)
        if patch is None:
            return Finding("selection.no-patch")
        if studio.models.get(patch.model_id) is None:
            return Finding("model.not-open")
        return None

    def plane_problem() -> Finding | None:
        plane = selected_plane(studio)
        if plane is None:
            return Finding("selection.no-plane")
        if not isinstance(plane, ModelFeature) or studio.models.get(plane.model_id) is None:
            return Finding("plane.model-not-open")
        if studio.measure(plane).fit is None:
            return studio.measure(plane).problem or Finding("field.no-plane")
        return None

    def show_surface() -> None:
        from vomstudio.ui.dialogs.surface_dialog import SurfaceDialog

        patch = selected_patch(studio)
        if patch is not None:
            dialog = SurfaceDialog(parent, studio, patch)
            fit_to_screen(dialog)
            dialog.show()

    def show_extension() -> None:
        from vomstudio.ui.dialogs.extended_plane_dialog import ExtendDialog

        plane = selected_plane(studio)
        if plane is not None:
            dialog = ExtendDialog(parent, studio, plane)
            fit_to_screen(dialog)
            dialog.show()

    return [
        Command(
            "patch_surface",
            tr("Patch &surface…"),
            show_surface,
            icon="waves",
            tip=tr("Analyse the roughness of the selected patch and deviations from its plane."),
            disabled_reason=patch_problem,
        ),
        Command(
            "extend_plane",
            tr("E&xtend plane…"),
            show_extension,
            icon="arrow-expand-horizontal",
            tip=tr("Extend the selected plane through its model, with its error band."),
            disabled_reason=plane_problem,
        ),
    ]
