"""Status line with tool hint, coordinates, frame, selection, GIS layers and running job."""

from __future__ import annotations

from datetime import datetime

from PySide6.QtCore import QRect, Qt, QTimer
from PySide6.QtGui import QAction, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QProgressBar,
    QStatusBar,
    QStyle,
    QStyleOption,
    QToolButton,
    QWidget,
)

from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.project.records import Model
from vomstudio.studio.tools.interaction_types import Pointer, PointerEvent
from vomstudio.ui.base.controls import ElidedLabel, HintLabel, Label, escape_markup
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio

_MARGIN = 6


class StatusLine(QStatusBar):
    """Status line of the studio; a running job has a progress bar and a stop button."""

    def __init__(self, studio: Studio, frame_action: QAction) -> None:
        super().__init__()
        set_help_topic(self, "numbers.md#the-status-line")
        self._studio = studio
        self._layers_time: datetime | None = None
        self._hint = HintLabel()
        self._photo_hint = ""
        self._position = Label()
        self._badge = QToolButton()
        self._badge.setObjectName("frame_badge")
        self._badge.setAutoRaise(True)
        self._badge.clicked.connect(frame_action.trigger)
        self._selected = Label()
        self._layers = Label()
        self._job = ElidedLabel()
        self._bar = QProgressBar()
        self._bar.setFixedWidth(110)
        self._stop = QToolButton()
        self._stop.setText(tr("Stop"))
        self._stop.clicked.connect(self._stop_job)
        self.addWidget(self._hint, 1)
        self._permanent_widgets: tuple[QWidget, ...] = (
            self._position,
            self._badge,
            self._selected,
            self._layers,
            self._job,
            self._bar,
            self._stop,
        )
        for widget in self._permanent_widgets:
            self.addPermanentWidget(widget)
        # A job that ends within 0.2 s is not shown.
        self._jobs_timer = QTimer(self, singleShot=True, interval=200)
        self._jobs_timer.timeout.connect(self._show_jobs)
        studio.jobs_changed.connect(self._jobs_changed)
        studio.layers_written.connect(self._layers_written)
        for signal in (
            studio.project_opened,
            studio.edited,
            studio.selection_changed,
            studio.model_loaded,
            studio.active_tool_changed,
            studio.tool_changed_signal,
        ):
            signal.connect(self.refresh)
        studio.project_opened.connect(self._begin_project)
        # A message that does not fit is elided; the tooltip contains the full text.
        self.messageChanged.connect(self.setToolTip)
        self._show_jobs()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Paint an elided message, because Qt would paint a long one over its neighbours."""
        painter, option = QPainter(self), QStyleOption()
        option.initFrom(self)
        self.style().drawPrimitive(QStyle.PrimitiveElement.PE_PanelStatusBar, option, painter, self)
        if self.currentMessage():
            available_space = self._message_area()
            elided_text = painter.fontMetrics().elidedText(
                self.currentMessage(), Qt.TextElideMode.ElideMiddle, available_space.width()
            )
            painter.setPen(self.palette().windowText().color())
            painter.drawText(
                available_space,
                Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter,
                elided_text,
            )

    def _begin_project(self) -> None:
        self._position.clear()
        self._layers.clear()
        self._layers.setToolTip("")
        self._layers_time = None

    def _message_area(self) -> QRect:
        """Return the rectangle for a message, which ends at the first permanent widget."""
        ends = [widget.x() for widget in self._permanent_widgets if widget.isVisible()]
        right = min(ends, default=self.width()) - 2 * _MARGIN
        return QRect(_MARGIN, 0, max(0, right - _MARGIN), self.height())

    def refresh(self, *_: object) -> None:
        """Update the hint, selection and frame."""
        studio, previous_text = self._studio, self._hint.text()
        if self._photo_hint:
            self._hint.setText(self._photo_hint)
        elif (tool := studio.tool) is not None:
            self._hint.setText(tool.hint())
        else:
            self._hint.setText(
                tr(
                    "Navigate: drag to orbit, wheel to zoom, Shift+drag to pan; "
                    "click a feature to select it, Ctrl+click to add it."
                )
            )
        if self._hint.text() != previous_text:
            # The user has continued, so the hint for the next click replaces an earlier message.
            self.clearMessage()
        count = len(studio.selection.ids)
        self._selected.setText(tr("{count} selected", count=count) if count else "")
        self._badge.setVisible(bool(studio.session.of(Model)))
        known_north, rotation_findings = studio.is_north_known(), studio.turn_findings()
        frames = list(dict.fromkeys(m.frame for m in studio.session.of(Model)))
        has_no_frame = not any(frame.has_up or frame.has_metres for frame in frames)
        frame_text = (
            tr("⚠ Local frame: not registered") if has_no_frame else f"⚠ {studio.frame_name()}"
        )
        if known_north and rotation_findings:
            worst_deg = max(finding.values["rotation95_deg"] for finding in rotation_findings)
            frame_text = tr(
                "{frame}, rotation error {error:.0f}°", frame=frame_text, error=worst_deg
            )
        self._badge.setText(
            studio.frame_name() if known_north and not rotation_findings else frame_text
        )
        subject = (
            tr("Frame of displayed coordinates and orientations. Click to change it.")
            if known_north
            else tr("Orientations are not geographic yet. Click to declare the model's frame.")
        )
        lines = [
            *(item.known_text() for item in frames),
            *(item.message for item in rotation_findings),
            subject,
        ]
        self._badge.setToolTip(escape_markup("\n".join(lines)))
        self._badge.setStyleSheet(
            ""
            if known_north and not rotation_findings
            else "background: #e69f00; color: black; padding: 1px 6px;"
        )

    def show_photo(self, text: str) -> None:
        """Show the status text of the visible photo, or "" if the outcrop is visible."""
        if bool(text) != bool(self._photo_hint):
            self._position.clear()
        self._photo_hint = text
        if text:
            self._hint.setText(text)
        else:
            self.refresh()

    def show_pointer(self, event: PointerEvent) -> None:
        """Show the World coordinates under the cursor."""
        if event.kind is not Pointer.MOVE:
            return
        model = self._studio.records.get(event.hit.model_id) if event.hit else None
        if event.hit is None or not isinstance(model, Model):
            self._position.setText("")
            return
        point = transform.apply(model.to_world, [event.hit.position])[0]
        names = (tr("E"), tr("N"), tr("Z")) if model.frame.has_north else ("x", "y", "z")
        thin_space = "\N{NARROW NO-BREAK SPACE}"
        values = (f"{value:,.3f}".replace(",", thin_space) for value in point)
        text = "  ".join(f"{name} {value}" for name, value in zip(names, values, strict=True))
        self._position.setText(f"{text} {'m' if model.frame.has_metres else tr('units')}")

    def _jobs_changed(self) -> None:
        if not self._studio.jobs.visible():
            self._jobs_timer.stop()
            self._show_jobs()
        elif not self._jobs_timer.isActive():
            self._jobs_timer.start()

    def _show_jobs(self) -> None:
        jobs = self._studio.jobs.visible()
        for widget in (self._job, self._bar, self._stop):
            widget.setVisible(bool(jobs))
        if jobs:
            # The newest job is shown, because the user waits for the last request.
            self._job.setText(jobs[-1].text())
            self._stop.setText(tr("Pause") if jobs[-1].is_resumable else tr("Stop"))
            self._bar.setRange(0, jobs[-1].total or 0)
            self._bar.setValue(jobs[-1].done)

    def _stop_job(self) -> None:
        for job in self._studio.jobs.visible()[-1:]:
            self._studio.jobs.cancel(job)

    def _layers_written(self, path: str) -> None:
        if path:
            self._layers_time = datetime.now()
            self._layers.setText("")
            self._layers.setToolTip(escape_markup(path))
        elif self._layers_time:
            self._layers.setText(tr("GIS layers saved at {time:%H:%M}", time=self._layers_time))
        else:
            self._layers.setText(tr("GIS layers not saved yet"))
