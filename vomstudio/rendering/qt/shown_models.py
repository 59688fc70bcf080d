"""Models in the view, which are prepared in the background and shown incrementally."""

from __future__ import annotations

import time

import numpy as np
from PySide6.QtCore import QObject, Qt, Signal

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import POINT_BUDGET
from vomstudio.rendering.prepare.events import (
    ChunksDone,
    FieldReady,
    LocatorReady,
    ModelBounds,
    Problem,
)
from vomstudio.rendering.prepare.model_queue import ModelQueue
from vomstudio.rendering.qt.camera_moves import CameraMoves
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime
from vomstudio.rendering.qt.scene_picture import ScenePicture

MAX_HANDLING_S = 0.010
"""Maximum time spent on accepting results before the window handles other events, seconds."""


class ShownModels(QObject):
    """Models that are shown in the view.

    Attributes
    ----------
    point_budget : int
        Maximum number of points of a cloud in memory.
    work : ModelQueue
        Threads that prepare models.
    """

    stage = Signal(str, str)
    """Emits the model id and the stage reached: "shown", "complete" or "pickable"."""
    problem = Signal(object)
    """Emits a finding about content that cannot be drawn correctly."""
    chunked = Signal(str)
    """Emits the model id when all of its chunks are present and can be recoloured."""
    colored = Signal(str, object)
    """Emits the model id and the FieldReady when the colours of a field are available."""
    placed = Signal(str)
    """Emits the model id when its placement has changed."""
    removed = Signal(str)

    _events_ready = Signal()

    def __init__(
        self, lifetime: SceneLifetime, picture: ScenePicture, moves: CameraMoves, parent: QObject
    ) -> None:
        super().__init__(parent)
        self.point_budget = POINT_BUDGET
        self.work = ModelQueue(lambda: self._events_ready.emit())
        self._lifetime, self._picture, self._moves = lifetime, picture, moves
        self._stages: dict[str, set[str]] = {}
        self._models_to_frame: set[str] = set()
        self._hidden: set[str] = set()
        self._elements: dict[str, BoolArray] = {}
        self._transforms: dict[str, FloatArray] = {}
        self._events_ready.connect(self._handle_events, Qt.ConnectionType.QueuedConnection)
        picture.drawn.connect(self._report_stages)
        moves.restored.connect(self._cancel_framing)

    def close(self) -> None:
        """Stop all workers."""
        self.work.close()

    # -- adding and removing

    def add(
        self,
        model_id: str,
        data: Mesh | PointCloud,
        to_world: FloatArray,
        *,
        frame_camera: bool,
    ) -> None:
        """Show a model after its preparation in the background.

        Parameters
        ----------
        model_id : str
        data : Mesh or PointCloud
        to_world : (4, 4) float64
            Similarity transform from the file frame to the World frame.
        frame_camera : bool
            Whether to frame the model as soon as its bounds are known.
        """
        if self._lifetime.is_closed:
            return
        hidden_mask = self._elements.get(model_id)
        self.remove(model_id)
        if hidden_mask is not None:
            self._elements[model_id] = hidden_mask
        stop_event = self.work.expect(model_id)
        self._stages[model_id] = set()
        self._transforms[model_id] = np.array(to_world, np.float64)
        if frame_camera:
            self._models_to_frame.add(model_id)

        def begin() -> None:
            scene = self._lifetime.scene
            if not stop_event.is_set() and scene is not None:
                canvas = scene.canvas
                self.work.prepare(
                    model_id,
                    data,
                    texture_limit=canvas.texture_limit,
                    max_whole_side=canvas.whole_texture_side,
                    budget=self.point_budget,
                )

        self._lifetime.call_when_started(begin)

    def remove(self, model_id: str) -> None:
        """Remove a model; an unknown id is ignored."""
        self.work.clear_state(model_id)
        self._stages.pop(model_id, None)
        self._transforms.pop(model_id, None)
        self.removed.emit(model_id)
        self._models_to_frame.discard(model_id)
        self._hidden.discard(model_id)
        self._elements.pop(model_id, None)
        scene = self._lifetime.scene
        if scene is not None and model_id in scene.models:
            scene.remove_model(model_id)
            self._picture.redraw()

    def set_visible(self, model_id: str, is_visible: bool) -> None:
        (self._hidden.discard if is_visible else self._hidden.add)(model_id)
        scene = self._lifetime.scene
        if scene is not None and model_id in scene.models:
            scene.set_visible(model_id, is_visible)
            self._picture.redraw()

    def hide_elements(self, model_id: str, is_hidden: BoolArray | None) -> None:
        """Hide the marked faces or points (n,) of a model; None shows all."""
        self._elements.pop(model_id, None)
        if is_hidden is not None:
            self._elements[model_id] = is_hidden
        scene = self._lifetime.scene
        if scene is not None and model_id in scene.models:
            scene.set_hidden(model_id, is_hidden)
            self._picture.redraw()

    def set_to_world(self, model_id: str, to_world: FloatArray) -> None:
        """Change the placement of a model, for example after its registration."""
        if model_id not in self._transforms:
            return
        self._transforms[model_id] = np.array(to_world, np.float64)
        scene = self._lifetime.scene
        if scene is not None and model_id in scene.models:
            scene.set_to_world(model_id, self._transforms[model_id])
            self._picture.redraw()
            self.placed.emit(model_id)

    def to_world(self, model_id: str) -> FloatArray:
        """Return the placement (4, 4) of a model."""
        return self._transforms[model_id]

    def reached_stages(self, model_id: str) -> frozenset[str]:
        """Return the stages of display that a model has reached; see `stage`."""
        return frozenset(self._stages.get(model_id, ()))

    def _cancel_framing(self) -> None:
        """Keep a restored view; new models do not move the camera."""
        self._models_to_frame.clear()

    # -- results of the workers

    def _handle_events(self) -> None:
        """Accept results of the workers for a few milliseconds."""
        scene = self._lifetime.scene
        if scene is None:
            return
        deadline = time.perf_counter() + MAX_HANDLING_S
        is_changed = False
        while time.perf_counter() < deadline and (prepared_event := self.work.next_event()):
            model_id, event = prepared_event
            if isinstance(event, Problem):
                self.problem.emit(event.finding)
                continue
            if isinstance(event, FieldReady):
                self.colored.emit(model_id, event)
                continue
            if isinstance(event, ModelBounds):
                self._register(model_id, event)
            else:
                scene.take(model_id, event)
            if isinstance(event, ChunksDone):
                self.chunked.emit(model_id)
            if isinstance(event, LocatorReady):
                self._emit_stage(model_id, "pickable")
            else:
                is_changed = True
        if self.work.is_waiting:
            self._events_ready.emit()
        if is_changed:
            self._content_changed()

    def _register(self, model_id: str, event: ModelBounds) -> None:
        scene = self._lifetime.scene
        assert scene is not None
        to_world = self._transforms[model_id]
        model = scene.add_model(model_id, event.data, to_world, event.bounds, event.origin)
        scene.set_visible(model_id, model_id not in self._hidden)
        if model_id in self._elements:
            scene.set_hidden(model_id, self._elements[model_id])
        if model_id in self._models_to_frame:
            self._models_to_frame.discard(model_id)
            self._moves.fit(model.corners_world())
            # The camera is at rest, so new content is drawn in its final quality.
            self._picture.is_moving = False
            self._picture.schedule_rest()

    def _content_changed(self) -> None:
        scene = self._lifetime.scene
        if scene is None:
            return
        models = scene.models.values()
        is_unseen = not all("shown" in self.reached_stages(model.model_id) for model in models)
        self._picture.schedule_redraw(
            is_first=is_unseen and any(m.proxies or m.parts for m in models)
        )

    def _report_stages(self) -> None:
        scene = self._lifetime.scene
        if scene is None:
            return
        picture = scene.picture
        # A listener may remove a model.
        for model in list(scene.models.values()):
            if (model.proxies and picture.is_proxy_shown) or any(
                p.is_uploaded for p in model.parts
            ):
                self._emit_stage(model.model_id, "shown")
            if (
                picture.is_complete
                and model.has_all_chunks
                and model.has_all_textures
                and model.is_settled
            ):
                self._emit_stage(model.model_id, "complete")

    def _emit_stage(self, model_id: str, stage: str) -> None:
        reached_stages = self._stages.setdefault(model_id, set())
        if stage not in reached_stages:
            reached_stages.add(stage)
            self.stage.emit(model_id, stage)
