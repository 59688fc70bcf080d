"""The dock of what was looked at: a grid over the face, and how far one has come in it."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QLineEdit, QPushButton

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr
from vomstudio.geology.coverage.face_coverage import FaceCoverage
from vomstudio.geometry.mesh import Mesh
from vomstudio.project import grid_edits
from vomstudio.project.records import FaceGrid, Model, get, get_feature
from vomstudio.studio.surfaces.face_grids import picked_lines
from vomstudio.studio.tools.cells import CellsTool
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, allow, button_row, narrow_form
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.coverage.analysis import (
    NewGrid,
    ShareQuestion,
    answer,
    figures_html,
    lay,
)
from vomstudio.ui.widgets.axis_titles import add_length_row
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.model_box import ModelBox
from vomstudio.ui.widgets.plane_field import PlaneField, ViewDirection
from vomstudio.ui.widgets.results_page import FiguresPage
from vomstudio.ui.widgets.vertex_table import parse_number

_MODEL, _SELECTED = "model", "selected"


class LookedAtPanel(AnalysisPanel[ShareQuestion, FaceCoverage]):
    """Panel of grids over faces, and of their coverage."""

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__(studio, "looked_at", "fractures.md#what-was-looked-at", tr("Counting…"))
        self._view = view
        self._laying = False
        self.model = ModelBox(studio)
        self.model.setObjectName("looked_at_model")
        self.over = ComboBox()
        self.over.setObjectName("looked_at_over")
        self.over.addItem(tr("All of the model"), _MODEL)
        self.over.addItem(tr("The selected features"), _SELECTED)
        self.plane = PlaneField(studio, "looked_at_plane", tr("as it is looked at now"), view)
        self.cell = QLineEdit()
        self.cell.setObjectName("looked_at_cell")
        self.cell.setPlaceholderText(tr("an eighth of the face"))
        self.cell.setToolTip(tr("The side of a cell."))
        self.lay = QPushButton(theme.icon("grid"), tr("Lay grid"))
        self.lay.setToolTip(tr("Whole cells over the face, on the outcrop."))
        self.grids = ComboBox()
        self.grids.setObjectName("looked_at_grid")
        self.grids.keep_narrow()
        self.mark = QPushButton(theme.icon("check"), tr("Mark cells"))
        self.mark.setCheckable(True)
        self.mark.setToolTip(
            tr("Click cells on the outcrop; Q, W, X and Z mark the one under the cursor.")
        )
        self.remove = QPushButton(theme.icon("delete-outline"), tr("Remove grid"))
        self.remove.setToolTip(tr("Its marks go with it; undo brings them back."))
        self.figures = FiguresPage(Finding("grid.not-begun").message)
        self.figures.setAccessibleName(tr("What was looked at"))
        self._arrange()
        self._connect()

    def _arrange(self) -> None:
        form = narrow_form()
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("Over"), self.over)
        form.addRow(tr("Face"), self.plane)
        add_length_row(form, self._studio, lambda u: tr("Cell ({unit})", unit=u), self.cell)
        chosen = narrow_form()
        chosen.addRow(tr("Grid"), self.grids)
        buttons = button_row(self.mark, self.remove)
        FormWithPicture.fill(
            self, form, self.lay, chosen, buttons, self.message, picture=self.figures
        )

    def _connect(self) -> None:
        studio = self._studio
        self.lay.clicked.connect(lambda _=False: self._lay())
        self.grids.activated.connect(self._soon)
        self.mark.clicked.connect(self._mark)
        self.remove.clicked.connect(lambda _=False: self._remove())
        self.over.activated.connect(lambda _: self._refresh())
        self.plane.changed.connect(self._refresh)
        self.cell.textChanged.connect(lambda _: self._refresh())
        studio.project_opened.connect(self.cell.clear)
        studio.project_opened.connect(self._soon)
        studio.edited.connect(self._soon)
        studio.model_loaded.connect(self._soon)
        studio.workspace.grids.changed.connect(self._soon)
        studio.selection_changed.connect(lambda _: self._refresh())
        studio.active_tool_changed.connect(lambda _: self._refresh())

    # --- what is shown -----------------------------------------------------------------------
    def _list(self) -> None:
        self.model.list_models()
        self._list_grids()

    def _answer(self, question: ShareQuestion) -> FaceCoverage:
        return answer(question)

    def _list_grids(self) -> None:
        there = [(grid.name, grid.id) for grid in self._studio.workspace.grids.all()]
        shown = [
            (self.grids.itemText(i), self.grids.itemData(i)) for i in range(self.grids.count())
        ]
        if shown == there:
            return
        kept, known = self.grids.currentData(), {id_ for _, id_ in shown}
        new = [id_ for _, id_ in there if id_ not in known]
        with QSignalBlocker(self.grids):
            self.grids.clear()
            for name, id_ in there:
                self.grids.addItem(name, id_)
            # What was laid just now is meant.
            wanted = new[-1] if new else kept
            self.grids.setCurrentIndex(max(self.grids.findData(wanted), 0) if there else -1)

    def grid(self) -> FaceGrid | None:
        """The chosen one."""
        return get(self._studio.records, self.grids.currentData(), FaceGrid)

    def _question(self) -> ShareQuestion:
        studio, grid = self._studio, self.grid()
        if grid is None:
            raise InputError(Finding("grid.not-begun"))
        model = get(studio.records, grid.model_id, Model)
        exposed = studio.workspace.grids.exposed(grid.id)
        if exposed is None:
            is_open = grid.model_id in studio.models
            raise InputError(Finding("action.busy" if is_open else "model.not-open"))
        own = (
            [f.id for f in studio.session.features() if getattr(f, "model_id", "") == model.id]
            if model is not None
            else []
        )
        lines = picked_lines(studio.records, studio.measured(own), grid.model_id)
        return ShareQuestion(grid, model, exposed, lines)

    def _result_text(self, result: FaceCoverage) -> str:
        return tr(
            "{cells} cells of {side:.3g} {unit} contain rock.",
            cells=result.cells,
            side=result.cell_m,
            unit=self._unit(),
        )

    def _unit(self) -> str:
        grid = self.grid()
        model = None if grid is None else get(self._studio.records, grid.model_id, Model)
        return "m" if model is not None and model.frame.has_metres else tr("units")

    def _show(self, result: FaceCoverage | None, message: str) -> None:
        super()._show(result, "" if result is None else message)
        if result is None:
            self.figures.show_reason(message)
        else:
            self.figures.setHtml(figures_html(result, self._unit()))

    def _refresh(self) -> None:
        marking = self._studio.has_project and self._studio.tool_name == CellsTool.name
        allow(self.lay, self._why_not_lay())
        no_grid = None if self.grid() is not None else Finding("action.no-grid")
        allow(self.mark, no_grid)
        allow(self.remove, no_grid)
        with QSignalBlocker(self.mark):
            self.mark.setChecked(marking and no_grid is None)

    def _why_not_lay(self) -> Finding | None:
        if self.model.selected_model() is None:
            return Finding("action.no-model")
        if self._laying:
            return Finding("action.busy")
        if self.over.currentData() == _SELECTED and not self._selected():
            return Finding("action.no-feature")
        if (text := self.cell.text().strip()) and not ((parse_number(text) or 0.0) > 0.0):
            return Finding("grid.cell-size")
        try:
            self.plane.plane()
        except VomError as error:
            return cause_of(error)
        return None

    # --- what is done ------------------------------------------------------------------------
    def _selected(self) -> list[str]:
        records = self._studio.records
        return [i for i in self._studio.selection.ids if get_feature(records, i) is not None]

    def _lay(self) -> None:
        model, studio = self.model.selected_model(), self._studio
        if model is None or self._why_not_lay() is not None:
            return
        data = studio.models[model.id].data
        points = data.vertices if isinstance(data, Mesh) else data.points
        in_world = self.over.currentData() == _SELECTED
        if in_world:
            measured = studio.measured(self._selected()).values()
            drawn = [extent_points(one) for one in measured]
            points = np.concatenate([np.zeros((0, 3)), *(p for p in drawn if len(p))])
        asked = NewGrid(
            model,
            points,
            in_world,
            self.plane.plane(),
            self._view() or (0.0, 0.0),
            parse_number(self.cell.text()) if self.cell.text().strip() else None,
        )
        self._laying = True
        self._refresh()
        self._background.run(partial(lay, asked), self._laid, self._not_laid)

    def _laid(self, grid: FaceGrid) -> None:
        self._laying = False
        self._studio.attempt(grid_edits.add_grid, grid)
        self._studio.activate(CellsTool.name)
        self._soon()
        self._refresh()

    def _not_laid(self, error: VomError) -> None:
        self._laying = False
        self._studio.fail(error)
        self._soon()
        self._refresh()

    def _mark(self, on: bool) -> None:
        self._studio.activate(CellsTool.name if on else "navigate")

    def _remove(self) -> None:
        if (grid := self.grid()) is not None:
            self._studio.attempt(grid_edits.remove_grid, grid.id)
