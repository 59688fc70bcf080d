"""Panel that counts fracture traces along a line, or in a circle, window or grid cells."""

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
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import (
    FaceGrid,
    FeatureType,
    Model,
    PickedFeature,
    Record,
    TypedFeature,
    get_feature,
)
from vomstudio.project.registration_errors import get_model
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import current_line
from vomstudio.ui.base.controls import button_row, icon_button, narrow_form, set_enabled
from vomstudio.ui.base.numbers import parse_numbers
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.fractures.analysis import (
    CIRCLE,
    EVERYTHING,
    GRID,
    SCANLINE,
    WINDOW,
    FractureRequest,
    FractureResult,
    MappedTrace,
    analyse_fractures,
    check_region_numbers,
    draw_figure,
    region_mark,
    write_figure,
)
from vomstudio.ui.panels.fractures.region_box import RegionBox
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    CopyCommandButton,
    copy_with_file,
    format_numbers,
)
from vomstudio.ui.widgets.drawing_view import DrawingView
from vomstudio.ui.widgets.figure_file import choose_figure_file
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.group_box import SELECTED, GroupBox
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.plane_field import PlaneField, ViewDirection
from vomstudio.ui.widgets.scaled_picture import ScaledPicture

_NO_COLOR = "#404040"


class FracturesPanel(AnalysisPanel[FractureRequest, FractureResult]):
    """Panel that counts traces along a line, or in a circle, window or grid cells."""

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__(studio, "fracture", "fractures.md", tr("Counting…"))
        self._drawn_result: FractureResult | None = None
        self.group_box = GroupBox(studio, tr("All traces"))
        self.group_box.setAccessibleName(tr("Traces"))
        self.plane = PlaneField(studio, "fracture_plane", tr("best-fit plane"), view)
        self.region_box = RegionBox(studio)
        self.region_field = QLineEdit()
        self.region_field.setObjectName("fracture_place")
        self.take = icon_button("cursor-default-click-outline", tr("Use the selected line or area"))
        self.take.setToolTip(tr("Use the selected line or area, projected onto the face."))
        self.options = OptionFields(FractureOptions, "fracture")
        follow_axes(self, studio, lambda axes: self.options.show_unit(length_unit(axes)))
        self.figure = QPushButton(theme.icon("image-outline"), tr("Figure…"))
        self.figure.setToolTip(
            tr("Save map, rose, nodes, lengths and intensity as SVG, PDF or PNG.")
        )
        self.copy = CopyCommandButton(
            self.copy_command, tr("save the traces as a GeoPackage and copy the command")
        )
        self.figures = QTextBrowser()
        self.figures.setAccessibleName(tr("Fracture statistics"))
        self.map = DrawingView(tr("The traces will be drawn here, projected onto the face."))
        self.map.setAccessibleName(tr("Trace map"))
        self.picture = ScaledPicture()
        self._arrange_widgets()
        self._connect_signals()

    def _arrange_widgets(self) -> None:
        form = narrow_form()
        form.addRow(tr("Traces"), self.group_box)
        form.addRow(tr("Face"), self.plane)
        row = QHBoxLayout()
        row.setSpacing(3)
        row.addWidget(self.region_box)
        row.addWidget(self.region_field, 1)
        row.addWidget(self.take)
        form.addRow(tr("Count in"), row)
        form.addRow(*self.options.place_row("snap_m", "terzaghi_cap"))
        self.options.add_rows(form)
        self.tabs = QTabWidget()
        self.tabs.addTab(self.map, tr("Map"))
        self.tabs.addTab(self.picture, tr("Figure"))
        results = QWidget()
        layout = QHBoxLayout(results)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.figures, 2)
        layout.addWidget(self.tabs, 3)
        self.figures.setMinimumWidth(150)
        buttons = button_row(self.figure, self.copy)
        FormWithPicture.fill(self, form, buttons, self.message, picture=results)

    def _connect_signals(self) -> None:
        studio = self._studio
        self.group_box.activated.connect(self._schedule_refresh)
        self.plane.changed.connect(self._schedule_refresh)
        self.region_box.currentIndexChanged.connect(self._apply_region_kind)
        self.region_field.textChanged.connect(self._schedule_refresh)
        self.options.changed.connect(self._schedule_refresh)
        self.take.clicked.connect(lambda _=False: self._use_selection())
        self.figure.clicked.connect(lambda _=False: self._ask_for_figure())
        self.tabs.currentChanged.connect(lambda _: self._draw_figure())
        self.map.dragged.connect(self._store_drag)
        self.map.dragging.connect(
            lambda ends: self.map.show_mark(
                region_mark(self._region_kind(), self._region_numbers(ends))
            )
        )
        studio.edited.connect(self._follow_edit)
        studio.selection_changed.connect(self._follow_selection)
        self._apply_region_kind()

    # --- sampling region ---------------------------------------------------------------------
    def _region_kind(self) -> str:
        return self.region_box.kind()

    def _apply_region_kind(self, *_: object) -> None:
        region_kind = self._region_kind()
        self.region_field.clear()
        reason = None
        if region_kind == EVERYTHING:
            reason = Finding("action.all-traces-counted")
        elif region_kind == GRID:
            reason = Finding("action.cells-are-window")
        set_enabled(self.region_field, reason)
        self.region_field.setPlaceholderText(
            {
                EVERYTHING: "",
                WINDOW: tr("around all traces"),
                CIRCLE: tr("x, y, radius"),
                SCANLINE: tr("x, y, x, y"),
                GRID: tr("done and empty cells"),
            }[region_kind]
        )
        can_mark = region_kind not in (EVERYTHING, GRID)
        self.map.enable_marking(can_mark)
        self.map.setToolTip("" if not can_mark else tr("Drag to mark where traces are counted."))
        self._refresh_take_button()
        self._schedule_refresh()

    def _region_numbers(self, ends: FloatArray) -> tuple[float, ...]:
        (x0, y0), (x1, y1) = np.round(ends, 3).tolist()
        region_kind = self._region_kind()
        if region_kind == CIRCLE:
            return x0, y0, round(math.hypot(x1 - x0, y1 - y0), 3)
        if region_kind == WINDOW:
            return min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)
        return x0, y0, x1, y1

    def _store_drag(self, ends: FloatArray) -> None:
        self.region_field.setText(", ".join(f"{v:g}" for v in self._region_numbers(ends)))

    def _selected_line(self) -> FloatArray | None:
        """Return the World points (n, 3) of the selected line, or None if none is selected."""
        line = current_line(self._studio, PickedFeature)
        return None if line is None else self._studio.measured([line.id])[line.id].points

    def _refresh_take_button(self) -> None:
        region_kind, line = self._region_kind(), self._selected_line()
        min_points = 3 if region_kind == WINDOW else 2
        reason = None
        if region_kind not in (WINDOW, SCANLINE):
            reason = Finding("action.no-window")
        elif line is None or len(line) < min_points or self.result is None:
            reason = Finding("action.no-area" if region_kind == WINDOW else "action.no-line")
        set_enabled(self.take, reason)

    def _use_selection(self) -> None:
        line = self._selected_line()
        if line is None or self.result is None:
            return
        from vomstudio.products.section.trace_map import map_to_face

        (face_line,) = map_to_face([line], self.result.face)
        self.region_field.setText(", ".join(f"{v:.3f}" for v in face_line.ravel().tolist()))

    def _follow_edit(self, edit: Edit) -> None:
        super()._follow_edit(edit)
        if any(isinstance(r, FaceGrid) for r in (*edit.before.values(), *edit.after.values())):
            self._schedule_refresh()

    def _follow_selection(self) -> None:
        if self.group_box.choice() == SELECTED:
            self._schedule_refresh()
        self._refresh_take_button()

    # --- input -------------------------------------------------------------------------------
    def _list_choices(self) -> None:
        self.group_box.list_groups()
        self.region_box.list_grids()

    def _compute_result(self, request: FractureRequest) -> FractureResult:
        return analyse_fractures(request)

    def _traces(self) -> list[MappedTrace]:
        studio, records = self._studio, self._studio.records
        features = [
            f for f in self.group_box.features() if isinstance(f, PickedFeature) and _is_line(f)
        ]
        measurements = studio.measured(f.id for f in features)
        traces = []
        for f in features:
            layer = get_kind(f).layer
            shape = None if layer is None else layer.shape(Subject(f, measurements[f.id], records))
            feature_type = records.get(f.type_id) if isinstance(f, TypedFeature) else None
            if shape is None or not isinstance(f, TypedFeature):
                continue
            type_name = feature_type.name if isinstance(feature_type, FeatureType) else ""
            color = feature_type.color if isinstance(feature_type, FeatureType) else _NO_COLOR
            traces.append(
                MappedTrace(
                    id=f.id, name=f.name, set=f.set_name or type_name, color=color, points=shape
                )
            )
        return traces

    def _create_request(self) -> FractureRequest:
        traces = self._traces()
        if not traces:
            is_selection = self.group_box.choice() == SELECTED
            raise InputError(Finding("selection.unsuitable" if is_selection else "traces.none"))
        plane = self.plane.plane()
        numbers = parse_numbers(self.region_field.text())
        if numbers is None:
            raise InputError(
                Finding("fractures.not-numbers", text=self.region_field.text().strip())
            )
        if (reason := check_region_numbers(self._region_kind(), numbers)) is not None:
            raise InputError(reason)
        models = [
            get_model(self._studio.records, get_feature(self._studio.records, t.id)) for t in traces
        ]
        return FractureRequest(
            traces=traces,
            plane=plane,
            region_kind=self._region_kind(),
            region_numbers=tuple(numbers),
            options=self.options.options(),
            is_metric=all(m is None or m.frame.has_metres for m in models),
            is_north_known=all(m is None or m.frame.has_north for m in models),
            cells=self.region_box.cells(),
            crs=_common_crs(models),
        )

    # --- result ------------------------------------------------------------------------------
    def _result_text(self, result: FractureResult) -> str:
        notes = [str(result.reason)]
        if result.network is not None:
            plane = result.face.plane
            assert plane is not None
            from vomstudio.geology.notation import format_plane

            attitude = format_plane(plane, self._studio.settings.notation, 0)
            if plane.undefined:
                text = tr("{count} traces, seen from above.", count=len(result.lines))
            else:
                text = (
                    tr(
                        "{count} traces on the face {plane}; azimuths are their strikes.",
                        count=len(result.lines),
                        plane=attitude,
                    )
                    if result.plane.azimuths_from == "north"
                    else tr(
                        "{count} traces on the face {plane}; azimuths are angles on it, "
                        "clockwise from up.",
                        count=len(result.lines),
                        plane=attitude,
                    )
                )
            notes = [
                text,
                *(
                    str(warning)
                    for warning in result.network.statistics.warnings
                    # The first line already reports the plane.
                    if warning.code != "lines.not-planar"
                ),
                *map(str, result.network.statistics.notes),
                *self.group_box.exclusion_messages(),
                *_cells_text(result),
            ]
        return "\n".join(notes)

    def _draw(self) -> None:
        result = self.result
        self.map.show_drawing(None if result is None else result.drawing)
        self.map.show_mark(None if result is None else result.mark)
        self.figures.setHtml(_result_html(result))
        self._draw_figure()
        self._refresh_take_button()

    def _refresh(self) -> None:
        reason = None
        if self._requests.is_waiting:
            reason = Finding("action.busy")
        elif self.result is None or self.result.network is None:
            reason = Finding("action.no-result")
        set_enabled(self.figure, reason)
        self.copy.set_enabled(reason)

    def _draw_figure(self) -> None:
        """Draw the figure if its tab is open."""
        result = self.result
        if self.tabs.currentWidget() is not self.picture or result is self._drawn_result:
            return
        self._drawn_result = result
        network = None if result is None else result.network
        if result is None or network is None:
            self.picture.show_image(QImage())
        else:
            self._background.run(partial(draw_figure, network), partial(self._show_figure, result))

    def _show_figure(self, result: FractureResult, png: bytes) -> None:
        if result is self._drawn_result:
            self.picture.show_image(QImage.fromData(png))

    # --- export ------------------------------------------------------------------------------
    def _ask_for_figure(self) -> None:
        path = choose_figure_file(self, self._studio, tr("Figure of the fractures"), "fractures")
        if path is not None:
            self.write_figure(path)

    def write_figure(self, path: Path) -> None:
        result = self.result
        network = None if result is None else result.network
        if network is not None:
            self._write(write_figure, network, path)

    def copy_command(self) -> None:
        """Write the traces to a GeoPackage selected by the user, and copy the command."""
        result = self.result
        if result is None or result.network is None:
            return
        from vomstudio.products.section.trace_map import write_map

        traces = result.request.traces

        def write(path: Path) -> None:
            q = result.request
            write_map(
                path,
                [t.points for t in traces],
                [t.name for t in traces],
                [t.set for t in traces],
                result.region,
                result.face,
                crs=q.crs or Axes(q.is_metric, q.is_north_known).wkt,
                force=True,
            )

        copy_with_file(self, self._studio, "traces.gpkg", write, partial(fractures_command, result))


