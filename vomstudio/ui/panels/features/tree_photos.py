"""Branches of the project tree for photo sets and their photos."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from PySide6.QtCore import QObject, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QKeySequence, QShortcut
from PySide6.QtWidgets import QMenu, QTreeWidget, QTreeWidgetItem

from vomstudio.core.words import tr, tr_n
from vomstudio.io.photos.reading import photo_names
from vomstudio.project.edit import Edit
from vomstudio.project.photo_edits import get_masks, marks_of, photo_sets
from vomstudio.project.records import (
    ImageMark,
    MarkedPoint,
    Mask,
    PhotoSet,
    ReconstructionRecord,
    Record,
)
from vomstudio.ui.base import theme
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.tree_view import ID_ROLE, NAME, ORIENTATION, SORT_ROLE, TreeItem
from vomstudio.ui.panels.photos.photo_commands import PhotoOpening
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey

PHOTO_ROLE = Qt.ItemDataRole.UserRole + 2
"""Item data role that stores the photo name."""
ROWS_PER_STEP = 200
"""Number of rows created between two events, which takes a few milliseconds."""
_MENU_ACTIONS = (
    "take_in_photos",
    "|",
    "make_settings",
    "make_model",
    "pause_model",
    "|",
    "show_alignment",
    "show_tie_points",
    "open_report",
)
"""Actions of the photos panel in the context menu of a photo set."""
_RECORD_KINDS = (PhotoSet, ReconstructionRecord, ImageMark, MarkedPoint, Mask)


class TreePhotos(QObject):
    """Branches of the photo sets, each with one row per photo once it is expanded.

    Parameters
    ----------
    actions : mapping
        Actions of the window, by name.
    show_panel : callable
        Brings the photos panel forward.
    """

    photo_selected = Signal(str)
    """Emitted with the name of the selected photo of the set shown in the photos panel."""

    def __init__(
        self,
        studio: Studio,
        survey: PhotoSurvey,
        opening: PhotoOpening,
        actions: Mapping[str, QAction],
        show_panel: Callable[[], object],
    ) -> None:
        super().__init__()
        self._studio, self._survey, self._photo_opening = studio, survey, opening
        self._actions, self._show_panel = actions, show_panel
        self._branches: dict[str, QTreeWidgetItem] = {}
        self._names: dict[str, Sequence[str]] = {}
        """Photo names in each branch that is filled or being filled, by set id."""
        self._background = QtBackground(self)
        self._timer = QTimer(self)
        self._timer.setInterval(0)
        self._timer.timeout.connect(self._add_next_rows)
        survey.rows_changed.connect(self._update_shown_set)
        studio.jobs.closed.connect(self._background.stop)

    def attach(self, tree: QTreeWidget) -> None:
        self._tree = tree
        self.setParent(tree)
        tree.itemExpanded.connect(self._expand)
        tree.itemDoubleClicked.connect(lambda item, _: self._open(item))
        tree.itemSelectionChanged.connect(self._emit_selected_photo)
        for code in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            # The shortcut acts only while the tree has the focus: in an editor, Enter ends editing.
            key = QShortcut(QKeySequence(code), tree)
            key.setContext(Qt.ShortcutContext.WidgetShortcut)
            key.activated.connect(lambda: self._open(tree.currentItem()))

    @property
    def has_photos(self) -> bool:
        """Whether the project has photo sets."""
        return bool(self._branches)

    # --- display -----------------------------------------------------------------------------
    def rebuild(self) -> None:
        """Add the branches to the cleared tree and expand those that were filled before."""
        names_by_set = dict(self._names)
        self._branches.clear()
        self._names.clear()
        for photo_set in photo_sets(self._studio.records):
            self._add_branch(photo_set)
            if photo_set.id in names_by_set:
                self._branches[photo_set.id].setExpanded(True)
                self._fill(photo_set.id, names_by_set[photo_set.id])

    def apply_edit(self, edit: Edit) -> None:
        """Update the branches after an edit."""
        records = [r for id_ in edit.ids for r in (edit.before[id_], edit.after[id_])]
        if not any(isinstance(r, _RECORD_KINDS) for r in records):
            return
        with QSignalBlocker(self._tree):
            sets = {each.id: each for each in photo_sets(self._studio.records)}
            for removed_id in self._branches.keys() - sets.keys():
                item = self._branches.pop(removed_id)
                self._names.pop(removed_id, None)
                self._tree.takeTopLevelItem(self._tree.indexOfTopLevelItem(item))
            for id_, photo_set in sets.items():
                if id_ not in self._branches:
                    self._add_branch(photo_set)
                    self._tree.sortItems(NAME, Qt.SortOrder.AscendingOrder)
                self._update_title(photo_set)
            self._update_labels(_find_changed_photos(records))

    def _add_branch(self, photo_set: PhotoSet) -> None:
        item = TreeItem(self._tree)
        item.setData(NAME, ID_ROLE, photo_set.id)
        # Photo sets are listed after the models.
        item.setData(NAME, SORT_ROLE, ("0", 1 + len(self._branches)))
        item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
        item.setIcon(NAME, theme.icon("image-multiple-outline"))
        item.setChildIndicatorPolicy(QTreeWidgetItem.ChildIndicatorPolicy.ShowIndicator)
        item.setFirstColumnSpanned(True)
        self._branches[photo_set.id] = item
        self._update_title(photo_set)

    def _update_title(self, photo_set: PhotoSet) -> None:
        item = self._branches[photo_set.id]
        names = self._list_names(photo_set.id)
        item.setText(NAME, f"{photo_set.name} ({len(names)})" if names else photo_set.name)
        lines = [photo_set.path]
        lines += [
            tr(
                "Reconstruction, {quality}: {registered} of {photos} photos are aligned.",
                quality=reconstruction.quality,
                registered=reconstruction.registered,
                photos=reconstruction.photos,
            )
            for reconstruction in self._studio.session.of(ReconstructionRecord)
            if reconstruction.photo_set_id == photo_set.id
        ]
        item.setToolTip(NAME, "\n".join(lines))

    def _is_in_panel(self, id_: str) -> bool:
        photo_set = self._survey.document.photo_set
        return photo_set is not None and photo_set.id == id_

    def _list_names(self, id_: str) -> Sequence[str]:
        if self._is_in_panel(id_) and self._survey.rows:
            return [row.name for row in self._survey.rows]
        return self._names.get(id_, ())

    def _update_shown_set(self) -> None:
        photo_set = self._survey.document.photo_set
        if photo_set is None or photo_set.id not in self._branches or not self._survey.rows:
            return
        with QSignalBlocker(self._tree):
            self._update_title(photo_set)
            names = self._list_names(photo_set.id)
            if photo_set.id in self._names and list(self._names[photo_set.id]) != list(names):
                self._branches[photo_set.id].takeChildren()
                self._fill(photo_set.id, names)

    # --- photos of a set ---------------------------------------------------------------------
    def _expand(self, item: QTreeWidgetItem) -> None:
        id_ = str(item.data(NAME, ID_ROLE))
        photo_set = self._studio.records.get(id_)
        if self._branches.get(id_) is not item or id_ in self._names:
            return
        if names := self._list_names(id_):
            self._fill(id_, names)
        elif isinstance(photo_set, PhotoSet):
            self._names[id_] = ()
            folder = self._survey.document.find_folder(photo_set)

            # The folder is read in a worker thread, because it may be on a slow drive.
            self._background.run(
                lambda: [] if folder is None else photo_names(folder),
                partial(self._show_names, id_, item),
                lambda _: self._show_names(id_, item, []),
            )

    def _show_names(self, id_: str, item: QTreeWidgetItem, names: list[str]) -> None:
        if self._branches.get(id_) is item and not self._names[id_]:
            self._fill(id_, names)
            record = self._studio.records.get(id_)
            if isinstance(record, PhotoSet):
                self._update_title(record)
            if not names:
                policy = QTreeWidgetItem.ChildIndicatorPolicy.DontShowIndicatorWhenChildless
                item.setChildIndicatorPolicy(policy)

    def _fill(self, id_: str, names: Sequence[str]) -> None:
        self._names[id_] = names
        self._add_next_rows()
        self._timer.start()

    def _add_next_rows(self) -> None:
        """Add the next rows to the first incomplete branch."""
        for id_, names in self._names.items():
            branch = self._branches[id_]
            start = branch.childCount()
            if start < len(names):
                icon = theme.icon("image-outline")
                rows: list[QTreeWidgetItem] = []
                for name in names[start : start + ROWS_PER_STEP]:
                    row = TreeItem([name])
                    row.setData(NAME, ID_ROLE, id_)
                    row.setData(NAME, PHOTO_ROLE, name)
                    row.setData(NAME, SORT_ROLE, start + len(rows))
                    row.setIcon(NAME, icon)
                    row.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
                    rows.append(row)
                with QSignalBlocker(self._tree):
                    branch.addChildren(rows)
                    self._update_labels(set(names[start : start + ROWS_PER_STEP]), id_)
                return
        self._timer.stop()

    def _update_labels(self, photos: set[str], set_id: str = "") -> None:
        """Update the marks and masks in the labels of photos; `set_id` limits this to one set."""
        for id_ in [set_id] if set_id else self._names:
            branch = self._branches[id_]
            names = self._names[id_][: branch.childCount()]
            numbers = [i for i, name in enumerate(names) if name in photos]
            if not numbers:
                continue
            records = self._studio.records
            counts: dict[str, int] = {}
            for _, mark in marks_of(records, id_):
                counts[mark.photo] = counts.get(mark.photo, 0) + 1
            masked_photos = get_masks(records, id_).keys()
            for number in numbers:
                name = names[number]
                count = counts.get(name, 0)
                labels = [tr_n("{count} mark", "{count} marks", count)] if count else []
                labels += [tr("mask")] if name in masked_photos else []
                row = branch.child(number)
                if row is not None:
                    row.setText(ORIENTATION, " · ".join(labels))
                    row.setToolTip(NAME, "\n".join([name, *labels]))

    # --- actions -----------------------------------------------------------------------------
    def _emit_selected_photo(self) -> None:
        photos = [item for item in self._tree.selectedItems() if item.data(NAME, PHOTO_ROLE)]
        if len(photos) == 1 and self._is_in_panel(str(photos[0].data(NAME, ID_ROLE))):
            self.photo_selected.emit(str(photos[0].data(NAME, PHOTO_ROLE)))

    def _open(self, item: QTreeWidgetItem | None) -> None:
        record = None if item is None else self._studio.records.get(str(item.data(NAME, ID_ROLE)))
        if item is None or not isinstance(record, PhotoSet):
            return
        if photo := item.data(NAME, PHOTO_ROLE):
            self._photo_opening.open_set_photo(record, str(photo))

    def fill_menu(self, menu: QMenu, item: QTreeWidgetItem) -> bool:
        """Fill the context menu of a photo set or photo; return False for rows of other kinds."""
        record = self._studio.records.get(str(item.data(NAME, ID_ROLE)))
        if not isinstance(record, PhotoSet):
            return False
        photo = item.data(NAME, PHOTO_ROLE)
        menu.addAction(
            theme.icon("image-edit-outline"),
            tr("&Open photo") if photo else tr("&Open its first photo"),
            partial(self._photo_opening.open_set_photo, record, photo),
        )
        menu.addAction(
            theme.icon("image-multiple-outline"),
            tr("Show in &Photos"),
            partial(self._show_in_panel, record, photo),
        )
        if self._is_in_panel(record.id):
            menu.addSeparator()
            for name in _MENU_ACTIONS:
                if name == "|":
                    menu.addSeparator()
                else:
                    menu.addAction(self._actions[name])
        return True

    def _show_in_panel(self, photo_set: PhotoSet, photo: str | None) -> None:
        if self._photo_opening.open_set(photo_set):
            self._show_panel()
            if photo:
                self.photo_selected.emit(photo)


def _find_changed_photos(records: Sequence[Record | None]) -> set[str]:
    return {r.photo for r in records if isinstance(r, ImageMark | Mask)}
