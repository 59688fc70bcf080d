"""Contents of a scene."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.scene.appearance import Appearance
from vomstudio.rendering.scene.camera_layer import CameraLayer
from vomstudio.rendering.scene.clip_planes import ClipPlanes
from vomstudio.rendering.scene.feature_layer import FeatureLayer
from vomstudio.rendering.scene.model_scene import ModelScene


@dataclass(frozen=True)
class Contents:
    """Models with their appearance and clipping, and the features and cameras over them."""

    models: dict[str, ModelScene] = field(default_factory=dict)
    look: Appearance = field(default_factory=Appearance)
    planes: ClipPlanes = field(default_factory=ClipPlanes)
    features: FeatureLayer = field(default_factory=FeatureLayer)
    cameras: CameraLayer = field(default_factory=CameraLayer)

    def visible(self) -> list[ModelScene]:
        return [model for model in self.models.values() if model.visible]

    def corners(self, *, is_closed: bool = False) -> FloatArray:
        """Return box corners (n, 3) of the visible models in the World frame.

        If `is_closed`, these are the corners of the models' chunks.
        """
        corners = [model.corners_world(is_closed=is_closed) for model in self.visible()]
        return np.concatenate([np.zeros((0, 3)), *corners])

    def overlay_corners(self) -> FloatArray:
        """Return box corners (n, 3) of the features and cameras in the World frame."""
        return np.concatenate([self.features.corners(), self.cameras.corners()])
