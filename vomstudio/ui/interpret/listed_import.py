"""Stations, contact lines and rock areas of a file, taken into the project from the menu."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.document import edits
from vomstudio.errors import VomError
from vomstudio.ui.common import file_filters
from vomstudio.ui.common.command_targets import current_model, start_folder
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr, tr_n


def choose_listed(parent: QWidget, studio: Studio) -> None:
    """Ask for a file, and take in what it holds."""
    name, _ = QFileDialog.getOpenFileName(
        parent,
        tr("Import stations, contact lines and rock areas"),
        start_folder(studio),
        file_filters.listed(),
    )
    if name:
        import_listed(studio, Path(name))


def import_listed(studio: Studio, path: Path) -> None:
    """As one edit, on the current model; what was left out is told."""
    from vomstudio.io.gis.crs import world_crs
    from vomstudio.io.project.listed_import import read_listed

    model = current_model(studio)
    if model is None:
        studio.warn(tr("Open the model first on which they lie."))
        return
    opened, surface = studio.models.get(model.id), studio.workspace.models.surface(model.id)
    try:
        found = read_listed(
            path, model, studio.records, world_crs(model.frame.crs, model.frame.unit_m),
            None if surface is None else surface.area_inside,
            None if opened is None else opened.data.bounds,
        )  # fmt: skip
    except VomError as error:
        studio.fail(error)
        return
    if not studio.attempt(edits.add_features, found.features):
        return
    studio.selection.set([feature.id for feature in found.features])
    said = [
        tr_n("Added {count} feature.", "Added {count} features.", len(found.features)),
        *found.warnings,
        *(tr("{feature} was left out: {reason}", feature=n, reason=r) for n, r in found.skipped),
    ]
    (studio.warn if found.skipped or found.warnings else studio.info)(" ".join(said))
