"""Combo box for the sampling region: window, circle, scanline or inspected grid cells."""

from __future__ import annotations

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.coverage.face_coverage import EMPTY_MARK, INSPECTED_MARK
from vomstudio.project.records import FaceGrid, get
from vomstudio.project.tables.grid_layer import world_cells
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.fractures.analysis import (
    CIRCLE,
    EVERYTHING,
    GRID,
    SCANLINE,
    WINDOW,
    GridCells,
)

_GRID_PREFIX = f"{GRID}:"


class RegionBox(ComboBox):
    """Combo box that selects the kind of sampling region, or a grid of the project."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.setObjectName("fracture_counted_in")
        for name, title in (
            (EVERYTHING, tr("No window")),
            (WINDOW, tr("Window")),
            (CIRCLE, tr("Circle")),
            (SCANLINE, tr("Scanline")),
        ):
            self.addItem(title, name)
        self._fixed_count = self.count()
        self.setCurrentIndex(1)

    def kind(self) -> str:
        """Return one of `EVERYTHING`, `WINDOW`, `CIRCLE`, `SCANLINE` and `GRID`."""
        data = str(self.currentData())
        return GRID if data.startswith(_GRID_PREFIX) else data

    def list_grids(self) -> None:
        """List the grids of the project; if the selected grid is missing, select the window."""
        grids = {f"{_GRID_PREFIX}{g.id}": g.name for g in self._studio.session.of(FaceGrid)}
        shown_titles = {
            str(self.itemData(i)): self.itemText(i) for i in range(self._fixed_count, self.count())
        }
        titles = {key: tr("Coverage: {grid}", grid=name) for key, name in grids.items()}
        if shown_titles == titles:
            return
        previous_key = self.currentData()
        was_blocked = self.blockSignals(True)
        while self.count() > self._fixed_count:
            self.removeItem(self.count() - 1)
        for key, title in titles.items():
            self.addItem(title, key)
        index = self.findData(previous_key)
        self.setCurrentIndex(index if index >= 0 else 1)
        self.blockSignals(was_blocked)
        if index < 0:
            self.currentIndexChanged.emit(self.currentIndex())

    def cells(self) -> GridCells | None:
        """Return the inspected cells of the selected grid, or None if no grid is selected."""
        data = str(self.currentData())
        grid = get(self._studio.records, data.removeprefix(_GRID_PREFIX), FaceGrid)
        if self.kind() != GRID or grid is None:
            return None
        corners: FloatArray
        _, corners = world_cells(grid, self._studio.records, INSPECTED_MARK + EMPTY_MARK)
        _, all_corners = world_cells(grid, self._studio.records)
        return GridCells(grid.name, corners, all_corners[0])
