"""Nodes of clouds that are required for the view."""

from __future__ import annotations

import time

from vomstudio.rendering.prepare.streaming import cloud_view
from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents

MAX_NODE_DELAY_S = 0.4
"""Maximum time after a request for which nodes are collected to be drawn in one frame."""


class VisibleNodes:
    """Visible nodes of all clouds in a scene."""

    def __init__(
        self, canvas: Canvas, scene_contents: Contents, visibility: SceneVisibility
    ) -> None:
        self._canvas, self._contents, self._visibility = canvas, scene_contents, visibility
        self._requested_at_s = 0.0

    def update_nodes(self, *, fetches_nodes: bool = True) -> None:
        """Determine the required nodes of the view.

        Missing nodes are requested if `fetches_nodes` is True. Until they arrive, the points of
        their parent nodes are enlarged to close the gaps.
        """
        eye, camera = self._visibility.eye, self._visibility.camera
        if eye is None:
            return
        for model in self._contents.visible():
            streamer = model.streamer
            if streamer is None:
                continue
            view = cloud_view(eye, camera, self._canvas.size, model.to_world, model.from_world)
            needed_nodes = streamer.look(view) if fetches_nodes else streamer.needed_nodes(view)
            present_rows = {part.row for part in model.parts}
            if needed_nodes is None:
                needed_nodes = model.needed_nodes
            elif fetches_nodes:
                model.needed_nodes = needed_nodes
                model.is_settled = present_rows.issuperset(needed_nodes)
                self._requested_at_s = time.perf_counter()
            model.shown_rows = needed_nodes
            if not present_rows.issuperset(needed_nodes):
                model.shown_rows = needed_nodes | streamer.closing(
                    [r for r in needed_nodes if r in present_rows]
                )

    @property
    def is_settled(self) -> bool:
        """Whether all required nodes are present."""
        return all(model.is_settled for model in self._contents.visible())

    @property
    def is_waiting(self) -> bool:
        """Whether the next frame should be delayed because many nodes are about to arrive."""
        return not self.is_settled and time.perf_counter() - self._requested_at_s < MAX_NODE_DELAY_S
