"""The facets of a model as slopes: the question, worked out in a thread, its command, and what is
shown: a table, and the outcrop in the colours of a share."""

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
from vomstudio.ui.base.controls import ComboBox, allow
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
"""Name, as the head of a column, and with what is counted."""
_LEAST_HEIGHT = 110


@dataclass(frozen=True, eq=False)
class FacetsQuestion:
    """features : those with a plane; measured : of each, by id; rows : of the facets among those
    that were found; data, to_world : of their model"""

    records: Mapping[str, Record]
    features: Sequence[Feature]
    measured: Mapping[str, Measurement]
    found: Proposals
    rows: Sequence[int]
    data: Mesh | PointCloud
    to_world: Matrix
    options: SlopeOptions


@dataclass(frozen=True, eq=False)
class FacetsAnswer:
    question: FacetsQuestion
    faces: Sequence[FacetFace]
    found: FacetSlopes


def answer_facets(question: FacetsQuestion) -> FacetsAnswer:
    """In a thread: what `vomstudio slope --facets` says of these planes and facets."""
    from vomstudio.geology.fractures.facet_slopes import FacetFace, facet_slopes
    from vomstudio.products.surface.slope_facets import find_overhangs
    from vomstudio.project.exports.feature_table import feature_table

    q = question
    # The height over the level, by a model's own coordinates; its scale counts for nothing.
    over = find_overhangs(q.data, q.found.label.astype(int), q.to_world[2][:3])
    faces = []
    for row in q.rows:
        measured = q.found.measured[row]
        if measured.plane is not None:
            area = measured.area_m2 or q.found.exposed_area_of(row)
            faces.append(FacetFace(str(row), measured.plane, area, over.get(str(row))))
    table = feature_table(q.records, q.features, q.measured)
    found = facet_slopes(table, faces, q.options)
    return FacetsAnswer(q, faces, found)


def facets_file(planes: Path) -> Path:
    """Of the facets, beside the table of planes."""
    return planes.with_name(f"{planes.stem}_facets.csv")


def facets_words(result: FacetsAnswer, planes: Path) -> CommandArguments:
    """The command that says the same of these tables."""
    q = result.question
    return [
        "slope",
        planes,
        ("--facets", facets_file(planes)),
        *option_words(q.options),
        ("-o", planes.with_name(f"{planes.stem}_result.csv")),
    ]


class FacetSlopesView(QWidget):
    """painted : another mode is to be seen on the outcrop; unpainted : none is; pointed_at : the
    place of the facet in the chosen row, among those that were found"""

    painted = Signal(str)
    pointed_at = Signal(int)
    unpainted = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.mode = ComboBox()
        self.mode.setObjectName("slope_facets_mode")
        self.mode.setToolTip(tr("What the outcrop is painted with."))
        for name, _, title in _MODES:
            self.mode.addItem(tr(title), name)
        self.mode.keep_narrow()
        self.mode.activated.connect(lambda _: self.painted.emit(self.chosen))
        self.off = QPushButton(theme.icon("image-outline"), "")
        self.off.setToolTip(tr("The outcrop as it was before."))
        self.off.clicked.connect(lambda _=False: self.unpainted.emit())
        self.table = NumberTable(
            (
                Column("#", lambda v: f"{v}", tr("1 is the largest facet.")),
                Column(tr("Face"), str, tr("Attitude of the facet as a slope."), number=False),
                *(
                    Column(tr(head), lambda v: f"{100.0 * v:.1f} %", tr(title))
                    for _, head, title in _MODES
                ),
                Column(tr("m²"), lambda v: f"{v:.2g}", tr("Area of the facet.")),
            ),
            2,
            descending=True,
        )
        self.table.setObjectName("slope_facets")
        self.table.setAccessibleName(tr("Facets as slopes"))
        self.table.setMinimumHeight(_LEAST_HEIGHT)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._row_chosen())
        row = QHBoxLayout()
        row.addWidget(self.mode, 1)
        row.addWidget(self.off)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addLayout(row)
        column.addWidget(self.table, 1)

    @property
    def chosen(self) -> str:
        """The mode that is painted."""
        return str(self.mode.currentData())

    def _row_chosen(self) -> None:
        for index in self.table.selectionModel().selectedRows():
            self.pointed_at.emit(int(self.table.numbers.rows[index.row()][0][0]) - 1)

    def show_answer(self, result: FacetsAnswer | None, notation: str, look: str) -> None:
        """look : what the outcrop shows where it is not painted"""
        self.off.setText(look)
        rows = []
        for each in () if result is None else result.found.facets:
            plane = Plane(each.face.dip_direction_deg, each.face.dip_deg)
            said = format_plane(plane, notation, 0, bare=True)
            shares = [getattr(each, name).share for name, _, _ in _MODES]
            why = tr("It overhangs, and is taken as a vertical face.") if each.overhangs else ""
            rows.append(((int(each.id) + 1, said, *shares, each.area_m2), why))
        self.table.fill(rows)
        for widget in (self.mode, self.off):
            allow(widget, None if rows else Finding("action.no-result"))


def shares_of(result: FacetsAnswer, mode: str) -> dict[int, float]:
    """By the place of the facet among those that were found."""
    shares = [getattr(each, mode).share for each in result.found.facets]
    ids = [int(each.id) for each in result.found.facets]
    return {i: share for i, share in zip(ids, shares, strict=True) if share is not None}


def show_facet(studio: Studio, found: Proposals, row: int) -> None:
    """It stands out on the outcrop, where its model is open."""
    model, opened = studio.records.get(found.model_id), studio.models.get(found.model_id)
    if isinstance(model, Model) and opened is not None:
        area = patch_area(found.patches[row], model, opened.surface)
        studio.preview.emit(Preview(np.zeros((0, 3)), color=(1.0, 1.0, 1.0), area=area))
