"""Import of the control points, marks and masks that lie beside photos: they become records."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from pathlib import Path

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import to_translate, tr
from vomstudio.io.control.control_files import marks_beside
from vomstudio.project.imports.sidecar_import import SidecarData, sidecar_tables, stored_path
from vomstudio.project.photo_edits import (
    PointState,
    add_photo_set,
    import_sidecar_data,
    locate_photos,
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
    """Imports what lies beside a folder of photos.

    given_from : the control points that the settings named, from which those of the project were
    begun; such a file is never written
    """

    def __init__(self, studio: Studio, document: PhotoDocument, exports: PhotoExports) -> None:
        self._studio, self._document, self._exports = studio, document, exports
        self.given_from: Path | None = None

    def begin(
        self,
        rows: Sequence[PhotoRow],
        given: tuple[Path | None, Path | None],
        then: Callable[[Failed | None], None],
        *,
        again: bool = False,
    ) -> RunningJob | None:
        """Import what lies beside the photos, if that was not done before or `again` is True, then
        call `then` with None or with the failure. given : files of control points and of marks,
        for photos that have none beside them. The job, or None where there was nothing to do."""
        folder, project = self._document.folder, self._studio.project
        if folder is not None and (moved := self._document.moved_from()) is not None:
            path = stored_path(project.folder, folder)
            self._studio.attempt(locate_photos, moved.id, path)
        if folder is None or (self._document.taken_in and not again):
            self._taken_in(rows)
            then(None)
            return None
        control, marks = sidecar_tables(project.folder, folder)
        named = None
        if control is None and marks is None:
            control, marks = _with_marks(given)
            named = control
        from vomstudio.studio.jobs.photo_tasks import IMPORT_SIDECARS, SidecarImport

        order = SidecarImport(
            project.folder,
            control,
            marks,
            {row.name: Path(row.found_mask) for row in rows if row.found_mask},
            tuple(row.name for row in rows),
        )

        def done(beside: SidecarData) -> None:
            if self._studio.project is project and self._document.folder == folder:
                self._keep(folder, beside, rows, has_tables=(control, marks) != (None, None))
                self.given_from = named
                self._taken_in(rows, just_read=beside)
                then(None)

        return self._studio.jobs.submit(
            IMPORT_SIDECARS, order, title=tr(_TITLE), on_done=done, on_failed=then
        )

    def _keep(
        self, folder: Path, beside: SidecarData, rows: Sequence[PhotoRow], *, has_tables: bool
    ) -> None:
        """As one edit."""
        for problem in beside.problems:
            self._studio.warn(Finding("file.unchanged", reason=format_sentence(problem)))
        strangers = {photo for _, photo, _, _ in beside.marks} - {row.name for row in rows}
        if strangers:
            self._studio.warn(unknown_photos(sorted(strangers)))
        known, marks = self._document.photo_set, beside.pixels
        points: Sequence[PointState] = beside.points
        if known is None:
            path = stored_path(self._studio.project.folder, folder)
            made = PhotoSet(new_id("photos"), folder.name, path, beside.crs)
            self._studio.attempt(add_photo_set, made, points, marks, beside.masks)
            return
        if not has_tables:
            points, marks = self._document.states()
        self._studio.attempt(
            import_sidecar_data, known.id, points, marks, beside.masks, beside.crs or None
        )

    def _taken_in(self, rows: Sequence[PhotoRow], *, just_read: SidecarData | None = None) -> None:
        """The records are what is shown."""
        self._document.look_at(self._document.folder)
        self._exports.begin(rows, given=self.given_from is not None, just_read=just_read)
        names = self._exports.foreign
        if self._document.taken_in and names:
            finding = Finding("photo.files-changed", files=abbreviate_names(names))
            self._studio.notice.emit(Notice(finding, "warning", "take_in_photos"))


def _with_marks(given: tuple[Path | None, Path | None]) -> tuple[Path | None, Path | None]:
    """Control points with the marks that lie beside them where none are named."""
    control, marks = given
    if control is not None and marks is None:
        with contextlib.suppress(VomError):
            marks = marks_beside(control)
    return control, marks
