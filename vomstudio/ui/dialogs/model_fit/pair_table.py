"""Table of the point pairs with their residuals, and summaries of the fit."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtWidgets import QHeaderView, QTableWidget, QTableWidgetItem

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.registrations import Registration
from vomstudio.registration.results import ModelPlacement
from vomstudio.studio.jobs.registration_tasks import FittedModel, HomologousPoint
from vomstudio.ui.base import theme


class PairTable(QTableWidget):
    """Table with one row for each pair."""

    def __init__(self) -> None:
        super().__init__(0, 3)
        self.setObjectName("point_pairs")
        self.setHorizontalHeaderLabels([tr("Point"), tr("Resid. (m)"), "dx, dy, dz (m)"])
        self.setSelectionBehavior(QTableWidget.SelectionBehavior.SelectRows)
        self.setSelectionMode(QTableWidget.SelectionMode.SingleSelection)
        self.setEditTriggers(QTableWidget.EditTrigger.NoEditTriggers)
        self.verticalHeader().hide()
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(2, QHeaderView.ResizeMode.Stretch)
        self.setMinimumSize(300, 120)

    def selected_row(self) -> int | None:
        """Return the selected row, or None if no row is selected."""
        rows = self.selectionModel().selectedRows()
        return rows[0].row() if rows else None

    def show_pairs(
        self, pairs: Sequence[HomologousPoint], placement: ModelPlacement | None
    ) -> None:
        residuals = {} if placement is None else {p.label: p for p in placement.control}
        blunders = set() if placement is None else {b.label for b in placement.blunders}
        self.setRowCount(len(pairs))
        for row, pair in enumerate(pairs):
            residual = residuals.get(pair.label)
            texts = [pair.label, "", ""]
            if residual is not None:
                texts[1:] = [
                    f"{residual.error_m:.3f}",
                    f"{residual.dx:.3f}, {residual.dy:.3f}, {residual.dz:.3f}",
                ]
            for column, text in enumerate(texts):
                item = QTableWidgetItem(text)
                if not column and pair.label in blunders:
                    item.setIcon(theme.icon("alert-outline"))
                self.setItem(row, column, item)


def placement_summary(placement: ModelPlacement) -> str:
    """Describe the placement by the points alone."""
    from vomstudio.registration.warnings import worst_axis_findings

    rms = placement.rms_control_m or 0.0
    sentences = [
        tr("Points only: {rms:.3f} m (RMS).", rms=rms),
        *worst_axis_findings(placement),
    ]
    return "\n".join([" ".join(map(str, sentences)), *map(str, reversed(placement.warnings))])


def fit_summary(fit: FittedModel, record: Registration | None) -> str:
    """Describe the fit by points and surfaces.

    Parameters
    ----------
    fit : FittedModel
    record : Registration or None
        Resulting registration, which includes the error of the reference if it is known.
    """
    from vomstudio.registration.rotation_uncertainty import worst_turn95_deg
    from vomstudio.registration.warnings import reference_fit_finding, worst_axis_findings

    fit_finding = reference_fit_finding(fit.places, fit.overlap, fit.rms_m, fit.blocks, fit.block_m)
    sentences = [
        fit_finding,
        *worst_axis_findings(fit.placed),
        Finding("registration.without-reference"),
    ]
    if record is not None and record.covariance != fit.placed.covariance:
        worst_deg = worst_turn95_deg(record.rotation_covariance())
        sentences[-1] = Finding("registration.with-reference", rotation95_deg=worst_deg)
    return "\n".join([" ".join(map(str, sentences)), *map(str, fit.placed.warnings)])
