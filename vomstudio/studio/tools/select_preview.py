"""What is shown of chosen faces and points, and of the patch that they would make."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, Model, get
from vomstudio.studio.tools.brush_stroke import record_figures
from vomstudio.studio.tools.element_selection import ChosenElements
from vomstudio.studio.tools.interaction_types import Area, Preview
from vomstudio.studio.tools.painted_area import chosen_area
from vomstudio.studio.tools.patch import new_patch
from vomstudio.studio.tools.patch_readout import patch_reading
from vomstudio.studio.tools.polyline import rgb
from vomstudio.studio.tools.screen_shape import DrawnShape
from vomstudio.studio.tools.tool_context import ToolContext

LIVE = 60_000
"""So many chosen faces or points are measured at every step; of more the plane is told by Enter."""
_COLOR = (0.05, 0.75, 0.95)


class SelectPreview:
    """Keeps what has been worked out for what is chosen now."""

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._area: tuple[BoolArray, Area | None] | None = None
        self._live: tuple[BoolArray, Measurement | None] | None = None

    def forget(self) -> None:
        """Nothing is chosen any more."""
        self._area = self._live = None

    def forget_measurement(self) -> None:
        """The patch would be of another type."""
        self._live = None

    def patch(self, chosen: ChosenElements) -> Patch | None:
        """Of what is chosen; None where its model is not open."""
        surface = self._context.surface(chosen.model_id)
        model = get(self._context.session.records, chosen.model_id, Model)
        if surface is None or model is None or surface.count != len(chosen.mask):
            return None
        patch = new_patch(self._context, model, surface.element)
        return patch.but(**record_figures(surface, chosen.ids()))

    def measurement(self, chosen: ChosenElements | None) -> Measurement | None:
        """Of the plane through what is chosen; None where that is too much to be measured live."""
        if chosen is None or chosen.count > LIVE:
            return None
        if self._live is None or self._live[0] is not chosen.mask:
            patch = self.patch(chosen)
            self._live = (chosen.mask, None if patch is None else self._context.measure(patch))
        return self._live[1]

    def show(self, chosen: ChosenElements | None, shape: DrawnShape | None) -> None:
        """Both, as far as they are there."""
        if shape is None and chosen is None:
            self._context.show(None)
            return
        measurement = None if shape is not None else self.measurement(chosen)
        kind = self._context.session.records.get(self._context.next_type_id)
        verdict = measurement.verdict if measurement else None
        self._context.show(
            Preview(
                line=np.zeros((0, 3)),
                color=rgb(kind.color) if isinstance(kind, FeatureType) else _COLOR,
                reading=patch_reading(self._context, measurement, painting=False),
                verdict=verdict.quality if verdict else None,
                area=None if chosen is None else self._drawn(chosen),
                outline=None if shape is None else shape.outline(),
            )
        )

    def _drawn(self, chosen: ChosenElements) -> Area | None:
        if self._area is None or self._area[0] is not chosen.mask:
            surface = self._context.surface(chosen.model_id)
            model = get(self._context.session.records, chosen.model_id, Model)
            if surface is None or model is None or surface.count != len(chosen.mask):
                return None
            self._area = (chosen.mask, chosen_area(chosen.ids(), model, surface))
        return self._area[1]
