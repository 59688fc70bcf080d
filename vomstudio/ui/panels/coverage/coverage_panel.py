"""Panel for sampling grids on faces and their coverage."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QLineEdit, QPushButton

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import tr
from vomstudio.geology.coverage.face_coverage import FaceCoverage
from vomstudio.geometry.mesh import Mesh
from vomstudio.project import grid_edits
from vomstudio.project.records import FaceGrid, Model, get, get_feature
from vomstudio.studio.surfaces.face_grids import picked_lines
from vomstudio.studio.tools.cells import CellsTool
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, button_row, narrow_form, set_enabled
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.coverage.analysis import (
    CoverageRequest,
    GridRequest,
    compute_grid_coverage,
    create_face_grid,
    figures_html,
)
from vomstudio.ui.widgets.axis_titles import add_length_row
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.model_box import ModelBox
from vomstudio.ui.widgets.plane_field import PlaneField, ViewDirection
from vomstudio.ui.widgets.results_page import FiguresPage

_WHOLE_MODEL, _SELECTED_FEATURES = "model", "selected"


class CoveragePanel(AnalysisPanel[CoverageRequest, FaceCoverage]):
    """Panel for sampling grids on faces and their coverage."""

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__(studio, "looked_at", "fractures.md#coverage", tr("Counting…"))
        self._view = view
        self._is_creating = False
        self.model = ModelBox(studio)
        self.model.setObjectName("looked_at_model")
        self.extent = ComboBox()
        self.extent.setObjectName("looked_at_over")
        self.extent.addItem(tr("Whole model"), _WHOLE_MODEL)
        self.extent.addItem(tr("Selected features"), _SELECTED_FEATURES)
        self.plane = PlaneField(studio, "looked_at_plane", tr("current view"), view)
        self.cell = QLineEdit()
        self.cell.setObjectName("looked_at_cell")
        self.cell.setPlaceholderText(tr("1/8 of the face"))
        self.cell.setToolTip(tr("Side length of a cell."))
        self.create_button = QPushButton(theme.icon("grid"), tr("Create grid"))
        self.create_button.setToolTip(tr("Create a grid of square cells on the face."))
        self.grids = ComboBox()
        self.grids.setObjectName("looked_at_grid")
        self.grids.keep_narrow()
        self.mark = QPushButton(theme.icon("check"), tr("Mark cells"))
        self.mark.setCheckable(True)
        self.mark.setToolTip(tr("Click cells, or mark them with Q, W, X and Z."))
        self.remove = QPushButton(theme.icon("delete-outline"), tr("Remove grid"))
        self.remove.setToolTip(tr("Remove the grid with its marks. Undo restores it."))
        self.figures = FiguresPage(Finding("grid.not-begun").message)
        self.figures.setAccessibleName(tr("Coverage"))
        self._arrange_widgets()
        self._connect_signals()

    def _arrange_widgets(self) -> None:
        form = narrow_form()
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("Over"), self.extent)
        form.addRow(tr("Face"), self.plane)
        add_length_row(form, self._studio, lambda u: tr("Cell size ({unit})", unit=u), self.cell)
        grid_form = narrow_form()
        grid_form.addRow(tr("Grid"), self.grids)
        buttons = button_row(self.mark, self.remove)
        FormWithPicture.fill(
            self, form, self.create_button, grid_form, buttons, self.message, picture=self.figures
        )

    def _connect_signals(self) -> None:
        studio = self._studio
        self.create_button.clicked.connect(lambda _=False: self._create_grid())
        self.grids.activated.connect(self._schedule_refresh)
        self.mark.clicked.connect(self._set_marking)
        self.remove.clicked.connect(lambda _=False: self._remove())
        self.extent.activated.connect(lambda _: self._refresh())
        self.plane.changed.connect(self._refresh)
        self.cell.textChanged.connect(lambda _: self._refresh())
        studio.edited.connect(self._schedule_refresh)
        studio.model_loaded.connect(self._schedule_refresh)
        connect_until_deleted(self, studio.workspace.grids.changed, self._schedule_refresh)
        studio.selection_changed.connect(self._refresh)
        studio.active_tool_changed.connect(self._refresh)

    # --- display -----------------------------------------------------------------------------
    def _list_choices(self) -> None:
        self.model.list_models()
        self._list_grids()

    def _compute_result(self, request: CoverageRequest) -> FaceCoverage:
        return compute_grid_coverage(request)

    def _list_grids(self) -> None:
        grids = [(grid.name, grid.id) for grid in self._studio.workspace.grids.all()]
        items = [
            (self.grids.itemText(i), self.grids.itemData(i)) for i in range(self.grids.count())
        ]
        if items == grids:
            return
        previous_id, listed_ids = self.grids.currentData(), {id_ for _, id_ in items}
        new_ids = [id_ for _, id_ in grids if id_ not in listed_ids]
        with QSignalBlocker(self.grids):
            self.grids.clear()
            for name, id_ in grids:
                self.grids.addItem(name, id_)
            # A new grid becomes the selected one.
            selected_id = new_ids[-1] if new_ids else previous_id
            self.grids.setCurrentIndex(max(self.grids.findData(selected_id), 0) if grids else -1)

    def grid(self) -> FaceGrid | None:
        """Return the selected grid, or None if no grid is selected."""
        return get(self._studio.records, self.grids.currentData(), FaceGrid)

    def _create_request(self) -> CoverageRequest:
        studio, grid = self._studio, self.grid()
        if grid is None:
            raise InputError(Finding("grid.not-begun"))
        model = get(studio.records, grid.model_id, Model)
        exposure = studio.workspace.grids.exposure(grid.id)
        if exposure is None:
            is_open = grid.model_id in studio.models
            raise InputError(Finding("action.busy" if is_open else "model.not-open"))
        feature_ids = (
            [f.id for f in studio.session.features() if getattr(f, "model_id", "") == model.id]
            if model is not None
            else []
        )
        lines = picked_lines(studio.records, studio.measured(feature_ids), grid.model_id)
        return CoverageRequest(grid, model, exposure, lines)

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

    def _set_result(self, result: FaceCoverage | None, message: str) -> None:
        super()._set_result(result, "" if result is None else message)
        if result is None:
            self.figures.show_reason(message)
        else:
            self.figures.setHtml(figures_html(result, self._unit()))

    def _refresh(self) -> None:
        is_marking = self._studio.has_project and self._studio.tool_name == CellsTool.name
        set_enabled(self.create_button, self._creation_problem())
        missing_grid_finding = None if self.grid() is not None else Finding("action.no-grid")
        set_enabled(self.mark, missing_grid_finding)
        set_enabled(self.remove, missing_grid_finding)
        with QSignalBlocker(self.mark):
            self.mark.setChecked(is_marking and missing_grid_finding is None)

    def _creation_problem(self) -> Finding | None:
        if self.model.selected_model() is None:
            return Finding("action.no-model")
        if self._is_creating:
            return Finding("action.busy")
        if self.extent.currentData() == _SELECTED_FEATURES and not self._selected_ids():
            return Finding("action.no-feature")
        if (text := self.cell.text().strip()) and not ((parse_number(text) or 0.0) > 0.0):
            return Finding("grid.cell-size")
        try:
            self.plane.plane()
        except VomError as error:
            return cause_finding(error)
        return None

    # --- actions -----------------------------------------------------------------------------
    def _selected_ids(self) -> list[str]:
        records = self._studio.records
        return [i for i in self._studio.selection.ids if get_feature(records, i) is not None]

    def _create_grid(self) -> None:
        model, studio = self.model.selected_model(), self._studio
        if model is None or self._creation_problem() is not None:
            return
        data = studio.models[model.id].data
        points = data.vertices if isinstance(data, Mesh) else data.points
        is_world = self.extent.currentData() == _SELECTED_FEATURES
        if is_world:
            measurements = studio.measured(self._selected_ids()).values()
            lines = [extent_points(item) for item in measurements]
            points = np.concatenate([np.zeros((0, 3)), *(p for p in lines if len(p))])
        request = GridRequest(
            model=model,
            points=points,
            world=is_world,
            plane=self.plane.plane(),
            view=self._view() or (0.0, 0.0),
            cell_m=parse_number(self.cell.text()) if self.cell.text().strip() else None,
        )
        self._is_creating = True
        self._refresh()
        self._background.run(
            partial(create_face_grid, request), self._add_grid, self._report_failure
        )

    def _add_grid(self, grid: FaceGrid) -> None:
        self._is_creating = False
        self._studio.attempt(grid_edits.add_grid, grid)
        self._studio.activate(CellsTool.name)
        self._schedule_refresh()
        self._refresh()

    def _report_failure(self, error: VomError) -> None:
        self._is_creating = False
        self._studio.fail(error)
        self._schedule_refresh()
        self._refresh()

    def _set_marking(self, is_on: bool) -> None:
        self._studio.activate(CellsTool.name if is_on else "navigate")

    def _remove(self) -> None:
        if (grid := self.grid()) is not None:
            self._studio.attempt(grid_edits.remove_grid, grid.id)
