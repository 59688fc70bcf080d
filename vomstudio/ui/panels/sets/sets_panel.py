"""The sets dock: sets proposed among planes, shown on the net, and taken over where accepted."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QColor, QHideEvent, QIcon, QPixmap, QShowEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QCheckBox,
    QHBoxLayout,
    QHeaderView,
    QLineEdit,
    QPushButton,
    QSpinBox,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.records import FeatureType, Typed
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, allow, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.number_formatting import length, number
from vomstudio.ui.base.qt_background import NewestResult
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.sets.candidates import (
    Choice,
    Proposed,
    candidates,
    propose,
    remarks_on,
    with_set,
)
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table, result_path
from vomstudio.ui.widgets.options_form import OptionFields

_SELECTED: Choice = ("selection", "")
_LEAST_HEIGHT = 96


class SetsPanel(QWidget):
    """proposed : what is shown and not yet decided upon, None where there is nothing. Nothing is
    changed before it is accepted, and that is one edit."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        explain(self, "conventions.md#sets-proposed")
        self._studio = studio
        self.proposed: Proposed | None = None
        self._options = SetOptions()
        self._newest = NewestResult(self, self._came, self._failed, self._slow)
        self._make_fields()
        self._make_table()
        self._arrange()
        studio.project_opened.connect(self._reopened)
        studio.sets_requested.connect(self.propose)
        studio.edited.connect(self._edited)
        self._list_groups()
        self._show_state("")

    def _make_fields(self) -> None:
        self.of = ComboBox()
        self.of.setObjectName("sets_of")
        self.of.activated.connect(lambda _: self._again())
        self.options = OptionFields(SetOptions, "sets")
        self.count = self.options.fields["exactly"]
        seeds = self.options.fields["seeds"]
        assert isinstance(self.count, QSpinBox)
        assert isinstance(seeds, QLineEdit)
        self.seeds = seeds
        self.count.valueChanged.connect(lambda _: self._again())
        self.seeds.textChanged.connect(lambda _: self._show_count())
        self.seeds.returnPressed.connect(self.propose)
        self.also = QCheckBox(tr("Also those that have a set"))
        self.also.setToolTip(
            tr(
                "Accepting then gives all of these planes new sets, and takes the set from those "
                "that are in none of the new ones."
            )
        )
        self.also.clicked.connect(lambda _: self._again())
        self.start = QPushButton(theme.icon("scatter-plot-outline"), tr("Propose"))
        self.start.clicked.connect(lambda _: self.propose())
        self.accept = QPushButton(theme.icon("check"), tr("Accept"))
        self.accept.setToolTip(tr("Write the sets to the planes; undo takes it back."))
        self.accept.clicked.connect(lambda _: self._accept())
        self.reject = QPushButton(theme.icon("close"), tr("Reject"))
        self.reject.setToolTip(tr("Forget the proposal; nothing is changed."))
        self.reject.clicked.connect(lambda _: self.drop())
        self.copy = CopyCommandButton(
            self._copy_command, tr("keep these planes as a table, and copy the command")
        )
        self.said = hint_label()
        self.said.setObjectName("sets_said")

    def _make_table(self) -> None:
        heads = (
            (
                tr("Set"),
                tr(
                    "Click twice to type another name. Sets of one name become one set; "
                    "without a name a set is not taken over."
                ),
            ),
            ("n", tr("Planes in the set.")),
            (tr("Mean"), tr("Mean plane after Fisher, ± its 95 % error with the registration.")),
            ("κ", tr("Fisher's concentration: the larger, the more alike.")),
            (
                tr("Spacing"),
                tr("Mean gap along the mean normal, as if each plane reached past all others."),
            ),
        )
        self.table = QTableWidget(0, len(heads))
        self.table.setObjectName("sets_table")
        self.table.setAccessibleName(tr("Proposed sets"))
        for column, (title, tip) in enumerate(heads):
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            self.table.setHorizontalHeaderItem(column, item)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.table.setMinimumHeight(_LEAST_HEIGHT)
        self.table.itemChanged.connect(lambda _: self._preview())

    def _arrange(self) -> None:
        form = narrow_form()
        form.addRow(tr("Of"), self.of)
        self.options.add_rows(form)
        buttons = QHBoxLayout()
        for button in (self.start, self.accept, self.reject, self.copy):
            buttons.addWidget(button)
        column = narrow_column(self)
        column.addLayout(form)
        column.addWidget(self.also)
        column.addLayout(buttons)
        column.addWidget(self.said)
        column.addWidget(self.table, 1)

    # --- which planes ------------------------------------------------------------------------
    def _choice(self) -> Choice:
        data = self.of.currentData()
        return _SELECTED if data is None else tuple(data)

    def _list_groups(self) -> None:
        """The groups that there are; the one that was chosen stays, where it is still there."""
        groups: list[tuple[str, Choice]] = [(tr("Selection"), _SELECTED)]
        if with_set(self._studio, ("picked", "")):
            groups.append((tr("All picked planes"), ("picked", "")))
        own = {f.type_id for f in self._studio.session.of(Typed)}
        for type_ in self._studio.session.of(FeatureType):
            if type_.id in own and with_set(self._studio, ("type", type_.id)):
                groups.append((type_.name, ("type", type_.id)))
        shown = [self.of.itemText(i) for i in range(self.of.count())]
        if shown == [title for title, _ in groups]:
            return
        chosen, known = self._choice(), [choice for _, choice in groups]
        self.of.clear()
        for title, choice in groups:
            self.of.addItem(title, choice)
        keep = chosen in known and len(shown) > 1
        self.of.setCurrentIndex(known.index(chosen) if keep else min(1, len(groups) - 1))

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._list_groups()
        self._preview()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        super().hideEvent(event)
        # A net must not show what nobody can accept or reject.
        self._studio.sets_proposed.emit(None)

    # --- proposing ---------------------------------------------------------------------------
    def _again(self) -> None:
        """Other planes or another number: propose anew what is being looked at."""
        if self.proposed is not None or self._newest.is_waiting:
            self.propose()

    def propose(self) -> None:
        """Among the chosen planes, in a thread."""
        self._list_groups()
        try:
            of = candidates(self._studio, self._choice(), replacing=self.also.isChecked())
        except VomError as error:
            self.drop(cause_of(error))
            return
        seeded = {"exactly": None} if self.seeds.text().strip() else {}
        self._options = self.options.options(**seeded)
        self._newest.request(partial(propose, of, self._options))
        self._show_state(self.said.text())

    def _slow(self) -> None:
        self._show_state(tr("Looking for sets…"))

    def _came(self, made: Proposed) -> None:
        self.proposed = made
        self._fill(made)
        self._show_state("\n".join(map(str, remarks_on(made, self._options))))
        self._preview()

    def _failed(self, error: VomError) -> None:
        self.drop(cause_of(error))

    def drop(self, why: Finding | None = None) -> None:
        """Forget the proposal: nothing is changed. why : shown in its place"""
        self._newest.cancel()
        self.proposed = None
        with QSignalBlocker(self.table):
            self.table.setRowCount(0)
        self._show_state("" if why is None else why.message)
        self._preview()

    def _accept(self) -> None:
        made = self.proposed
        if made is None:
            return
        names = self._names()
        put = made.assignment(names)
        # Its own edit is no reason to forget what it was.
        self.proposed = None
        if not self._studio.attempt(edits.assign_sets, put):
            self.proposed = made
            return
        told = [tr("{set}: {count:,}", set=s, count=len(ids)) for s, ids in made.groups(names) if s]
        self.drop(Finding("sets.accepted", sets=told))

    # --- what has happened meanwhile -----------------------------------------------------------
    def _edited(self, edit: Edit) -> None:
        touched = set(self._studio.affected(edit))
        if self.proposed is not None and not touched.isdisjoint(self.proposed.of.ids):
            self.drop(Finding("sets.planes-changed"))
        elif self._newest.is_waiting and touched:
            self.propose()
        if self.isVisible():
            self._list_groups()

    def _reopened(self) -> None:
        self.drop()
        if self.isVisible():
            self._list_groups()

    # --- what is shown -----------------------------------------------------------------------
    def _names(self) -> list[str]:
        """As typed, of each set."""
        count = 0 if self.proposed is None else len(self.proposed.sets)
        items = [self.table.item(row, 0) for row in range(count)]
        return ["" if item is None else item.text() for item in items]

    def _fill(self, made: Proposed) -> None:
        from vomstudio.geology.notation import format_attitude
        from vomstudio.geology.orientation import Plane

        notation = self._studio.settings.notation
        rows = []
        for one, name, cone in zip(made.sets, made.names, made.cones_deg, strict=True):
            plane = Plane(one.dip_direction_deg, one.dip_deg)
            mean = format_attitude(plane, cone, notation, bare=True)
            numbers = number(one.kappa), length(one.spacing_m)
            rows.append([name, f"{one.n:,}", mean, *numbers])
        rows.append([tr("in no set"), f"{made.found.unassigned:,}", "", "", ""])
        with QSignalBlocker(self.table):
            self.table.setRowCount(len(rows))
            for row, texts in enumerate(rows):
                for column, text in enumerate(texts):
                    self._put(row, column, text, named=row < len(made.sets))

    def _put(self, row: int, column: int, text: str, *, named: bool) -> None:
        item = QTableWidgetItem(text)
        if column:
            item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        else:
            item.setIcon(_swatch(row, named))
        if column or not named:
            item.setFlags(Qt.ItemFlag.ItemIsEnabled)
        self.table.setItem(row, column, item)

    def _show_state(self, said: str) -> None:
        made = self.proposed
        self.said.setText(said)
        self.said.setVisible(bool(said))
        self.table.setVisible(made is not None)
        some = made is not None and bool(made.sets) and not self._newest.is_waiting
        none = Finding("sets.no-proposal")
        allow(self.accept, None if some else none)
        allow(self.reject, None if made is not None else none)
        self.copy.allow(None if made is not None else none)
        self._show_count()

    def _copy_command(self) -> None:
        made = self.proposed
        if made is None:
            return
        words = option_words(self._options)
        copy_with_table(
            self,
            self._studio,
            "planes.csv",
            made.of.ids,
            lambda path: ["sets", path, *words, ("-o", result_path(path, "csv")), "--force"],
        )

    def _show_count(self) -> None:
        self.count.setEnabled(not self.seeds.text().strip())

    def _preview(self) -> None:
        """On the net, while this panel is there."""
        made = self.proposed
        shown = made is not None and self.isVisible()
        names = self._names()
        groups = made.groups(names) if made is not None and shown else None
        self._studio.sets_proposed.emit(groups)


def _swatch(row: int, named: bool) -> QIcon:
    """The colour of a set on the net."""
    from vomstudio.ui.panels.net.feature_sets import color_of

    picture = QPixmap(12, 12)
    picture.fill(QColor(color_of(row, named)))
    return QIcon(picture)
