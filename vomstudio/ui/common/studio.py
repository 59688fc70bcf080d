"""The open project as the window works with it: session, models, tool, jobs. No widgets."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from vomstudio.document import edits
from vomstudio.document.comparison import NearestPick, nearest_picks
from vomstudio.document.edit import Edit
from vomstudio.document.measurements import Measurement, Measurements, sources_of
from vomstudio.document.records import (
    FEATURES,
    ON_A_MODEL,
    TYPED,
    Dimension,
    Feature,
    FeatureType,
    Frame,
    Intersection,
    Lineation,
    Model,
    Record,
    Registration,
)
from vomstudio.document.selection import Selection
from vomstudio.document.session import Session
from vomstudio.errors import VomError
from vomstudio.geometry.brush import PaintSurface
from vomstudio.io.photos import cameras_file
from vomstudio.io.project.folder import (
    Project,
    create_untitled,
    is_free,
    is_project,
    untitled_projects,
)
from vomstudio.io.settings import Settings, SettingsFile
from vomstudio.jobs.events import Failed
from vomstudio.tools.context import Tool
from vomstudio.tools.line import LineTool
from vomstudio.tools.measure import MeasureTool
from vomstudio.tools.patch import PatchTool
from vomstudio.tools.trace import TraceTool
from vomstudio.tools.types import PointerEvent, Preview
from vomstudio.ui.common.job_bridge import JobBridge
from vomstudio.ui.common.wording import degrees, length, plane_text
from vomstudio.ui.scene.display import Display
from vomstudio.ui.shell.model_loader import ModelLoader, OpenModel

DIMENSIONS = "dimensions"
"""Stands for all dimensions where types stand for the other features."""
_LAYERS_IDLE_MS = 2000
_LAYERS_PATIENCE_S = 10.0


@dataclass(frozen=True)
class Notice:
    """What happened to the user's thing. level: "info", "hint" (goes by itself), "warning" or
    "error". action: the name of the action that mends it, offered beside the sentence."""

    text: str
    level: str = "info"
    action: str = ""


def group_of(feature: Feature) -> str:
    """The id that hides a feature together with its like."""
    return DIMENSIONS if isinstance(feature, Dimension) else feature.type_id


class Studio(QObject):
    """Views connect to these signals, never to a session: another project may take its place."""

    project_opened = Signal()
    edited = Signal(object)  # Edit
    history_changed = Signal()
    selection_changed = Signal(object)  # tuple of ids
    model_loaded = Signal(str)
    frame_wanted = Signal(str)
    next_changed = Signal()
    tool_changed_signal = Signal()
    active_tool_changed = Signal(str)
    preview = Signal(object)  # Preview | None
    notice = Signal(object)  # Notice
    settings_changed = Signal()
    """Not for the list of what was open lately."""
    recent_changed = Signal()
    _not_kept = Signal(str)
    visibility_changed = Signal(object)  # tuple of ids
    layers_written = Signal(str)
    recovery_found = Signal(object)  # list of folders

    def __init__(self, settings: Settings) -> None:
        super().__init__()
        self.settings = settings
        self._settings_file = SettingsFile(lambda text: self._not_kept.emit(text))
        self._not_kept.connect(self.warn, Qt.ConnectionType.QueuedConnection)
        self.jobs = JobBridge()
        self.selection = Selection()
        self.selection.changed.connect(self.selection_changed.emit)
        self.measurements = Measurements(settings.thresholds)
        self._nearest: dict[str, NearestPick] | None = None
        self.models: dict[str, OpenModel] = {}
        self.hidden: set[str] = set()
        self.tool_name = "navigate"
        self.display = Display(lambda values: self.project.journal.set_view("display", values))
        self.next_type_id = "bedding"
        self.next_set = ""
        self.project: Project = None  # type: ignore[assignment]
        self.loader = ModelLoader(self.jobs, lambda: self.settings.point_budget)
        self.loader.problem.connect(lambda text: self.warn(text, "error"))
        self._layers_timer = QTimer(self)
        self._layers_timer.setSingleShot(True)
        self._layers_timer.setInterval(_LAYERS_IDLE_MS)
        self._layers_timer.timeout.connect(self.write_layers)
        self.trace_tool = TraceTool(self)
        self.patch_tool = PatchTool(self)
        self.line_tool = LineTool(self)
        self.measure_tool = MeasureTool(self)
        self.tools: dict[str, Tool] = {
            "trace": self.trace_tool,
            "patch": self.patch_tool,
            "line": self.line_tool,
            "measure": self.measure_tool,
        }

    # --- project -----------------------------------------------------------------------------
    @property
    def session(self) -> Session:
        return self.project.session

    @property
    def records(self) -> Mapping[str, Record]:
        return self.session.records

    def new_project(self) -> None:
        self._adopt(create_untitled(self.settings.affecting_results))

    def open_project(self, folder: Path) -> None:
        """Raises VomError with the present project untouched."""
        if self.project is not None and folder.resolve() == self.project.folder.resolve():
            return
        self._adopt(Project.open(folder, settings=self.settings.affecting_results))
        if not self.project.untitled:
            self.remember(self.project.folder)

    def offer_recovery(self) -> None:
        """Tell of projects that a crash or a power cut has left open."""
        named = [Path(p) for p in self.settings.unclosed]
        found = [
            folder
            for folder in (*(f for f in named if is_free(f)), *untitled_projects(finished=False))
            if folder.resolve() != self.project.folder.resolve()
        ]
        if found:
            self.recovery_found.emit(found)

    def _adopt(self, project: Project) -> None:
        if self.project is not None:
            self._leave()
        self.project = project
        self._nearest = None
        self.session.changed.connect(self._on_edit)
        self.session.history_changed.connect(lambda _: self.history_changed.emit())
        self._mark_open(True)
        self.hidden = set(project.journal.view("hidden", []))
        if self.next_type_id not in self.records:
            self.next_type_id = self.session.of(FeatureType)[0].id
        self.display.load(project.journal.view("display"))
        self.selection.set(())
        self.project_opened.emit()
        self.history_changed.emit()
        for problem in self.session.problems:
            self.warn(f"A part of the project could not be read and was left out: {problem}")
        for model in self.session.of(Model):
            self._load(model)
        if self.session.recovered:
            self.warn("Work that had not been saved is back. Save it, or take it back with Undo.")
        draft = self.session.draft
        if draft is not None:
            self._restore_draft(draft.state)

    def _restore_draft(self, state: Mapping[str, Any]) -> None:
        name = str(state.get("tool"))
        tool = self.tools.get(name)
        if tool is not None:
            self.activate(name)
        if tool is None or not tool.restore(state):
            self.warn("An unfinished feature could not be read and was left out.")
            return
        if trace := self.trace_tool.trace:
            self.next_type_id, self.next_set = trace.type_id, trace.set_name
        self.tool_changed()
        count = len(state.get("vertices", ()))
        points = f"{count} point{'s' if count != 1 else ''}"
        what = "measurement" if name == "measure" else name
        self.info(f"An unfinished {what} with {points} is back: go on picking.")

    def _leave(self) -> None:
        self._mark_open(False)
        self.display.flush()
        self.loader.forget_all()
        if self._layers_timer.isActive():
            # An edit of the last moment, a discarded one included; `close` waits for it.
            self.write_layers()
        for tool in self.tools.values():
            tool.forget()
        self.models.clear()
        self.measurements = Measurements(self.settings.thresholds)
        self.project.close()

    def close(self) -> None:
        """The window goes: give everything back."""
        self._leave()
        self.jobs.finish("files", _LAYERS_PATIENCE_S)
        self.jobs.close()

    def save(self) -> None:
        self.session.save()
        self.write_layers()
        self.info(f"Saved {self.project.name}.")

    def discard(self) -> None:
        """Leave what was not saved to the history. Raises VomError."""
        if (tool := self.open_tool) is not None:
            tool.cancel()
        if self.session.dirty:
            self.session.discard_unsaved()

    def save_as(self, folder: Path) -> None:
        self._mark_open(False)
        try:
            self.project.save_as(folder)
        finally:
            self._mark_open(True)
        self.remember(folder)
        # The same records under another name: no view has to be built anew.
        self.history_changed.emit()
        self.write_layers()
        self.info(f"Saved as {folder}.")

    def _mark_open(self, is_open: bool) -> None:
        """Note in the settings what must be offered if the program ends without closing it."""
        folder = str(self.project.folder.resolve())
        kept = [p for p in self.settings.unclosed if p != folder]
        unclosed = [*kept, folder] if is_open and not self.project.untitled else kept
        if unclosed != self.settings.unclosed:
            self.settings.unclosed = unclosed
            self.keep_settings()

    @property
    def worth_asking(self) -> bool:
        """Closing now would put work aside that the user may want to keep."""
        is_open = self.open_tool is not None
        if not self.session.dirty and not is_open and not self.unsaved_reconstructions:
            return False
        return (
            bool(self.session.features())
            or is_open
            or not self.project.untitled
            or self.unsaved_reconstructions
        )

    @property
    def unsaved_reconstructions(self) -> bool:
        return self.project.untitled and self.project.has_reconstructions

    def remember(self, path: Path) -> None:
        self.settings.add_recent(path.resolve())
        self.recent_changed.emit()
        self._settings_file.write_soon(self.settings)

    def keep_settings(self) -> None:
        try:
            self._settings_file.write(self.settings)
        except VomError as error:
            self.warn(str(error))
        self.settings_changed.emit()

    # --- edits -------------------------------------------------------------------------------
    def apply(self, edit: Edit) -> bool:
        """False, with the reason said, where it cannot be done."""
        try:
            self.session.apply(edit)
        except VomError as error:
            self.fail(error)
            return False
        return True

    def attempt(self, make: Any, *args: Any, **values: Any) -> bool:
        """Make an edit of `document.edits` and apply it."""
        try:
            return self.apply(make(self.records, *args, **values))
        except VomError as error:
            self.fail(error)
            return False

    def undo(self) -> None:
        tool = self.open_tool
        if tool is None or not tool.undo():
            self._step(self.session.undo)

    def redo(self) -> None:
        self._step(self.session.redo)

    def _step(self, do: Any) -> None:
        try:
            do()
        except VomError as error:
            self.fail(error)

    def _on_edit(self, edit: Edit) -> None:
        self._nearest = None
        for id_, record in edit.after.items():
            if isinstance(record, Model) and id_ not in self.models:
                self._load(record)
        if self.next_type_id not in self.records:
            self.next_type_id = self.session.of(FeatureType)[0].id
        self.measurements.forget_all_but(self.records)
        self.selection.keep(self.records)
        self.edited.emit(edit)
        self.patch_tool.look_again()
        if not self.project.untitled:
            self._layers_timer.start()

    def affected(self, edit: Edit) -> list[str]:
        """The features that look different after an edit: its own, those of its models and feature
        types, and what rests on them. Deleted ones are among them."""
        ids = set(edit.ids)
        own = [i for i in edit.ids if isinstance(edit.before[i] or edit.after[i], FEATURES)]
        others = [f.id for f in self.session.features() if f.id not in ids and self._rests(f, ids)]
        return own + others

    def _rests(self, feature: Feature, ids: set[str]) -> bool:
        if isinstance(feature, ON_A_MODEL) and feature.model_id in ids:
            return True
        if isinstance(feature, TYPED) and feature.type_id in ids:
            return True
        if isinstance(feature, Lineation | Dimension) and feature.plane_id in ids:
            return True
        if isinstance(feature, Lineation | Dimension) and feature.plane_id:
            return any(r.id in ids for r in sources_of(self.records, feature) if r is not None)
        # Members of its groups may have come or gone: they are few, and looked at again.
        return isinstance(feature, Intersection)

    def delete_selected(self) -> None:
        ids = [i for i in self.selection.ids if isinstance(self.records.get(i), FEATURES)]
        if ids:
            self.attempt(edits.delete, ids)

    # --- models ------------------------------------------------------------------------------
    def open_path(self, path: Path) -> None:
        """A project folder or a model file; the reason is said where it is neither."""
        path = path.expanduser()
        if not path.exists():
            self.warn(f"{path}: there is no such file or folder.", "error")
        elif is_project(path) or (path.is_dir() and path.suffix == ".vom"):
            try:
                self.open_project(path)
            except VomError as error:
                self.fail(error)
        else:
            self.open_model(path)

    def open_model(
        self,
        path: Path,
        name: str | None = None,
        like: str | None = None,
        then: Callable[[str], None] = lambda _: None,
    ) -> None:
        """name: of its record; None for that of the file. like: a model whose frame it shares.
        then: called with its id once it is there."""
        path = path.resolve()
        self.loader.load(
            str(path),
            path,
            self.project.cache,
            lambda opened: self._add_opened(path, opened, name or _name_of(path), like, then),
        )

    def _load(self, model: Model) -> None:
        """Read the data of a model of the project."""
        path = self.project.find_model(model)
        if path is None:
            text = (
                f"The model {model.name} is not where it was ({model.path}). Its features are "
                "here; use Model > Locate to say where the file is now."
            )
            self.notice.emit(Notice(text, "warning", "locate"))
            return

        def arrived(opened: OpenModel) -> None:
            if model.id not in self.records:
                return
            if opened.content_hash != model.content_hash:
                self.warn(
                    f"{path} has changed since {model.name} was measured on it. The features stay "
                    "as they are; open the file as a new model to measure on it."
                )
                return
            self._attach(model.id, path, opened)

        self.loader.load(model.id, path, self.project.cache, arrived)

    def locate_model(self, model_id: str, path: Path) -> None:
        """The user says where a model's file is now."""

        def arrived(opened: OpenModel) -> None:
            stored = self.project.model_path(path)
            if self.attempt(edits.relocate_model, model_id, stored, opened.content_hash):
                self._attach(model_id, path, opened)

        self.loader.load(model_id, path, self.project.cache, arrived)

    def copy_model(
        self,
        model_id: str,
        cameras: Path | None = None,
        photos: bool = False,
        then: Callable[[], None] = lambda: None,
    ) -> None:
        """Bring a model's files into the project's folder, with the cameras of its photos (None for
        those beside it) and, where wanted, the photos. then: called before the model moves."""
        model = self.records.get(model_id)
        path = self.project.find_model(model) if isinstance(model, Model) else None
        if path is None or not isinstance(model, Model):
            return
        project = self.project

        def arrived(result: dict[str, Any]) -> None:
            copy = Path(result["path"])
            if self.project is not project:
                return
            then()
            stored = project.model_path(copy)
            if self.attempt(edits.relocate_model, model_id, stored, model.content_hash):
                self.info(f"{model.name} is part of the project's folder now.")

        self.jobs.submit(
            "files",
            "copy_model",
            {
                "path": str(path),
                "folder": str(project.folder / "models"),
                "cameras": None if cameras is None else str(cameras),
                "photos": photos,
            },
            title=f"Copying {model.name}",
            on_done=arrived,
            on_failed=lambda event: self.warn(event.message, "error"),
        )

    def _add_opened(
        self,
        path: Path,
        opened: OpenModel,
        name: str,
        like: str | None,
        then: Callable[[str], None],
    ) -> None:
        same = [m for m in self.session.of(Model) if m.content_hash == opened.content_hash]
        if same:
            if same[0].id not in self.models:
                self._attach(same[0].id, path, opened)
            self.info(f"{path.name} is open already.")
            return
        placement: Frame | Registration = _frame_of(path, opened)
        other = self.records.get(like or "")
        if isinstance(other, Model):
            placement = other.placement
        model = Model(
            id=edits.new_id("model"),
            name=name,
            path=self.project.model_path(path),
            kind=opened.kind,
            content_hash=opened.content_hash,
            placement=placement,
        )
        # The data first: an edit that brings a model without data would read the file again.
        self.models[model.id] = opened
        if not self.attempt(edits.add_model, model):
            del self.models[model.id]
            return
        self.remember(path)
        self._attach(model.id, path, opened)
        if model.frame.kind == "undeclared" and not isinstance(other, Model):
            self.frame_wanted.emit(model.id)
        then(model.id)

    def _attach(self, model_id: str, path: Path, opened: OpenModel) -> None:
        self.models[model_id] = opened
        if opened.warnings:
            # One notice: the bar shows the newest only.
            self.warn(f"{path.name}: " + "\n".join(opened.warnings))
        self.model_loaded.emit(model_id)

    def visible(self, id_: str) -> bool:
        return id_ not in self.hidden

    def show_only(self, ids: Iterable[str]) -> None:
        """These features with their types, and no others; the models stay as they are."""
        ids = set(ids)
        features = self.session.features()
        groups = {group_of(f) for f in features if f.id in ids}
        hidden = {f.id for f in features if f.id not in ids}
        changed = (self.hidden & (ids | groups)) | (hidden - self.hidden)
        self._set_hidden((self.hidden - ids - groups) | hidden, changed)

    def show_all(self) -> None:
        self._set_hidden(set(), set(self.hidden))

    def _set_hidden(self, hidden: set[str], changed: set[str]) -> None:
        if changed:
            self.hidden = hidden
            self.project.journal.set_view("hidden", sorted(self.hidden))
            self.visibility_changed.emit(tuple(changed))

    def set_visible(self, ids: Iterable[str], visible: bool) -> None:
        ids = tuple(ids)
        hidden = self.hidden - set(ids) if visible else self.hidden | set(ids)
        self._set_hidden(hidden, set(ids))

    # --- derived -----------------------------------------------------------------------------
    def measured(self, ids: Iterable[str]) -> dict[str, Measurement]:
        return self.measurements.of(self.records, ids)

    def nearest_pick(self, reading_id: str) -> NearestPick | None:
        """The pick to which a compass reading is compared; worked out for all readings at once, and
        again after an edit."""
        if self._nearest is None:
            self._nearest = nearest_picks(self.records, self.measurements)
        return self._nearest.get(reading_id)

    def nearest_text(self, reading_id: str) -> str:
        """How far a reading is from the nearest pick, and from which, in words."""
        found = self.nearest_pick(reading_id)
        if found is None:
            return "No pick of the same type to compare with"
        how = "the most alike" if found.distance_m is None else f"{length(found.distance_m)} away"
        return f"{degrees(found.angle_deg)} from {found.name}, {how}"

    def north_known(self) -> bool:
        """Every model of the project knows its north."""
        models = self.session.of(Model)
        return bool(models) and all(m.frame.has_north for m in models)

    def metres_known(self) -> bool:
        """No model of the project is of unknown scale."""
        return all(m.frame.has_metres for m in self.session.of(Model))

    def frame_name(self) -> str:
        names = list(dict.fromkeys(m.frame.name() for m in self.session.of(Model)))
        return " / ".join(names)

    def write_layers(self) -> None:
        """Bring project.gpkg up to date, in another process; an untitled project has none."""
        self._layers_timer.stop()
        if self.project.untitled:
            return
        folder = self.project.folder
        if not self.session.features():
            # Layers that show what is not there any more would be worse than none.
            with contextlib.suppress(OSError):
                (folder / "project.gpkg").unlink(missing_ok=True)
            return

        def failed(event: Failed) -> None:
            self.layers_written.emit("")
            self.warn(f"The GIS layers are not up to date: {event.message}")
            self._layers_timer.start(30_000)

        self.jobs.submit(
            "files",
            "write_layers",
            {"folder": str(folder)},
            title="Writing GIS layers",
            on_done=lambda _: self.layers_written.emit(str(folder / "project.gpkg")),
            on_failed=failed,
            quiet=True,
        )

    # --- tools -------------------------------------------------------------------------------
    def activate(self, name: str) -> None:
        if name == self.tool_name:
            return
        if self.tool_name == "patch":
            # A stroke that is being made is kept: there is no way back to it.
            self.patch_tool.leave()
        open_tool = self.open_tool
        if open_tool is not None and self.tools.get(name) is not open_tool:
            waits = "finish it with Enter or cancel it with Esc"
            if name in self.tools:
                self.hint(f"What is being picked comes first: {waits}.")
                self.active_tool_changed.emit(self.tool_name)
                return
            self.info(f"What is being picked waits: {waits}.")
        self.tool_name = name
        self.active_tool_changed.emit(name)

    @property
    def tool(self) -> Tool | None:
        """The active tool; None while navigating."""
        return self.tools.get(self.tool_name)

    @property
    def open_tool(self) -> Tool | None:
        """The tool that has something unfinished."""
        return next((tool for tool in self.tools.values() if tool.open), None)

    def finish_tool(self) -> None:
        if (tool := self.open_tool or self.tool) is not None:
            tool.finish()

    def cancel_tool(self) -> None:
        if (tool := self.open_tool or self.tool) is not None:
            tool.cancel()

    def pointer(self, event: PointerEvent) -> None:
        if (tool := self.tool) is not None:
            tool.pointer(event)

    def set_next(self, type_id: str, set_name: str) -> None:
        """Feature type and set for what is made next, the open trace included."""
        self.next_type_id, self.next_set = type_id, set_name
        for tool in self.tools.values():
            tool.set_type(type_id, set_name)
        self.next_changed.emit()

    # --- ToolContext -------------------------------------------------------------------------
    def surface(self, model_id: str) -> PaintSurface | None:
        found = self.models.get(model_id)
        return found.surface if found else None

    def measure(self, feature: Feature) -> Measurement:
        return self.measurements.one(self.records, feature)

    def format_plane(self, measurement: Measurement) -> str:
        return plane_text(measurement.fit, self.settings.notation, local=not self.north_known())

    def show(self, preview: Preview | None) -> None:
        self.preview.emit(preview)

    def say(self, message: str) -> None:
        self.notice.emit(Notice(message, "warning"))

    def hint(self, message: str) -> None:
        self.notice.emit(Notice(message, "hint"))

    def tool_changed(self) -> None:
        self.tool_changed_signal.emit()
        self.history_changed.emit()

    def created(self, feature_id: str) -> None:
        self.selection.set((feature_id,))

    # --- words -------------------------------------------------------------------------------
    def info(self, text: str) -> None:
        self.notice.emit(Notice(text))

    def warn(self, text: str, level: str = "warning") -> None:
        self.notice.emit(Notice(text, level))

    def fail(self, error: VomError) -> None:
        self.notice.emit(Notice(str(error), "error"))


def _name_of(path: Path) -> str:
    """The file's name; every model made of photos has the same, so its folder's."""
    if not path.with_name(cameras_file.FILE_NAME).is_file():
        return path.stem
    return path.parent.name if path.stem == "model" else f"{path.parent.name} {path.stem}"


def _frame_of(path: Path, opened: OpenModel) -> Frame:
    """The file's own; a model made of photos in a local system of control has metres and north."""
    if opened.crs:
        return Frame("crs", opened.crs)
    return Frame("local") if cameras_file.scale_known(path) else Frame()
