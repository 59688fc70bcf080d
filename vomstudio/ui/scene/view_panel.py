"""The panel of the view direction: typed, along the fold axis, along a line, along or facing a
plane."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document.catalogue import TOTAL
from vomstudio.document.edit import Edit
from vomstudio.document.kinds import is_picked_plane
from vomstudio.document.records import Matrix, Model, Record, Typed, get_feature
from vomstudio.document.registration_errors import bowed_deg, model_of, turns_of
from vomstudio.errors import VomError
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.notation import format_line, parse_line
from vomstudio.geology.orientation import Line, Plane, angle_between_lines, normals_to_planes
from vomstudio.geometry import transform
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360
from vomstudio.rendering.view.first_view import first_view
from vomstudio.signals import once_told
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.number_formatting import degrees
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr, tr_n

SAME_DEG = 0.5
"""Directions that differ by less are treated as the same."""

_EDGE_ON = 0.05
"""Sine of the angle to the exposed face under which neither side is the better one."""


class ViewPanel(QWidget):
    """`look` turns the view: look(trend_deg, plunge_deg), orthographic."""

    def __init__(self, studio: Studio, look: Callable[[float, float], None]) -> None:
        super().__init__()
        explain(self, "numbers.md#the-view-direction")
        self._studio = studio
        self._look = look
        self._direction = Line(0.0, 0.0)
        self._axis_kept: FoldAxis | str | None = None
        self._beds: tuple[str, ...] = ()
        self._poor = 0
        self._faced: tuple[str, Matrix, npt.NDArray[np.float64]] | None = None
        self.now = QLabel("–")
        font = self.now.font()
        font.setPointSizeF(font.pointSizeF() * 1.2)
        font.setBold(True)
        self.now.setFont(font)
        self.typed = QLineEdit()
        self.typed.setObjectName("view_direction")
        self.typed.setPlaceholderText(tr("For example 125/26"))
        self.typed.returnPressed.connect(self._typed)
        go = QPushButton(tr("Look"))
        go.clicked.connect(self._typed)
        row = QHBoxLayout()
        row.addWidget(self.typed, 1)
        row.addWidget(go)
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(tr("Current"), self.now)
        form.addRow(tr("New"), row)

        self._buttons: dict[str, QPushButton] = {}
        grid = QGridLayout()
        grid.setSpacing(4)
        for i, (name, text, call) in enumerate(
            (
                ("beta", tr("Along fold axis"), self.along_beta),
                ("facing", tr("Face the plane"), self.face),
                ("strike", tr("Along strike"), self._along_strike),
                ("dip", tr("Down dip"), self._down_dip),
                ("line", tr("Along the line"), self.along_line),
                ("flip", tr("Opposite side"), self._flip),
            )
        ):
            button = QPushButton(text)
            button.clicked.connect(call)
            self._buttons[name] = button
            grid.addWidget(button, i // 2, i % 2)
        self.only_selected = QCheckBox(tr("Fold axis of selected bedding only"))
        self.only_selected.toggled.connect(self._forget_axis)
        self.only_selected.toggled.connect(self.refresh)
        self._verdict = QLabel()
        self._verdict.setWordWrap(True)
        self._verdict.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addLayout(form)
        layout.addLayout(grid)
        layout.addWidget(self.only_selected)
        layout.addWidget(self._verdict)
        layout.addStretch()
        studio.project_opened.connect(self._forget_axis)
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self._edited)
        studio.selection_changed.connect(self._selected)

    def show_direction(self, trend_deg: float, plunge_deg: float, orthographic: bool) -> None:
        """Show the direction of the view, in degrees."""
        self._direction = Line(wrap360(trend_deg), plunge_deg)
        line = format_line(self._direction, 0)
        self.now.setText(
            tr("{line} (orthographic)", line=line)
            if orthographic
            else tr("{line} (perspective)", line=line)
        )

    # --- directions --------------------------------------------------------------------------
    def _typed(self) -> None:
        try:
            line = parse_line(self.typed.text())
        except VomError as error:
            self._studio.warn(str(error))
            return
        self._turn(line)

    def along_beta(self) -> None:
        """Look along the fold axis of the bedding, where there is one."""
        axis = self._axis()
        if isinstance(axis, FoldAxis):
            self._turn_axis(axis.beta)

    def face(self) -> None:
        """Look perpendicular to the selected plane."""
        plane = self._plane()
        if plane is not None:
            # Against the upward normal; a vertical plane is looked at toward its dip direction
            # plus 180 degrees (CLI.md, ortho --plane).
            self._turn(Line(wrap360(plane.dip_direction_deg + 180.0), 90.0 - plane.dip_deg))

    def along_line(self) -> None:
        """Look along the selected lineation or intersection."""
        line = self._line()
        if line is not None:
            self._turn_axis(line)

    def _along_strike(self) -> None:
        plane = self._plane()
        if plane is not None:
            self._turn(Line(plane.strike_rhr_deg, 0.0))

    def _down_dip(self) -> None:
        plane = self._plane()
        if plane is not None:
            self._turn(Line(plane.dip_direction_deg, plane.dip_deg))

    def _flip(self) -> None:
        self._turn(Line(wrap360(self._direction.trend_deg + 180.0), -self._direction.plunge_deg))

    def _turn_axis(self, axis: Line) -> None:
        """Look along an axis: of its two views the one onto the exposed side; `Opposite side` gives
        the other one. Where no side is known, or both are edge on, the view is down the axis."""
        side = self._exposed_view()
        if side is not None and axis.vector() @ side < -_EDGE_ON:
            axis = Line.from_vector(-axis.vector(), directed=True)
        self._turn(axis)

    def _exposed_view(self) -> npt.NDArray[np.float64] | None:
        """Direction of a view onto the first mesh that is open."""
        for model_id, opened in self._studio.models.items():
            model = self._studio.records.get(model_id)
            if isinstance(model, Model) and isinstance(opened.data, Mesh):
                if self._faced is None or self._faced[:2] != (model_id, model.to_world):
                    trend, plunge = first_view(opened.data, transform.matrix(model.to_world))
                    view = Line(trend, plunge).vector()
                    self._faced = (model_id, model.to_world, view)
                return self._faced[2]
        return None

    def _turn(self, line: Line) -> None:
        self._look(line.trend_deg, line.plunge_deg)

    def why_no_beta(self) -> str | None:
        """Why there is no fold axis; None where there is one."""
        axis = self._axis()
        return axis if isinstance(axis, str) else None

    def why_no_plane(self) -> str | None:
        """Why no plane can be faced; None where one is selected."""
        return None if self._plane() is not None else tr("Select a plane first.")

    def origin_of(self, direction: Line) -> tuple[str, float | None]:
        """From which measurement a direction follows, as a sentence, and its 95 % error in degrees
        where it is known."""
        axis = self._axis()
        if isinstance(axis, FoldAxis) and angle_between_lines(axis.beta, direction) < SAME_DEG:
            text = tr_n(
                "Along the fold axis (beta) {line} of {count} bedding plane, 95 %: {error}; "
                "verdict: {verdict}, valid: {valid}.",
                "Along the fold axis (beta) {line} of {count} bedding planes, 95 %: {error}; "
                "verdict: {verdict}, valid: {valid}.",
                len(self._beds),
                line=format_line(axis.beta, 0),
                error=degrees(axis.error95_deg),
                verdict=axis.verdict,
                valid=axis.valid,
            )
            return text, axis.error95_deg
        for id_ in reversed(self._studio.selection.ids):
            feature = get_feature(self._studio.records, id_)
            if feature is None:
                continue
            measured = self._studio.measured([id_])[id_]
            line = measured.line or (measured.plane.pole() if measured.plane else None)
            if line is not None and angle_between_lines(line, direction) < SAME_DEG:
                error = measured.max_confidence95_deg
                if measured.registration_error_deg is not None:
                    error = TOTAL.value(self._studio.subject(feature, measured))
                values = {"feature": feature.name, "error": degrees(error)}
                if measured.line is not None:
                    return tr("Along {feature}, 95 %: {error}.", **values), error
                return tr("Perpendicular to {feature}, 95 %: {error}.", **values), error
        text = tr(
            "The direction was typed or set with the mouse. It follows from no measurement, so its "
            "error is unknown."
        )
        return text, None

    def why_no_line(self) -> str | None:
        """Why no line can be looked along; None where one is selected."""
        if self._line() is not None:
            return None
        return tr("Select a lineation or an intersection first.")

    # --- what they are taken from ------------------------------------------------------------
    def _plane(self) -> Plane | None:
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return None
        return self._studio.measured([current])[current].plane

    def _line(self) -> Line | None:
        current = self._studio.selection.current
        if current is None or get_feature(self._studio.records, current) is None:
            return None
        return self._studio.measured([current])[current].line

    def bedding(self) -> list[str]:
        """Ids of the bedding planes for the fold axis: feature types are never pooled silently."""
        beds = [t.id for t in self._studio.session.of(Typed) if _is_bed(t)]
        if not self.only_selected.isChecked():
            return beds
        chosen = set(self._studio.selection.ids)
        return [id_ for id_ in beds if id_ in chosen]

    def _axis(self) -> FoldAxis | str:
        """The fold axis of the bedding, or why there is none."""
        if self._axis_kept is None:
            self._beds = tuple(self.bedding())
            self._axis_kept = self._find_axis()
        return self._axis_kept

    def _find_axis(self) -> FoldAxis | str:
        measured = self._studio.measured(self._beds)
        self._poor = sum(
            m.verdict is not None and m.verdict.quality == "poor" for m in measured.values()
        )
        fitted = {id_: m.fit for id_, m in measured.items() if m.fit is not None}
        fits = list(fitted.values())
        if len(fits) < 2:
            if self.only_selected.isChecked():
                return tr(
                    "A fold axis needs at least 2 selected bedding planes; there are {count}.",
                    count=len(fits),
                )
            return tr(
                "A fold axis needs at least 2 bedding planes; there are {count}.", count=len(fits)
            )
        try:
            azimuths, dips, _ = normals_to_planes(np.array([fit.normal for fit in fits]))
            records = self._studio.records
            models = [model_of(records, get_feature(records, id_)) for id_ in fitted]
            return fold_axis(azimuths, dips, turns_of(models), bowed_deg(models))
        except VomError as error:
            return str(error)

    def _forget_axis(self, *_: object) -> None:
        """Every refresh of the commands asks for the axis: it is kept until something changes."""
        self._axis_kept = None

    def _edited(self, edit: Edit) -> None:
        # Thousands of planes are asked for it: most edits are of other features.
        touched = set(self._studio.affected(edit))
        if not touched.isdisjoint(self._beds) or any(
            _is_bed(self._studio.records.get(id_)) for id_ in touched
        ):
            self._forget_axis()
        self.refresh()

    def _selected(self, *_: object) -> None:
        if self.only_selected.isChecked():
            self._forget_axis()
        self.refresh()

    def _poor_planes(self) -> tuple[str, ...]:
        """A warning where planes are poor: the scatter of planes ignores the error of each."""
        if not self._poor:
            return ()
        return (
            tr_n(
                "{count} of these planes is poor: the error of the fold axis is computed from "
                "scatter alone and is too small.",
                "{count} of these planes are poor: the error of the fold axis is computed from "
                "scatter alone and is too small.",
                self._poor,
            ),
        )

    def refresh(self, *_: object) -> None:
        """Show the fold axis with its verdict, and which directions there are now."""
        once_told(self._show)

    def _show(self) -> None:
        axis, plane = self._axis(), self._plane()
        _enable(self._buttons["beta"], None if isinstance(axis, FoldAxis) else axis)
        why = None if plane is not None else tr("Select a plane first.")
        for name in ("facing", "strike", "dip"):
            _enable(self._buttons[name], why)
        _enable(self._buttons["line"], self.why_no_line())
        if isinstance(axis, FoldAxis):
            text = tr_n(
                "<b>Fold axis (beta) {line}</b> of {count} bedding plane, 95 %: {largest} × "
                "{smallest}<br>Verdict: {verdict} (valid: {valid})",
                "<b>Fold axis (beta) {line}</b> of {count} bedding planes, 95 %: {largest} × "
                "{smallest}<br>Verdict: {verdict} (valid: {valid})",
                len(self._beds),
                line=format_line(axis.beta, 0),
                largest=degrees(axis.max_confidence95_deg),
                smallest=degrees(axis.min_confidence95_deg),
                verdict=axis.verdict,
                valid=axis.valid,
            )
            reasons = (f"• {reason}" for reason in (*axis.reasons, *self._poor_planes()))
            self._verdict.setText("<br>".join([text, *reasons]))
        else:
            self._verdict.setText(axis)


def _enable(button: QPushButton, why_not: str | None) -> None:
    button.setEnabled(why_not is None)
    button.setToolTip("" if why_not is None else tr("Not now: {reason}", reason=why_not))


def _is_bed(record: Record | None) -> bool:
    """A picked plane of the type bedding."""
    return isinstance(record, Typed) and record.type_id == "bedding" and is_picked_plane(record)
