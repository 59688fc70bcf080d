"""What there is to be drawn."""

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
    """The models, how they look and are cut, and what is drawn over them."""

    models: dict[str, ModelScene] = field(default_factory=dict)
    look: Appearance = field(default_factory=Appearance)
    planes: ClipPlanes = field(default_factory=ClipPlanes)
    features: FeatureLayer = field(default_factory=FeatureLayer)
    cameras: CameraLayer = field(default_factory=CameraLayer)

    def visible(self) -> list[ModelScene]:
        return [model for model in self.models.values() if model.visible]

    def corners(self, *, close: bool = False) -> FloatArray:
        """(n, 3) World corners of the visible models; see `ModelScene.corners_world`."""
        some = [model.corners_world(close=close) for model in self.visible()]
        return np.concatenate([np.zeros((0, 3)), *some])

    def corners_over(self) -> FloatArray:
        """(n, 3) World corners of what is drawn over the models."""
        return np.concatenate([self.features.corners(), self.cameras.corners()])
