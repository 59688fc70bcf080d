"""Lines that were drawn on an orthophoto in another program, taken into the project as traces."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.document import edits
from vomstudio.document.records import Model
from vomstudio.errors import InputError
from vomstudio.failures import exception_hooks
from vomstudio.ui.common import file_filters
from vomstudio.ui.common.background_reading import Background
from vomstudio.ui.common.command_targets import current_model, start_folder, why_no_model
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.workspace.drawn_traces import DrawnTraces
    from vomstudio.workspace.model_loading import OpenModel

# What casts rays is imported in the thread, when it is needed.
Made = TypeVar("Made")


def _reported(work: Callable[[], Made]) -> Callable[[], Made | None]:
    """None, and the fault told, where it fails in a way that nobody expected: then another drawing
    can still be read."""

    def run() -> Made | None:
        try:
            return work()
        except Exception as error:  # noqa: BLE001 - shown like every unexpected error
            exception_hooks.report_as_uncaught(error)
            return None

    return run


class DrawingImport(QObject):
    """Files are read and rays are cast in a thread; the traces come as one edit."""

    def __init__(self, parent: QWidget, studio: Studio) -> None:
        super().__init__(parent)
        self._parent, self._studio = parent, studio
        self._background = Background(self)

    def why_not(self) -> str | None:
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

    def take_in(self, drawing: Path) -> None:
        """Find the picture on which a drawing was made, then bring its lines back."""

        def look() -> list[Path]:
            from vomstudio.workspace.drawn_traces import fitting_sidecars

            return fitting_sidecars(drawing)

        self._studio.info(tr("Reading {file}…", file=drawing.name))
        self._background.run(
            _reported(look),
            lambda found: self._choose_picture(drawing, found),
        )

    def _choose_picture(self, drawing: Path, found: object) -> None:
        if not isinstance(found, list):
            return
        sidecar: Path | None = found[0] if len(found) == 1 else None
        if sidecar is None:
            name, _ = QFileDialog.getOpenFileName(
                self._parent,
                tr("The file NAME.json that was written beside the orthophoto"),
                str(drawing.parent),
                file_filters.sidecars(),
            )
            sidecar = Path(name) if name else None
        if sidecar is None:
            return
        self._bring_back(drawing, sidecar)

    def _bring_back(self, drawing: Path, sidecar: Path) -> None:
        studio = self._studio
        shown = self._model_of(sidecar)
        if shown is None:
            studio.warn(tr("Open the model first of which the orthophoto was made."))
            return
        model, opened = shown
        records, type_id, set_name = dict(studio.records), studio.next_type_id, studio.next_set
        surface = studio.workspace.models.surface(model.id)

        def work() -> DrawnTraces | InputError:
            from vomstudio.workspace.drawn_traces import read_drawn_traces

            try:
                return read_drawn_traces(
                    drawing, sidecar, model, opened.data, surface, records, type_id, set_name
                )
            except InputError as error:
                return error

        self._background.run(_reported(work), lambda found: self._arrived(model, found))

    def _model_of(self, sidecar: Path) -> tuple[Model, OpenModel] | None:
        """The open model whose file the picture shows, else the current one."""
        from vomstudio.products.ortho.drawing_back import read_sidecar

        studio = self._studio
        try:
            wanted = read_sidecar(sidecar).content_hash
        except InputError:
            # It is said when the lines are read.
            wanted = None
        current = current_model(studio)
        models = sorted(studio.session.of(Model), key=lambda m: m is not current)
        fitting = [m for m in models if m.content_hash == wanted]
        for model in (*fitting, *models):
            if (opened := studio.models.get(model.id)) is not None:
                return model, opened
        return None

    def _arrived(self, model: Model, found: object) -> None:
        from vomstudio.workspace.drawn_traces import DrawnTraces

        studio = self._studio
        if isinstance(found, InputError):
            # The field is an option of the command line.
            studio.warn(f"{found.file}: {found.message}" if found.file else found.message, "error")
            return
        if not isinstance(found, DrawnTraces):
            return
        now = studio.records.get(model.id)
        if not isinstance(now, Model) or now.to_world != model.to_world:
            studio.warn(
                tr("The model was moved or removed meanwhile. Import the drawing once more.")
            )
            return
        if not studio.attempt(edits.add_features, found.traces):
            return
        studio.selection.set([trace.id for trace in found.traces])
        said = [
            tr_n("Added {count} trace on {model}.", "Added {count} traces on {model}.",
                 len(found.traces), model=model.name),
            *found.warnings,
            *(tr("{feature} was left out: {reason}", feature=n, reason=r)
              for n, r in found.skipped),
        ]  # fmt: skip
        (studio.warn if found.skipped or found.warnings else studio.info)(" ".join(said))
