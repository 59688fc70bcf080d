"""Protocols of a tool and of its context."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, Protocol, TypeVar

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.project.measurement_cache import Measurement
from vomstudio.project.records import Feature
from vomstudio.project.session import Session
from vomstudio.studio.tools.element_selection import Combine
from vomstudio.studio.tools.followed_line import PathFinder
from vomstudio.studio.tools.interaction_types import DiscardedFeature, Hit, PointerEvent, Preview
from vomstudio.studio.tools.outcrop_elements import OutcropElements

T = TypeVar("T")


class Tool(Protocol):
    """State machine for gestures in the viewport.

    At most one tool is open at a time. An open tool has an unfinished feature, which is ended by
    `finish` or `cancel`, and which can be restored from its draft.

    Attributes
    ----------
    name : str
        Name of the tool in drafts, and of its command and panel.
    can_paint : bool
        Whether the tool draws with the left button, so that the right button orbits.
    is_finishing : bool
        Whether the open feature will be stored as soon as background work is complete.
    """

    name: ClassVar[str]
    can_paint: ClassVar[bool]

    @property
    def is_finishing(self) -> bool: ...

    @property
    def is_open(self) -> bool: ...

    @property
    def undo_label(self) -> str | None:
        """Label of the step that `undo` would revert, or None if no step can be undone."""

    @property
    def redo_label(self) -> str | None:
        """Label of the step that `redo` would repeat, or None if no step can be redone.

        It is still available after undo has reverted the first step, although the tool is not
        open any more.
        """

    def hint(self) -> str:
        """Describe the effect of the next click for the status line."""

    def finish_problem(self) -> Finding | None:
        """Return why `finish` cannot be called now, or None if it can."""

    def cancel_problem(self) -> Finding | None:
        """Return why `cancel` cannot be called now, or None if it can."""

    def pointer(self, event: PointerEvent) -> None: ...

    def undo(self) -> bool:
        """Undo the last step of the unfinished feature. Return False if no step can be undone."""

    def redo(self) -> bool:
        """Redo the last undone step. Return False if no step can be redone."""

    def finish(self) -> str | None:
        """Finish the feature and return its id, or show a message and return None."""

    def cancel(self) -> None: ...

    def leave(self) -> None:
        """Deactivate the tool."""

    def document_changed(self) -> None:
        """Handle a change of the document, including changes by undo."""

    def clear_state(self) -> None:
        """Reset because the project is being closed; an unfinished feature remains as a draft."""

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Restore a draft. Return False if it belongs to another tool or is not valid."""

    def set_type(self, type_id: str, set_name: str) -> None:
        """Set the feature type and set of the next feature."""


class ToolContext(Protocol):
    """Session and models, as provided to a tool."""

    @property
    def session(self) -> Session: ...

    @property
    def next_type_id(self) -> str:
        """Id of the feature type of the next feature."""

    @property
    def next_set(self) -> str:
        """Set of the next feature."""

    def set_next_type(self, type_id: str, set_name: str) -> None:
        """Set the feature type and set of the next feature."""

    def surface(self, model_id: str) -> SelectableSurface | None:
        """Return the surface of a model, or None while the model is not loaded."""

    def run_in_background(
        self, work: Callable[[], T], finished_callback: Callable[[T | None], object]
    ) -> None:
        """Run a long task in the background.

        `finished_callback` receives the result in the caller's thread. If the task has failed, it
        receives None after a message.
        """

    @property
    def paths(self) -> PathFinder:
        """Path finder for lines that follow a contact."""

    @property
    def elements(self) -> OutcropElements:
        """Faces and points of the visible models, and the view onto them."""

    def measure(self, feature: Feature) -> Measurement:
        """Measure a feature that is not part of the document."""

    def format_attitude(self, measurement: Measurement) -> str:
        """Format a plane or line with its 95 % error, in the user's notation."""

    def world_positions(self, hits: Sequence[Hit]) -> FloatArray:
        """Return the positions (k, 3) of hits in the World frame."""

    def feature_positions(self) -> dict[str, FloatArray]:
        """Return the centres (3,) of the visible features in the World frame, by id."""

    def select(self, feature_ids: Sequence[str], combination: Combine) -> None:
        """Combine features with the selected features."""

    def show(self, preview: Preview | None) -> None:
        """Draw the preview of an unfinished feature, or remove it if None."""

    def report(self, message: Finding | VomError) -> None:
        """Show a message to the user."""

    def hint(self, message: Finding) -> None:
        """Show why a click had no effect; the message disappears by itself."""

    def tool_changed(self) -> None:
        """Report a change of the tool's state, so that the panel and commands are updated."""

    def report_discarded(self, discarded_work: DiscardedFeature) -> None:
        """Report discarded work, which undo restores."""

    def report_created(self, feature_id: str) -> None:
        """Select a feature that the tool has created or changed."""
