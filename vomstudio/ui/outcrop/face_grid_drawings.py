"""Drawings of the cells of face grids on the surface, in the colours of their marks."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.coverage.cells import ExposedArea
from vomstudio.geology.coverage.face_coverage import EMPTY_MARK, INSPECTED_MARK, UNMEASURABLE_MARK
from vomstudio.project.edit import Edit
from vomstudio.project.grid_edits import grid_marks
from vomstudio.project.records import FaceGrid, Model, get
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.surfaces.face_grids import world_grid
from vomstudio.studio.tools.interaction_types import Area
from vomstudio.studio.tools.polyline import rgb
from vomstudio.ui.base.studio import Studio

COLORS = {INSPECTED_MARK: "#009e73", EMPTY_MARK: "#f0e442", UNMEASURABLE_MARK: "#202020"}
"""Green and yellow of the palette of Okabe and Ito, and near-black."""
_LINE_COLOR = "#ffffff"
_MAX_FILLED_TRIANGLES = 150_000
_MAX_DOTS = 20_000


class FaceGridDrawings:
    """Drawings of the grids whose models are open."""

    def __init__(self, studio: Studio, viewport: Viewport) -> None:
        self._studio, self._layer = studio, viewport.features
        self._drawn_keys: dict[str, set[str]] = {}
        studio.project_opened.connect(self._rebuild)
        studio.edited.connect(self._follow_edit)
        studio.visibility_changed.connect(self._update_visibility)
        studio.workspace.grids.changed.connect(self._redraw)
        self._rebuild()

    def _rebuild(self) -> None:
        for grid_id in list(self._drawn_keys):
            self._remove(grid_id)
        if self._studio.has_project:
            for grid in self._studio.workspace.grids.all():
                self._redraw(grid.id)

    def _follow_edit(self, edit: Edit) -> None:
        model_ids = {id_ for id_, r in edit.after.items() if isinstance(r, Model)}
        for id_, record in edit.after.items():
            if isinstance(record, FaceGrid):
                self._redraw(id_)
            elif isinstance(edit.before[id_], FaceGrid):
                self._remove(id_)
        for grid in self._studio.workspace.grids.all() if model_ids else ():
            if grid.model_id in model_ids:
                self._redraw(grid.id)

    def _update_visibility(self, ids: tuple[str, ...]) -> None:
        for grid in self._studio.workspace.grids.all():
            if {grid.id, grid.model_id, "models"} & set(ids):
                self._redraw(grid.id)

    def _remove(self, grid_id: str) -> None:
        keys = self._drawn_keys.pop(grid_id, set())
        if keys:
            self._layer.change(dict.fromkeys(keys))

    def _redraw(self, grid_id: str) -> None:
        studio = self._studio
        grid = get(studio.records, grid_id, FaceGrid)
        exposure = studio.workspace.grids.exposure(grid_id)
        model = None if grid is None else get(studio.records, grid.model_id, Model)
        if grid is None or model is None or exposure is None:
            self._remove(grid_id)
            return
        drawings = {drawing.id: drawing for drawing in self._create_drawings(grid, model, exposure)}
        removed_keys = self._drawn_keys.get(grid_id, set()) - drawings.keys()
        self._drawn_keys[grid_id] = set(drawings)
        self._layer.change({**dict.fromkeys(removed_keys), **drawings})

    def _create_drawings(
        self, grid: FaceGrid, model: Model, exposed_area: ExposedArea
    ) -> list[FeatureDrawing]:
        cells = world_grid(grid, model)
        axes = cells.cell * np.stack([cells.right, cells.up, cells.normal])
        empty_corners = np.zeros((0, 3, 3), np.float32)
        is_visible = self._studio.visible(grid.id) and self._studio.visible(grid.model_id)

        def drawing(key: str, color: str, area: Area) -> FeatureDrawing:
            return FeatureDrawing(
                key, np.zeros((0, 3)), None, rgb(color), "", cells.origin, is_visible, area
            )

        lines = (exposed_area.lines @ axes).astype(np.float32)
        drawings = []
        if len(lines):
            drawings.append(
                drawing(f"{grid.id}:lines", _LINE_COLOR, Area(cells.origin, empty_corners, lines))
            )
        marks = np.array(list(grid_marks(grid)))
        for mark, color in COLORS.items():
            is_marked = np.isin(exposed_area.cell, np.flatnonzero(marks == mark))
            if is_marked.any():
                corners = _thin_out(exposed_area.pieces[is_marked]) @ axes
                area = Area(cells.origin, corners.astype(np.float32), empty_corners[:, :2])
                drawings.append(drawing(f"{grid.id}:{mark}", color, area))
        return drawings


def _thin_out(pieces: FloatArray) -> FloatArray:
    """Return the triangles, or the centroids of a subset if there are too many triangles."""
    if len(pieces) <= _MAX_FILLED_TRIANGLES:
        return pieces
    return np.asarray(pieces[:: max(1, len(pieces) // _MAX_DOTS)].mean(axis=1))
