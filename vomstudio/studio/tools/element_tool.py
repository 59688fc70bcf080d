"""Base class of the tools that select faces or points of a model.

The tools are state machines without Qt or VTK. The selected elements belong to one model. Every
change is a step that can be undone, and is written to the journal as a draft. A shape that is drawn
over the picture selects the elements inside (the centroids of faces), and includes hidden elements
only on request.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_changes import ElementChanges
from vomstudio.studio.tools.element_preview import ElementPreview
from vomstudio.studio.tools.element_selection import Combine, ElementSelection, combine_masks
from vomstudio.studio.tools.interaction_types import Button, DiscardedFeature, Pointer, PointerEvent
from vomstudio.studio.tools.screen_shape import DrawnShape
from vomstudio.studio.tools.selection_messages import MODES, ElementMode
from vomstudio.studio.tools.tool_context import ToolContext

if TYPE_CHECKING:
    from vomstudio.extraction.selection.visible_region import ViewSnapshot


class ElementTool:
    """Tool that selects faces or points.

    Attributes
    ----------
    noun : str
        Name of the selected elements in undo labels.
    changes : ElementChanges
        Changes of the entire selection.
    mode : ElementMode
        Action of a click or drag.
    combine : Combine
        Combination of the result with the selection if no modifier key is pressed.
    is_through : bool
        Whether shapes also select hidden elements.
    """

    name: ClassVar[str]
    noun: ClassVar[str] = "selection"
    can_paint: ClassVar[bool] = True

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.mode: ElementMode = "rectangle"
        self.combine: Combine = "new"
        self.is_through = False
        self._selection: ElementSelection | None = None
        self.changes = ElementChanges(self, context)
        self._shape: DrawnShape | None = None
        self._preview = ElementPreview(context)

    # --- to be implemented by the tool --------------------------------------------------------
    def _show_preview(self) -> None:
        """Draw the selection and the unfinished shape."""
        raise NotImplementedError

    def _extra_state(self) -> dict[str, Any]:
        """Return the entries of a draft other than the selection."""
        return {}

    # --- state -------------------------------------------------------------------------------
    @property
    def is_open(self) -> bool:
        """Whether a selection exists or a shape is being drawn."""
        return self._shape is not None or self.count > 0

    @property
    def is_finishing(self) -> bool:
        """Whether the selection will be used as soon as background work is complete."""
        return False

    @property
    def count(self) -> int:
        """Number of selected faces or points."""
        return 0 if self._selection is None else self._selection.count

    @property
    def selection(self) -> ElementSelection | None:
        """Current selection, or None if it is empty."""
        return self._selection if self.count else None

    @property
    def drawing(self) -> bool:
        """Whether a shape is being drawn."""
        return self._shape is not None

    @property
    def undo_label(self) -> str | None:
        if self._shape is not None:
            return tr("Corner") if self._shape.corners > 1 else None
        return None if self._selection is None else self._selection.last_step

    @property
    def redo_label(self) -> str | None:
        selection = None if self._shape is not None else self._selection
        return None if selection is None else selection.next_step

    def cancel_problem(self) -> Finding | None:
        return None if self.is_open else Finding("selection.empty")

    # --- settings ----------------------------------------------------------------------------
    def set_mode(self, mode: ElementMode) -> None:
        """Set the action of the next click or drag, and discard an unfinished shape."""
        self._shape = None
        self.mode = mode
        self._notify_change()

    def set_combine(self, combine: Combine) -> None:
        """Set how the next result is combined if no modifier key is pressed."""
        self.combine = combine
        self._notify_change()

    def set_select_through(self, is_through: bool) -> None:
        """Set whether shapes select hidden elements too."""
        self.is_through = is_through
        self._notify_change()

    # --- shapes ------------------------------------------------------------------------------
    def _draw(self, event: PointerEvent) -> None:
        """Draw a shape with the left button."""
        if event.kind is Pointer.MOVE:
            if self._shape is not None:
                self._shape.move(event)
                self._show_preview()
        elif event.button is not Button.LEFT:
            return
        elif event.kind in (Pointer.CLICK, Pointer.DOUBLE_CLICK):
            self._draw_click(event)
        elif event.kind is Pointer.DRAG_START:
            if self.mode == "polygon" and self._shape is not None:
                self._shape.corner(event)
            else:
                self._begin_shape(event)
            self._notify_change()
        elif self._shape is not None and event.kind is Pointer.DRAG_MOVE:
            self._shape.drag(event)
            if not event.has_more_steps:
                self._show_preview()
        elif self._shape is not None and event.kind is Pointer.DRAG_END:
            self._shape.drag(event)
            if self._shape.mode != "polygon":
                self._close_shape()

    def _draw_click(self, event: PointerEvent) -> None:
        if self.mode != "polygon":
            self._context.hint(Finding("selection.hold-button"))
            return
        if self._shape is None:
            self._begin_shape(event)
        elif self._shape.corner(event):
            self._close_shape()
            return
        self._notify_change()

    def _begin_shape(self, event: PointerEvent) -> None:
        if event.is_in_photo:
            self._context.hint(Finding("selection.not-in-photo"))
        elif self.mode != "pick":
            combination_mode = combination(event, self.combine)
            self._shape = DrawnShape(self.mode, combination_mode, (event.x, event.y))

    def _close_shape(self) -> None:
        """Close the shape if it is complete, and select the elements inside it."""
        shape = self._shape
        if shape is None:
            return
        if (reason := shape.close_problem()) is not None:
            self._context.hint(reason)
            return
        self._shape = None
        snapshot = self._context.elements.view_snapshot()
        if snapshot is not None:
            self._apply_shape(shape, snapshot)
        self._notify_change()

    def _apply_shape(self, shape: DrawnShape, snapshot: ViewSnapshot) -> None:
        """Select the elements inside a shape, on the model with most elements inside it."""
        selection_before, combination_mode = self._selection, shape.combine
        ids = self._models(combination_mode)
        masks = inside(self._context, snapshot, shape, ids, is_through=self.is_through)
        best_model_id = max(masks, key=lambda id_: int(np.count_nonzero(masks[id_])), default=None)
        if best_model_id is None:
            self._context.hint(Finding("selection.no-model"))
        elif not masks[best_model_id].any() and (
            selection_before is None or combination_mode in ("new", "add")
        ):
            self._context.hint(Finding("selection.nothing-inside", through=self.is_through))
        else:
            self.take(best_model_id, masks[best_model_id], combination_mode, tr(MODES[shape.mode]))

    def _models(self, combination: Combine) -> list[str]:
        """Return the ids of the visible models that a shape can select.

        Only the model of an existing selection is returned, unless the shape replaces it.
        """
        visible_ids = self._context.elements.shown()
        if self.selection is not None and combination != "new":
            return [id_ for id_ in visible_ids if id_ == self.selection.model_id]
        return visible_ids

    # --- selection ---------------------------------------------------------------------------
    def take(self, model_id: str, mask: BoolArray, combination: Combine, step: str) -> None:
        """Combine elements of a model with the selection; `step` is the label for undo."""
        selection = self._selection
        if selection is None or selection.model_id != model_id or len(selection.mask) != len(mask):
            if combination in ("subtract", "intersect"):
                self._context.hint(Finding("selection.empty"))
                return
            selection = ElementSelection(model_id, len(mask))
        hidden_elements = self._context.elements.hidden(model_id)
        if hidden_elements is not None:
            mask = mask & ~hidden_elements
        if not selection.change(combine_masks(selection.mask, mask, combination), step):
            self._context.hint(Finding("selection.no-change"))
            return
        self._selection = selection
        self._store_draft()
        self._notify_change()

    def adopt(self, selection: ElementSelection) -> None:
        """Continue with a selection of another tool."""
        self._selection = selection
        self._store_draft()
        self._notify_change()

    def release(self) -> ElementSelection | None:
        """Clear the selection and return it (None if empty), so that another tool can adopt it."""
        selection = self.selection
        self._discard_state()
        return selection

    def undo(self) -> bool:
        """Remove the last corner of the shape, or else undo the last step.

        Return False if no step can be undone.
        """
        if self._shape is not None:
            if not self._shape.remove_last_corner():
                self._shape = None
            self._notify_change()
            return True
        return self._selection is not None and self._finish_step(self._selection.undo())

    def redo(self) -> bool:
        """Redo the last undone step. Return False if no step can be redone."""
        return self._selection is not None and self._finish_step(self._selection.redo())

    def _finish_step(self, is_done: bool) -> bool:
        if is_done:
            self._store_draft()
            self._notify_change()
        return is_done

    # --- end ---------------------------------------------------------------------------------
    def cancel(self) -> None:
        """Discard the unfinished shape, or else the selection, which undo restores."""
        if self._shape is not None:
            self._shape = None
            self._notify_change()
        elif (selection := self.selection) is not None:
            self._discard_selection(selection, f"Discard the {self.noun}", lambda: None)

    def _discard_selection(
        self,
        selection: ElementSelection,
        label: str,
        back: Callable[[], None],
        sequence: int | None = None,
    ) -> None:
        self._discard_state()
        self._store_draft()
        selection.discard_undone_steps()

        def restore_work() -> bool:
            back()
            self.adopt(selection)
            return True

        untouched_mask = selection.mask
        self._context.report_discarded(
            DiscardedFeature(
                self.name,
                label,
                restore_work,
                lambda: (
                    self._selection is selection and np.array_equal(selection.mask, untouched_mask)
                ),
                sequence,
            )
        )

    def _discard_state(self) -> None:
        self._selection, self._shape = None, None
        self._preview.clear_state()
        self._notify_change()

    def leave(self) -> None:
        """Discard an unfinished shape; the selection remains."""
        self._shape = None
        self._notify_change()

    def clear_state(self) -> None:
        """Reset because the project is being closed; the selection remains as a draft."""
        self._selection, self._shape = None, None
        self._preview.clear_state()
        self._context.show(None)

    def set_type(self, type_id: str, set_name: str) -> None:
        """Do nothing, because elements have no type."""

    def document_changed(self) -> None:
        """Discard the selection if its model was removed."""
        selection = self._selection
        if selection is not None and selection.model_id not in self._context.session.records:
            self._discard_state()
            self._store_draft()

    # --- drafts ------------------------------------------------------------------------------
    def _store_draft(self) -> None:
        session, selection = self._context.session, self.selection
        elements = None if selection is None else selection.to_dict()
        state = None
        if elements is not None:
            state = {"tool": self.name, "chosen": elements, **self._extra_state()}
        if session.draft is not None and session.draft.state == state:
            return
        try:
            session.set_draft(state)
        except VomError as error:
            self._context.report(error)

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Restore a draft. Return False if it is not valid or its model was removed."""
        try:
            selection = ElementSelection.from_dict(state["chosen"])
        except (KeyError, TypeError, ValueError):
            return False
        if selection.model_id not in self._context.session.records:
            return False
        self._selection = selection
        self._notify_change()
        return True

    def _notify_change(self) -> None:
        self._show_preview()
        self._context.tool_changed()


