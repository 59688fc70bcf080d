"""Depth order of models of the same rock if one of them shows a field.

Otherwise, the colours of a comparison would flicker wherever the benchmark model is at the same
position, and would be hidden wherever it is in front.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene.appearance import Appearance
from vomstudio.rendering.scene.model_scene import ModelScene
from vomstudio.rendering.view.camera import Eye

MIN_SHARE, MAX_SHARE = 0.001, 0.05
"""Limits of the distance by which models are pushed back, as shares of the extent of the model
that shows a field."""


def push_back_others(visible: Sequence[ModelScene], style: Appearance, eye: Eye) -> None:
    """Draw models without a field behind those that show a field.

    Features keep their depth, so they remain in front of both.

    Parameters
    ----------
    visible : sequence of ModelScene
    style : Appearance
    eye : Eye
        View in which the models will be drawn.
    """
    shift_m = max((_shift_m(m) for m in visible if style.shows_field(m)), default=0.0)
    for model in visible:
        offset = 0.0 if style.shows_field(model) else _offset(model, eye, shift_m)
        for part in model.parts + model.proxies:
            if part.offset != offset:
                part.offset = offset
                vtk_data.push_back(part.actor, offset)


def _shift_m(model: ModelScene) -> float:
    """Return the distance by which other models are moved back behind a model with a field.

    This is the largest distance in the colours of a comparison, within limits that depend on the
    extent of the model.
    """
    assert model.field is not None
    scale = model.field.scale
    extent = float(np.linalg.norm(np.ptp(model.corners_world(), axis=0)))
    is_distance = scale.kind == "diverging" and scale.unit == "m"
    max_value = max(abs(scale.low), abs(scale.high)) if is_distance else 0.0
    return min(max(max_value, MIN_SHARE * extent), MAX_SHARE * extent)


def _offset(model: ModelScene, eye: Eye, shift_m: float) -> float:
    """Return the difference of depth-buffer values that is at least `shift_m` within a model."""
    if shift_m == 0.0:
        return 0.0
    nearest_depth = max(float(eye.depth(model.corners_world()).min()), eye.near)
    return eye.buffer_from_depth(nearest_depth + shift_m) - eye.buffer_from_depth(nearest_depth)
