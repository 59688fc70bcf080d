"""What a tool is given to work with."""

from __future__ import annotations

from typing import Protocol

from vomstudio.document.measurements import Measurement
from vomstudio.document.records import Trace
from vomstudio.document.session import Session
from vomstudio.geometry.surface import Surface
from vomstudio.tools.types import Preview


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

    def surface(self, model_id: str) -> Surface | None:
        """The surface of an open model; None while it is not loaded."""

    def measure(self, trace: Trace) -> Measurement:
        """The live fit of a trace that is not in the document."""

    def format_plane(self, measurement: Measurement) -> str:
        """The plane in the notation the user has chosen, with digits that follow its error."""

    def show(self, preview: Preview | None) -> None:
        """Draw the unfinished feature, or nothing."""

    def say(self, message: str) -> None:
        """Tell the user what happened to their thing and what to do."""

    def hint(self, message: str) -> None:
        """The same of a click that did nothing: not worth a message that stays."""

    def tool_changed(self) -> None:
        """The tool's state has changed: its panel and the actions look again."""

    def created(self, feature_id: str) -> None:
        """A feature has been made or changed by the tool, and wants to be the selected one."""
