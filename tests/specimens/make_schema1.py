"""How the specimens of journal schema 1 were made, with the program that wrote that schema.

`python -m tests.specimens.make_schema1 FOLDER` plays a geologist's days at a small outcrop in
FOLDER, which must not be there yet, with the program's own session, tools and jobs, and puts what
they leave into this folder. The specimens have FOLDER's name in them: it was /geologist/outcrop.

It runs with the program of schema 1 only (git tag or commit in which `io/journal.py` says
SCHEMA_VERSION = 1) and is kept to tell what is in the specimens. They are never made again: they
stand for what users have on their disks.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
PHOTOS = ("HL_2041.jpg", "HL_2042.jpg", "HL_2050.jpg")
SHARE = 0.32
"""Of the sample's photos in width and height."""


def main() -> None:
    """Play the days, then keep what is small."""
    outcrop = Path(sys.argv[1])
    outcrop.mkdir(parents=True)
    state = outcrop.parent / f"{outcrop.name}-state"
    for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"):
        os.environ[name] = str(state / name)
    os.environ["VOMSTUDIO_SETTINGS"] = str(state / "settings.toml")

    from PySide6.QtCore import QCoreApplication
    from vomstudio.io.journal import SCHEMA_VERSION

    from vomstudio.io import image_store

    if SCHEMA_VERSION != 1:
        raise SystemExit("This program writes another schema; see the docstring.")
    image_store.folder = lambda: state / "images"
    application = QCoreApplication([])
    make_photos(outcrop / "photos")
    make_models(outcrop)
    days(outcrop, state)
    draft(outcrop, state)
    keep(outcrop)
    del application


# --- what the geologist comes with ----------------------------------------------------------------
def make_photos(folder: Path) -> None:
    """Three of the sample's photos, small, with control points, marks and the mask of one."""
    from PIL import Image
    from vomstudio.io.photo_masks import mask_place, write_mask
    from vomstudio.io.sample import sample_control, sample_marks, sample_photos

    from vomstudio.io.control import CONTROL, MARKS, read_control, read_marks, write_control
    from vomstudio.io.control import write_marks as write

    folder.mkdir()
    for name in PHOTOS:
        with Image.open(sample_photos() / name) as image:
            size = round(image.width * SHARE), round(image.height * SHARE)
            small = image.resize(size, Image.Resampling.LANCZOS)
            small.save(folder / name, quality=72, exif=image.getexif())
    write_control(folder / CONTROL, read_control(sample_control()), "EPSG:32633")
    marks = [
        replace(m, x=round(m.x * SHARE, 2), y=round(m.y * SHARE, 2))
        for m in read_marks(sample_marks())
        if m.photo in PHOTOS
    ]
    write(folder / MARKS, marks)
    used = np.ones((size[1], size[0]), bool)
    used[:40] = False
    used[40:60, 300:] = False
    write_mask(mask_place(folder / PHOTOS[1]), used)


