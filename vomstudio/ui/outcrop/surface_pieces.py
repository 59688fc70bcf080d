"""Cache of the surface areas of painted and outlined features, for drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from PySide6.QtCore import QObject

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.project.records import Model, PaintedFeature, PickedFeature
from vomstudio.studio.tools.interaction_types import Area
from vomstudio.studio.tools.painted_area import enclosed_area, patch_area
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio


@dataclass(frozen=True, eq=False)
class _CachedArea:
    """Cached area of a feature.

    Attributes
    ----------
    source : object
        Runs or vertices from which the area was computed.
    area : Area or None
        Area, or None if it is empty or not computed yet.
    is_outline : bool
        Whether the area is enclosed by an outline.
    """

    source: object
    to_world: object
    area: Area | None
    is_outline: bool


class SurfacePieces:
    """Cache that computes the area of each feature once.

    Parameters
    ----------
    redraw : callable
        Called with the id of a feature after its area was computed.
    """

    def __init__(self, studio: Studio, owner: QObject, redraw: Callable[[str], None]) -> None:
        self._studio, self._redraw = studio, redraw
        self._background = QtBackground(owner)
        self._cache: dict[str, _CachedArea] = {}

    def clear(self) -> None:
        self._cache.clear()

    def remove(self, id_: str) -> None:
        self._cache.pop(id_, None)

    def painted_area(self, patch: PaintedFeature) -> Area | None:
        """Return the area of a patch, or None if it is empty or its model is not open."""
        open_model = self._find_open_model(patch.model_id)
        if open_model is None:
            return None
        model, surface = open_model
        cached_area = self._cached_area(patch.id, patch.runs, model)
        if cached_area is None:
            area = patch_area(patch, model, surface)
            cached_area = self._cache[patch.id] = _CachedArea(
                patch.runs, model.to_world, area, False
            )
        return cached_area.area

    def outlined_area(self, feature: PickedFeature) -> Area | None:
        """Return the area that the outline of a feature encloses.

        The area is computed in a worker thread. None is returned until it is available, and if the
        model is not open.
        """
        open_model = self._find_open_model(feature.model_id)
        if open_model is None:
            return None
        model, surface = open_model
        cached_area = self._cached_area(feature.id, feature.vertices, model)
        if cached_area is None:
            cached_area = _CachedArea(feature.vertices, model.to_world, None, True)
            self._cache[feature.id] = cached_area
            ring = np.array(feature.vertices, np.float64)
            self._background.run(
                partial(enclosed_area, ring, model, surface),
                partial(self._store_area, feature.id, cached_area),
            )
        return cached_area.area

    def find_enclosing(self, point: FloatArray) -> list[str]:
        """Return the ids of outlined features whose computed area contains a World point."""
        return [
            id_
            for id_, cached_area in self._cache.items()
            if cached_area.is_outline
            and cached_area.area is not None
            and _contains(cached_area.area, point)
        ]

    def _find_open_model(self, model_id: str) -> tuple[Model, SelectableSurface] | None:
        model, open_model = self._studio.records.get(model_id), self._studio.models.get(model_id)
        if open_model is None or not isinstance(model, Model):
            return None
        return model, open_model.surface

    def _cached_area(self, id_: str, source: object, model: Model) -> _CachedArea | None:
        cached_area = self._cache.get(id_)
        return (
            cached_area
            if cached_area
            and cached_area.source is source
            and cached_area.to_world == model.to_world
            else None
        )

    def _store_area(self, id_: str, request: _CachedArea, area: object) -> None:
        if self._cache.get(id_) is not request or not isinstance(area, Area):
            return
        self._cache[id_] = replace(request, area=area)
        self._redraw(id_)


def _contains(area: Area, point: FloatArray) -> bool:
    """Return whether a World point is on a triangle, within 0.1 % of the extent of the area."""
    corners = area.corners.astype(np.float64)
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    offset = point - area.origin - a
    normal = np.cross(b, c)
    size = np.einsum("ij,ij->i", normal, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.einsum("ij,ij->i", np.cross(offset, c), normal) / size
        t = np.einsum("ij,ij->i", np.cross(b, offset), normal) / size
        distance = np.abs(np.einsum("ij,ij->i", offset, normal)) / np.sqrt(size)
    tolerance = 1e-3 * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    return bool(((s >= -1e-6) & (t >= -1e-6) & (s + t <= 1 + 1e-6) & (distance <= tolerance)).any())
