"""Cached drawing and measured plane of the selected faces or points."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from vomstudio.core.arrays import BoolArray
from vomstudio.core.identifiers import new_id
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.brush_stroke import patch_fields
from vomstudio.studio.tools.element_selection import ElementSelection
from vomstudio.studio.tools.interaction_types import Area
from vomstudio.studio.tools.painted_area import selection_area
from vomstudio.studio.tools.tool_context import ToolContext

MAX_LIVE_ELEMENTS = 60_000
"""Maximum number of elements that are measured at every step; larger selections are measured only
when a plane is created."""


class ElementPreview:
    """Preview of a selection, with cached results."""

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self._area: tuple[BoolArray, Area | None] | None = None
        self._mask_measurement: tuple[BoolArray, Measurement | None] | None = None

    def clear_state(self) -> None:
        """Reset because the selection is empty."""
        self._area = self._mask_measurement = None

    def forget_measurement(self) -> None:
        """Reset the measurement because the plane would have another type."""
        self._mask_measurement = None

    def patch(self, selection: ElementSelection) -> Patch | None:
        """Return the patch of the selection, or None if its model is not open."""
        surface = self._context.surface(selection.model_id)
        model = get(self._context.session.records, selection.model_id, Model)
        if surface is None or model is None or surface.count != len(selection.mask):
            return None
        patch = new_patch(self._context, model, surface.element)
        return patch.replace_fields(**patch_fields(surface, selection.ids()))

    def measurement(self, selection: ElementSelection | None) -> Measurement | None:
        """Return the measurement of the plane; None if the selection is empty or too large."""
        if selection is None or selection.count > MAX_LIVE_ELEMENTS:
            return None
        if self._mask_measurement is None or self._mask_measurement[0] is not selection.mask:
            patch = self.patch(selection)
            self._mask_measurement = (
                selection.mask,
                None if patch is None else self._context.measure(patch),
            )
        return self._mask_measurement[1]

    def area(self, selection: ElementSelection | None) -> Area | None:
        """Return the selection for drawing, or None if it is empty or its model is not open."""
        if selection is None:
            return None
        if self._area is None or self._area[0] is not selection.mask:
            surface = self._context.surface(selection.model_id)
            model = get(self._context.session.records, selection.model_id, Model)
            if surface is None or model is None or surface.count != len(selection.mask):
                return None
            self._area = (selection.mask, selection_area(selection.ids(), model, surface))
        return self._area[1]


def new_patch(context: ToolContext, model: Model, element: Literal["face", "point"]) -> Patch:
    """Create an empty patch with the next feature type and set.

    Parameters
    ----------
    context : ToolContext
    model : Model
    element : {"face", "point"}

    Returns
    -------
    Patch
    """
    patch = empty_patch(model, element, context.next_type_id)
    return replace(patch, set_name=context.next_set)


def empty_patch(model: Model, element: Literal["face", "point"], type_id: str) -> Patch:
    """Create a patch without elements.

    Parameters
    ----------
    model : Model
    element : {"face", "point"}
    type_id : str
        Feature type.

    Returns
    -------
    Patch
    """
    zero_vector = (0.0, 0.0, 0.0)
    return Patch(
        id=new_id("patch"),
        name="",
        type_id=type_id,
        model_id=model.id,
        model_hash=model.content_hash,
        element=element,
        runs=(),
        n=0,
        mean=zero_vector,
        scatter=(zero_vector, zero_vector, zero_vector),
        n_effective=0.0,
    )
