"""Angle and intersection line of two planes."""

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
from vomstudio.ui.base.controls import ComboBox, rich_label, set_enabled
from vomstudio.ui.base.number_formatting import format_error_deg, natural_sort_key
from vomstudio.ui.base.studio import Studio


def default_line_type(studio: Studio) -> str:
    """Return the id of the default intersection type: lineation, or else another line type."""
    feature_types = studio.session.of(FeatureType)
    sorted_types = sorted(feature_types, key=lambda k: (k.id != "lineation", k.geometry != "line"))
    return sorted_types[0].id


def selected_intersection(studio: Studio) -> Intersection | None:
    """Create the intersection of the two selected planes without storing it.

    Returns None unless exactly two planes are selected.
    """
    ids = studio.selection.ids
    if len(ids) != 2 or not all(has_plane(studio.records.get(i)) for i in ids):
        return None
    return create_intersection(studio, Group(feature_id=ids[0]), Group(feature_id=ids[1]))


def create_intersection(studio: Studio, first_group: Group, second_group: Group) -> Intersection:
    """Create the intersection of two groups of planes without storing it."""
    return Intersection(
        id=new_id("intersection"),
        name="",
        type_id=default_line_type(studio),
        first=first_group,
        second=second_group,
    )


def keep_problem(studio: Studio) -> Finding | None:
    """Return why the intersection of the selected planes cannot be stored, or None if it can."""
    intersection = selected_intersection(studio)
    if intersection is None:
        return Finding("selection.not-two-planes")
    return studio.measure(intersection).problem


def line_problem(measurement: Measurement) -> Finding | None:
    """Return why the intersection line is unknown, or None if it is known."""
    return None if measurement.line is not None else Finding("action.no-intersection")


def keep_intersection(studio: Studio) -> None:
    """Store the intersection of the two selected planes as a feature and select it."""
    intersection = selected_intersection(studio)
    if intersection is not None and studio.attempt(edits.add_features, [intersection]):
        studio.selection.set([intersection.id])


def format_relation(measurement: Measurement) -> list[str]:
    """Format the angle, intersection line, error and reasons as lines of rich text.

    If the intersection line is unknown, the only line is the reason.
    """
    if measurement.line is None:
        return [escape(str(measurement.problem or "–"))]
    intersection = (
        tr("Intersection: <b>{line}</b>, 95 % error unknown", line=measurement.attitude())
        if measurement.total95_deg is None
        else tr("Intersection: <b>{line}</b> (95 %)", line=measurement.attitude())
    )
    registration_lines = []
    if measurement.registration_error_deg is not None:
        error = format_error_deg(measurement.registration_error_deg)
        registration_lines.append(tr("Error due to registration: {error}", error=error))
    return [
        tr("Angle between the planes: {angle}", angle=format_error_deg(measurement.angle_deg)),
        intersection,
        *registration_lines,
        *(
            f"• {escape(reason.message)}"
            for reason in (measurement.verdict.reasons if measurement.verdict else ())
        ),
    ]


class IntersectionDialog(QDialog):
    """Dialog that shows the intersection line of the mean planes of two selected groups.

    A group is a feature type or one of its sets.
    """

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
        buttons.accepted.connect(self._keep_result)
        buttons.rejected.connect(self.reject)
        groups = list_plane_groups(studio)
        for box in (self.first, self.second):
            for text, color, group in groups:
                box.addItem(theme.swatch(color), text, group)
            box.currentIndexChanged.connect(self._refresh)
        for feature_type in sorted(
            studio.session.of(FeatureType), key=lambda k: k.geometry != "line"
        ):
            self.type_box.addItem(
                theme.swatch(feature_type.color), feature_type.name, feature_type.id
            )
        self.type_box.setCurrentIndex(max(0, self.type_box.findData(default_line_type(studio))))
        # By default, the most common case is selected: a fault that cuts bedding (textbook, fig.
        # 30).
        self.first.setCurrentIndex(self._find_group(groups, "bedding", 0))
        self.second.setCurrentIndex(self._find_group(groups, "fault", min(1, len(groups) - 1)))
        form = QFormLayout()
        form.addRow(tr("First planes"), self.first)
        form.addRow(tr("Second planes"), self.second)
        form.addRow(tr("Feature type"), self.type_box)
        form.addRow(tr("Name"), self.name)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.result_text)
        layout.addStretch()
        layout.addWidget(buttons)
        self._refresh()

    @staticmethod
    def _find_group(groups: list[tuple[str, str, Group]], type_id: str, default: int) -> int:
        for i, (_, _, group) in enumerate(groups):
            if group.type_id == type_id and not group.set_name:
                return i
        return default

    def intersection(self) -> Intersection | None:
        """Create the selected intersection; return None if the groups are equal or missing."""
        first_group, second_group = self.first.currentData(), self.second.currentData()
        if first_group is None or second_group is None or first_group == second_group:
            return None
        intersection = create_intersection(self._studio, first_group, second_group)
        return Intersection(
            id=intersection.id,
            name=self.name.text().strip(),
            type_id=str(self.type_box.currentData()),
            first=first_group,
            second=second_group,
        )

    def _refresh(self, *_: object) -> None:
        intersection = self.intersection()
        if intersection is None:
            same_group_finding = Finding("action.same-groups")
            self.result_text.setText(same_group_finding.message)
            set_enabled(self.keep_button, same_group_finding)
            return
        measurement = self._studio.measure(intersection)
        self.result_text.setText("<br>".join(format_relation(measurement)))
        set_enabled(self.keep_button, line_problem(measurement))

    def _keep_result(self) -> None:
        intersection = self.intersection()
        if intersection is not None and self._studio.attempt(edits.add_features, [intersection]):
            self._studio.selection.set([intersection.id])
            self.accept()


def list_plane_groups(studio: Studio) -> list[tuple[str, str, Group]]:
    """Return the text, colour and group of each feature type with planes, and of its sets."""
    counts: Counter[tuple[str, str]] = Counter()
    sizes = studio.session.records.count_by(group_and_set)
    for (type_id, set_name, is_plane), count in sizes.items():
        # The empty name represents all sets.
        for name in {"", set_name} if is_plane else ():
            counts[type_id, name] += count
    groups = []
    for feature_type in studio.session.of(FeatureType):
        names = sorted((n for t, n in counts if t == feature_type.id), key=natural_sort_key)
        for name in names:
            count = counts[feature_type.id, name]
            title = f"{feature_type.name}, {name}" if name else feature_type.name
            text = tr_n("{group} ({count} plane)", "{group} ({count} planes)", count, group=title)
            group = Group(type_id=feature_type.id, set_name=name)
            groups.append((text, feature_type.color, group))
    return groups
