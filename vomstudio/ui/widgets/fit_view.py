"""View of an attitude with its verdict, one reason and folded details, for panels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.kinds import find_kind
from vomstudio.project.measurement import Measurement
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import strip_mnemonic
from vomstudio.ui.base.controls import Label, escape_markup, fold_button, lay_out_now
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import orientation_text
from vomstudio.ui.base.remedies import remedy_command, short_reason


@dataclass(frozen=True)
class _Line:
    """Row with two figures; its title and tip are translated when they are shown."""

    title: str
    tip: str
    first: Figure
    second: Figure
    between: str = " / "


_ERROR = _Line(
    to_translate("95 % error"),
    to_translate("Total 95 % error, which determines the verdict, and the registration error."),
    catalogue.TOTAL_ERROR,
    catalogue.REGISTRATION_ERROR,
)
_CONFIDENCE = _Line(
    to_translate("Fit 95 %"),
    to_translate("Half-angles of the joint 95 % region of the fit alone."),
    catalogue.MAX_CONFIDENCE,
    catalogue.MIN_CONFIDENCE,
    " × ",
)
_SIZE = _Line(
    to_translate("Extent / RMS"),
    to_translate("Longest axis of the trace, and RMS distance from the plane."),
    catalogue.EXTENT,
    catalogue.RMS,
)
_AREA = _Line(
    to_translate("Area"),
    to_translate("Area of the patch."),
    catalogue.AREA,
    catalogue.AREA,
)
_LINES = (
    _ERROR,
    _CONFIDENCE,
    _Line(
        to_translate("± dip / dir."),
        to_translate("95 % errors of dip and dip direction (undefined if nearly horizontal)."),
        catalogue.DIP_ERROR,
        catalogue.DIP_DIRECTION_ERROR,
    ),
    _Line(
        to_translate("Ang. error"),
        to_translate("Hyperbolic angular error (Quinn and Ehlmann 2019), largest × smallest."),
        catalogue.MAX_ANGULAR_ERROR,
        catalogue.MIN_ANGULAR_ERROR,
        " × ",
    ),
    _Line(
        to_translate("M / K"),
        to_translate("M = ln(l1/l3), good above 4; K = ln(l1/l2) / ln(l2/l3), good below 0.8."),
        catalogue.M,
        catalogue.K,
    ),
    _Line(
        to_translate("Copl. / coll."),
        to_translate("Coplanarity 1/l3 and collinearity l1/l2 (textbook, eq. 20 and 21)."),
        catalogue.COPLANARITY,
        catalogue.COLLINEARITY,
    ),
    _SIZE,
    _AREA,
)

_LINE_ROWS = (_ERROR, _CONFIDENCE, _SIZE)
"""Rows that apply to lines."""


class FitView(QWidget):
    """View of the orientation and verdict of a measurement, with its details folded.

    If the verdict is not good, one short reason is displayed with the button of the command that
    acts on it. Further reasons and the details can be unfolded in place.

    Parameters
    ----------
    actions : mapping of str to QAction, optional
        Actions by command name.
    """

    def __init__(self, actions: Mapping[str, QAction] | None = None) -> None:
        super().__init__()
        self._actions = actions or {}
        self._action: QAction | None = None
        self._badge = Label()
        self._badge.setFixedSize(18, 18)
        self._plane = Label("–")
        font = self._plane.font()
        font.setPointSizeF(font.pointSizeF() * 1.35)
        font.setBold(True)
        self._plane.setFont(font)
        self._verdict = Label()
        header_layout = QHBoxLayout()
        header_layout.addWidget(self._plane)
        header_layout.addStretch()
        header_layout.addWidget(self._badge)
        header_layout.addWidget(self._verdict)
        self._details = _wrapped_label()
        self._reason = _wrapped_label()
        self.remedy = QPushButton()
        self.remedy.setObjectName("remedy")
        self.remedy.clicked.connect(self._run_action)
        row = QHBoxLayout()
        row.addWidget(self._reason, 1)
        row.addWidget(self.remedy, 0, Qt.AlignmentFlag.AlignTop)
        self.more = fold_button("more_reasons")
        self._reasons = _wrapped_label()
        self._reasons.hide()
        self.more.toggled.connect(self._unfold_reasons)
        self.details = fold_button("fit_details", tr("Details"))
        self._figures = self._create_details()
        self._figures.hide()
        self.details.toggled.connect(self._unfold_details)
        set_help_topic(self._plane, "numbers.md#orientation")
        set_help_topic(self._badge, catalogue.QUALITY)
        set_help_topic(self._verdict, catalogue.QUALITY)
        for label in (self._reason, self._reasons):
            set_help_topic(label, catalogue.REASONS)
        set_help_topic(self, "numbers.md")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(3)
        layout.addLayout(header_layout)
        layout.addWidget(self._details)
        layout.addLayout(row)
        layout.addWidget(self.more)
        layout.addWidget(self._reasons)
        layout.addWidget(self.details)
        layout.addWidget(self._figures)
        for label in (self._plane, self._details, self._reason, self._reasons):
            label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)

    def _create_details(self) -> QWidget:
        """Create the rows of figures, and the notes below them."""
        page = QWidget()
        grid = QGridLayout(page)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(1, 1)
        self._values: list[Label] = []
        self._titles: list[Label] = []
        for row, line in enumerate(_LINES):
            label, value = Label(tr(line.title)), Label("–")
            label.setToolTip(tr(line.tip))
            value.setToolTip(tr(line.tip))
            set_help_topic(label, line.first)
            set_help_topic(value, partial(_figure_at, value, line))
            value.setAlignment(Qt.AlignmentFlag.AlignRight)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            grid.addWidget(label, row, 0)
            grid.addWidget(value, row, 1)
            self._values.append(value)
            self._titles.append(label)
        self._notes = _wrapped_label()
        self._notes.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        grid.addWidget(self._notes, len(_LINES), 0, 1, 2)
        return page

    def show_measurement(
        self, measurement: Measurement | None, notation: str, *, is_local: bool
    ) -> None:
        """Show a measurement, or dashes if no measurement is given.

        Parameters
        ----------
        notation : str
            Notation of attitudes.
        is_local : bool
            Whether the frame of the model is unknown.
        """
        verdict = measurement.verdict if measurement else None
        texts = self._show_header(measurement, notation, is_local=is_local)
        quality = verdict.quality if verdict else None
        self._badge.setPixmap(theme.verdict_icon(quality).pixmap(18, 18))
        self._verdict.setText(quality or "")
        for label in (self._badge, self._verdict):
            label.setToolTip(verdict.limits.description if verdict else "")
        self._details.setText("\n".join(texts))
        self._details.setVisible(bool(texts))
        reasons = list(verdict.reasons) if verdict else []
        if not reasons and measurement is not None and measurement.problem:
            reasons = [measurement.problem]
        self._show_reasons(reasons)
        self._show_details(measurement)
        lay_out_now(self)

    def _show_header(
        self, measurement: Measurement | None, notation: str, *, is_local: bool
    ) -> Sequence[str]:
        """Show the attitude or main figure, and return the remaining lines of the kind."""
        feature_kind = find_kind(measurement.kind) if measurement else None
        texts = feature_kind.words(measurement) if feature_kind and measurement else []
        is_attitude = measurement is not None and (
            measurement.plane is not None or measurement.line is not None
        )
        if texts and not is_attitude:
            # The first line contains the main figure with its name.
            self._plane.setText(texts[0])
            texts = texts[1:]
        else:
            self._plane.setText(orientation_text(measurement, notation) if measurement else "–")
        self._plane.setToolTip(
            tr("Local frame: unregistered model with unknown north and scale.") if is_local else ""
        )
        return texts

    def _show_reasons(self, reasons: Sequence[Finding]) -> None:
        """Show the first reason in short form with its command; others are unfolded in place."""
        first_reason_lines = reasons[0] if reasons else None
        self._reason.setText("" if first_reason_lines is None else short_reason(first_reason_lines))
        self._reason.setToolTip(
            "" if first_reason_lines is None else escape_markup(first_reason_lines.message)
        )
        self._reason.setVisible(first_reason_lines is not None)
        self._set_action("" if first_reason_lines is None else remedy_command(first_reason_lines))
        self.more.setVisible(bool(reasons))
        count = len(reasons) - 1
        self.more.setText(
            tr_n("{count} further reason", "{count} further reasons", count)
            if count > 0
            else tr("Why")
        )
        self._reasons.setText("\n".join(f"• {reason.message}" for reason in reasons))
        self._reasons.setVisible(bool(reasons) and self.more.isChecked())

    def _set_action(self, command: str) -> None:
        if self._action is not None:
            self._action.changed.disconnect(self._follow_action)
        self._action = self._actions.get(command)
        if self._action is not None:
            self._action.changed.connect(self._follow_action)
        self._follow_action()

    def _follow_action(self) -> None:
        """Offer the command that acts on the reason while it can run."""
        action = self._action
        self.remedy.setVisible(action is not None and action.isEnabled())
        if action is not None:
            self.remedy.setText(strip_mnemonic(action.text()).rstrip("…"))
            self.remedy.setToolTip(action.toolTip())

    def _run_action(self) -> None:
        if self._action is not None:
            self._action.trigger()

    def _show_details(self, measurement: Measurement | None) -> None:
        fit = measurement.fit if measurement else None
        texts = ["–" if measurement is None else _line_text(line, measurement) for line in _LINES]
        for line, value, title, text in zip(_LINES, self._values, self._titles, texts, strict=True):
            value.setText(text)
            # An unfinished trace keeps all rows, so that the layout does not jump.
            has_row = line is not _AREA and (measurement is None or fit is not None)
            for widget in (value, title):
                widget.setVisible(has_row or text != "–")
        notes = measurement.verdict.notes if measurement and measurement.verdict else ()
        self._notes.setText("\n".join(f"◦ {note.message}" for note in notes))
        self._notes.setVisible(bool(notes))
        has_details = measurement is not None and (bool(notes) or any(t != "–" for t in texts))
        self.details.setVisible(has_details)
        self._figures.setVisible(has_details and self.details.isChecked())

    def _unfold_reasons(self, is_unfolded: bool) -> None:
        self._reasons.setVisible(is_unfolded)
        lay_out_now(self)

    def _unfold_details(self, is_unfolded: bool) -> None:
        self._figures.setVisible(is_unfolded)
        lay_out_now(self)


def _wrapped_label() -> Label:
    label = Label()
    label.setWordWrap(True)
    return label


def _figure_at(value: Label, line: _Line, position: QPoint) -> Figure:
    """Return the figure of a row at a position; the text is right-aligned."""
    text_width = value.fontMetrics().horizontalAdvance
    _, separator, second = value.text().partition(line.between)
    return (
        line.second
        if position.x() > value.width() - text_width(second) and separator
        else line.first
    )


def _line_text(line: _Line, measurement: Measurement) -> str:
    """Return the text of both figures in a row; lines have only errors and a size."""
    subject = Subject(None, measurement)
    if line is _AREA:
        return line.first.text(subject) if line.first.value(subject) is not None else "–"
    first, second = line.first.text(subject), line.second.text(subject)
    if measurement.fit is None:
        if line not in _LINE_ROWS or line.first.value(subject) is None:
            return "–"
        # Without an axis, the region is a circular cone.
        if line is _CONFIDENCE and measurement.confidence_axis is None:
            return first
    size = f"   (n {catalogue.N_POINTS.value(subject)})" if line is _SIZE else ""
    return f"{first}{line.between}{second}{size}"
