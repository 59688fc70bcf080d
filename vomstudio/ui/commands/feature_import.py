"""Import of features from a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.studio.tools.local_surface import surroundings_function
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import current_model, start_folder
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.project.imports.feature_lists import ImportedFeatures


class FeatureListImport(QObject):
    """Import of the features in a file in one edit; the file is read in a worker thread."""

    def __init__(self, parent: QWidget, studio: Studio) -> None:
        super().__init__(parent)
        self._parent, self._studio = parent, studio
        self._background = QtBackground(self)

    def choose_file(self) -> None:
        """Ask for a file and import its features."""
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("Import features"),
            start_folder(self._studio),
            file_filters.layers_and_tables(),
        )
        if name:
            self.import_file(Path(name))

    def import_file(self, path: Path) -> None:
        """Import features into the current model and report the features that were skipped."""
        studio = self._studio
        model = current_model(studio)
        if model is None:
            studio.warn(Finding("action.no-model"))
            return
        target, records = model, dict(studio.records)
        open_model, surface = studio.models.get(model.id), studio.workspace.models.surface(model.id)
        bounds = None if open_model is None else open_model.data.bounds

        def read_features() -> ImportedFeatures:
            from vomstudio.io.gis.crs import world_crs
            from vomstudio.project.imports.feature_lists import read_listed_features

            return read_listed_features(
                path,
                target,
                records,
                world_crs(target.frame.crs, target.frame.unit_m),
                None if surface is None else surface.area_inside,
                bounds,
                surroundings=surroundings_function(surface),
            )

        studio.info(Finding("file.reading", file=path.name))
        self._background.run(
            read_features, lambda result: self._add_features(target, result), studio.fail
        )

    def _add_features(self, model: Model, imported_features: ImportedFeatures) -> None:
        studio = self._studio
        current_record = studio.records.get(model.id)
        if not isinstance(current_record, Model) or current_record.to_world != model.to_world:
            studio.warn(Finding("model.moved"))
            return
        if not studio.attempt(edits.add_features, imported_features.features):
            return
        studio.selection.set([feature.id for feature in imported_features.features])
        studio.info(Finding("features.added", count=len(imported_features.features)))
        for warning in imported_features.warnings:
            studio.warn(warning, warning.severity)
        for name, reason in imported_features.skipped:
            studio.warn(Finding("feature.left-out", feature=name, reason=reason))
