"""What the tools are told of the faces and points of the models, and how these are looked at."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from vomstudio.extraction.selecting.looking import Looking
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh

Mask = npt.NDArray[np.bool_]


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
