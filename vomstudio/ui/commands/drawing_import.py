"""Lines that were drawn on an orthophoto in another program, taken into the project as traces."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.studio.jobs.drawing_tasks import (
    FIND_PICTURES,
    READ_DRAWN_LINES,
    DrawingFile,
    DrawnLines,
    DrawnLinesRequest,
    FittingPictures,
)
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.models import find_placed_model
from vomstudio.studio.notices import UPDATE_DRAWN, Notice
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import current_model, start_folder, why_no_model
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.project.kinds.trace import Trace
    from vomstudio.studio.drawn_traces import DrawnTraces


class DrawingImport(QObject):
    """Files are read and rays are cast by jobs; the traces come as one edit."""

    def __init__(self, parent: QWidget, studio: Studio) -> None:
        super().__init__(parent)
        self._parent, self._studio = parent, studio
        self._background = QtBackground(self)
        self._edited: Sequence[Trace] = ()
        self._drawing = ""
        studio.project_opened.connect(self._forget)

    def why_not(self) -> Finding | None:
        return why_no_model(self._studio)

    def choose(self) -> None:
        """Ask for a drawing, and for the picture's sidecar where it does not lie beside it."""
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("Import lines drawn on an orthophoto"),
            start_folder(self._studio),
            file_filters.drawings(),
        )
        if name:
            self.take_in(Path(name))

    def take_in(self, drawing: Path, sidecar: Path | None = None) -> None:
        """Find the picture on which a drawing was made, then bring its lines back."""
        self._studio.jobs.submit(
            FIND_PICTURES,
            DrawingFile(drawing, sidecar),
            title=tr("Reading {file}", file=drawing.name),
            on_done=self._background.guard(lambda found: self._choose_picture(drawing, found)),
            on_failed=self._failed,
        )

    def _choose_picture(self, drawing: Path, found: FittingPictures) -> None:
        if len(found.sidecars) == 1:
            self._bring_back(drawing, found.sidecars[0], found.content_hashes[0])
            return
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("The file NAME.json that was written beside the orthophoto"),
            str(drawing.parent),
            file_filters.sidecars(),
        )
        if name:
            self.take_in(drawing, Path(name))

    def _bring_back(self, drawing: Path, sidecar: Path, content_hash: str) -> None:
        studio = self._studio
        model = self._model_of(content_hash)
        standing = None if model is None else find_placed_model(studio.workspace.projects, model.id)
        if model is None or standing is None:
            studio.warn(Finding("action.no-model"))
            return
        studio.jobs.submit(
            READ_DRAWN_LINES,
            DrawnLinesRequest(drawing, sidecar, standing),
            title=tr(
                "Bringing the lines of {file} to {model}", file=drawing.name, model=model.name
            ),
            on_done=self._background.guard(
                lambda found: self._to_traces(drawing, sidecar, model, found)
            ),
            on_failed=self._failed,
        )

    def _to_traces(self, drawing: Path, sidecar: Path, model: Model, found: DrawnLines) -> None:
        studio = self._studio
        records = dict(studio.records)
        surface = studio.workspace.models.surface(model.id)

        type_id, set_name = studio.next_type_id, studio.next_set

        def work() -> DrawnTraces:
            from vomstudio.studio.drawn_traces import DrawingTarget, create_drawn_traces

            target = DrawingTarget(model, surface, type_id, set_name)
            return create_drawn_traces(found, drawing, sidecar, target, records)

        self._background.run(
            work, lambda traces: self._arrived(drawing, model, traces), self._refuse
        )

    def _failed(self, event: Failed) -> None:
        if event.cancelled:
            self._studio.info(Finding("drawing.cancelled"))
        else:
            self._refuse(event.to_error())

    def _model_of(self, content_hash: str) -> Model | None:
        """The open model whose file the picture shows, else the current one."""
        studio = self._studio
        current = current_model(studio)
        models = sorted(studio.session.of(Model), key=lambda m: m is not current)
        fitting = [m for m in models if m.content_hash == content_hash]
        return next((m for m in (*fitting, *models) if m.id in studio.models), None)

    def _refuse(self, error: VomError) -> None:
        # The field is an option of the command line.
        cause = cause_of(error)
        self._studio.warn(cause if error.file is None else cause.with_file(error.file), "error")

    def _arrived(self, drawing: Path, model: Model, found: DrawnTraces) -> None:
        studio = self._studio
        now = studio.records.get(model.id)
        if not isinstance(now, Model) or now.to_world != model.to_world:
            studio.warn(Finding("model.moved"))
            return
        if found.traces and not studio.attempt(edits.add_features, found.traces):
            return
        self._edited, self._drawing = found.edited, drawing.name
        if found.traces:
            studio.selection.set([trace.id for trace in found.traces])
            studio.info(Finding("drawing.added", count=len(found.traces), model=model.name))
        for message in found.messages:
            studio.warn(message, message.severity)
        for edited in found.edited_findings:
            studio.notice.emit(Notice(edited, "warning", UPDATE_DRAWN))

    def _forget(self, *_: object) -> None:
        """Another project does not have the edited traces."""
        self._edited = ()

    def why_no_update(self) -> Finding | None:
        """Return why there are no edited traces to update, None if there are."""
        return None if self._edited else Finding("action.no-edited-traces")

    def update(self) -> None:
        """Give the traces that were edited in the last drawing their new vertices."""
        from vomstudio.studio.drawn_traces import update_traces

        edited, self._edited = self._edited, ()
        if edited and self._studio.attempt(update_traces, edited, self._drawing):
            self._studio.selection.set([trace.id for trace in edited])
