"""Dock that proposes nearly planar facets of the outcrop for review."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QTimer
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QPushButton,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.extraction.facet_options import DEFAULT_ANGLE_DEG, FacetOptions
from vomstudio.geology.plane_matching import compare_proposals
from vomstudio.geometry.patches import has_id
from vomstudio.geometry.units import Axes
from vomstudio.project import catalogue
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Model
from vomstudio.studio.surfaces.facet_proposals import Proposals
from vomstudio.studio.tools.interaction_types import Area, Hit
from vomstudio.studio.tools.painted_area import merge_areas, patch_area
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, Label, create_row
from vomstudio.ui.base.number_formatting import area as area_text
from vomstudio.ui.base.number_formatting import format_error_deg
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.measured_planes import measured_planes, oriented_planes
from vomstudio.ui.panels.surface.facet_texts import (
    agreement_text,
    share_text,
    summary_text,
)
from vomstudio.ui.panels.surface.facets_command import copy_facets
from vomstudio.ui.panels.surface.model_panel import MIN_WIDTH_PX, ProposalsPanel
from vomstudio.ui.panels.surface.visible_part import find_visible_part
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit, project_axes
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.number_table import Column
from vomstudio.ui.widgets.options_form import OptionFields

_LIVE_DELAY_MS = 350
_MIN_HEIGHT_PX = 200
_VERDICT_RANKS = {"good": 0, "doubtful": 1, "poor": 2, None: 3}
_VERDICTS = {
    "good": to_translate("good"),
    "doubtful": to_translate("doubtful"),
    "poor": to_translate("poor"),
}
_COLOURS = {
    "label": to_translate("Colours by facet"),
    "dip direction": to_translate("Colours by dip direction"),
    "error": to_translate("Colours by 95 % error"),
    "exposure": to_translate("Colours by exposure"),
}


class FacetsPanel(ProposalsPanel):
    """Panel that proposes facets; the project changes only when facets are accepted."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(
            studio,
            studio.facets,
            "facet",
            "conventions.md#proposed-facets",
            tr("Find on model"),
            "vector-polygon",
        )
        self._facets = studio.facets
        self._table_state: tuple[Proposals | None, int] = (None, 0)
        self._live_timer = QTimer(self, singleShot=True, interval=_LIVE_DELAY_MS)
        self._live_timer.timeout.connect(self._search_visible_part)
        self._create_limit_fields()
        self._create_decision_buttons()
        self._arrange_widgets()
        self._follow()

    # --- parts -------------------------------------------------------------------------------
    def _create_limit_fields(self) -> None:
        self.limits = OptionFields(FacetOptions, "facet", FacetOptions(angle_deg=DEFAULT_ANGLE_DEG))
        self.limits.changed.connect(self._limits_changed)
        follow_axes(self, self._studio, self._show_axes)
        self.preview_box = QCheckBox(tr("Preview in view"))
        self.preview_box.setObjectName("facet_live")
        self.preview_box.setToolTip(tr("Show the effect of thresholds in the middle of the view."))
        self.preview_box.clicked.connect(lambda on: self._live_timer.start() if on else None)
        self.copy = CopyCommandButton(
            lambda: copy_facets(self._studio, self._model, self.limits.options()),
            tr("the command for these facets"),
        )
        self.summary, self.message = hint_label(), hint_label()
        self.message.setObjectName("facet_message")

    def _create_decision_buttons(self) -> None:
        self.colours = ComboBox()
        self.colours.setObjectName("facet_colours")
        for key, text in _COLOURS.items():
            self.colours.addItem(tr(text), key)
        self.colours.keep_narrow()
        self.colours.activated.connect(lambda _: self._paint())
        self._make_list(
            (
                Column(
                    tr("Quality"),
                    _verdict_text,
                    tr("Quality of the facet, the most doubtful first."),
                    number=False,
                    icon=_verdict_icon,
                ),
                Column(
                    tr("95 % error"),
                    format_error_deg,
                    tr("95 % error of the plane."),
                ),
                Column(
                    tr("Plane"), str, tr("Orientation, in the project's notation."), number=False
                ),
                Column(tr("Area"), self._area_text, tr("Area of the facet.")),
                Column("#", lambda v: f"{v}", tr("Number; 1 is the largest.")),
            ),
            tr("Proposed facets"),
            _MIN_HEIGHT_PX,
            is_descending=True,
        )
        self.accept_all = QPushButton(tr("Accept all"))
        self.accept_all.setIcon(theme.icon("check-all"))
        self.accept_all.clicked.connect(lambda _: self._decide(self._accept, self.listed_indices()))
        self.reject_all = QPushButton(tr("Reject all"))
        self.reject_all.setIcon(theme.icon("close-box-multiple-outline"))
        self.reject_all.clicked.connect(lambda _: self._facets.drop())

    def _show_axes(self, axes: Axes) -> None:
        self.limits.show_unit(length_unit(axes))

    def _area_text(self, value: float) -> str:
        return area_text(value, 2, is_metric=project_axes(self._studio).metric)

    def _arrange_widgets(self) -> None:
        limits = QGridLayout()
        limits.setContentsMargins(0, 0, 0, 0)
        limits.setSpacing(3)
        self.limits.add_cells(limits)
        self.start.setMinimumWidth(MIN_WIDTH_PX)
        limits.addWidget(create_row(self.start, self.copy), len(self.limits.fields) // 2, 2, 1, 2)
        limits.setColumnStretch(1, 1)
        limits.setColumnStretch(3, 1)
        # Wide buttons would widen the dock when facets are proposed.
        for part in (self.accept, self.reject, self.accept_all, self.reject_all):
            part.setMinimumWidth(MIN_WIDTH_PX)
        for combo in (self.colours, self.type):
            combo.setMinimumWidth(MIN_WIDTH_PX)
        self._options_row = create_row(self.colours, Label(tr("as")), self.type)
        self._decision_row = create_row(self.accept, self.reject, self.accept_all, self.reject_all)
        column = narrow_column(self)
        column.addWidget(self.title)
        column.addLayout(limits)
        column.addWidget(self.preview_box)
        column.addWidget(self.progress)
        column.addWidget(self.summary)
        # The row is above the buttons, so that the user sees the feature type before accepting all.
        column.addWidget(self._options_row)
        column.addWidget(self._decision_row)
        column.addWidget(self.filter)
        column.addWidget(self.filter.problem)
        column.addWidget(self.table, 1)
        column.addWidget(self.reason)
        column.addWidget(self.message)
        column.addStretch()

    # --- display -----------------------------------------------------------------------------
    def update_widgets(self) -> None:
        """Show the current model and its proposals."""
        super().update_widgets()
        self._show_proposals()

    def _refresh_buttons(self) -> None:
        super()._refresh_buttons()
        self.copy.set_enabled(self._disabled_reason())
        proposals, selection = self._facets.proposals, self._selection()
        no_selection = Finding("action.no-row")
        for button, is_enabled, tooltip, reason in (
            (
                self.accept,
                bool(selection),
                tr("Accept the selected facets as patches (Enter)."),
                no_selection,
            ),
            (
                self.reject,
                bool(selection),
                tr("Reject the selected facets (Delete)."),
                no_selection,
            ),
            (
                self.accept_all,
                bool(self.table.numbers.rowCount()),
                tr("Accept all listed facets in one step."),
                Finding("facets.none-open"),
            ),
            (
                self.reject_all,
                proposals is not None,
                tr("Discard all proposed facets without changes."),
                Finding("action.no-proposals"),
            ),
        ):
            button.setEnabled(is_enabled)
            button.setToolTip(tooltip if is_enabled else str(reason))
        if proposals is not None and not proposals.is_whole_model:
            self.accept_all.setToolTip(tr("Accept all listed facets of the part in view."))

    # --- state -------------------------------------------------------------------------------
    def _limits_changed(self) -> None:
        self._refresh_buttons()
        if self.preview_box.isChecked():
            self._live_timer.start()

    def _search_visible_part(self) -> None:
        model, part = self._model, find_visible_part(self._studio)
        if model is not None and self._disabled_reason() is None and part is not None:
            self._facets.find(model.id, self.limits.options(), part)

    def _start(self, model: Model) -> None:
        self._facets.find(model.id, self.limits.options(), None)

    # --- proposals ---------------------------------------------------------------------------
    def _show_proposals(self) -> None:
        proposals, facets = self._facets.proposals, self._facets
        parts = (self.table, self.filter, self._decision_row, self._options_row, self.summary)
        for part in parts:
            part.setVisible(proposals is not None)
        state = (proposals, len(facets.open_rows))
        if state != self._table_state:
            self._table_state = state
            self._fill(proposals)
            if proposals is not None:
                self._paint()
        if proposals is not None:
            self.summary.setText(summary_text(proposals, facets.open_rows, facets.accepted))
        self.message.setText(self._summary_text(proposals))
        self._refresh_buttons()

    def _fill(self, proposals: Proposals | None) -> None:
        notation = self._studio.settings.notation
        rows = []
        for row in sorted(self._facets.open_rows) if proposals is not None else ():
            assert proposals is not None
            measurement = proposals.measured[row]
            if measurement.plane is None or measurement.verdict is None:
                continue
            verdict = measurement.verdict.quality
            error = catalogue.TOTAL_ERROR.value(
                self._studio.subject(proposals.patches[row], measurement)
            )
            verdict_key = (_VERDICT_RANKS[verdict], 90.0 if error is None else error)
            plane = measurement.attitude(notation, omit_hand_rule=True)
            area = measurement.area_m2
            if area is None:
                area = proposals.get_exposed_area(row)
            reasons = self._reason_text(row)
            rows.append(((verdict_key, error, plane, area or None, row + 1), reasons))
        self._show_rows(rows)

    def _paint(self) -> None:
        color_key = str(self.colours.currentData())
        self._facets.paint(color_key, "hsv" if color_key == "dip direction" else None)

    def _summary_text(self, proposals: Proposals | None) -> str:
        if proposals is None or self._facets.findings:
            return " ".join(map(str, self._facets.findings))
        studio = self._studio
        lines = [share_text(proposals, self._facets.open_rows, self._facets.accepted)]
        lines += map(str, proposals.result.warnings)
        proposed_runs = {patch.runs for patch in proposals.patches}
        picks = [
            f
            for f in studio.session.features()
            if getattr(f, "model_id", "") == proposals.model_id
            and getattr(f, "runs", None) not in proposed_runs
        ]
        undecided_facets = [
            (proposals.patches[i], proposals.measured[i]) for i in sorted(self._facets.open_rows)
        ]
        agreement = compare_proposals(
            measured_planes(studio, picks), oriented_planes(studio, undecided_facets)
        )
        if agreement.picked:
            lines.append(agreement_text(agreement))
        return "\n".join(line for line in lines if line)

    # --- decision ----------------------------------------------------------------------------
    def _measured_feature(self, index: int) -> tuple[Feature, Measurement]:
        proposals = self._facets.proposals
        assert proposals is not None
        return proposals.patches[index], proposals.measured[index]

    def _reason_text(self, index: int) -> str:
        verdict = self._measured_feature(index)[1].verdict
        if verdict is None or verdict.quality == "good":
            return ""
        return " ".join(item.message for item in verdict.reasons)

    def _highlight_area(self, indices: Sequence[int]) -> Area | None:
        proposals = self._facets.proposals
        open_model = None if proposals is None else self._studio.models.get(proposals.model_id)
        if proposals is None or open_model is None:
            return None
        areas = (
            patch_area(proposals.patches[index], proposals.model, open_model.surface)
            for index in indices
        )
        return merge_areas([area for area in areas if area is not None])

    def _index_at(self, hit: Hit) -> int | None:
        proposals = self._facets.proposals
        assert proposals is not None
        matches = (
            i for i in self._facets.open_rows if has_id(proposals.patches[i].runs, hit.index)
        )
        return next(matches, None)

    def _accept(self, indices: list[int]) -> bool:
        return bool(self._facets.accept(indices, str(self.type.currentData())))

    def _reject(self, indices: list[int]) -> bool:
        self._facets.reject(indices)
        return True


def _verdict_name(verdict_key: tuple[int, float]) -> str | None:
    return next((name for name, place in _VERDICT_RANKS.items() if place == verdict_key[0]), None)


def _verdict_text(verdict_key: tuple[int, float]) -> str:
    name = _verdict_name(verdict_key)
    return "–" if name is None else tr(_VERDICTS[name])


def _verdict_icon(verdict_key: tuple[int, float]) -> QIcon:
    return theme.verdict_icon(_verdict_name(verdict_key))