def make_models(folder: Path) -> None:
    """`face.obj` with its cameras, `boulder.ply`, a cloud in feet with y up, and `block.ply`."""
    from PIL import Image
    from vomstudio.io.cameras_file import FILE_NAME, Cameras, write_cameras
    from vomstudio.io.sample import read_true_cameras, sample_model
    from vomstudio.io.writing import write_model

    from vomstudio.geometry.cameras import View
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Material, Mesh
    from vomstudio.io.models import read_model

    true = read_true_cameras()
    views = []
    for view in true.views:
        if view.name in PHOTOS:
            lens = view.intrinsics
            small = lens.scaled(round(lens.width * SHARE), round(lens.height * SHARE))
            views.append(View(view.name, small, view.rotation, view.translation))
    data = read_model(sample_model()).data
    vertices, faces = simplified(data.vertices, data.faces, 1500)
    vertices = np.round(vertices, 3)
    uv = seen_in(views[1], vertices - np.array(true.origin))
    with Image.open(folder / "photos" / PHOTOS[1]) as image:
        image.resize((240, 160)).save(folder / "face.jpg", quality=60)
    materials = (Material("face", folder / "face.jpg"),)
    mesh = Mesh(vertices, faces, materials, np.array([0, len(faces)], np.int64), uv)
    (folder / "drawn").mkdir()
    write_model(mesh, None, folder / "drawn" / "face.obj")
    (folder / "face.jpg").unlink()
    cameras = Cameras(tuple(views), folder / "photos", true.origin, "EPSG:32633", True)
    write_cameras(folder / "drawn" / FILE_NAME, cameras)

    chance = np.random.default_rng(11)
    x, z = chance.uniform(-3.0, 3.0, (2, 420))
    y = 0.7 * x - 0.2 * z + chance.normal(0.0, 0.02, 420)
    points = np.round(np.column_stack([x, y, z]), 3)
    grey = chance.integers(90, 180, 420).astype(np.uint8)
    write_model(PointCloud(points, np.repeat(grey[:, None], 3, 1)), None, folder / "boulder.ply")
    g = np.linspace(0.0, 2.0, 5)
    a, b = np.meshgrid(g, g)
    i = np.arange(25).reshape(5, 5)
    p, q, r, s = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    block = Mesh(
        np.column_stack([a.ravel(), b.ravel(), np.round(0.4 * a + 0.1 * b, 3).ravel()]),
        np.concatenate([np.stack([p, q, r], 1), np.stack([q, s, r], 1)]).astype(np.int32),
    )
    (folder / "lost").mkdir()
    write_model(block, None, folder / "lost" / "block.ply")


def simplified(vertices: Any, faces: Any, count: int) -> tuple[Any, Any]:
    """A mesh of about `count` triangles."""
    import open3d as o3d

    origin = np.floor(vertices.min(axis=0))
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(vertices - origin),
        o3d.utility.Vector3iVector(np.asarray(faces, np.int32)),
    )
    mesh.merge_close_vertices(1e-9)
    mesh = mesh.simplify_quadric_decimation(count)
    mesh.remove_unreferenced_vertices()
    return np.asarray(mesh.vertices) + origin, np.asarray(mesh.triangles).astype(np.int32)


def seen_in(view: Any, points: Any) -> Any:
    """Texture coordinates of points, by where they are in a photo."""
    lens = view.intrinsics
    u, v = (view.project(points) / (lens.width, lens.height)).T
    return np.clip(np.column_stack([u, 1.0 - v]), 0.0, 1.0).astype(np.float32)


# --- the days -------------------------------------------------------------------------------------
class NoJobs:
    """Stands where the worker processes are; nothing is ever loaded or written by itself."""

    def __getattr__(self, name: str) -> Any:
        return lambda *args, **values: []


