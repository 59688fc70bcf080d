"""Dock that proposes traces for review: lines that exceed the noise of the surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtWidgets import (
    QFileDialog,
    QGridLayout,
    QPushButton,
    QSizePolicy,
)

from vomstudio.core.findings import Finding
from vomstudio.core.options import find_declaration, option_words
from vomstudio.core.words import tr
from vomstudio.extraction.trace_options import ONNX_COST, ProposalOptions
from vomstudio.geometry import transform
from vomstudio.project import catalogue
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Model
from vomstudio.studio.surfaces.trace_proposals import ProposedLines
from vomstudio.studio.tools.interaction_types import Area, Hit
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import results_folder, start_folder
from vomstudio.ui.base.controls import ComboBox, Label, create_row, file_field
from vomstudio.ui.base.number_formatting import format_error_deg
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.proposed_trace_drawings import MAX_P_VALUE, line_area
from vomstudio.ui.panels.surface.model_panel import MIN_WIDTH_PX, ProposalsPanel
from vomstudio.ui.panels.surface.trace_texts import reason_text, summary_text
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.copied_command import (
    CopyCommandButton,
    copy_command,
    find_model_arguments,
)
from vomstudio.ui.widgets.follow_box import field_costs
from vomstudio.ui.widgets.number_table import Column
from vomstudio.ui.widgets.options_form import OptionFields, fill_choices

_MIN_HEIGHT_PX = 130
# Maximum distance of a click from a line, as a multiple of the resolution.
_CLICK_TOLERANCE_PX = 8.0


class TracesPanel(ProposalsPanel):
    """Panel that proposes traces; the project changes only when traces are accepted."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(
            studio,
            studio.proposed_traces,
            "proposed",
            "conventions.md#proposed-traces",
            tr("Find lines"),
            "vector-polyline",
        )
        self._traces = studio.proposed_traces
        self._table_state: tuple[ProposedLines | None, frozenset[int]] = (None, frozenset())
        self._make_settings()
        self._create_decision_buttons()
        self._arrange_widgets()
        self._follow()

    # --- parts -------------------------------------------------------------------------------
    def _make_settings(self) -> None:
        start = ProposalOptions(cost=ProposalOptions().used_cost)
        self.limits = OptionFields(ProposalOptions, "proposed", start)
        self.limits.changed.connect(self._refresh_buttons)
        cost = self.limits.place("cost")
        assert isinstance(cost, ComboBox)
        self.cost = cost
        self._fields: tuple[str, ...] | None = None
        self.cost.currentIndexChanged.connect(lambda _: self._refresh_buttons())
        self.network, self._network_row = file_field(
            "proposed_network", tr("Choose…"), self._choose_network
        )
        self.network.setAccessibleName(tr("ONNX file"))
        self.network.setPlaceholderText(tr("ONNX file of a network"))
        self.network.setToolTip(
            tr("Network that computes edge probabilities (0 to 1) from an RGB picture.")
        )
        self.network.textChanged.connect(lambda _: self._refresh_buttons())
        self.copy = CopyCommandButton(
            self._copy_command, tr("the command for these lines, including rejected ones")
        )
        self.summary = hint_label()

    def _create_decision_buttons(self) -> None:
        self._make_list(
            (
                Column(
                    tr("Doubt"),
                    lambda v: f"{100 * v[0]:.0f} %",
                    tr(
                        "Probability that noise produces such a line (orange up to {sure:.0f} %).",
                        sure=100 * MAX_P_VALUE,
                    ),
                ),
                Column("m", lambda v: f"{v:.3g}", tr("Length.")),
                Column(tr("Plane"), str, tr("Dip direction and dip."), number=False),
                Column(
                    tr("95 % error"),
                    format_error_deg,
                    tr("95 % error of the plane."),
                ),
                Column("#", str, tr("Number; 1 is the strongest.")),
            ),
            tr("Proposed traces"),
            _MIN_HEIGHT_PX,
        )
        self.table.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
        self.edit = QPushButton(theme.icon("pencil"), tr("Edit"))
        self.edit.clicked.connect(lambda _: self._edit())
        self.clear_button = QPushButton(theme.icon("close-box-multiple-outline"), tr("Clear"))
        self.clear_button.clicked.connect(lambda _: self._traces.drop())
        self.restore = QPushButton(theme.icon("restore"), "")
        self.restore.setObjectName("proposed_forgive")
        self.restore.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.restore.setAccessibleName(tr("Restore rejected lines"))
        self.restore.clicked.connect(lambda _: self._restore_rejected())

    def _arrange_widgets(self) -> None:
        grid = QGridLayout()
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(3)
        grid.addWidget(Label(tr("Search for")), 0, 0)
        grid.addWidget(self.cost, 0, 1, 1, 3)
        self.limits.add_cells(grid, 1)
        row = grid.rowCount()
        grid.addWidget(self._network_row, row, 0, 1, 4)
        grid.addWidget(self.start, row + 1, 0, 1, 3)
        grid.addWidget(self.copy, row + 1, 3)
        grid.setColumnStretch(1, 1)
        grid.setColumnStretch(3, 1)
        # Wide buttons would widen the dock when traces are proposed.
        for part in (self.accept, self.edit, self.reject, self.clear_button, self.cost, self.type):
            part.setMinimumWidth(MIN_WIDTH_PX)
        self._decision_row = create_row(self.accept, self.edit, self.reject, self.clear_button)
        self._type_row = create_row(Label(tr("Accept as")), self.type, self.restore)
        column = narrow_column(self)
        column.addWidget(self.title)
        column.addLayout(grid)
        column.addWidget(self.progress)
        column.addWidget(self.summary)
        column.addWidget(self._decision_row)
        column.addWidget(self.filter)
        column.addWidget(self.filter.problem)
        column.addWidget(self.table, 1)
        column.addWidget(self.reason)
        column.addWidget(self._type_row)
        column.addStretch()

    # --- display -----------------------------------------------------------------------------
    def update_widgets(self) -> None:
        """Show the current model and its proposals."""
        super().update_widgets()
        self._list_costs()
        self._show_proposals()

    def _list_costs(self) -> None:
        open_model = None if self._model is None else self._studio.models.get(self._model.id)
        fields = () if open_model is None else tuple(sorted(open_model.data.fields))
        if fields == self._fields:
            return
        self._fields = fields
        fill_choices(self.cost, find_declaration(ProposalOptions, "cost"), field_costs(fields))

    def _disabled_reason(self) -> Finding | None:
        is_onnx = self._model is not None and self.cost.currentData() == ONNX_COST
        if is_onnx and not self.network.text().strip():
            return Finding("follow.no-network")
        return super()._disabled_reason()

    def _refresh_buttons(self) -> None:
        super()._refresh_buttons()
        traces = self._traces
        self._network_row.setVisible(self.cost.currentData() == ONNX_COST)
        self.copy.set_enabled(self._disabled_reason())
        rows = self._selection()
        no_selection = Finding("action.no-row")
        has_open_tool = self._studio.open_tool is not None
        for button, reason, tooltip in (
            (
                self.accept,
                None if rows else no_selection,
                tr("Accept the selected lines as traces (Enter)."),
            ),
            (
                self.edit,
                Finding("action.not-one-row")
                if len(rows) != 1
                else Finding("feature.open")
                if has_open_tool
                else None,
                tr("Edit the way-points of the selected line in the trace tool."),
            ),
            (
                self.reject,
                None if rows else no_selection,
                tr("Reject the selected lines, also in later searches (Delete)."),
            ),
            (
                self.clear_button,
                None if traces.proposals is not None else Finding("action.no-proposals"),
                tr("Clear the list without rejecting its lines."),
            ),
        ):
            button.setEnabled(reason is None)
            button.setToolTip(tooltip if reason is None else str(reason))
        count = 0 if self._model is None else traces.count_rejected(self._model.id)
        self.restore.setEnabled(count > 0)
        self.restore.setToolTip(
            tr("Propose the {count} rejected lines of this model again.", count=count)
            if count
            else str(Finding("action.nothing-rejected"))
        )

    # --- state -------------------------------------------------------------------------------
    def _create_options(self) -> ProposalOptions:
        is_onnx = self.cost.currentData() == ONNX_COST
        return self.limits.options(onnx_model=self.network.text().strip() if is_onnx else None)

    def _choose_network(self) -> None:
        name, _ = QFileDialog.getOpenFileName(
            self, tr("Network"), start_folder(self._studio), tr("ONNX files (*.onnx)")
        )
        if name:
            self.network.setText(name)

    def _start(self, model: Model) -> None:
        self._traces.find(model.id, self._create_options())

    def _copy_command(self) -> None:
        studio = self._studio
        model_arguments = None if self._model is None else find_model_arguments(studio, self._model)
        if model_arguments is None:
            return
        target = results_folder(studio) / "proposed_traces.csv"
        arguments = ["trace", *model_arguments, "--propose", *option_words(self._create_options())]
        copy_command(studio, [*arguments, ("-o", target), "--force"])

    # --- proposals ---------------------------------------------------------------------------
    def _show_proposals(self) -> None:
        proposals, open_indices = self._traces.proposals, self._traces.open_rows
        for part in (self.table, self._decision_row, self._type_row, self.filter):
            part.setVisible(proposals is not None)
        if (proposals, open_indices) != self._table_state:
            self._table_state = (proposals, open_indices)
            self._fill(proposals, open_indices)
        text = " ".join(map(str, self._traces.findings))
        if not text and proposals is not None:
            text = summary_text(proposals, len(open_indices))
        self.summary.setText(text)
        self.summary.setVisible(bool(text))
        self._refresh_buttons()

    def _fill(self, proposals: ProposedLines | None, open_indices: frozenset[int]) -> None:
        rows = []
        for row in sorted(open_indices) if proposals is not None else ():
            assert proposals is not None
            line = proposals.lines[row]
            plane = error = None
            if line.measured.plane is not None:
                plane = line.measured.attitude(self._studio.settings.notation, omit_hand_rule=True)
                error = catalogue.TOTAL_ERROR.value(self._studio.subject(line.trace, line.measured))
            rows.append((((line.doubt, row), line.length_m, plane, error, row + 1), ""))
        self._show_rows(rows)

    def _measured_feature(self, index: int) -> tuple[Feature, Measurement]:
        proposals = self._traces.proposals
        assert proposals is not None
        line = proposals.lines[index]
        return line.trace, line.measured

    def _highlight_area(self, indices: Sequence[int]) -> Area | None:
        proposals = self._traces.proposals
        if proposals is None:
            return None
        return line_area([proposals.lines[index].points for index in indices])

    def _reason_text(self, index: int) -> str:
        proposals = self._traces.proposals
        return "" if proposals is None else reason_text(proposals, proposals.lines[index])

    def _index_at(self, hit: Hit) -> int | None:
        """Return the index of the line nearest to a point, or None if it is too far away."""
        proposals, model = self._traces.proposals, self._model
        if proposals is None or model is None:
            return None
        point = transform.apply(model.to_world, [hit.position])[0]
        distances = {
            row: float(np.linalg.norm(proposals.lines[row].points - point, axis=1).min())
            for row in self._traces.open_rows
        }
        nearest_row = min(distances, key=lambda row: distances[row], default=None)
        if nearest_row is None:
            return None
        scale = transform.scale_factor(model.to_world)
        max_distance = (
            _CLICK_TOLERANCE_PX * scale * (proposals.lines[nearest_row].trace.resolution or 0.0)
        )
        return nearest_row if distances[nearest_row] <= max_distance else None

    # --- decision ----------------------------------------------------------------------------
    def _accept(self, indices: list[int]) -> bool:
        return bool(self._traces.accept(indices, str(self.type.currentData())))

    def _reject(self, indices: list[int]) -> bool:
        self._traces.reject(indices)
        return True

    def _edit(self) -> None:
        rows = self._selection()
        if len(rows) == 1:
            self._studio.preview.emit(None)
            self._studio.set_next_type(str(self.type.currentData()), self._studio.next_set)
            self._traces.edit(rows[0])

    def _restore_rejected(self) -> None:
        if self._model is not None:
            self._traces.restore_rejected(self._model.id)
