"""In what fractures are counted: window, circle, scanline, or what was looked at of a grid."""

from __future__ import annotations

from vomstudio.core.arrays import FloatArray
from vomstudio.core.words import tr
from vomstudio.geology.coverage.face_coverage import DONE, EMPTY
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

_GRID_IS = f"{GRID}:"


class CountedInBox(ComboBox):
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
        self._fixed = self.count()
        self.setCurrentIndex(1)

    def kind(self) -> str:
        """One of the words of `fracture_answer`."""
        chosen = str(self.currentData())
        return GRID if chosen.startswith(_GRID_IS) else chosen

    def list_grids(self) -> None:
        """Those of the project; the chosen one stays, or the window takes its place."""
        grids = {f"{_GRID_IS}{g.id}": g.name for g in self._studio.session.of(FaceGrid)}
        listed = {str(self.itemData(i)): self.itemText(i) for i in range(self._fixed, self.count())}
        titles = {key: tr("Looked at: {grid}", grid=name) for key, name in grids.items()}
        if listed == titles:
            return
        chosen = self.currentData()
        blocked = self.blockSignals(True)
        while self.count() > self._fixed:
            self.removeItem(self.count() - 1)
        for key, title in titles.items():
            self.addItem(title, key)
        at = self.findData(chosen)
        self.setCurrentIndex(at if at >= 0 else 1)
        self.blockSignals(blocked)
        if at < 0:
            self.currentIndexChanged.emit(self.currentIndex())

    def cells(self) -> GridCells | None:
        """Those of the chosen grid that were looked at and could be measured; None without one."""
        chosen = str(self.currentData())
        grid = get(self._studio.records, chosen.removeprefix(_GRID_IS), FaceGrid)
        if self.kind() != GRID or grid is None:
            return None
        corners: FloatArray
        _, corners = world_cells(grid, self._studio.records, DONE + EMPTY)
        _, whole = world_cells(grid, self._studio.records)
        return GridCells(grid.name, corners, whole[0])
