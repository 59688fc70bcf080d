"""Which nodes of clouds the view needs, and whether they are there."""

from __future__ import annotations

import time

from vomstudio.rendering.prepare.streaming import view_of
from vomstudio.rendering.scene.camera_visibility import Sight
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents

PATIENCE_S = 0.4
"""Nodes that come within this time after they were asked for are drawn in one frame."""


class NodesInView:
    """Of all the clouds of a scene."""

    def __init__(self, canvas: Canvas, contents: Contents, sight: Sight) -> None:
        self._canvas, self._contents, self._sight = canvas, contents, sight
        self._asked = 0.0

    def look_around(self, *, fetch: bool = True) -> None:
        """Find out which nodes the view needs, and have those fetched that are not there. Until
        they are, those above them close the surface."""
        eye, camera = self._sight.eye, self._sight.camera
        if eye is None:
            return
        for model in self._contents.visible():
            streamer = model.streamer
            if streamer is None:
                continue
            view = view_of(eye, camera, self._canvas.size, model.to_world, model.from_world)
            needed = streamer.look(view) if fetch else streamer.needed(view)
            there = {part.row for part in model.parts}
            if needed is None:
                needed = model.needed
            elif fetch:
                model.needed = needed
                model.settled = there.issuperset(needed)
                self._asked = time.perf_counter()
            model.shown_rows = needed
            if not there.issuperset(needed):
                model.shown_rows = needed | streamer.closing([r for r in needed if r in there])

    @property
    def settled(self) -> bool:
        """Whether the nodes are there that the view needs."""
        return all(model.settled for model in self._contents.visible())

    @property
    def waits(self) -> bool:
        """Whether so much is on its way that a frame had better wait for it."""
        return not self.settled and time.perf_counter() - self._asked < PATIENCE_S
