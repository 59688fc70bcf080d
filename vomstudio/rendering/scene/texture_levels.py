"""Texture levels on the graphics card, selected according to the view."""

from __future__ import annotations

from vomstudio.rendering.scene.camera_visibility import SceneVisibility
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.contents import Contents
from vomstudio.rendering.scene.model_scene import ModelScene


class TextureLevels:
    """Texture levels of all models of a scene."""

    def __init__(
        self, canvas: Canvas, scene_contents: Contents, visibility: SceneVisibility
    ) -> None:
        self._canvas, self._contents, self._visibility = canvas, scene_contents, visibility

    @property
    def is_upload_due(self) -> bool:
        """Whether a finer texture than the uploaded one is required."""
        return any(
            gpu_texture.is_too_coarse
            for m in self._textured_models()
            for gpu_texture in m.gpu_textures.values()
        )

    def choose(self) -> None:
        """Choose the texture levels for the view.

        With a software renderer, these are the coarsest levels that have about one texel per pixel;
        otherwise, they are the finest levels.
        """
        software = self._canvas.is_software
        needed_levels = self._visibility.texels_per_pixel() if software else {}
        for model in self._contents.models.values():
            for gpu_texture in model.gpu_textures.values():
                if software:
                    gpu_texture.request_level(needed_levels.get(id(gpu_texture)))
                else:
                    gpu_texture.target_level = 0

    def upload_next_piece(self) -> bool:
        """Upload a piece of a texture. Return False if no upload is required."""
        models = self._textured_models()
        if any(
            gpu_texture.level is None for m in models for gpu_texture in m.gpu_textures.values()
        ):
            # A new texture would be uploaded completely, which blocks the window, only to be
            # replaced by the level required for this view.
            self.choose()
        for model in models:
            for material, gpu_texture in model.gpu_textures.items():
                if gpu_texture.level == gpu_texture.target_level:
                    gpu_texture.forget_pieces(self._canvas.window)
                    continue
                if gpu_texture.upload_piece(
                    self._canvas.surface, has_mipmap=not self._canvas.is_software
                ):
                    self._style_parts(model, material)
                return True
        return False

    def _textured_models(self) -> list[ModelScene]:
        style = self._contents.look
        return [model for model in self._contents.visible() if style.is_textured(model)]

    def _style_parts(self, model: ModelScene, material: int) -> None:
        for part in model.parts:
            if part.material == material:
                self._contents.look.style_part(model, part)
