"""What the 3-D view costs, on models that this script makes itself.

    xvfb-run -a -s '-screen 0 1600x1000x24 +extension GLX' \\
        python -m tests.benchmarks.bench_viewport [--millions 1 5] [--clouds 5 9.4 FILE] [--stock]
        python -m tests.benchmarks.bench_viewport --memory 5
        python -m tests.benchmarks.bench_viewport --second 5

Prints, for each size: time to the stages of a model, longest freeze of the window while it loads
and while it comes to rest (gaps of a 5 ms timer), a drag step through Qt beside a plain frame of
60,000 vertex-coloured triangles drawn by VTK alone in the same run, picks before and after the
locator stands, a repaint with a live preview over the resting model, zooming in step by step until
the finest textures are up and out again at once, and memory. Clouds, of so many million made points
or from a file: stages, freezes, drag, picks and zoom. `--stock` drags the same meshes in
pyvistaqt's QtInteractor. Meshes and clouds are then shown by elevation, clipped by dragging a face
of the box, and clouds under eye-dome lighting. `--memory` prints what drawing and picking a mesh
takes beside the mesh itself and its textures, which are tiny for that; one size per process.
`--second` opens the second view of a mesh beside the viewport: time to its libraries, to its first
and to its complete picture, memory, freezes, and a drag of 20 steps in linked views.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

STARTED = time.perf_counter()

import numpy as np  # noqa: E402
from PySide6.QtCore import QPointF, Qt, QTimer  # noqa: E402
from PySide6.QtGui import QMouseEvent  # noqa: E402
from PySide6.QtWidgets import QApplication, QMainWindow, QWidget  # noqa: E402

SIZE = (1400, 900)
TEXTURE_FORMATS = 4
TEXTURE_SIDE = 4096
ORIGIN = np.array([576_700.0, 5_188_100.0, 180.0])


def outcrop(triangles: int, folder: Path):  # type: ignore[no-untyped-def]
    """A rough cliff of 100 x 60 m in UTM coordinates with four textures, as a Mesh."""
    from vomstudio.geometry.mesh import Material, Mesh

    rows = int((triangles / 2 / (100 / 60)) ** 0.5)
    columns = triangles // 2 // rows
    vertices, faces, uvs, offsets, base = [], [], [], [0], 0
    splits = np.linspace(0, columns, TEXTURE_FORMATS + 1).astype(int)
    for k in range(TEXTURE_FORMATS):
        i = np.arange(splits[k], splits[k + 1] + 1)
        x, z = np.meshgrid(i * 100.0 / columns, np.linspace(0.0, 60.0, rows + 1))
        y = 2.0 * np.sin(x / 3.0) * np.cos(z / 5.0) + 0.4 * np.sin(3.1 * x + 1.7 * z)
        y += 0.05 * np.sin(40.0 * x) * np.sin(37.0 * z) + 0.2 * z
        vertices.append(np.stack([x, y, z], -1).reshape(-1, 3) + ORIGIN)
        u = (i - splits[k]) / (splits[k + 1] - splits[k])
        uvs.append(np.stack(np.meshgrid(u, np.linspace(0.0, 1.0, rows + 1)), -1).reshape(-1, 2))
        wide = len(i)
        a = (np.arange(rows)[:, None] * wide + np.arange(wide - 1)).ravel() + base
        faces.append(np.stack([a, a + 1, a + wide + 1], 1))
        faces.append(np.stack([a, a + wide + 1, a + wide], 1))
        offsets.append(offsets[-1] + 2 * len(a))
        base += wide * (rows + 1)
    materials = tuple(Material(f"face{k}", picture(folder, k)) for k in range(TEXTURE_FORMATS))
    return Mesh(
        np.concatenate(vertices),
        np.concatenate(faces).astype(np.int32),
        materials,
        np.array(offsets, np.int64),
        np.concatenate(uvs).astype(np.float32),
    )


def picture(folder: Path, number: int) -> Path:
    path = folder / f"texture{number}.jpg"
    if not path.exists():
        from PIL import Image

        rng = np.random.default_rng(number)
        coarse = rng.integers(90, 190, (TEXTURE_SIDE // 16, TEXTURE_SIDE // 16, 3), np.uint8)
        image = Image.fromarray(coarse).resize(
            (TEXTURE_SIDE, TEXTURE_SIDE), Image.Resampling.BICUBIC
        )
        fine = rng.integers(0, 40, (TEXTURE_SIDE, TEXTURE_SIDE, 1), np.uint8)
        Image.fromarray(np.asarray(image) // 2 + fine + 40).save(path, quality=90)
    return path


def memory_mb() -> float:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


class Heartbeat:
    """Longest gap between beats of a 5 ms timer since the last `restart`."""

    def __init__(self) -> None:
        self.timer = QTimer()
        self.timer.setInterval(5)
        self.timer.setTimerType(Qt.TimerType.PreciseTimer)
        self.timer.timeout.connect(self.beat)
        self.last = time.perf_counter()
        self.gaps: list[float] = []
        self.timer.start()

    def beat(self) -> None:
        now = time.perf_counter()
        self.gaps.append(now - self.last)
        self.last = now

    def restart(self) -> None:
        self.gaps.clear()
        self.last = time.perf_counter()

    def report(self) -> str:
        if not self.gaps:
            return "no beat"
        gaps = np.array(self.gaps) * 1e3
        return f"longest gap {gaps.max():.0f} ms, {int((gaps > 100).sum())} over 100 ms"


def pump(app: QApplication, seconds: float, until=lambda: False) -> float:  # type: ignore[no-untyped-def]
    """Run the event loop as an application would; returns the seconds it took."""
    started = time.perf_counter()
    while time.perf_counter() - started < seconds and not until():
        app.processEvents()
        time.sleep(0.0005)
    return time.perf_counter() - started


def milliseconds(values: list[float]) -> str:
    v = np.array(values) * 1e3
    return f"median {np.median(v):6.1f}  p95 {np.percentile(v, 95):6.1f}  max {v.max():6.1f} ms"


def drag(app: QApplication, widget: QWidget, steps: int) -> list[float]:
    """Seconds per step of a drag, from the event until it has been painted."""

    def send(kind, x, y, button, buttons):  # type: ignore[no-untyped-def]
        at = QPointF(x, y)
        event = QMouseEvent(
            kind, at, widget.mapToGlobal(at), button, buttons, Qt.KeyboardModifier.NoModifier
        )
        app.sendEvent(widget, event)

    left, none = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
    x, y = widget.width() / 2.0, widget.height() / 2.0
    send(QMouseEvent.Type.MouseButtonPress, x, y, left, left)
    app.processEvents()
    times = []
    for i in range(steps + 2):
        started = time.perf_counter()
        send(QMouseEvent.Type.MouseMove, x + 6 + 3 * i, y + 2 * i, none, left)
        app.processEvents()
        times.append(time.perf_counter() - started)
    send(QMouseEvent.Type.MouseButtonRelease, x, y, left, none)
    return times[2:]


def zoom(app: QApplication, view, heart: Heartbeat) -> None:  # type: ignore[no-untyped-def]
    """Ten notches closer at a time with a rest after each, then back in one go."""
    scene = view.scene
    hit = view.pick(SIZE[0] / 2, SIZE[1] / 2)
    if hit is None:
        print("zoom                            nothing in the middle of the view")
        return
    about, before = view.world_position(hit), view.moves.camera_state()
    rests = []
    heart.restart()
    for _ in range(8):
        view.camera.zoom(0.72, about)
        view.moves.redraw()
        pump(app, 0.02)
        rests.append(pump(app, 30.0, lambda: bool(scene.picture.is_complete)))
    levels = [s.level for m in scene.models.values() for s in m.gpu_textures.values()]
    print(
        f"zooming in, 8 rests             {max(rests):6.2f} s at most, texture levels {levels}, "
        f"{heart.report()}"
    )
    heart.restart()
    view.moves.set_camera_state(before)
    pump(app, 0.02)
    rest = pump(app, 30.0, lambda: bool(scene.picture.is_complete))
    pump(app, 0.2)
    print(f"zooming out in one go           {rest:6.2f} s, {heart.report()}")


def cloud(points: int):  # type: ignore[no-untyped-def]
    """A rough coloured cliff of 100 x 60 m in UTM coordinates, as a PointCloud."""
    from vomstudio.geometry.cloud import PointCloud

    rng = np.random.default_rng(0)
    x, z = rng.uniform(0.0, 100.0, points), rng.uniform(0.0, 60.0, points)
    y = 2.0 * np.sin(x / 3.0) * np.cos(z / 5.0) + 0.4 * np.sin(3.1 * x + 1.7 * z)
    y += rng.normal(0.0, 0.02, points)
    colors = [120 + 60 * np.sin(x), 110 + 50 * np.cos(2 * z), 100 + 40 * np.sin(x * z)]
    return PointCloud(np.stack([x, y, z], 1) + ORIGIN, np.stack(colors, 1).astype(np.uint8))


def run_cloud(app: QApplication, source: str, steps: int) -> None:
    from vomstudio.rendering.qt.viewport import Viewport

    if Path(source).exists():
        from vomstudio.io.models.opening import read_model

        data = read_model(Path(source)).data
    else:
        data = cloud(int(float(source) * 1e6))
    print(f"\n== {len(data.points):,} points")
    window = QMainWindow()
    window.resize(*SIZE)
    view = Viewport()
    window.setCentralWidget(view)
    seen: list[float] = []
    view.first_frame.connect(lambda: seen.append(time.perf_counter()))
    window.show()
    pump(app, 10.0, lambda: bool(seen))
    heart = Heartbeat()
    stages: dict[str, float] = {}
    started = time.perf_counter()
    view.model_stage.connect(
        lambda _, stage: stages.setdefault(stage, time.perf_counter() - started)
    )
    heart.restart()
    view.models.add("m", data, np.eye(4), frame_camera=True)
    pump(app, 60.0, lambda: {"complete", "pickable"} <= stages.keys())
    print(
        "stages                          " + ", ".join(f"{k} {v:.2f} s" for k, v in stages.items())
    )
    print(f"while loading                   {heart.report()}")
    picks = []
    for k in range(200):
        t = time.perf_counter()
        view.pick(SIZE[0] * (0.3 + 0.002 * k), SIZE[1] * 0.5)
        picks.append(time.perf_counter() - t)
    print(f"pick                            {milliseconds(picks)}; wanted 0.05 ms")
    print(f"drag step                       {milliseconds(drag(app, view, steps))}")
    heart.restart()
    rest = pump(app, 30.0, lambda: bool(view.scene.picture.is_complete))  # type: ignore[union-attr]
    pump(app, 0.3)
    print(f"coming to rest                  {rest:6.2f} s, {heart.report()}")
    display(app, view, heart, steps)
    zoom(app, view, heart)
    window.close()
    view.shutdown()


def display(app: QApplication, view, heart: Heartbeat, steps: int) -> None:  # type: ignore[no-untyped-def]
    """Fields, clipping and eye-dome lighting of the model "m"."""
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.rendering.view.clipping import ClipBox
    from vomstudio.rendering.view.scalars import ELEVATION, FieldStyle

    scene = view.scene

    def whole() -> bool:
        return bool(view.is_still)

    pump(app, 30.0, whole)
    before = memory_mb()
    heart.restart()
    started = time.perf_counter()
    view.display.set_mode("field")
    view.display.set_field("m", FieldStyle(ELEVATION))
    pump(app, 60.0, lambda: view.display.color_scale("m") is not None)
    there = time.perf_counter() - started
    pump(app, 60.0, whole)
    spent = time.perf_counter() - started
    print(
        f"shown by elevation              {there:6.2f} s colours, {spent:.2f} s whole, "
        f"{heart.report()}, {memory_mb() - before:+.0f} MB"
    )
    heart.restart()
    started = time.perf_counter()
    view.display.set_mode("textured")
    pump(app, 0.1)
    pump(app, 60.0, whole)
    print(
        f"and back                        {time.perf_counter() - started:6.2f} s, "
        f"{heart.report()}, {memory_mb() - before:+.0f} MB"
    )
    box = ClipBox.from_points(scene.models["m"].corners_world())
    view.clip.set_box(box)
    pump(app, 0.1)
    pump(app, 60.0, whole)
    at = view.clip.places()[1][1]
    heart.restart()
    times = clip_drag(app, view, float(at[0]), float(at[1]), steps)
    assert view.clip.box.high[0] < box.high[0]
    print(f"drag step of a clipping face    {milliseconds(times)}")
    heart.restart()
    spent = pump(app, 60.0, whole)
    pump(app, 0.3)
    print(f"coming to rest, clipped         {spent:6.2f} s, {heart.report()}")
    print(f"drag step, clipped              {milliseconds(drag(app, view, steps))}")
    picks = []
    for k in range(200):
        t = time.perf_counter()
        view.pick(SIZE[0] * (0.3 + 0.002 * k), SIZE[1] * 0.5)
        picks.append(time.perf_counter() - t)
    print(f"pick, clipped                   {milliseconds(picks)}")
    view.clip.set_box(None)
    pump(app, 0.1)
    pump(app, 60.0, whole)
    if isinstance(scene.models["m"].data, PointCloud):
        bare = [redraw(app, view, whole) for _ in range(3)]
        view.display.set_eye_dome(True)
        pump(app, 0.1)
        pump(app, 60.0, whole)
        heart.restart()
        shaded = [redraw(app, view, whole) for _ in range(3)]
        print(
            f"rest frame                      {min(bare):6.2f} s, with eye-dome lighting "
            f"{min(shaded):.2f} s, {heart.report()}"
        )


def redraw(app: QApplication, view, whole) -> float:  # type: ignore[no-untyped-def]
    view.scene.picture.abandon()
    view._picture._dirty = False
    started = time.perf_counter()
    view._picture._come_to_rest()
    pump(app, 60.0, whole)
    return time.perf_counter() - started


def clip_drag(app: QApplication, widget: QWidget, x: float, y: float, steps: int) -> list[float]:
    """Seconds per step of dragging the handle at a pixel to the left."""
    left, none = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
    times = []
    for k in range(steps + 3):
        kind = QMouseEvent.Type.MouseMove if k else QMouseEvent.Type.MouseButtonPress
        at = QPointF(x - 4.0 * k, y)
        button = none if k else left
        event = QMouseEvent(
            kind, at, widget.mapToGlobal(at), button, left, Qt.KeyboardModifier.NoModifier
        )
        started = time.perf_counter()
        app.sendEvent(widget, event)
        app.processEvents()
        times.append(time.perf_counter() - started)
    end = QMouseEvent(
        QMouseEvent.Type.MouseButtonRelease,
        at,
        widget.mapToGlobal(at),
        left,
        none,
        Qt.KeyboardModifier.NoModifier,
    )
    app.sendEvent(widget, end)
    return times[3:]


def memory(app: QApplication, millions: float, folder: Path) -> None:
    """Bytes per triangle of drawing and picking a textured mesh, beside mesh and textures."""
    from vomstudio.rendering.qt.viewport import Viewport

    mesh = outcrop(int(millions * 1e6), folder)
    for array in (mesh.vertices, mesh.faces, mesh.uv):
        assert array is not None
        array.sum()
    window = QMainWindow()
    window.resize(*SIZE)
    view = Viewport()
    window.setCentralWidget(view)
    stages: set[str] = set()
    view.model_stage.connect(lambda _, stage: stages.add(stage))
    window.show()
    # Also the proxy's decimation and the texture reader, whose libraries are no part of a triangle.
    small = outcrop(200_000, folder)
    view.models.add("s", small, np.eye(4), frame_camera=True)
    pump(app, 60.0, lambda: {"complete", "pickable"} <= stages)
    view.models.remove("s")
    stages.clear()
    pump(app, 1.0)
    before = memory_mb()
    view.models.add("m", mesh, np.eye(4), frame_camera=True)
    pump(app, 120.0, lambda: {"complete", "pickable"} <= stages)
    pump(app, 1.0)
    grown = (memory_mb() - before) * 1e6
    with open("/proc/self/status") as file:
        peak = next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) * 1024
    print(
        f"drawing {len(mesh.faces):,} triangles: {grown / len(mesh.faces):.0f} bytes each, "
        f"{(peak - before * 1e6) / len(mesh.faces):.0f} at the most"
    )
    window.close()
    view.shutdown()


def plain_frames(count: int) -> tuple[list[float], list[float]]:
    """Seconds per frame of VTK alone, 60,000 vertex-coloured triangles off screen, and the same
    with the picture read back."""
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
    from vtkmodules.vtkRenderingCore import (
        vtkActor,
        vtkPolyDataMapper,
        vtkRenderer,
        vtkRenderWindow,
    )

    from vomstudio.rendering.prepare import vtk_data

    n = 173
    x, z = np.meshgrid(np.linspace(0, 100, n + 1), np.linspace(0, 60, n + 1))
    points = np.stack([x, 2.0 * np.sin(x / 3.0) * np.cos(z / 5.0), z], -1).reshape(-1, 3)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)]
    )
    colors = np.random.default_rng(0).integers(60, 220, (len(points), 3), np.uint8)
    data = vtk_data.triangles(points.astype(np.float32), faces.astype(np.int32), colors=colors)
    window, renderer = vtkRenderWindow(), vtkRenderer()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*SIZE)
    window.AddRenderer(renderer)
    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(data)
    mapper.SetStatic(1)
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    renderer.AddActor(actor)
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(50, 0, 30)
    camera.SetPosition(50, -125, 50)
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCameraClippingRange()
    pixels = vtkUnsignedCharArray()
    bare, read = [], []
    for i in range(2 * count + 6):
        camera.Azimuth(0.5)  # as far in all as the drag turns
        started = time.perf_counter()
        window.Render()
        window.WaitForCompletion()
        if i % 2:
            window.GetRGBACharPixelData(0, 0, SIZE[0] - 1, SIZE[1] - 1, 0, pixels, 0)
        if i >= 6:
            (read if i % 2 else bare).append(time.perf_counter() - started)
    window.Finalize()
    return bare, read


def stock_drag(app: QApplication, mesh, steps: int) -> list[float]:  # type: ignore[no-untyped-def]
    """The same model and drag in pyvistaqt as it comes."""
    import pyvista
    import pyvistaqt
    from vtkmodules.vtkRenderingCore import vtkTexture

    from vomstudio.rendering.prepare import textures, vtk_data

    window = QMainWindow()
    window.resize(*SIZE)
    view = pyvistaqt.QtInteractor(window)
    window.setCentralWidget(view)
    window.show()
    for k, material in enumerate(mesh.materials):
        rows = slice(*mesh.material_offsets[k : k + 2])
        used, inverse = np.unique(mesh.faces[rows], return_inverse=True)
        data = vtk_data.triangles(
            (mesh.vertices[used] - ORIGIN).astype(np.float32),
            inverse.reshape(-1, 3).astype(np.int32),
            uv=mesh.uv[used],
        )
        texture = vtkTexture()
        texture.SetInputData(
            vtk_data.image(textures.load_texture(material.texture, 16384).levels[0].tiles[0])
        )
        view.add_mesh(pyvista.wrap(data), texture=texture, lighting=False)
    view.view_xz()
    pump(app, 4.0)
    times = drag(app, view, steps)
    window.close()
    return times


def run(app: QApplication, millions: float, steps: int, folder: Path) -> None:
    from vomstudio.rendering.qt.viewport import Viewport
    from vomstudio.studio.tools.interaction_types import Preview

    mesh = outcrop(int(millions * 1e6), folder)
    print(f"\n== {len(mesh.faces):,} triangles, {TEXTURE_FORMATS} textures of {TEXTURE_SIDE}^2")
    window = QMainWindow()
    window.resize(*SIZE)
    view = Viewport()
    window.setCentralWidget(view)
    seen: list[float] = []
    view.first_frame.connect(lambda: seen.append(time.perf_counter()))
    shown = time.perf_counter()
    window.show()
    pump(app, 10.0, lambda: bool(seen))
    print(f"first frame of this window      {seen[0] - shown:6.2f} s after show()")
    before = memory_mb()
    heart = Heartbeat()
    stages: dict[str, float] = {}
    started = time.perf_counter()
    view.model_stage.connect(
        lambda _, stage: stages.setdefault(stage, time.perf_counter() - started)
    )
    heart.restart()
    called = time.perf_counter()
    view.models.add("m", mesh, np.eye(4), frame_camera=True)
    called = time.perf_counter() - called
    early: list[float] = []

    def probe() -> None:
        if "pickable" not in stages and view.pick(SIZE[0] / 2, SIZE[1] / 2) is not None:
            for k in range(10):
                t = time.perf_counter()
                view.pick(SIZE[0] * (0.3 + 0.04 * k), SIZE[1] * 0.5)
                early.append(time.perf_counter() - t)

    pump(app, 60.0, lambda: {"complete", "pickable"} <= stages.keys())
    print(f"add_model returned after        {called * 1e3:6.1f} ms")
    print(
        "stages                          " + ", ".join(f"{k} {v:.2f} s" for k, v in stages.items())
    )
    print(f"while loading                   {heart.report()}")
    model = view.scene.models["m"]  # type: ignore[union-attr]
    locators, model.locators = model.locators, []
    stages.pop("pickable")
    probe()
    model.locators = locators
    print(f"pick before the locator         {milliseconds(early)}")
    late = []
    for k in range(200):
        t = time.perf_counter()
        view.pick(SIZE[0] * (0.3 + 0.002 * k), SIZE[1] * 0.5)
        late.append(time.perf_counter() - t)
    print(f"pick with the locator           {milliseconds(late)}")
    pump(app, 0.5)
    frames = view.scene.canvas.frames  # type: ignore[union-attr]
    pump(app, 1.0)
    print(f"frames drawn in an idle second  {view.scene.canvas.frames - frames}")  # type: ignore[union-attr]
    bare, read = plain_frames(steps)
    print(f"plain 60,000-triangle frame     {milliseconds(bare)}")
    print(f"  the same, picture read        {milliseconds(read)}")
    frames = view.scene.canvas.frames  # type: ignore[union-attr]
    times = drag(app, view, steps)
    drawn = view.scene.canvas.frames - frames  # type: ignore[union-attr]
    print(f"drag step                       {milliseconds(times)}, {drawn} frames for {steps + 2}")
    ratio = np.percentile(times, 95) / np.percentile(bare, 95)
    print(f"  p95 over the plain frame's    {ratio:.2f}")
    heart.restart()
    rest = pump(app, 30.0, lambda: bool(view.scene.picture.is_complete))  # type: ignore[union-attr]
    pump(app, 0.3)
    print(f"coming to rest                  {rest:6.2f} s, {heart.report()}")
    line = np.array(
        [
            view.world_position(h)
            for h in (view.pick(SIZE[0] * (0.4 + 0.02 * k), SIZE[1] * 0.5) for k in range(8))
            if h is not None
        ]
    )
    repaint = []
    for k in range(steps):
        t = time.perf_counter()
        view.set_preview(
            Preview(
                line, line[0] + 0.05 * k, line[:6], reading=("132/41", "95 % 2.1"), verdict="good"
            )
        )
        app.processEvents()
        repaint.append(time.perf_counter() - t)
    print(f"repaint with a live preview     {milliseconds(repaint)}")
    view.set_preview(None)
    display(app, view, heart, steps)
    zoom(app, view, heart)
    select = feature_changes(app, view, line)
    print(f"select one of 1000 features     {milliseconds(select)}")
    times = drag(app, view, steps)
    print(f"drag step with 1000 features    {milliseconds(times)}")
    print(f"memory                          {before:.0f} MB before, {memory_mb():.0f} MB after")
    closing = time.perf_counter()
    window.close()
    view.shutdown()
    print(f"closing                         {time.perf_counter() - closing:6.2f} s")


def second_view(app: QApplication, millions: float, folder: Path) -> None:
    """What the second view of a mesh costs, beside a viewport that shows it already."""
    from PySide6.QtWidgets import QHBoxLayout

    from vomstudio.rendering.qt.second_view import SecondView, import_plotter
    from vomstudio.rendering.qt.viewport import Viewport

    mesh = outcrop(int(millions * 1e6), folder)
    print(f"\n== second view of {len(mesh.faces):,} triangles")
    window, box = QMainWindow(), QWidget()
    row = QHBoxLayout(box)
    window.setCentralWidget(box)
    window.resize(*SIZE)
    view = Viewport()
    row.addWidget(view)
    window.show()
    view.models.add("m", mesh, np.eye(4), frame_camera=True)
    pump(app, 300.0, lambda: {"complete", "pickable"} <= view.models.reached_stages("m"))
    pump(app, 1.0)
    print(f"drag step of the viewport alone {milliseconds(drag(app, view, 20))}")
    pump(app, 60.0, lambda: view.is_still)
    before, started = memory_mb(), time.perf_counter()
    import_plotter()
    print(f"libraries                       {time.perf_counter() - started:6.2f} s")
    print(f"memory of the libraries         {memory_mb() - before:6.0f} MB")
    before, started = memory_mb(), time.perf_counter()
    heart = Heartbeat()
    second = SecondView(view, lambda _: True)
    row.addWidget(second)
    pump(app, 60.0, lambda: second.scene is not None and second.scene.canvas.frames > 1)
    print(f"first picture                   {time.perf_counter() - started:6.2f} s")
    pump(app, 300.0, lambda: second.is_still and view.is_still)
    print(f"complete picture                {time.perf_counter() - started:6.2f} s")
    print(f"while it opens                  {heart.report()}")
    print(f"memory of the view              {memory_mb() - before:6.0f} MB")
    assert second.scene is not None
    frames = second.scene.canvas.frames
    plotter = second.plotter
    assert plotter is not None
    second.camera_changed.connect(lambda: follow(second, view))
    print(f"drag step of linked views       {milliseconds(drag(app, plotter, 20))}")
    print(f"pictures of the drag            {second.scene.canvas.frames - frames:6d}")
    pump(app, 300.0, lambda: second.is_still and view.is_still)
    print(f"pictures with the rest          {second.scene.canvas.frames - frames:6d}")
    frames = second.scene.canvas.frames
    pump(app, 3.0)
    print(f"pictures when idle for 3 s      {second.scene.canvas.frames - frames:6d}")
    for _ in range(3):
        second.hide()
        pump(app, 1.0)
        closed = memory_mb() - before
        second.show()
        pump(app, 300.0, lambda: second.is_still)
        print(f"memory closed and opened again  {closed:6.0f} {memory_mb() - before:6.0f} MB")
    second.release()
    window.close()
    view.shutdown()


def follow(redraw, other) -> None:  # type: ignore[no-untyped-def]
    """Link the cameras of two views."""
    other.camera.restore(redraw.camera.to_dict())
    other.moves.redraw()


def feature_changes(app: QApplication, view, line) -> list[float]:  # type: ignore[no-untyped-def]
    from vomstudio.rendering.view.drawing import FeatureDrawing

    rng = np.random.default_rng(0)
    made = {}
    for k in range(1000):
        at = line[k % len(line)] + rng.uniform(-15, 15, 3) * [1.0, 0.2, 1.0]
        trace = at + np.cumsum(rng.normal(0, 0.15, (30, 3)), axis=0)
        made[f"f{k}"] = FeatureDrawing(f"f{k}", trace, None, (0.9, 0.6, 0.0), f"B{k} 132/41", at)
    view.features.change(made)
    app.processEvents()
    times = []
    for k in range(20):
        t = time.perf_counter()
        view.features.select([f"f{k}"])
        app.processEvents()
        times.append(time.perf_counter() - t)
    return times


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--millions", type=float, nargs="*", default=[1.0, 5.0])
    parser.add_argument(
        "--clouds", nargs="*", default=["5", "9.4"], help="millions of points, or files"
    )
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--stock", action="store_true")
    parser.add_argument("--memory", type=float, help="millions of triangles")
    parser.add_argument("--second", type=float, help="millions of triangles")
    options = parser.parse_args()
    app = QApplication([])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.memory:
            global TEXTURE_SIDE
            TEXTURE_SIDE = 64
            memory(app, options.memory, folder)
            return
        for k in range(TEXTURE_FORMATS):
            picture(folder, k)
        if options.second:
            second_view(app, options.second, folder)
            return
        for millions in options.millions:
            run(app, millions, options.steps, folder)
            if options.stock:
                mesh = outcrop(int(millions * 1e6), folder)
                times = stock_drag(app, mesh, min(options.steps, 6))
                print(f"drag step of stock pyvistaqt    {milliseconds(times)}")
    for source in options.clouds:
        run_cloud(app, source, options.steps)


if __name__ == "__main__":
    main()
