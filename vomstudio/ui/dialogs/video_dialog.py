"""Extraction of frames from a video: a worker extracts and judges them; they open as photos."""

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
from vomstudio.core.words import tr, tr_n
from vomstudio.photogrammetry.survey.survey_options import VideoFrameOptions
from vomstudio.photogrammetry.survey.video import FrameReport, is_ours, verdict_of
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.survey_tasks import TAKE_FRAMES, FramesRequest
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.controls import Label, allow, as_words, file_field, rich_label
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.texts import as_sentence
from vomstudio.ui.widgets.options_form import OptionFields

_SHOWN_GAPS = 6


class VideoDialog(QDialog):
    """It can be closed while the work goes on: the Jobs panel shows it, and a notice its end."""

    def __init__(
        self, parent: QWidget, studio: Studio, open_photos: Callable[[Path], None]
    ) -> None:
        super().__init__(parent)
        explain(self, "photos.md#frames-from-a-video")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Frames from a video"))
        self.setMinimumWidth(620)
        self._studio, self._open_photos = studio, open_photos
        self._job: RunningJob | None = None
        about = Label(
            tr(
                "The sharpest frame of each interval is kept, unless it is blurred or nearly the "
                "same as the previous one. Photos are better than frames of a video: they are "
                "larger and sharper, and they state their camera and position."
            )
        )
        about.setWordWrap(True)
        self.video, video = file_field("video_file", tr("Choose…"), self._browse_video)
        self.folder, folder = file_field("video_folder", tr("Choose…"), self._browse_folder)
        self.options = OptionFields(VideoFrameOptions, "video")
        form = QFormLayout()
        form.addRow(tr("Video"), video)
        self.options.add_rows(form)
        form.addRow(tr("Folder"), folder)
        self.bar = QProgressBar()
        self.bar.hide()
        self.said = rich_label()
        self.said.setObjectName("video_said")
        self.said.setWordWrap(True)
        self.said.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.start = buttons.addButton(tr("Extract frames"), role)
        self.stop = buttons.addButton(tr("Stop"), role)
        self.start.clicked.connect(self._start)
        self.stop.clicked.connect(self._stop)
        buttons.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addWidget(about)
        layout.addSpacing(4)
        layout.addLayout(form)
        layout.addWidget(self.bar)
        layout.addWidget(self.said)
        layout.addStretch(1)
        layout.addWidget(buttons)
        for field in (self.video, self.folder):
            field.textChanged.connect(self._refresh)
        studio.jobs_changed.connect(self._refresh)
        self._refresh()

    # --- choosing ----------------------------------------------------------------------------
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
        """Fill in a video, and a folder beside it for the frames."""
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
        ready = bool(self.video.text().strip() and self.folder.text().strip())
        allow(self.start, None if ready else Finding("action.no-video"))
        self.start.setEnabled(job is None and ready)
        self.stop.setVisible(job is not None)
        self.bar.setVisible(job is not None)
        if job is not None:
            self.bar.setRange(0, job.total or 0)
            self.bar.setValue(job.done)

    # --- the job -----------------------------------------------------------------------------
    def _start(self) -> None:
        video = Path(self.video.text().strip()).expanduser()
        folder = Path(self.folder.text().strip()).expanduser()
        force = False
        if folder.is_dir() and any(folder.iterdir()) and not is_ours(folder):
            answer = QMessageBox.question(
                self,
                tr("Folder is not empty"),
                tr(
                    "{folder} contains other files. Write the frames into this folder?",
                    folder=as_words(folder.name),
                ),
            )
            if answer != QMessageBox.StandardButton.Yes:
                return
            force = True
        self.said.setText("")
        studio, open_photos, options = self._studio, self._open_photos, self.options.options()

        def done(result: FrameReport) -> None:
            self._ended(report_words(result))
            level = "info" if result.good_enough else "warning"
            studio.warn(verdict_of(result).with_file(video.name), level)
            open_photos(folder)

        def failed(event: Failed) -> None:
            if event.cancelled:
                self._ended(tr("Stopped. Nothing was written."))
                return
            self._ended(escape(event.message))
            studio.warn(event.to_error(), "error")

        self._job = studio.jobs.submit(
            TAKE_FRAMES,
            FramesRequest(video, folder, options, force),
            title=tr("Frames of {video}", video=video.name),
            on_done=done,
            on_failed=failed,
        )
        self._refresh()

    def _stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)

    def _ended(self, words: str) -> None:
        """Show how the job ended, unless the dialog was closed meanwhile."""
        self._job = None
        try:
            self.said.setText(words)
            self._refresh()
            self.adjustSize()
        except RuntimeError:
            # Closed meanwhile: Qt's side of it is gone.
            return


def report_words(result: FrameReport) -> str:
    """Rich text: how many frames were kept and left out, the gaps, the warnings and the verdict."""
    lines = [
        tr_n(
            "<b>{count} frame kept</b> of {width} × {height} pixels, from {seconds:.0f} s",
            "<b>{count} frames kept</b> of {width} × {height} pixels, from {seconds:.0f} s",
            len(result.frames),
            width=result.width,
            height=result.height,
            seconds=result.seconds,
        )
    ]
    lines += [
        tr_n(
            "{count} frame left out: {reason}",
            "{count} frames left out: {reason}",
            number,
            reason=tr(reason),
        )
        for reason, number in result.skipped.items()
    ]
    if gaps := result.gaps_s:
        shown = ", ".join(f"{seconds:.1f} s" for seconds in gaps[:_SHOWN_GAPS])
        if len(gaps) > _SHOWN_GAPS:
            shown += " …"
        lines.append(tr("Gaps at {times}: frames may not overlap there.", times=shown))
    lines += [f"⚠ {escape(as_sentence(str(text)))}" for text in result.warnings]
    lines.append(f"<b>{as_sentence(result.verdict)}</b>")
    return "<br>".join(lines)
