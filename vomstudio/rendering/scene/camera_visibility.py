"""Visibility of the scene's contents from the camera."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.rendering.scene import field_order, visible_parts
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.model_scene import ModelScene, Part
from vomstudio.rendering.view.camera import Camera, Eye


class SceneVisibility:
    """Visibility of the contents; `eye` is the view last applied to the canvas, or None."""

    def __init__(self, camera: Camera, canvas: Canvas, scene_contents: Contents) -> None:
        self.camera = camera
        self.eye: Eye | None = None
        self._canvas, self._contents = canvas, scene_contents

    def apply(self, camera: Camera | None = None) -> Eye:
        """Apply the scene's camera, or the given one, to the canvas."""
        camera = self.camera if camera is None else camera
        corners = np.concatenate([self._contents.corners(), self._contents.overlay_corners()])
        self.eye = eye = camera.eye(corners)
        self._canvas.look(eye, camera.distance, camera.view_angle_deg)
        field_order.push_back_others(self._contents.visible(), self._contents.look, eye)
        return eye

    def parts(self, *, include_all_nodes: bool = False) -> list[tuple[ModelScene, Part]]:
        """Return the parts of the models in view, nearest first; see `parts_in_view`."""
        assert self.eye is not None
        models, planes = self._contents.models.values(), self._contents.planes
        return visible_parts.parts_in_view(
            models, self.eye, self._canvas.size, planes.box, include_all_nodes=include_all_nodes
        )

    def set_point_sizes(self) -> None:
        """Set the point sizes of all clouds in view."""
        for model, part in self.parts():
            if part.spacing > 0.0 and isinstance(model.data, PointCloud):
                self.set_part_point_size(model, part)

    def set_part_point_size(self, model: ModelScene, part: Part) -> None:
        assert self.eye is not None
        style, height = self._contents.look, self._canvas.size[1]
        visible_parts.set_point_sizes(model, part, self.eye, self.camera, height, style)

    def texels_per_pixel(self) -> dict[int, float]:
        """Return the texels per pixel for each texture in view, keyed by its `id`."""
        assert self.eye is not None
        return visible_parts.texels_per_pixel(
            self.parts(), self.eye, self.camera, self._canvas.size[1]
        )

    def pixel_at(self, position: FloatArray) -> float:
        """Return the metres per device pixel at a point in the World frame."""
        depth = float((position - self.camera.position) @ self.camera.direction)
        return self.camera.metres_per_pixel(self._canvas.size[1], max(depth, 1e-6))

    def pixel_sizes(self, points: FloatArray) -> FloatArray:
        """Return the metres per device pixel (n,) at points (n, 3) in the World frame."""
        camera, height = self.camera, self._canvas.size[1]
        if camera.orthographic:
            return np.full(len(points), camera.metres_per_pixel(height))
        depth = np.abs((points - camera.position) @ camera.direction)
        return np.asarray(np.maximum(depth, 1e-6) * camera.metres_per_pixel(height, 1.0))

    def is_in_front(self, points: FloatArray, depth_tolerance: float = 0.0) -> BoolArray:
        """Return whether points (n, 3) are in the picture and not behind its surface.

        Parameters
        ----------
        points : (n, 3) ndarray
            Points in the World frame.
        depth_tolerance : float
            Tolerated distance behind the surface, metres.
        """
        width, height = self._canvas.size
        pixels, depth = self.camera.project(points, (width, height))
        is_visible_pixel = np.isfinite(pixels).all(axis=1) & (depth > 0.0)
        x, y = (
            np.where(is_visible_pixel, pixels[:, 0], 0.0),
            np.where(is_visible_pixel, pixels[:, 1], 0.0),
        )
        is_visible_pixel &= (x >= 0) & (x < width) & (y >= 0) & (y < height)
        if self.eye is None or not is_visible_pixel.any():
            return np.asarray(is_visible_pixel, np.bool_)
        column = np.clip(x.astype(int), 0, width - 1)
        row = np.clip(height - 1 - y.astype(int), 0, height - 1)
        buffer = self._canvas.depth()[row, column].astype(np.float64)
        surface = self.eye.depth_from_buffer(buffer)
        depth_of_points = self.eye.depth(np.asarray(points, float).reshape(-1, 3))
        tolerance = 0.004 * np.abs(surface) + depth_tolerance
        return np.asarray(
            is_visible_pixel & ((buffer >= 1.0) | (depth_of_points <= surface + tolerance)),
            np.bool_,
        )
