"""The dock of slopes: which planes and intersections let a face fail."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtWidgets import (
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QToolButton,
    QWidget,
)

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.notation import format_plane, parse_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import SlopeFace
from vomstudio.project.measurement import Measurement
from vomstudio.project.records import Model, Typed
from vomstudio.studio.display import usual_look
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, allow
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.slopes.analysis import (
    SlopeAnswer,
    SlopeQuestion,
    answer,
    words_of,
    write_figure,
)
from vomstudio.ui.panels.slopes.facets import (
    FacetsAnswer,
    FacetSlopesView,
    FacetsQuestion,
    answer_facets,
    facets_file,
    facets_words,
    shares_of,
    show_facet,
)
from vomstudio.ui.panels.slopes.results import SlopeResults
from vomstudio.ui.panels.tools.common import narrow_column
from vomstudio.ui.widgets.copied_command import CommandArguments, CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table
from vomstudio.ui.widgets.figure_file import ask_for_figure_file
from vomstudio.ui.widgets.group_box import SELECTED, GroupBox
from vomstudio.ui.widgets.options_form import OptionFields

_FRICTION_DEG = 30.0


class SlopesPanel(AnalysisPanel[SlopeQuestion | FacetsQuestion, SlopeAnswer | FacetsAnswer]):
    """Panel of the kinematic analysis of one face, or of each proposed facet."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(studio, "slope", "conventions.md#slopes", tr("Computing…"))
        self._writing = False
        self._notation = ""
        self._chosen_here: tuple[str, ...] | None = None
        self._features: list[Typed] = []
        self.of = GroupBox(studio, tr("All planes"))
        self.of.setAccessibleName(tr("Planes"))
        self.of.activated.connect(self._group_chosen)
        self.at = ComboBox()
        self.at.setObjectName("slope_at")
        self.at.addItem(tr("One face"), "face")
        self.at.addItem(tr("Each facet"), "facets")
        self.at.setToolTip(
            tr("The slope is one face, or each facet that was found on the model by itself.")
        )
        self.at.activated.connect(self._at_chosen)
        self.face = QLineEdit()
        self.face.setObjectName("slope_face")
        self.face.setToolTip(tr("Attitude of the slope, in the notation of the project."))
        self.face.textChanged.connect(self._soon)
        self.take = QPushButton(tr("Take selected"))
        self.take.setToolTip(tr("The face dips as the selected plane does."))
        self.take.clicked.connect(self._take_selected)
        self.angles = OptionFields(SlopeOptions, "slope", SlopeOptions(_FRICTION_DEG))
        self.angles.changed.connect(self._soon)
        self.limits = ComboBox()
        self.limits.setObjectName("slope_limits")
        self.limits.addItem(tr("small circles"), "curved")
        self.limits.addItem(tr("dip directions"), "straight")
        self.limits.setToolTip(
            tr(
                "The lateral limits of planes: small circles about the strike of the face, or dip "
                "directions."
            )
        )
        self.limits.keep_narrow()
        self.limits.activated.connect(self._soon)
        self.results = SlopeResults()
        self.results.chosen.connect(self._select)
        self.facets = FacetSlopesView()
        self.facets.setVisible(False)
        self.facets.painted.connect(lambda _: self._paint())
        self.facets.unpainted.connect(studio.facets.unpaint)
        self.facets.pointed_at.connect(self._point_at)
        self.copy = CopyCommandButton(
            self._copy_command, tr("keep the planes as a table, and copy the command")
        )
        self.figure = _button("image-outline", tr("Figure…"), self._ask_for_figure)
        self._arrange()
        studio.project_opened.connect(self._opened)
        studio.settings_changed.connect(self._notation_changed)
        studio.edited.connect(self._edited)
        studio.selection_changed.connect(lambda _: self._selected())
        studio.facets.changed.connect(self._facets_changed)
        self._notation_changed()

    def _arrange(self) -> None:
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(4)
        form.addRow(tr("Planes"), _row(self.of, self.copy, self.figure, wide=self.of))
        form.addRow(tr("Slope"), _row(self.at, self.face, self.take, wide=self.face))
        fields, labels = self.angles.fields, self.angles.labels
        angles = _row(
            fields["friction_deg"],
            labels["lateral_deg"],
            fields["lateral_deg"],
            self.limits,
            wide=self.limits,
        )
        form.addRow(labels["friction_deg"], angles)
        column = narrow_column(self)
        column.addLayout(form)
        column.addWidget(self.message)
        column.addWidget(self.results, 1)
        column.addWidget(self.facets, 1)

    # --- when to look again ------------------------------------------------------------------
    def _opened(self) -> None:
        """Another project."""
        self._chosen_here = None
        self.face.clear()
        self._soon()

    def _notation_changed(self) -> None:
        """What was typed stays the plane that it was."""
        before, notation = self._notation, self._studio.settings.notation
        self._notation = notation
        example = format_plane(Plane(135.0, 70.0), notation)
        self.face.setPlaceholderText(tr("such as {example}", example=example))
        if before and before != notation:
            with suppress(VomError):
                plane = parse_plane(self.face.text(), before)
                whole = (plane.dip_direction_deg % 1.0, plane.dip_deg % 1.0) == (0.0, 0.0)
                self.face.setText(format_plane(plane, notation, 0 if whole else 2))
        self._soon()

    def _group_chosen(self, *_: object) -> None:
        self._chosen_here = None
        self._soon()

    def _selected(self) -> None:
        if self.visibleRegion().isEmpty():
            self._stale = True
            return
        self._refresh_take()
        ids = self._studio.selection.ids
        self.results.mark(ids)
        # What was clicked here is still one of those that were looked at.
        if ids != self._chosen_here and self.of.choice() == SELECTED:
            self._chosen_here = None
            self._soon()

    # --- the question ------------------------------------------------------------------------
    def _list(self) -> None:
        self.of.list_groups()
        self._refresh_take()

    def _answer(self, question: SlopeQuestion | FacetsQuestion) -> SlopeAnswer | FacetsAnswer:
        if isinstance(question, FacetsQuestion):
            return answer_facets(question)
        return answer(question)

    @property
    def facets_result(self) -> FacetsAnswer | None:
        """The result by facet, or None if another result is shown."""
        return self.result if isinstance(self.result, FacetsAnswer) else None

    @property
    def face_result(self) -> SlopeAnswer | None:
        """The result of one face, or None if another result is shown."""
        return self.result if isinstance(self.result, SlopeAnswer) else None

    @property
    def _at_facets(self) -> bool:
        return bool(self.at.currentData() == "facets")

    def _planes(self) -> tuple[list[Typed], dict[str, Measurement]]:
        """Return the planes of the choice with their measurements.

        Raises InputError if the choice has none.
        """
        studio = self._studio
        if self._chosen_here is None:
            self._features = self.of.features()
        features = [f for f in self._features if f.id in studio.records]
        measured = studio.measured(f.id for f in features)
        features = [f for f in features if measured[f.id].plane is not None]
        if not features:
            is_selection = self.of.choice() == SELECTED
            raise InputError(Finding("selection.unsuitable" if is_selection else "planes.none"))
        return features, dict(measured)

    def _question(self) -> SlopeQuestion | FacetsQuestion:
        if self._at_facets:
            return self._facets_question()
        planes = self._planes()
        text = self.face.text().strip()
        if not text:
            raise InputError(Finding("slope.no-face"))
        face = SlopeFace(parse_plane(text, self._notation), self._options())
        return SlopeQuestion(dict(self._studio.records), *planes, face)

    def _options(self) -> SlopeOptions:
        return replace(self.angles.options(), limits=self.limits.currentData())

    def _facets_question(self) -> FacetsQuestion:
        studio, proposals = self._studio, self._studio.facets.proposals
        planes = self._planes()
        opened = None if proposals is None else studio.models.get(proposals.model_id)
        model = None if proposals is None else studio.records.get(proposals.model_id)
        if proposals is None or opened is None or not isinstance(model, Model):
            raise InputError(Finding("action.no-proposals"))
        rows = sorted(studio.facets.open | studio.facets.accepted)
        return FacetsQuestion(
            dict(studio.records),
            *planes,
            proposals,
            rows,
            opened.data,
            model.to_world,
            self._options(),
        )

    def _at_chosen(self, *_: object) -> None:
        if not self._at_facets:
            self._studio.facets.unpaint()
        allow(self.face, Finding("action.slope-is-facet") if self._at_facets else None)
        self._refresh_take()
        self._soon()

    def _facets_changed(self) -> None:
        if self._at_facets:
            self._soon()

    def _point_at(self, row: int) -> None:
        """The facet of the chosen row stands out on the outcrop."""
        if self.facets_result is not None:
            show_facet(self._studio, self.facets_result.question.found, row)

    def _paint(self) -> None:
        """The outcrop by the chosen mode."""
        if self.facets_result is not None:
            mode = self.facets.chosen
            self._studio.facets.paint_shares(mode, shares_of(self.facets_result, mode))

    # --- the answer --------------------------------------------------------------------------
    def _result_text(self, result: SlopeAnswer | FacetsAnswer) -> str:
        counted = _counted(result) if isinstance(result, SlopeAnswer) else _counted_facets(result)
        return " ".join([counted, *map(str, result.found.warnings)])

    def _draw(self) -> None:
        self.results.setVisible(not self._at_facets)
        self.facets.setVisible(self._at_facets)
        proposals = self._studio.facets.proposals
        opened = None if proposals is None else self._studio.models.get(proposals.model_id)
        look = usual_look([] if opened is None else [opened.data])
        self.facets.show_answer(self.facets_result, self._studio.settings.notation, look)
        self.results.show_answer(self.face_result, self._studio.settings.notation)
        self.results.mark(self._studio.selection.ids)
        self._paint()

    def _select(self, ids: list[str]) -> None:
        # One may be deleted that is still listed.
        self._chosen_here = tuple(id_ for id_ in ids if id_ in self._studio.records)
        self._studio.selection.set(self._chosen_here)

    # --- the face ----------------------------------------------------------------------------
    def _selected_plane(self) -> Plane | None:
        current = self._studio.selection.current
        record = None if current is None else self._studio.records.get(current)
        if current is None or not isinstance(record, Typed):
            return None
        return self._studio.measured([current])[current].plane

    def _refresh_take(self) -> None:
        why = None
        if self._at_facets:
            why = Finding("action.slope-is-facet")
        elif self._selected_plane() is None:
            why = Finding("selection.no-plane")
        allow(self.take, why)

    def _take_selected(self) -> None:
        plane = self._selected_plane()
        if plane is not None:
            self.face.setText(format_plane(plane, self._notation, 1))

    # --- what is taken away ------------------------------------------------------------------
    def _refresh(self) -> None:
        why = None
        if self._requests.is_waiting:
            why = Finding("action.busy")
        elif self.result is None:
            why = Finding("action.no-proposals" if self._at_facets else "action.no-result")
        elif self._writing:
            why = Finding("action.busy")
        self.copy.allow(why)
        if why is None and self._at_facets:
            why = Finding("action.nets-of-one-face")
        self.figure.setEnabled(why is None)
        more = tr("the nets of the four modes as SVG, PDF or PNG")
        self.figure.setToolTip(
            tr("{button}: {more}", button=self.figure.text().rstrip("…"), more=why or more)
        )

    def _copy_command(self) -> None:
        """Ask for the table of the planes, and put the command on the clipboard."""
        if self.facets_result is not None:
            self._copy_facets(self.facets_result)
            return
        if self.face_result is None:
            return
        question = self.face_result.question
        copy_with_table(
            self,
            self._studio,
            "slope-planes.csv",
            [f.id for f in question.features],
            partial(words_of, question.face),
        )

    def _copy_facets(self, result: FacetsAnswer) -> None:
        """The table of the facets comes beside that of the planes."""
        from vomstudio.products.surface.slope_facets import write_faces

        def words(path: Path) -> CommandArguments:
            write_faces(facets_file(path), result.faces)
            return facets_words(result, path)

        ids = [f.id for f in result.question.features]
        copy_with_table(self, self._studio, "slope-planes.csv", ids, words)

    def _ask_for_figure(self) -> None:
        path = ask_for_figure_file(self, self._studio, tr("Figure of the slope"), "slope")
        if path is not None:
            self.write_figure(path)

    def write_figure(self, path: Path) -> None:
        """The four nets to a file, in a thread."""
        if self.face_result is None:
            return
        self._writing = True
        self._refresh()
        studio, written = self._studio, Finding("export.written", file=path)
        self._background.run(
            partial(write_figure, self.face_result, path),
            lambda _: self._written(partial(studio.info, written)),
            lambda error: self._written(partial(studio.fail, error)),
        )

    def _written(self, report: Callable[[], None]) -> None:
        self._writing = False
        self._refresh()
        report()


def _counted(result: SlopeAnswer) -> str:
    """Return the number of planes, and why probabilities are missing."""
    found = result.found
    if not found.with_error:
        return tr("{n:,} planes. No error of theirs is known, so no probability is.", n=found.n)
    return tr_n("{count:,} plane.", "{count:,} planes.", found.n)


def _counted_facets(result: FacetsAnswer) -> str:
    """How many, and how much of their area has a share of what is painted."""
    return tr(
        "{facets} facets, {planes:,} planes. The outcrop shows the share that is critical at each.",
        facets=len(result.found.facets),
        planes=result.found.n,
    )


def _row(*parts: QWidget, wide: QWidget) -> QHBoxLayout:
    row = QHBoxLayout()
    for part in parts:
        row.addWidget(part, 1 if part is wide else 0)
    return row


def _button(icon: str, text: str, clicked: Callable[[], None]) -> QToolButton:
    """Its tooltip says what it does."""
    button = QToolButton()
    button.setIcon(theme.icon(icon))
    button.setText(text)
    button.setAccessibleName(text)
    button.clicked.connect(clicked)
    return button
