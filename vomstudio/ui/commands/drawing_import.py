"""Import of lines that were drawn on an orthophoto in another program."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_finding
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
from vomstudio.ui.base.command_targets import current_model, missing_model_finding, start_folder
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.project.kinds.trace import Trace
    from vomstudio.studio.drawn_traces import DrawnTraces


class DrawingImport(QObject):
    """Import of a drawing as traces in one edit; jobs read the files and cast the rays."""

    def __init__(self, parent: QWidget, studio: Studio) -> None:
        super().__init__(parent)
        self._parent, self._studio = parent, studio
        self._background = QtBackground(self)
        self._edited_traces: Sequence[Trace] = ()
        self._drawing_name = ""
        studio.project_opened.connect(self._clear)

    def disabled_reason(self) -> Finding | None:
        return missing_model_finding(self._studio)

    def choose_file(self) -> None:
        """Ask for a drawing, and for the sidecar of its orthophoto unless exactly one fits."""
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("Import drawn lines"),
            start_folder(self._studio),
            file_filters.drawings(),
        )
        if name:
            self.import_drawing(Path(name))

    def import_drawing(self, drawing: Path, sidecar: Path | None = None) -> None:
        """Find the picture on which the drawing was made, then import the lines."""
        self._studio.jobs.submit(
            FIND_PICTURES,
            DrawingFile(drawing, sidecar),
            title=tr("Reading {file}", file=drawing.name),
            on_done=self._background.guard(
                lambda pictures: self._choose_picture(drawing, pictures)
            ),
            on_failed=self._handle_failure,
        )

    def _choose_picture(self, drawing: Path, pictures: FittingPictures) -> None:
        if len(pictures.sidecars) == 1:
            self._read_lines(drawing, pictures.sidecars[0], pictures.content_hashes[0])
            return
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("Choose the NAME.json written with the orthophoto"),
            str(drawing.parent),
            file_filters.sidecars(),
        )
        if name:
            self.import_drawing(drawing, Path(name))

    def _read_lines(self, drawing: Path, sidecar: Path, content_hash: str) -> None:
        studio = self._studio
        model = self._find_model(content_hash)
        placed_model = (
            None if model is None else find_placed_model(studio.workspace.projects, model.id)
        )
        if model is None or placed_model is None:
            studio.warn(Finding("action.no-model"))
            return
        studio.jobs.submit(
            READ_DRAWN_LINES,
            DrawnLinesRequest(drawing, sidecar, placed_model),
            title=tr(
                "Projecting the lines of {file} onto {model}", file=drawing.name, model=model.name
            ),
            on_done=self._background.guard(
                lambda lines: self._create_traces(drawing, sidecar, model, lines)
            ),
            on_failed=self._handle_failure,
        )

    def _create_traces(self, drawing: Path, sidecar: Path, model: Model, lines: DrawnLines) -> None:
        studio = self._studio
        records = dict(studio.records)
        surface = studio.workspace.models.surface(model.id)

        type_id, set_name = studio.next_type_id, studio.next_set

        def compute() -> DrawnTraces:
            from vomstudio.studio.drawn_traces import DrawingTarget, create_drawn_traces

            target = DrawingTarget(model, surface, type_id, set_name)
            return create_drawn_traces(lines, drawing, sidecar, target, records)

        self._background.run(
            compute, lambda traces: self._add_traces(drawing, model, traces), self._report_error
        )

    def _handle_failure(self, event: Failed) -> None:
        if event.cancelled:
            self._studio.info(Finding("drawing.cancelled"))
        else:
            self._report_error(event.to_error())

    def _find_model(self, content_hash: str) -> Model | None:
        """Return the open model that the picture shows, otherwise another open model.

        The current model is preferred. Return None if no model is open.
        """
        studio = self._studio
        preferred_model = current_model(studio)
        models = sorted(studio.session.of(Model), key=lambda m: m is not preferred_model)
        matches = [m for m in models if m.content_hash == content_hash]
        return next((m for m in (*matches, *models) if m.id in studio.models), None)

    def _report_error(self, error: VomError) -> None:
        # The field is an option of the command line.
        cause = cause_finding(error)
        self._studio.warn(cause if error.file is None else cause.with_file(error.file), "error")

    def _add_traces(self, drawing: Path, model: Model, drawn_traces: DrawnTraces) -> None:
        studio = self._studio
        current_record = studio.records.get(model.id)
        if not isinstance(current_record, Model) or current_record.to_world != model.to_world:
            studio.warn(Finding("model.moved"))
            return
        if drawn_traces.traces and not studio.attempt(edits.add_features, drawn_traces.traces):
            return
        self._edited_traces, self._drawing_name = drawn_traces.edited, drawing.name
        if drawn_traces.traces:
            studio.selection.set([trace.id for trace in drawn_traces.traces])
            studio.info(Finding("drawing.added", count=len(drawn_traces.traces), model=model.name))
        for message in drawn_traces.messages:
            studio.warn(message, message.severity)
        for finding in drawn_traces.edited_findings:
            studio.notice.emit(Notice(finding, "warning", UPDATE_DRAWN))

    def _clear(self, *_: object) -> None:
        # The edited traces do not exist in another project.
        self._edited_traces = ()

    def missing_update_finding(self) -> Finding | None:
        """Return why no traces can be updated, or None if the last drawing has edited traces."""
        return None if self._edited_traces else Finding("action.no-edited-traces")

    def update(self) -> None:
        """Replace the vertices of traces that were edited in the last drawing."""
        from vomstudio.studio.drawn_traces import update_traces

        traces, self._edited_traces = self._edited_traces, ()
        if traces and self._studio.attempt(update_traces, traces, self._drawing_name):
            self._studio.selection.set([trace.id for trace in traces])