def inside(
    context: ToolContext,
    snapshot: ViewSnapshot,
    shape: DrawnShape,
    model_ids: list[str],
    *,
    is_through: bool,
) -> dict[str, BoolArray]:
    """Return the elements (n,) of each model that are inside a shape.

    Parameters
    ----------
    context : ToolContext
    snapshot : ViewSnapshot
    shape : DrawnShape
    model_ids : list of str
    is_through : bool

    Returns
    -------
    dict of str to ndarray of bool
    """
    filled_ring = snapshot.outline_mask(shape.ring())
    elements, masks = context.elements, {}
    for model_id in model_ids:
        data = elements.data(model_id)
        model = get(context.session.records, model_id, Model)
        if data is not None and model is not None:
            masks[model_id] = snapshot.inside(
                data,
                transform.matrix(model.to_world),
                filled_ring,
                is_through=is_through,
                spacing=elements.spacing(model_id) * transform.scale_factor(model.to_world),
            )
    return masks


def combination(event: PointerEvent, default: Combine) -> Combine:
    """Return the combination by keys: Shift adds, Alt or Ctrl removes, both intersect.

    If none of these keys is pressed, `default` is returned.

    Parameters
    ----------
    event : PointerEvent
    default : Combine

    Returns
    -------
    Combine
    """
    is_removing = event.alt or event.ctrl
    if event.shift and is_removing:
        return "intersect"
    if event.shift:
        return "add"
    return "subtract" if is_removing else default
