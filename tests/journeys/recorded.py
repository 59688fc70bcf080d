"""A session that can be killed: it says on stdout what is on the screen after every event.

Run as `python -m tests.journeys.recorded MODE`: `studio` does the work without a viewport and
without worker processes, `window` with mouse and keys in the real window. With `--named FOLDER` the
project gets a name first. With `--step` it waits for a line on stdin before every event.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.samples import ZIGZAG
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import IDENTITY
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.control.points import ControlPoint
from vomstudio.project import edits
from vomstudio.project.assets import asset_path, store_asset
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.photo_edits import add_photo_set, add_reconstruction
from vomstudio.project.records import (
    ImageMark,
    MarkedPoint,
    Mask,
    Model,
    PhotoSet,
    ReconstructionRecord,
)
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.line import LineTool
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.studio.tools.trace import TraceTool

Event = tuple[str, Callable[[], object]]

LAST = "save beside an area"


def on_screen(studio: Any) -> dict[str, Any]:
    """What a person sees of the document, without the ids, which are new in every run."""
    tool = studio.open_tool
    feature = getattr(tool, "feature", None)
    chosen = getattr(tool, "selection", None)
    return {
        "traces": [
            [
                t.name,
                t.type_id,
                t.set_name,
                t.notes,
                t.overturned,
                t.method,
                [list(v) for v in t.vertices],
            ]
            for t in studio.session.of(Trace)
        ],
        "chosen": None if chosen is None else chosen.ids().tolist(),
        "patches": [
            [p.name, p.type_id, p.n, p.area, [list(r) for r in p.runs]]
            for p in studio.session.of(Patch)
        ],
        "models": [
            [
                m.name,
                m.frame.kind,
                m.frame.crs,
                m.content_hash,
                m.registration.name if m.registration else "",
                [list(row) for row in m.to_world],
            ]
            for m in studio.session.of(Model)
        ],
        "photos": [[s.name, s.path, s.crs] for s in studio.session.of(PhotoSet)],
        "points": sorted(
            [p.label, list(p.position or ()), p.sigma_m, p.check]
            for p in studio.session.of(MarkedPoint)
        ),
        "marks": sorted(
            [studio.records[m.point_id].label, m.photo, m.x, m.y]
            for m in studio.session.of(ImageMark)
        ),
        "masks": sorted(
            [m.photo, asset_path(studio.project.folder, m.file).read_bytes().decode()]
            for m in studio.session.of(Mask)
        ),
        "reconstructions": [
            [r.name, r.folder, r.registered] for r in studio.session.of(ReconstructionRecord)
        ],
        "registrations": [
            [r.name, r.method, [list(row) for row in r.matrix]]
            for r in studio.session.of(Registration)
        ],
        "lines": [
            [
                f.name,
                f.type_id,
                f.slip,
                studio.records[f.plane_id].name if f.plane_id else "",
                [list(v) for v in f.vertices],
            ]
            for f in studio.session.of(Lineation)
        ],
        "dimensions": [
            [d.name, d.kind, [list(v) for v in d.vertices]] for d in studio.session.of(Dimension)
        ],
        "draft": [list(v) for v in getattr(tool, "vertices", ())] if tool else None,
        "draft_of": [
            tool.name,
            getattr(feature, "type_id", ""),
            getattr(feature, "slip", ""),
            getattr(feature, "kind", ""),
            tool.is_continued,
        ]
        if tool
        else None,
        "dirty": studio.session.dirty,
        "undo": studio.session.undo_label,
        "redo": studio.session.redo_label,
    }


def announce(name: str, studio: Any) -> None:
    print(json.dumps({"event": name, "screen": on_screen(studio)}), flush=True)


# --- without a viewport --------------------------------------------------------------------------
def make_studio() -> Any:
    from vomstudio.io.settings import Settings
    from vomstudio.ui.base.studio import Studio

    studio = Studio(Settings())
    studio.jobs.close()
    return studio


def sheet() -> Mesh:
    """A rough strip of 40 squares by 40."""
    x, y = np.meshgrid(np.arange(41) / 10, np.arange(41) / 10)
    z = 0.3 * x + 0.01 * np.sin(40 * x) * np.cos(30 * y)
    i = np.arange(41 * 41).reshape(41, 41)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return Mesh(np.column_stack([x.ravel(), y.ravel(), z.ravel()]), faces.astype(np.int32))


def bed(shift: float) -> list[tuple[float, float, float]]:
    return [(x, y, z + shift) for x, y, z in ZIGZAG]


def studio_events(studio: Any, outcrop: Path) -> list[Event]:
    frame = Frame("local")
    model = Model("m1", "cliff", str(outcrop), "mesh", "0" * 64, placement=Frame())
    tool = studio.get_tool(TraceTool)
    # The only model that a studio without workers has.
    studio.models["m1"] = SimpleNamespace(surface=create_surface(sheet()))

    def brush(x: float, **keys: bool) -> None:
        for kind, length in ((Pointer.DRAG_START, 0.0), (Pointer.DRAG_END, 0.4)):
            face = int((x + length) * 10)
            place = studio.models["m1"].surface.corners(np.array([face]))[0].mean(axis=0)
            hit = Hit("m1", "face", face, (float(place[0]), float(place[1]), float(place[2])))
            studio.pointer(PointerEvent(kind, 0, 0, Button.LEFT, hit=hit, **keys))

    def click(point: tuple[float, float, float], **more: Any) -> Event:
        made = PointerEvent(
            Pointer.CLICK, 0, 0, Button.LEFT, hit=Hit("m1", "face", 0, point), **more
        )
        return "click", lambda: studio.pointer(made)

    def trace() -> str:
        return studio.session.of(Trace)[-1].id

    def move() -> None:
        for kind, y in (
            (Pointer.DRAG_START, 0.0),
            (Pointer.DRAG_MOVE, 0.3),
            (Pointer.DRAG_END, 0.4),
        ):
            studio.pointer(
                PointerEvent(
                    kind, 0, 0, Button.LEFT, hit=Hit("m1", "face", 0, (1.0, y, 0.5)), handle=1
                )
            )

    def save() -> None:
        # Saving a project without a name gives it one, in the window.
        if not studio.project.is_untitled:
            studio.session.save()

    attempt = studio.attempt
    return [
        ("open model", lambda: attempt(edits.add_model, model)),
        ("declare frame", lambda: attempt(edits.declare_frame, "m1", frame)),
        ("trace tool", lambda: studio.activate("trace")),
        *(click(p) for p in bed(0.0)),
        ("finish", tool.finish),
        *(click(p) for p in bed(1.0)[:4]),
        ("take back", studio.undo),
        ("move", move),
        click((1.5, 0.0, 1.7), ctrl=True),
        ("delete vertex", lambda: tool.delete_vertex(0)),
        ("type", lambda: studio.set_next_type("fault", "F")),
        click(bed(1.0)[4]),
        ("finish", tool.finish),
        ("undo", studio.undo),
        ("redo", studio.redo),
        ("plane tool", lambda: studio.activate("plane")),
        ("stroke", lambda: brush(1.0)),
        ("stroke", lambda: brush(2.0, shift=True)),
        ("take away", lambda: brush(1.5, ctrl=True)),
        ("undo", studio.undo),
        ("finish", studio.finish_tool),
        ("stroke", lambda: brush(0.5)),
        ("give up", studio.cancel_tool),
        ("trace tool", lambda: studio.activate("trace")),
        ("name", lambda: attempt(edits.set_attributes, [trace()], name="main fault")),
        ("notes", lambda: attempt(edits.set_attributes, [trace()], notes="slickensides")),
        ("delete", lambda: attempt(edits.delete, [trace()])),
        ("save", save),
        ("undo", studio.undo),
        ("continue", lambda: tool.continue_feature(trace())),
        click((4.5, 0.4, 3.1)),
        ("cancel", tool.cancel),
        ("continue", lambda: tool.continue_feature(trace())),
        click((4.5, 0.4, 3.1)),
        ("finish", tool.finish),
        click(bed(2.0)[0]),
        click(bed(2.0)[1]),
        (
            "rename beside a draft",
            lambda: attempt(edits.set_attributes, [trace()], set_name="late"),
        ),
        ("save beside a draft", save),
        ("cancel", tool.cancel),
        ("line tool", lambda: studio.activate("line")),
        ("on a plane", lambda: studio.get_tool(LineTool).choose(plane_id=trace(), slip="normal")),
        *(click(p) for p in bed(3.0)[:3]),
        ("take back", studio.undo),
        ("slip", lambda: studio.get_tool(LineTool).choose(slip="dextral")),
        ("finish", studio.finish_tool),
        ("measure tool", lambda: studio.activate("measure")),
        *(click(p) for p in bed(3.0)[:2]),
        ("area", lambda: studio.get_tool(MeasureTool).choose(kind="area")),
        *(click(p) for p in bed(3.0)[:3]),
        ("finish", studio.finish_tool),
        ("undo", studio.undo),
        click(bed(3.0)[3]),
        *photo_events(studio),
        (LAST, save),
    ]


def photo_events(studio: Any) -> list[Event]:
    """What a model rests on, as the windows of photos change it."""
    from vomstudio.ui.panels.photos.photo_document import PhotoDocument

    document = PhotoDocument(studio)
    wall = PhotoSet("photos-1", "wall", "/geologist/wall", "EPSG:32633")
    run = ReconstructionRecord("run-1", wall.id, "wall", "wall-low", "low", "0" * 64, (), 9, 8, 0.4)
    found = Registration("r-1", "control points, wall", "control", Frame("crs", "EPSG:32633"))
    east = ((1.0, 0.0, 0.0, 250.0), *IDENTITY[1:])

    def add() -> None:
        studio.attempt(add_photo_set, wall)
        document.set_folder(Path(wall.path))

    def mark(label: str, x: float, join: str | None = None) -> None:
        made = document.marking().set_mark(label, "a.jpg", (x, 7.0))
        document.set_marking(f"Mark {label}", made, join)

    def place(label: str, height: float) -> None:
        point = ControlPoint(label, (4e5, 5e6, height), 0.02)
        document.set_marking(f"Coordinates of {label}", document.marking().set_coordinates(point))

    def mask(*photos: str) -> None:
        file = store_asset(studio.project.folder, f"mask of {photos}".encode(), ".png")
        document.set_masks("Leave out", dict.fromkeys(photos, file))

    return [
        ("photos", add),
        ("control point", lambda: place("P1", 120.0)),
        ("mark", lambda: mark("P1", 10.0)),
        ("nudge", lambda: mark("P1", 10.1, "nudged")),
        ("nudge", lambda: mark("P1", 10.2, "nudged")),
        ("undo", studio.undo),
        ("redo", studio.redo),
        ("tie point", lambda: mark("tie1", 33.0)),
        (
            "rename",
            lambda: document.set_marking(
                "Rename tie1", document.marking().rename_point("tie1", "corner")
            ),
        ),
        ("mask", lambda: mask("a.jpg")),
        ("mask", lambda: mask("a.jpg", "b.jpg")),
        ("undo", studio.undo),
        (
            "remove point",
            lambda: document.set_marking(
                "Remove corner", document.marking().remove_point("corner")
            ),
        ),
        ("undo", studio.undo),
        ("make model", lambda: studio.attempt(add_reconstruction, run, found)),
        ("register", lambda: studio.attempt(edits.set_registration, found, ["m1"])),
        (
            "register anew",
            lambda: studio.attempt(edits.set_registration, replace(found, matrix=east)),
        ),
        ("undo", studio.undo),
        ("redo", studio.redo),
    ]


# --- the whole window ---------------------------------------------------------------------------
def window_events(window: Any, picks: dict[str, np.ndarray]) -> list[Event]:
    from PySide6.QtCore import Qt

    from tests import driver

    def key(code: Any, modifier: Any = driver.NONE) -> Callable[[], None]:
        return lambda: driver.key(window, code, modifier)

    def look() -> None:
        driver.look_at(window, np.concatenate(list(picks.values())), 0.0, 10.0)

    def clicks(name: str) -> list[Event]:
        return [("click", lambda p=p: driver.pick(window, p[None])) for p in picks[name][3:23:5]]

    return [
        ("look", look),
        ("trace tool", key(Qt.Key.Key_T)),
        *clicks("B03"),
        ("finish", key(Qt.Key.Key_Return)),
        ("undo", key(Qt.Key.Key_Z, driver.CTRL)),
        ("redo", key(Qt.Key.Key_Y, driver.CTRL)),
        *clicks("B04")[:3],
        ("take back", key(Qt.Key.Key_Backspace)),
    ]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("mode", choices=["studio", "window"])
    parser.add_argument("--named", type=Path)
    parser.add_argument("--models", type=Path)
    parser.add_argument("--step", action="store_true")
    args = parser.parse_args()
    from vomstudio.core.paths import resource

    outcrop = resource("outcrop", "outcrop.obj")
    if args.mode == "studio":
        from PySide6.QtCore import QCoreApplication

        application = QCoreApplication([])
        studio = make_studio()
        studio.new_project()
        events = studio_events(studio, outcrop)
    else:
        from PySide6.QtWidgets import QApplication

        from tests import driver
        from tests.journeys.conftest import bare_outcrop, read_picks

        application = QApplication([])
        window = driver.make_window()
        studio = window.studio
        driver.open_outcrop(window, bare_outcrop(args.models))
        events = window_events(window, read_picks())
    if args.named:
        studio.project.save_as(args.named)
    announce("begin", studio)
    for name, do in events:
        if args.step:
            sys.stdin.readline()
        do()
        application.processEvents()
        announce(name, studio)
    sys.stdin.readline()


if __name__ == "__main__":
    main()
