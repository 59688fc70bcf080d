"""The planes that were measured on both models: the angle between them beside their errors."""

from __future__ import annotations

from PySide6.QtWidgets import QVBoxLayout, QWidget

from vomstudio.core.words import to_translate, tr
from vomstudio.geology.model_agreement import Agreement, OrientedPlane, compare_orientations
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.number_formatting import degrees
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.measured_planes import measured_planes
from vomstudio.ui.widgets.number_table import Column, NumberTable

_BY = {"name": to_translate("name"), "nearness": to_translate("nearness")}
_LEAST_HEIGHT = 130


class AgreementTable(QWidget):
    """Hidden where not both models are of the project and were interpreted."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._shown: tuple[str, str] | None = None
        self.agreement: Agreement | None = None
        self.said = Label()
        self.said.setObjectName("agreement")
        self.said.setWordWrap(True)
        self.table = NumberTable(
            (
                Column(tr("Plane"), tip=tr("On the model."), number=False),
                Column(tr("Other"), tip=tr("On the benchmark."), number=False),
                Column(tr("By"), tip=tr("Matched by name, or by nearness."), number=False),
                Column(tr("Angle"), degrees, tr("Between the two planes.")),
                Column(
                    tr("95 %"),
                    degrees,
                    tr("Stated errors of both together, with their registrations where known."),
                ),
            ),
            3,
            descending=True,
        )
        self.table.setMinimumHeight(_LEAST_HEIGHT)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.said)
        column.addWidget(self.table)
        self.hide()

    def forget(self) -> None:
        """Features or models have changed."""
        self._shown = None

    def show_models(self, model_id: str, other_id: str) -> None:
        """Ids of the models; an empty one is none of the project. The same again is not worked out
        anew unless `forget` was called."""
        if self._shown == (model_id, other_id):
            return
        self._shown = (model_id, other_id)
        planes = [self._planes(id_) if id_ else [] for id_ in (model_id, other_id)]
        if not (planes[0] and planes[1]):
            self.agreement = None
            self.hide()
            return
        found = self.agreement = compare_orientations(planes[0], planes[1])
        self.said.setText(_summary_text(found))
        self.table.fill(
            [
                (
                    (one.first, one.second, tr(_BY[one.by]), one.angle_deg, one.error95_deg),
                    tr("The planes differ by more than their errors explain.")
                    if one.agree is False
                    else "",
                )
                for one in found.matched
            ]
        )
        self.table.setVisible(bool(found.matched))
        self.show()

    def _planes(self, model_id: str) -> list[OrientedPlane]:
        features = [
            f for f in self._studio.session.features() if getattr(f, "model_id", "") == model_id
        ]
        return measured_planes(self._studio, features)


def _summary_text(compare_orientations: Agreement) -> str:
    if not compare_orientations.n:
        return tr("No plane was measured on both: none has the same name or lies near another one.")
    said = tr(
        "Planes measured on both: {n} ({named} matched by name, {near} by nearness). Angle: median "
        "{median}, RMS {rms}.",
        n=compare_orientations.n,
        named=compare_orientations.by_name,
        near=compare_orientations.by_nearness,
        median=degrees(compare_orientations.median_angle_deg),
        rms=degrees(compare_orientations.rms_angle_deg),
    )
    if compare_orientations.agree_share is None:
        return said
    return f"{said} " + tr(
        "{share:.0f} % agree within their stated 95 % errors.",
        share=100.0 * compare_orientations.agree_share,
    )
