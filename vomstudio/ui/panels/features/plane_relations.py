"""Angle between two planes, and their intersection line."""

from __future__ import annotations

from collections import Counter
from html import escape

from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr, tr_n
from vomstudio.project import edits
from vomstudio.project.kinds import group_and_set, has_plane
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.measurement_cache import Measurement
from vomstudio.project.records import FeatureType, Group
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, allow, rich_label
from vomstudio.ui.base.number_formatting import degrees, natural_sort_key
from vomstudio.ui.base.studio import Studio


def line_type(studio: Studio) -> str:
    """The feature type that an intersection gets: the lineation's, else another line's."""
    kinds = studio.session.of(FeatureType)
    order = sorted(kinds, key=lambda k: (k.id != "lineation", k.geometry != "line"))
    return order[0].id


def of_selected(studio: Studio) -> Intersection | None:
    """The intersection of exactly two selected planes, not in the document; else None."""
    ids = studio.selection.ids
    if len(ids) != 2 or not all(has_plane(studio.records.get(i)) for i in ids):
        return None
    return between(studio, Group(feature_id=ids[0]), Group(feature_id=ids[1]))


def between(studio: Studio, first: Group, second: Group) -> Intersection:
    """The intersection of two groups of planes, not in the document."""
    return Intersection(new_id("intersection"), "", line_type(studio), first, second)


def why_not_keep(studio: Studio) -> Finding | None:
    """Return why the intersection of the selected planes cannot be kept; None if it can."""
    relation = of_selected(studio)
    if relation is None:
        return Finding("selection.not-two-planes")
    return studio.measure(relation).problem


def why_no_line(measured: Measurement) -> Finding | None:
    """Return that the line of intersection is not known; None if it is."""
    return None if measured.line is not None else Finding("action.no-intersection")


def keep(studio: Studio) -> None:
    """Make the intersection of the two selected planes a feature."""
    relation = of_selected(studio)
    if relation is not None and studio.attempt(edits.add_features, [relation]):
        studio.selection.set([relation.id])


def relation_lines(measured: Measurement) -> list[str]:
    """Angle, intersection line, error and reasons as lines of rich text."""
    if measured.line is None:
        return [escape(str(measured.problem or "–"))]
    intersection = (
        tr("Intersection: <b>{line}</b>, 95 % error unknown", line=measured.attitude())
        if measured.total95_deg is None
        else tr("Intersection: <b>{line}</b> (95 %)", line=measured.attitude())
    )
    registered = []
    if measured.registration_error_deg is not None:
        error = degrees(measured.registration_error_deg)
        registered.append(tr("Of that by the registration: {error}", error=error))
    return [
        tr("Angle between the planes: {angle}", angle=degrees(measured.angle_deg)),
        intersection,
        *registered,
        *(
            f"• {escape(reason.message)}"
            for reason in (measured.verdict.reasons if measured.verdict else ())
        ),
    ]


class IntersectionDialog(QDialog):
    """Two groups of planes, each a feature type or one of its sets, and the line where their mean
    planes meet."""

    def __init__(self, studio: Studio, parent: QWidget) -> None:
        super().__init__(parent)
        self._studio = studio
        self.setWindowTitle(tr("Intersection of sets"))
        self.first, self.second, self.type_box = ComboBox(), ComboBox(), ComboBox()
        self.result_text = rich_label()
        self.result_text.setWordWrap(True)
        self.result_text.setMinimumWidth(380)
        self.name = QLineEdit()
        self.name.setPlaceholderText(tr("Next free name"))
        buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.keep_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.keep_button.setText(tr("Keep intersection"))
        buttons.accepted.connect(self._keep)
        buttons.rejected.connect(self.reject)
        groups = groups_of(studio)
        for box in (self.first, self.second):
            for text, color, group in groups:
                box.addItem(theme.swatch(color), text, group)
            box.currentIndexChanged.connect(self._refresh)
        for kind in sorted(studio.session.of(FeatureType), key=lambda k: k.geometry != "line"):
            self.type_box.addItem(theme.swatch(kind.color), kind.name, kind.id)
        self.type_box.setCurrentIndex(max(0, self.type_box.findData(line_type(studio))))
        # Most often bedding is cut by a fault (textbook, fig. 30).
        self.first.setCurrentIndex(self._find(groups, "bedding", 0))
        self.second.setCurrentIndex(self._find(groups, "fault", min(1, len(groups) - 1)))
        form = QFormLayout()
        form.addRow(tr("Planes of"), self.first)
        form.addRow(tr("and planes of"), self.second)
        form.addRow(tr("Feature type"), self.type_box)
        form.addRow(tr("Name"), self.name)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.result_text)
        layout.addStretch()
        layout.addWidget(buttons)
        self._refresh()

    @staticmethod
    def _find(groups: list[tuple[str, str, Group]], type_id: str, instead: int) -> int:
        for i, (_, _, group) in enumerate(groups):
            if group.type_id == type_id and not group.set_name:
                return i
        return instead

    def relation(self) -> Intersection | None:
        """The intersection that is chosen; None where both groups are the same."""
        first, second = self.first.currentData(), self.second.currentData()
        if first is None or second is None or first == second:
            return None
        made = between(self._studio, first, second)
        return Intersection(
            made.id, self.name.text().strip(), str(self.type_box.currentData()), first, second
        )

    def _refresh(self, *_: object) -> None:
        relation = self.relation()
        if relation is None:
            same = Finding("action.same-groups")
            self.result_text.setText(same.message)
            allow(self.keep_button, same)
            return
        measured = self._studio.measure(relation)
        self.result_text.setText("<br>".join(relation_lines(measured)))
        allow(self.keep_button, why_no_line(measured))

    def _keep(self) -> None:
        relation = self.relation()
        if relation is not None and self._studio.attempt(edits.add_features, [relation]):
            self._studio.selection.set([relation.id])
            self.accept()


def groups_of(studio: Studio) -> list[tuple[str, str, Group]]:
    """Text, colour and group of every feature type with planes, and of each of its sets."""
    counts: Counter[tuple[str, str]] = Counter()
    every = studio.session.records.count_by(group_and_set)
    for (type_id, set_name, is_plane), count in every.items():
        # "" stands for all sets.
        for name in {"", set_name} if is_plane else ():
            counts[type_id, name] += count
    found = []
    for kind in studio.session.of(FeatureType):
        names = sorted((n for t, n in counts if t == kind.id), key=natural_sort_key)
        for name in names:
            count = counts[kind.id, name]
            title = f"{kind.name}, {name}" if name else kind.name
            text = tr_n("{group} ({count} plane)", "{group} ({count} planes)", count, group=title)
            group = Group(type_id=kind.id, set_name=name)
            found.append((text, kind.color, group))
    return found
