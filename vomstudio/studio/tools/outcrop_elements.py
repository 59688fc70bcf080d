"""Faces and points of the models, as provided to the tools."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from vomstudio.core.arrays import BoolArray

if TYPE_CHECKING:
    from vomstudio.core.findings import Finding
    from vomstudio.extraction.selection.neighbours import NeighbourGraph
    from vomstudio.extraction.selection.visible_region import ViewSnapshot
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh


class OutcropElements(Protocol):
    """Access to elements: the faces of a mesh or points of a cloud, by row in the file."""

    def view_snapshot(self) -> ViewSnapshot | None:
        """Return the current view of the outcrop, or None if nothing is drawn."""

    def shown(self) -> list[str]:
        """Return the ids of the open and visible models."""

    def data(self, model_id: str) -> Mesh | PointCloud | None:
        """Return the data of a model, or None if the model is not open."""

    def spacing(self, model_id: str) -> float:
        """Return the typical spacing of neighbours in the unit of the file, or 0 if unknown."""

    def neighbours(
        self, model_id: str, finished_callback: Callable[[], None]
    ) -> NeighbourGraph | Finding | None:
        """Return the neighbour graph, or why it cannot be built.

        Returns None while the graph is built in the background; `finished_callback` is called
        afterwards.
        """

    def hidden(self, model_id: str) -> BoolArray | None:
        """Return which elements (n,) are hidden, or None if all are visible."""

    def hide(self, model_id: str, is_hidden: BoolArray | None) -> None:
        """Hide exactly the marked elements; None shows all."""

    def cut_out(self, model_id: str, mask: BoolArray) -> None:
        """Create a model of the marked elements in the background; the original remains."""
