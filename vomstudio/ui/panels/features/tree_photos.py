"""The sets of photos in the project tree, each with its photos."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from PySide6.QtCore import QObject, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QKeySequence, QShortcut
from PySide6.QtWidgets import QMenu, QTreeWidget, QTreeWidgetItem

from vomstudio.core.words import tr, tr_n
from vomstudio.io.photos.reading import photo_names
from vomstudio.project.edit import Edit
from vomstudio.project.photo_edits import marks_of, masks_of, photo_sets
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
from vomstudio.ui.panels.features.tree_view import ID, NAME, ORIENTATION, SORT, TreeItem
from vomstudio.ui.panels.photos.photo_commands import PhotoOpening
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey

PHOTO = Qt.ItemDataRole.UserRole + 2
"""The name of a photo, on its row."""
_AT_ONCE = 200
"""So many rows are made before the window gets its turn: they take some milliseconds."""
_OFFERED = (
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
"""What the panel of photos offers for the set that it shows."""
_SHOWN = (PhotoSet, ReconstructionRecord, ImageMark, MarkedPoint, Mask)


class TreePhotos(QObject):
    """A branch for each set of photos, with a row for each photo once it is expanded.

    chosen : the name of a photo of the set in the panel, when it is selected
    """

    chosen = Signal(str)

    def __init__(
        self,
        studio: Studio,
        survey: PhotoSurvey,
        opening: PhotoOpening,
        actions: Mapping[str, QAction],
        show_panel: Callable[[], object],
    ) -> None:
        """actions : of the window by their names. show_panel : brings the panel of photos
        forward"""
        super().__init__()
        self._studio, self._survey, self._opening = studio, survey, opening
        self._actions, self._show_panel = actions, show_panel
        self._branches: dict[str, QTreeWidgetItem] = {}
        self._names: dict[str, Sequence[str]] = {}
        """Of the photos of each branch that is filled or being filled."""
        self._background = QtBackground(self)
        self._timer = QTimer(self)
        self._timer.setInterval(0)
        self._timer.timeout.connect(self._fill_on)
        survey.rows_changed.connect(self._rows_changed)
        studio.jobs.closed.connect(self._background.stop)

    def join(self, tree: QTreeWidget) -> None:
        self._tree = tree
        self.setParent(tree)
        tree.itemExpanded.connect(self._expanded)
        tree.itemDoubleClicked.connect(lambda item, _: self._open(item))
        tree.itemSelectionChanged.connect(self._selected)
        for code in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            # Only with the focus on the tree itself: in an editor Enter ends editing.
            key = QShortcut(QKeySequence(code), tree)
            key.setContext(Qt.ShortcutContext.WidgetShortcut)
            key.activated.connect(lambda: self._open(tree.currentItem()))

    @property
    def any(self) -> bool:
        """Whether the project has sets of photos."""
        return bool(self._branches)

    # --- what is shown -----------------------------------------------------------------------
    def rebuild(self) -> None:
        """The tree was emptied: a branch for each set of photos, filled where one was."""
        filled = dict(self._names)
        self._branches.clear()
        self._names.clear()
        for photo_set in photo_sets(self._studio.records):
            self._add(photo_set)
            if photo_set.id in filled:
                self._branches[photo_set.id].setExpanded(True)
                self._fill(photo_set.id, filled[photo_set.id])

    def edited(self, edit: Edit) -> None:
        """Follow an edit of whatever record."""
        changed = [r for id_ in edit.ids for r in (edit.before[id_], edit.after[id_])]
        if not any(isinstance(r, _SHOWN) for r in changed):
            return
        with QSignalBlocker(self._tree):
            sets = {each.id: each for each in photo_sets(self._studio.records)}
            for gone in self._branches.keys() - sets.keys():
                item = self._branches.pop(gone)
                self._names.pop(gone, None)
                self._tree.takeTopLevelItem(self._tree.indexOfTopLevelItem(item))
            for id_, photo_set in sets.items():
                if id_ not in self._branches:
                    self._add(photo_set)
                    self._tree.sortItems(NAME, Qt.SortOrder.AscendingOrder)
                self._title(photo_set)
            self._describe(_photos_in(changed))

    def _add(self, photo_set: PhotoSet) -> None:
        item = TreeItem(self._tree)
        item.setData(NAME, ID, photo_set.id)
        # After the models.
        item.setData(NAME, SORT, ("0", 1 + len(self._branches)))
        item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
        item.setIcon(NAME, theme.icon("image-multiple-outline"))
        item.setChildIndicatorPolicy(QTreeWidgetItem.ChildIndicatorPolicy.ShowIndicator)
        item.setFirstColumnSpanned(True)
        self._branches[photo_set.id] = item
        self._title(photo_set)

    def _title(self, photo_set: PhotoSet) -> None:
        item = self._branches[photo_set.id]
        names = self._known_names(photo_set.id)
        item.setText(NAME, f"{photo_set.name} ({len(names)})" if names else photo_set.name)
        about = [photo_set.path]
        about += [
            tr(
                "Reconstruction, {quality}: {registered} of {photos} photos are aligned.",
                quality=each.quality,
                registered=each.registered,
                photos=each.photos,
            )
            for each in self._studio.session.of(ReconstructionRecord)
            if each.photo_set_id == photo_set.id
        ]
        item.setToolTip(NAME, "\n".join(about))

    def _in_panel(self, id_: str) -> bool:
        shown = self._survey.document.photo_set
        return shown is not None and shown.id == id_

    def _known_names(self, id_: str) -> Sequence[str]:
        if self._in_panel(id_) and self._survey.rows:
            return [row.name for row in self._survey.rows]
        return self._names.get(id_, ())

    def _rows_changed(self) -> None:
        shown = self._survey.document.photo_set
        if shown is None or shown.id not in self._branches or not self._survey.rows:
            return
        with QSignalBlocker(self._tree):
            self._title(shown)
            names = self._known_names(shown.id)
            if shown.id in self._names and list(self._names[shown.id]) != list(names):
                self._branches[shown.id].takeChildren()
                self._fill(shown.id, names)

    # --- the photos of a set -----------------------------------------------------------------
    def _expanded(self, item: QTreeWidgetItem) -> None:
        id_ = str(item.data(NAME, ID))
        photo_set = self._studio.records.get(id_)
        if self._branches.get(id_) is not item or id_ in self._names:
            return
        if names := self._known_names(id_):
            self._fill(id_, names)
        elif isinstance(photo_set, PhotoSet):
            self._names[id_] = ()
            folder = self._survey.document.folder_of(photo_set)

            # The folder may be on a slow drive.
            self._background.run(
                lambda: [] if folder is None else photo_names(folder),
                partial(self._listed, id_, item),
                lambda _: self._listed(id_, item, []),
            )

    def _listed(self, id_: str, item: QTreeWidgetItem, names: list[str]) -> None:
        if self._branches.get(id_) is item and not self._names[id_]:
            self._fill(id_, names)
            record = self._studio.records.get(id_)
            if isinstance(record, PhotoSet):
                self._title(record)
            if not names:
                hides = QTreeWidgetItem.ChildIndicatorPolicy.DontShowIndicatorWhenChildless
                item.setChildIndicatorPolicy(hides)

    def _fill(self, id_: str, names: Sequence[str]) -> None:
        self._names[id_] = names
        self._fill_on()
        self._timer.start()

    def _fill_on(self) -> None:
        """Make the next rows of a branch that lacks some."""
        for id_, names in self._names.items():
            branch = self._branches[id_]
            there = branch.childCount()
            if there < len(names):
                icon = theme.icon("image-outline")
                rows: list[QTreeWidgetItem] = []
                for name in names[there : there + _AT_ONCE]:
                    row = TreeItem([name])
                    row.setData(NAME, ID, id_)
                    row.setData(NAME, PHOTO, name)
                    row.setData(NAME, SORT, there + len(rows))
                    row.setIcon(NAME, icon)
                    row.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
                    rows.append(row)
                with QSignalBlocker(self._tree):
                    branch.addChildren(rows)
                    self._describe(set(names[there : there + _AT_ONCE]), id_)
                return
        self._timer.stop()

    def _describe(self, photos: set[str], only: str = "") -> None:
        """Say of these photos what is drawn in them. only : the id of the set to look at"""
        for id_ in [only] if only else self._names:
            branch = self._branches[id_]
            names = self._names[id_][: branch.childCount()]
            numbers = [i for i, name in enumerate(names) if name in photos]
            if not numbers:
                continue
            records = self._studio.records
            counts: dict[str, int] = {}
            for _, mark in marks_of(records, id_):
                counts[mark.photo] = counts.get(mark.photo, 0) + 1
            masked = masks_of(records, id_).keys()
            for number in numbers:
                name = names[number]
                count = counts.get(name, 0)
                said = [tr_n("{count} mark", "{count} marks", count)] if count else []
                said += [tr("mask")] if name in masked else []
                row = branch.child(number)
                if row is not None:
                    row.setText(ORIENTATION, " · ".join(said))
                    row.setToolTip(NAME, "\n".join([name, *said]))

    # --- what is done ------------------------------------------------------------------------
    def _selected(self) -> None:
        photos = [item for item in self._tree.selectedItems() if item.data(NAME, PHOTO)]
        if len(photos) == 1 and self._in_panel(str(photos[0].data(NAME, ID))):
            self.chosen.emit(str(photos[0].data(NAME, PHOTO)))

    def _open(self, item: QTreeWidgetItem | None) -> None:
        record = None if item is None else self._studio.records.get(str(item.data(NAME, ID)))
        if item is None or not isinstance(record, PhotoSet):
            return
        if photo := item.data(NAME, PHOTO):
            self._opening.open_in(record, str(photo))

    def menu_for(self, menu: QMenu, item: QTreeWidgetItem) -> bool:
        """Fill the context menu of a set or a photo; False where the row is neither."""
        record = self._studio.records.get(str(item.data(NAME, ID)))
        if not isinstance(record, PhotoSet):
            return False
        photo = item.data(NAME, PHOTO)
        menu.addAction(
            theme.icon("image-edit-outline"),
            tr("&Open photo") if photo else tr("&Open its first photo"),
            partial(self._opening.open_in, record, photo),
        )
        menu.addAction(
            theme.icon("image-multiple-outline"),
            tr("Show in the &Photos panel"),
            partial(self._show_in_panel, record, photo),
        )
        if self._in_panel(record.id):
            menu.addSeparator()
            for name in _OFFERED:
                if name == "|":
                    menu.addSeparator()
                else:
                    menu.addAction(self._actions[name])
        return True

    def _show_in_panel(self, photo_set: PhotoSet, photo: str | None) -> None:
        if self._opening.open_set(photo_set):
            self._show_panel()
            if photo:
                self.chosen.emit(photo)


def _photos_in(changed: Sequence[Record | None]) -> set[str]:
    return {r.photo for r in changed if isinstance(r, ImageMark | Mask)}
