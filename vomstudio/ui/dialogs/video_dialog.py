"""Dialog that extracts frames from a video and opens them as photos."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QMessageBox,
    QProgressBar,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.survey.survey_options import VideoFrameOptions
from vomstudio.photogrammetry.survey.video import FrameReport, is_extraction_folder, video_verdict
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.survey_tasks import EXTRACT_FRAMES, FramesRequest
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.controls import Label, escape_markup, file_field, rich_label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.widgets.options_form import OptionFields

_MAX_SHOWN_GAPS = 6


class VideoDialog(QDialog):
    """Dialog that extracts frames in a job, and can be closed while the job runs."""

    def __init__(
        self, parent: QWidget, studio: Studio, open_photos: Callable[[Path], None]
    ) -> None:
        super().__init__(parent)
        set_help_topic(self, "photos.md#frames-from-a-video")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Video frames"))
        self.setMinimumWidth(620)
        self._studio, self._open_photos = studio, open_photos
        self._job: RunningJob | None = None
        intro = Label(
            tr(
                "The sharpest frame of each interval is saved unless blurred or redundant. Photos"
                " are better: larger, sharper, and with camera and position data."
            )
        )
        intro.setWordWrap(True)
        self.video, video_row = file_field("video_file", tr("Choose…"), self._browse_video)
        self.folder, folder_row = file_field("video_folder", tr("Choose…"), self._browse_folder)
        self.options = OptionFields(VideoFrameOptions, "video")
        form = QFormLayout()
        form.addRow(tr("Video"), video_row)
        self.options.add_rows(form)
        form.addRow(tr("Folder"), folder_row)
        self.progress_bar = QProgressBar()
        self.progress_bar.hide()
        self.result_label = rich_label()
        self.result_label.setObjectName("video_said")
        self.result_label.setWordWrap(True)
        self.result_label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.start_button = buttons.addButton(tr("Extract frames"), role)
        self.stop_button = buttons.addButton(tr("Stop"), role)
        self.start_button.clicked.connect(self._start)
        self.stop_button.clicked.connect(self._stop)
        buttons.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addWidget(intro)
        layout.addSpacing(4)
        layout.addLayout(form)
        layout.addWidget(self.progress_bar)
        layout.addWidget(self.result_label)
        layout.addStretch(1)
        layout.addWidget(buttons)
        for field in (self.video, self.folder):
            field.textChanged.connect(self._refresh)
        studio.jobs_changed.connect(self._refresh)
        self._refresh()

    # --- file choice -------------------------------------------------------------------------
    def _browse_video(self) -> None:
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Choose a video of the outcrop"),
            start_folder(self._studio),
            file_filters.videos(),
        )
        if name:
            self.choose_video(Path(name))

    def choose_video(self, path: Path) -> None:
        """Set the video, and a folder beside it for the frames."""
        self.video.setText(str(path))
        self.folder.setText(str(path.with_name(f"{path.stem} frames")))

    def _browse_folder(self) -> None:
        name = QFileDialog.getExistingDirectory(
            self, tr("Choose a folder for the frames"), self.folder.text()
        )
        if name:
            self.folder.setText(name)

    def _refresh(self) -> None:
        job = self._job
        is_ready = bool(self.video.text().strip() and self.folder.text().strip())
        set_enabled(self.start_button, None if is_ready else Finding("action.no-video"))
        self.start_button.setEnabled(job is None and is_ready)
        self.stop_button.setVisible(job is not None)
        self.progress_bar.setVisible(job is not None)
        if job is not None:
            self.progress_bar.setRange(0, job.total or 0)
            self.progress_bar.setValue(job.done)

    # --- the job -----------------------------------------------------------------------------
    def _start(self) -> None:
        video = Path(self.video.text().strip()).expanduser()
        folder = Path(self.folder.text().strip()).expanduser()
        force = False
        if folder.is_dir() and any(folder.iterdir()) and not is_extraction_folder(folder):
            answer = QMessageBox.question(
                self,
                tr("Folder is not empty"),
                Finding("video.folder-not-empty", folder=escape_markup(folder.name)).message,
            )
            if answer != QMessageBox.StandardButton.Yes:
                return
            force = True
        self.result_label.setText("")
        studio, open_photos, options = self._studio, self._open_photos, self.options.options()

        def handle_result(result: FrameReport) -> None:
            self._show_result(describe_report(result))
            level = "info" if result.good_enough else "warning"
            studio.warn(video_verdict(result).with_file(video.name), level)
            open_photos(folder)

        def handle_failure(event: Failed) -> None:
            if event.cancelled:
                self._show_result(tr("Stopped. Nothing was written."))
                return
            self._show_result(escape(event.message))
            studio.warn(event.to_error(), "error")

        self._job = studio.jobs.submit(
            EXTRACT_FRAMES,
            FramesRequest(video, folder, options, force),
            title=tr("Frames of {video}", video=video.name),
            on_done=handle_result,
            on_failed=handle_failure,
        )
        self._refresh()

    def _stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)

    def _show_result(self, text: str) -> None:
        """Show the result of the job, unless the dialog has been closed in the meantime."""
        self._job = None
        try:
            self.result_label.setText(text)
            self._refresh()
            self.adjustSize()
        except RuntimeError:
            # Qt has deleted the widgets of a closed dialog.
            return


def describe_report(result: FrameReport) -> str:
    """Describe the frames, gaps, warnings and verdict of an extraction as rich text."""
    headline = Finding(
        "video.frames-kept",
        count=len(result.frames),
        width=result.width,
        height=result.height,
        seconds=result.seconds,
    )
    lines = [f"<b>{escape(headline.message)}</b>"]
    lines += [
        escape(Finding("video.frames-left-out", count=number, reason=tr(reason)).message)
        for reason, number in result.skipped.items()
    ]
    if gaps := result.gaps_s:
        times = ", ".join(f"{seconds:.1f} s" for seconds in gaps[:_MAX_SHOWN_GAPS])
        if len(gaps) > _MAX_SHOWN_GAPS:
            times += " …"
        lines.append(tr("Gaps at {times}: frames may not overlap there.", times=times))
    lines += [f"⚠ {escape(format_sentence(str(text)))}" for text in result.warnings]
    lines.append(f"<b>{format_sentence(result.verdict)}</b>")
    return "<br>".join(lines)