class Geologist:
    """A studio without a screen, and the hand that clicks."""

    def __init__(self) -> None:
        from vomstudio.ui.studio import Studio

        from vomstudio.io.settings import Settings

        self.studio = Studio(Settings())
        self.studio.jobs.close()
        self.studio.jobs = NoJobs()
        self.studio.loader._jobs = NoJobs()

        def show(notice: Any) -> None:
            if notice.level in ("warning", "error"):
                print(f"  [{notice.level}] {notice.text}")

        self.studio.notice.connect(show)

    def bring(self, path: Path, name: str) -> str:
        """Open a model, whose data is here at once; its id."""
        made: list[str] = []
        opened = read(path)
        self.studio._add_opened(path, opened, name, None, made.append)
        return made[0]

    def attempt(self, make: Callable[..., Any], *args: Any, **values: Any) -> None:
        assert self.studio.attempt(make, *args, **values)

    def hit(self, model_id: str, point: Any) -> Any:
        from vomstudio.tools.interaction_types import Hit

        surface = self.studio.models[model_id].surface
        if surface.element == "point":
            places = surface.corners(np.arange(surface.count))
        else:
            places = surface.corners(np.arange(surface.count)).mean(axis=1)
        index = int(((places - np.asarray(point)) ** 2).sum(axis=1).argmin())
        place = tuple(float(value) for value in point)
        return Hit(model_id, surface.element, index, place)

    def click(self, model_id: str, points: Any, **more: Any) -> None:
        from vomstudio.tools.interaction_types import Button, Pointer, PointerEvent

        for point in points:
            hit = self.hit(model_id, point)
            self.studio.pointer(PointerEvent(Pointer.CLICK, 0, 0, Button.LEFT, hit=hit, **more))

    def drag_vertex(self, model_id: str, index: int, point: Any) -> None:
        from vomstudio.tools.interaction_types import Button, Pointer, PointerEvent

        for kind in (Pointer.DRAG_START, Pointer.DRAG_MOVE, Pointer.DRAG_END):
            hit = self.hit(model_id, point)
            self.studio.pointer(PointerEvent(kind, 0, 0, Button.LEFT, hit=hit, handle=index))

    def stroke(self, model_id: str, points: Any, *, ctrl: bool = False) -> None:
        from vomstudio.tools.interaction_types import Button, Pointer, PointerEvent

        kinds = [Pointer.DRAG_START, *[Pointer.DRAG_MOVE] * (len(points) - 2), Pointer.DRAG_END]
        for kind, point in zip(kinds, points, strict=True):
            hit = self.hit(model_id, point)
            self.studio.pointer(PointerEvent(kind, 0, 0, Button.LEFT, ctrl=ctrl, hit=hit))

    def trace(self, model_id: str, points: Any, type_id: str, set_name: str = "") -> str:
        """Pick a trace and finish it; its id."""
        self.studio.activate("trace")
        self.studio.set_next(type_id, set_name)
        self.click(model_id, points)
        made = self.studio.trace_tool.finish()
        assert made
        return made

    def line(self, model_id: str, points: Any, **values: str) -> str:
        self.studio.activate("line")
        self.studio.line_tool.choose(**values)
        self.click(model_id, points)
        made = self.studio.line_tool.finish()
        assert made
        return made

    def measure(self, model_id: str, points: Any, kind: str, plane_id: str = "") -> str:
        from vomstudio.document.records import Dimension

        self.studio.activate("measure")
        self.studio.measure_tool.choose(kind=kind, plane_id=plane_id)
        self.click(model_id, points)
        if self.studio.measure_tool.open:
            assert self.studio.measure_tool.finish()
        return self.studio.session.of(Dimension)[-1].id

    def undo(self, times: int = 1) -> None:
        for _ in range(times):
            self.studio.undo()

    def redo(self, times: int = 1) -> None:
        for _ in range(times):
            self.studio.redo()


def read(path: Path) -> Any:
    from vomstudio.ui.model_loader import OpenModel

    from vomstudio.geometry.streaming.surfaces import surface_of
    from vomstudio.io.models import read_model

    loaded = read_model(path)
    surface = surface_of(loaded.data)
    surface.build()
    return OpenModel(loaded.data, surface, loaded.warnings, None, loaded.crs, loaded.content_hash)


def picked(name: str, count: int) -> Any:
    """Some points of a pick of the sample, in its World."""
    from vomstudio.io.sample import read_picks

    picks = read_picks()
    points = picks.of(picks.names.index(name))
    return points[np.linspace(0, len(points) - 1, count).round().astype(int)]


