"""The pieces of models' surfaces that features are, as they are drawn: each is made once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from PySide6.QtCore import QObject

from vomstudio.document.records import Model, Painted, Picked
from vomstudio.geometry.brush import PaintSurface
from vomstudio.tools.interaction_types import Area
from vomstudio.tools.painted_area import area_of, enclosed_area
from vomstudio.ui.common.background_reading import Background
from vomstudio.ui.common.studio import Studio


@dataclass(frozen=True, eq=False)
class _Kept:
    """area : None where there is none, or where it is not known yet"""

    of: object
    to_world: object
    area: Area | None


class SurfacePieces:
    """redraw : told the id of a feature whose piece has become known"""

    def __init__(self, studio: Studio, owner: QObject, redraw: Callable[[str], None]) -> None:
        self._studio, self._redraw = studio, redraw
        self._background = Background(owner)
        self._kept: dict[str, _Kept] = {}

    def clear(self) -> None:
        self._kept.clear()

    def forget(self, id_: str) -> None:
        self._kept.pop(id_, None)

    def painted(self, patch: Painted) -> Area | None:
        """A painted piece of an open model."""
        found = self._open(patch.model_id)
        if found is None:
            return None
        model, surface = found
        kept = self._kept_of(patch.id, patch.runs, model)
        if kept is None:
            kept = self._keep(patch.id, patch.runs, model, area_of(patch, model, surface))
        return kept.area

    def enclosed(self, feature: Picked) -> Area | None:
        """What the outline of a feature encloses; it is looked for beside the window, and None
        until then."""
        found = self._open(feature.model_id)
        if found is None:
            return None
        model, surface = found
        kept = self._kept_of(feature.id, feature.vertices, model)
        if kept is None:
            kept = self._keep(feature.id, feature.vertices, model, None)
            ring = np.array(feature.vertices, np.float64)
            self._background.run(
                partial(enclosed_area, ring, model, surface), partial(self._came, feature.id, kept)
            )
        return kept.area

    def _open(self, model_id: str) -> tuple[Model, PaintSurface] | None:
        model, opened = self._studio.records.get(model_id), self._studio.models.get(model_id)
        if opened is None or not isinstance(model, Model):
            return None
        return model, opened.surface

    def _kept_of(self, id_: str, of: object, model: Model) -> _Kept | None:
        kept = self._kept.get(id_)
        return kept if kept and kept.of is of and kept.to_world == model.to_world else None

    def _keep(self, id_: str, of: object, model: Model, area: Area | None) -> _Kept:
        self._kept[id_] = kept = _Kept(of, model.to_world, area)
        return kept

    def _came(self, id_: str, asked: _Kept, area: object) -> None:
        if self._kept.get(id_) is not asked or not isinstance(area, Area):
            return
        self._kept[id_] = _Kept(asked.of, asked.to_world, area)
        self._redraw(id_)
