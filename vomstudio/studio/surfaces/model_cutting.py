"""Creation of new models from parts of models, which do not change."""

from __future__ import annotations

import tempfile
from itertools import count
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.project.records import Model, get
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.model_tasks import CUT_MODEL, CutModel, ModelCut
from vomstudio.studio.models import Models
from vomstudio.studio.notices import Notices
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs


class ModelCutting:
    """Action that cuts parts out of models and adds them to the project as new models."""

    def __init__(self, projects: Projects, models: Models, jobs: Jobs, notices: Notices) -> None:
        self._projects, self._models = projects, models
        self._jobs, self._notices = jobs, notices

    def cut(self, model_id: str, mask: BoolArray) -> None:
        """Create a model of selected faces or points (n,), with textures, colours and fields.

        The new model is stored in the project folder and has the placement of the original.
        """
        model = get(self._projects.records, model_id, Model)
        open_model = self._models.open_models.get(model_id)
        project = self._projects.project
        path = None if model is None else project.find_model(model)
        if model is None or open_model is None or path is None:
            self._notices.warn(Finding("model.not-open"))
            return
        if isinstance(open_model.data, StreamedCloud):
            self._notices.warn(Finding("model.cloud-too-large", model=model.name))
            return
        used_names = {item.name for item in self._projects.of(Model)}
        names = (tr("{model} piece {number}", model=model.name, number=k) for k in count(1))
        name = next(item for item in names if item not in used_names)
        with tempfile.NamedTemporaryFile(prefix="vomstudio-", suffix=".npy", delete=False) as file:
            np.save(file, np.packbits(mask))
        mask_file = Path(file.name)
        folder = project.folder / "models"
        order = ModelCut(
            path,
            project.cache,
            model.content_hash,
            mask_file,
            open_model.crs,
            folder,
            name,
            model.registration,
        )

        def handle_result(cut_model: CutModel) -> None:
            mask_file.unlink(missing_ok=True)
            if self._projects.project is not project:
                return
            for warning in cut_model.warnings:
                self._notices.warn(warning)
            label = f"Cut {name} out of {model.name}"
            self._models.open_model(cut_model.path, name, reference_id=model_id, label=label)

        self._jobs.submit(
            CUT_MODEL,
            order,
            title=tr("Cutting out {name}", name=name),
            on_done=handle_result,
            on_failed=lambda event: self._handle_failure(mask_file, event),
        )

    def _handle_failure(self, mask_file: Path, event: Failed) -> None:
        mask_file.unlink(missing_ok=True)
        if not event.cancelled:
            self._notices.warn(event.to_error(), "error")
