"""The stereonet dock: orientations of the project, linked with table, tree and 3-D view."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter

from PySide6.QtCore import QEvent, Qt, QTimer
from PySide6.QtGui import QAction, QMouseEvent, QPalette
from PySide6.QtWidgets import (
    QHBoxLayout,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_line
from vomstudio.geology.roses import LINE_ANGLES
from vomstudio.products.net.contents import NetContents, NetSet, compute_means
from vomstudio.products.net.figure import NetArtists
from vomstudio.products.net.net_options import MAX_PLANES, add_intersections
from vomstudio.products.net.rose import RoseArtists
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.products.net.set_statistics import add_statistics
from vomstudio.products.net.style import NetStyle
from vomstudio.project.edit import Edit
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.project.records import Typed, get_feature
from vomstudio.project.registration_errors import model_of
from vomstudio.studio.tools.interaction_types import is_click
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ElidedLabel
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.number_formatting import orientation_text
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.canvas import (
    DPI,
    DrawnNet,
    DrawnRoses,
    NetCanvas,
    Wanted,
)
from vomstudio.ui.panels.net.command import net_words
from vomstudio.ui.panels.net.contour_button import ContourButton
from vomstudio.ui.panels.net.feature_sets import Groups
from vomstudio.ui.panels.net.figure_export import style_of
from vomstudio.ui.panels.net.menu_button import NetMenuButton
from vomstudio.ui.panels.net.source import NetSource, with_fold
from vomstudio.ui.panels.net.view_box import NetViewBox
from vomstudio.ui.panels.net.view_settings import NetWishes
from vomstudio.ui.widgets.axis_titles import follow_axes, project_axes
from vomstudio.ui.widgets.copied_command import CopyCommandButton
from vomstudio.ui.widgets.copied_planes import copy_with_table

_IN_MENU = ("propose_sets", "net_in_middle", "figure_style", "export_net")
# A press that moves further than this draws a lasso.
_FONT_PX = 12.0
# A redraw that takes long comes seldom: it must never hold up a row of picks.
_SOON_MS, _QUICK_MS, _LATEST_MS = 30, 60, 500
_CORNER = 0.4
"""Of the width, for the name of what is selected."""
_NET = "net"
_PATIENCE_S = 5.0
_MANY = 300
"""Orientations above which the net is drawn in a thread: Matplotlib takes 0.1 s for 5,000."""


class StereonetPanel(QWidget):
    """The net with its buttons. A click or a lasso selects features."""

    def __init__(self, studio: Studio, actions: Mapping[str, QAction]) -> None:
        super().__init__()
        explain(self, "numbers.md#the-net")
        self._studio = studio
        self.wishes = NetWishes(studio)
        self._source = NetSource(studio, self.wishes)
        self._net: DrawnNet | None = None
        self._roses: DrawnRoses | None = None
        self.canvas = NetCanvas()
        self.canvas.setMinimumSize(220, 220)
        self.canvas.pressed.connect(self._pressed)
        self.canvas.moved.connect(self._moved)
        self.canvas.released.connect(self._released)
        self.canvas.left.connect(self._show_selected)
        self.canvas.painted.connect(self._painted)
        self.canvas.resized.connect(self._soon)
        self._background = QtBackground(self, "net", threads=1)
        self._stale = True
        self._path: list[tuple[float, float]] = []
        self.view = NetViewBox(studio, self.wishes)
        self._circles = self._toggle(
            "circle-outline", tr("Great circles (hidden where there are many)"), True
        )
        self._poles = self._toggle("circle-medium", tr("Poles"), True)
        self._means = self._toggle("sigma", tr("Mean orientation of each type and set"), False)
        self._beta = self._toggle(
            "axis-arrow", tr("Fold axis (beta) and pi-plane of the bedding"), True
        )
        self.contours = ContourButton(studio)
        self.copy = QToolButton()
        self.copy.setDefaultAction(actions["copy_net"])
        self.more = NetMenuButton(
            studio,
            self.wishes,
            lambda: self._source.names,
            actions["type_on_net"].trigger,
            [actions[name] for name in _IN_MENU],
        )
        self.command = CopyCommandButton(
            self._copy_command, tr("keep what is shown as a table, and copy the command")
        )
        # In the corner of the picture that neither net nor legend ever reaches.
        self._under = ElidedLabel()
        self._under.setParent(self.canvas)
        self._under.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.canvas.resized.connect(self._place_under)
        row = QHBoxLayout()
        row.setContentsMargins(4, 2, 4, 2)
        row.setSpacing(2)
        row.addWidget(self.view)
        self._of_net = (self._circles, self._poles, self._means, self._beta, self.contours)
        for button in (*self._of_net, self.more, self.copy, self.command):
            row.addWidget(button)
        row.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.canvas, 1)
        layout.addLayout(row)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(_SOON_MS)
        self._timer.timeout.connect(self.redraw)
        self._emphasis = QTimer(self)
        self._emphasis.setSingleShot(True)
        self._emphasis.setInterval(_SOON_MS)
        self._emphasis.timeout.connect(self._emphasise)
        self._listen()

    def _listen(self) -> None:
        studio = self._studio
        studio.project_opened.connect(self._soon)
        studio.edited.connect(self._edited)
        studio.visibility_changed.connect(lambda _: self._soon())
        studio.settings_changed.connect(self._soon)
        studio.sets_proposed.connect(self._proposed)
        studio.selection_changed.connect(lambda _: self._select())
        studio.tool_changed_signal.connect(self._show_live)
        self.wishes.changed.connect(self._soon)
        studio.fold.changed.connect(self._soon)
        # Of an empty net, too, which no edit of a feature changes.
        follow_axes(studio, lambda _: self._soon())

    def _toggle(self, icon: str, tip: str, on: bool) -> QToolButton:
        button = QToolButton()
        button.setIcon(theme.icon(icon))
        button.setToolTip(tip)
        button.setAccessibleName(tip)
        button.setCheckable(True)
        theme.highlight_toggles(button)
        button.setChecked(on)
        button.toggled.connect(lambda _: self.redraw())
        return button

    def _place_under(self) -> None:
        wide = round(_CORNER * self.canvas.width())
        self._under.setGeometry(6, 3, wide, self._under.sizeHint().height())

    def _soon(self) -> None:
        """Draw anew, once for all that happens meanwhile."""
        if not self._timer.isActive():
            self._timer.start()

    def _proposed(self, groups: Groups | None) -> None:
        """Show these planes by their proposed sets, and nothing else, until there are none."""
        if groups != self._source.groups:
            self._source.groups = groups
            self._soon()

    def _edited(self, edit: Edit) -> None:
        if self._studio.affected(edit):
            self._soon()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        super().changeEvent(event)
        # The net has the colours of the theme. Qt sends this before all is made, too.
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_timer"):
            self._soon()

    def close_thread(self) -> None:
        """The program ends."""
        self._timer.stop()
        self._emphasis.stop()
        self._background.stop(wait_s=_PATIENCE_S)

    @property
    def artists(self) -> NetArtists | None:
        """The net that is shown; None before the first, and while roses are."""
        return None if self._net is None else self._net.artists

    @property
    def roses(self) -> RoseArtists | None:
        """The roses or histograms that are shown."""
        return None if self._roses is None else self._roses.artists

    @property
    def up_to_date(self) -> bool:
        """Whether no other net is wanted or being drawn."""
        timed = self._timer.isActive() or self._emphasis.isActive()
        return not timed and not self._background.is_busy

    def _painted(self) -> None:
        if self._stale:
            self._soon()

    # --- drawing -----------------------------------------------------------------------------
    def contents(self) -> NetContents:
        """What the net shows now."""
        return with_fold(*self._without_fold())

    def _without_fold(self) -> tuple[NetContents, FoldPlanes | None]:
        """What the net shows now, and the planes whose fold axis is to be shown too."""
        source, wishes, studio = self._source, self.wishes, self._studio
        sets = source.shown_sets()
        live = source.live()
        north = self._north(sets) and (live is None or project_axes(studio).north)
        asked = wishes.asked
        circles, marks = wishes.typed()
        net = NetContents(
            sets=tuple(sets),
            projection=self.view.projection,
            circles=None if self._circles.isChecked() else False,
            poles=self._poles.isChecked(),
            means=compute_means(sets, studio.settings.notation) if self._means.isChecked() else (),
            contour=self.contours.method,
            contouring=replace(self.contours.contouring, levels=wishes.levels),
            selected=frozenset(studio.selection.ids),
            ellipses=source.of_current(),
            circles_typed=circles,
            marks=marks,
            errors=source.errors(sets) if "errors" in asked else (),
            live=live,
            notation=studio.settings.notation,
            notes=(*source.left_out(), *wishes.turning.notes, *(() if north else (_local(),))),
            compact=True,
            north=north,
        )
        if "slip planes" in asked:
            net = replace(net, circles_typed=(*net.circles_typed, *source.slip_planes(sets)))
        net = add_statistics(net, asked)
        planes = sum(len(s) for s in sets if s.kind == "plane")
        if "intersections" in asked and 2 <= planes <= MAX_PLANES:
            net = add_intersections(net)
        return net, source.fold_planes(sets) if self._beta.isChecked() else None

    def rose_contents(self) -> RoseContents:
        """What roses or histograms show now."""
        sets = self._source.shown_sets()
        found = self._source.roses(sets)
        if self._north(sets):
            return found
        return replace(found, notes=(*found.notes, _local()), north=False)

    def _north(self, sets: Sequence[NetSet]) -> bool:
        """Nothing that is shown lies on a model without north; compass readings lie on none. An
        empty net has the axes of the outcrop."""
        if project_axes(self._studio).north:
            return True
        records = self._studio.records
        models = [model_of(records, get_feature(records, id_)) for s in sets for id_ in s.ids]
        return bool(models) and all(model is None or model.frame.has_north for model in models)

    def _copy_command(self) -> None:
        """Of the planes and lines that are shown, as the net shows them."""
        contours, notation = self.contours, self._studio.settings.notation
        ids = [id_ for s in self._source.shown_sets() for id_ in s.ids]
        style = style_of(self._studio)
        choice = self._studio.fold
        # A command cannot choose the selected planes of a table.
        shown = self.contents().fold is not None and not choice.selected
        fold = choice.which if shown else None
        copy_with_table(
            self,
            self._studio,
            "net.csv",
            ids,
            lambda path: net_words(
                path,
                self.wishes,
                self.view.projection,
                contours.method,
                contours.contouring,
                notation,
                style,
                self._source.colors_of(ids, style),
                fold,
            ),
        )

    def for_print(self) -> NetContents | RoseContents:
        """The contents for a printed figure: with a title, and without selection."""
        project, frame = self._studio.project, self._studio.frame_name()
        title = "" if project.untitled else project.name
        notes = (frame,) if frame else ()
        if self.wishes.view != "net":
            roses = self.rose_contents()
            return replace(
                roses, title=title, notes=(*roses.notes, *self.wishes.turning.notes, *notes)
            )
        net = self.contents().replace_selection(())
        return replace(net, title=title, notes=(*net.notes, *notes), compact=False, live=None)

    def redraw(self) -> None:
        """Draw the net anew, unless it is hidden; it is then drawn when it is painted next."""
        # Behind another tab nobody sees it (Qt calls it visible): it is drawn when it is painted.
        self._stale = self.canvas.visibleRegion().isEmpty()
        if self._stale or self.canvas.width() < 50 or self.canvas.height() < 50:
            return
        start = perf_counter()
        self._allow_buttons()
        dark = self.palette().color(QPalette.ColorRole.Window).lightness() < 128
        net, beds = self._without_fold() if self.wishes.view == "net" else (NetContents(), None)
        many = _many(net)
        style = NetStyle.dock(dark=dark, dpi=DPI, font_px=_FONT_PX)
        size = (self.canvas.width(), self.canvas.height())
        wanted = Wanted(net, style, size, self.canvas.devicePixelRatioF(), beds)
        if self.wishes.view != "net":
            self._background.cancel(_NET)
            self._draw_roses(wanted)
        elif many:
            draw = partial(DrawnNet.of, wanted)
            self._background.run(draw, partial(self._drawn, wanted), key=_NET)
        else:
            self._background.cancel(_NET)
            self._show(DrawnNet.of(wanted))
        took = 1000.0 * (perf_counter() - start)
        # With many features a change of one is on the outcrop before it is on the net.
        slow = took > _QUICK_MS or many
        self._timer.setInterval(min(_LATEST_MS, int(5 * took)) if slow else _SOON_MS)

    def _allow_buttons(self) -> None:
        """What belongs to a net can be chosen while one is shown, and says so else."""
        of_net = self.wishes.view == "net"
        for button in self._of_net:
            what = button.accessibleName()
            button.setEnabled(of_net)
            button.setToolTip(what if of_net else Finding("net.only", what=what).message)
        self._under.setVisible(of_net)

    def _drawn(self, wanted: Wanted, net: DrawnNet) -> None:
        """The thread has drawn a net."""
        if wanted.contents.selected != frozenset(self._studio.selection.ids):
            self._emphasise_in(net)
        net.artists.show_live(self._source.live())
        self._show(net)

    def _emphasise_in(self, net: DrawnNet) -> None:
        net.artists.select(self._studio.selection.ids, self._source.of_current())

    def _draw_roses(self, wanted: Wanted) -> None:
        contents = self.rose_contents()
        self._net = self._roses = None
        if contents.roses:
            self._roses = DrawnRoses.of(contents, wanted)
            self.canvas.show_net(self._roses)
        elif contents.of in LINE_ANGLES:
            self.canvas.say(tr("No visible lines with such an angle."))
        else:
            self.canvas.say(tr("No visible planes with such an angle."))
        self._show_selected()

    def _show_live(self) -> None:
        """The feature that is being picked has changed."""
        if self._net is None or not self.up_to_date or self._stale:
            return
        live = self._source.live()
        if live is not None or self._net.artists.contents.live is not None:
            self._net.artists.show_live(live)
            self.canvas.show_net(self._net)

    def _show(self, net: DrawnNet) -> None:
        self._net, self._roses = net, None
        self.canvas.show_net(net)
        self._show_selected()

    def _select(self) -> None:
        if self._studio.fold.selected:
            self._soon()
        if self._net is not None and _many(self._net.artists.contents):
            # The table and the outcrop come first.
            self._emphasis.start()
        else:
            self._emphasise()

    def _emphasise(self) -> None:
        if self._net is not None and self.up_to_date:
            self._emphasise_in(self._net)
            self.canvas.show_net(self._net)
        self._show_selected()

    # --- pointing ----------------------------------------------------------------------------
    def _pressed(self, event: QMouseEvent, x: float, y: float) -> None:
        self._path = [(x, y)]
        self.canvas.lasso = [event.position()]

    def _moved(self, x: float, y: float) -> None:
        if self._path:
            self._path.append((x, y))
            if self._is_lasso():
                self.canvas.update()
            return
        line = self.artists.line_at(x, y) if self.artists else None
        if line is None:
            self._show_selected()
        else:
            self._under.setText(format_line(line, 0))
            self._place_under()

    def _is_lasso(self) -> bool:
        (x0, y0), scale = self._path[0], self.canvas.devicePixelRatioF()
        return not all(is_click((x - x0) / scale, (y - y0) / scale) for x, y in self._path)

    def _released(self, event: QMouseEvent, x: float, y: float) -> None:
        if not self._path:
            return
        path, is_lasso = self._path, self._is_lasso()
        self._path, self.canvas.lasso = [], []
        self.canvas.update()
        adding = bool(
            event.modifiers()
            & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
        )
        selection = self._studio.selection
        if self.roses is not None and not is_lasso:
            here = self.roses.features_at(x, y)
            selection.set([*selection.ids, *here] if adding else here)
            return
        if self.artists is None:
            return
        if is_lasso:
            inside = self.artists.features_within(path)
            # In the order of the records, so that the current one does not hang on chance.
            found = [f.id for f in self._studio.session.features() if f.id in inside]
            selection.set([*selection.ids, *found] if adding else found)
            return
        at = self.artists.feature_at(x, y, 8.0 * self.canvas.devicePixelRatioF())
        if at is not None and adding:
            selection.toggle(at)
        elif not adding:
            selection.set([] if at is None else [at])

    def _show_selected(self) -> None:
        """Name what is selected, in the corner where the direction under the cursor is shown."""
        ids = self._studio.selection.ids
        shown = self.artists.contents if self.artists else None
        known = {i for s in shown.sets for i in s.ids} if shown and ids else set()
        if self.roses is not None:
            known = {i for c in self.roses.contents.counted.values() for i in c.ids}
        here = [i for i in ids if i in known]
        record = self._studio.records.get(here[-1]) if here else None
        if len(here) > 1:
            text = tr("{count:,} selected", count=len(here))
        elif isinstance(record, Typed):
            measured = self._studio.measured([record.id])[record.id]
            said = orientation_text(measured, self._studio.settings.notation)
            text = f"{record.name}\n{said}"
        else:
            text = ""
        self._under.setText(text)
        self._place_under()


def _many(net: NetContents) -> bool:
    return sum(map(len, net.sets)) > _MANY


def _local() -> str:
    return tr("Local frame: azimuths are from the model's y axis, not from north")