def days(outcrop: Path, state: Path) -> None:
    """The project `schema1.vom`."""
    from vomstudio.io.model_copy import copy_model
    from vomstudio.io.readings import FieldRow, guess, make_readings, read_field_table, understand
    from vomstudio.ui.job_bridge import JobBridge
    from vomstudio.ui.make_settings import MakeSettings
    from vomstudio.ui.photo_survey import PhotoSurvey

    from vomstudio.document import edits
    from vomstudio.document.records import FeatureType, Frame, Group, Intersection, Lineation
    from vomstudio.io.control import (
        CONTROL,
        MARKS,
        read_control,
        read_marks,
        write_control,
        write_marks,
    )
    from vomstudio.jobs.run_job import run_job
    from vomstudio.jobs.tasks import write_layers
    from vomstudio.progress import Silent

    me = Geologist()
    studio = me.studio
    studio.new_project()
    face = me.bring(outcrop / "drawn" / "face.obj", "face")
    me.attempt(edits.declare_frame, face, Frame("local"))
    b01 = me.trace(face, picked("B01", 9), "bedding", "west limb")
    project_folder = outcrop / "schema1.vom"
    studio.project.save_as(project_folder)
    assert studio.project.folder == project_folder

    # Into the project, with cameras and photos; then it is told what its coordinates are.
    copy = copy_model(outcrop / "drawn" / "face.obj", project_folder / "models", photos=True)
    hash_ = studio.models[face].content_hash
    me.attempt(edits.relocate_model, face, studio.project.model_path(copy), hash_)
    me.attempt(edits.declare_frame, face, Frame("crs", "EPSG:32632"))
    me.attempt(edits.declare_frame, face, Frame("crs", "EPSG:32633"))

    me.trace(face, picked("B02", 8), "bedding", "west limb")
    b05 = me.trace(face, picked("B05", 10), "bedding", "crest")
    me.trace(face, picked("B06", 7), "bedding", "crest")
    b09 = me.trace(face, picked("B09", 9), "bedding", "middle limb")
    me.attempt(edits.set_attributes, [b05], method="regression")
    me.attempt(edits.set_attributes, [b09], overturned=True)
    f01 = me.trace(face, picked("F01", 14), "fault", "main")
    f03 = me.trace(face, picked("F03", 9), "fault", "main")
    me.attempt(edits.set_attributes, [f01], name="main fault")
    me.attempt(edits.set_attributes, [f03], method="regression", notes='=1+1; "Harnisch", 20°')
    j = [
        me.trace(face, picked(name, 6), "joint", name[:2])
        for name in ("J1-01", "J1-02", "J2-01", "J2-03", "J3-01", "J3-03")
    ]
    me.attempt(edits.delete, j[4:])
    me.undo()
    me.attempt(edits.delete, [j[5]])
    # Three points have no error of their own.
    three = me.trace(face, picked("B18", 3), "bedding")
    me.attempt(edits.set_attributes, [three], name="Ebene α", set_name="east limb")

    # A trace that is changed while it is picked, and after.
    studio.activate("trace")
    studio.set_next("contact", "")
    points = picked("B10", 6)
    me.click(face, points[:4])
    studio.undo()
    me.drag_vertex(face, 1, points[1] + (0.02, 0.01, 0.05))
    me.click(face, [0.5 * (points[0] + points[1])], ctrl=True)
    me.click(face, points[3:])
    studio.trace_tool.delete_vertex(0)
    contact = studio.trace_tool.finish()
    studio.trace_tool.continue_trace(contact)
    me.click(face, picked("B10", 37)[-3:-1])
    studio.trace_tool.finish()
    studio.trace_tool.continue_trace(contact)
    me.click(face, [points[2]])
    studio.trace_tool.cancel()

    # Feature types of one's own.
    shear = edits.suggest_type(studio.records, "Shear zone")
    me.attempt(edits.add_type, shear)
    line_type = edits.suggest_type(studio.records, "Slickenline", "line")
    me.attempt(edits.add_type, line_type)
    passing = edits.suggest_type(studio.records, "Stylolite")
    me.attempt(edits.add_type, passing)
    me.attempt(edits.change_type, replace(shear, name="Shear band", color="#123abc"))
    me.attempt(edits.remove_type, passing.id)
    me.attempt(edits.remove_type, "foliation")
    me.attempt(edits.add_type, FeatureType("foliation", "Schistosity", "#56b4e9", "pentagon"))
    me.trace(face, picked("F02", 8), shear.id, "main")
    studio.session.save()

    # Patches on faces: strokes that add and take away.
    studio.activate("patch")
    studio.set_next("joint", "J1")
    studio.patch_tool.set_radius(0.9)
    at = picked("J1-01", 3)
    me.stroke(face, at)
    me.stroke(face, at + (0.5, 0.0, 0.4))
    me.stroke(face, at[:2] + (0.9, 0.0, 0.5), ctrl=True)
    me.undo()
    me.redo()
    patch = studio.patch_tool.finish()
    studio.set_next("bedding", "crest")
    me.stroke(face, picked("B07", 3))
    bed_patch = studio.patch_tool.finish()
    me.attempt(edits.set_attributes, [bed_patch], name="bed top", overturned=True)
    me.stroke(face, picked("B08", 3))
    studio.patch_tool.cancel()
    studio.patch_tool.continue_patch(patch)
    me.stroke(face, at + (-0.4, 0.0, -0.5))
    studio.patch_tool.finish()

    # Lines: alone, on planes, with and without a sense of slip.
    lineation = me.line(face, picked("F01", 40)[10:14], plane_id=f01, slip="normal")
    me.line(face, picked("F04", 5), type_id=line_type.id, plane_id=f01, slip="dextral")
    me.line(face, picked("B01", 30)[3:5], type_id="fold_axis", plane_id="", slip="")
    me.line(face, picked("J1-02", 4), type_id="lineation", plane_id=j[1], set_name="plumose")
    me.attempt(edits.set_attributes, [lineation], name="striae", notes="quartz fibres")
    me.attempt(edits.set_attributes, [lineation], slip="reverse")
    # Its plane goes: it stays and says so.
    me.line(face, picked("J2-03", 5), plane_id=j[3], slip="sinistral")
    me.attempt(edits.delete, [j[3]])

    # Dimensions of each kind.
    a, b = picked("B01", 2), picked("B02", 2)
    me.measure(face, [a[0], b[0]], "distance")
    me.measure(face, picked("B09", 5), "polyline")
    me.measure(face, picked("J1-01", 5), "area")
    thick = me.measure(face, [a[1], b[1]], "thickness", b01)
    me.measure(face, [picked("B05", 2)[0], picked("B08", 2)[0]], "thickness", bed_patch)
    across = me.measure(face, [picked("J2-01", 2)[0], picked("J2-01", 2)[1]], "thickness", j[2])
    me.attempt(edits.set_attributes, [thick], name="H54 to H55", notes="along the scanline")
    me.attempt(edits.delete, [j[2]])
    assert across in studio.records

    # Field readings from a table, with a type of their own.
    table = outcrop / "field book.csv"
    with table.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["station", "type", "dip direction", "dip", "x", "y", "z", "notes"])
        writer.writerow(["S1", "Bedding", 312, 39, 364523.1, 4721863.8, 851.0, "Brunton"])
        writer.writerow(["S2", "Bedding", 0, 0, 364529.4, 4721861.8, 850.2, "flat"])
        writer.writerow(["S3", "Cleavage", 121.5, 78, "", "", "", "overgrown"])
    columns = guess(read_field_table(table))
    understood = understand(
        read_field_table(table), dict(columns.columns), columns.notation, to_grid=None
    )
    assert not understood.bad, understood.bad
    cleavage = edits.suggest_type(studio.records, "Cleavage")
    planes = make_readings(
        understood.rows,
        type_ids={"bedding": "bedding", "cleavage": cleavage.id},
        type_id="bedding",
        set_name="field",
        turn_deg=3.25,
        source=table.name,
    )
    me.attempt(edits.add_readings, planes, [cleavage])
    lines = [
        FieldRow(2, "", "line", 31.0, 11.0, notes="hinge", position=(364529.0, 4721861.5, 853.0)),
        FieldRow(3, "vertical one", "line", 200.0, 90.0),
    ]
    read_lines = make_readings(lines, type_ids={}, type_id="fold_axis", source="lines.csv")
    me.attempt(edits.add_readings, read_lines)

    # Intersections by features and by sets.
    me.attempt(
        edits.add_features,
        [
            Intersection(
                edits.new_id("intersection"),
                "",
                "lineation",
                Group(feature_id=b01),
                Group(feature_id=f01),
            )
        ],
    )
    me.attempt(
        edits.add_features,
        [
            Intersection(
                edits.new_id("intersection"), "", "fold_axis",
                Group(type_id="bedding", set_name="west limb"),
                Group(type_id="bedding", set_name="crest"),
                set_name="axes", notes="beta of two limbs",
            ),
            Intersection(
                edits.new_id("intersection"), "", "lineation",
                Group(type_id="bedding"), Group(feature_id=planes[2].id),
            ),
            Intersection(
                edits.new_id("intersection"), "without a group", "lineation",
                Group(feature_id=j[3]), Group(type_id="joint", set_name="J1"),
            ),
        ],
    )  # fmt: skip
    studio.session.save()

    # A cloud in feet with y up, which lies beside the project, and a model that gets lost.
    boulder = me.bring(outcrop / "boulder.ply", "boulder")
    me.attempt(edits.declare_frame, boulder, Frame("scaled", None, 0.3048, "y"))
    cloud = np.asarray(studio.models[boulder].data.points)
    near = cloud[np.argsort(np.abs(cloud[:, 0] + cloud[:, 2]))]
    me.trace(boulder, near[:24:4], "vein", "boulder")
    studio.activate("patch")
    studio.set_next("vein", "boulder")
    studio.patch_tool.set_radius(0.4)
    me.stroke(boulder, near[:3])
    studio.patch_tool.finish()
    me.line(boulder, cloud[:3], type_id="lineation", plane_id="", slip="")
    me.measure(boulder, cloud[3:5], "distance")
    me.attempt(edits.declare_frame, boulder, Frame("local", None, 0.3048, "y"))
    block = me.bring(outcrop / "lost" / "block.ply", "hand specimen")
    corners = np.asarray(studio.models[block].data.vertices)
    me.trace(block, corners[[0, 4, 12, 20, 24, 7]], "foliation")
    me.measure(block, corners[[0, 24]], "distance")
    me.measure(block, corners[[0, 4, 24, 20]], "area")

    # The window is closed without saving, and the next day that is taken back.
    studio.session.discard_unsaved()
    studio.project.close()
    me = Geologist()
    studio = me.studio
    studio.open_project(project_folder)
    studio.models[face] = read(copy)
    me.undo()
    studio.session.save()

    # The photos become a model in the project.
    photos = outcrop / "photos"
    out = project_folder / "reconstruction" / "photos-preview"
    settings = MakeSettings("preview", seed=0).for_photos(photos)
    request = {"photos": str(photos), "out": str(out), **settings.request(), "crs": "EPSG:32633"}
    result = run_job("reconstruct", request, Silent())
    assert result["registered"] == 3, result
    shrink(out, photos / PHOTOS[1])
    made = me.bring(out / "model.obj", "photos")
    me.attempt(edits.set_attributes, [b01], notes="seen in HL_2041 too")
    me.trace(made, picked("B03", 8), "bedding", "west limb")

    # The photos' folder cannot be written on another day: points and marks go into the project.
    studio.jobs = JobBridge()
    survey = PhotoSurvey(studio)
    studio.jobs.close()
    studio.jobs = NoJobs()
    survey.folder = photos
    spare = survey.mark_files().spare
    spare.mkdir(parents=True)
    points = read_control(photos / CONTROL)
    write_control(spare / CONTROL, [*points[:3], replace(points[3], check=True)], "EPSG:32633")
    marks = read_marks(photos / MARKS)
    write_marks(spare / MARKS, [*marks[:6], replace(marks[0], label="tie 1", x=11.25, y=13.0)])

    # What is seen and not part of the history.
    studio.set_visible([j[1]], False)
    studio.display.set_cameras(True)
    studio.display.flush()

    studio.session.save()
    me.attempt(edits.set_attributes, [f03], set_name="splay")
    late = me.trace(face, picked("F04", 7), "fault", "splay")
    me.attempt(edits.set_attributes, [late], name="last one")
    me.attempt(edits.delete, [studio.session.of(Lineation)[-1].id])
    me.undo(2)
    write_layers({"folder": str(project_folder)}, Silent())
    print("undo:", studio.session.undo_label, "redo:", studio.session.redo_label)
    studio.project.close()


