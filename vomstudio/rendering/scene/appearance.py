"""Appearance of models: display mode, lighting, point size and field colours."""

from __future__ import annotations

from vomstudio.geometry.cloud import PointCloud
from vomstudio.rendering.prepare import vtk_data
from vomstudio.rendering.scene import gpu_textures
from vomstudio.rendering.scene.model_scene import ModelScene, Part
from vomstudio.rendering.view.scalars import reader

DISPLAY_MODES = ("textured", "vertex_colors", "plain shaded", "wireframe", "points", "field")
"""In the mode "field", a model shows its field, or its textures if it has no field."""
LIT_MODES = frozenset({"plain shaded"})
"""Display modes that are lit by default; colours are easier to read without lighting."""
PLAIN_COLOR = (0.76, 0.74, 0.70)


class Appearance:
    """Appearance of all models in a scene."""

    def __init__(self) -> None:
        self.mode = "textured"
        self.lit = {mode: mode in LIT_MODES for mode in DISPLAY_MODES}
        self.point_size: float | None = None
        """Point size in logical pixels; None closes the gaps between points."""
        self.point_scale = 1.0
        """Device pixels per logical pixel."""

    def is_textured(self, model: ModelScene) -> bool:
        return self.mode == "textured" or (self.mode == "field" and model.field is None)

    def shows_field(self, model: ModelScene) -> bool:
        return self.mode == "field" and model.field is not None

    def tint(self, model: ModelScene) -> None:
        """Apply the field colours of a model, or restore its original colours.

        The nodes of a cloud are coloured later, by `tint_node`.

        Raises
        ------
        ValueError
            If the colours do not match the parts of the model.
        """
        if isinstance(model.data, PointCloud):
            # Nodes of clouds are coloured when they are shown.
            for part in model.parts:
                self.untint(part)
                self.style_part(model, part)
            return
        field = model.field if self.mode == "field" else None
        fields = [] if field is None else [*field.parts, *field.proxies]
        parts = [*model.parts, *model.proxies]
        if field is not None and (len(field.parts), len(field.proxies)) != (
            len(model.parts),
            len(model.proxies),
        ):
            raise ValueError("the colours are of another state of the model")
        for k, part in enumerate(parts):
            values = part.actor.GetMapper().GetInput().GetPointData()
            if fields:
                if not part.is_tinted:
                    part.point_scalars = values.GetScalars()
                values.SetScalars(fields[k])
                part.is_uploaded, part.is_tinted = False, True
            else:
                self.untint(part)
            self.style_part(model, part)

    @staticmethod
    def untint(part: Part) -> None:
        if part.is_tinted:
            part.actor.GetMapper().GetInput().GetPointData().SetScalars(part.point_scalars)
            part.point_scalars = None
            part.is_uploaded, part.is_tinted = False, False

    def tint_node(self, model: ModelScene, part: Part) -> bool:
        """Apply field colours to a node before it is shown. Return whether its colours changed."""
        field = model.field
        if part.is_tinted or part.piece is None or field is None or not self.shows_field(model):
            return False
        _, read = reader(part.piece.cloud, field.style.name, model.to_world)
        values = part.actor.GetMapper().GetInput().GetPointData()
        part.point_scalars = values.GetScalars()
        values.SetScalars(vtk_data.color_array(field.scale.colors(read(part.piece.rows))))
        part.is_uploaded, part.is_tinted = False, True
        # Keep the point size of the view.
        part.actor.GetMapper().SetScalarVisibility(True)
        return True

    def style_part(self, model: ModelScene, part: Part) -> None:
        """Set the appearance of a part for the display mode."""
        actor, mapper, display_property = (
            part.actor,
            part.actor.GetMapper(),
            part.actor.GetProperty(),
        )
        display_property.SetColor(*PLAIN_COLOR)
        display_property.SetPointSize(max(1.0, round((self.point_size or 2.0) * self.point_scale)))
        display_property.SetAmbient(0.25)
        display_property.SetDiffuse(0.75)
        if isinstance(model.data, PointCloud):
            display_property.LightingOff()
            colored = part.is_tinted or (part.has_colors and self.mode != "plain shaded")
            mapper.SetScalarVisibility(colored)
            return
        gpu_texture = model.gpu_textures.get(part.material) if part.has_uv else None
        gpu_textures.remove_textures(actor)
        is_textured = (
            gpu_texture is not None and self.is_textured(model) and gpu_texture.apply_to(actor)
        )
        if is_textured:
            display_property.SetColor(1.0, 1.0, 1.0)
        colored = part.is_tinted or (
            part.has_colors and not is_textured and self.mode != "plain shaded"
        )
        mapper.SetScalarVisibility(colored)
        display_property.SetLighting(
            self.lit[self.mode if is_textured or colored else "plain shaded"]
        )
        if self.mode == "wireframe":
            display_property.SetRepresentationToWireframe()
            display_property.SetLighting(False)
        elif self.mode == "points":
            display_property.SetRepresentationToPoints()
            display_property.SetLighting(False)
        else:
            display_property.SetRepresentationToSurface()
