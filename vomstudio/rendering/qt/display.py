"""Appearance of the models in the view: display mode, lighting, points and fields."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from vomstudio.rendering.prepare.events import FieldReady
from vomstudio.rendering.qt.scene_lifetime import SceneLifetime
from vomstudio.rendering.qt.scene_picture import ScenePicture
from vomstudio.rendering.qt.shown_models import ShownModels
from vomstudio.rendering.view.scalars import ELEVATION, FieldStyle, Scale

if TYPE_CHECKING:
    from vomstudio.rendering.scene.scene import Scene


class ModelAppearance(QObject):
    """Appearance of the models.

    `captions` contains their names, which are shown if several models show a field.
    """

    field_shown = Signal(str)
    """Emits the model id when the colour scale of its field is available from `color_scale`."""

    def __init__(
        self, lifetime: SceneLifetime, picture: ScenePicture, models: ShownModels, parent: QObject
    ) -> None:
        super().__init__(parent)
        self.captions: dict[str, str] = {}
        self._lifetime, self._picture, self._work = lifetime, picture, models.work
        self._styles: dict[str, FieldStyle] = {}
        self._mode = "textured"
        models.chunked.connect(self._color)
        models.colored.connect(self._take_field)
        models.placed.connect(self._apply_placement)
        models.removed.connect(self._forget_field)

    def set_mode(self, mode: str) -> None:
        """Set the display mode, one of `scene.appearance.DISPLAY_MODES`."""
        self._mode = mode

        def apply(scene: Scene) -> None:
            if mode != "field":
                # The colours of a field that is not displayed would only use memory.
                for model_id in list(scene.models):
                    scene.set_field(model_id, None)
            scene.set_mode(mode)
            for model_id in self._styles:
                self._color(model_id)

        self._change(apply)

    def set_lit(self, mode: str, is_lit: bool) -> None:
        """Set whether a light at the viewer shades the meshes in a display mode."""
        self._change(lambda scene: scene.set_lit(mode, is_lit))

    def set_point_size(self, pixels: float | None) -> None:
        """Set the size of cloud points in logical pixels; None closes the gaps between points."""
        self._change(lambda scene: scene.set_point_size(pixels))

    def set_eye_dome(self, is_enabled: bool) -> None:
        """Set whether clouds at rest have eye-dome lighting."""
        self._change(lambda scene: scene.set_eye_dome(is_enabled))

    def _change(self, change: Callable[[Scene], None]) -> None:
        def apply() -> None:
            assert self._lifetime.scene is not None
            change(self._lifetime.scene)
            self._picture.replace_canvas()

        self._lifetime.call_when_started(apply)

    # -- fields

    def set_field(self, model_id: str, style: FieldStyle | None, caption: str = "") -> None:
        """Set the field of a model for the display mode "field", or None to remove it.

        `caption` is the name of the model; it is shown if several models show a field.
        """
        self.captions[model_id] = caption
        if style == self._styles.get(model_id):
            return
        self._forget_field(model_id)
        scene = self._lifetime.scene
        if style is not None:
            self._styles[model_id] = style
            self._color(model_id)
        elif scene is not None and model_id in scene.models:
            scene.set_field(model_id, None)
            self._picture.replace_canvas()

    def color_scale(self, model_id: str) -> Scale | None:
        """Return the colour scale of a model's field, or None if the model shows no field."""
        scene = self._lifetime.scene
        model = None if scene is None else scene.models.get(model_id)
        if model is None or model.field is None or self._mode != "field":
            return None
        return model.field.scale

    def scales(self) -> list[tuple[Scale, str]]:
        """Return the colour scales of all displayed fields, with the ids of their models."""
        scene = self._lifetime.scene
        return [] if scene is None else scene.scales()

    def _apply_placement(self, model_id: str) -> None:
        if model_id in self._styles and self._styles[model_id].name == ELEVATION:
            self._color(model_id)

    def _color(self, model_id: str) -> None:
        """Start to compute the colours of a model's field if the field is displayed."""
        scene = self._lifetime.scene
        model = None if scene is None else scene.models.get(model_id)
        style = self._styles.get(model_id)
        if model is None or style is None or self._mode != "field" or not model.has_all_chunks:
            return
        self._work.color(
            model_id,
            model.data,
            style,
            model.to_world.copy(),
            [part.rows for part in model.proxies],
            [part.rows for part in model.parts],
        )

    def _take_field(self, model_id: str, event: FieldReady) -> None:
        scene = self._lifetime.scene
        if scene is None:
            return
        if self._mode == "field" and self._styles.get(model_id) == event.style:
            scene.take(model_id, event)
            self._picture.replace_canvas()
            self.field_shown.emit(model_id)

    def _forget_field(self, model_id: str) -> None:
        self._styles.pop(model_id, None)
        self._work.forget_field(model_id)
