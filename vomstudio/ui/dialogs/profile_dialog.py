"""Dialog for the profile of limits by which planes and lines are assessed."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, replace
from typing import Any

from PySide6.QtCore import QSignalBlocker
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.profiles import PROFILES_BY_NAME, Thresholds
from vomstudio.project import edits
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import PROFILE_ID, Feature, get_limits
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio

_MAX_PREVIEW_FEATURES = 5_000
"""Maximum number of features in the preview; assessing more takes too long."""

_LIMITS = (
    ("good_confidence95_deg", "error", to_translate("Error of a good plane, maximum"), "°"),
    ("poor_confidence95_deg", "error", to_translate("Error of a poor plane, above"), "°"),
    ("least_extent_over_resolution", "error", to_translate("Extent over resolution, minimum"), ""),
    ("least_coplanarity", "shape", to_translate("Coplanarity, minimum"), ""),
    ("most_collinearity", "shape", to_translate("Collinearity, maximum"), ""),
    ("extent_over_resolution", "shape", to_translate("Extent over resolution, minimum"), ""),
    ("surface_effect_deg", "", to_translate("Angle to outcrop face, minimum"), "°"),
)

_DESCRIPTIONS = {
    "error": to_translate(
        "A plane is assessed by its 95 % error. Shape and extent are only reported."
    ),
    "shape": to_translate(
        "A plane is assessed by the textbook limits: good if it meets all three, doubtful if it"
        " misses one, otherwise poor. Errors are only reported."
    ),
}


def command(studio: Studio, dialogs: OpenDialogs, parent: QWidget) -> Command:
    """Create the command that opens the dialog."""

    def show_dialog() -> None:
        dialogs.show(ProfileDialog, lambda: ProfileDialog(parent, studio))

    return Command(
        "verdict_profile",
        tr("Verdict &profile…"),
        show_dialog,
        icon="scale-balance",
        tip=tr("Choose the limits by which planes are called good, doubtful or poor."),
    )


class ProfileDialog(QDialog):
    """Editor of the verdict profile, which is applied in one edit that can be undone."""

    def __init__(self, parent: QWidget, studio: Studio) -> None:
        super().__init__(parent)
        set_help_topic(self, "conventions.md#verdicts")
        self._studio = studio
        self.setWindowTitle(tr("Verdict profile"))
        self.setMinimumWidth(460)
        self.profile = ComboBox()
        self.profile.setObjectName("profile")
        self.profile.activated.connect(self._show_selected_profile)
        self.name = QLineEdit()
        self.name.setObjectName("profile_name")
        self.name.setPlaceholderText(tr("Name of your profile"))
        self.name.textEdited.connect(self._handle_change)
        self.description = Label()
        self.description.setWordWrap(True)
        self.effect = Label()
        self.effect.setWordWrap(True)
        self.boxes: dict[str, QDoubleSpinBox] = {}
        self._arrange_widgets()
        studio.edited.connect(self._handle_edit)

    def _arrange_widgets(self) -> None:
        self.form = QFormLayout()
        self.form.addRow(tr("Profile"), self.profile)
        self.form.addRow(tr("Name"), self.name)
        for name, _, title, unit in _LIMITS:
            box = DoubleSpinBox()
            box.setObjectName(name)
            box.setDecimals(1)
            box.setRange(0.1, 100_000.0)
            box.setSuffix(unit)
            box.valueChanged.connect(self._handle_change)
            self.boxes[name] = box
            self.form.addRow(tr(title), box)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.apply_button = buttons.addButton(
            tr("Assess all features"), QDialogButtonBox.ButtonRole.ApplyRole
        )
        self.apply_button.setToolTip(tr("Assess all features in one step, which can be undone."))
        self.apply_button.clicked.connect(self._apply)
        buttons.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addLayout(self.form)
        layout.addWidget(self.description)
        layout.addWidget(self.effect)
        layout.addStretch()
        layout.addWidget(buttons)

    # --- display -----------------------------------------------------------------------------
    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802
        super().showEvent(event)
        self._show_project_profile()

    def _handle_edit(self, *_: object) -> None:
        """Show the project's profile if an edit changed it; otherwise keep the entered limits."""
        if not self.isVisible():
            return
        if (
            get_limits(self._studio.records, self._studio.settings.thresholds)
            != self._current_limits
        ):
            self._show_project_profile()
        else:
            self._show_effect()

    def _show_project_profile(self) -> None:
        """Show the profile of the project."""
        self._current_limits = get_limits(self._studio.records, self._studio.settings.thresholds)
        stored_profiles = self._studio.settings.profiles.values()
        custom_profiles = [Thresholds(**limits) for limits in stored_profiles]
        self._profiles = PROFILES_BY_NAME | {
            profile.profile: profile for profile in (*custom_profiles, self._current_limits)
        }
        with QSignalBlocker(self.profile):
            self.profile.clear()
            for name in self._profiles:
                self.profile.addItem(_title(name), name)
            self.profile.setCurrentIndex(self.profile.findData(self._current_limits.profile))
        self._fill(self._current_limits)

    def _show_selected_profile(self) -> None:
        self._fill(self._profiles[self.profile.currentData()])

    def _fill(self, limits: Thresholds) -> None:
        self._base_limits = limits
        with QSignalBlocker(self.name):
            self.name.setText(_title(limits.profile))
        for name, criterion, _, _ in _LIMITS:
            with QSignalBlocker(self.boxes[name]):
                self.boxes[name].setValue(getattr(limits, name))
            self.form.setRowVisible(self.boxes[name], criterion in ("", limits.by))
        self.description.setText(tr(_DESCRIPTIONS[limits.by]))
        self._show_effect()

    def _handle_change(self, *_: object) -> None:
        standard_profile = PROFILES_BY_NAME.get(self._base_limits.profile)
        if standard_profile is not None and self.name.text() == _title(standard_profile.profile):
            with QSignalBlocker(self.name):
                self.name.setText(tr("custom limits"))
        self._show_effect()

    def limits(self) -> Thresholds:
        """Return the entered limits with the entered name."""
        values: dict[str, Any] = {name: box.value() for name, box in self.boxes.items()}
        limits = replace(self._base_limits, **values)
        if limits == self._base_limits and self.name.text() == _title(self._base_limits.profile):
            return self._base_limits
        return replace(limits, profile=self.name.text().strip())

    def _show_effect(self) -> None:
        """Show the numbers of verdicts with the present and the entered limits.

        Nothing is shown if the project has more than `_MAX_PREVIEW_FEATURES` features.
        """
        limits, records = self.limits(), self._studio.records
        is_unchanged = limits == self._current_limits
        set_enabled(self.apply_button, Finding("edit.no-change") if is_unchanged else None)
        ids = [id_ for id_, record in records.items() if isinstance(record, Feature)]
        if len(ids) > _MAX_PREVIEW_FEATURES:
            self.effect.clear()
            return
        current_counts = _describe_counts(self._studio.measured(ids))
        if is_unchanged:
            self.effect.setText(tr("Now: {counts}.", counts=current_counts))
            return
        other_records = {id_: record for id_, record in records.items() if id_ != PROFILE_ID}
        new_counts = _describe_counts(Measurements(limits).of(other_records, ids))
        self.effect.setText(
            tr("Now: {counts}. With these limits: {then}.", counts=current_counts, then=new_counts)
        )

    # --- edit --------------------------------------------------------------------------------
    def _apply(self) -> None:
        limits = self.limits()
        if not self._studio.attempt(edits.judge_by, limits):
            return
        if limits.profile not in PROFILES_BY_NAME:
            self._studio.settings.profiles[limits.profile] = asdict(limits)
            self._studio.keep_settings()


def _title(profile: str) -> str:
    titles = {"error": tr("by error"), "textbook": tr("textbook: shape and extent")}
    return titles.get(profile, profile)


def _describe_counts(measurements: Any) -> str:
    counts = Counter(m.verdict.quality for m in measurements.values() if m.verdict is not None)
    return tr(
        "{good} good, {doubtful} doubtful, {poor} poor",
        good=counts["good"],
        doubtful=counts["doubtful"],
        poor=counts["poor"],
    )
