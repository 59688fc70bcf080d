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
from vomstudio.ui.base.long_boxes import fit_to_screen
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.figure_export import NetDock, style_of, write_shown
from vomstudio.ui.widgets.figure_file import ask_for_figure_file

if TYPE_CHECKING:
    from vomstudio.ui.dialogs.readings_dialog import Place


def commands(
    studio: Studio,
    net: Callable[[], NetDock | None],
    parent: QWidget,
    dialogs: OpenDialogs,
    fill_middle: Callable[[str], None],
) -> list[Command]:
    """net : None until its library is there. parent : of the dialogs. fill_middle : gives a dock
    the place of the outcrop, or puts it back"""

    def no_net() -> Finding | None:
        empty = None if studio.session.features() else Finding("action.net-empty")
        return not_loaded() or empty

    def export() -> None:
        if (panel := net()) is not None:
            choose_picture(parent, studio, panel)

    def copy() -> None:
        if (panel := net()) is not None:
            copy_net(studio, panel)

    def type_in() -> None:
        from vomstudio.ui.dialogs.net_drawing_dialog import NetTypingDialog

        if (panel := net()) is not None:
            dialogs.show(NetTypingDialog, lambda: NetTypingDialog(parent, studio, panel.wishes))

    def style() -> None:
        from vomstudio.ui.dialogs.figure_style_dialog import FigureStyleDialog

        if (panel := net()) is not None:
            dialogs.show(FigureStyleDialog, lambda: FigureStyleDialog(parent, studio, panel))

    def not_loaded() -> Finding | None:
        return None if net() else Finding("action.net-loading")

    return [
        Command(
            "type_on_net",
            tr("Draw and turn on the net…"),
            type_in,
            "pencil-ruler",
            (),
            tr("Type great and small circles, lines on planes, a turning, levels."),
            not_loaded,
        ),
        Command(
            "figure_style",
            tr("Style of figures…"),
            style,
            "palette-outline",
            (),
            tr("Size, letters, symbols and colours of figures of nets and roses."),
            not_loaded,
        ),
        Command(
            "net_in_middle",
            tr("Stereonet in the middle"),
            lambda: fill_middle("stereonet"),
            "fit-to-page-outline",
            "Shift+F9",
            tr("Give the stereonet the place of the outcrop, or put it back."),
        ),
        Command(
            "import_readings",
            tr("Import &field measurements…"),
            lambda: choose_readings(parent, studio),
            "compass-outline",
            (),
            tr(
                "Import compass readings from a table and compare them "
                "with the planes picked on the model."
            ),
        ),
        Command(
            "export_net",
            tr("Export stereo&net…"),
            export,
            "export-variant",
            (),
            tr("The stereonet as a figure: SVG, PDF or PNG."),
            no_net,
        ),
        Command(
            "copy_net",
            tr("&Copy stereonet as a figure"),
            copy,
            "content-copy",
            (),
            tr(
                "The stereonet as a figure on the clipboard: drawing programs take it as SVG, "
                "others as a picture."
            ),
            no_net,
        ),
    ]


# --- field measurements ----------------------------------------------------------------------
def choose_readings(parent: QWidget, studio: Studio) -> None:
    """Ask for a table, and import its readings."""
    name, _ = QFileDialog.getOpenFileName(
        parent,
        tr("Import field measurements"),
        start_folder(studio),
        file_filters.tables(),
    )
    if name:
        import_readings(parent, studio, Path(name))


def import_readings(parent: QWidget, studio: Studio, path: Path) -> None:
    """Ask for the meaning of the columns, and add the readings as features."""
    from vomstudio.project.imports.field_table import read_field_table
    from vomstudio.ui.dialogs.readings_dialog import ReadingsDialog

    try:
        table = read_field_table(path)
    except VomError as error:
        studio.fail(error)
        return
    dialog = ReadingsDialog(
        parent, table, dict(studio.records), place_of(studio), type_id=studio.next_type_id
    )
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)

    def add() -> None:
        ids = [reading.id for reading in dialog.readings]
        if studio.attempt(edits.add_readings, dialog.readings, dialog.types):
            studio.selection.set(ids)
            picks = {i: found for i in ids if (found := studio.nearest_pick(i)) is not None}
            studio.info(reading_comparison.summary(ids, picks))

    dialog.accepted.connect(add)
    fit_to_screen(dialog)
    dialog.open()


def place_of(studio: Studio) -> Place:
    """The one CRS of the project's models, and the middle of those that are open."""
    from vomstudio.ui.dialogs.readings_dialog import Place

    models = studio.session.of(Model)
    codes = {m.frame.crs for m in models if m.frame.kind == "crs"}
    crs = codes.pop() if len(codes) == 1 else None
    corners = [
        transform.apply(m.to_world, studio.models[m.id].data.bounds)
        for m in models
        if m.id in studio.models and m.frame.has_north
    ]
    if not corners:
        return Place(crs)
    x, y, _ = np.concatenate(corners).mean(axis=0)
    return Place(crs, float(x), float(y), True)


# --- the net as a figure ---------------------------------------------------------------------
def choose_picture(parent: QWidget, studio: Studio, panel: NetDock) -> None:
    """Ask for a file, and write the stereonet to it."""
    path = ask_for_figure_file(parent, studio, tr("Export stereonet"), "stereonet")
    if path is not None:
        export_net(studio, panel, path)


def copy_net(studio: Studio, panel: NetDock) -> None:
    """What the stereonet shows, as `export_net` writes it, to the clipboard: SVG and a picture."""
    made = {}
    try:
        shown = panel.for_print()
        for format_ in ("svg", "png"):
            data = io.BytesIO()
            write_shown(data, shown, style_of(studio), format_)
            made[format_] = data.getvalue()
    except VomError as error:
        studio.fail(error)
        return
    mime = QMimeData()
    mime.setImageData(QImage.fromData(made["png"]))
    mime.setData("image/svg+xml", made["svg"])
    QGuiApplication.clipboard().setMimeData(mime)
    studio.info(Finding("net.copied"))


def export_net(studio: Studio, panel: NetDock, path: Path) -> None:
    """Write what the stereonet shows, on white, at the size of a printed figure."""
    from vomstudio.core.files.atomic import atomic_write

    try:
        shown = panel.for_print()
        format_ = path.suffix.lower().removeprefix(".")
        with atomic_write(path, True) as temporary:
            write_shown(Path(temporary), shown, style_of(studio), format_)
    except VomError as error:
        studio.fail(error)
    else:
        studio.info(Finding("export.written", file=path))
