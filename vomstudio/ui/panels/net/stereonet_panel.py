"""Stereonet panel, linked to the feature table, the project tree and the 3-D view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter

from PySide6.QtCore import QEvent, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtGui import (
    QAction,
    QColor,
    QIcon,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QRegion,
)
from PySide6.QtWidgets import (
    QBoxLayout,
    QHBoxLayout,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_line
from vomstudio.geology.roses import LINE_ANGLES
from vomstudio.products.net.contents import Contouring, NetContents, NetSet, compute_means
from vomstudio.products.net.figure import NetArtists
from vomstudio.products.net.net_options import MAX_PLANES, add_intersections
from vomstudio.products.net.rose import RoseArtists
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.products.net.set_statistics import add_statistics
from vomstudio.products.net.style import NetStyle
from vomstudio.project.edit import Edit
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.project.records import TypedFeature, get_feature
from vomstudio.project.registration_errors import get_model
from vomstudio.studio.surfaces.proposed_planes import ProposedPlanes, is_proposal
from vomstudio.studio.tools.interaction_types import is_click
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ElidedLabel
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import orientation_text
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.canvas import (
    DPI,
    DrawnNet,
    DrawnRoses,
    NetCanvas,
    NetRequest,
)
from vomstudio.ui.panels.net.command import net_command
from vomstudio.ui.panels.net.contour_button import ContourButton
from vomstudio.ui.panels.net.feature_sets import Groups
from vomstudio.ui.panels.net.figure_export import load_figure_style
from vomstudio.ui.panels.net.menu_button import NetMenuButton
from vomstudio.ui.panels.net.source import NetSource, add_fold_axis
from vomstudio.ui.panels.net.view_box import NetViewBox
from vomstudio.ui.panels.net.view_settings import NetViewSettings
from vomstudio.ui.widgets.axis_titles import follow_axes, project_axes
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table

_MENU_ACTIONS = ("propose_sets", "net_in_middle", "figure_style", "export_net")
_FONT_PX = 12.0
# Slow redraws are delayed longer, so that they do not block consecutive picks.
_REDRAW_DELAY_MS, _MAX_DIRECT_REDRAW_MS, _MAX_REDRAW_DELAY_MS = 30, 60, 500
_LABEL_WIDTH_SHARE = 0.4
"""Width of the corner label as a fraction of the canvas width."""
_MIN_CANVAS_PX = 140
"""Minimum width and height of the canvas, also in the overlay."""
_MIN_LEGEND_PX = 360
"""Minimum width of the overlay at which the whole legend is shown."""
_NET_KEY = "net"
_STOP_TIMEOUT_S = 5.0
_OVERLAY_OPACITY = "dd"
"""Opacity of the paper over the outcrop, as two hexadecimal digits."""
_MAX_DIRECT_FEATURES = 300
"""Maximum number of features drawn in the main thread.

