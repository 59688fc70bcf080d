"""Changes of the entire selection, such as its inverse or selection by value."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_selection import Combine, ElementSelection
from vomstudio.studio.tools.interaction_types import DiscardedFeature
from vomstudio.studio.tools.selection_messages import UNDO_LABELS
from vomstudio.studio.tools.tool_context import ToolContext

if TYPE_CHECKING:
    from vomstudio.extraction.selection.field_values import ElementColours
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh


class SelectionTool(Protocol):
    """Protocol of the tool whose selection is changed."""

    combine: Combine
    name: ClassVar[str]

    @property
    def selection(self) -> ElementSelection | None: ...

    def take(self, model_id: str, mask: BoolArray, combination: Combine, step: str) -> None: ...


class ElementChanges:
    """Changes of the selection of a tool; each is a step that undo reverts."""

    def __init__(self, tool: SelectionTool, context: ToolContext) -> None:
        self._tool, self._context = tool, context
        self._colours: tuple[object, ElementColours] | None = None

    def _replace_selection(self, selection: ElementSelection, mask: BoolArray, step: str) -> None:
        self._tool.take(selection.model_id, mask, "new", step)

    # --- all at once -------------------------------------------------------------------------
    def model_id(self) -> str | None:
        """Return the id of the selection's model, or else of the only visible model, or None."""
        selection = self._tool.selection
        visible_ids = self._context.elements.shown()
        if selection is not None:
            return selection.model_id
        return visible_ids[0] if len(visible_ids) == 1 else None

    def data(self) -> Mesh | PointCloud | None:
        """Return the data of the model, or None if the model is not unique."""
        model_id = self.model_id()
        return None if model_id is None else self._context.elements.data(model_id)

    def select_all(self) -> None:
        """Select all elements of the model."""
        from vomstudio.extraction.selection.visible_region import element_count

        model_id, data = self.model_id(), self.data()
        if model_id is not None and data is not None:
            self._tool.take(
                model_id, np.ones(element_count(data), np.bool_), "new", tr("Select all")
            )

    def invert(self) -> None:
        """Invert the selection."""
        if (selection := self._tool.selection) is not None:
            self._replace_selection(selection, ~selection.mask, tr("Invert"))

    def expand(self) -> None:
        """Enlarge the selection by one ring of neighbours."""
        self._change_ring(includes_outer=True)

    def shrink(self) -> None:
        """Shrink the selection by one ring of elements."""
        self._change_ring(includes_outer=False)

    def _change_ring(self, *, includes_outer: bool) -> None:
        selection = self._tool.selection
        if selection is None:
            return
        growth_steps = self.expand if includes_outer else self.shrink
        neighbours = self._context.elements.neighbours(selection.model_id, growth_steps)
        if neighbours is None:
            self._context.hint(Finding("neighbours.pending"))
        elif isinstance(neighbours, Finding):
            self._context.report(neighbours)
        elif includes_outer:
            self._replace_selection(selection, neighbours.expand(selection.mask), tr("Expand"))
        else:
            self._replace_selection(selection, neighbours.shrink(selection.mask), tr("Shrink"))

    def select_patch(self, patch: Patch) -> None:
        """Select the faces or points of a patch."""
        data = self._context.elements.data(patch.model_id)
        if data is None:
            self._context.report(Finding("model.not-open", model=patch.model_id))
            return
        from vomstudio.extraction.selection.visible_region import element_count

        mask = np.zeros(element_count(data), np.bool_)
        ids = runs_to_ids(patch.runs)
        mask[ids[ids < len(mask)]] = True
        self._tool.take(patch.model_id, mask, self._tool.combine, tr("Select plane"))

    # --- selection by value -------------------------------------------------------------------
    def select_by_field(self, name: str, low: float, high: float) -> None:
        """Select elements with values from `low` to `high`."""
        from vomstudio.extraction.selection.field_values import select_by_value

        model_id, data = self.model_id(), self.data()
        model = get(self._context.session.records, model_id, Model)
        if model_id is None or data is None or model is None:
            self._context.hint(Finding("selection.empty"))
            return
        mask = select_by_value(data, transform.matrix(model.to_world), name, low, high)
        if not mask.any():
            self._context.hint(Finding("selection.no-such-value"))
            return
        self._tool.take(model_id, mask, self._tool.combine, tr("Select by field"))

    def select_by_colour(self, tolerance: float) -> None:
        """Select elements with colours similar to those of the selection."""
        from vomstudio.extraction.selection.field_values import ElementColours

        selection, data = self._tool.selection, self.data()
        if selection is None or data is None:
            self._context.hint(Finding("selection.empty"))
            return
        try:
            if self._colours is None or self._colours[0] is not data:
                self._colours = (data, ElementColours(data))
            mask = self._colours[1].like(selection.ids(), tolerance)
        except VomError as error:
            self._context.report(error)
            return
        self._tool.take(selection.model_id, mask, self._tool.combine, tr("Select by colour"))

    # --- hiding and cutting ------------------------------------------------------------------
    def isolate(self) -> None:
        """Hide all elements of the model except the selection."""
        if (selection := self._tool.selection) is not None:
            self._context.elements.hide(selection.model_id, ~selection.mask)
            self._context.tool_changed()

    def show_all(self) -> None:
        """Show every face and point again; undo hides them again."""
        elements = self._context.elements
        hidden_by_id = {id_: elements.hidden(id_) for id_ in elements.shown()}
        for model_id in hidden_by_id:
            elements.hide(model_id, None)
        self._context.tool_changed()

        def hide_again() -> bool:
            for model_id, mask in hidden_by_id.items():
                elements.hide(model_id, mask)
            self._context.tool_changed()
            return True

        self._context.report_discarded(
            DiscardedFeature(self._tool.name, tr(UNDO_LABELS["show"]), hide_again, lambda: False)
        )

    def has_hidden_elements(self) -> bool:
        """Return whether any face or point is hidden."""
        elements = self._context.elements
        return any(elements.hidden(id_) is not None for id_ in elements.shown())

    def cut_out(self) -> None:
        """Create a new model from the selection."""
        if (selection := self._tool.selection) is not None:
            self._context.elements.cut_out(selection.model_id, selection.mask)
