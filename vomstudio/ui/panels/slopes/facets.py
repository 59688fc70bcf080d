"""Kinematic analysis of each facet of a model, with its command line and table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.options import option_words
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.mesh import Mesh
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Feature, Model, Record
from vomstudio.studio.tools.interaction_types import Preview
from vomstudio.studio.tools.painted_area import patch_area
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, set_enabled
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.copied_command import CommandArguments
from vomstudio.ui.widgets.number_table import Column, NumberTable

if TYPE_CHECKING:
    from vomstudio.geology.fractures.facet_slopes import FacetFace, FacetSlopes
    from vomstudio.studio.surfaces.facet_proposals import Proposals

_MODES = (
    ("planar", to_translate("Planar"), to_translate("Planar sliding, % of planes")),
    ("wedge", to_translate("Wedge"), to_translate("Wedge sliding, % of intersections")),
    ("flexural_toppling", to_translate("Flexural"), to_translate("Flexural toppling, % of planes")),
    (
        "direct_toppling",
        to_translate("Direct"),
        to_translate("Direct toppling, % of intersections"),
    ),
)
"""Name, column title and description of each failure mode, with the counted quantity."""
_MIN_TABLE_HEIGHT_PX = 110


@dataclass(frozen=True, eq=False)
class FacetSlopesRequest:
    """Input of the analysis by facet.

    Attributes
    ----------
    features : sequence of Feature
        Features that have a plane.
    measured : mapping of str to Measurement
        Measurements of the features by id.
    rows : sequence of int
        Indices of the facets in `proposals`.
    data : Mesh or PointCloud
        Model that contains the facets.
    to_world : Matrix
        Transform of the model to the World frame.
    """

    records: Mapping[str, Record]
    features: Sequence[Feature]
    measured: Mapping[str, Measurement]
    proposals: Proposals
    rows: Sequence[int]
    data: Mesh | PointCloud
    to_world: Matrix
    options: SlopeOptions


@dataclass(frozen=True, eq=False)
class FacetSlopesResult:
    request: FacetSlopesRequest
    faces: Sequence[FacetFace]
    analysis: FacetSlopes


def analyze_facets(request: FacetSlopesRequest) -> FacetSlopesResult:
    """Analyse facets as in the command `slope --facets`. Runs in a worker thread."""
    from vomstudio.geology.fractures.facet_slopes import FacetFace, facet_slopes
    from vomstudio.products.surface.slope_facets import find_overhangs
    from vomstudio.project.exports.feature_table import feature_table

    q = request
    # Only the direction of the World z axis in model coordinates matters here, not the scale.
    overhangs = find_overhangs(q.data, q.proposals.label.astype(int), q.to_world[2][:3])
    faces = []
    for row in q.rows:
        measurement = q.proposals.measured[row]
        if measurement.plane is not None:
            area = measurement.area_m2 or q.proposals.get_exposed_area(row)
            faces.append(FacetFace(str(row), measurement.plane, area, overhangs.get(str(row))))
    table = feature_table(q.records, q.features, q.measured)
    analysis = facet_slopes(table, faces, q.options)
    return FacetSlopesResult(q, faces, analysis)


def facets_file(planes: Path) -> Path:
    """Return the path of the facet table, which is next to the table of planes."""
    return planes.with_name(f"{planes.stem}_facets.csv")


def facets_command(result: FacetSlopesResult, planes: Path) -> CommandArguments:
    """Return the command that reproduces the result from both tables."""
    q = result.request
    return [
        "slope",
        planes,
        ("--facets", facets_file(planes)),
        *option_words(q.options),
        ("-o", planes.with_name(f"{planes.stem}_result.csv")),
    ]


class FacetSlopesView(QWidget):
    """Table of the facets as slopes, and the failure mode by which the outcrop is coloured.

    The signal `painted` is emitted with the selected mode, `reset_requested` requests the previous
    colours, and `facet_selected` is emitted with the index of the facet in the selected row.
    """

    painted = Signal(str)
    facet_selected = Signal(int)
    reset_requested = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.mode = ComboBox()
        self.mode.setObjectName("slope_facets_mode")
        self.mode.setToolTip(tr("Choose the colours of the outcrop."))
        for name, _, title in _MODES:
            self.mode.addItem(tr(title), name)
        self.mode.keep_narrow()
        self.mode.activated.connect(lambda _: self.painted.emit(self.current_mode))
        self.reset_button = QPushButton(theme.icon("image-outline"), "")
        self.reset_button.setToolTip(tr("Restore the previous colours of the outcrop."))
        self.reset_button.clicked.connect(lambda _=False: self.reset_requested.emit())
        self.table = NumberTable(
            (
                Column("#", lambda v: f"{v}", tr("Number; 1 is the largest facet.")),
                Column(tr("Face"), str, tr("Attitude of the facet as a slope."), number=False),
                *(
                    Column(tr(column_title), lambda v: f"{100.0 * v:.1f} %", tr(title))
                    for _, column_title, title in _MODES
                ),
                Column(tr("m²"), lambda v: f"{v:.2g}", tr("Area of the facet.")),
            ),
            2,
            is_descending=True,
        )
        self.table.setObjectName("slope_facets")
        self.table.setAccessibleName(tr("Facets as slopes"))
        self.table.setMinimumHeight(_MIN_TABLE_HEIGHT_PX)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._emit_selected_facet())
        row = QHBoxLayout()
        row.addWidget(self.mode, 1)
        row.addWidget(self.reset_button)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addLayout(row)
        column.addWidget(self.table, 1)

    @property
    def current_mode(self) -> str:
        """Name of the failure mode by which the outcrop is coloured."""
        return str(self.mode.currentData())

    def _emit_selected_facet(self) -> None:
        for index in self.table.selectionModel().selectedRows():
            self.facet_selected.emit(int(self.table.numbers.rows[index.row()][0][0]) - 1)

    def show_result(
        self, result: FacetSlopesResult | None, notation: str, colors_name: str
    ) -> None:
        """Fill the table; `colors_name` is the text of the button that restores the colours."""
        self.reset_button.setText(colors_name)
        rows = []
        for facet in () if result is None else result.analysis.facets:
            plane = Plane(facet.face.dip_direction_deg, facet.face.dip_deg)
            attitude = format_plane(plane, notation, 0, omit_hand_rule=True)
            shares = [getattr(facet, name).share for name, _, _ in _MODES]
            note = (
                tr("The facet overhangs and is treated as a vertical face.")
                if facet.overhangs
                else ""
            )
            rows.append(((int(facet.id) + 1, attitude, *shares, facet.area_m2), note))
        self.table.fill(rows)
        for widget in (self.mode, self.reset_button):
            set_enabled(widget, None if rows else Finding("action.no-result"))


def facet_shares(result: FacetSlopesResult, mode: str) -> dict[int, float]:
    """Return the known critical shares for a failure mode, by facet index."""
    shares = [getattr(facet, mode).share for facet in result.analysis.facets]
    ids = [int(facet.id) for facet in result.analysis.facets]
    return {i: share for i, share in zip(ids, shares, strict=True) if share is not None}


def show_facet(studio: Studio, proposals: Proposals, row: int) -> None:
    """Highlight a facet on the outcrop if its model is open."""
    model, loaded_model = (
        studio.records.get(proposals.model_id),
        studio.models.get(proposals.model_id),
    )
    if isinstance(model, Model) and loaded_model is not None:
        area = patch_area(proposals.patches[row], model, loaded_model.surface)
        studio.preview.emit(Preview(np.zeros((0, 3)), color=(1.0, 1.0, 1.0), area=area))
