"""Panel that requests repeated picks and compares their spread with the reported errors."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

import numpy as np
from PySide6.QtWidgets import QLineEdit, QPushButton

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.coverage.table_repeats import TableRepeats, table_repeats
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.project.exports.feature_table import feature_table
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import FeatureType, RepeatableFeature, TypedFeature, get
from vomstudio.project.repeated_features import set_interpreter
from vomstudio.rendering.view.drawing import FeatureDrawing
from vomstudio.studio.tools.interaction_types import Area
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import missing_feature_finding, selected_features
from vomstudio.ui.base.controls import button_row, narrow_form, set_enabled
from vomstudio.ui.base.number_formatting import extent_points
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import OutcropView
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.tools.common import hint_label
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.results_page import FiguresPage

_PLACE = "place to be picked again"
_COLOR = (1.0, 0.76, 0.03)
_CORNERS = 48


class RepeatsPanel(AnalysisPanel[OrientationTable, TableRepeats]):
    """Panel that requests a second pick of features and shows the repeatability."""

    def __init__(self, studio: Studio, view: OutcropView) -> None:
        super().__init__(studio, "repeats", "fractures.md#repeated-picks", tr("Counting…"))
        self._view = view
        self._blind_repeats = studio.workspace.repeats
        self.interpreter = QLineEdit()
        self.interpreter.setObjectName("repeats_interpreter")
        self.interpreter.setPlaceholderText(tr("initials"))
        self.share = QLineEdit("10")
        self.share.setObjectName("repeats_share")
        self.share.setToolTip(tr("Percentage of picks to repeat."))
        self.begin = QPushButton(theme.icon("replay"), tr("Start re-picking"))
        self.begin.setToolTip(tr("Repeat a random sample of picks, with the originals hidden."))
        self.name = QPushButton(tr("Set interpreter"))
        self.name.setToolTip(tr("Record this interpreter for the selected features."))
        self.zoom_button = QPushButton(theme.icon("image-filter-center-focus"), tr("Zoom to pick"))
        self.skip = QPushButton(tr("Skip"))
        self.stop = QPushButton(tr("Stop"))
        self.prompt = hint_label()
        self.prompt.setObjectName("repeats_offered")
        self.figures = FiguresPage(Finding("repeats.not-begun").message)
        self.figures.setAccessibleName(tr("Spread of the repeats"))
        self._arrange_widgets()
        self._connect_signals()

    def _arrange_widgets(self) -> None:
        form = narrow_form()
        form.addRow(tr("Interpreter"), self.interpreter)
        form.addRow(tr("Share (%)"), self.share)
        first_row = button_row(self.begin, self.name)
        second = button_row(self.zoom_button, self.skip, self.stop)
        FormWithPicture.fill(
            self, form, first_row, second, self.prompt, self.message, picture=self.figures
        )

    def _connect_signals(self) -> None:
        studio = self._studio
        for button, run in (
            (self.begin, self._begin_round),
            (self.name, self._store_interpreter),
            (self.zoom_button, self._show_place),
            (self.skip, self._blind_repeats.skip),
            (self.stop, self._blind_repeats.stop),
        ):
            button.clicked.connect(lambda _=False, run=run: self._run(run))
        self.share.textChanged.connect(lambda _: self._refresh())
        studio.edited.connect(self._schedule_refresh)
        studio.selection_changed.connect(self._refresh_name)
        self._blind_repeats.changed.connect(self._show_next)

    def _run(self, run: Callable[[], object]) -> None:
        try:
            run()
        except VomError as error:
            self._studio.fail(error)
        self._refresh()

    # --- round of repeated picks -------------------------------------------------------------
    def _begin_round(self) -> None:
        # The clicked button has the keyboard focus, but the tool needs it.
        self._blind_repeats.begin(self._share() or 0.0, self.interpreter.text().strip())
        if self._view.viewport is not None:
            self._view.viewport.setFocus()

    def _share(self) -> float | None:
        value = parse_number(self.share.text())
        return value / 100.0 if value is not None and 0.0 < value <= 100.0 else None

    def _store_interpreter(self) -> None:
        studio = self._studio
        ids, interpreter = selected_features(studio), self.interpreter.text().strip()
        studio.attempt(set_interpreter, ids, interpreter)

    def _show_next(self) -> None:
        """Show which feature is to be picked again, and where it is."""
        records, id_ = self._studio.records, self._blind_repeats.current
        feature = get(records, id_, RepeatableFeature)
        if feature is None:
            self.prompt.clear()
            self._show_mark(None)
        else:
            type_ = (
                get(records, feature.type_id, FeatureType)
                if isinstance(feature, TypedFeature)
                else None
            )
            done_count = len(self._blind_repeats.selected_ids) - len(
                self._blind_repeats.waiting_ids
            )
            self.prompt.setText(
                tr(
                    "{number} of {all}: pick the {type} in the ring again ({kind}).",
                    number=done_count + 1,
                    all=len(self._blind_repeats.selected_ids),
                    type="" if type_ is None else type_.name.lower(),
                    kind=tr(get_kind(feature).title).lower(),
                )
            )
            self._show_place()
        self._refresh()

    def _show_place(self) -> None:
        """Look at the face around the feature, without revealing the attitude of its plane."""
        id_, viewport = self._blind_repeats.current, self._view.viewport
        if id_ is None or viewport is None:
            return
        measurements = self._studio.measured([id_])[id_]
        points = extent_points(measurements)
        centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
        radius = max(float(np.linalg.norm(points - centre, axis=1).max()) * 1.15, 1e-6)
        trend, plunge = viewport.moves.view_direction()
        from vomstudio.geology.orientation import Line
        from vomstudio.geometry.view_frame import ViewFrame

        direction = Line(trend, plunge).vector()
        face = measurements.outcrop_normal
        if face is not None and abs(float(face @ direction)) > 0.1:
            direction = -face if float(face @ direction) < 0.0 else face
            line = Line.from_vector(direction, is_directed=True)
            viewport.moves.look_along(line.trend_deg, line.plunge_deg)
        frame = ViewFrame.from_direction(direction)
        angles = np.linspace(0.0, 2.0 * np.pi, _CORNERS)
        ring = np.cos(angles)[:, None] * frame.right + np.sin(angles)[:, None] * frame.down
        viewport.moves.frame(centre + 2.5 * radius * ring)
        self._show_mark((centre - 0.5 * radius * direction, radius * ring))

    def _show_mark(self, ring: tuple[np.ndarray, np.ndarray] | None) -> None:
        """Draw the ring, which cannot be selected, or remove it if `ring` is not given."""
        viewport = self._view.viewport
        if viewport is None:
            return
        drawing = None
        if ring is not None:
            centre, offsets = ring
            edges = np.stack([offsets[:-1], offsets[1:]], axis=1).astype(np.float32)
            area = Area(centre, np.zeros((0, 3, 3), np.float32), edges)
            drawing = FeatureDrawing(_PLACE, np.zeros((0, 3)), None, _COLOR, "", centre, area=area)
        if drawing is not None or _PLACE in viewport.features.drawings:
            viewport.features.change({_PLACE: drawing})

    # --- figures -----------------------------------------------------------------------------
    def _compute_result(self, request: OrientationTable) -> TableRepeats:
        return table_repeats(request)

    def _create_request(self) -> OrientationTable:
        studio = self._studio
        features = studio.session.of(RepeatableFeature)
        if not any(f.repeat_of for f in features):
            raise InputError(Finding("repeats.not-begun"))
        measurements = studio.measured(f.id for f in features)
        return feature_table(studio.records, features, measurements, repeats=True)

    def _result_text(self, result: TableRepeats) -> str:
        return "\n".join(map(str, result.reasons))

    def _set_result(self, result: TableRepeats | None, message: str) -> None:
        super()._set_result(result, "" if result is None else message)
        if result is None:
            self.figures.show_reason(message)
        else:
            names = {f.id: f.name for f in self._studio.session.of(RepeatableFeature)}
            self.figures.setHtml(figures_html(result, names))

    def _refresh(self) -> None:
        if not self._studio.has_project:
            return
        is_running = self._blind_repeats.current is not None
        reason = Finding("action.round-running") if is_running else None
        if reason is None and not self._blind_repeats.available():
            reason = Finding("action.no-pick-left")
        if reason is None and self._share() is None:
            text = self.share.text().strip()
            reason = Finding("option.out-of-range", value=text, minimum=0, maximum=100)
        set_enabled(self.begin, reason)
        for button in (self.zoom_button, self.skip, self.stop):
            set_enabled(button, None if is_running else Finding("action.no-round"))
        self._refresh_name()

    def _refresh_name(self) -> None:
        # The picks available for repetition do not depend on the selection.
        if not self._studio.has_project:
            return
        set_enabled(self.name, missing_feature_finding(self._studio))


def figures_html(repeats: TableRepeats, names: dict[str, str]) -> str:
    """Format the repeatability as HTML; `names` contains the names of features by id."""
    lines = []
    if repeats.spread is not None:
        spread = repeats.spread
        lines = [
            (
                tr("95 % error from repeats"),
                f"{spread.error95_deg:.1f}° ({spread.error95_low_deg:.1f} – "
                f"{spread.error95_high_deg:.1f}°)",
            ),
            (tr("Stated 95 % error"), _degrees(repeats.stated95_deg)),
            (tr("Median angle"), _degrees(repeats.median_angle_deg)),
        ]
    if repeats.test is not None:
        lines.append(
            (
                tr("Within stated errors"),
                tr("{within} of {count}", within=repeats.test.within95, count=repeats.test.n),
            )
        )
    lines += [
        (
            group.name or tr("unknown"),
            tr(
                "{error}, repeats: {count}",
                error=_degrees(group.spread.error95_deg),
                count=group.spread.n,
            ),
        )
        for group in repeats.interpreters
    ]
    table = "".join(
        f"<tr><td style='padding:1px 8px 1px 4px'>{escape(a)}</td>"
        f"<td style='padding:1px 2px'>{escape(b)}</td></tr>"
        for a, b in lines
    )
    pairs = "".join(
        f"<tr><td style='padding:1px 8px 1px 4px'>{escape(names.get(p.first, p.first))}</td>"
        f"<td style='padding:1px 8px'>{escape(' / '.join(w or '–' for w in p.by))}</td>"
        f"<td style='padding:1px 8px' align='right'>{p.angle_deg:.1f}°</td>"
        f"<td style='padding:1px 8px' align='right'>{_degrees(p.stated95_deg)}</td></tr>"
        for p in repeats.pairs
    )
    headers = "".join(
        f"<th align='left' style='padding:1px 8px 1px 4px'>{escape(h)}</th>"
        for h in (tr("Pick"), tr("By"), tr("Angle"), tr("Stated 95 %"))
    )
    return f"<table>{table}</table><br><table><tr>{headers}</tr>{pairs}</table>"


def _degrees(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}°"
