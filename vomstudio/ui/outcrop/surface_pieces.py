"""The pieces of models' surfaces that features are, as they are drawn: each is made once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from PySide6.QtCore import QObject

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.brush import PaintSurface
from vomstudio.project.records import Model, Painted, Picked
from vomstudio.studio.tools.interaction_types import Area
from vomstudio.studio.tools.painted_area import enclosed_area, patch_area
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio


@dataclass(frozen=True, eq=False)
class _Kept:
    """area : None where there is none, or where it is not known yet; outline : it is what an
    outline encloses"""

    of: object
    to_world: object
    area: Area | None
    outline: bool


class SurfacePieces:
    """redraw : told the id of a feature whose piece has become known"""

    def __init__(self, studio: Studio, owner: QObject, redraw: Callable[[str], None]) -> None:
        self._studio, self._redraw = studio, redraw
        self._background = QtBackground(owner)
        self._cache: dict[str, _Kept] = {}

    def clear(self) -> None:
        self._cache.clear()

    def remove(self, id_: str) -> None:
        self._cache.pop(id_, None)

    def painted_area(self, patch: Painted) -> Area | None:
        """A painted piece of an open model."""
        found = self._open(patch.model_id)
        if found is None:
            return None
        model, surface = found
        kept = self._cached(patch.id, patch.runs, model)
        if kept is None:
            area = patch_area(patch, model, surface)
            kept = self._cache[patch.id] = _Kept(patch.runs, model.to_world, area, False)
        return kept.area

    def outlined_area(self, feature: Picked) -> Area | None:
        """What the outline of a feature encloses; it is looked for beside the window, and None
        until then."""
        found = self._open(feature.model_id)
        if found is None:
            return None
        model, surface = found
        kept = self._cached(feature.id, feature.vertices, model)
        if kept is None:
            kept = _Kept(feature.vertices, model.to_world, None, True)
            self._cache[feature.id] = kept
            ring = np.array(feature.vertices, np.float64)
            self._background.run(
                partial(enclosed_area, ring, model, surface), partial(self._store, feature.id, kept)
            )
        return kept.area

    def find_enclosing(self, point: FloatArray) -> list[str]:
        """Ids of the features whose outline encloses a point of World on the surface, as far as
        they are known."""
        return [
            id_
            for id_, kept in self._cache.items()
            if kept.outline and kept.area is not None and _holds(kept.area, point)
        ]

    def _open(self, model_id: str) -> tuple[Model, PaintSurface] | None:
        model, opened = self._studio.records.get(model_id), self._studio.models.get(model_id)
        if opened is None or not isinstance(model, Model):
            return None
        return model, opened.surface

    def _cached(self, id_: str, of: object, model: Model) -> _Kept | None:
        kept = self._cache.get(id_)
        return kept if kept and kept.of is of and kept.to_world == model.to_world else None

    def _store(self, id_: str, asked: _Kept, area: object) -> None:
        if self._cache.get(id_) is not asked or not isinstance(area, Area):
            return
        self._cache[id_] = replace(asked, area=area)
        self._redraw(id_)


def _holds(area: Area, point: FloatArray) -> bool:
    """Whether a point of World lies on one of the triangles, to a thousandth of their extent."""
    corners = area.corners.astype(np.float64)
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    off = point - area.origin - a
    normal = np.cross(b, c)
    size = np.einsum("ij,ij->i", normal, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.einsum("ij,ij->i", np.cross(off, c), normal) / size
        t = np.einsum("ij,ij->i", np.cross(b, off), normal) / size
        away = np.abs(np.einsum("ij,ij->i", off, normal)) / np.sqrt(size)
    near = 1e-3 * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    return bool(((s >= -1e-6) & (t >= -1e-6) & (s + t <= 1 + 1e-6) & (away <= near)).any())
