"""Stations, contact lines and rock areas of a file, taken into the project from the menu."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import current_model, start_folder
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.project.imports.feature_lists import ImportedFeatures


class ListedImport(QObject):
    """The file is read in a thread; what it holds comes as one edit."""

    def __init__(self, parent: QWidget, studio: Studio) -> None:
        super().__init__(parent)
        self._parent, self._studio = parent, studio
        self._background = QtBackground(self)

    def choose(self) -> None:
        """Ask for a file, and take in what it holds."""
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("Import stations, contact lines and rock areas"),
            start_folder(self._studio),
            file_filters.layers_and_tables(),
        )
        if name:
            self.take_in(Path(name))

    def take_in(self, path: Path) -> None:
        """On the current model; what was left out is told."""
        studio = self._studio
        model = current_model(studio)
        if model is None:
            studio.warn(Finding("action.no-model"))
            return
        shown, records = model, dict(studio.records)
        opened, surface = studio.models.get(model.id), studio.workspace.models.surface(model.id)
        bounds = None if opened is None else opened.data.bounds

        def work() -> ImportedFeatures:
            from vomstudio.io.gis.crs import world_crs
            from vomstudio.project.imports.feature_lists import read_listed_features

            return read_listed_features(
                path,
                shown,
                records,
                world_crs(shown.frame.crs, shown.frame.unit_m),
                None if surface is None else surface.area_inside,
                bounds,
            )

        studio.info(Finding("file.reading", file=path.name))
        self._background.run(work, lambda found: self._arrived(shown, found), studio.fail)

    def _arrived(self, model: Model, found: ImportedFeatures) -> None:
        studio = self._studio
        now = studio.records.get(model.id)
        if not isinstance(now, Model) or now.to_world != model.to_world:
            studio.warn(Finding("model.moved"))
            return
        if not studio.attempt(edits.add_features, found.features):
            return
        studio.selection.set([feature.id for feature in found.features])
        studio.info(Finding("features.added", count=len(found.features)))
        for warning in found.warnings:
            studio.warn(warning, warning.severity)
        for name, reason in found.skipped:
            studio.warn(Finding("feature.left-out", feature=name, reason=reason))
