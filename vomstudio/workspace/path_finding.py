"""Paths over open models, searched for in a thread of their own."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import VomError
from vomstudio.extraction.path_costs import COSTS, OF_COLOURS
from vomstudio.failures import exception_hooks
from vomstudio.geometry.mesh import Mesh
from vomstudio.tools.followed_line import Answer, Way
from vomstudio.tools.interaction_types import Point
from vomstudio.words import tr
from vomstudio.workspace.models import Models
from vomstudio.workspace.photo_path_finding import PhotoPaths
from vomstudio.workspace.photos import ModelPhotos

if TYPE_CHECKING:
    from vomstudio.extraction.surface_graph import SurfaceGraph

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Wanted:
    data: Any
    cost: str
    ends: tuple[Point, Point]
    live: bool
    answer: Answer
    photo: str = ""
    photos: ModelPhotos | None = None


class PathFinding:
    """The thread lives while there is something to search for. The graph of the model that was
    searched last is kept."""

    def __init__(
        self,
        models: Models,
        hand_over: Callable[[Callable[[], object]], object],
        photos_of: Callable[[str], ModelPhotos | None] = lambda model_id: None,
    ) -> None:
        self._models, self._hand_over, self._photos_of = models, hand_over, photos_of
        self._in_photos = PhotoPaths()
        self._wanted: deque[_Wanted] = deque()
        self._lock = threading.Lock()
        self._running = False
        self._surface: SurfaceGraph | None = None

    def costs(self, model_id: str) -> tuple[str, ...]:
        """As `tools.followed_line.PathFinder` has it."""
        opened = self._models.open.get(model_id)
        data = None if opened is None else opened.data
        coloured = data is not None and (
            data.colors is not None
            or (isinstance(data, Mesh) and data.uv is not None
                and any(m.texture is not None for m in data.materials))
        )  # fmt: skip
        return COSTS if coloured else tuple(cost for cost in COSTS if cost not in OF_COLOURS)

    def follow(
        self,
        model_id: str,
        cost: str,
        ends: tuple[Point, Point],
        *,
        photo: str = "",
        live: bool,
        answer: Answer,
    ) -> None:
        """As `tools.followed_line.PathFinder` has it."""
        opened = self._models.open.get(model_id)
        if opened is None:
            said = tr("The model is not loaded, so nothing can be followed on it.")
            self._hand_over(lambda: answer(said))
            return
        with self._lock:
            if live:
                # The cursor has moved on.
                self._wanted = deque(w for w in self._wanted if not w.live)
            photos = self._photos_of(model_id) if photo else None
            self._wanted.append(_Wanted(opened.data, cost, ends, live, answer, photo, photos))
            if self._running:
                return
            self._running = True
        threading.Thread(target=self._run, name="path finding", daemon=True).start()

    def forget(self) -> None:
        """Another project is opened: nothing is waited for, and no graph is kept."""
        with self._lock:
            self._wanted.clear()
            self._surface = None
            self._in_photos = PhotoPaths()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._wanted:
                    self._running = False
                    return
                wanted = self._wanted.popleft()
            found = self._found(wanted)
            self._hand_over(lambda w=wanted, f=found: w.answer(f))  # type: ignore[misc]

    def _found(self, wanted: _Wanted) -> Way | str:
        try:
            if wanted.photos is None:
                return self._over_surface(wanted)
            return self._in_photo(wanted, wanted.photos)
        except VomError as error:
            return str(error)
        except Exception as error:  # noqa: BLE001 - shown like every unexpected error
            exception_hooks.report_as_uncaught(error)
            return tr("The path could not be found.")

    def _in_photo(self, wanted: _Wanted, photos: ModelPhotos) -> Way:
        """Over the surface where the photo cannot say, with the reason."""
        ends = np.asarray(wanted.ends)
        try:
            return self._in_photos.way(photos, wanted.photo, wanted.cost, ends, live=wanted.live)
        except VomError as error:
            way = self._over_surface(wanted)
            return replace(way, said=str(error), final=not wanted.live)

    def _over_surface(self, wanted: _Wanted) -> Way:
        from vomstudio.extraction.following import Follower
        from vomstudio.extraction.surface_graph import SurfaceGraph

        surface = self._surface
        if surface is None or surface.data is not wanted.data:
            surface = SurfaceGraph(wanted.data)
            surface.prepare()
            with self._lock:
                self._surface = surface
        path = Follower(surface, wanted.cost).follow(np.asarray(wanted.ends))
        return Way(path.points, costs=path.costs)
