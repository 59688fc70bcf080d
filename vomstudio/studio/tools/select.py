"""Tool that selects features, or the faces and points of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.studio.tools.element_tool import ElementTool
from vomstudio.studio.tools.interaction_types import PointerEvent, Preview
from vomstudio.studio.tools.screen_shape import DrawnShape
from vomstudio.studio.tools.selection_messages import (
    SHAPE_HINTS,
    UNDO_LABELS,
    ShapeMode,
    count_text,
)
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import ToolEntry

if TYPE_CHECKING:
    from vomstudio.extraction.selection.visible_region import ViewSnapshot

Target = Literal["features", "surface"]
_COLOR = (0.05, 0.75, 0.95)
_HINTS: dict[Target, str] = {
    "features": to_translate("Select features: click one, or {how} The right button orbits."),
    "surface": to_translate("Select the surface: {how} {count}"),
}


class SelectTool(ElementTool):
    """Tool that selects features or elements inside a shape, and features by clicks.

    Attributes
    ----------
    target : {"features", "surface"}
        Whether shapes select features, or the faces and points of a model.
    """

    name = "select"

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self.target: Target = "features"

    def hint(self) -> str:
        if self._shape is not None:
            return self._shape.hint()
        mode: ShapeMode = "rectangle" if self.mode == "pick" else self.mode
        hint_text = tr(SHAPE_HINTS[mode])
        return tr(_HINTS[self.target], how=hint_text, count=count_text(self.count))

    def finish_problem(self) -> Finding | None:
        return Finding("tool.no-shape") if self._shape is None else self._shape.close_problem()

    def set_target(self, target: Target) -> None:
        """Set whether shapes select features or the surface of a model."""
        self._shape = None
        self.target = target
        self._notify_change()

    @property
    def selects_feature(self) -> bool:
        """Whether a click selects the feature under the cursor."""
        return self.target == "features" and self.mode != "polygon" and self._shape is None

    def pointer(self, event: PointerEvent) -> None:
        """Draw a shape with the left button; see `Tool`."""
        self._draw(event)

    def _apply_shape(self, shape: DrawnShape, snapshot: ViewSnapshot) -> None:
        if self.target == "surface":
            super()._apply_shape(shape, snapshot)
            return
        positions = self._context.feature_positions()
        ids = list(positions)
        pixels = snapshot.pixels(np.array([positions[id_] for id_ in ids]).reshape(-1, 3))
        filled_ring = snapshot.outline_mask(shape.ring())
        height, width = filled_ring.shape
        with np.errstate(invalid="ignore"):
            is_in_picture = (pixels >= 0.0) & (pixels < [width, height])
        is_seen = np.asarray(is_in_picture.all(axis=1))
        columns, rows = np.where(is_seen[:, None], pixels, 0.0).astype(int).T
        is_inside = is_seen & (filled_ring[rows, columns] > 0)
        inside_ids = tuple(id_ for id_, is_in in zip(ids, is_inside, strict=True) if is_in)
        if not inside_ids and shape.combine == "new":
            self._context.hint(Finding("selection.no-feature-inside"))
        self._context.select(inside_ids, shape.combine)

    def finish(self) -> str | None:
        """Close the unfinished shape and return None."""
        self._close_shape()
        return None

    def hide_selected(self) -> None:
        """Hide the selection; undo shows and selects it again."""
        selection, elements = self.selection, self._context.elements
        if selection is None:
            return
        model_id, previous_mask = selection.model_id, elements.hidden(selection.model_id)
        elements.hide(
            model_id, selection.mask if previous_mask is None else selection.mask | previous_mask
        )
        self._discard_selection(
            selection, tr(UNDO_LABELS["hide"]), lambda: elements.hide(model_id, previous_mask)
        )

    def _show_preview(self) -> None:
        if self._shape is None and self.selection is None:
            self._context.show(None)
            return
        self._context.show(
            Preview(
                line=np.zeros((0, 3)),
                color=_COLOR,
                area=self._preview.area(self.selection),
                outline=None if self._shape is None else self._shape.outline(),
            )
        )


TOOL = ToolEntry(
    SelectTool,
    label=to_translate("&Select"),
    icon="selection-drag",
    key="S",
    tip=to_translate("Select features or parts of the surface by clicking or drawing shapes."),
    order=25,
    uses_modifiers=True,
)
