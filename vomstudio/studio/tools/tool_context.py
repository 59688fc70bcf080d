"""The protocol of a tool, and of the context it works in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Protocol, TypeVar

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.geometry.brush import PaintSurface
from vomstudio.project.measurement_cache import Measurement
from vomstudio.project.records import Feature
from vomstudio.project.session import Session
from vomstudio.studio.tools.followed_line import PathFinder
from vomstudio.studio.tools.interaction_types import Discarded, PointerEvent, Preview
from vomstudio.studio.tools.outcrop_elements import OutcropElements

T = TypeVar("T")


class Tool(Protocol):
    """A state machine for gestures in the viewport. At most one tool is open at a time: it has an
    unfinished feature, which `finish` or `cancel` ends and which its draft restores.

    name : in drafts, and of its command and panel; paints : it draws with the left button, so that
    the right one orbits
    """

    name: ClassVar[str]
    paints: ClassVar[bool]

    @property
    def open(self) -> bool: ...

    @property
    def undo_label(self) -> str | None:
        """The step of the unfinished thing that `undo` would take back; None where there is
        none."""

    @property
    def redo_label(self) -> str | None:
        """The step that `redo` would bring again; None where there is none. Where undo took back
        the first step there still is one, though nothing is open any more."""

    def hint(self) -> str:
        """What the next click does, as a sentence for the status line."""

    def why_not_finish(self) -> Finding | None:
        """Return why `finish` cannot be called now; None if it can."""

    def why_not_cancel(self) -> Finding | None:
        """Return why `cancel` cannot be called now; None if it can."""

    def pointer(self, event: PointerEvent) -> None: ...

    def undo(self) -> bool:
        """Take the last step of the unfinished thing back; False where there is none."""

    def redo(self) -> bool:
        """Bring the step again that was taken back last; False where there is none."""

    def finish(self) -> str | None:
        """Keep it; the id of the feature, or None with the reason shown."""

    def cancel(self) -> None: ...

    def leave(self) -> None:
        """Another tool is chosen."""

    def document_changed(self) -> None:
        """The document has changed, perhaps by undo."""

    def forget(self) -> None:
        """The project is being closed; the unfinished feature is kept as a draft."""

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Continue a draft; False where it is not one of this tool or cannot be read."""

    def set_type(self, type_id: str, set_name: str) -> None:
        """Another feature type or set was chosen for the next feature."""


class ToolContext(Protocol):
    """The session and the models, as a tool sees them."""

    @property
    def session(self) -> Session: ...

    @property
    def next_type_id(self) -> str:
        """The feature type for what is made next."""

    @property
    def next_set(self) -> str:
        """The set for what is made next."""

    def set_next(self, type_id: str, set_name: str) -> None:
        """Another type and set for what is made next."""

    def surface(self, model_id: str) -> PaintSurface | None:
        """The surface of an open model; None while it is not loaded."""

    def aside(self, work: Callable[[], T], then: Callable[[T | None], object]) -> None:
        """Do what takes long beside the window; `then` is told its result in the caller's thread,
        later, or None where it failed, which the user is told."""

    @property
    def paths(self) -> PathFinder:
        """Finds the ways that lines follow over models."""

    @property
    def elements(self) -> OutcropElements:
        """The faces and points of the models that are shown, and how they are looked at."""

    def measure(self, feature: Feature) -> Measurement:
        """The live figures of a feature that is not in the document."""

    def format_attitude(self, measurement: Measurement) -> str:
        """The plane or line with its 95 % error, in the notation the user has chosen."""

    def show(self, preview: Preview | None) -> None:
        """Draw the unfinished feature, or nothing."""

    def say(self, message: Finding | VomError) -> None:
        """Report to the user what happened and what to do."""

    def hint(self, message: Finding) -> None:
        """Report why a click did nothing; the message disappears by itself."""

    def tool_changed(self) -> None:
        """The tool's state has changed: its panel and the commands are refreshed."""

    def discarded(self, discarded: Discarded) -> None:
        """The tool has let something unfinished go, which undo brings back."""

    def created(self, feature_id: str) -> None:
        """The tool has made or changed a feature, which becomes the selected one."""
