"""The photos of a model that is to be made: listed, checked and reconstructed by workers."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.errors import VomError
from vomstudio.io.cameras_file import FILE_NAME, read_cameras
from vomstudio.io.control import CONTROL, MARKS
from vomstudio.io.control_files import find_control, marks_beside
from vomstudio.io.project import PHOTO_TABLES, RECONSTRUCTIONS
from vomstudio.jobs.events import Failed
from vomstudio.ui.job_bridge import Job
from vomstudio.ui.make_settings import MakeSettings, asked_for
from vomstudio.ui.photo_marks import MarkFiles
from vomstudio.ui.studio import Notice, Studio

# What does not listen is stopped the hard way before that.
_STOPPING_S = 10.0
# Marks come one soon after the other.
_TABLES_MS = 1000


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
    """Masks of the photos."""
    marks_changed = Signal()

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
        self.control_note = ""
        self.result: dict[str, Any] | None = None
        self._reading: Job | None = None
        self._making: Job | None = None
        self._goes_on = False
        self.settings = MakeSettings()
        self.forecast: dict[str, Any] | None = None
        self._foreseeing: Job | None = None
        self._taken_over: Path | None = None
        """Control points of another file from which those beside the photos were begun."""
        self._tables_soon = QTimer(self)
        self._tables_soon.setSingleShot(True)
        self._tables_soon.setInterval(_TABLES_MS)
        self._tables_soon.timeout.connect(self.control_written)
        studio.jobs.closed.connect(self._tables_soon.stop)
        self.marks_changed.connect(self._tables_soon.start)
        studio.project_opened.connect(self._project_opened)
        studio.jobs.changed.connect(self.changed)

    # --- state -------------------------------------------------------------------------------
    @property
    def quality(self) -> str:
        return self.settings.quality

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
        if self._tables_soon.isActive():
            return self.tr("the control points are being looked at")
        if self.settings.control is not None:
            if self._foreseeing is not None:
                return self.tr("the control points are being looked at")
            if problem := self.control_facts.get("problem"):
                return self.tr("{0} (Settings of the model: other files, or none)").format(problem)
        return None

    @property
    def control_facts(self) -> dict[str, Any]:
        """See `ControlCheck`; empty where no control is chosen or it has not been looked at."""
        return (self.forecast or {}).get("control") or {}

    def out(self) -> Path | None:
        """Where the model of these photos in this quality is made, or was begun. One of another
        quality or of another folder of this name, which may have been measured on, stays as it
        is."""
        if self.folder is None:
            return None
        place = self._studio.project.folder / RECONSTRUCTIONS
        for number in itertools.count(1):
            again = "" if number == 1 else f"-{number}"
            out = place / f"{self.folder.name}{again}-{self.quality}"
            asked = asked_for(out / "request.json")
            if asked is None or _same_photos(asked[0], self.folder):
                return out
        return None

    def choose_quality(self, quality: str) -> None:
        self.choose(replace(self.settings, quality=quality))

    def choose(self, settings: MakeSettings) -> None:
        """Make the next model like this."""
        before, self.settings = self.settings, settings
        if self.making is None and not self.reading and self.rows:
            if before.quality != settings.quality:
                self._show_cameras()
                self.rows_changed.emit()
            self.foresee()
        self.changed.emit()

    @property
    def begun(self) -> bool:
        """An earlier run has finished some stages and no more."""
        out = self.out()
        return out is not None and (out / "work").is_dir() and not (out / "report.html").exists()

    # --- photos ------------------------------------------------------------------------------
    def open(self, folder: Path, settings: MakeSettings | None = None) -> None:
        """List the photos of a folder, then check them. settings: None for those of before, with
        the control that lies beside these photos."""
        self._stop_reading()
        self.folder = folder
        self.settings = settings or self._with_tables(self.settings.for_photos(folder))
        self.forecast = None
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
        self.foresee()
        self._read("check_photos", self.tr("Checking the survey"), self._checked)

    def _checked(self, result: dict[str, Any]) -> None:
        self._take(result)
        if (after := self._earlier_result()) is not None:
            self._take(after["survey"])
        self._show_cameras()
        self.rows_changed.emit()

    @property
    def foreseeing(self) -> bool:
        return self._foreseeing is not None

    def foresee(self) -> None:
        """Ask a worker what the settings mean for these photos; `changed` tells when it has."""
        if self.folder is None:
            return
        settings, request = self.settings, self.settings.request()

        def done(result: dict[str, Any]) -> None:
            if self._foreseeing is not job:
                return
            self._foreseeing = None
            facts = result["control"]
            if settings.found and facts is not None and facts["problem"]:
                # Nobody asked for these files: they are in the way of no model.
                self.settings = settings.without_control()
                self.control_note = self.tr("{0} beside the photos is not used: {1}").format(
                    Path(request["control"]).name, facts["problem"]
                )
                result = {**result, "control": None}
            self.forecast = result
            self.rows_changed.emit()
            self.changed.emit()

        def failed(event: Failed) -> None:
            if self._foreseeing is job:
                self._foreseeing = None
                if not event.cancelled:
                    self._studio.warn(event.message)
                self.changed.emit()

        self.control_note = ""
        job = self._studio.jobs.submit(
            "inspection",
            "foresee",
            {
                "photos": str(self.folder),
                "sizes": [(row.width, row.height) for row in self.rows],
                **request,
            },
            title=self.tr("Looking at what the model needs"),
            on_done=done,
            on_failed=failed,
            quiet=True,
        )
        self._foreseeing = job

    def control_written(self) -> None:
        """Control points or marks beside the photos are new: they are taken unless other files were
        chosen that are not in them, and looked at again."""
        self._tables_soon.stop()
        if self.folder is None:
            return
        if self.settings.found or self.settings.control in (None, self._taken_over):
            self.settings = self._with_tables(self.settings)
        self.foresee()
        self.changed.emit()

    def control_findings(self) -> list[tuple[str, str]]:
        """Severity and sentence of what the control points can do."""
        facts = self.control_facts
        if not facts:
            return [("warning", self.control_note)] if self.control_note else []
        if facts["problem"]:
            return [("error", facts["problem"])]
        frame = facts["crs"] or self.tr("a local frame")
        words = self.tr("The model is placed by ground control in {0}: {1}.").format(
            frame, facts["summary"]
        )
        return [("info", words), *(("warning", text) for text in facts["warnings"])]

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
        self._foreseeing = None
        if self._reading is not None:
            self._studio.jobs.cancel(self._reading)
            self._reading = None

    # --- masks and marks ---------------------------------------------------------------------
    def mark_files(self) -> MarkFiles | None:
        """Where control points and marks of these photos are."""
        if self.folder is None:
            return None
        key = hashlib.sha256(str(self.folder.resolve()).encode()).hexdigest()[:8]
        name = f"{self.folder.name}-{key}"

        def kept() -> Path:
            return self._studio.project.folder / PHOTO_TABLES / name

        control, marks = self.settings.control, self.settings.marks
        files = MarkFiles(self.folder, kept)
        if control is None or files.own:
            return files
        if marks is None:
            with contextlib.suppress(VomError):
                marks = marks_beside(control)
        self._taken_over = control
        return MarkFiles(self.folder, kept, control, marks)

    def set_mask(self, name: str, mask: str | None) -> None:
        for row in self.rows:
            if row.name == name:
                row.mask = mask
        self.drawn_changed.emit()

    def tables(self) -> tuple[Path | None, Path | None]:
        """The control points, with their marks, and the tie points that nobody has to name."""
        files = self.mark_files()
        if files is None:
            return None, None
        if (found := find_control(files.photos)) is not None:
            return found
        control, marks = files.found(CONTROL), files.found(MARKS)
        return (None if marks is None else control), marks

    def _with_tables(self, settings: MakeSettings) -> MakeSettings:
        control, marks = self.tables()
        if control is None:
            return settings.without_control()
        return replace(settings, control=control, marks=marks, found=True)

    def aligned_folder(self) -> Path | None:
        """A reconstruction of these photos with cameras: in this quality, else the newest one."""
        out = self.out()
        if out is None or self.folder is None:
            return None
        if (out / FILE_NAME).exists():
            return out
        folders = [each.parent for each in out.parent.glob(f"*/{FILE_NAME}")]
        asked = {each: asked_for(each / "request.json") for each in folders}
        mine = [each for each, found in asked.items()
                if found is not None and _same_photos(found[0], self.folder)]  # fmt: skip
        return max(mine, key=lambda each: (each / FILE_NAME).stat().st_mtime, default=None)

    def check_again(self) -> None:
        """Masks have changed what the photos are worth."""
        if not self.reading and self.making is None and self.rows:
            self._read("check_photos", self.tr("Checking the survey"), self._checked)

    # --- the model ---------------------------------------------------------------------------
    def make(self) -> None:
        """Reconstruct as the settings say, or go on where an earlier run stopped."""
        out, folder = self.out(), self.folder
        if self.why_not_make() is not None or out is None or folder is None:
            return
        request = {"photos": str(folder), "out": str(out), **self.settings.request()}
        # Shown before; the reconstruction itself would take no CRS for a local one.
        request["crs"] = self.control_facts.get("crs") or self.settings.crs
        if self.settings.control is None:
            # Tie points join photos whatever places the model.
            marks = self.tables()[1]
            request["marks"] = None if marks is None else str(marks)
        session, name = self._studio.session, folder.name
        self.result = None

        def done(result: dict[str, Any]) -> None:
            self._making, self._goes_on = None, False
            words = self.tr("The model of {0} is made: {1} of {2} photos, {3:,} faces.").format(
                name, result["registered"], result["photos"], result["faces"]
            )
            if self._studio.session is not session:
                where = self.tr("It belongs to another project: {0}").format(result["mesh"])
                self._studio.notice.emit(Notice(f"{words} {where}"))
                self.changed.emit()
                return
            self.result = result
            self._take(result["survey"])
            self._show_cameras()
            self.rows_changed.emit()
            said = "".join(f" {text}" for text in result["warnings"][:2])
            self._studio.notice.emit(Notice(words + said))
            # The project may have been saved under another name meanwhile.
            place = self._studio.project.folder / RECONSTRUCTIONS / out.name
            self._studio.open_model(place / Path(result["mesh"]).name, name)

        def failed(event: Failed) -> None:
            self._making = None
            if event.cancelled and self._goes_on:
                self._goes_on = False
                self.make()
            elif not event.cancelled:
                self._studio.warn(event.message, "error")
            self.changed.emit()

        self._making = self._studio.jobs.submit(
            "reconstruction",
            "reconstruct",
            request,
            title=self.tr("Making a model of {0}").format(name),
            on_done=done,
            on_failed=failed,
        )
        self.changed.emit()

    def stop_to_move(self) -> None:
        """The project's folder is about to be moved: stop the work, which then goes on there."""
        if self._making is not None:
            self._goes_on = True
            self.pause()
            self._studio.jobs.finish("reconstruction", _STOPPING_S)

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
        self.verdict = self.problem = self.control_note = ""
        self.forecast = None
        self.rows_changed.emit()
        # The newest is the one that the user was at.
        asked = (self._studio.project.folder / RECONSTRUCTIONS).glob("*/request.json")
        for request in sorted(asked, key=lambda path: -path.stat().st_mtime)[:1]:
            if (found := asked_for(request)) is None:
                continue
            folder, settings = found
            # A project that was moved together with its photos.
            for place in (folder, self._studio.project.folder.parent / folder.name):
                if place.is_dir():
                    self.open(place, settings)
                    break


def _same_photos(asked: Path, folder: Path) -> bool:
    """Whether a reconstruction was made of these photos; those that are gone have been moved."""
    return not asked.is_dir() or asked.resolve() == folder.resolve()
