"""The dock of what was looked at: a grid over the face, and how far one has come in it."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QHBoxLayout, QLineEdit, QPushButton

from vomstudio.document import grid_edits
from vomstudio.document.records import FaceGrid, Model, get, get_feature
from vomstudio.errors import VomError
from vomstudio.geology.looked_at.shares import LookedAt
from vomstudio.geometry.mesh import Mesh
from vomstudio.tools.cells import CellsTool
from vomstudio.ui.analyse.seen_panel import SeenPanel
from vomstudio.ui.common import theme
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.number_formatting import drawn_points
from vomstudio.ui.common.qt_background import NewestResult, QtBackground
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.vertex_table import parse_number
from vomstudio.ui.common.widgets import ComboBox, narrow_form
from vomstudio.ui.forms.figures_page import FiguresPage
from vomstudio.ui.forms.form_beside import FormBeside
from vomstudio.ui.forms.model_axes import add_length_row
from vomstudio.ui.forms.model_box import ModelBox
from vomstudio.ui.forms.plane_field import PlaneField, ViewDirection
from vomstudio.ui.interpret.tool_panels.common import hint_label
from vomstudio.ui.sections.looked_at_answer import (
    NewGrid,
    ShareQuestion,
    answer,
    figures_html,
    lay,
)
from vomstudio.words import tr
from vomstudio.workspace.surfaces.face_grids import lines_on

_MODEL, _SELECTED = "model", "selected"


class LookedAtPanel(SeenPanel):
    """found : what is shown, None where there is none"""

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__(studio)
        explain(self, "fractures.md#what-was-looked-at")
        self._view = view
        self.found: LookedAt | None = None
        self._background = QtBackground(self)
        self._laying = False
        self._asked = NewestResult(
            self, self._came, self._studio.fail, lambda: self.said.setText(tr("Counting…"))
        )
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
        self.grids = ComboBox()
        self.grids.setObjectName("looked_at_grid")
        self.grids.keep_narrow()
        self.mark = QPushButton(theme.icon("check"), tr("Mark cells"))
        self.mark.setCheckable(True)
        self.remove = QPushButton(theme.icon("delete-outline"), tr("Remove grid"))
        self.said = hint_label()
        self.said.setObjectName("looked_at_said")
        self.figures = FiguresPage(_first_step())
        self.figures.setAccessibleName(tr("What was looked at"))
        self._arrange()
        self._connect()

    def _arrange(self) -> None:
        form = narrow_form()
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("Over"), self.over)
        form.addRow(tr("Face"), self.plane)
        add_length_row(form, self._studio, lambda u: tr("Cell ({unit})", unit=u), self.cell)
        body = FormBeside(self)
        column = body.column
        column.addLayout(form)
        column.addWidget(self.lay)
        chosen = narrow_form()
        chosen.addRow(tr("Grid"), self.grids)
        column.addLayout(chosen)
        buttons = QHBoxLayout()
        buttons.addWidget(self.mark)
        buttons.addWidget(self.remove)
        buttons.addStretch()
        column.addLayout(buttons)
        column.addWidget(self.said)
        body.put_beside(self.figures)

    def _connect(self) -> None:
        studio = self._studio
        self.lay.clicked.connect(lambda _=False: self._lay())
        self.grids.activated.connect(self._soon)
        self.mark.clicked.connect(self._mark)
        self.remove.clicked.connect(lambda _=False: self._remove())
        self.over.activated.connect(lambda _: self._refresh_buttons())
        self.plane.changed.connect(self._refresh_buttons)
        self.cell.textChanged.connect(lambda _: self._refresh_buttons())
        studio.project_opened.connect(self.cell.clear)
        studio.project_opened.connect(self._soon)
        studio.edited.connect(self._soon)
        studio.model_loaded.connect(self._soon)
        studio.workspace.grids.changed.connect(self._soon)
        studio.selection_changed.connect(lambda _: self._refresh_buttons())
        studio.active_tool_changed.connect(lambda _: self._refresh_buttons())
        studio.jobs.closed.connect(self._close)

    def _close(self) -> None:
        self._asked.close()
        self._background.stop()

    # --- what is shown -----------------------------------------------------------------------
    def show_now(self) -> None:
        if not self._studio.has_project:
            return
        self.model.list_models()
        self._list_grids()
        why = self._asked.answer(self._question(), answer)
        if why is not None:
            self.found = None
            self.said.clear()
            self.figures.say(why)
        self._refresh_buttons()

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

    def _question(self) -> ShareQuestion | str:
        """Or why there is none."""
        studio, grid = self._studio, self.grid()
        if grid is None:
            return _first_step()
        model = get(studio.records, grid.model_id, Model)
        exposed = studio.workspace.grids.exposed(grid.id)
        if exposed is None:
            if grid.model_id in studio.models:
                return tr("Counting…")
            return tr("The grid's model is not open, so its surface is not known.")
        own = [f.id for f in studio.session.features() if getattr(f, "model_id", "") == model.id] \
            if model is not None else []  # fmt: skip
        lines = lines_on(studio.records, studio.measured(own), grid.model_id)
        return ShareQuestion(grid, model, exposed, lines)

    def _came(self, made: object) -> None:
        assert isinstance(made, LookedAt)
        self.found = made
        grid = self.grid()
        model = None if grid is None else get(self._studio.records, grid.model_id, Model)
        unit = "m" if model is not None and model.frame.has_metres else tr("units")
        self.said.setText(
            tr("{cells} cells of {side:.3g} {unit} hold rock.", cells=made.cells,
               side=made.cell_m, unit=unit)
        )  # fmt: skip
        self.figures.setHtml(figures_html(made, unit))
        self._refresh_buttons()

    def _refresh_buttons(self) -> None:
        marking = self._studio.has_project and self._studio.tool_name == CellsTool.name
        _allow(self.lay, self._why_not_lay(), tr("Whole cells over the face, on the outcrop."))
        no_grid = None if self.grid() is not None else tr("Lay a grid first.")
        tip = tr("Click cells on the outcrop; Q, W, X and Z mark the one under the cursor.")
        _allow(self.mark, no_grid, tip)
        _allow(self.remove, no_grid, tr("Its marks go with it; undo brings them back."))
        with QSignalBlocker(self.mark):
            self.mark.setChecked(marking and no_grid is None)

    def _why_not_lay(self) -> str | None:
        if self.model.chosen_model() is None:
            return tr("Open a model first.")
        if self._laying:
            return tr("A grid is being laid.")
        if self.over.currentData() == _SELECTED and not self._selected():
            return tr("Select features that lie on the face first.")
        if (text := self.cell.text().strip()) and not ((parse_number(text) or 0.0) > 0.0):
            return tr("The side of a cell is a positive number.")
        try:
            self.plane.plane()
        except VomError as error:
            return error.message
        return None

    # --- what is done ------------------------------------------------------------------------
    def _selected(self) -> list[str]:
        records = self._studio.records
        return [i for i in self._studio.selection.ids if get_feature(records, i) is not None]

    def _lay(self) -> None:
        model, studio = self.model.chosen_model(), self._studio
        if model is None or self._why_not_lay() is not None:
            return
        data = studio.models[model.id].data
        points = data.vertices if isinstance(data, Mesh) else data.points
        in_world = self.over.currentData() == _SELECTED
        if in_world:
            measured = studio.measured(self._selected()).values()
            drawn = [drawn_points(one) for one in measured]
            points = np.concatenate([np.zeros((0, 3)), *(p for p in drawn if len(p))])
        asked = NewGrid(
            model, points, in_world, self.plane.plane(), self._view() or (0.0, 0.0),
            parse_number(self.cell.text()) if self.cell.text().strip() else None,
        )  # fmt: skip
        self._laying = True
        self._refresh_buttons()
        self._background.run(partial(lay, asked), self._laid, self._not_laid)

    def _laid(self, grid: FaceGrid) -> None:
        self._laying = False
        self._studio.attempt(grid_edits.add_grid, grid)
        self._studio.activate(CellsTool.name)
        self._soon()
        self._refresh_buttons()

    def _not_laid(self, error: VomError) -> None:
        self._laying = False
        self._studio.fail(error)
        self._soon()
        self._refresh_buttons()

    def _mark(self, on: bool) -> None:
        self._studio.activate(CellsTool.name if on else "navigate")

    def _remove(self) -> None:
        if (grid := self.grid()) is not None:
            self._studio.attempt(grid_edits.remove_grid, grid.id)


def _first_step() -> str:
    return tr("Lay a grid over the face, then mark its cells as you look through them.")


def _allow(button: QPushButton, why_not: str | None, tip: str) -> None:
    button.setEnabled(why_not is None)
    button.setToolTip(tip if why_not is None else tr("Not now: {reason}", reason=why_not))
