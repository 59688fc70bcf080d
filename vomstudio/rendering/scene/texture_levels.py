"""Texture levels on the graphics card, selected according to the view."""

from __future__ import annotations

from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.model_scene import ModelScene


class TextureLevels:
    """Texture levels of all models of a scene."""

    def __init__(self, canvas: Canvas, contents: Contents, visibility: SceneVisibility) -> None:
        self._canvas, self._contents, self._sight = canvas, contents, visibility

    @property
    def due(self) -> bool:
        """Whether a finer texture than the uploaded one is required."""
        return any(skin.too_coarse for m in self._textured() for skin in m.skins.values())

    def choose(self) -> None:
        """Choose the coarsest levels that have about one texel per pixel."""
        software = self._canvas.software
        needed_levels = self._sight.texels_per_pixel() if software else {}
        for model in self._contents.models.values():
            for skin in model.skins.values():
                if software:
                    skin.want(needed_levels.get(id(skin)))
                else:
                    skin.target_level = 0

    def upload_one(self) -> bool:
        """Upload a piece of a texture. Return False if no upload is required."""
        models = self._textured()
        if any(skin.level is None for m in models for skin in m.skins.values()):
            # A new texture would be uploaded completely, which blocks the window, only to be
            # replaced by the level required for this view.
            self.choose()
        for model in models:
            for material, skin in model.skins.items():
                if skin.level == skin.target_level:
                    skin.forget_pieces(self._canvas.window)
                    continue
                if skin.upload_piece(self._canvas.surface, mipmap=not self._canvas.software):
                    self._dress(model, material)
                return True
        return False

    def _textured(self) -> list[ModelScene]:
        style = self._contents.look
        return [model for model in self._contents.visible() if style.textured(model)]

    def _dress(self, model: ModelScene, material: int) -> None:
        for part in model.parts:
            if part.material == material:
                self._contents.look.dress(model, part)
