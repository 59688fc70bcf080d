"""The faces and points of the open models, and how they are looked at."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.document.records import Model
from vomstudio.extraction.selecting.looking import Looking
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.workspace.models import Models
from vomstudio.workspace.projects import Projects
from vomstudio.workspace.visibility import Visibility


class OutcropElements:
    """As `tools.outcrop_elements` has it. look : tells what is seen; the viewport's, once there is
    one"""

    def __init__(self, projects: Projects, models: Models, visibility: Visibility) -> None:
        self.look: Callable[[], Looking | None] = lambda: None
        self._projects, self._models, self._visibility = projects, models, visibility

    def looking(self) -> Looking | None:
        return self.look()

    def shown(self) -> list[str]:
        visible = self._visibility.visible
        if not visible("models"):
            return []
        ids = [model.id for model in self._projects.of(Model)]
        return [id_ for id_ in ids if id_ in self._models.open and visible(id_)]

    def data(self, model_id: str) -> Mesh | PointCloud | None:
        opened = self._models.open.get(model_id)
        return None if opened is None else opened.data

    def spacing(self, model_id: str) -> float:
        opened = self._models.open.get(model_id)
        return 0.0 if opened is None else opened.resolution or 0.0
