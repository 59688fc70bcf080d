"""What can be done with chosen faces and points at once: all, none, a ring more, by a value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.patches import ids_of
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_selection import ChosenElements, Combine
from vomstudio.studio.tools.interaction_types import Discarded
from vomstudio.studio.tools.tool_context import ToolContext

if TYPE_CHECKING:
    from vomstudio.extraction.selection.field_values import ElementColours
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh


class Chooser(Protocol):
    """What the changes ask of the tool."""

    combine: Combine
    name: str

    @property
    def chosen(self) -> ChosenElements | None: ...

    def take(self, model_id: str, found: BoolArray, how: Combine, step: str) -> None: ...


class SelectChanges:
    """Of one tool. Each is a step that undo takes back."""

    def __init__(self, tool: Chooser, context: ToolContext) -> None:
        self._tool, self._context = tool, context
        self._colours: tuple[object, ElementColours] | None = None

    def _only(self, chosen: ChosenElements, mask: BoolArray, step: str) -> None:
        self._tool.take(chosen.model_id, mask, "new", step)

    # --- all at once -------------------------------------------------------------------------
    def model_id(self) -> str | None:
        """Of the model that is meant: that of what is chosen, else the only one that is shown."""
        chosen = self._tool.chosen
        shown = self._context.elements.shown()
        if chosen is not None:
            return chosen.model_id
        return shown[0] if len(shown) == 1 else None

    def data(self) -> Mesh | PointCloud | None:
        """Of the model that is meant; None where it is not clear which."""
        model_id = self.model_id()
        return None if model_id is None else self._context.elements.data(model_id)

    def everything(self) -> None:
        """Choose all of the model that is meant."""
        from vomstudio.extraction.selection.visible_region import count_of

        model_id, data = self.model_id(), self.data()
        if model_id is not None and data is not None:
            self._tool.take(model_id, np.ones(count_of(data), np.bool_), "new", tr("Choose all"))

    def invert(self) -> None:
        """What is not chosen, in place of what is."""
        if (chosen := self._tool.chosen) is not None:
            self._only(chosen, ~chosen.mask, tr("Invert"))

    def wider(self) -> None:
        """A ring of neighbours more."""
        self._ring(gains=True)

    def narrower(self) -> None:
        """A ring less."""
        self._ring(gains=False)

    def _ring(self, *, gains: bool) -> None:
        chosen = self._tool.chosen
        if chosen is None:
            return
        again = self.wider if gains else self.narrower
        found = self._context.elements.neighbours(chosen.model_id, again)
        if found is None:
            self._context.hint(Finding("neighbours.pending"))
        elif isinstance(found, Finding):
            self._context.say(found)
        elif gains:
            self._only(chosen, found.wider(chosen.mask), tr("Widen"))
        else:
            self._only(chosen, found.narrower(chosen.mask), tr("Narrow"))

    def take_patch(self, patch: Patch) -> None:
        """Choose the faces or points of a patch."""
        data = self._context.elements.data(patch.model_id)
        if data is None:
            self._context.say(Finding("model.not-open", model=patch.model_id))
            return
        from vomstudio.extraction.selection.visible_region import count_of

        mask = np.zeros(count_of(data), np.bool_)
        ids = ids_of(patch.runs)
        mask[ids[ids < len(mask)]] = True
        self._tool.take(patch.model_id, mask, self._tool.combine, tr("Take a patch"))

    # --- by a value --------------------------------------------------------------------------
    def by_field(self, name: str, low: float, high: float) -> None:
        """What has a value from low to high."""
        from vomstudio.extraction.selection.field_values import within

        model_id, data = self.model_id(), self.data()
        model = get(self._context.session.records, model_id, Model)
        if model_id is None or data is None or model is None:
            self._context.hint(Finding("selection.empty"))
            return
        found = within(data, transform.matrix(model.to_world), name, low, high)
        if not found.any():
            self._context.hint(Finding("selection.no-such-value"))
            return
        self._tool.take(model_id, found, self._tool.combine, tr("By a field"))

    def by_colour(self, tolerance: float) -> None:
        """What has a colour like that of what is chosen."""
        from vomstudio.extraction.selection.field_values import ElementColours

        chosen, data = self._tool.chosen, self.data()
        if chosen is None or data is None:
            self._context.hint(Finding("selection.empty"))
            return
        try:
            if self._colours is None or self._colours[0] is not data:
                self._colours = (data, ElementColours(data))
            found = self._colours[1].like(chosen.ids(), tolerance)
        except VomError as error:
            self._context.say(error)
            return
        self._tool.take(chosen.model_id, found, self._tool.combine, tr("By colour"))

    # --- hiding and cutting ------------------------------------------------------------------
    def isolate(self) -> None:
        """Hide everything of the model but what is chosen."""
        if (chosen := self._tool.chosen) is not None:
            self._context.elements.hide(chosen.model_id, ~chosen.mask)
            self._context.tool_changed()

    def show_all(self) -> None:
        """Show every face and point again; undo hides them again."""
        elements = self._context.elements
        hidden = {id_: elements.hidden(id_) for id_ in elements.shown()}
        for model_id in hidden:
            elements.hide(model_id, None)
        self._context.tool_changed()

        def hide_again() -> bool:
            for model_id, mask in hidden.items():
                elements.hide(model_id, mask)
            self._context.tool_changed()
            return True

        self._context.discarded(
            Discarded(self._tool.name, "Show what was hidden", hide_again, lambda: False)
        )

    def anything_hidden(self) -> bool:
        """Whether a face or point is hidden."""
        elements = self._context.elements
        return any(elements.hidden(id_) is not None for id_ in elements.shown())

    def cut_out(self) -> None:
        """A model of what is chosen."""
        if (chosen := self._tool.chosen) is not None:
            self._context.elements.cut_out(chosen.model_id, chosen.mask)
