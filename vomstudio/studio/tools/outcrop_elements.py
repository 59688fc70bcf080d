"""What the tools are told of the faces and points of the models, and how these are looked at."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from vomstudio.core.arrays import BoolArray

if TYPE_CHECKING:
    from vomstudio.core.findings import Finding
    from vomstudio.extraction.selection.neighbours import Neighbours
    from vomstudio.extraction.selection.visible_region import Looking
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh


class OutcropElements(Protocol):
    """Elements are the faces of a mesh or the points of a cloud, by their rows in the file."""

    def looking(self) -> Looking | None:
        """What is seen of the outcrop now; None where nothing is drawn."""

    def shown(self) -> list[str]:
        """The ids of the models that are open and shown."""

    def data(self, model_id: str) -> Mesh | PointCloud | None:
        """None where the model is not open."""

    def spacing(self, model_id: str) -> float:
        """Usual distance between neighbours, in the file's unit; 0 where it is not known."""

    def neighbours(self, model_id: str, then: Callable[[], None]) -> Neighbours | Finding | None:
        """Return the neighbour graph, or why it cannot be built.

        None while it is built in the background, after which `then` is called.
        """

    def hidden(self, model_id: str) -> BoolArray | None:
        """(n,) which are hidden; None where none is."""

    def hide(self, model_id: str, hidden: BoolArray | None) -> None:
        """Hide these and show all others; None shows everything."""

    def cut_out(self, model_id: str, mask: BoolArray) -> None:
        """Make a model of these, with their textures, in the background; the original stays."""
