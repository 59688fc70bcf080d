"""The photos of a model that is to be made: listed, checked and reconstructed by workers."""

from __future__ import annotations

import glob
import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from vomstudio.errors import VomError
from vomstudio.io.cameras_file import FILE_NAME, read_cameras
from vomstudio.jobs.events import Failed
from vomstudio.ui.job_bridge import Job
from vomstudio.ui.photo_marks import MarkFiles
from vomstudio.ui.studio import Notice, Studio

FOLDER = "reconstruction"


@dataclass
class PhotoRow:
    """A photo as the panel shows it. place: (x, y) metres in plan; looks: unit (dx, dy) or None."""

    name: str
    path: str
    width: int
    height: int
    camera: str
    focal: str
    taken: str
    has_gps: bool
    mask: str | None
    thumbnail: str | None = None
    place: tuple[float, float] | None = None
    looks: tuple[float, float] | None = None
    gsd_m: float | None = None
    blur: float | None = None
    views: float | None = None
    findings: list[str] = field(default_factory=list)


class PhotoSurvey(QObject):
    """changed: anything that is shown; rows_changed: the photos themselves."""

    changed = Signal()
    rows_changed = Signal()
    drawn_changed = Signal()
    """Masks and marks of the photos."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.folder: Path | None = None
        self.rows: list[PhotoRow] = []
        self.findings: list[dict[str, Any]] = []
        self.verdict = ""
        self.left_out: list[str] = []
        self.problem = ""
        self.has_north = True
        self.result: dict[str, Any] | None = None
        self._reading: Job | None = None
        self._making: Job | None = None
        self.quality = "medium"
        studio.project_opened.connect(self._project_opened)
        studio.jobs.changed.connect(self.changed)

    # --- state -------------------------------------------------------------------------------
    @property
    def reading(self) -> bool:
        return self._reading is not None

    @property
    def making(self) -> Job | None:
        """The running reconstruction."""
        return self._making

    def why_not_make(self) -> str | None:
        if self._making is not None:
            return self.tr("a model is being made")
        if self.folder is None:
            return self.tr("choose a folder of photos first")
        if self.reading:
            return self.tr("the photos are being looked at")
        if len(self.rows) < 2:
            return self.tr("a model needs at least two photos that overlap")
        return None

    def out(self) -> Path | None:
        """Where the model of these photos in this quality is made, or was begun. One of another
        quality, which may have been measured on, stays as it is."""
        if self.folder is None:
            return None
        return self._studio.project.folder / FOLDER / f"{self.folder.name}-{self.quality}"

    def choose_quality(self, quality: str) -> None:
        self.quality = quality
        if self.making is None and not self.reading and self.rows:
            self._show_cameras()
            self.rows_changed.emit()
        self.changed.emit()

    @property
    def begun(self) -> bool:
        """An earlier run has finished some stages and no more."""
        out = self.out()
        return out is not None and (out / "work").is_dir() and not (out / "report.html").exists()

    # --- photos ------------------------------------------------------------------------------
    def open(self, folder: Path) -> None:
        """List the photos of a folder, then check them."""
        self._stop_reading()
        self.folder = folder
        self.rows, self.findings, self.left_out = [], [], []
        self.verdict, self.problem, self.result = "", "", None
        self.has_north = True
        self.rows_changed.emit()
        self._read("list_photos", self.tr("Looking at photos"), self._listed)

    def _read(self, task: str, title: str, then: Any) -> None:
        def done(result: dict[str, Any]) -> None:
            self._reading = None
            then(result)
            self.changed.emit()

        def failed(event: Failed) -> None:
            self._reading = None
            if not event.cancelled:
                self.problem = event.message
            self.changed.emit()

        self._reading = self._studio.jobs.submit(
            "photos",
            task,
            {"photos": str(self.folder), "cache": str(self._studio.project.cache)},
            title=title,
            on_done=done,
            on_failed=failed,
        )
        self.changed.emit()

    def _listed(self, result: dict[str, Any]) -> None:
        self.rows = [PhotoRow(**row) for row in result["rows"]]
        self.left_out = list(result["left_out"])
        self.rows_changed.emit()
        self._read("check_photos", self.tr("Checking the survey"), self._checked)

    def _checked(self, result: dict[str, Any]) -> None:
        self._take(result)
        if (after := self._earlier_result()) is not None:
            self._take(after["survey"])
        self._show_cameras()
        self.rows_changed.emit()

    def _earlier_result(self) -> dict[str, Any] | None:
        """What a finished reconstruction of these photos has told."""
        out = self.out()
        if out is None:
            return None
        try:
            found = json.loads((out / "reconstruction.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return found if isinstance(found, dict) and "survey" in found else None

    def _take(self, result: dict[str, Any]) -> None:
        """The findings of a survey check, before or after the alignment."""
        self.findings, self.verdict = result["findings"], result["verdict"]
        for each in self.rows:
            each.findings = []
        by_name = {row.name: row for row in self.rows}
        for facts in result["photos"]:
            if row := by_name.get(facts["name"]):
                row.gsd_m, row.views = facts["gsd_m"], facts["views"]
                if facts["blur"] is not None:
                    row.blur = facts["blur"]
        for finding in self.findings:
            for name in finding["photos"] or ():
                if row := by_name.get(name):
                    row.findings.append(finding["text"])

    def _stop_reading(self) -> None:
        if self._reading is not None:
            self._studio.jobs.cancel(self._reading)
            self._reading = None

    # --- masks and marks ---------------------------------------------------------------------
    def mark_files(self) -> MarkFiles | None:
        """Where control points and marks of these photos are."""
        if self.folder is None:
            return None
        key = hashlib.sha256(str(self.folder.resolve()).encode()).hexdigest()[:8]
        kept = self._studio.project.folder / "photos" / f"{self.folder.name}-{key}"
        return MarkFiles(self.folder, kept)

    def set_mask(self, name: str, mask: str | None) -> None:
        for row in self.rows:
            if row.name == name:
                row.mask = mask
        self.drawn_changed.emit()

    def tables(self) -> tuple[Path | None, Path | None]:
        """The control points and marks with which a model is made, where none are named."""
        files = self.mark_files()
        if files is None:
            return None, None
        try:
            control, marks, why_not = files.for_model()
        except VomError as error:
            self._studio.warn(str(error))
            return None, None
        if why_not:
            self._studio.warn(
                self.tr("The model is made without the control points. {0}").format(why_not)
            )
        return control, marks

    def aligned_folder(self) -> Path | None:
        """A reconstruction of these photos with cameras: in this quality, else the newest one."""
        out = self.out()
        if out is None or self.folder is None:
            return None
        if (out / FILE_NAME).exists():
            return out
        found = out.parent.glob(f"{glob.escape(self.folder.name)}-*/{FILE_NAME}")
        newest = sorted(found, key=lambda path: path.stat().st_mtime)
        return newest[-1].parent if newest else None

    def check_again(self) -> None:
        """Masks have changed what the photos are worth."""
        if not self.reading and self.making is None and self.rows:
            self._read("check_photos", self.tr("Checking the survey"), self._checked)

    # --- the model ---------------------------------------------------------------------------
    def make(self, control: Path | None = None, marks: Path | None = None) -> None:
        """Reconstruct, or go on where an earlier run stopped."""
        out = self.out()
        if self.why_not_make() is not None or out is None:
            return
        if control is None and marks is None:
            control, marks = self.tables()
        request = {
            "photos": str(self.folder),
            "out": str(out),
            "quality": self.quality,
            "control": None if control is None else str(control),
            "marks": None if marks is None else str(marks),
        }
        self.result = None

        def done(result: dict[str, Any]) -> None:
            self._making = None
            self.result = result
            self._take(result["survey"])
            self._show_cameras()
            self.rows_changed.emit()
            self._studio.notice.emit(
                Notice(
                    self.tr("The model of {0} is made: {1} of {2} photos, {3:,} faces.").format(
                        Path(request["photos"] or "").name,
                        result["registered"],
                        result["photos"],
                        result["faces"],
                    )
                    + "".join(f" {text}" for text in result["warnings"][:2])
                )
            )
            name = Path(request["photos"] or "").name
            self._studio.open_model(Path(result["mesh"]), name)

        def failed(event: Failed) -> None:
            self._making = None
            if not event.cancelled:
                self._studio.warn(event.message, "error")
            self.changed.emit()

        self._making = self._studio.jobs.submit(
            "reconstruction",
            "reconstruct",
            request,
            title=self.tr("Making a model of {0}").format(Path(request["photos"] or "").name),
            on_done=done,
            on_failed=failed,
        )
        self.changed.emit()

    def pause(self) -> None:
        """Stop the work; what is finished is kept, and `make` goes on behind it."""
        if self._making is not None:
            self._studio.jobs.cancel(self._making)

    def _show_cameras(self) -> None:
        """Places and directions as they were found, where a model has been made."""
        out = self.out()
        if out is None or not (out / FILE_NAME).exists():
            return
        try:
            cameras = read_cameras(out / FILE_NAME)
        except VomError:
            return
        self.has_north = cameras.crs is not None
        rows = {row.name: row for row in self.rows}
        for view in cameras.views:
            if row := rows.get(view.name):
                x, y, _ = view.centre
                dx, dy, _ = view.direction
                size = (dx * dx + dy * dy) ** 0.5
                row.place = (float(x), float(y))
                row.looks = (float(dx / size), float(dy / size)) if size > 0.2 else None
        for row in self.rows:
            if row.name not in {view.name for view in cameras.views}:
                row.place = row.looks = None

    def _project_opened(self) -> None:
        self._stop_reading()
        self.folder, self.rows, self.findings, self.result = None, [], [], None
        self.verdict = self.problem = ""
        self.rows_changed.emit()
        # The newest is the one that the user was at.
        asked_for = (self._studio.project.folder / FOLDER).glob("*/request.json")
        for request in sorted(asked_for, key=lambda path: -path.stat().st_mtime)[:1]:
            try:
                asked = json.loads(request.read_text(encoding="utf-8"))
                folder, quality = Path(asked["photos"]), str(asked["quality"])
            except (OSError, ValueError, KeyError):
                continue
            if folder.is_dir():
                self.quality = quality
                self.open(folder)
