"""Panel for the view direction: typed, or along the fold axis, a line or a plane."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from itertools import islice
from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, Qt, QTimer
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.signals import call_after_notifications
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.notation import format_attitude, format_line, parse_line
from vomstudio.geology.orientation import Line, Plane, angle_between_lines
from vomstudio.geometry import transform
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360
from vomstudio.products.ortho.view_directions import cost_of_direction
from vomstudio.project.edit import Edit
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, get_feature
from vomstudio.rendering.view.first_view import first_view
from vomstudio.studio.view_quality import (
    AxialDirection,
    direction_across_slip,
    intersection_direction,
    scene_depth,
)
from vomstudio.ui.base.controls import Label, rich_label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import LatestRequestRunner
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import OutcropView
from vomstudio.ui.panels.view.bedding_axis import BeddingAxis
from vomstudio.ui.panels.view.saved_views_box import SavedViewsBox
from vomstudio.ui.widgets.fold_box import FoldBox

if TYPE_CHECKING:
    from vomstudio.geology.folds import FoldAxis

MAX_SAME_DIRECTION_DEG = 0.5
"""Directions that differ by a smaller angle are treated as equal."""

_MAX_FEATURES = 20
_MAX_IMMEDIATE_BEDS = 150

_MIN_EDGE_ON_SINE = 0.05
"""Sine of the angle to the exposed face below which both sides are seen edge-on."""


class ViewPanel(QWidget):
    """Panel with view directions and saved views."""

    def __init__(self, studio: Studio, view: OutcropView) -> None:
        super().__init__()
        set_help_topic(self, "numbers.md#the-view-direction")
        self._studio = studio
        self._look_along = view.look_along
        self._direction = Line(0.0, 0.0)
        self._is_stale = False
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._request_axis)
        self._requests = LatestRequestRunner(
            self, self._store_axis, lambda error: self._store_axis(to_finding(error)), lambda: None
        )
        self._bedding = BeddingAxis(studio)
        self._exposed_cache: tuple[str, Matrix, FloatArray] | None = None
        self.current_label = Label("–")
        font = self.current_label.font()
        font.setPointSizeF(font.pointSizeF() * 1.2)
        font.setBold(True)
        self.current_label.setFont(font)
        self.direction_field = QLineEdit()
        self.direction_field.setObjectName("view_direction")
        self.direction_field.setPlaceholderText(tr("For example 125/26"))
        self.direction_field.returnPressed.connect(self._look_along_text)
        look_button = QPushButton(tr("Look"))
        look_button.clicked.connect(self._look_along_text)
        row = QHBoxLayout()
        row.addWidget(self.direction_field, 1)
        row.addWidget(look_button)
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(tr("Current"), self.current_label)
        form.addRow(tr("New"), row)

        self._buttons: dict[str, QPushButton] = {}
        grid = QGridLayout()
        grid.setSpacing(4)
        for i, (name, text, callback) in enumerate(
            (
                ("beta", tr("Along fold axis"), self.look_along_beta),
                ("meeting", tr("Along intersection"), self.look_along_intersection),
                ("facing", tr("Face the plane"), self.face),
                ("strike", tr("Along strike"), self._look_along_strike),
                ("line", tr("Along the line"), self.look_along_line),
                ("dip", tr("Down dip"), self._look_down_dip),
                ("slip", tr("Across the slip"), self.look_along_slip_normal),
                ("rock", tr("Face the outcrop"), self._face_outcrop),
                ("flip", tr("Opposite side"), self._reverse_direction),
            )
        ):
            button = QPushButton(text)
            button.clicked.connect(callback)
            self._buttons[name] = button
            grid.addWidget(button, i // 2, i % 2)
        self._cost = Label()
        self._cost.setObjectName("view_cost")
        self._cost.setWordWrap(True)
        self._cost.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.selected_only_box = QCheckBox(tr("Selected bedding only"))
        self.selected_only_box.toggled.connect(
            lambda on: studio.fold.choose(studio.fold.fold_filter, is_selected=on)
        )
        self.fold_box = FoldBox(studio)
        studio.fold.changed.connect(self._follow_fold_choice)
        self._verdict = rich_label()
        self._verdict.setWordWrap(True)
        self._verdict.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addLayout(form)
        layout.addLayout(grid)
        layout.addWidget(self._cost)
        layout.addWidget(SavedViewsBox(studio, view))
        layout.addWidget(self.fold_box)
        layout.addWidget(self.selected_only_box)
        layout.addWidget(self._verdict)
        layout.addStretch()
        studio.project_opened.connect(self._follow_project)
        studio.edited.connect(self._follow_edit)
        studio.selection_changed.connect(self._follow_selection)
        studio.model_loaded.connect(self.refresh)
        studio.jobs.closed.connect(self._requests.close)

    def show_direction(self, trend_deg: float, plunge_deg: float, is_orthographic: bool) -> None:
        """Show the direction of the view in degrees, and whether it is orthographic."""
        self._direction = Line(wrap360(trend_deg), plunge_deg)
        line = format_line(self._direction, 0)
        self.current_label.setText(
            tr("{line} (orthographic)", line=line)
            if is_orthographic
            else tr("{line} (perspective)", line=line)
        )
        # A drag emits many directions; the cost is shown only for the last one.
        self._call_with_axis(self._show_cost)

    # --- directions --------------------------------------------------------------------------
    def _look_along_text(self) -> None:
        try:
            line = parse_line(self.direction_field.text())
        except VomError as error:
            self._studio.warn(error)
            return
        self._turn(line)

    def look_along_beta(self) -> None:
        """Look along the fold axis of the bedding if it is known."""
        axis = self._bedding.find_axis()
        if not isinstance(axis, Finding):
            self._turn_axis(axis.beta)

    def face(self) -> None:
        """Look perpendicular to the selected plane."""
        plane = self._selected_plane()
        if plane is not None:
            # The view is against the upward normal. A vertical plane is viewed along its dip
            # direction plus 180 degrees (CLI.md, ortho --plane).
            self._turn(Line(wrap360(plane.dip_direction_deg + 180.0), 90.0 - plane.dip_deg))

    def look_along_line(self) -> None:
        """Look along the selected lineation or intersection."""
        line = self._selected_line()
        if line is not None:
            self._turn_axis(line)

    def look_along_intersection(self) -> None:
        """Look along the intersection of the two selected planes, which are then seen edge-on."""
        direction = self._find_intersection()
        if isinstance(direction, AxialDirection):
            self._turn_axis(direction.line)

    def look_along_slip_normal(self) -> None:
        """Look perpendicular to the selected slip, within its fault plane.

        This view shows the displacement at full length.
        """
        direction = self._find_slip_normal()
        if isinstance(direction, AxialDirection):
            self._turn_axis(direction.line)

    def _face_outcrop(self) -> None:
        view = self._find_exposed_view()
        if view is not None:
            self._turn(Line.from_vector(view, is_directed=True))

    def _look_along_strike(self) -> None:
        plane = self._selected_plane()
        if plane is not None:
            self._turn(Line(plane.strike_rhr_deg, 0.0))

    def _look_down_dip(self) -> None:
        plane = self._selected_plane()
        if plane is not None:
            self._turn(Line(plane.dip_direction_deg, plane.dip_deg))

    def _reverse_direction(self) -> None:
        self._turn(Line(wrap360(self._direction.trend_deg + 180.0), -self._direction.plunge_deg))

    def _turn_axis(self, axis: Line) -> None:
        """Look along an axis from the exposed side of the outcrop.

        If the side is unknown, or if both sides are seen edge-on, the view is down the plunge of
        the axis.
        """
        view = self._find_exposed_view()
        if view is not None and axis.vector() @ view < -_MIN_EDGE_ON_SINE:
            axis = Line.from_vector(-axis.vector(), is_directed=True)
        self._turn(axis)

    def _find_exposed_view(self) -> FloatArray | None:
        """Return the view direction onto the first open mesh, or None if no mesh is open."""
        for model_id, open_model in self._studio.models.items():
            model = self._studio.records.get(model_id)
            if isinstance(model, Model) and isinstance(open_model.data, Mesh):
                if self._exposed_cache is None or self._exposed_cache[:2] != (
                    model_id,
                    model.to_world,
                ):
                    trend, plunge = first_view(open_model.data, transform.matrix(model.to_world))
                    view = Line(trend, plunge).vector()
                    self._exposed_cache = (model_id, model.to_world, view)
                return self._exposed_cache[2]
        return None

    def _turn(self, line: Line) -> None:
        self._look_along(line.trend_deg, line.plunge_deg)

    def fold_axis_problem(self) -> Finding | None:
        """Return why the fold axis cannot be computed, or None if it can."""
        return self._bedding.disabled_reason()

    def plane_problem(self) -> Finding | None:
        """Return a finding if no plane is selected, otherwise None."""
        return Finding("selection.no-plane") if self._selected_plane() is None else None

    def find_direction_origin(self, direction: Line) -> tuple[str, float | None]:
        """Describe the measurement that defines a direction.

        Returns
        -------
        str
            Description, or a message if the direction is not that of a measurement.
        float or None
            95 % error of the direction in degrees, or None if it is unknown.
        """
        axis = self._bedding.find_axis()
        if (
            not isinstance(axis, Finding)
            and angle_between_lines(axis.beta, direction) < MAX_SAME_DIRECTION_DEG
        ):
            return _axis_text(axis), axis.error95_deg
        # In a large selection, no single feature defines the view.
        for id_ in islice(reversed(self._studio.selection.ids), _MAX_FEATURES):
            feature = get_feature(self._studio.records, id_)
            if feature is None:
                continue
            measurements = self._studio.measured([id_])[id_]
            line = measurements.line or (measurements.plane.pole() if measurements.plane else None)
            if line is not None and angle_between_lines(line, direction) < MAX_SAME_DIRECTION_DEG:
                attitude = measurements.attitude(self._studio.settings.notation)
                values = {"feature": feature.name, "attitude": attitude}
                if measurements.line is not None:
                    text = tr("Along {feature}, {attitude} (95 %).", **values)
                else:
                    text = tr("Perpendicular to {feature}, {attitude} (95 %).", **values)
                return text, measurements.total95_deg
        return Finding("view.direction-unmeasured").message, None

    def line_problem(self) -> Finding | None:
        """Return a finding if no line is selected, otherwise None."""
        return Finding("selection.no-line") if self._selected_line() is None else None

    # --- measurements ------------------------------------------------------------------------
    def _selected_measurements(self) -> list[Measurement]:
        """Return the measurements of all selected features."""
        measurements = self._studio.measured(self._studio.selection.ids)
        return [measurements[id_] for id_ in self._studio.selection.ids if id_ in measurements]

    def _error95_deg(self, id_: str) -> float | None:
        """Return the 95 % error of a feature in degrees, or None if it is unknown.

        It includes the registration error if that is known.
        """
        measurement = self._studio.measured([id_]).get(id_)
        return None if measurement is None else measurement.total95_deg

    def _current_error_deg(self) -> float | None:
        current = self._studio.selection.current
        return None if current is None else self._error95_deg(current)

    def _find_intersection(self) -> AxialDirection | Finding:
        if len(self._studio.selection.ids) != 2:
            return Finding("selection.not-two-planes")
        return intersection_direction(self._selected_measurements())

    def _find_slip_normal(self) -> AxialDirection | Finding:
        current = self._studio.selection.current
        measurements = {} if current is None else self._studio.measured([current])
        if current is None or current not in measurements:
            return Finding("selection.no-slip")
        return direction_across_slip(measurements[current])

    def _selected_plane(self) -> Plane | None:
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return None
        return self._studio.measured([current])[current].plane

    def _selected_line(self) -> Line | None:
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return None
        return self._studio.measured([current])[current].line

    def _follow_edit(self, edit: Edit) -> None:
        self._bedding.follow_edit(self._studio.affected_ids(edit))
        self.refresh()

    def _follow_selection(self, *_: object) -> None:
        if self._studio.fold.is_selected:
            self._bedding.update_bedding()
        self.refresh()

    def _follow_fold_choice(self) -> None:
        with QSignalBlocker(self.selected_only_box):
            self.selected_only_box.setChecked(self._studio.fold.is_selected)
        self._bedding.update_bedding()
        self.refresh()

    def _follow_project(self) -> None:
        self.direction_field.clear()
        self._bedding.update_bedding()
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the fold axis with its verdict, and enable the available directions."""
        self._call_with_axis(self._show_directions)

    def _call_with_axis(self, show: Callable[[], None]) -> None:
        """Call `show`; with many beds the fold axis is first computed in a worker thread.

        A hidden panel with many beds is not updated until it is shown.
        """
        if self._bedding.count <= _MAX_IMMEDIATE_BEDS:
            call_after_notifications(show)
        elif self.visibleRegion().isEmpty():
            self._is_stale = True
        elif self._bedding.is_known:
            call_after_notifications(show)
        else:
            self._timer.start(0)

    def _request_axis(self) -> None:
        self._requests.request(self._bedding.search())

    def _store_axis(self, axis: FoldAxis | Finding) -> None:
        self._bedding.store(axis)
        if self._bedding.is_known:
            call_after_notifications(self._show_directions)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        if self._is_stale:
            self._is_stale = False
            self.refresh()

    def _show_directions(self) -> None:
        axis, plane = self._bedding.find_axis(), self._selected_plane()
        no_plane = Finding("selection.no-plane") if plane is None else None
        intersection, slip = self._find_intersection(), self._find_slip_normal()
        beta = axis if isinstance(axis, Finding) else AxialDirection(axis.beta, axis.error95_deg)
        self._update_direction_button("beta", beta)
        self._update_direction_button("meeting", intersection)
        self._update_direction_button("slip", slip)
        error = self._current_error_deg()
        self._update_direction_button(
            "facing", no_plane if plane is None else AxialDirection(plane.pole(), error)
        )
        for name in ("strike", "dip"):
            set_enabled(self._buttons[name], no_plane)
        line = self._selected_line()
        self._update_direction_button(
            "line", self.line_problem() if line is None else AxialDirection(line, error)
        )
        no_surface = Finding("action.no-surface") if self._find_exposed_view() is None else None
        set_enabled(self._buttons["rock"], no_surface)
        self._show_cost()
        if not isinstance(axis, Finding):
            text = f"<b>{escape(_axis_text(axis))}</b>"
            warnings = (f"• {warning}" for warning in self._bedding.warnings())
            self._verdict.setText("<br>".join([text, *map(escape, warnings)]))
            # Statistics lists the reasons with their figures.
            self._verdict.setToolTip("<br>".join(escape(str(item)) for item in axis.reasons))
        else:
            self._verdict.setText(escape(axis.message))
            self._verdict.setToolTip("")

    def _update_direction_button(
        self, name: str, direction: AxialDirection | Finding | None
    ) -> None:
        """Enable or disable a button; its tooltip shows the direction and effect of its error."""
        button = self._buttons[name]
        if not isinstance(direction, AxialDirection):
            set_enabled(button, direction or Finding("action.no-direction"))
            return
        set_enabled(button, None)
        text = tr(
            "Along {line} (95 %).",
            line=format_attitude(direction.line, direction.error95_deg),
        )
        button.setToolTip(
            f"{text} {self._cost_text(direction.line, direction.error95_deg)}".strip()
        )

    def _cost_text(self, line: Line, error95_deg: float | None) -> str:
        """Describe the effect of a direction error; empty if no model is open."""
        studio = self._studio
        depth, metric = scene_depth(line.vector(), studio.models, studio.records)
        return cost_of_direction(error95_deg, depth, is_metric=metric).message if depth else ""

    def _show_cost(self) -> None:
        """Show the origin of the current direction and the effect of its error."""
        origin, error = self.find_direction_origin(self._direction)
        axis = self._bedding.find_axis()
        if not isinstance(axis, Finding) and origin == _axis_text(axis):
            # The axis itself is stated below, with its planes.
            origin = tr("Along the fold axis.")
        self._cost.setText(f"{origin} {self._cost_text(self._direction, error)}".strip())


def _axis_text(axis: FoldAxis) -> str:
    return tr_n(
        "Along the fold axis (beta) {line} (95 %) of {count} bedding plane; "
        "verdict: {verdict}; view along it valid: {valid}.",
        "Along the fold axis (beta) {line} (95 %) of {count} bedding planes; "
        "verdict: {verdict}; view along it valid: {valid}.",
        axis.n,
        line=format_attitude(axis.beta, axis.error95_deg),
        verdict=axis.verdict,
        valid=axis.valid,
    )
