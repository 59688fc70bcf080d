"""Second scene that draws the contents of another scene without copying its data."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from vtkmodules.vtkCommonDataModel import vtkPolyData

from vomstudio.rendering.scene import gpu_textures, picking
from vomstudio.rendering.scene.appearance import Appearance
from vomstudio.rendering.scene.canvas import Canvas
from vomstudio.rendering.scene.gpu_textures import GpuTexture
from vomstudio.rendering.scene.model_scene import ModelScene, Part
from vomstudio.rendering.scene.scene import Scene
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import PREVIEW
from vomstudio.studio.tools.interaction_types import Hit


class _SharedAppearance(Appearance):
    """Appearance whose field colours are applied by the source scene to the shared data."""

    def __init__(self, source: Scene) -> None:
        super().__init__()
        self._source = source

    def tint_node(self, model: ModelScene, part: Part) -> bool:
        source_model = self._source.models.get(model.model_id)
        if source_model is None or part.source is None:
            return False
        self._source.look.tint_node(source_model, part.source)
        if part.is_tinted == part.source.is_tinted:
            return False
        part.is_tinted, part.is_uploaded = part.source.is_tinted, False
        part.actor.GetMapper().SetScalarVisibility(True)
        return True


class SharedScene(Scene):
    """Scene with its own camera and actors, whose data belong to a source scene.

    Points, faces, colours and decoded textures are shared; only the resources on the graphics card
    are created again. `follow` adopts the changes of the source.
    """

    def __init__(self, source: Scene, camera: Camera, canvas: Canvas) -> None:
        super().__init__(camera, canvas, _SharedAppearance(source))
        self._source = source

    def follow(self, is_shown: Callable[[str], bool]) -> bool:
        """Adopt the current contents and appearance of the source.

        Parameters
        ----------
        is_shown : callable
            Function that returns whether this scene shows a model, given its id.

        Returns
        -------
        bool
            Whether the models must be drawn again; features are redrawn separately.
        """
        source = self._source
        has_changed = self._follow_look(source.look)
        for model_id in [i for i in self.models if i not in source.models]:
            self.remove_model(model_id)
            has_changed = True
        for model_id, model in source.models.items():
            has_changed |= self._follow_model(model)
            if self.models[model_id].visible != is_shown(model_id):
                self.set_visible(model_id, not self.models[model_id].visible)
                has_changed = True
        if source.clip_box is not self.clip_box:
            self.set_clip(source.clip_box)
            has_changed = True
        if source.picture.eye_dome != self.picture.eye_dome:
            self.set_eye_dome(source.picture.eye_dome)
            has_changed = True
        if has_changed:
            self.picture.abandon()
        return has_changed

    def follow_features(self) -> bool:
        """Adopt the drawings and the selection of the source. Return whether they have changed."""
        source, layer = self._source.features, self.features
        changes = {
            key: drawing
            for key, drawing in source.drawings.items()
            if layer.drawings.get(key) is not drawing
        }
        removed_ids = dict.fromkeys(layer.drawings.keys() - source.drawings.keys())
        if changes or removed_ids:
            self.set_features({**changes, **removed_ids})
        is_selected = source.selected != layer.selected
        if is_selected:
            self.set_selected(source.selected)
        return bool(changes or removed_ids or is_selected)

    def pick(self, x: float, y: float, size: tuple[float, float]) -> Hit | None:
        """Return the front-most point of the visible models at a pixel, or None."""
        models = self._source.models
        candidates = [
            models[model.model_id]
            for model in self._contents.visible()
            if model.model_id in models and not model.model_id.startswith(PREVIEW)
        ]
        return picking.pick_front(candidates, self.camera, x, y, size, self.clip_box)

    def _follow_look(self, style: Appearance) -> bool:
        settings = (self.look.mode, self.look.lit, self.look.point_size)
        if settings == (style.mode, style.lit, style.point_size):
            return False
        self.look.mode, self.look.lit = style.mode, dict(style.lit)
        self.look.point_size = style.point_size
        self._restyle_parts()
        return True

    def _follow_model(self, model: ModelScene) -> bool:
        """Adopt the current state of a model of the source. Return whether it has changed."""
        copy, is_changed = self.models.get(model.model_id), False
        if copy is None or copy.data is not model.data:
            bounds = model.origin + np.stack([model.low, model.high])
            copy = self.add_model(model.model_id, model.data, model.to_world, bounds, model.origin)
            is_changed = True
        if (copy.to_world != model.to_world).any():
            self.set_to_world(model.model_id, model.to_world)
            is_changed = True
        if copy.field is not model.field or copy.hidden is not model.hidden:
            copy.field, copy.hidden = model.field, model.hidden
            is_changed = True
        is_changed |= self._follow_textures(copy, model)
        is_changed |= self._follow_parts(copy, copy.proxies, model.proxies)
        is_changed |= self._follow_parts(copy, copy.parts, model.parts)
        is_done = (model.has_all_chunks, model.has_all_textures)
        if (copy.has_all_chunks, copy.has_all_textures) != is_done:
            copy.has_all_chunks, copy.has_all_textures = is_done
            # Until all chunks are present, a simplified model is shown.
            is_changed = True
        return is_changed

    @staticmethod
    def _follow_textures(copy: ModelScene, model: ModelScene) -> bool:
        is_changed = False
        for material, gpu_texture in model.gpu_textures.items():
            previous_texture = copy.gpu_textures.get(material)
            if previous_texture is None or previous_texture.texture is not gpu_texture.texture:
                copy.gpu_textures[material] = GpuTexture(gpu_texture.texture)
                is_changed = True
        return is_changed

    def _follow_parts(self, copy: ModelScene, parts: list[Part], sources: list[Part]) -> bool:
        """Adopt the parts of a model, which share the data of their sources."""
        is_changed = False
        if [id(part.source) for part in parts] != [id(source) for source in sources]:
            present_parts = {id(part.source): part for part in parts}
            parts[:] = [
                present_parts.pop(id(source))
                if id(source) in present_parts
                else self._share_part(copy, source)
                for source in sources
            ]
            for part in present_parts.values():
                gpu_textures.remove_textures(part.actor)
                self.canvas.remove(part.actor)
            copy.forget_boxes()
            is_changed = True
        for part, source in zip(parts, sources, strict=True):
            if part.is_tinted != source.is_tinted or part.elements != source.elements:
                part.is_tinted, part.elements, part.is_uploaded = (
                    source.is_tinted,
                    source.elements,
                    False,
                )
                self.look.style_part(copy, part)
                is_changed = True
        return is_changed

    def _share_part(self, copy: ModelScene, source: Part) -> Part:
        """Create a part that draws the data of another part."""
        data = source.actor.GetMapper().GetInput()
        assert isinstance(data, vtkPolyData)
        part = self._actor_creator.part(copy, data)
        part.source, part.has_colors = source, source.has_colors
        part.material, part.density, part.has_uv = source.material, source.density, source.has_uv
        part.spacing, part.row, part.rows = source.spacing, source.row, source.rows
        part.is_tinted = source.is_tinted
        self.look.style_part(copy, part)
        return part
