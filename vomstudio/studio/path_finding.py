"""Path searches on open models, run in a worker thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.extraction.path_costs import COLOUR_COSTS, COST_NAMES
from vomstudio.geometry.mesh import Mesh
from vomstudio.studio.background import Background
from vomstudio.studio.models import Models
from vomstudio.studio.photo_path_finding import PhotoPaths
from vomstudio.studio.photos import ModelPhotos
from vomstudio.studio.tools.followed_line import FollowedPath, PathCallback
from vomstudio.studio.tools.interaction_types import Point

if TYPE_CHECKING:
    from vomstudio.extraction.surface_graph import SurfaceGraph

_LIVE_KEY = "live"


@dataclass(frozen=True, eq=False)
class _Search:
    """Request for a path. It is live if it ends at the cursor or a dragged vertex."""

    data: Any
    cost: str
    ends: tuple[Point, Point]
    is_live: bool
    photo: str
    photos: ModelPhotos | None


class PathFinding:
    """Path finder that computes one path at a time and caches the graph of the last model.

    Parameters
    ----------
    background : Background
        Background that has a single thread.
    """

    def __init__(
        self,
        models: Models,
        background: Background,
        get_photos: Callable[[str], ModelPhotos | None] = lambda model_id: None,
    ) -> None:
        self._models, self._background, self._get_photos = models, background, get_photos
        self._photo_paths = PhotoPaths()
        self._graph: SurfaceGraph | None = None

    def costs(self, model_id: str) -> tuple[str, ...]:
        """Return the names of the available costs; see `studio.tools.followed_line.PathFinder`."""
        open_model = self._models.open_models.get(model_id)
        data = None if open_model is None else open_model.data
        is_coloured = data is not None and (
            data.colors is not None
            or (
                isinstance(data, Mesh)
                and data.uv is not None
                and any(m.texture is not None for m in data.materials)
            )
        )
        return (
            COST_NAMES
            if is_coloured
            else tuple(cost for cost in COST_NAMES if cost not in COLOUR_COSTS)
        )

    def follow(
        self,
        model_id: str,
        cost: str,
        ends: tuple[Point, Point],
        *,
        photo: str = "",
        is_live: bool,
        callback: PathCallback,
    ) -> None:
        """Request a path; see `studio.tools.followed_line.PathFinder`."""
        open_model = self._models.open_models.get(model_id)
        photos = self._get_photos(model_id) if photo else None
        data = None if open_model is None else open_model.data
        search = _Search(data, cost, ends, is_live, photo, photos)
        # A new search for the cursor replaces the one for its previous position.
        self._background.run(
            partial(self._find_path, search),
            callback,
            lambda error: callback(to_finding(error)),
            key=_LIVE_KEY if is_live else None,
        )

    def clear_state(self) -> None:
        """Discard all searches and the graph because another project is opened."""
        self._background.cancel_all()
        self._graph = None
        self._photo_paths = PhotoPaths()

    # --- in the thread -----------------------------------------------------------------------
    def _find_path(self, search: _Search) -> FollowedPath:
        if search.data is None:
            raise InputError(Finding("model.not-open"))
        if search.photos is None:
            return self._find_surface_path(search)
        ends = np.asarray(search.ends)
        try:
            return self._photo_paths.find_path(
                search.photos, search.photo, search.cost, ends, is_live=search.is_live
            )
        except VomError as error:
            # If the photo gives no path, the path over the surface is returned with the reason. A
            # path to the cursor is replaced when the cursor moves.
            path = self._find_surface_path(search)
            return replace(path, warnings=(to_finding(error),), is_final=not search.is_live)

    def _find_surface_path(self, search: _Search) -> FollowedPath:
        from vomstudio.extraction.following import Follower
        from vomstudio.extraction.surface_graph import SurfaceGraph

        graph = self._graph
        if graph is None or graph.data is not search.data:
            graph = SurfaceGraph(search.data)
            graph.prepare()
            self._graph = graph
        path = Follower(graph, search.cost).follow(np.asarray(search.ends))
        return FollowedPath(path.points, costs=path.costs)
