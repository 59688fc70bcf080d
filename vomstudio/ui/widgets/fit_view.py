"""View of a plane with its errors and verdict, for panels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QSizePolicy, QVBoxLayout, QWidget

from vomstudio.core.words import to_translate, tr
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Subject
from vomstudio.project.kinds import kind_named
from vomstudio.project.measurement import Measurement
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, escape_markup, lay_out_now
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.number_formatting import orientation_text


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
    to_translate(
        "The larger half-angle of the 95 % region, with the errors of fit, resolution and "
        "registration, which decides the verdict; and by how much the registration can tilt it."
    ),
    catalogue.TOTAL,
    catalogue.REGISTRATION_ERROR,
)
_CONFIDENCE = _Line(
    to_translate("Fit 95 %"),
    to_translate(
        "Half-angles of the joint 95 % confidence region of the fit alone, largest × smallest."
    ),
    catalogue.MAX_CONFIDENCE,
    catalogue.MIN_CONFIDENCE,
    " × ",
)
_SIZE = _Line(
    to_translate("Extent / RMS"),
    to_translate(
        "Longest axis of the trace, and root mean square distance of its points to the plane."
    ),
    catalogue.EXTENT,
    catalogue.RMS,
)
_LINES = (
    _ERROR,
    _CONFIDENCE,
    _Line(
        to_translate("± dip / dir."),
        to_translate(
            "95 % confidence of dip and of dip direction; the dip direction is undefined for a "
            "nearly horizontal plane."
        ),
        catalogue.DIP_ERROR,
        catalogue.DIP_DIRECTION_ERROR,
    ),
    _Line(
        to_translate("Ang. error"),
        to_translate(
            "Hyperbolic angular error of the scatter (Quinn and Ehlmann 2019), largest × smallest."
        ),
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
)

_LINE_ROWS = (_ERROR, _CONFIDENCE, _SIZE)
"""Rows that apply to lines."""


class FitView(QWidget):
    """View of the orientation, errors, indices and verdict of a measurement.

    Parameters
    ----------
    reasons_shown : int, optional
        Maximum number of displayed reasons and notes; the tooltip contains all of them.
    """

    def __init__(self, reasons_shown: int | None = None) -> None:
        super().__init__()
        self._reasons_shown = reasons_shown
        self._badge = Label()
        self._badge.setFixedSize(18, 18)
        self._plane = Label("–")
        font = self._plane.font()
        font.setPointSizeF(font.pointSizeF() * 1.35)
        font.setBold(True)
        self._plane.setFont(font)
        self._plane.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._verdict = Label()
        head = QHBoxLayout()
        head.addWidget(self._plane)
        head.addStretch()
        head.addWidget(self._badge)
        head.addWidget(self._verdict)
        grid = QGridLayout()
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(1, 1)
        self._values: list[Label] = []
        self._titles: list[Label] = []
        self._rows: object = None
        for row, line in enumerate(_LINES):
            label, value = Label(tr(line.title)), Label("–")
            label.setToolTip(tr(line.tip))
            value.setToolTip(tr(line.tip))
            explain(label, line.first)
            explain(value, partial(_figure_at, value, line))
            value.setAlignment(Qt.AlignmentFlag.AlignRight)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            grid.addWidget(label, row, 0)
            grid.addWidget(value, row, 1)
            self._values.append(value)
            self._titles.append(label)
        self._details = Label()
        self._details.setWordWrap(True)
        self._details.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._reasons = Label()
        self._reasons.setWordWrap(True)
        explain(self._plane, "numbers.md#orientation")
        explain(self._badge, catalogue.QUALITY)
        explain(self._verdict, catalogue.QUALITY)
        explain(self._reasons, catalogue.REASONS)
        explain(self, "numbers.md")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(3)
        layout.addLayout(head)
        layout.addLayout(grid)
        layout.addWidget(self._details)
        layout.addWidget(self._reasons)

    def show_measurement(self, measured: Measurement | None, notation: str, *, local: bool) -> None:
        """Show a measurement, or dashes if no measurement is given.

        Parameters
        ----------
        notation : str
            Notation of attitudes.
        local : bool
            Whether the frame of the model is unknown.
        """
        fit = measured.fit if measured else None
        verdict = measured.verdict if measured else None
        self._plane.setText(orientation_text(measured, notation) if measured else "–")
        self._plane.setToolTip(
            tr("Local frame: the model is not registered, so north and scale are unknown.")
            if local
            else ""
        )
        quality = verdict.quality if verdict else None
        self._badge.setPixmap(theme.verdict_icon(quality).pixmap(18, 18))
        self._verdict.setText(quality or "")
        for label in (self._badge, self._verdict):
            label.setToolTip(verdict.limits.description if verdict else "")
        texts = ["–" if measured is None else _text(line, measured) for line in _LINES]
        for value, title, text in zip(self._values, self._titles, texts, strict=True):
            value.setText(text)
            # An unfinished trace keeps all rows, so that the layout does not jump.
            for widget in (value, title):
                widget.setVisible(measured is None or fit is not None or text != "–")
        kind = kind_named(measured.kind) if measured else None
        self._details.setText("\n".join(kind.words(measured)) if kind and measured else "")
        self._details.setVisible(bool(self._details.text()))
        reasons = [str(reason) for reason in verdict.reasons] if verdict else []
        if not reasons and measured is not None and measured.problem:
            reasons = [str(measured.problem)]
        lines = [f"• {reason}" for reason in reasons]
        # Notes do not lower the verdict and have a different bullet.
        lines += [f"◦ {note.message}" for note in (verdict.notes if verdict else ())]
        visible_lines = lines[: self._reasons_shown]
        if len(visible_lines) < len(lines):
            visible_lines[-1] += f"  (+{len(lines) - len(visible_lines)})"
        self._reasons.setText("\n".join(visible_lines))
        self._reasons.setToolTip(escape_markup("\n".join(lines)))
        self._reasons.setVisible(bool(lines))
        rows = (self._details.text(), self._reasons.text(), [w.isHidden() for w in self._values])
        if rows != self._rows:
            self._rows = rows
            lay_out_now(self)


def _figure_at(value: Label, line: _Line, position: QPoint) -> Figure:
    """Return the figure of a row at a position; the text is right-aligned."""
    text_width = value.fontMetrics().horizontalAdvance
    _, separator, second = value.text().partition(line.between)
    return (
        line.second
        if position.x() > value.width() - text_width(second) and separator
        else line.first
    )


def _text(line: _Line, measured: Measurement) -> str:
    """Return the text of both figures in a row; lines have only errors and a size."""
    subject = Subject(None, measured)
    first, second = line.first.text(subject), line.second.text(subject)
    if measured.fit is None:
        if line not in _LINE_ROWS or line.first.value(subject) is None:
            return "–"
        # Without an axis, the region is a circular cone.
        if line is _CONFIDENCE and measured.confidence_axis is None:
            return first
    size = f"   (n {catalogue.N_POINTS.value(subject)})" if line is _SIZE else ""
    return f"{first}{line.between}{second}{size}"
