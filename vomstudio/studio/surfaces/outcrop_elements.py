"""The faces and points of the open models, and how they are looked at."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from functools import partial

from vomstudio.core.arrays import BoolArray
from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.signals import Signal
from vomstudio.extraction.selection.neighbours import Neighbours, neighbours_of
from vomstudio.extraction.selection.visible_region import Looking, count_of
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.project.records import Model
from vomstudio.studio.background import Background
from vomstudio.studio.model_loading import OpenModel
from vomstudio.studio.models import Models
from vomstudio.studio.projects import Projects
from vomstudio.studio.surfaces.model_cutting import ModelCutting
from vomstudio.studio.tools.element_selection import mask_from_dict, mask_to_dict
from vomstudio.studio.visibility import Visibility

_KEPT = "hidden_elements"
_NEIGHBOURS = "neighbours"


class OutcropElements:
    """Faces and points of the models for the tools (`studio.tools.outcrop_elements`).

    Parameters
    ----------
    look : callable
        Returns what is visible; that of the viewport, once there is one.
    """

    def __init__(
        self,
        projects: Projects,
        models: Models,
        visibility: Visibility,
        background: Background,
        cutting: ModelCutting,
    ) -> None:
        self.look: Callable[[], Looking | None] = lambda: None
        self.hidden_changed: Signal[str] = Signal()
        self._projects, self._models, self._visibility = projects, models, visibility
        self._background, self._cutting = background, cutting
        self._hidden: dict[str, BoolArray] = {}
        self._known: tuple[OpenModel, Neighbours | Finding] | None = None
        self._pending: tuple[OpenModel, Callable[[], None]] | None = None

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

    # --- neighbours ---------------------------------------------------------------------------
    def neighbours(self, model_id: str, then: Callable[[], None]) -> Neighbours | Finding | None:
        opened = self._models.open.get(model_id)
        if opened is None:
            return Finding("model.not-open", model=model_id)
        if self._known is not None and self._known[0] is opened:
            return self._known[1]
        pending, self._pending = self._pending, (opened, then)
        if pending is None or pending[0] is not opened:
            self._background.run(
                lambda: neighbours_of(opened.data, opened.resolution or 0.0),
                partial(self._store, opened),
                lambda error: self._store(opened, finding_of(error)),
                key=_NEIGHBOURS,
            )
        return None

    def _store(self, opened: OpenModel, result: Neighbours | Finding) -> None:
        pending, self._pending = self._pending, None
        if any(each is opened for each in self._models.open.values()):
            self._known = (opened, result)
            if pending is not None:
                pending[1]()

    # --- what is hidden -----------------------------------------------------------------------
    def hidden(self, model_id: str) -> BoolArray | None:
        return self._hidden.get(model_id)

    def hide(self, model_id: str, hidden: BoolArray | None) -> None:
        if hidden is None or not hidden.any():
            if self._hidden.pop(model_id, None) is None:
                return
        else:
            self._hidden[model_id] = hidden
        words = {id_: mask_to_dict(mask) for id_, mask in self._hidden.items()}
        self._projects.keep_view(_KEPT, {id_: each for id_, each in words.items() if each})
        self.hidden_changed.emit(model_id)

    def all_hidden(self) -> dict[str, BoolArray]:
        """What is hidden of each model of which anything is."""
        return dict(self._hidden)

    def hide_all(self, hidden: Mapping[str, BoolArray]) -> None:
        """Hide this and nothing else; of models that are open and still have so many elements."""
        for model_id in {*self._hidden, *hidden}:
            mask, data = hidden.get(model_id), self.data(model_id)
            now = self._hidden.get(model_id)
            if mask is now or data is None or (mask is not None and len(mask) != count_of(data)):
                continue
            self.hide(model_id, mask)

    def load(self) -> None:
        """Read what of the open project's models is hidden, without a signal."""
        self._hidden.clear()
        kept = self._projects.view(_KEPT, {})
        for id_, words in kept.items() if isinstance(kept, Mapping) else ():
            with contextlib.suppress(KeyError, TypeError, ValueError):
                self._hidden[str(id_)] = mask_from_dict(words)

    def loaded(self, model_id: str) -> None:
        """A model is there: it is shown without what is hidden of it."""
        hidden, data = self._hidden.get(model_id), self.data(model_id)
        if hidden is None or data is None:
            return
        if len(hidden) != count_of(data):
            # The file that was chosen for it is another one.
            del self._hidden[model_id]
        else:
            self.hidden_changed.emit(model_id)

    # --- cutting out --------------------------------------------------------------------------
    def cut_out(self, model_id: str, mask: BoolArray) -> None:
        self._cutting.cut(model_id, mask)

    def forget(self) -> None:
        """Another project is opened."""
        self._hidden.clear()
        self._background.cancel(_NEIGHBOURS)
        self._known = self._pending = None