def _cells_text(result: FractureResult) -> list[str]:
    cells = result.request.cells
    if cells is None:
        return []
    return [
        tr_n(
            "Counted in {count} done or empty cell of {grid}.",
            "Counted in {count} done or empty cells of {grid}.",
            len(cells.corners),
            grid=cells.name,
        )
    ]


def fractures_command(result: FractureResult, traces: Path) -> CommandArguments:
    """Return the command that reproduces the result from a GeoPackage of the traces.

    The sampling region is stored in files next to the GeoPackage.
    """
    from vomstudio.products.section.trace_map import map_outputs, map_to_outcrop

    q, region = result.request, result.region
    plane = result.plane
    circle = None
    if region.circle is not None:
        x, y, radius = region.circle
        (centre,) = map_to_outcrop(np.array([[x, y]]), result.face).tolist()
        centre = centre[:2] if plane.is_horizontal else centre
        circle = format_numbers((*centre, radius))
    files = map_outputs(traces, region)
    area, scanline = (str(files[name]) if name in files else None for name in ("area", "scanline"))
    attitude = f"{plane.dip_direction_deg:.12g}/{plane.dip_deg:.12g}"
    options = replace(q.options, plane=attitude, circle=circle, area=area, scanline=scanline)
    return ["fractures", traces, *option_words(options)]


