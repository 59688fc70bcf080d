"""Commands that export the stereonet and import field measurements."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QMimeData, Qt
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtWidgets import QFileDialog, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.project import edits, reading_comparison
from vomstudio.project.records import Model
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_to_screen
from vomstudio.ui.panels.net.figure_export import NetDock, load_figure_style, write_net_figure
from vomstudio.ui.widgets.figure_file import choose_figure_file

if TYPE_CHECKING:
    from vomstudio.project.imports.field_table import FieldTable
    from vomstudio.ui.dialogs.readings_dialog import ProjectLocation


DEFAULT_CONTOUR_METHOD = "exponential_kamb"


def commands(
    studio: Studio,
    find_net: Callable[[], NetDock | None],
    parent: QWidget,
    dialogs: OpenDialogs,
    toggle_center: Callable[[str], None],
    show_net: Callable[[], None],
) -> list[Command]:
    """Create the commands that export the stereonet and import field measurements.

    Parameters
    ----------
    studio : Studio
    find_net : callable
        Returns the stereonet, or None until its library is loaded.
    parent : QWidget
    dialogs : OpenDialogs
    toggle_center : callable
        Moves a dock to the centre in place of the outcrop, or back.
    show_net : callable
        Brings the stereonet to the front.
    """

    def missing_net_finding() -> Finding | None:
        empty_net_finding = None if studio.session.features() else Finding("action.net-empty")
        return net_loading_finding() or empty_net_finding

    def export() -> None:
        if (panel := find_net()) is not None:
            choose_net_file(parent, studio, panel)

    def copy() -> None:
        if (panel := find_net()) is not None:
            copy_net(studio, panel)

    def draw_on_net() -> None:
        from vomstudio.ui.dialogs.net_drawing_dialog import NetDrawingDialog

        if (panel := find_net()) is not None:
            dialogs.show(
                NetDrawingDialog, lambda: NetDrawingDialog(parent, studio, panel.view_settings)
            )

    def choose_style() -> None:
        from vomstudio.ui.dialogs.figure_style_dialog import FigureStyleDialog

        if (panel := find_net()) is not None:
            dialogs.show(
                FigureStyleDialog, lambda: FigureStyleDialog(parent, studio, panel), is_general=True
            )

    def net_loading_finding() -> Finding | None:
        return None if find_net() else Finding("action.net-loading")

    def toggle_rose() -> None:
        if (panel := find_net()) is not None:
            is_rose_shown = studio.settings.net_view == "strike"
            panel.view_settings.show_view("net" if is_rose_shown else "strike", "")
            show_net()

    def toggle_contours() -> None:
        studio.settings.contour = "" if studio.settings.contour else DEFAULT_CONTOUR_METHOD
        studio.keep_settings()
        show_net()

    return [
        Command(
            "type_on_net",
            tr("Draw and rotate…"),
            draw_on_net,
            icon="pencil-ruler",
            tip=tr("Draw great and small circles, rotate the data, set contour levels."),
            disabled_reason=net_loading_finding,
        ),
        Command(
            "figure_style",
            tr("Figure style…"),
            choose_style,
            icon="palette-outline",
            tip=tr("Set size, font, symbols and colours of net and rose figures."),
            disabled_reason=net_loading_finding,
        ),
        Command(
            "rose_diagram",
            tr("Rose diagram"),
            toggle_rose,
            icon="chart-donut-variant",
            tip=tr("Switch between the rose diagram of strikes and the net."),
            disabled_reason=net_loading_finding,
            is_checked=lambda: studio.settings.net_view == "strike",
        ),
        Command(
            "net_contours",
            tr("Net contours"),
            toggle_contours,
            icon="chart-bell-curve-cumulative",
            tip=tr("Contour the density of poles and lines, or remove the contours."),
            disabled_reason=net_loading_finding,
            is_checked=lambda: bool(studio.settings.contour),
        ),
        Command(
            "net_in_middle",
            tr("Stereonet in centre"),
            lambda: toggle_center("stereonet"),
            icon="fit-to-page-outline",
            shortcut="Shift+F9",
            tip=tr("Show the stereonet in place of the outcrop, or put it back."),
        ),
        Command(
            "import_readings",
            tr("Import &field measurements…"),
            lambda: choose_readings(parent, studio),
            icon="compass-outline",
            tip=tr("Import compass readings and compare them with the picked planes."),
        ),
        Command(
            "export_net",
            tr("Export stereo&net…"),
            export,
            icon="export-variant",
            tip=tr("Export the stereonet as SVG, PDF or PNG."),
            disabled_reason=missing_net_finding,
        ),
        Command(
            "copy_net",
            tr("&Copy stereonet figure"),
            copy,
            icon="content-copy",
            tip=tr("Copy the stereonet to the clipboard as SVG and picture."),
            disabled_reason=missing_net_finding,
        ),
    ]


# --- field measurements ----------------------------------------------------------------------
def choose_readings(parent: QWidget, studio: Studio) -> None:
    """Ask for a table and import the readings it contains."""
    name, _ = QFileDialog.getOpenFileName(
        parent,
        tr("Import field measurements"),
        start_folder(studio),
        file_filters.tables(),
    )
    if name:
        import_readings(parent, studio, Path(name))


def import_readings(parent: QWidget, studio: Studio, path: Path) -> None:
    """Ask for the meaning of the columns and add the readings as features.

    Layers and workbooks are read in a worker thread.
    """
    from vomstudio.io.gate.orientation_files import is_layer_file
    from vomstudio.project.imports.field_table import read_field_table

    if is_layer_file(path):
        QtBackground(parent).run(
            lambda: read_field_table(path),
            lambda table: _ask_for_columns(parent, studio, table),
            studio.fail,
        )
        return
    try:
        table = read_field_table(path)
    except VomError as error:
        studio.fail(error)
    else:
        _ask_for_columns(parent, studio, table)


def _ask_for_columns(parent: QWidget, studio: Studio, table: FieldTable) -> None:
    from vomstudio.ui.dialogs.readings_dialog import ReadingsDialog

    dialog = ReadingsDialog(
        parent, table, dict(studio.records), project_location(studio), type_id=studio.next_type_id
    )
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)

    def add_readings() -> None:
        ids = [reading.id for reading in dialog.readings]
        if studio.attempt(edits.add_readings, dialog.readings, dialog.types):
            studio.selection.set(ids)
            if dialog.types:
                names = [feature_type.name for feature_type in dialog.types]
                studio.info(Finding("reading.new-types", types=names))
            picks = {i: pick for i in ids if (pick := studio.nearest_pick(i)) is not None}
            studio.info(reading_comparison.summary(ids, picks))

    dialog.accepted.connect(add_readings)
    fit_to_screen(dialog)
    dialog.open()


def project_location(studio: Studio) -> ProjectLocation:
    """Return the CRS of the project and the centre of its open models in the World frame.

    The CRS is returned only if all models that have a CRS share it. The centre is computed from the
    models in which north is known, and is missing if there are no such models.
    """
    from vomstudio.ui.dialogs.readings_dialog import ProjectLocation

    models = studio.session.of(Model)
    codes = {m.frame.crs for m in models if m.frame.kind == "crs"}
    crs = codes.pop() if len(codes) == 1 else None
    corners = [
        transform.apply(m.to_world, studio.models[m.id].data.bounds)
        for m in models
        if m.id in studio.models and m.frame.has_north
    ]
    if not corners:
        return ProjectLocation(crs)
    x, y, _ = np.concatenate(corners).mean(axis=0)
    return ProjectLocation(crs, float(x), float(y), True)


# --- figure of the net -----------------------------------------------------------------------
def choose_net_file(parent: QWidget, studio: Studio, panel: NetDock) -> None:
    """Ask for a file and write the stereonet to it."""
    path = choose_figure_file(parent, studio, tr("Export stereonet"), "stereonet")
    if path is not None:
        export_net(studio, panel, path)


def copy_net(studio: Studio, panel: NetDock) -> None:
    """Copy the stereonet to the clipboard as SVG and as an image."""
    images = {}
    try:
        net_contents = panel.printable_contents()
        for format_ in ("svg", "png"):
            data = io.BytesIO()
            write_net_figure(data, net_contents, load_figure_style(studio), format_)
            images[format_] = data.getvalue()
    except VomError as error:
        studio.fail(error)
        return
    mime = QMimeData()
    mime.setImageData(QImage.fromData(images["png"]))
    mime.setData("image/svg+xml", images["svg"])
    QGuiApplication.clipboard().setMimeData(mime)
    studio.info(Finding("net.copied"))


def export_net(studio: Studio, panel: NetDock, path: Path) -> None:
    """Write the stereonet on a white background at the size of a printed figure."""
    from vomstudio.core.files.atomic import atomic_write

    try:
        net_contents = panel.printable_contents()
        format_ = path.suffix.lower().removeprefix(".")
        with atomic_write(path, True) as temporary_path:
            write_net_figure(Path(temporary_path), net_contents, load_figure_style(studio), format_)
    except VomError as error:
        studio.fail(error)
    else:
        studio.written(path)