def shrink(out: Path, photo: Path) -> None:
    """Leave what is small of a finished reconstruction; the mesh becomes a coarse one."""
    from PIL import Image
    from vomstudio.io.cameras_file import read_cameras
    from vomstudio.io.writing import write_model

    from vomstudio.geometry.mesh import Material, Mesh
    from vomstudio.io.models import read_model

    data = read_model(out / "model.obj").data
    cameras = read_cameras(out / "cameras.json")
    view = next(v for v in cameras.views if v.name == photo.name)
    vertices, faces = simplified(data.vertices, data.faces, 800)
    vertices = np.round(vertices, 3)
    uv = seen_in(view, vertices - np.array(cameras.origin))
    for name in ("dense.laz", "model.glb", "model.ply", "model.offset.txt"):
        (out / name).unlink(missing_ok=True)
    with Image.open(photo) as image:
        image.resize((240, 160)).save(out / "texture_1.jpg", quality=60)
    materials = (Material("texture_1", out / "texture_1.jpg"),)
    mesh = Mesh(vertices, faces, materials, np.array([0, len(faces)], np.int64), uv)
    write_model(mesh, "EPSG:32633", out / "model.obj", force=True)
    for stage in (out / "work").iterdir():
        if stage.is_file():
            stage.unlink()
        elif not stage.name.startswith(("frame-", "size-")):
            shutil.rmtree(stage)


