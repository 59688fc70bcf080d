"""Import of control points, marks and masks beside photos into the project records."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr
from vomstudio.io.control.control_files import marks_path
from vomstudio.project.imports.sidecar_import import SidecarData, sidecar_tables, stored_path
from vomstudio.project.photo_edits import (
    PointState,
    add_photo_set,
    import_sidecar_data,
    locate_photos,
    photo_set_name,
)
from vomstudio.project.records import PhotoSet
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base.studio import Notice, Studio
from vomstudio.ui.base.texts import abbreviate_names, format_sentence
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_exports import PhotoExports
from vomstudio.ui.panels.photos.photo_marks import unknown_photos
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_TITLE = to_translate("Importing points and masks")


class PhotoImport:
    """Importer of the control points, marks and masks beside a folder of photos.

    Attributes
    ----------
    user_control : Path or None
        File selected in the settings from which the control points of the project were imported.
        This file is never written.
    """

    def __init__(self, studio: Studio, document: PhotoDocument, exports: PhotoExports) -> None:
        self._studio, self._document, self._exports = studio, document, exports
        self.user_control: Path | None = None

    def begin(
        self,
        rows: Sequence[PhotoRow],
        user_tables: tuple[Path | None, Path | None],
        callback: Callable[[Failed | None], None],
        *,
        is_repeat: bool = False,
    ) -> RunningJob | None:
        """Import the files beside the photos if they are new or if `is_repeat` is True.

        Parameters
        ----------
        rows : sequence of PhotoRow
        user_tables : (Path or None, Path or None)
            Files of control points and marks, used for photos that have no such files beside them.
        callback : callable
            Called with None on success, or with the failure.
        is_repeat : bool, default False
            Whether to repeat an earlier import.

        Returns
        -------
        RunningJob or None
            The import job, or None if there is nothing to import.
        """
        folder, project = self._document.folder, self._studio.project
        if folder is not None and (moved_set := self._document.find_moved_set()) is not None:
            path = stored_path(project.folder, folder)
            self._studio.attempt(locate_photos, moved_set.id, path)
        if folder is None or (self._document.is_imported and not is_repeat):
            self._show_records(rows)
            callback(None)
            return None
        control, marks = sidecar_tables(project.folder, folder)
        control_source = None
        if control is None and marks is None:
            control, marks = _add_default_marks(user_tables)
            control_source = control
        from vomstudio.studio.jobs.photo_tasks import IMPORT_SIDECARS, SidecarImport

        request = SidecarImport(
            project=project.folder,
            control=control,
            marks=marks,
            masks={row.name: Path(row.sidecar_mask) for row in rows if row.sidecar_mask},
            names=tuple(row.name for row in rows),
        )

        def handle_result(sidecars: SidecarData) -> None:
            if self._studio.project is project and self._document.folder == folder:
                self._store(folder, sidecars, rows, has_tables=(control, marks) != (None, None))
                self.user_control = control_source
                self._show_records(rows, sidecars=sidecars)
                callback(None)

        return self._studio.jobs.submit(
            IMPORT_SIDECARS, request, title=tr(_TITLE), on_done=handle_result, on_failed=callback
        )

    def _store(
        self, folder: Path, sidecars: SidecarData, rows: Sequence[PhotoRow], *, has_tables: bool
    ) -> None:
        """Store the data of the files in one edit."""
        for problem in sidecars.problems:
            self._studio.warn(Finding("file.unchanged", reason=format_sentence(problem)))
        unknown = {photo for _, photo, _, _ in sidecars.marks} - {row.name for row in rows}
        if unknown:
            self._studio.warn(unknown_photos(sorted(unknown)))
        stored_set, marks = self._document.photo_set, sidecars.pixels
        points: Sequence[PointState] = sidecars.points
        if stored_set is None:
            path = stored_path(self._studio.project.folder, folder)
            new_set = PhotoSet(new_id("photos"), photo_set_name(folder), path, sidecars.crs)
            self._studio.attempt(add_photo_set, new_set, points, marks, sidecars.masks)
            return
        if not has_tables:
            points, marks = self._document.states()
        self._studio.attempt(
            import_sidecar_data, stored_set.id, points, marks, sidecars.masks, sidecars.crs or None
        )

    def _show_records(
        self, rows: Sequence[PhotoRow], *, sidecars: SidecarData | None = None
    ) -> None:
        """Show the records of the folder and begin to export them."""
        self._document.set_folder(self._document.folder)
        self._exports.begin(rows, is_external=self.user_control is not None, sidecars=sidecars)
        names = self._exports.foreign_files
        if self._document.is_imported and names:
            finding = Finding("photo.files-changed", files=abbreviate_names(names))
            self._studio.notice.emit(Notice(finding, "warning", "take_in_photos"))


def _add_default_marks(tables: tuple[Path | None, Path | None]) -> tuple[Path | None, Path | None]:
    """Add the marks file beside the control points if no marks file is given."""
    control, marks = tables
    if control is not None and marks is None:
        with contextlib.suppress(VomError):
            marks = marks_path(control)
    return control, marks
