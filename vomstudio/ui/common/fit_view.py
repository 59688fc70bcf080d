"""A plane with its errors and its verdict, as panels show it."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from vomstudio.document.measurements import Measurement
from vomstudio.tools.measure import dimension_lines
from vomstudio.ui.common import theme
from vomstudio.ui.common.wording import area, degrees, length, number, orientation_text

_FIELDS = (
    ("confidence", "95 % conf.", "Half-angles of the joint 95 % confidence region of the plane, "
     "largest × smallest"),
    ("split", "± dip / dir.", "The same confidence along and across the dip; the dip direction "
     "is undefined near horizontal"),
    ("angular", "Ang. error", "Hyperbolic angular error of the scatter (Quinn and Ehlmann 2019), "
     "largest × smallest"),
    ("indices", "M / K", "M = ln(l1/l3), good over 4; K = ln(l1/l2)/ln(l2/l3), good under 0.8"),
    ("textbook", "Copl. / coll.", "Coplanarity 1/l3 and collinearity l1/l2 (textbook eq. 20, 21)"),
    ("size", "Extent / RMS", "Longest axis of the trace, and the root mean square distance of its "
     "points from the plane"),
)  # fmt: skip


class FitView(QWidget):
    """`reasons_shown`: the others wait in the tooltip, where the panel has little room."""

    def __init__(self, reasons_shown: int | None = None) -> None:
        super().__init__()
        self._reasons_shown = reasons_shown
        self._badge = QLabel()
        self._badge.setFixedSize(18, 18)
        self._plane = QLabel("–")
        font = self._plane.font()
        font.setPointSizeF(font.pointSizeF() * 1.35)
        font.setBold(True)
        self._plane.setFont(font)
        self._plane.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._word = QLabel()
        head = QHBoxLayout()
        head.addWidget(self._plane)
        head.addStretch()
        head.addWidget(self._badge)
        head.addWidget(self._word)
        grid = QGridLayout()
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(1, 1)
        self._values: dict[str, QLabel] = {}
        self._titles: dict[str, QLabel] = {}
        for row, (name, title, tip) in enumerate(_FIELDS):
            label, value = QLabel(title), QLabel("–")
            label.setToolTip(tip)
            value.setToolTip(tip)
            value.setAlignment(Qt.AlignmentFlag.AlignRight)
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            grid.addWidget(label, row, 0)
            grid.addWidget(value, row, 1)
            self._values[name] = value
            self._titles[name] = label
        self._more = QLabel()
        self._more.setWordWrap(True)
        self._more.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._reasons = QLabel()
        self._reasons.setWordWrap(True)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(3)
        layout.addLayout(head)
        layout.addLayout(grid)
        layout.addWidget(self._more)
        layout.addWidget(self._reasons)

    def show_measurement(self, measured: Measurement | None, notation: str, *, local: bool) -> None:
        fit = measured.fit if measured else None
        verdict = measured.verdict if measured else None
        self._plane.setText(orientation_text(measured, notation, None) if measured else "–")
        self._plane.setToolTip("Local frame: the model is not registered" if local else "")
        quality = verdict.quality if verdict else None
        self._badge.setPixmap(theme.verdict_icon(quality).pixmap(18, 18))
        self._word.setText(quality or "")
        values = dict.fromkeys(self._values, "–")
        if measured is not None and fit is not None:
            values = {
                "confidence": f"{degrees(fit.max_confidence95_deg)} × "
                f"{degrees(fit.min_confidence95_deg)}",
                "split": f"{degrees(fit.dip_error_deg)} / {degrees(fit.dip_direction_error_deg)}",
                "angular": f"{degrees(fit.max_angular_error_deg)} × "
                f"{degrees(fit.min_angular_error_deg)}",
                "indices": f"{number(fit.M)} / {number(fit.K)}",
                "textbook": f"{number(fit.coplanarity)} / {number(fit.collinearity)}",
                "size": f"{length(fit.extent, metric=measured.metric)} / "
                f"{length(fit.rms, metric=measured.metric)}   (n {fit.n})",
            }
        elif measured is not None:
            values |= _line_values(measured)
        for name, text in values.items():
            self._values[name].setText(text)
            # What has no fit has no indices; an unfinished trace keeps its rows: nothing jumps.
            for widget in (self._values[name], self._titles[name]):
                widget.setVisible(measured is None or fit is not None or text != "–")
        self._more.setText("\n".join(_more(measured)) if measured else "")
        self._more.setVisible(bool(self._more.text()))
        reasons = verdict.reasons if verdict else ()
        if not reasons and measured is not None and measured.problem:
            reasons = (measured.problem,)
        lines = [f"• {reason}" for reason in reasons]
        shown = lines[: self._reasons_shown]
        if len(shown) < len(lines):
            shown[-1] += f"  (+{len(lines) - len(shown)})"
        self._reasons.setText("\n".join(shown))
        self._reasons.setToolTip("\n".join(lines))
        self._reasons.setVisible(bool(reasons))


def _line_values(measured: Measurement) -> dict[str, str]:
    values = {}
    if measured.max_confidence95_deg is not None:
        values["confidence"] = degrees(measured.max_confidence95_deg)
        # Without an axis it is a round cone.
        if measured.confidence_axis is not None:
            values["confidence"] += f" × {degrees(measured.min_confidence95_deg)}"
    if (fit := measured.line_fit) is not None:
        sizes = (length(size, metric=measured.metric) for size in (fit.length, fit.rms))
        values["size"] = f"{' / '.join(sizes)}   (n {fit.n})"
    return values


def _more(measured: Measurement) -> list[str]:
    """What only lines, patches, intersections and dimensions have."""
    lines = []
    if measured.area_m2 is not None:
        lines.append(f"Area {area(measured.area_m2, metric=measured.metric)}")
    if measured.rake_deg is not None:
        lines.append(
            f"Rake {measured.rake_deg:.0f}°, {degrees(measured.off_plane_deg)} off its plane"
        )
    if measured.slip_rake_deg is not None:
        lines.append(f"Slip of the hanging wall: rake {measured.slip_rake_deg:.0f}°")
    if measured.angle_deg is not None:
        lines.append(f"Angle between the planes {degrees(measured.angle_deg)}")
    if measured.dimension:
        lines += dimension_lines(measured.dimension, metric=measured.metric)
    return lines
