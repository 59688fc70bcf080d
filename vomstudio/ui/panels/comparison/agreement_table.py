"""Table of the planes measured on both models, with angles and errors."""

from __future__ import annotations

from PySide6.QtWidgets import QVBoxLayout, QWidget

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.model_agreement import Agreement, OrientedPlane, compare_orientations
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.number_formatting import format_error_deg
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.measured_planes import measured_planes
from vomstudio.ui.widgets.number_table import Column, NumberTable

_MATCH_TITLES = {"name": to_translate("name"), "nearness": to_translate("distance")}
_MIN_TABLE_HEIGHT_PX = 130


class AgreementTable(QWidget):
    """Table of the matching planes of two models, hidden unless both models have planes."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._model_ids: tuple[str, str] | None = None
        self.agreement: Agreement | None = None
        self.summary = Label()
        self.summary.setObjectName("agreement")
        self.summary.setWordWrap(True)
        self.table = NumberTable(
            (
                Column(tr("Plane"), tip=tr("On the model."), number=False),
                Column(tr("Other"), tip=tr("On the benchmark."), number=False),
                Column(tr("By"), tip=tr("Matched by name or by distance."), number=False),
                Column(tr("Angle"), format_error_deg, tr("Between the two planes.")),
                Column(
                    tr("95 %"),
                    format_error_deg,
                    tr("Combined stated errors, including registrations if known."),
                ),
            ),
            3,
            is_descending=True,
        )
        self.table.setMinimumHeight(_MIN_TABLE_HEIGHT_PX)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.summary)
        column.addWidget(self.table)
        self.hide()

    def invalidate(self) -> None:
        """Mark the displayed result as outdated after features or models have changed."""
        self._model_ids = None

    def show_models(self, model_id: str, other_id: str) -> None:
        """Show the agreement between the planes of two models, given by id.

        An empty id represents a model outside the project. The same pair is recomputed only after a
        call to `invalidate`.
        """
        if self._model_ids == (model_id, other_id):
            return
        self._model_ids = (model_id, other_id)
        planes = [self._planes(id_) if id_ else [] for id_ in (model_id, other_id)]
        if not (planes[0] and planes[1]):
            self.agreement = None
            self.hide()
            return
        agreement = self.agreement = compare_orientations(planes[0], planes[1])
        self.summary.setText(_summary_text(agreement))
        self.table.fill(
            [
                (
                    (
                        match.first,
                        match.second,
                        tr(_MATCH_TITLES[match.by]),
                        match.angle_deg,
                        match.error95_deg,
                    ),
                    tr("The planes differ by more than their errors explain.")
                    if match.agree is False
                    else "",
                )
                for match in agreement.matched
            ]
        )
        self.table.setVisible(bool(agreement.matched))
        self.show()

    def _planes(self, model_id: str) -> list[OrientedPlane]:
        features = [
            f for f in self._studio.session.features() if getattr(f, "model_id", "") == model_id
        ]
        return measured_planes(self._studio, features)


def _summary_text(agreement: Agreement) -> str:
    lines = [finding.message for finding in agreement.findings]
    if agreement.n:
        angles = tr(
            "Angle: median {median}, RMS {rms}.",
            median=format_error_deg(agreement.median_angle_deg),
            rms=format_error_deg(agreement.rms_angle_deg),
        )
        lines.insert(1, angles)
    return " ".join(lines)
