"""Panel for the statistics of the selection, a feature type or a set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QTextBrowser, QToolButton, QVBoxLayout

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import FeatureType, TypedFeature
from vomstudio.project.registration_errors import get_models, get_rotation_errors
from vomstudio.studio.fold_choice import FOLD_TYPE
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, limit_width, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import natural_sort_key
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import LazyPanel
from vomstudio.ui.panels.statistics.texts import Rows, domain_rows, fold_rows, statistics_rows
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table
from vomstudio.ui.widgets.fold_box import FoldBox
from vomstudio.ui.widgets.group_box import SELECTED, GroupBox

if TYPE_CHECKING:
    from vomstudio.geology.folds import FoldAxis
    from vomstudio.project.fold_planes import FoldPlanes


class StatisticsPanel(LazyPanel):
    """Panel for the statistics of one group of features.

    Different types are pooled only in a selection, and the panel then reports this.
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__(studio)
        set_help_topic(self, "numbers.md#means-and-fold-axes")
        self.group_box = GroupBox(studio)
        self.group_box.setAccessibleName(tr("Statistics of"))
        self.group_box.activated.connect(lambda _: self.refresh())
        self.figures = QTextBrowser()
        self.figures.setAccessibleName(tr("Statistics"))
        self._clipboard_text = ""
        self.copy = QToolButton()
        self.copy.setIcon(theme.icon("content-copy"))
        self.copy.setToolTip(tr("Copy as text"))
        self.copy.setAccessibleName(tr("Copy as text"))
        self.copy.clicked.connect(lambda: QGuiApplication.clipboard().setText(self._clipboard_text))
        self.command = CopyCommandButton(
            self._copy_command, tr("save the data as a table and copy the command")
        )
        row = QHBoxLayout()
        label = Label(tr("Planes"))
        label.setBuddy(self.group_box)
        row.addWidget(label)
        row.addWidget(self.group_box, 1)
        row.addWidget(self.copy)
        row.addWidget(self.command)
        self.fold_box = FoldBox(studio)
        form = QVBoxLayout()
        form.setContentsMargins(6, 4, 6, 4)
        form.setSpacing(4)
        form.addLayout(row)
        form.addWidget(self.fold_box)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(limit_width(form))
        column.addWidget(self.figures, 1)
        studio.settings_changed.connect(self._schedule_refresh)
        studio.edited.connect(self._follow_edit)
        connect_until_deleted(self, studio.fold.changed, self._schedule_refresh)
        studio.selection_changed.connect(self._follow_selection)
        self._schedule_refresh()

    def _follow_selection(self) -> None:
        if self.group_box.choice() == SELECTED or self._studio.fold.is_selected:
            self._schedule_refresh()

    def update_widgets(self) -> None:
        self.group_box.list_groups()
        features = self.group_box.features()
        pages = [*self._kind_pages(features, "plane"), *self._kind_pages(features, "line")]
        if not pages:
            self._clipboard_text = ""
            is_selection = self.group_box.choice() == SELECTED
            code = "selection.unsuitable" if is_selection else "features.no-orientation"
            self.figures.setPlainText(Finding(code).message)
        else:
            notes = self.group_box.exclusion_messages()
            self._clipboard_text = "\n\n".join(
                [*(_plain_text(title, rows) for title, rows in pages), *notes]
            )
            note_html = "".join(f"<p>{escape(sentence)}</p>" for sentence in notes)
            self.figures.setHtml("".join(_html(title, rows) for title, rows in pages) + note_html)
        reason = None if pages else Finding("action.no-result")
        set_enabled(self.copy, reason)
        self.command.set_enabled(reason)

    def _copy_command(self) -> None:
        ids = [f.id for f in self.group_box.features()]
        copy_with_table(self, self._studio, "planes.csv", ids, lambda path: ["stats", path])

    def _kind_pages(
        self, features: Sequence[TypedFeature], geometry: str
    ) -> list[tuple[str, Rows]]:
        """Return the titles and rows for the planes and their fold axis, or for the lines.

        `geometry` is "plane" or "line". The list is empty if no feature has this geometry.
        """
        import numpy as np

        from vomstudio.geology.populations.set_statistics import set_statistics

        measurements = self._studio.measured(f.id for f in features)
        oriented_features = [
            f for f in features if getattr(measurements[f.id], geometry) is not None
        ]
        if not oriented_features:
            return []
        rotations = get_rotation_errors(get_models(self._studio.records, oriented_features))
        notation = self._studio.settings.notation
        if geometry == "line":
            lines = [
                line for f in oriented_features if (line := measurements[f.id].line) is not None
            ]
            vectors = np.array([line.vector() for line in lines])
            statistics = set_statistics(vectors, "lines", rotation_errors=rotations)
            return [(tr("Lines"), statistics_rows(statistics, notation))]
        planes = [
            plane for f in oriented_features if (plane := measurements[f.id].plane) is not None
        ]
        vectors = -np.array([plane.normal() for plane in planes])
        rows = statistics_rows(set_statistics(vectors, rotation_errors=rotations), notation)
        mixed_type_rows = self._mixed_type_rows(oriented_features)
        pages = [(tr("Planes"), [*mixed_type_rows, *rows])]
        if not mixed_type_rows:
            pages[:0] = self._fold_pages(oriented_features, measurements)
        return pages

    def _fold_pages(
        self, features: Sequence[TypedFeature], measurements: Mapping[str, Measurement]
    ) -> list[tuple[str, Rows]]:
        """Return titles and rows for the fold axis of planes of one type, and for its domains.

        The list is empty for fewer than three features.
        """
        from vomstudio.project.fold_planes import fold_planes

        fold, fold_filter = self._studio.fold, self._studio.fold.fold_filter
        if self.group_box.choice() == ("type", FOLD_TYPE, "") and fold.features():
            planes = fold.planes()
        else:
            # The group already restricts the planes to the set.
            fold_filter = replace(fold_filter, set_name=None)
            planes = fold_planes(self._studio.records, features, measurements, fold_filter)
        if len(features) < 3:
            return []
        title = tr("As a fold")
        try:
            axis = planes.axis()
        except VomError as error:
            return [(title, [(tr("Verdict"), error.message)])]
        axis, domains = _domains(planes, axis)
        return [(title, fold_rows(axis, planes, self._studio.settings.notation)), *domains]

    def _mixed_type_rows(self, features: Sequence[TypedFeature]) -> Rows:
        kinds = {f.type_id for f in features}
        if len(kinds) < 2:
            return []
        names = [k.name for k in self._studio.session.of(FeatureType) if k.id in kinds]
        return [(tr("Note"), Finding("sets.mixed-types", n=len(kinds), types=names).message)]


