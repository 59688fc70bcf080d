"""Panel that proposes sets of planes, previews them on the net and assigns them."""

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
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.geology.sets.set_options import SetOptions
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.records import FeatureType, TypedFeature
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import (
    MAX_FORM_WIDTH_PX,
    ComboBox,
    limit_width,
    narrow_form,
    set_enabled,
)
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import length, number
from vomstudio.ui.base.qt_background import LatestRequestRunner
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.sets.candidates import (
    Choice,
    ProposalResult,
    assignable_features,
    collect_candidates,
    proposal_warnings,
    propose,
)
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table, result_path
from vomstudio.ui.widgets.options_form import OptionFields

_SELECTED: Choice = ("selection", "")
_MIN_TABLE_HEIGHT_PX = 96


class SetsPanel(QWidget):
    """Panel that proposes sets of planes.

    The project does not change until a proposal is accepted, which is one edit.

    Attributes
    ----------
    result : ProposalResult or None
        Proposal that has been neither accepted nor rejected.
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        set_help_topic(self, "conventions.md#proposed-sets")
        self._studio = studio
        self.result: ProposalResult | None = None
        self._options = SetOptions()
        self._newest = LatestRequestRunner(
            self, self._show_result, self._show_error, self._show_progress
        )
        self._make_fields()
        self._make_table()
        self._arrange_widgets()
        studio.sets_requested.connect(self.propose)
        studio.edited.connect(self._follow_edit)
        self._list_groups()
        self._show_state("")

    def _make_fields(self) -> None:
        self.group_box = ComboBox()
        self.group_box.setObjectName("sets_of")
        self.group_box.activated.connect(lambda _: self._repeat_proposal())
        self.options = OptionFields(SetOptions, "sets")
        self.count = self.options.fields["exactly"]
        seeds = self.options.fields["seeds"]
        assert isinstance(self.count, QSpinBox)
        assert isinstance(seeds, QLineEdit)
        self.seeds = seeds
        self.count.valueChanged.connect(lambda _: self._repeat_proposal())
        self.seeds.textChanged.connect(lambda _: self._show_count())
        self.seeds.returnPressed.connect(self.propose)
        self.assigned_box = QCheckBox(tr("Include assigned planes"))
        self.assigned_box.setToolTip(
            tr("Also replace existing sets; planes outside the new sets lose their set.")
        )
        self.assigned_box.clicked.connect(lambda _: self._repeat_proposal())
        self.start = QPushButton(theme.icon("scatter-plot-outline"), tr("Propose"))
        self.start.clicked.connect(lambda _: self.propose())
        self.accept = QPushButton(theme.icon("check"), tr("Accept"))
        self.accept.setToolTip(tr("Assign the sets to the planes. Undo reverts this."))
        self.accept.clicked.connect(lambda _: self._accept())
        self.reject = QPushButton(theme.icon("close"), tr("Reject"))
        self.reject.setToolTip(tr("Discard the proposal without changes."))
        self.reject.clicked.connect(lambda _: self.drop())
        self.copy = CopyCommandButton(
            self._copy_command, tr("save these planes as a table and copy the command")
        )
        self.message = hint_label()
        self.message.setObjectName("sets_said")

    def _make_table(self) -> None:
        columns = (
            (
                tr("Set"),
                tr("Double-click to rename. Equal names merge; unnamed sets are skipped."),
            ),
            ("n", tr("Planes in the set.")),
            (tr("Mean"), tr("Fisher mean plane, ± 95 % error including registration.")),
            ("κ", tr("Fisher's concentration: larger means less scatter.")),
            (
                tr("Spacing"),
                tr("Mean spacing along the mean normal, assuming infinite planes."),
            ),
        )
        self.table = QTableWidget(0, len(columns))
        self.table.setObjectName("sets_table")
        self.table.setAccessibleName(tr("Proposed sets"))
        for column, (title, tooltip) in enumerate(columns):
            item = QTableWidgetItem(title)
            item.setToolTip(tooltip)
            self.table.setHorizontalHeaderItem(column, item)
        self.table.verticalHeader().hide()
        self.table.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.table.setMinimumHeight(_MIN_TABLE_HEIGHT_PX)
        self.table.itemChanged.connect(lambda _: self._show_preview())

    def _arrange_widgets(self) -> None:
        form = narrow_form()
        form.addRow(tr("Planes"), self.group_box)
        self.options.add_rows(form)
        buttons = QHBoxLayout()
        for button in (self.start, self.accept, self.reject, self.copy):
            buttons.addWidget(button)
        form.addRow(self.assigned_box)
        form.addRow(buttons)
        column = narrow_column(self)
        column.addLayout(limit_width(form))
        column.addWidget(self.message)
        # Figures far to the right of their sets could not be read.
        self.table.setMaximumWidth(MAX_FORM_WIDTH_PX)
        row = QHBoxLayout()
        row.addWidget(self.table, 1)
        row.addStretch()
        column.addLayout(row, 1)
        column.addStretch()

    # --- candidates --------------------------------------------------------------------------
    def _choice(self) -> Choice:
        data = self.group_box.currentData()
        return _SELECTED if data is None else tuple(data)

    def _list_groups(self) -> None:
        """List the groups of planes, keeping the current group if it still exists."""
        groups: list[tuple[str, Choice]] = [(tr("Selection"), _SELECTED)]
        if assignable_features(self._studio, ("picked", "")):
            groups.append((tr("All picked planes"), ("picked", "")))
        used_types = {f.type_id for f in self._studio.session.of(TypedFeature)}
        for type_ in self._studio.session.of(FeatureType):
            if type_.id in used_types and assignable_features(self._studio, ("type", type_.id)):
                groups.append((type_.name, ("type", type_.id)))
        titles = [self.group_box.itemText(i) for i in range(self.group_box.count())]
        if titles == [title for title, _ in groups]:
            return
        previous, choices = self._choice(), [choice for _, choice in groups]
        self.group_box.clear()
        for title, choice in groups:
            self.group_box.addItem(title, choice)
        is_listed = previous in choices and len(titles) > 1
        self.group_box.setCurrentIndex(
            choices.index(previous) if is_listed else min(1, len(groups) - 1)
        )

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._list_groups()
        self._show_preview()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802
        super().hideEvent(event)
        # The net shows a proposal only while it can be accepted or rejected.
        self._studio.sets_proposed.emit(None)

    # --- proposing ---------------------------------------------------------------------------
    def _repeat_proposal(self) -> None:
        """Repeat the proposal if one is shown or being computed."""
        if self.result is not None or self._newest.is_waiting:
            self.propose()

    def propose(self) -> None:
        """Propose sets for the planes of the group in a worker thread."""
        self._list_groups()
        try:
            planes = collect_candidates(
                self._studio, self._choice(), include_assigned=self.assigned_box.isChecked()
            )
        except VomError as error:
            self.drop(cause_finding(error))
            return
        overrides = {"exactly": None} if self.seeds.text().strip() else {}
        self._options = self.options.options(**overrides)
        self._newest.request(partial(propose, planes, self._options))
        self._show_state(self.message.text())

    def _show_progress(self) -> None:
        self._show_state(tr("Searching for sets…"))

    def _show_result(self, result: ProposalResult) -> None:
        self.result = result
        self._fill(result)
        self._show_state("\n".join(map(str, proposal_warnings(result, self._options))))
        self._show_preview()

    def _show_error(self, error: VomError) -> None:
        self.drop(cause_finding(error))

    def drop(self, reason: Finding | None = None) -> None:
        """Discard the proposal, and show the reason if one is given."""
        self._newest.cancel()
        self.result = None
        with QSignalBlocker(self.table):
            self.table.setRowCount(0)
        self._show_state("" if reason is None else reason.message)
        self._show_preview()

    def _accept(self) -> None:
        result = self.result
        if result is None:
            return
        names = self._set_names()
        assignment = result.set_names(names)
        # Otherwise `_follow_edit` would discard the proposal on its own edit.
        self.result = None
        if not self._studio.attempt(edits.assign_sets, assignment):
            self.result = result
            return
        self._studio.settings.color_by = "set"
        self._studio.keep_settings()
        counts = [
            tr("{set}: {count:,}", set=s, count=len(ids)) for s, ids in result.groups(names) if s
        ]
        self.drop(Finding("sets.accepted", sets=counts))

    # --- changes of the project ----------------------------------------------------------------
    def _follow_edit(self, edit: Edit) -> None:
        affected_ids = set(self._studio.affected_ids(edit))
        if self.result is not None and not affected_ids.isdisjoint(self.result.candidates.ids):
            self.drop(Finding("sets.planes-changed"))
        elif self._newest.is_waiting and affected_ids:
            self.propose()
        if self.isVisible():
            self._list_groups()

    # --- display -----------------------------------------------------------------------------
    def _set_names(self) -> list[str]:
        """Return the set names as typed by the user."""
        count = 0 if self.result is None else len(self.result.sets)
        items = [self.table.item(row, 0) for row in range(count)]
        return ["" if item is None else item.text() for item in items]

    def _fill(self, result: ProposalResult) -> None:
        from vomstudio.geology.notation import format_attitude
        from vomstudio.geology.orientation import Plane

        notation = self._studio.settings.notation
        rows = []
        for set_, name, cone in zip(result.sets, result.names, result.cones_deg, strict=True):
            plane = Plane(set_.dip_direction_deg, set_.dip_deg)
            mean = format_attitude(plane, cone, notation, omit_hand_rule=True)
            numbers = number(set_.kappa), length(set_.spacing_m)
            rows.append([name, f"{set_.n:,}", mean, *numbers])
        rows.append([tr("no set"), f"{result.unassigned_count:,}", "", "", ""])
        with QSignalBlocker(self.table):
            self.table.setRowCount(len(rows))
            for row, texts in enumerate(rows):
                for column, text in enumerate(texts):
                    self._put(row, column, text, has_name=row < len(result.sets))

    def _put(self, row: int, column: int, text: str, *, has_name: bool) -> None:
        item = QTableWidgetItem(text)
        if column:
            item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        else:
            item.setIcon(_swatch(row, has_name))
        if column or not has_name:
            item.setFlags(Qt.ItemFlag.ItemIsEnabled)
        self.table.setItem(row, column, item)

    def _show_state(self, message: str) -> None:
        result = self.result
        self.message.setText(message)
        self.message.setVisible(bool(message))
        self.table.setVisible(result is not None)
        can_accept = result is not None and bool(result.sets) and not self._newest.is_waiting
        no_proposal = Finding("sets.no-proposal")
        set_enabled(self.accept, None if can_accept else no_proposal)
        set_enabled(self.reject, None if result is not None else no_proposal)
        self.copy.set_enabled(None if result is not None else no_proposal)
        self._show_count()

    def _copy_command(self) -> None:
        result = self.result
        if result is None:
            return
        arguments = option_words(self._options)
        copy_with_table(
            self,
            self._studio,
            "planes.csv",
            result.candidates.ids,
            lambda path: ["sets", path, *arguments, ("-o", result_path(path, "csv")), "--force"],
        )

    def _show_count(self) -> None:
        self.count.setEnabled(not self.seeds.text().strip())

    def _show_preview(self) -> None:
        """Show the proposal on the net while this panel is visible."""
        result = self.result
        is_shown = result is not None and self.isVisible()
        names = self._set_names()
        groups = result.groups(names) if result is not None and is_shown else None
        self._studio.sets_proposed.emit(groups)


def _swatch(row: int, has_name: bool) -> QIcon:
    """Return an icon in the colour that the set has on the net."""
    from vomstudio.ui.panels.net.feature_sets import set_color

    picture = QPixmap(12, 12)
    picture.fill(QColor(set_color(row, has_name)))
    return QIcon(picture)
