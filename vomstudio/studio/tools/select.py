"""Tool that selects faces or points to create a patch or a new model.

The tool is a state machine without Qt or VTK. The selection belongs to one model and is
unfinished until Enter converts it to a patch or Esc discards it. Both can be undone, and every
change of the selection is a step that can be undone. A shape that is drawn over the picture
selects the elements inside (the centroids of faces), and includes hidden elements only on
request.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import BoolArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry import transform
from vomstudio.project import edits
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.element_selection import Combine, ElementSelection, combine_masks
from vomstudio.studio.tools.growth import Growth, Seed
from vomstudio.studio.tools.interaction_types import Button, Discarded, Pointer, PointerEvent
from vomstudio.studio.tools.screen_shape import DrawnShape
from vomstudio.studio.tools.select_changes import SelectChanges
from vomstudio.studio.tools.select_preview import SelectPreview
from vomstudio.studio.tools.selection_messages import (
    HINTS,
    STEPS,
    SelectMode,
    empty_shape_finding,
    selection_text,
)
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import ToolEntry

if TYPE_CHECKING:
    from vomstudio.extraction.selection.visible_region import ViewSnapshot

MAX_PATCH_ELEMENTS = 2_000_000


class SelectTool:
    """Tool that selects faces or points; see the module.

    Attributes
    ----------
    growth : Growth
        Growth of the selection from a click.
    changes : SelectChanges
        Other changes of the selection.
    mode : SelectMode
        Action of a click or drag.
    combine : Combine
        How the result is combined with the selection.
    through : bool
        Whether shapes also select hidden elements.
    """

    name = "select"
    paints = True

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.mode: SelectMode = "grow"
        self.combine: Combine = "new"
        self.through = False
        self._selection: ElementSelection | None = None
        self.growth = Growth(context)
        self.changes = SelectChanges(self, context)
        self._shape: DrawnShape | None = None
        self._preview = SelectPreview(context)

    # --- state -------------------------------------------------------------------------------
    @property
    def open(self) -> bool:
        """Whether a selection exists or a shape is being drawn."""
        return self._shape is not None or self.count > 0

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

    @property
    def measurement(self) -> Measurement | None:
        """Measurement of the plane through the selection, or None if the selection is too large."""
        return self._preview.measurement(self.selection)

    def hint(self) -> str:
        if self._shape is not None:
            return self._shape.hint()
        return tr(HINTS[self.mode]) + " " + selection_text(self.count)

    def why_not_finish(self) -> Finding | None:
        if self._shape is not None:
            return self._shape.why_not_close()
        return None if self.count else Finding("selection.empty")

    def why_not_cancel(self) -> Finding | None:
        return None if self.open else Finding("selection.empty")

    # --- settings ----------------------------------------------------------------------------
    def set_mode(self, mode: SelectMode) -> None:
        """Set the action of the next click or drag, and discard an unfinished shape."""
        self._shape = None
        self.mode = mode
        self._changed()

    def set_combine(self, combine: Combine) -> None:
        """Set how the next result is combined if neither Shift nor Ctrl is pressed."""
        self.combine = combine
        self._changed()

    def set_tolerance(
        self, *, angle_deg: float | None = None, distance: float | None = None
    ) -> None:
        """Set the tolerances of growth, in degrees and metres."""
        if angle_deg is not None:
            self.growth.set_angle(angle_deg)
        if distance is not None:
            self.growth.set_distance(distance)
        self.regrow()

    def set_through(self, through: bool) -> None:
        """Set whether shapes select hidden elements too."""
        self.through = through
        self._changed()

    # --- gestures ----------------------------------------------------------------------------
    def pointer(self, event: PointerEvent) -> None:
        """Draw shapes with the left button; see `Tool`."""
        if self._shape is not None and event.kind is Pointer.MOVE:
            self._shape.move(event)
            self._show()
            return
        if event.kind is Pointer.WHEEL:
            self.turn(event.turns, distance=event.shift)
            return
        if event.button is not Button.LEFT:
            return
        if event.kind in (Pointer.CLICK, Pointer.DOUBLE_CLICK):
            self._click(event)
        elif event.kind is Pointer.DRAG_START:
            self._press(event)
        elif event.kind is Pointer.DRAG_MOVE and self._shape is not None:
            self._shape.drag(event)
            if not event.more:
                self._show()
        elif event.kind is Pointer.DRAG_END and self._shape is not None:
            self._shape.drag(event)
            if self._shape.mode != "polygon":
                self._close()

    def _click(self, event: PointerEvent) -> None:
        if self.mode == "grow":
            self._grow(event)
        elif self.mode == "polygon":
            if self._shape is None:
                self._begin(event)
            elif self._shape.corner(event):
                self._close()
                return
            self._changed()
        else:
            self._context.hint(Finding("selection.hold-button"))

    def _press(self, event: PointerEvent) -> None:
        if self.mode == "grow":
            # This is a click with a small movement.
            self._grow(event)
            return
        if self.mode == "polygon" and self._shape is not None:
            self._shape.corner(event)
        else:
            self._begin(event)
        self._changed()

    def _grow(self, event: PointerEvent) -> None:
        if event.hit is None:
            self._context.hint(Finding("tool.no-surface"))
            return
        how = combination(event, self.combine)
        if (
            self.selection is not None
            and how != "new"
            and event.hit.model_id != self.selection.model_id
        ):
            self._context.hint(Finding("tool.other-model"))
            return
        self.growth.seed = None
        self._grow_from(Seed(event.hit, how))

    def _grow_from(self, seed: Seed) -> None:
        piece = self.growth.piece(seed.hit, lambda: self._grow_from(seed))
        if piece is not None:
            self.take(seed.hit.model_id, piece.mask, seed.how, tr(STEPS["grow"]))
            self.growth.seed = seed

    def turn(self, turns: float, *, distance: bool) -> None:
        """Change a tolerance by notches of the wheel."""
        self.growth.turn(turns, distance=distance)
        self.regrow()

    def regrow(self) -> None:
        """Repeat the last growth with the new tolerance."""
        seed, selection = self.growth.seed, self._selection
        if seed is not None and selection is not None and selection.last_step is not None:
            piece = self.growth.piece(seed.hit, lambda: None)
            if piece is not None:
                selection.change_last(combine_masks(selection.before_last(), piece.mask, seed.how))
                self._keep_draft()
        self._changed()

    def _begin(self, event: PointerEvent) -> None:
        if event.in_photo:
            self._context.hint(Finding("selection.not-in-photo"))
            return
        how = combination(event, self.combine)
        self._shape = DrawnShape(self.mode, how, (event.x, event.y))

    def _close(self) -> None:
        """Select the elements inside the shape."""
        shape, self._shape = self._shape, None
        looking = self._context.elements.looking()
        if shape is None or looking is None:
            return
        selection_before, how = self._selection, shape.combine
        ids = self._models(how)
        masks = inside(self._context, looking, shape, ids, through=self.through)
        best = max(masks, key=lambda id_: int(np.count_nonzero(masks[id_])), default=None)
        if best is None:
            self._context.hint(Finding("selection.no-model"))
        elif not masks[best].any() and (selection_before is None or how in ("new", "add")):
            self._context.hint(empty_shape_finding(through=self.through))
        else:
            self.take(best, masks[best], how, tr(STEPS[shape.mode]))
        self._changed()

    def _models(self, how: Combine) -> list[str]:
        """Return the ids of the models to search; an existing selection restricts them."""
        visible_ids = self._context.elements.shown()
        if self.selection is not None and how != "new":
            return [id_ for id_ in visible_ids if id_ == self.selection.model_id]
        return visible_ids

    def take(self, model_id: str, mask: BoolArray, how: Combine, step: str) -> None:
        """Select elements of a model; `step` is the label of the step."""
        selection = self._selection
        if selection is None or selection.model_id != model_id or len(selection.mask) != len(mask):
            if how in ("subtract", "intersect"):
                self._context.hint(Finding("selection.empty"))
                return
            selection = ElementSelection(model_id, len(mask))
        self.growth.seed = None
        hidden = self._context.elements.hidden(model_id)
        if hidden is not None:
            mask = mask & ~hidden
        if not selection.change(combine_masks(selection.mask, mask, how), step):
            self._context.hint(Finding("selection.no-change"))
            return
        self._selection = selection
        self._keep_draft()
        self._changed()

    # --- start and end ------------------------------------------------------------------------
    def undo(self) -> bool:
        """Remove the last corner of the shape, or else undo the last step."""
        if self._shape is not None:
            if not self._shape.take_back():
                self._shape = None
            self._changed()
            return True
        return self._selection is not None and self._stepped(self._selection.undo())

    def redo(self) -> bool:
        """Redo the last undone step."""
        return self._selection is not None and self._stepped(self._selection.redo())

    def _stepped(self, done: bool) -> bool:
        self.growth.seed = None
        if done:
            self._keep_draft()
            self._changed()
        return done

    def finish(self) -> str | None:
        """Close the unfinished shape, or else convert the selection to a patch."""
        if self._shape is not None:
            if (reason := self._shape.why_not_close()) is not None:
                self._context.hint(reason)
            else:
                self._close()
            return None
        selection = self.selection
        if selection is None:
            return None
        if selection.count > MAX_PATCH_ELEMENTS:
            self._context.report(
                Finding("selection.too-many", count=selection.count, maximum=MAX_PATCH_ELEMENTS)
            )
            return None
        patch = self._preview.patch(selection)
        if patch is None:
            self._context.report(Finding("model.not-open", model=selection.model_id))
            return None
        session = self._context.session
        top_before = session.top
        try:
            added = edits.add_features(session.records, [patch])
            session.apply(added, finishes_draft=session.draft is not None)
        except VomError as error:
            self._context.report(error)
            return None
        # Undo removes the patch, and the next undo restores the selection.
        self._discard(selection, "Let go of what was chosen", lambda: None, after=top_before)
        self._context.created(patch.id)
        return patch.id

    def cancel(self) -> None:
        """Discard the unfinished shape, or else the selection, which undo restores."""
        if self._shape is not None:
            self._shape = None
            self._changed()
            return
        selection = self.selection
        if selection is None:
            return
        self._discard(selection, "Discard what was chosen", lambda: None)

    def hide_selected(self) -> None:
        """Hide the selection; undo shows and selects it again."""
        selection, elements = self.selection, self._context.elements
        if selection is None:
            return
        model_id, hidden_before = selection.model_id, elements.hidden(selection.model_id)
        elements.hide(
            model_id, selection.mask if hidden_before is None else selection.mask | hidden_before
        )
        self._discard(
            selection, "Hide what was chosen", lambda: elements.hide(model_id, hidden_before)
        )

    def _discard(
        self,
        selection: ElementSelection,
        label: str,
        back: Callable[[], None],
        after: int | None = None,
    ) -> None:
        self._drop()
        self._keep_draft()
        selection.settle()

        def bring_back() -> bool:
            back()
            self._selection = selection
            self._keep_draft()
            self._changed()
            return True

        untouched = selection.mask
        self._context.discarded(
            Discarded(
                self.name,
                label,
                bring_back,
                lambda: self._selection is selection and np.array_equal(selection.mask, untouched),
                after,
            )
        )

    def _drop(self) -> None:
        self._selection, self._shape, self.growth.seed = None, None, None
        self._preview.forget()
        self._changed()

    def leave(self) -> None:
        """Discard an unfinished shape; the selection remains."""
        self._shape = None
        self._changed()

    def forget(self) -> None:
        """Reset because the project is being closed; the selection remains as a draft."""
        self._selection, self._shape, self.growth.seed = None, None, None
        self._preview.forget()
        self._context.show(None)

    def set_type(self, type_id: str, set_name: str) -> None:
        """Set the feature type and set of the patch that `finish` will create."""
        self._preview.forget_measurement()
        if self.open:
            self._show()

    def document_changed(self) -> None:
        """Discard the selection if its model was removed."""
        selection = self._selection
        if selection is not None and selection.model_id not in self._context.session.records:
            self._drop()
            self._keep_draft()

    # --- drafts ------------------------------------------------------------------------------
    def _keep_draft(self) -> None:
        selection = self.selection
        state = None if selection is None else selection.to_dict()
        try:
            self._context.session.set_draft(
                None if state is None else {"tool": self.name, "chosen": state}
            )
        except VomError as error:
            self._context.report(error)

    def restore(self, state: Mapping[str, Any]) -> bool:
        try:
            selection = ElementSelection.from_dict(state["chosen"])
        except (KeyError, TypeError, ValueError):
            return False
        if selection.model_id not in self._context.session.records:
            return False
        self._selection = selection
        self._changed()
        return True

    # --- preview ------------------------------------------------------------------------------
    def _changed(self) -> None:
        self._show()
        self._context.tool_changed()

    def _show(self) -> None:
        self._preview.show(self.selection, self._shape)


def inside(
    context: ToolContext,
    looking: ViewSnapshot,
    shape: DrawnShape,
    model_ids: list[str],
    *,
    through: bool,
) -> dict[str, BoolArray]:
    """Return the elements (n,) of each model that are inside a shape."""
    filled = looking.filled(shape.ring())
    elements, masks = context.elements, {}
    for model_id in model_ids:
        data = elements.data(model_id)
        model = get(context.session.records, model_id, Model)
        if data is not None and model is not None:
            masks[model_id] = looking.inside(
                data,
                transform.matrix(model.to_world),
                filled,
                through=through,
                spacing=elements.spacing(model_id) * transform.scale_factor(model.to_world),
            )
    return masks


def combination(event: PointerEvent, usual: Combine) -> Combine:
    """Return the combination: Shift adds, Ctrl subtracts, both intersect, or the default."""
    if event.shift and event.ctrl:
        return "intersect"
    if event.shift:
        return "add"
    return "subtract" if event.ctrl else usual


TOOL = ToolEntry(
    SelectTool,
    label=to_translate("&Select"),
    icon="lasso",
    key="S",
    tip=to_translate(
        "Choose faces or points by growing from a click, or by drawing around them; for a patch, "
        "to hide them, or to cut them out."
    ),
    order=25,
    takes_keys=True,
)
