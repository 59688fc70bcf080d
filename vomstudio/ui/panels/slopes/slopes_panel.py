"""Panel for the kinematic analysis of slopes."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import (
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QToolButton,
    QWidget,
)

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.notation import format_plane, parse_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import SlopeFace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, TypedFeature
from vomstudio.studio.display import default_appearance
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, limit_width, set_enabled
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.slopes.analysis import (
    FaceSlopeRequest,
    FaceSlopeResult,
    analyze_slope,
    slope_command,
    write_figure,
)
from vomstudio.ui.panels.slopes.facets import (
    FacetSlopesRequest,
    FacetSlopesResult,
    FacetSlopesView,
    analyze_facets,
    facet_shares,
    facets_command,
    facets_file,
    show_facet,
)
from vomstudio.ui.panels.slopes.results import SlopeResults
from vomstudio.ui.panels.tools.common import narrow_column
from vomstudio.ui.widgets.copied_command import CommandArguments, CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table
from vomstudio.ui.widgets.figure_file import choose_figure_file
from vomstudio.ui.widgets.group_box import SELECTED, GroupBox
from vomstudio.ui.widgets.options_form import OptionFields

_DEFAULT_FRICTION_DEG = 30.0


class SlopesPanel(
    AnalysisPanel[FaceSlopeRequest | FacetSlopesRequest, FaceSlopeResult | FacetSlopesResult]
):
    """Panel for the kinematic analysis of a single face or of each proposed facet."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(studio, "slope", "conventions.md#slopes", tr("Computing…"))
        self._is_writing = False
        self._notation = ""
        self._clicked_ids: tuple[str, ...] | None = None
        self._feature_ids: list[str] = []
        self.group_box = GroupBox(studio, tr("All planes"))
        self.group_box.setAccessibleName(tr("Planes"))
        self.group_box.activated.connect(self._follow_group)
        self.slope_kind = ComboBox()
        self.slope_kind.setObjectName("slope_at")
        self.slope_kind.addItem(tr("One face"), "face")
        self.slope_kind.addItem(tr("Each facet"), "facets")
        self.slope_kind.setToolTip(tr("Analyse one face, or each facet found on the model."))
        self.slope_kind.activated.connect(self._follow_slope_kind)
        self.face = QLineEdit()
        self.face.setObjectName("slope_face")
        self.face.setToolTip(tr("Attitude of the slope, in the project's notation."))
        self.face.textChanged.connect(self._schedule_refresh)
        self.take = QPushButton(tr("Use selected"))
        self.take.setToolTip(tr("Use the attitude of the selected plane."))
        self.take.clicked.connect(self._use_selection)
        self.angles = OptionFields(SlopeOptions, "slope", SlopeOptions(_DEFAULT_FRICTION_DEG))
        self.angles.changed.connect(self._schedule_refresh)
        self.results = SlopeResults()
        self.results.planes_clicked.connect(self._select)
        self.facets = FacetSlopesView()
        self.facets.setVisible(False)
        self.facets.painted.connect(lambda _: self._paint())
        self.facets.reset_requested.connect(studio.facets.unpaint)
        self.facets.facet_selected.connect(self._show_facet)
        self.copy = CopyCommandButton(
            self._copy_command, tr("save the planes as a table and copy the command")
        )
        self.figure = _button("image-outline", tr("Figure…"), self._ask_for_figure)
        self._arrange_widgets()
        studio.settings_changed.connect(self._convert_face)
        studio.edited.connect(self._follow_edit)
        studio.selection_changed.connect(self._follow_selection)
        connect_until_deleted(self, studio.facets.changed, self._follow_facets)
        self._convert_face()

    def _arrange_widgets(self) -> None:
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(4)
        form.addRow(
            tr("Planes"),
            _create_row(self.group_box, self.copy, self.figure, stretched_widget=self.group_box),
        )
        form.addRow(
            tr("Slope"),
            _create_row(self.slope_kind, self.face, self.take, stretched_widget=self.face),
        )
        label, angles = self.angles.place_row("friction_deg", "lateral_deg")
        angles.addWidget(self.angles.place("limits"), 1)
        form.addRow(label, angles)
        self.angles.add_rows(form)
        column = narrow_column(self)
        column.addLayout(limit_width(form))
        column.addWidget(self.message)
        column.addWidget(self.results, 1)
        column.addWidget(self.facets, 1)

    # --- changes -----------------------------------------------------------------------------
    def _convert_face(self) -> None:
        """Rewrite the typed face in the current notation."""
        previous_notation, notation = self._notation, self._studio.settings.notation
        self._notation = notation
        example = format_plane(Plane(135.0, 70.0), notation)
        self.face.setPlaceholderText(tr("such as {example}", example=example))
        if previous_notation and previous_notation != notation:
            with suppress(VomError):
                plane = parse_plane(self.face.text(), previous_notation)
                is_integer = (plane.dip_direction_deg % 1.0, plane.dip_deg % 1.0) == (0.0, 0.0)
                self.face.setText(format_plane(plane, notation, 0 if is_integer else 2))
        self._schedule_refresh()

    def _follow_group(self, *_: object) -> None:
        self._clicked_ids = None
        self._schedule_refresh()

    def _follow_selection(self) -> None:
        if self.visibleRegion().isEmpty():
            self._is_stale = True
            return
        self._refresh_take()
        ids = self._studio.selection.ids
        self.results.mark(ids)
        # A click in the list selects some of the analysed planes, which does not change the input.
        if ids != self._clicked_ids and self.group_box.choice() == SELECTED:
            self._clicked_ids = None
            self._schedule_refresh()

    # --- input -------------------------------------------------------------------------------
    def _list_choices(self) -> None:
        self.group_box.list_groups()
        self._refresh_take()

    def _compute_result(
        self, request: FaceSlopeRequest | FacetSlopesRequest
    ) -> FaceSlopeResult | FacetSlopesResult:
        if isinstance(request, FacetSlopesRequest):
            return analyze_facets(request)
        return analyze_slope(request)

    @property
    def facets_result(self) -> FacetSlopesResult | None:
        """Result of the analysis by facet, or None if another result is shown."""
        return self.result if isinstance(self.result, FacetSlopesResult) else None

    @property
    def face_result(self) -> FaceSlopeResult | None:
        """Result of the analysis of one face, or None if another result is shown."""
        return self.result if isinstance(self.result, FaceSlopeResult) else None

    @property
    def _uses_facets(self) -> bool:
        return bool(self.slope_kind.currentData() == "facets")

    def _planes(self) -> tuple[list[TypedFeature], dict[str, Measurement]]:
        """Return the planes of the group and their measurements by feature id.

        Raises InputError if the group contains no planes.
        """
        studio = self._studio
        is_selection = self.group_box.choice() == SELECTED
        if self._clicked_ids is None or not is_selection:
            self._feature_ids = [feature.id for feature in self.group_box.features()]
        records = [studio.records.get(id_) for id_ in self._feature_ids]
        features = [record for record in records if isinstance(record, TypedFeature)]
        measurements = studio.measured(f.id for f in features)
        features = [f for f in features if measurements[f.id].plane is not None]
        if not features:
            raise InputError(Finding("selection.unsuitable" if is_selection else "planes.none"))
        return features, dict(measurements)

    def _create_request(self) -> FaceSlopeRequest | FacetSlopesRequest:
        if self._uses_facets:
            return self._create_facets_request()
        planes = self._planes()
        text = self.face.text().strip()
        if not text:
            raise InputError(Finding("slope.no-face"))
        face = SlopeFace(parse_plane(text, self._notation), self._create_options())
        return FaceSlopeRequest(dict(self._studio.records), *planes, face)

    def _create_options(self) -> SlopeOptions:
        return self.angles.options()

    def _create_facets_request(self) -> FacetSlopesRequest:
        studio, proposals = self._studio, self._studio.facets.proposals
        features, measurements = self._planes()
        loaded_model = None if proposals is None else studio.models.get(proposals.model_id)
        model = None if proposals is None else studio.records.get(proposals.model_id)
        if proposals is None or loaded_model is None or not isinstance(model, Model):
            raise InputError(Finding("action.no-proposals"))
        rows = sorted(studio.facets.open_rows | studio.facets.accepted)
        return FacetSlopesRequest(
            records=dict(studio.records),
            features=features,
            measured=measurements,
            proposals=proposals,
            rows=rows,
            data=loaded_model.data,
            to_world=model.to_world,
            options=self._create_options(),
        )

    def _follow_slope_kind(self, *_: object) -> None:
        if not self._uses_facets:
            self._studio.facets.unpaint()
        set_enabled(self.face, Finding("action.slope-is-facet") if self._uses_facets else None)
        self._refresh_take()
        self._schedule_refresh()

    def _follow_facets(self) -> None:
        if self._uses_facets:
            self._schedule_refresh()

    def _show_facet(self, row: int) -> None:
        """Highlight the facet in the selected row on the outcrop."""
        if self.facets_result is not None:
            show_facet(self._studio, self.facets_result.request.proposals, row)

    def _paint(self) -> None:
        """Colour the outcrop by the critical share of the selected failure mode."""
        if self.facets_result is not None:
            mode = self.facets.current_mode
            self._studio.facets.paint_shares(mode, facet_shares(self.facets_result, mode))

    # --- result ------------------------------------------------------------------------------
    def _result_text(self, result: FaceSlopeResult | FacetSlopesResult) -> str:
        count_text = (
            _count_text(result)
            if isinstance(result, FaceSlopeResult)
            else _facet_count_text(result)
        )
        return " ".join([count_text, *map(str, result.analysis.warnings)])

    def _draw(self) -> None:
        self.results.setVisible(not self._uses_facets)
        self.facets.setVisible(self._uses_facets)
        proposals = self._studio.facets.proposals
        loaded_model = None if proposals is None else self._studio.models.get(proposals.model_id)
        appearance = default_appearance([] if loaded_model is None else [loaded_model.data])
        self.facets.show_result(self.facets_result, self._studio.settings.notation, appearance)
        self.results.show_result(self.face_result, self._studio.settings.notation)
        self.results.mark(self._studio.selection.ids)
        self._paint()

    def _select(self, ids: list[str]) -> None:
        # The list may still contain a deleted plane.
        self._clicked_ids = tuple(id_ for id_ in ids if id_ in self._studio.records)
        self._studio.selection.set(self._clicked_ids)

    # --- face --------------------------------------------------------------------------------
    def _selected_plane(self) -> Plane | None:
        current = self._studio.selection.current
        record = None if current is None else self._studio.records.get(current)
        if current is None or not isinstance(record, TypedFeature):
            return None
        return self._studio.measured([current])[current].plane

    def _refresh_take(self) -> None:
        reason = None
        if self._uses_facets:
            reason = Finding("action.slope-is-facet")
        elif self._selected_plane() is None:
            reason = Finding("selection.no-plane")
        set_enabled(self.take, reason)

    def _use_selection(self) -> None:
        plane = self._selected_plane()
        if plane is not None:
            self.face.setText(format_plane(plane, self._notation, 1))

    # --- export ------------------------------------------------------------------------------
    def _refresh(self) -> None:
        reason = None
        if self._requests.is_waiting:
            reason = Finding("action.busy")
        elif self.result is None:
            reason = Finding("action.no-proposals" if self._uses_facets else "action.no-result")
        elif self._is_writing:
            reason = Finding("action.busy")
        self.copy.set_enabled(reason)
        if reason is None and self._uses_facets:
            reason = Finding("action.nets-of-one-face")
        self.figure.setEnabled(reason is None)
        purpose = tr("nets of the four modes as SVG, PDF or PNG")
        self.figure.setToolTip(
            tr("{button}: {more}", button=self.figure.text().rstrip("…"), more=reason or purpose)
        )

    def _copy_command(self) -> None:
        """Write the tables of the analysis to files, and copy the command to the clipboard."""
        if self.facets_result is not None:
            self._copy_facets(self.facets_result)
            return
        if self.face_result is None:
            return
        request = self.face_result.request
        copy_with_table(
            self,
            self._studio,
            "slope-planes.csv",
            [f.id for f in request.features],
            partial(slope_command, request.face),
        )

    def _copy_facets(self, result: FacetSlopesResult) -> None:
        """Write the tables of planes and facets, and copy the command to the clipboard."""
        from vomstudio.products.surface.slope_facets import write_faces

        def command(path: Path) -> CommandArguments:
            write_faces(facets_file(path), result.faces)
            return facets_command(result, path)

        ids = [f.id for f in result.request.features]
        copy_with_table(self, self._studio, "slope-planes.csv", ids, command)

    def _ask_for_figure(self) -> None:
        path = choose_figure_file(self, self._studio, tr("Figure of the slope"), "slope")
        if path is not None:
            self.write_figure(path)

    def write_figure(self, path: Path) -> None:
        """Write the four nets to a figure file in a worker thread."""
        if self.face_result is None:
            return
        self._is_writing = True
        self._refresh()
        studio = self._studio
        self._background.run(
            partial(write_figure, self.face_result, path),
            lambda _: self._finish_writing(partial(studio.written, path)),
            lambda error: self._finish_writing(partial(studio.fail, error)),
        )

    def _finish_writing(self, report: Callable[[], None]) -> None:
        self._is_writing = False
        self._refresh()
        report()


def _count_text(result: FaceSlopeResult) -> str:
    """Return the number of planes as text; if no errors are known, the text reports this."""
    analysis = result.analysis
    if not analysis.with_error:
        return Finding("slope.no-errors", n=analysis.n).message
    return tr_n("{count:,} plane.", "{count:,} planes.", analysis.n)


def _facet_count_text(result: FacetSlopesResult) -> str:
    """Return the numbers of facets and planes as text."""
    return tr(
        "{facets} facets, {planes:,} planes. The outcrop shows the critical share at each facet.",
        facets=len(result.analysis.facets),
        planes=result.analysis.n,
    )


def _create_row(*parts: QWidget, stretched_widget: QWidget) -> QHBoxLayout:
    row = QHBoxLayout()
    for part in parts:
        row.addWidget(part, 1 if part is stretched_widget else 0)
    return row


def _button(icon: str, text: str, callback: Callable[[], None]) -> QToolButton:
    """Create a tool button; `_refresh` sets its tooltip."""
    button = QToolButton()
    button.setIcon(theme.icon(icon))
    button.setText(text)
    button.setAccessibleName(text)
    button.clicked.connect(callback)
    return button