Larger nets are drawn in a worker thread; Matplotlib takes 0.1 s for 5,000 features.
"""


class StereonetPanel(QWidget):
    """Panel with the stereonet or roses, in which a click or a lasso selects features."""

    menu_requested = Signal(str, QPoint)
    """Emits the id of the feature under the cursor and the screen position for its menu."""
    paper_changed = Signal(QRegion)

    def __init__(self, studio: Studio, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        set_help_topic(self, "numbers.md#the-net")
        self._studio = studio
        self.view_settings = NetViewSettings(studio)
        self._source = NetSource(studio, self.view_settings)
        self._net: DrawnNet | None = None
        self._roses: DrawnRoses | None = None
        self.canvas = NetCanvas()
        self.canvas.setMinimumSize(_MIN_CANVAS_PX, _MIN_CANVAS_PX)
        self.canvas.mouse_pressed.connect(self._start_path)
        self.canvas.mouse_moved.connect(self._follow_mouse)
        self.canvas.mouse_released.connect(self._finish_path)
        self.canvas.mouse_left.connect(self._describe_selection)
        self.canvas.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.canvas.customContextMenuRequested.connect(self._request_menu)
        self.canvas.painted.connect(self._redraw_if_stale)
        self.canvas.resized.connect(self._schedule_redraw)
        self._background = QtBackground(self, "net", threads=1)
        self._is_stale = True
        self._path: list[tuple[float, float]] = []
        self.view = NetViewBox(studio, self.view_settings)
        self._circles = self._create_toggle(
            "circle-outline", tr("Great circles (hidden if there are many)"), True
        )
        self._poles = self._create_toggle("circle-medium", tr("Poles"), True)
        self._means = self._create_toggle(
            "sigma", tr("Mean orientation of each type and set"), False
        )
        self._beta = self._create_toggle(
            "axis-arrow", tr("Fold axis (beta) and pi-plane of the bedding"), True
        )
        self.contours = ContourButton(studio, self.view_settings, lambda: self._source.types)
        self.copy = QToolButton()
        self.copy.setDefaultAction(actions["copy_net"])
        self.menu_button = NetMenuButton(
            studio=studio,
            view_settings=self.view_settings,
            names=lambda: self._source.names,
            edit_drawings=actions["type_on_net"].trigger,
            final_actions=[actions[name] for name in _MENU_ACTIONS],
        )
        self.command = CopyCommandButton(
            self._copy_command, tr("save the data as a table and copy the command")
        )
        # Neither the net nor the legend covers this corner.
        self._corner_label = _CornerLabel()
        self._corner_label.setParent(self.canvas)
        self._corner_label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.canvas.resized.connect(self._place_corner_label)
        self.tools = QWidget()
        self.tools.setAutoFillBackground(True)
        self._tool_rows = QBoxLayout(QBoxLayout.Direction.LeftToRight, self.tools)
        self._tool_rows.setContentsMargins(4, 2, 4, 2)
        self._tool_rows.setSpacing(2)
        self._tool_rows.addWidget(self.view)
        row = QHBoxLayout()
        self._tool_rows.addLayout(row, 1)
        self._net_buttons = (self._circles, self._poles, self._means, self._beta, self.contours)
        for button in (*self._net_buttons, self.menu_button, self.copy, self.command):
            row.addWidget(button)
        row.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.canvas, 1)
        layout.addWidget(self.tools)
        self._paper_opacity = ""
        self._timer = QTimer(self, singleShot=True, interval=_REDRAW_DELAY_MS)
        self._timer.timeout.connect(self.redraw)
        self._emphasis_timer = QTimer(self, singleShot=True, interval=_REDRAW_DELAY_MS)
        self._emphasis_timer.timeout.connect(self._emphasise)
        self._connect_signals()

    def _connect_signals(self) -> None:
        studio = self._studio
        studio.project_opened.connect(self._schedule_redraw)
        studio.edited.connect(self._follow_edit)
        studio.visibility_changed.connect(lambda _: self._schedule_redraw())
        studio.settings_changed.connect(self._schedule_redraw)
        studio.sets_proposed.connect(self._show_proposed_sets)
        studio.planes_proposed.connect(self._show_proposed_planes)
        studio.selection_changed.connect(lambda _: self._follow_selection())
        studio.tool_changed_signal.connect(self._update_live_net)
        self.view_settings.changed.connect(self._schedule_redraw)
        studio.fold.changed.connect(self._schedule_redraw)
        # An empty net also shows the note about north, and no edit of a feature updates that note.
        follow_axes(self, studio, lambda _: self._schedule_redraw())

    def set_overlay(self, is_overlay: bool) -> None:
        """Enter or leave the overlay, which has translucent paper that covers only the net.

        In the overlay, the tools are in two rows that appear only under the cursor. Figures are
        copied from the docked or enlarged net, or by a command.
        """
        self._paper_opacity = _OVERLAY_OPACITY if is_overlay else ""
        directions = QBoxLayout.Direction
        self._tool_rows.setDirection(
            directions.TopToBottom if is_overlay else directions.LeftToRight
        )
        for button in (self.copy, self.command):
            button.setVisible(not is_overlay)
        self.tools.setVisible(not is_overlay)
        self._schedule_redraw()

    def _create_toggle(self, icon: str, tooltip: str, is_checked: bool) -> QToolButton:
        button = QToolButton()
        button.setIcon(theme.icon(icon))
        button.setToolTip(tooltip)
        button.setAccessibleName(tooltip)
        button.setCheckable(True)
        theme.highlight_toggles(button)
        button.setChecked(is_checked)
        button.toggled.connect(lambda _: self.redraw())
        return button

    @property
    def _is_brief(self) -> bool:
        """Whether the overlay is too narrow for the legend of the net."""
        return bool(self._paper_opacity) and self.canvas.width() < _MIN_LEGEND_PX

    def _place_corner_label(self) -> None:
        """Place the label in the top left corner, or at the bottom of a narrow overlay."""
        canvas, height = self.canvas, self._corner_label.sizeHint().height()
        if self._is_brief:
            self._corner_label.setGeometry(2, canvas.height() - height - 2, canvas.width(), height)
        else:
            width = round(_LABEL_WIDTH_SHARE * canvas.width())
            self._corner_label.setGeometry(2, 2, width, height)

    def _schedule_redraw(self) -> None:
        """Schedule a redraw; all changes before it are drawn together."""
        if not self._timer.isActive():
            self._timer.start()

    def _show_proposed_sets(self, groups: Groups | None) -> None:
        """Show only the planes of the proposed sets; None restores the sets of the project."""
        if groups != self._source.groups:
            self._source.groups = groups
            self._schedule_redraw()

    def _show_proposed_planes(self, owner: str, planes: ProposedPlanes | None) -> None:
        """Show the proposed features of a panel, or hide them if None."""
        previous = self._source.proposed.get(owner)
        if planes is None:
            self._source.proposed.pop(owner, None)
        else:
            self._source.proposed[owner] = planes
        if previous is None or planes is None or previous.indices != planes.indices:
            if previous is not planes:
                self._schedule_redraw()
        elif previous.selection != planes.selection:
            self._follow_selection()

    def _follow_edit(self, edit: Edit) -> None:
        if self._studio.affected_ids(edit):
            self._schedule_redraw()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        super().changeEvent(event)
        # The net uses the colours of the theme. Qt also sends this event before __init__ has
        # finished.
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_timer"):
            self._schedule_redraw()

    def close_thread(self) -> None:
        """Stop the timers and the worker thread."""
        self._timer.stop()
        self._emphasis_timer.stop()
        self._background.stop(wait_s=_STOP_TIMEOUT_S)

    @property
    def artists(self) -> NetArtists | None:
        """Artists of the net, or None before the first drawing or while roses are shown."""
        return None if self._net is None else self._net.artists

    @property
    def roses(self) -> RoseArtists | None:
        """Artists of the roses or histograms, or None while a net is shown."""
        return None if self._roses is None else self._roses.artists

    @property
    def is_up_to_date(self) -> bool:
        """Whether the drawing is current: no redraw is scheduled or running."""
        is_scheduled = self._timer.isActive() or self._emphasis_timer.isActive()
        return not is_scheduled and not self._background.is_busy

    def _redraw_if_stale(self) -> None:
        if self._is_stale:
            self._schedule_redraw()

    # --- drawing -----------------------------------------------------------------------------
    def contents(self) -> NetContents:
        """Return the contents of the net."""
        return add_fold_axis(*self._contents_without_fold())

    def _contents_without_fold(self) -> tuple[NetContents, FoldPlanes | None]:
        """Return the contents of the net without its fold axis, and the planes of that axis.

        Returns
        -------
        NetContents
            Contents of the net.
        FoldPlanes or None
            Planes of the fold axis; None if the axis is not drawn.
        """
        source, view_settings, studio = self._source, self.view_settings, self._studio
        sets = source.visible_sets()
        live_drawings = source.live()
        has_north = self._has_north(sets) and (live_drawings is None or project_axes(studio).north)
        overlays = view_settings.overlays
        circles, marks = view_settings.rotated_drawings()
        net = NetContents(
            sets=tuple(sets),
            projection=self.view.projection,
            circles=None if self._circles.isChecked() else False,
            poles=self._poles.isChecked(),
            means=compute_means(sets, studio.settings.notation) if self._means.isChecked() else (),
            contour=self.contours.method,
            contouring=self._contouring(sets),
            selected=frozenset(studio.selection.ids),
            ellipses=source.current_ellipses(),
            user_circles=circles,
            marks=marks,
            errors=source.error_ellipses(sets) if "errors" in overlays else (),
            live=live_drawings,
            notation=studio.settings.notation,
            notes=(
                *source.repeat_notes(),
                *view_settings.rotation.notes,
                *(() if has_north else (_local_frame_note(),)),
            ),
            compact=True,
            brief=self._is_brief,
            north=has_north,
        )
        if "slip planes" in overlays:
            net = replace(net, user_circles=(*net.user_circles, *source.slip_planes(sets)))
        net = add_statistics(net, overlays)
        planes = sum(len(s) for s in sets if s.kind == "plane")
        if "intersections" in overlays and 2 <= planes <= MAX_PLANES:
            net = add_intersections(net)
        net = replace(net, sets=source.color_sets(net.sets))
        return net, source.fold_planes(sets) if self._beta.isChecked() else None

    def _contouring(self, sets: Sequence[NetSet]) -> Contouring:
        """Return the settings of the contours of these sets."""
        contouring = replace(self.contours.contouring, levels=self.view_settings.levels)
        contoured_type = None if contouring.each_set else self._source.contoured_type(sets)
        return replace(contouring, set_name=contoured_type)

    def rose_contents(self) -> RoseContents:
        """Return the contents of the roses or histograms."""
        sets = self._source.visible_sets()
        net_contents = self._source.roses(sets)
        if self._has_north(sets):
            return net_contents
        return replace(net_contents, notes=(*net_contents.notes, _local_frame_note()), north=False)

    def _has_north(self, sets: Sequence[NetSet]) -> bool:
        """Return whether the azimuths of all shown features refer to north.

        An empty net has north if the axes of the project have it. Compass readings belong to no
        model and always have north.
        """
        if project_axes(self._studio).north:
            return True
        records = self._studio.records
        models = [get_model(records, get_feature(records, id_)) for s in sets for id_ in s.ids]
        return bool(models) and all(model is None or model.frame.has_north for model in models)

    def _copy_command(self) -> None:
        """Write the shown features to a table and copy the command that draws them."""
        contours, notation = self.contours, self._studio.settings.notation
        ids = [id_ for s in self._source.visible_sets() for id_ in s.ids]
        style = load_figure_style(self._studio)
        choice = self._studio.fold
        # A command cannot select planes in a table.
        is_shown = self.contents().fold is not None and not choice.is_selected
        fold = choice.fold_filter if is_shown else None
        copy_with_table(
            self,
            self._studio,
            "net.csv",
            ids,
            lambda path: net_command(
                table=path,
                view_settings=self.view_settings,
                projection=self.view.projection,
                method=contours.method,
                contouring=self._contouring(self._source.visible_sets()),
                notation=notation,
                style=style,
                colors=self._source.type_colors(ids, style),
                fold=fold,
            ),
        )

    def printable_contents(self) -> NetContents | RoseContents:
        """Return the contents of a printed figure, which has a title and no selection."""
        project, frame = self._studio.project, self._studio.frame_name()
        title = "" if project.is_untitled else project.name
        notes = (frame,) if frame else ()
        if self.view_settings.view != "net":
            roses = self.rose_contents()
            return replace(
                roses, title=title, notes=(*roses.notes, *self.view_settings.rotation.notes, *notes)
            )
        net = self.contents().replace_selection(())
        notes = (*net.notes, *notes)
        return replace(net, title=title, notes=notes, compact=False, brief=False, live=None)

    def redraw(self) -> None:
        """Redraw the net if it is visible, otherwise the next time it is painted."""
        # Qt reports a panel behind another tab as visible.
        self._is_stale = self.canvas.visibleRegion().isEmpty()
        if self._is_stale or self.canvas.width() < 50 or self.canvas.height() < 50:
            return
        start = perf_counter()
        self._enable_buttons()
        is_dark = self.palette().color(QPalette.ColorRole.Window).lightness() < 128
        net, fold_planes = (
            self._contents_without_fold()
            if self.view_settings.view == "net"
            else (NetContents(), None)
        )
        # Printed figures and copied commands contain features only.
        shown_sets = (*net.sets, *self._source.proposals())
        net = replace(
            net,
            sets=shown_sets,
            selected=self._source.selected_ids(),
            contouring=self._contouring(shown_sets),
        )
        is_large_net = _is_large(net)
        style = NetStyle.dock(dark=is_dark, dpi=DPI, font_px=_FONT_PX)
        paper = style.paper + self._paper_opacity
        is_net = self.view_settings.view == "net"
        self._corner_label.set_paper(paper if self._paper_opacity else None)
        request = NetRequest(
            contents=net,
            style=style if is_net else replace(style, paper=paper),
            size=(self.canvas.width(), self.canvas.height()),
            ratio=self.canvas.devicePixelRatioF(),
            fold_planes=fold_planes,
            paper=paper if is_net and self._paper_opacity else None,
        )
        if not is_net:
            self._background.cancel(_NET_KEY)
            self._draw_roses(request)
        elif is_large_net:
            draw = partial(DrawnNet.draw, request)
            self._background.run(draw, partial(self._show_drawn_net, request), key=_NET_KEY)
        else:
            self._background.cancel(_NET_KEY)
            self._show_net(DrawnNet.draw(request))
        elapsed_ms = 1000.0 * (perf_counter() - start)
        # The outcrop shows a changed feature before a large net does.
        is_slow = elapsed_ms > _MAX_DIRECT_REDRAW_MS or is_large_net
        self._timer.setInterval(
            min(_MAX_REDRAW_DELAY_MS, int(5 * elapsed_ms)) if is_slow else _REDRAW_DELAY_MS
        )

    def _enable_buttons(self) -> None:
        """Enable the buttons of the net only while a net is shown; tooltips state the reason."""
        is_net = self.view_settings.view == "net"
        for button in self._net_buttons:
            title = button.accessibleName()
            button.setEnabled(is_net)
            button.setToolTip(title if is_net else Finding("net.only", what=title).message)
        self._corner_label.setVisible(is_net)

    def _show_drawn_net(self, request: NetRequest, net: DrawnNet) -> None:
        if request.contents.selected != self._source.selected_ids():
            self._emphasise_selection(net)
        net.artists.show_live_feature(self._source.live())
        self._show_net(net)

    def _emphasise_selection(self, net: DrawnNet) -> None:
        net.artists.select(self._source.selected_ids(), self._source.current_ellipses())

    def _draw_roses(self, request: NetRequest) -> None:
        net_contents = self.rose_contents()
        self._net = self._roses = None
        if net_contents.roses:
            self._roses = DrawnRoses.draw(net_contents, request)
            self.canvas.show_net(self._roses)
        elif net_contents.of in LINE_ANGLES:
            self.canvas.show_message(tr("No visible lines to plot."))
        else:
            self.canvas.show_message(tr("No visible planes to plot."))
        self._describe_selection()

    def _update_live_net(self) -> None:
        """Update the open feature of the current tool on the net."""
        if self._net is None or not self.is_up_to_date or self._is_stale:
            return
        live_net = self._source.live()
        if live_net is not None or self._net.artists.contents.live is not None:
            self._net.artists.show_live_feature(live_net)
            self.canvas.show_net(self._net)

    def _show_net(self, net: DrawnNet) -> None:
        self._net, self._roses = net, None
        self.canvas.show_net(net)
        self._describe_selection()

    def _follow_selection(self) -> None:
        if self._studio.fold.is_selected:
            self._schedule_redraw()
        if self._net is not None and _is_large(self._net.artists.contents):
            # The table and the outcrop are updated first.
            self._emphasis_timer.start()
        else:
            self._emphasise()

    def _emphasise(self) -> None:
        if self._net is not None and self.is_up_to_date:
            self._emphasise_selection(self._net)
            self.canvas.show_net(self._net)
        self._describe_selection()

    # --- mouse -------------------------------------------------------------------------------
    def _start_path(self, event: QMouseEvent, x: float, y: float) -> None:
        self._path = [(x, y)]
        self.canvas.lasso = [event.position()]

    def _follow_mouse(self, x: float, y: float) -> None:
        if self._path:
            self._path.append((x, y))
            if self._is_lasso():
                self.canvas.update()
            return
        line = self.artists.line_at(x, y) if self.artists else None
        if line is None:
            self._describe_selection()
        else:
            self._corner_label.set_text(format_line(line, 0))
            self._place_corner_label()

    def _is_lasso(self) -> bool:
        (x0, y0), scale = self._path[0], self.canvas.devicePixelRatioF()
        return not all(is_click((x - x0) / scale, (y - y0) / scale) for x, y in self._path)

    def _finish_path(self, event: QMouseEvent, x: float, y: float) -> None:
        if not self._path:
            return
        path, is_lasso = self._path, self._is_lasso()
        self._path, self.canvas.lasso = [], []
        self.canvas.update()
        is_adding = bool(
            event.modifiers()
            & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
        )
        selection = self._studio.selection
        if self.roses is not None and not is_lasso:
            bin_ids = self.roses.features_at(x, y)
            selection.set([*selection.ids, *bin_ids] if is_adding else bin_ids)
            return
        if self.artists is None:
            return
        if is_lasso:
            inside_ids = self.artists.features_in_polygon(path)
            if any(map(is_proposal, inside_ids)):
                self._studio.proposals_picked.emit(inside_ids, is_adding)
            # In the order of the records, so that the current feature does not depend on hashing.
            lasso_ids = [f.id for f in self._studio.session.features() if f.id in inside_ids]
            selection.set([*selection.ids, *lasso_ids] if is_adding else lasso_ids)
            return
        feature_id = self.artists.feature_at(x, y, 8.0 * self.canvas.devicePixelRatioF())
        if feature_id is not None and is_proposal(feature_id):
            self._studio.proposals_picked.emit((feature_id,), is_adding)
            return
        if feature_id is not None and is_adding:
            selection.toggle(feature_id)
        elif not is_adding:
            selection.set([] if feature_id is None else [feature_id])

    def _request_menu(self, position: QPoint) -> None:
        ratio = self.canvas.devicePixelRatioF()
        x, y = position.x() * ratio, (self.canvas.height() - position.y()) * ratio
        feature_id = self.artists.feature_at(x, y, 8.0 * ratio) if self.artists else None
        if feature_id is not None:
            self.menu_requested.emit(feature_id, self.canvas.mapToGlobal(position))

    def _describe_selection(self) -> None:
        """Show a single selected feature in the corner label, with its attitude and verdict."""
        ids = self._studio.selection.ids
        net_contents = self.artists.contents if self.artists else None
        shown_ids = {i for s in net_contents.sets for i in s.ids} if net_contents and ids else set()
        if self.roses is not None:
            shown_ids = {i for c in self.roses.contents.counted_sets.values() for i in c.ids}
        selected_ids = [i for i in ids if i in shown_ids]
        record = self._studio.records.get(selected_ids[0]) if len(selected_ids) == 1 else None
        text, icon = "", QIcon()
        if isinstance(record, TypedFeature):
            measurement = self._studio.measured([record.id])[record.id]
            attitude = orientation_text(measurement, self._studio.settings.notation)
            text = ("{}  {}" if self._is_brief else "{}\n{}").format(record.name, attitude)
            if self._is_brief and not self._corner_label.fits(text, self.canvas.width()):
                text = attitude
            if measurement.verdict is not None:
                icon = theme.verdict_icon(measurement.verdict.quality)
        self._corner_label.set_text(text, icon)
        self._place_corner_label()
        self._report_paper()

    def _report_paper(self) -> None:
        """Emit the area of the net and its texts, the only area that an overlay covers."""
        region = QRegion() if self._net is None else self._net.paper_region
        if not region.isEmpty():
            region = region.united(self._corner_label.paper_rect())
            region.translate(self.canvas.mapTo(self, QPoint(0, 0)))
        self.paper_changed.emit(region)


class _CornerLabel(ElidedLabel):
    """Label with its own paper and a coloured mark at the end of its last line."""

    def __init__(self) -> None:
        super().__init__()
        self.setContentsMargins(4, 1, 4, 1)
        self._mark = QIcon()
        self._paper = QColor()

    def set_text(self, text: str, mark: QIcon | None = None) -> None:
        """Show a text, optionally with a mark."""
        self._mark = mark or QIcon()
        self.setText(text)
        self.update()

    def set_paper(self, color: str | None) -> None:
        """Set the colour behind the text as #rrggbbaa, or None for no paper."""
        self._paper = QColor() if color is None else QColor(f"#{color[7:]}{color[1:7]}")

    def fits(self, text: str, width_px: int) -> bool:
        """Return whether a line of text and a mark fit in a width."""
        metrics, margins = self.fontMetrics(), self.contentsMargins()
        mark = metrics.height() + 8
        return metrics.horizontalAdvance(text) + mark + margins.left() <= width_px

    def paper_rect(self) -> QRect:
        """Return the rectangle of the paper in the parent widget; empty if there is no text."""
        return self._text_rect().translated(self.pos()) if self.text() else QRect()

    def _text_rect(self) -> QRect:
        area, margins = self.contentsRect(), self.contentsMargins()
        lines = (self.shorten(line, area.width()) for line in self.text().split("\n"))
        width = max(map(self.fontMetrics().horizontalAdvance, lines))
        if not self._mark.isNull():
            width = max(width, self._mark_rect().right() + 1 - area.left())
        return QRect(0, 0, margins.left() + width + margins.right(), self.height())

    def _mark_rect(self) -> QRect:
        metrics, area = self.fontMetrics(), self.contentsRect()
        last_line = self.shorten(self.text().split("\n")[-1], area.width())
        side = metrics.height()
        mark_x = area.left() + metrics.horizontalAdvance(last_line) + 4
        return QRect(mark_x, area.bottom() + 1 - side, side, side)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        if self._paper.isValid() and self.text():
            painter = QPainter(self)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(self._paper)
            painter.drawRoundedRect(self._text_rect(), 4.0, 4.0)
            painter.end()
        super().paintEvent(event)
        self._mark.paint(QPainter(self), self._mark_rect())


def _is_large(net: NetContents) -> bool:
    return sum(map(len, net.sets)) > _MAX_DIRECT_FEATURES


def _local_frame_note() -> str:
    return tr("Local frame: azimuths are from the model's y axis, not from north")
