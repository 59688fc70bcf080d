"""Plots of models and their features with PyVista."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.plots.datasets import (
    cloud_dataset,
    dataset_blocks,
    local_origin,
    mesh_dataset,
    texture_file,
)
from vomstudio.rendering.view.first_view import first_view

if TYPE_CHECKING:
    from pyvista import Plotter as Plotter

MODEL_COLOR = "#b8b2a8"


@dataclass(frozen=True, eq=False)
class DrawnFeature:
    """Geometry and style of a feature in a plot.

    Parameters
    ----------
    line : (n, 3) float64
        Vertices in the World frame.
    ring : (c, 3) float64 or None
        Outline of the disc that shows a plane.
    anchor : (3,) float64
        Position of the label.
    color : str
        Colour as "#rrggbb".
    """

    name: str
    line: FloatArray
    ring: FloatArray | None
    anchor: FloatArray
    label: str
    color: str


def draw(
    plotter: Plotter, models: Sequence[Mesh | PointCloud], features: Sequence[DrawnFeature]
) -> Plotter:
    """Add models and features to a plotter, and view the exposed side of the first model.

    Models and features are in the World frame; a common origin is subtracted from all
    coordinates.
    """
    origin = _origin(models, features)
    for model in models:
        _add_model(plotter, model, origin)
    for feature in features:
        _add_feature(plotter, feature, origin)
    named_features = [f for f in features if f.label]
    if named_features:
        anchors = np.array([f.anchor for f in named_features]) - origin
        plotter.add_point_labels(
            anchors,
            [f.label for f in named_features],
            font_size=12,
            shape="rounded_rect",
            shape_color="white",
            shape_opacity=0.7,
            show_points=False,
            always_visible=True,
        )
    _set_camera(plotter, models)
    return plotter


def _origin(models: Sequence[Mesh | PointCloud], features: Sequence[DrawnFeature]) -> FloatArray:
    corners = [model.bounds for model in models] or [f.anchor[None] for f in features]
    if not corners:
        return np.zeros(3)
    points = np.concatenate(corners)
    return local_origin(np.array([points.min(axis=0), points.max(axis=0)]))


def _add_model(plotter: Any, model: Mesh | PointCloud, origin: FloatArray) -> None:
    import pyvista

    if isinstance(model, PointCloud):
        data = cloud_dataset(model, origin)
        colors = (
            {"scalars": "RGB", "rgb": True} if "RGB" in data.point_data else {"color": MODEL_COLOR}
        )
        plotter.add_mesh(data, style="points", point_size=2, show_scalar_bar=False, **colors)
        return
    for block in dataset_blocks(mesh_dataset(model, origin)):
        path = texture_file(block)
        if path is not None:
            texture = pyvista.read_texture(str(path))
            plotter.add_mesh(block, texture=texture, lighting=False)
        elif "RGB" in block.point_data:
            plotter.add_mesh(block, scalars="RGB", rgb=True, lighting=False)
        else:
            diffuse = block.field_data.get("diffuse", None)
            plotter.add_mesh(block, color=MODEL_COLOR if diffuse is None else diffuse)


def _add_feature(plotter: Any, feature: DrawnFeature, origin: FloatArray) -> None:
    import pyvista

    line = feature.line - origin
    if len(line) > 1:
        joined_lines = pyvista.lines_from_points(line)
        plotter.add_mesh(
            joined_lines, color=feature.color, line_width=4, name=f"{feature.name} line"
        )
    elif len(line) == 1:
        plotter.add_points(line, color=feature.color, point_size=8, name=f"{feature.name} point")
    if feature.ring is not None:
        ring = feature.ring - origin
        disc = pyvista.PolyData(ring, faces=np.concatenate([[len(ring)], np.arange(len(ring))]))
        plotter.add_mesh(disc, color=feature.color, opacity=0.5, name=f"{feature.name} plane")


def _set_camera(plotter: Any, models: Sequence[Mesh | PointCloud]) -> None:
    """View the exposed side of the first model, with the up direction upwards in the image."""
    if not models:
        plotter.reset_camera()
        return
    trend, plunge = np.radians(first_view(models[0], np.eye(4)))
    direction = [np.sin(trend) * np.cos(plunge), np.cos(trend) * np.cos(plunge), -np.sin(plunge)]
    plotter.view_vector([-v for v in direction], viewup=(0.0, 0.0, 1.0))
    plotter.reset_camera()


def off_screen_plotter() -> Plotter:
    """Return a plotter that draws off screen.

    In a notebook, `show` displays a static picture; `screenshot` returns the pixels.
    """
    import pyvista

    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        # VTK would choose the same window, but only after a warning about the missing display.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    plotter: Plotter = pyvista.Plotter(off_screen=True)
    plotter.set_background("white")  # type: ignore[arg-type]
    return plotter
