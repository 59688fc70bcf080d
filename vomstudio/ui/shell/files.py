"""Files and models as the window's menus deal with them: open, save, export, locate, leave."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QFileDialog, QMenu, QMessageBox

from vomstudio.document import edits
from vomstudio.document.records import Model, OnAModel
from vomstudio.errors import VomError
from vomstudio.io.models.registry import extensions
from vomstudio.io.project.export import export_records
from vomstudio.io.project.folder import SUFFIX, is_project, untitled_folder, untitled_projects
from vomstudio.jobs.events import Failed
from vomstudio.ui.common.studio import Notice, Studio
from vomstudio.ui.shell.frame_dialog import FrameDialog

if TYPE_CHECKING:
    from vomstudio.ui.shell.main_window import MainWindow


_EXPORTS = {
    "csv": "Orientation table (*.csv)",
    "gpkg": "GeoPackage (*.gpkg)",
    "shp": "Shapefiles (*.shp)",
    "dxf": "DXF (*.dxf)",
}


class Files(QObject):
    """Dialogs belong to the window; what they decide is done by the studio."""

    def __init__(self, window: MainWindow, studio: Studio) -> None:
        super().__init__(window)
        self._window = window
        self.studio = studio

    def project_name(self) -> str:
        project = self.studio.project
        return self.tr("untitled") if project.untitled else project.name

    def open_path(self, path: Path) -> None:
        if is_project(path) and not self.ask_to_keep():
            return
        self.studio.open_path(path)

    def choose_model(self) -> None:
        patterns = " ".join(f"*{e} *{e.upper()}" for e in extensions())
        names, _ = QFileDialog.getOpenFileNames(
            self._window,
            self.tr("Open a model"),
            self.folder(),
            f"Models ({patterns});;All files (*)",
        )
        for name in names:
            self.open_path(Path(name))

    def choose_project(self) -> None:
        name = QFileDialog.getExistingDirectory(
            self._window, self.tr("Open a project (a folder NAME.vom)"), self.folder()
        )
        if name:
            self.open_path(Path(name))

    def folder(self) -> str:
        recent = self.studio.settings.recent
        return str(Path(recent[0]).parent) if recent else str(Path.home())

    def new_project(self) -> None:
        if self.ask_to_keep():
            self.attempt(self.studio.new_project)

    def save(self) -> bool:
        if self.studio.project.untitled:
            return self.save_as()
        return self.attempt(self.studio.save)

    def save_as(self) -> bool:
        name, _ = QFileDialog.getSaveFileName(
            self._window,
            self.tr("Save the project as"),
            str(Path(self.folder()) / f"outcrop{SUFFIX}"),
            f"VOM Studio project (*{SUFFIX})",
        )
        if not name:
            return False
        folder = Path(name if name.endswith(SUFFIX) else name + SUFFIX)
        self._window.survey.stop_to_move()
        return self.attempt(lambda: self.studio.save_as(folder))

    def export(self, format_: str) -> None:
        pattern = _EXPORTS[format_]
        stem = "orientations" if self.studio.project.untitled else self.studio.project.name
        name, _ = QFileDialog.getSaveFileName(
            self._window,
            self.tr("Export"),
            str(Path(self.folder()) / f"{stem}.{format_}"),
            pattern,
        )
        if name:
            path = Path(name if name.endswith(f".{format_}") else f"{name}.{format_}")
            self.export_to(format_, path)

    def export_to(self, format_: str, path: Path) -> None:
        def write() -> None:
            made = export_records(self.studio.records, format_, path, force=True,
                                  thresholds=self.studio.settings.thresholds)  # fmt: skip
            self.studio.info(f"Written: {', '.join(str(file) for file in made.files)}")

        self.attempt(write)

    def export_model(self) -> None:
        """The current model in World, in any format that is written, by a worker."""
        from vomstudio.io.models.writing import find_writers

        model = self.current_model()
        path = self.studio.project.find_model(model) if model is not None else None
        if model is None or path is None:
            return
        patterns = [f"{w.name} ({' '.join(f'*{e}' for e in w.extensions)})" for w in find_writers()]
        name, _ = QFileDialog.getSaveFileName(
            self._window,
            self.tr("Export {0} as").format(model.name),
            str(Path(self.folder()) / f"{model.name}_export"),
            ";;".join(patterns),
        )
        if not name:
            return

        def done(result: dict[str, Any]) -> None:
            self.studio.info(" ".join([f"Written: {name}.", *result["warnings"]]))

        def failed(event: Failed) -> None:
            if not event.cancelled:
                self.studio.warn(event.message, "error")

        self.studio.jobs.submit(
            "products",
            "export_model",
            {
                "path": str(path),
                "cache": str(self.studio.project.cache),
                "to_world": [list(row) for row in model.to_world],
                "crs": model.frame.crs,
                "out": name,
            },
            title=f"Exporting {model.name}",
            on_done=done,
            on_failed=failed,
        )

    def attempt(self, do: Callable[[], None]) -> bool:
        try:
            do()
        except VomError as error:
            self.studio.fail(error)
            return False
        return True

    def ask_to_keep(self) -> bool:
        """Before the project is left: save, leave without saving, or stay (False)."""
        studio = self.studio
        if studio.worth_asking:
            box = QMessageBox(self._window)
            box.setIcon(QMessageBox.Icon.Question)
            box.setText(self.tr("Save the changes to {0}?").format(self.project_name()))
            box.setInformativeText(
                self.tr("What is not saved now is kept in the project's history and can be "
                        "brought back with Undo.")
            )  # fmt: skip
            box.setStandardButtons(
                QMessageBox.StandardButton.Save
                | QMessageBox.StandardButton.Discard
                | QMessageBox.StandardButton.Cancel
            )
            answer = box.exec()
            if answer == QMessageBox.StandardButton.Cancel:
                return False
            if answer == QMessageBox.StandardButton.Save:
                return self.save()
        # Where even this cannot be written the work stays in the journal; a full disk must not
        # hold the window open.
        self.attempt(studio.discard)
        return True

    def offer_recovery(self, folders: list[Path]) -> None:
        newest = folders[0]
        whose = "" if newest.parent == untitled_folder() else f" of {newest.stem}"
        more = f", and {len(folders) - 1} older" if len(folders) > 1 else ""
        self._window.message_bar.say(
            Notice(
                f"Work{whose} that was open when the program ended last time was found{more}.",
                "warning",
            ),
            (self.tr("Bring it back"), lambda: self.open_path(newest)),
        )

    # --- models ------------------------------------------------------------------------------
    def current_model(self) -> Model | None:
        """The selected model, or the only one, or the one of the selected feature."""
        records, models = self.studio.records, self.studio.session.of(Model)
        for id_ in reversed(self.studio.selection.ids):
            record = records.get(id_)
            if isinstance(record, OnAModel):
                record = records.get(record.model_id)
            if isinstance(record, Model):
                return record
        undeclared = [m for m in models if m.frame.kind == "undeclared"]
        if len(undeclared) == 1:
            return undeclared[0]
        return models[-1] if models else None

    def declare_frame(self, model_id: str | None = None) -> None:
        model = self.studio.records.get(model_id) if model_id else self.current_model()
        if not isinstance(model, Model):
            return
        dialog = FrameDialog(self._window, model, self.studio.models.get(model.id))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(
            lambda: self.studio.attempt(edits.declare_frame, model.id, dialog.frame)
        )
        dialog.open()

    def locate_model(self) -> None:
        model = self.current_model()
        if model is None:
            return
        name, _ = QFileDialog.getOpenFileName(
            self._window, self.tr("Where is {0}?").format(model.name), self.folder()
        )
        if name:
            self.studio.locate_model(model.id, Path(name))

    def remove_model(self) -> None:
        model = self.current_model()
        if model is not None:
            self.studio.attempt(edits.remove_model, model.id)

    def fill_recent(self, menu: QMenu) -> None:
        menu.clear()
        for text in self.studio.settings.recent:
            action = menu.addAction(text)
            action.setEnabled(Path(text).exists())
            action.triggered.connect(lambda _=False, p=text: self.open_path(Path(p)))
        if menu.isEmpty():
            menu.addAction(self.tr("Nothing yet")).setEnabled(False)

    def fill_discarded(self, menu: QMenu) -> None:
        menu.clear()
        for folder in untitled_projects(finished=True)[:20]:
            action = menu.addAction(folder.stem)
            action.setToolTip(self.tr("Opens as it was left; Undo brings the discarded work back"))
            action.triggered.connect(lambda _=False, p=folder: self.open_path(p))
        if menu.isEmpty():
            menu.addAction(self.tr("Nothing was discarded")).setEnabled(False)
