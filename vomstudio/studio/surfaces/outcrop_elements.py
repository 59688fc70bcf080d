"""Faces and points of the open models, and the view onto them."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from functools import partial

from vomstudio.core.arrays import BoolArray
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.signals import Signal
from vomstudio.extraction.selection.neighbours import NeighbourGraph, build_neighbour_graph
from vomstudio.extraction.selection.visible_region import ViewSnapshot, element_count
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

VIEW_KEY = "hidden_elements"
_NEIGHBOURS_KEY = "neighbours"


class ModelElements:
    """Implementation of `studio.tools.outcrop_elements` for the open models.

    Attributes
    ----------
    look : callable
        Returns the current view of the viewport.
    """

    def __init__(
        self,
        projects: Projects,
        models: Models,
        visibility: Visibility,
        background: Background,
        cutting: ModelCutting,
    ) -> None:
        self.look: Callable[[], ViewSnapshot | None] = lambda: None
        self.hidden_changed: Signal[str] = Signal()
        self._projects, self._models, self._visibility = projects, models, visibility
        self._background, self._model_cutting = background, cutting
        self._hidden: dict[str, BoolArray] = {}
        self._neighbours: tuple[OpenModel, NeighbourGraph | Finding] | None = None
        self._pending_request: tuple[OpenModel, list[Callable[[], None]]] | None = None

    def view_snapshot(self) -> ViewSnapshot | None:
        return self.look()

    def shown(self) -> list[str]:
        visible = self._visibility.visible
        if not visible("models"):
            return []
        ids = [model.id for model in self._projects.of(Model)]
        return [id_ for id_ in ids if id_ in self._models.open_models and visible(id_)]

    def data(self, model_id: str) -> Mesh | PointCloud | None:
        open_model = self._models.open_models.get(model_id)
        return None if open_model is None else open_model.data

    def spacing(self, model_id: str) -> float:
        open_model = self._models.open_models.get(model_id)
        return 0.0 if open_model is None else open_model.resolution or 0.0

    # --- neighbours ---------------------------------------------------------------------------
    def neighbours(
        self, model_id: str, finished_callback: Callable[[], None]
    ) -> NeighbourGraph | Finding | None:
        open_model = self._models.open_models.get(model_id)
        if open_model is None:
            return Finding("model.not-open", model=model_id)
        if self._neighbours is not None and self._neighbours[0] is open_model:
            return self._neighbours[1]
        if self._pending_request is not None and self._pending_request[0] is open_model:
            if finished_callback not in self._pending_request[1]:
                self._pending_request[1].append(finished_callback)
        else:
            self._pending_request = (open_model, [finished_callback])
            self._background.run(
                lambda: build_neighbour_graph(open_model.data, open_model.resolution or 0.0),
                partial(self._store, open_model),
                lambda error: self._store(open_model, to_finding(error)),
                key=_NEIGHBOURS_KEY,
            )
        return None

    def _store(self, opened_model: OpenModel, result: NeighbourGraph | Finding) -> None:
        pending_request, self._pending_request = self._pending_request, None
        if any(item is opened_model for item in self._models.open_models.values()):
            self._neighbours = (opened_model, result)
            for callback in () if pending_request is None else pending_request[1]:
                callback()

    # --- hidden elements ----------------------------------------------------------------------
    def hidden(self, model_id: str) -> BoolArray | None:
        return self._hidden.get(model_id)

    def hide(self, model_id: str, is_hidden: BoolArray | None) -> None:
        if is_hidden is None or not is_hidden.any():
            if self._hidden.pop(model_id, None) is None:
                return
        else:
            self._hidden[model_id] = is_hidden
        encoded_masks = {id_: mask_to_dict(mask) for id_, mask in self._hidden.items()}
        self._projects.store_view(
            VIEW_KEY, {id_: item for id_, item in encoded_masks.items() if item}
        )
        self.hidden_changed.emit(model_id)

    def get_hidden_masks(self) -> dict[str, BoolArray]:
        """Return the masks of hidden elements, keyed by model id."""
        return dict(self._hidden)

    def hide_all(self, hidden_masks: Mapping[str, BoolArray]) -> None:
        """Hide exactly the marked elements of open models with an unchanged element count."""
        for model_id in {*self._hidden, *hidden_masks}:
            mask, data = hidden_masks.get(model_id), self.data(model_id)
            current = self._hidden.get(model_id)
            if (
                mask is current
                or data is None
                or (mask is not None and len(mask) != element_count(data))
            ):
                continue
            self.hide(model_id, mask)

    def load(self) -> None:
        """Read the hidden elements of the open project, without a signal."""
        self._hidden.clear()
        stored_view = self._projects.view(VIEW_KEY, {})
        for id_, encoded_mask in stored_view.items() if isinstance(stored_view, Mapping) else ():
            with contextlib.suppress(KeyError, TypeError, ValueError):
                self._hidden[str(id_)] = mask_from_dict(encoded_mask)

    def loaded(self, model_id: str) -> None:
        """Apply the hidden elements to a loaded model, or discard them if its size has changed."""
        hidden_elements, data = self._hidden.get(model_id), self.data(model_id)
        if hidden_elements is None or data is None:
            return
        if len(hidden_elements) != element_count(data):
            # The user has selected a different file for the model.
            del self._hidden[model_id]
        else:
            self.hidden_changed.emit(model_id)

    # --- cutting ------------------------------------------------------------------------------
    def cut_out(self, model_id: str, mask: BoolArray) -> None:
        self._model_cutting.cut(model_id, mask)

    def clear_state(self) -> None:
        """Reset because another project is opened."""
        self._hidden.clear()
        self._background.cancel(_NEIGHBOURS_KEY)
        self._neighbours = self._pending_request = None