def draft(outcrop: Path, state: Path) -> None:
    """The project `schema1_draft.vom`, as it is after its process was killed: a trace is open, work
    is not saved, and the journal's last rows are in the log beside it."""
    from vomstudio.document import edits
    from vomstudio.document.records import Frame

    me = Geologist()
    studio = me.studio
    studio.new_project()
    folder = outcrop / "schema1_draft.vom"
    boulder = me.bring(outcrop / "boulder.ply", "boulder")
    me.attempt(edits.declare_frame, boulder, Frame("local", None, 0.3048, "y"))
    studio.project.save_as(folder)
    cloud = np.asarray(studio.models[boulder].data.points)
    near = cloud[np.argsort(np.abs(cloud[:, 0] + cloud[:, 2]))]
    me.trace(boulder, near[:24:4], "vein", "boulder")
    studio.session.save()
    studio.project.journal._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    second = me.trace(boulder, near[2:26:4], "vein")
    me.attempt(edits.set_attributes, [second], name="second vein")
    studio.activate("trace")
    studio.set_next("fault", "late")
    me.click(boulder, near[30:50:5])
    # Killed here.
    kept = outcrop / "kept" / "schema1_draft.vom"
    kept.mkdir(parents=True)
    for name in ("journal.sqlite", "journal.sqlite-wal"):
        shutil.copy(folder / name, kept / name)
    studio.trace_tool.forget()
    studio.project.close()


# --- what is kept ---------------------------------------------------------------------------------
def keep(outcrop: Path) -> None:
    """Into this folder; without the locks, which name the machine."""
    project = HERE / "schema1.vom"
    for name in ("schema1.vom", "schema1_draft.vom", "photos"):
        shutil.rmtree(HERE / name, ignore_errors=True)
    leave = shutil.ignore_patterns("lock", "lock-journal", "cache", "thumbnails")
    shutil.copytree(outcrop / "schema1.vom", project, ignore=leave)
    shutil.copytree(outcrop / "kept" / "schema1_draft.vom", HERE / "schema1_draft.vom")
    shutil.copytree(outcrop / "photos", HERE / "photos")
    shutil.copy(outcrop / "boulder.ply", HERE / "boulder.ply")
    result = json.loads((project / "reconstruction/photos-preview/reconstruction.json").read_text())
    print(json.dumps({k: v for k, v in result.items() if isinstance(v, str)}, indent=1))
    files = [p for p in HERE.rglob("*") if p.is_file() and "__pycache__" not in p.parts]
    print(f"{sum(p.stat().st_size for p in files) / 1e6:.2f} MB in {len(files)} files")


if __name__ == "__main__":
    main()