DOMAIN_TITLES = {
    "domain": to_translate("By domain"),
    "set_name": to_translate("By set"),
}
"""Titles of the fold axes of domains, by the attribute that defines the domains."""


def _domains(planes: FoldPlanes, axis: FoldAxis) -> tuple[FoldAxis, list[tuple[str, Rows]]]:
    """Compute the fold axes of the domains and apply their verdict to the common axis.

    If no plane has a domain, the sets serve as domains and the axis is not changed.

    Returns
    -------
    FoldAxis
        Fold axis with the verdict of the domains.
    list of (str, Rows)
        Title and rows of the domains; empty if there are fewer than two domains.
    """
    from vomstudio.geology.domains import apply_domain_verdict, domain_axes

    has_domains = any(feature.domain for feature in planes.features)
    members: dict[str, list[int]] = {}
    for row, feature in enumerate(planes.features):
        name = (
            feature.domain or tr("no domain") if has_domains else feature.set_name or tr("no set")
        )
        members.setdefault(name, []).append(row)
    if len(members) < 2:
        return axis, []
    beds = {
        name: (planes.azimuth_deg[rows], planes.dip_deg[rows])
        for name, rows in sorted(members.items(), key=lambda item: natural_sort_key(item[0]))
    }
    title = tr(DOMAIN_TITLES["domain" if has_domains else "set_name"])
    figures, one_axis = domain_axes(beds, axis)
    axis = apply_domain_verdict(axis, one_axis) if has_domains else axis
    return axis, [(title, domain_rows(figures, one_axis))]


def _html(title: str, rows: Rows) -> str:
    cells = "".join(
        f"<tr><td colspan='2' style='padding:1px 2px 1px 4px'>{name} {escape(value)}</td></tr>"
        if name == "•"
        else f"<tr><td style='padding:1px 8px 1px 4px'>{escape(name)}</td>"
        f"<td style='padding:1px 2px'>{escape(value)}</td></tr>"
        for name, value in rows
    )
    return f"<p style='margin:4px'><b>{escape(title)}</b></p><table width='100%'>{cells}</table>"


def _plain_text(title: str, rows: Rows) -> str:
    return "\n".join([title, *(f"{name}\t{value}" for name, value in rows)])
