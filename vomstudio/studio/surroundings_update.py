"""Update of features whose surroundings were measured by an earlier version's rule."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.geometry.surface import Surface
from vomstudio.project import edits
from vomstudio.project.records import Model, SurfaceFeature
from vomstudio.studio.background import Background
from vomstudio.studio.editing import Editing
from vomstudio.studio.models import Models
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects
from vomstudio.studio.tools.local_surface import (
    find_outdated_features,
    find_outdated_model,
    remeasure,
)


class SurroundingsUpdate:
    """Update that remeasures the surroundings of features on open models in one edit."""

    def __init__(
        self,
        projects: Projects,
        models: Models,
        editing: Editing,
        notices: Notices,
        background: Background,
    ) -> None:
        self._projects, self._models, self._editing = projects, models, editing
        self._notices, self._background = notices, background
        self._offered_folder = ""

    def disabled_reason(self) -> Finding | None:
        """Return why no feature can be updated, or None if one can."""
        if self._background.is_busy:
            return Finding("surroundings.running")
        # Called after every gesture, for thousands of features on a few models.
        models = self._projects.records.count_by(find_outdated_model)
        if not models:
            return Finding("surroundings.up-to-date")
        hashes = self._hashes()
        if not any(hashes.get(id_) == hash_ for id_, hash_ in models):
            return Finding("surroundings.models-closed")
        return None

    def offer_update(self, model_id: str) -> None:
        """Report once per project that features on this model can be updated."""
        folder = str(self._projects.project.folder)
        count = sum(feature.model_id == model_id for feature in self._updatable_features())
        if not count or self._offered_folder == folder:
            return
        self._offered_folder = folder
        self._notices.info(Finding("surroundings.earlier-rule", count=count))

    def update(self) -> None:
        """Remeasure all outdated features in a thread, and apply the edit at the end."""
        if self.disabled_reason() is not None:
            return
        features = list(self._updatable_features())
        surfaces = {f.model_id: self._models.surface(f.model_id) for f in features}
        measured_fields: dict[str, dict[str, Any]] = {}

        def fail(error: VomError) -> None:
            self._notices.fail(error)
            self._finish(features, measured_fields)

        self._background.run(
            lambda: _measure(features, surfaces, measured_fields),
            lambda _: self._finish(features, measured_fields),
            fail,
        )

    def _outdated_features(self) -> list[SurfaceFeature]:
        return self._projects.records.cached(find_outdated_features)

    def _hashes(self) -> dict[str, str]:
        """Return the content hashes of the open models, keyed by id."""
        return {
            model.id: model.content_hash
            for model in self._projects.records.of(Model)
            if self._models.surface(model.id) is not None
        }

    def _updatable_features(self) -> Iterator[SurfaceFeature]:
        hashes = self._hashes()
        return (f for f in self._outdated_features() if hashes.get(f.model_id) == f.model_hash)

    def _finish(
        self, features: list[SurfaceFeature], measured_fields: Mapping[str, dict[str, Any]]
    ) -> None:
        records = self._projects.records
        # Features that were changed meanwhile already follow the present rule.
        unchanged = {
            f.id: measured_fields[f.id]
            for f in features
            if f.id in measured_fields and records.get(f.id) is f
        }
        if not unchanged or not self._editing.attempt(edits.update_surroundings, unchanged):
            return
        remaining_count = len(self._outdated_features())
        self._notices.info(Finding("surroundings.updated", count=len(unchanged)))
        if remaining_count:
            self._notices.warn(Finding("surroundings.left-out", count=remaining_count))


def _measure(
    features: list[SurfaceFeature],
    surfaces: Mapping[str, Surface | None],
    measured_fields: dict[str, dict[str, Any]],
) -> None:
    for feature in features:
        surface = surfaces[feature.model_id]
        if surface is not None:
            measured_fields[feature.id] = remeasure(surface, feature)