def _common_crs(models: Iterable[Model | None]) -> str | None:
    """Return the common CRS of the models, or None for local or different frames."""
    frames = {None if m is None else (m.frame.crs, m.frame.unit_m) for m in models}
    frame = frames.pop() if len(frames) == 1 else None
    return None if frame is None else world_crs(*frame)


def _is_line(feature: Record) -> bool:
    layer = get_kind(feature).layer if isinstance(feature, TypedFeature) else None
    return layer is not None and layer.geometry == "line"


def _result_html(result: FractureResult | None) -> str:
    network = None if result is None else result.network
    if network is None:
        return ""
    from vomstudio.products.fractures.summary import figure_rows

    cells = "".join(
        f"<tr><td style='padding:1px 8px 1px 4px'>{escape(name)}</td>"
        f"<td style='padding:1px 2px'>{escape(_typeset(value))}</td></tr>"
        for name, value in figure_rows(network.statistics)
    )
    note = escape(tr("95 % error, assuming independently placed traces."))
    return f"<table width='100%'>{cells}</table><p>{note}</p>"


def _typeset(text: str) -> str:
    """Replace plain-text symbols with typographic ones, and remove a repeated note."""
    repeated_note = tr(" (95 %, assuming independently placed traces)")
    return text.replace(repeated_note, "").replace("+-", "±").replace("m2", "m²")
