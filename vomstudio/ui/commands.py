"""What the window can do, as one table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtWidgets import QInputDialog, QMessageBox

from vomstudio.document import edits
from vomstudio.document.records import FEATURES, Model
from vomstudio.errors import VomError
from vomstudio.tools.polyline import PolylineTool
from vomstudio.ui import (
    display_commands,
    feature_commands,
    in_photos_commands,
    line_commands,
    net_commands,
    ortho_dialog,
    patch_commands,
    photo_commands,
    survey_commands,
)
from vomstudio.ui.actions import Command
from vomstudio.ui.failure_notices import save_report
from vomstudio.ui.model_copying import copy_into_project

if TYPE_CHECKING:
    from vomstudio.ui.main_window import MainWindow

# (name, text, key, what the viewer looks toward)
_VIEWS = (
    ("top", "From above", "7"),
    ("north", "Looking North", "1"),
    ("east", "Looking East", "2"),
    ("south", "Looking South", "3"),
    ("west", "Looking West", "4"),
    ("bottom", "From below", "8"),
)

NOTHING_OPEN = "nothing is being picked"


def commands(w: MainWindow) -> list[Command]:
    return [
        *_files(w),
        *_edits(w),
        *_views(w),
        *_models(w),
        *_tools(w),
        *survey_commands.commands(w),
        *photo_commands.commands(w),
        *in_photos_commands.commands(w),
        *ortho_dialog.commands(w),
        *line_commands.commands(w),
        *patch_commands.commands(w),
        *net_commands.commands(w),
        *feature_commands.commands(w),
        *display_commands.commands(w),
        *_help(w),
    ]


def _files(w: MainWindow) -> list[Command]:
    studio = w.studio

    def no_features() -> str | None:
        return None if studio.session.features() else "there is nothing yet; pick a trace first"

    return [
        Command("new", "&New project", w.files.new_project, "file-outline", "Ctrl+N"),
        Command("open", "&Open model…", w.files.choose_model, "folder-open-outline", "Ctrl+O",
                "Meshes, clouds and height models; or drop a file onto the window"),
        Command("open_sample", "Try the sample outcrop", lambda: _open_sample(w),
                "image-filter-hdr", (), "A generated cliff whose bedding is known exactly"),
        Command("open_project", "Open &project…", w.files.choose_project, "folder-outline",
                "Ctrl+Shift+O"),
        Command("save", "&Save", w.files.save, "content-save-outline", "Ctrl+S",
                "Work is in the journal already; saving marks it and writes the GIS layers"),
        Command("save_as", "Save &as…", w.files.save_as, None, "Ctrl+Shift+S"),
        Command("export_csv", "Export &table…", lambda: w.files.export("csv"), "table-arrow-right",
                "Ctrl+E", "The orientation table as CSV, with every error and its reason",
                no_features),
        Command("export_gpkg", "Export &GIS layers…", lambda: w.files.export("gpkg"),
                "layers-outline", (), "Planes and traces as GeoPackage", no_features),
        Command("export_shp", "Export &shapefiles…", lambda: w.files.export("shp"), None, (),
                "Planes, traces and the rest as shapefiles, one for each layer", no_features),
        Command("export_dxf", "Export &DXF…", lambda: w.files.export("dxf"), None, (),
                "Planes, traces and the rest for CAD, a layer for each feature type", no_features),
        Command("quit", "&Quit", w.close, None, "Ctrl+Q"),
    ]  # fmt: skip


def _edits(w: MainWindow) -> list[Command]:
    studio = w.studio

    def chosen() -> list[str]:
        return [i for i in studio.selection.ids if isinstance(studio.records.get(i), FEATURES)]

    def none_chosen() -> str | None:
        return None if chosen() else "select a feature first"

    def can_undo() -> bool:
        tool = studio.open_tool
        return tool is not None and tool.can_undo

    def nothing_to_undo() -> str | None:
        if can_undo() or studio.session.undo_label:
            return None
        return "there is nothing to undo"

    def to_undo() -> str | None:
        if can_undo():
            return "The last step of what is being picked"
        return studio.session.undo_label

    def nothing_to_redo() -> str | None:
        return None if studio.session.redo_label else "there is nothing to redo"

    return [
        Command("undo", "&Undo", studio.undo, "undo", "Ctrl+Z", "", nothing_to_undo,
                what=to_undo),
        Command("redo", "&Redo", studio.redo, "redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "",
                nothing_to_redo, what=lambda: studio.session.redo_label),
        Command("delete", "&Delete features", studio.delete_selected, "delete-outline", (), "",
                none_chosen),
        Command("rename", "&Rename…", lambda: _rename(w), None, "F2", "", none_chosen),
        Command("select_all", "Select &all features",
                lambda: studio.selection.set(f.id for f in studio.session.features()),
                None, "Ctrl+A"),
        Command("find_command", "&Find a command…", lambda: _palette(w), "magnify", "Ctrl+K"),
    ]  # fmt: skip


def _views(w: MainWindow) -> list[Command]:
    studio = w.studio

    def no_viewport() -> str | None:
        return None if w.viewport is not None and studio.models else "open a model first"

    def none_chosen() -> str | None:
        if studio.measured(studio.selection.ids):
            return no_viewport()
        return "select a feature first"

    def toggle_orthographic() -> None:
        if w.viewport is not None:
            w.viewport.set_orthographic(not w.viewport.orthographic)

    def home() -> None:
        if w.viewport is not None:
            w.see_all()

    def view(name: str) -> Callable[[], None]:
        def look() -> None:
            if w.viewport is not None:
                w.viewport.standard_view(name)

        return look

    def notation(name: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.notation = name
            studio.keep_settings()

        return choose

    def is_notation(name: str) -> Callable[[], bool]:
        return lambda: studio.settings.notation == name

    def trackball() -> None:
        studio.settings.turntable = not studio.settings.turntable
        if w.viewport is not None:
            w.viewport.gestures.set_turntable(studio.settings.turntable)
        studio.keep_settings()

    table = [
        Command("home", "&Whole model", home, "home-outline", "Home", "",
                no_viewport, in_viewport=True),
        Command("frame_selection", "&Frame selection", w.frame_selection,
                "image-filter-center-focus", "F", "Bring the selected features into view",
                none_chosen, in_viewport=True),
        Command("orthographic", "&Orthographic", toggle_orthographic, "cube-outline", "O",
                "Without perspective: lengths across the view are true", no_viewport,
                in_viewport=True,
                checked=lambda: w.viewport is not None and w.viewport.orthographic),
        Command("trackball", "Turn about any &axis", trackball, None, (),
                "Off: the turntable keeps Z up", no_viewport,
                checked=lambda: not studio.settings.turntable),
        Command("only_outcrop", "Only the outcrop", w.show_only_outcrop, None, "F9",
                "Hide the panels, or bring them back"),
    ]  # fmt: skip
    table += [
        Command(f"view_{name}", text, view(name), None, key, "", no_viewport, in_viewport=True)
        for name, text, key in _VIEWS
    ]
    for name, text, value in (
        ("notation_dipdir", "Dip direction/dip (132/41)", "dipdir/dip"),
        ("notation_strike", "Strike/dip, right-hand rule (042/41)", "strike/dip"),
        ("notation_quadrant", "Quadrant (N42E 41SE)", "quadrant"),
    ):
        table.append(Command(name, text, notation(value), checked=is_notation(value)))
    return table


def _models(w: MainWindow) -> list[Command]:
    studio = w.studio

    def no_model() -> str | None:
        return None if studio.session.of(Model) else "open a model first"

    def cannot_copy() -> str | None:
        model = w.files.current_model()
        if model is None:
            return "open a model first"
        if studio.project.untitled:
            return "save the project first"
        if model.id not in studio.models:
            return "the model's file is not open"
        return None if Path(model.path).is_absolute() else "the model is in the project already"

    def copy() -> None:
        model = w.files.current_model()
        if model is not None:
            copy_into_project(w, model)

    def cannot_export() -> str | None:
        model = w.files.current_model()
        if model is None:
            return "open a model first"
        return None if model.id in studio.models else "the model's file is not open"

    def not_missing() -> str | None:
        model = w.files.current_model()
        if model is None:
            return "open a model first"
        return "the model's file is where it should be" if model.id in studio.models else None

    return [
        Command("declare_frame", "&Declare frame…", lambda: w.files.declare_frame(), "axis-arrow",
                (), "Up axis, unit, and CRS or local: what makes angles geographic", no_model),
        Command("locate", "&Locate file…", w.files.locate_model, "file-search-outline", (),
                "Say where the file of a model is now", not_missing),
        Command("copy_model", "&Copy into the project", copy, "content-copy", (),
                "The model, its materials, images and cameras, and its photos if wanted, so that "
                "the folder can be moved and zipped",
                cannot_copy),
        Command("export_model", "&Export model as…", w.files.export_model, "export", (),
                "In World, as OBJ, PLY, GLB, LAS/LAZ, XYZ, SHP or DXF", cannot_export),
        Command("remove_model", "&Remove model", w.files.remove_model, "close", (), "", no_model),
    ]  # fmt: skip


def _tools(w: MainWindow) -> list[Command]:
    studio = w.studio

    def picking() -> PolylineTool[Any] | None:
        """The open tool, where it picks vertices."""
        tool = studio.open_tool
        return tool if isinstance(tool, PolylineTool) else None

    def not_loaded() -> str | None:
        return None if studio.models else "open a model first"

    def cannot_finish() -> str | None:
        unfinished = studio.open_tool or studio.tool
        return NOTHING_OPEN if unfinished is None else unfinished.why_not_finish()

    def nothing_open() -> str | None:
        return NOTHING_OPEN if studio.open_tool is None else None

    def cannot_cancel() -> str | None:
        return None if studio.patch_tool.current is not None else nothing_open()

    def no_vertex() -> str | None:
        if (tool := picking()) is None:
            return NOTHING_OPEN
        if tool.current_vertex is None:
            return f"click a vertex of the open {tool.what} first"
        return None

    def to_continue() -> tuple[str, str] | None:
        """Id and tool of the last selected feature that was picked vertex by vertex."""
        for id_ in reversed(studio.selection.ids):
            for name, tool in studio.tools.items():
                if isinstance(tool, PolylineTool) and isinstance(
                    studio.records.get(id_), tool.record
                ):
                    return id_, name
        return None

    def cannot_continue() -> str | None:
        if studio.open_tool is not None:
            return "something is being picked: finish or cancel it first"
        return None if to_continue() else "select a trace, line or measurement first"

    def nothing_to_delete() -> str | None:
        if picking() is not None:
            return no_vertex()
        if any(isinstance(studio.records.get(i), FEATURES) for i in studio.selection.ids):
            return None
        return "select a feature first"

    def delete_vertex() -> None:
        if (tool := picking()) is not None:
            tool.delete_vertex()

    def delete() -> None:
        if picking() is not None:
            delete_vertex()
        else:
            studio.delete_selected()

    def back() -> None:
        if (unfinished := studio.open_tool) is not None:
            unfinished.undo()

    def continue_feature() -> None:
        found = to_continue()
        if found is None:
            return
        id_, name = found
        studio.activate(name)
        tool = studio.tools[name]
        try:
            if isinstance(tool, PolylineTool):
                tool.continue_feature(id_)
        except VomError as error:
            studio.fail(error)

    def no_beta() -> str | None:
        return w.view_panel.why_no_beta()

    def no_plane() -> str | None:
        return w.view_panel.why_no_plane()

    return [
        Command("navigate", "&Navigate", lambda: studio.activate("navigate"), "cursor-move", "N",
                "Turn, move and zoom; click a plane to select it", in_viewport=True,
                checked=lambda: studio.tool_name == "navigate"),
        Command("trace", "&Trace", lambda: studio.activate("trace"), "vector-polyline", "T",
                "Click along a bed, fault or fracture; its plane is fitted as you go",
                not_loaded, in_viewport=True, checked=lambda: studio.tool_name == "trace"),
        Command("finish", "Finish", studio.finish_tool, "check", ("Return", "Enter"),
                "Keep what is being picked", cannot_finish, in_viewport=True),
        Command("cancel", "Cancel", studio.cancel_tool, "close", "Esc",
                "Give up what is being picked; a continued one stays as it was", cannot_cancel,
                in_viewport=True),
        Command("continue_trace", "Continue", continue_feature, "vector-polyline-plus", (),
                "Take the selected trace, line or measurement up again: add, move, insert or "
                "delete vertices",
                cannot_continue),
        Command("delete_vertex", "Delete vertex", delete_vertex, "vector-polyline-remove", (),
                "The marked vertex of what is being picked (Del in the viewport)", no_vertex),
        Command("delete_here", "Delete what is marked or selected", delete, None, "Del",
                "The marked vertex of what is being picked, else the selected features",
                nothing_to_delete, in_viewport=True),
        Command("undo_click", "Take back the last click", back, None, "Backspace", "", nothing_open,
                in_viewport=True),
        Command("along_beta", "Look along &beta", lambda: w.view_panel.along_beta(), None, "B",
                "Orthographic view down the fold axis of the bedding", no_beta, in_viewport=True),
        Command("face_plane", "Face the &plane", lambda: w.view_panel.face(), None,
                "Shift+P",
                "Orthographic view at right angles to the selected plane", no_plane,
                in_viewport=True),
        Command("show_stereonet", "Show the &stereonet", lambda: w.docks["stereonet"].raise_()),
    ]  # fmt: skip


def _help(w: MainWindow) -> list[Command]:
    return [
        Command("shortcuts", "&Shortcuts", lambda: _shortcuts(w), "keyboard-outline", "F1"),
        Command("save_report", "Save a &report…", lambda: save_report(w), "file-alert-outline", (),
                "What went wrong, as a text that you can read before giving it to anybody"),
        Command("about", "&About VOM Studio", w.about),
    ]  # fmt: skip


def _open_sample(w: MainWindow) -> None:
    from vomstudio.io.sample import sample_model

    w.open_path(sample_model())


def _rename(w: MainWindow) -> None:
    chosen = [i for i in w.studio.selection.ids if isinstance(w.studio.records.get(i), FEATURES)]
    current = chosen[-1]
    before = w.studio.records[current].name
    name, accepted = QInputDialog.getText(w, "Rename", "Name", text=before)
    if accepted and name.strip() != before:
        w.studio.attempt(edits.set_attributes, [current], name=name.strip())


def _palette(w: MainWindow) -> None:
    from vomstudio.ui.palette import CommandPalette

    dialog = CommandPalette(w, w.actions_table)
    if dialog.exec() and dialog.chosen:
        w.actions_table.run(dialog.chosen)


def _shortcuts(w: MainWindow) -> None:
    rows = []
    for command in w.actions_table.commands():
        keys = ", ".join(k.toString() for k in w.actions_table.all[command.name].shortcuts())
        if keys:
            where = " (in the viewport)" if command.in_viewport else ""
            text = command.text.replace("&", "") + where
            rows.append(f"<tr><td><b>{keys}</b>&nbsp;&nbsp;</td><td>{text}</td></tr>")
    mouse = (
        "<p><b>Mouse</b>: drag orbits about the point under the cursor, wheel zooms to the cursor, "
        "middle button or Shift+drag pans, double click sets the pivot. While picking: click adds, "
        "drag a vertex moves it, Ctrl+click inserts, Enter or double click finishes. With the "
        "brush of Patch: drag paints, Ctrl+drag takes away, the right button orbits. "
        "On the net: click a pole or a great circle, drag a lasso around poles; Ctrl adds.</p>"
    )
    QMessageBox.information(w, "Shortcuts", f"<table>{''.join(rows)}</table>{mouse}")
