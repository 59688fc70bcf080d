"""The dock of fractures: traces on their face counted along a line, in a circle or in a window."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path

import numpy as np
from PySide6.QtGui import QImage
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QTabWidget,
    QTextBrowser,
    QWidget,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.fractures.fracture_options import FractureOptions
from vomstudio.geometry.units import Axes
from vomstudio.io.gis.crs import world_crs
from vomstudio.project.edit import Edit
from vomstudio.project.figures import Subject
from vomstudio.project.kinds import kind_of
from vomstudio.project.records import (
    FaceGrid,
    FeatureType,
    Model,
    Picked,
    Record,
    Typed,
    get_feature,
)
from vomstudio.project.registration_errors import model_of
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import current_line
from vomstudio.ui.base.controls import allow, button_row, icon_button, narrow_form
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.fractures.analysis import (
    CIRCLE,
    EVERYTHING,
    GRID,
    SCANLINE,
    WINDOW,
    FractureAnswer,
    FractureQuestion,
    MappedTrace,
    answer,
    draw_figure,
    mark_of,
    numbers_of,
    wanted_of,
    write_figure,
)
from vomstudio.ui.panels.fractures.domain_box import CountedInBox
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    CopyCommandButton,
    copy_with_file,
    format_numbers,
)
from vomstudio.ui.widgets.drawing_view import DrawingView
from vomstudio.ui.widgets.figure_file import ask_for_figure_file
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.group_box import SELECTED, GroupBox
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.plane_field import PlaneField, ViewDirection
from vomstudio.ui.widgets.scaled_picture import ScaledPicture

_NO_COLOR = "#404040"


class FracturesPanel(AnalysisPanel[FractureQuestion, FractureAnswer]):
    """Panel that counts traces along a line, in a circle, in a window or in cells."""

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__(studio, "fracture", "fractures.md", tr("Counting…"))
        self._drawn: FractureAnswer | None = None
        self.of = GroupBox(studio, tr("All traces"))
        self.of.setAccessibleName(tr("Traces"))
        self.plane = PlaneField(studio, "fracture_plane", tr("the plane of best fit"), view)
        self.counted_in = CountedInBox(studio)
        self.place = QLineEdit()
        self.place.setObjectName("fracture_place")
        self.take = icon_button(
            "cursor-default-click-outline", tr("Take the selected line or area")
        )
        self.take.setToolTip(tr("The selected line or area, as it lies on the face."))
        self.options = OptionFields(FractureOptions, "fracture")
        follow_axes(studio, lambda axes: self.options.show_unit(length_unit(axes)))
        self.figure = QPushButton(theme.icon("image-outline"), tr("Figure…"))
        self.figure.setToolTip(tr("Map, rose, nodes, lengths and intensity as SVG, PDF or PNG."))
        self.copy = CopyCommandButton(
            self.copy_command, tr("keep the traces as a GeoPackage, and copy the command")
        )
        self.figures = QTextBrowser()
        self.figures.setAccessibleName(tr("Figures of the fractures"))
        self.map = DrawingView(tr("The traces will be drawn here, as they lie on their face."))
        self.map.setAccessibleName(tr("Map of the traces"))
        self.picture = ScaledPicture()
        self._arrange()
        self._connect()

    def _arrange(self) -> None:
        form = narrow_form()
        form.addRow(tr("Traces"), self.of)
        form.addRow(tr("Face"), self.plane)
        row = QHBoxLayout()
        row.setSpacing(3)
        row.addWidget(self.counted_in)
        row.addWidget(self.place, 1)
        row.addWidget(self.take)
        form.addRow(tr("Count in"), row)
        numbers = QHBoxLayout()
        numbers.setSpacing(3)
        numbers.addWidget(self.options.fields["snap_m"], 1)
        numbers.addWidget(self.options.labels["terzaghi_cap"])
        numbers.addWidget(self.options.fields["terzaghi_cap"], 1)
        form.addRow(self.options.labels["snap_m"], numbers)
        self.tabs = QTabWidget()
        self.tabs.addTab(self.map, tr("Map"))
        self.tabs.addTab(self.picture, tr("Figure"))
        shown = QWidget()
        beside = QHBoxLayout(shown)
        beside.setContentsMargins(0, 0, 0, 0)
        beside.addWidget(self.figures, 2)
        beside.addWidget(self.tabs, 3)
        self.figures.setMinimumWidth(150)
        buttons = button_row(self.figure, self.copy)
        FormWithPicture.fill(self, form, buttons, self.message, picture=shown)

    def _connect(self) -> None:
        studio = self._studio
        self.of.activated.connect(self._soon)
        self.plane.changed.connect(self._soon)
        self.counted_in.currentIndexChanged.connect(self._counted_in_chosen)
        self.place.textChanged.connect(self._soon)
        self.options.changed.connect(self._soon)
        self.take.clicked.connect(lambda _=False: self._take_selected())
        self.figure.clicked.connect(lambda _=False: self._ask_for_figure())
        self.tabs.currentChanged.connect(lambda _: self._draw_figure())
        self.map.dragged.connect(self._dragged)
        self.map.dragging.connect(
            lambda ends: self.map.show_mark(mark_of(self._counted(), self._place_of(ends)))
        )
        studio.project_opened.connect(self._opened)
        studio.edited.connect(self._edited)
        studio.selection_changed.connect(lambda _: self._selected())
        self._counted_in_chosen()

    def _opened(self) -> None:
        """Another project."""
        self.place.clear()
        self._soon()

    # --- where is counted --------------------------------------------------------------------
    def _counted(self) -> str:
        return self.counted_in.kind()

    def _counted_in_chosen(self, *_: object) -> None:
        kind = self._counted()
        self.place.clear()
        why = None
        if kind == EVERYTHING:
            why = Finding("action.all-traces-counted")
        elif kind == GRID:
            why = Finding("action.cells-are-window")
        allow(self.place, why)
        self.place.setPlaceholderText(
            {
                EVERYTHING: "",
                WINDOW: tr("around all"),
                CIRCLE: tr("x, y, radius"),
                SCANLINE: tr("x, y, x, y"),
                GRID: tr("cells done or empty"),
            }[kind]
        )
        free = kind not in (EVERYTHING, GRID)
        self.map.enable_marking(free)
        self.map.setToolTip("" if not free else tr("Drag to mark where the traces are counted."))
        self._refresh_take()
        self._soon()

    def _place_of(self, ends: FloatArray) -> tuple[float, ...]:
        (x0, y0), (x1, y1) = np.round(ends, 3).tolist()
        kind = self._counted()
        if kind == CIRCLE:
            return x0, y0, round(math.hypot(x1 - x0, y1 - y0), 3)
        if kind == WINDOW:
            return min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)
        return x0, y0, x1, y1

    def _dragged(self, ends: FloatArray) -> None:
        self.place.setText(", ".join(f"{v:g}" for v in self._place_of(ends)))

    def _selected_line(self) -> FloatArray | None:
        """(n, 3) World."""
        line = current_line(self._studio, Picked)
        return None if line is None else self._studio.measured([line.id])[line.id].points

    def _refresh_take(self) -> None:
        kind, line = self._counted(), self._selected_line()
        least = 3 if kind == WINDOW else 2
        why = None
        if kind not in (WINDOW, SCANLINE):
            why = Finding("action.no-window")
        elif line is None or len(line) < least or self.result is None:
            why = Finding("action.no-area" if kind == WINDOW else "action.no-line")
        allow(self.take, why)

    def _take_selected(self) -> None:
        line = self._selected_line()
        if line is None or self.result is None:
            return
        from vomstudio.products.section.trace_map import map_to_face

        (flat,) = map_to_face([line], self.result.face)
        self.place.setText(", ".join(f"{v:.3f}" for v in flat.ravel().tolist()))

    def _edited(self, edit: Edit) -> None:
        super()._edited(edit)
        if any(isinstance(r, FaceGrid) for r in (*edit.before.values(), *edit.after.values())):
            self._soon()

    def _selected(self) -> None:
        if self.of.choice() == SELECTED:
            self._soon()
        self._refresh_take()

    # --- the question ------------------------------------------------------------------------
    def _list(self) -> None:
        self.of.list_groups()
        self.counted_in.list_grids()

    def _answer(self, question: FractureQuestion) -> FractureAnswer:
        return answer(question)

    def _traces(self) -> list[MappedTrace]:
        studio, records = self._studio, self._studio.records
        features = [f for f in self.of.features() if isinstance(f, Picked) and _is_line(f)]
        measured = studio.measured(f.id for f in features)
        found = []
        for f in features:
            layer = kind_of(f).layer
            shape = None if layer is None else layer.shape(Subject(f, measured[f.id], records))
            type_ = records.get(f.type_id) if isinstance(f, Typed) else None
            if shape is None or not isinstance(f, Typed):
                continue
            named = type_.name if isinstance(type_, FeatureType) else ""
            color = type_.color if isinstance(type_, FeatureType) else _NO_COLOR
            found.append(MappedTrace(f.id, f.name, f.set_name or named, color, shape))
        return found

    def _question(self) -> FractureQuestion:
        traces = self._traces()
        if not traces:
            is_selection = self.of.choice() == SELECTED
            raise InputError(Finding("selection.unsuitable" if is_selection else "traces.none"))
        plane = self.plane.plane()
        place = numbers_of(self.place.text())
        if place is None:
            raise InputError(Finding("fractures.not-numbers", text=self.place.text().strip()))
        if (why := wanted_of(self._counted(), place)) is not None:
            raise InputError(why)
        models = [
            model_of(self._studio.records, get_feature(self._studio.records, t.id)) for t in traces
        ]
        return FractureQuestion(
            traces,
            plane,
            self._counted(),
            place,
            self.options.options(),
            all(m is None or m.frame.has_metres for m in models),
            all(m is None or m.frame.has_north for m in models),
            self.counted_in.cells(),
            _crs_of(models),
        )

    # --- the answer --------------------------------------------------------------------------
    def _result_text(self, result: FractureAnswer) -> str:
        notes = [str(result.why)]
        if result.mapped is not None:
            plane = result.face.plane
            assert plane is not None
            from vomstudio.geology.notation import format_plane

            shown = format_plane(plane, self._studio.settings.notation, 0)
            if plane.undefined:
                text = tr("{count} traces, seen from above.", count=len(result.lines))
            else:
                text = (
                    tr(
                        "{count} traces on the face {plane}; azimuths are their strikes.",
                        count=len(result.lines),
                        plane=shown,
                    )
                    if result.plane.azimuths_from == "north"
                    else tr(
                        "{count} traces on the face {plane}; azimuths are angles on it, "
                        "clockwise from up.",
                        count=len(result.lines),
                        plane=shown,
                    )
                )
            notes = [
                text,
                *(
                    str(each)
                    for each in result.mapped.found.warnings
                    # The first line names the plane.
                    if each.code != "lines.not-planar"
                ),
                *map(str, result.mapped.found.notes),
                *self.of.exclusion_messages(),
                *_of_cells(result),
            ]
        return "\n".join(notes)

    def _draw(self) -> None:
        result = self.result
        self.map.show_drawing(None if result is None else result.drawing)
        self.map.show_mark(None if result is None else result.mark)
        self.figures.setHtml(_html(result))
        self._draw_figure()
        self._refresh_take()

    def _refresh(self) -> None:
        why = None
        if self._requests.is_waiting:
            why = Finding("action.busy")
        elif self.result is None or self.result.mapped is None:
            why = Finding("action.no-result")
        allow(self.figure, why)
        self.copy.allow(why)

    def _draw_figure(self) -> None:
        """Where somebody looks at it."""
        result = self.result
        if self.tabs.currentWidget() is not self.picture or result is self._drawn:
            return
        self._drawn = result
        labelled = None if result is None else result.mapped
        if result is None or labelled is None:
            self.picture.show_image(QImage())
        else:
            self._background.run(partial(draw_figure, labelled), partial(self._figure_came, result))

    def _figure_came(self, of: FractureAnswer, png: bytes) -> None:
        if of is self._drawn:
            self.picture.show_image(QImage.fromData(png))

    # --- what is taken away ------------------------------------------------------------------
    def _ask_for_figure(self) -> None:
        path = ask_for_figure_file(self, self._studio, tr("Figure of the fractures"), "fractures")
        if path is not None:
            self.write_figure(path)

    def write_figure(self, path: Path) -> None:
        result = self.result
        labelled = None if result is None else result.mapped
        if labelled is not None:
            self._write(write_figure, labelled, path)

    def copy_command(self) -> None:
        """Ask for the GeoPackage of the traces, and put the command on the clipboard."""
        result = self.result
        if result is None or result.mapped is None:
            return
        from vomstudio.products.section.trace_map import write_map

        traces = result.question.traces

        def write(path: Path) -> None:
            q = result.question
            write_map(
                path,
                [t.points for t in traces],
                [t.name for t in traces],
                [t.set for t in traces],
                result.counted,
                result.face,
                crs=q.crs or Axes(q.metric, q.north_known).wkt,
                force=True,
            )

        copy_with_file(self, self._studio, "traces.gpkg", write, partial(words_of, result))


def _of_cells(result: FractureAnswer) -> list[str]:
    cells = result.question.cells
    if cells is None:
        return []
    return [
        tr_n(
            "Counted in {count} whole cell of {grid} that is done or empty.",
            "Counted in {count} whole cells of {grid} that are done or empty.",
            len(cells.corners),
            grid=cells.name,
        )
    ]


def words_of(result: FractureAnswer, traces: Path) -> CommandArguments:
    """The command that says the same. traces : their GeoPackage, with what they are counted in
    beside it"""
    from vomstudio.products.section.trace_map import map_files, map_to_outcrop

    q, counted = result.question, result.counted
    plane = result.plane
    circle = None
    if counted.circle is not None:
        x, y, radius = counted.circle
        (centre,) = map_to_outcrop(np.array([[x, y]]), result.face).tolist()
        centre = centre[:2] if plane.is_horizontal else centre
        circle = format_numbers((*centre, radius))
    files = map_files(traces, counted)
    area, scanline = (str(files[name]) if name in files else None for name in ("area", "scanline"))
    shown = f"{plane.dip_direction_deg:.12g}/{plane.dip_deg:.12g}"
    options = replace(q.options, plane=shown, circle=circle, area=area, scanline=scanline)
    return ["fractures", traces, *option_words(options)]


def _crs_of(models: Iterable[Model | None]) -> str | None:
    """Return the CRS that all these models have; None for a local frame."""
    frames = {None if m is None else (m.frame.crs, m.frame.unit_m) for m in models}
    frame = frames.pop() if len(frames) == 1 else None
    return None if frame is None else world_crs(*frame)


def _is_line(feature: Record) -> bool:
    layer = kind_of(feature).layer if isinstance(feature, Typed) else None
    return layer is not None and layer.geometry == "line"


def _html(result: FractureAnswer | None) -> str:
    labelled = None if result is None else result.mapped
    if labelled is None:
        return ""
    from vomstudio.products.fractures.summary import figure_rows

    cells = "".join(
        f"<tr><td style='padding:1px 8px 1px 4px'>{escape(name)}</td>"
        f"<td style='padding:1px 2px'>{escape(_typeset(said))}</td></tr>"
        for name, said in figure_rows(labelled.found)
    )
    note = escape(tr("± 95 %, of traces placed independently."))
    return f"<table width='100%'>{cells}</table><p>{note}</p>"


def _typeset(said: str) -> str:
    """As a window writes what a terminal may not be able to show."""
    once = tr(" (95 %, of traces placed independently)")
    return said.replace(once, "").replace("+-", "±").replace("m2", "m²")
