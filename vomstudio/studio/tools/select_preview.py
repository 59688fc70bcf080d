"""Preview of a selection of faces or points, and of the resulting patch."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, Model, get
from vomstudio.studio.tools.brush_stroke import record_figures
from vomstudio.studio.tools.element_selection import ElementSelection
from vomstudio.studio.tools.interaction_types import Area, Preview
from vomstudio.studio.tools.painted_area import selection_area
from vomstudio.studio.tools.patch import new_patch
from vomstudio.studio.tools.patch_readout import patch_reading
from vomstudio.studio.tools.polyline import rgb
from vomstudio.studio.tools.screen_shape import DrawnShape
from vomstudio.studio.tools.tool_context import ToolContext

MAX_LIVE_ELEMENTS = 60_000
"""Maximum number of elements that are measured at every step; larger selections are measured only
when a patch is created."""
_COLOR = (0.05, 0.75, 0.95)


class SelectPreview:
    """Preview of the selection, with cached results."""

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._area: tuple[BoolArray, Area | None] | None = None
        self._live: tuple[BoolArray, Measurement | None] | None = None

    def forget(self) -> None:
        """Reset because the selection is empty."""
        self._area = self._live = None

    def forget_measurement(self) -> None:
        """Reset the measurement because the patch would have another type."""
        self._live = None

    def patch(self, selection: ElementSelection) -> Patch | None:
        """Return the patch of the selection, or None if its model is not open."""
        surface = self._context.surface(selection.model_id)
        model = get(self._context.session.records, selection.model_id, Model)
        if surface is None or model is None or surface.count != len(selection.mask):
            return None
        patch = new_patch(self._context, model, surface.element)
        return patch.but(**record_figures(surface, selection.ids()))

    def measurement(self, selection: ElementSelection | None) -> Measurement | None:
        """Return the measurement of the plane, or None if the selection is too large."""
        if selection is None or selection.count > MAX_LIVE_ELEMENTS:
            return None
        if self._live is None or self._live[0] is not selection.mask:
            patch = self.patch(selection)
            self._live = (selection.mask, None if patch is None else self._context.measure(patch))
        return self._live[1]

    def show(self, selection: ElementSelection | None, shape: DrawnShape | None) -> None:
        """Draw the selection and the unfinished shape."""
        if shape is None and selection is None:
            self._context.show(None)
            return
        measurement = None if shape is not None else self.measurement(selection)
        kind = self._context.session.records.get(self._context.next_type_id)
        verdict = measurement.verdict if measurement else None
        self._context.show(
            Preview(
                line=np.zeros((0, 3)),
                color=rgb(kind.color) if isinstance(kind, FeatureType) else _COLOR,
                reading=patch_reading(self._context, measurement, painting=False),
                verdict=verdict.quality if verdict else None,
                area=None if selection is None else self._drawn(selection),
                outline=None if shape is None else shape.outline(),
            )
        )

    def _drawn(self, selection: ElementSelection) -> Area | None:
        if self._area is None or self._area[0] is not selection.mask:
            surface = self._context.surface(selection.model_id)
            model = get(self._context.session.records, selection.model_id, Model)
            if surface is None or model is None or surface.count != len(selection.mask):
                return None
            self._area = (selection.mask, selection_area(selection.ids(), model, surface))
        return self._area[1]
