"""What somebody does with a workspace, where no Qt and no VTK can be imported.

Each story is run as `python -m tests.studio.stories NAME FOLDER` by the test of its name.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.studio.loop import Loop
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registration_frames import is_same_registration
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.registration_file import find_registration, registration_path
from vomstudio.io.models.writing import write_model
from vomstudio.io.settings import Settings
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.records import Model
from vomstudio.project.sample import read_picks, read_truth, sample_model
from vomstudio.studio.jobs.job import NoArguments
from vomstudio.studio.jobs.model_tasks import IMPORT_LIBRARIES, LOAD_MODEL, ModelFile
from vomstudio.studio.notices import Notice
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.studio.workspace import Workspace

WITHOUT = ("PySide6", "vtk", "vtkmodules", "pyvista")
_PATIENCE_S = 120.0


class Desk:
    """A workspace, its loop, and all that it has said."""

    def __init__(self, settings: Settings | None = None) -> None:
        self.loop = Loop()
        self.settings = settings or Settings()
        self.work = Workspace(self.settings, self.loop.post, self.loop.later)
        self.said: list[Notice] = []
        self.work.notices.posted.connect(self.said.append)

    def wait(self, done: Callable[[], object], what: str) -> None:
        assert self.loop.run_until(lambda: bool(done()), _PATIENCE_S), f"{what}: {self.said}"

    def open_sample(self) -> Model:
        self.work.models.open_path(sample_model())
        self.wait(lambda: self.work.models.open_models, "the sample")
        (model,) = self.work.projects.of(Model)
        return model

    def click(self, point: np.ndarray, model: Model) -> None:
        """As a viewport tells of a click on the model's vertex that is nearest to a point."""
        data = self.work.models.open_models[model.id].data
        assert isinstance(data, Mesh)
        nearest = int(np.argmin(np.linalg.norm(data.vertices - point, axis=1)))
        face = int(np.flatnonzero((data.faces == nearest).any(axis=1))[0])
        weights = tuple(float(corner == nearest) for corner in data.faces[face])
        x, y, z = (float(value) for value in data.vertices[nearest])
        hit = Hit(model.id, "face", face, (x, y, z), weights)  # type: ignore[arg-type]
        self.work.tools.pointer(PointerEvent(Pointer.CLICK, 0.0, 0.0, Button.LEFT, hit=hit))

    def pick_first_plane(self, model: Model) -> tuple[str, int]:
        """Click along the sample's first pick; its name and the number of clicks."""
        picks = read_picks()
        to_file = np.linalg.inv(np.asarray(model.to_world))
        points = picks.of(0) @ to_file[:3, :3].T + to_file[:3, 3]
        self.work.tools.activate("trace")
        for point in points:
            self.click(point, model)
        return picks.names[0], len(points)


def measured(folder: Path) -> None:
    """Pick, undo, redo, save, reopen: the plane is that of the sample's truth throughout."""
    desk = Desk()
    work = desk.work
    work.projects.new()
    model = desk.open_sample()
    previews: list[object] = []
    work.tools.preview.connect(previews.append)
    name, _ = desk.pick_first_plane(model)
    assert len(previews) > 3
    work.tools.finish()
    (trace,) = work.projects.of(Trace)
    assert work.selection.ids == (trace.id,)
    assert trace.resolution is not None
    assert trace.outcrop_normal is not None
    fit = work.derived.measured([trace.id])[trace.id].fit
    assert fit is not None
    truth = read_truth().planes[name]
    assert abs(fit.dip_deg - truth.dip_deg) < 3.0
    assert abs(fit.dip_direction_deg - truth.dip_direction_deg) < 3.0

    work.history.undo()
    assert work.projects.of(Trace) == []
    assert work.selection.ids == ()
    work.history.redo()
    assert work.projects.of(Trace) == [trace]

    target = folder / "kept.vom"
    work.projects.save_as(target)
    written: list[str] = []
    work.layers.written.connect(written.append)
    desk.wait(lambda: written, "the layers")
    assert written == [str(target / "project.gpkg")]
    assert (target / "project.gpkg").is_file()
    work.visibility.set_visible([trace.id], False)
    work.close()

    again = Desk()
    again.work.projects.open(target)
    assert again.work.projects.of(Trace) == [trace]
    assert not again.work.visibility.visible(trace.id)
    again.wait(lambda: again.work.models.open_models, "the model of the project")
    same = again.work.derived.measured([trace.id])[trace.id].fit
    assert same is not None
    assert np.array_equal(same.normal, fit.normal)
    again.work.close()
    assert again.settings.recent[0] == str(target.resolve())
    assert again.settings.unclosed == []


def draft(folder: Path) -> None:
    """Clicks that were never finished are back at the next start, and can be gone on with."""
    desk = Desk()
    target = folder / "begun.vom"
    desk.work.projects.new()
    desk.work.projects.save_as(target)
    model = desk.open_sample()
    desk.work.projects.save()
    _, count = desk.pick_first_plane(model)
    # The lock is given back, and nothing else is done: as a power cut would leave it.
    desk.work.jobs.close()
    desk.work.projects.project.close()
    assert desk.settings.unclosed == [str(target.resolve())]

    again = Desk(desk.settings)
    again.work.projects.new()
    found: list[list[Path]] = []
    again.work.recovery_found.connect(found.append)
    again.work.offer_recovery()
    assert found == [[target]]
    again.work.projects.open(target)
    assert again.work.tools.active_name == "trace"
    assert len(again.work.tools.of(TraceTool).vertices) == count
    restored = Finding("tool.draft-restored", count=count)
    assert any(notice.message == restored for notice in again.said)
    assert again.work.has_work_to_save
    again.wait(lambda: again.work.models.open_models, "the model")
    again.work.history.undo()
    assert len(again.work.tools.of(TraceTool).vertices) == count - 1
    again.work.tools.finish()
    assert [len(t.vertices) for t in again.work.projects.of(Trace)] == [count - 1]
    again.work.discard()
    assert again.work.projects.of(Trace) == []
    again.work.history.undo()
    assert len(again.work.projects.of(Trace)) == 1
    again.work.close()


def cancelled(folder: Path) -> None:
    """A job that is cancelled says so once, to the one who asked; the next one is done."""
    desk = Desk()
    ended: list[object] = []
    changes: list[int] = []
    jobs = desk.work.jobs
    jobs.changed.connect(lambda: changes.append(len(jobs.jobs)))
    for _ in range(2):
        job = jobs.submit(
            IMPORT_LIBRARIES,
            NoArguments(),
            title="Getting ready",
            on_done=ended.append,
            on_failed=ended.append,
        )
    assert len(jobs.visible()) == 2
    jobs.cancel(job)
    desk.wait(lambda: len(ended) == 2, "both ends")
    assert ended[0] == NoArguments()
    assert getattr(ended[1], "cancelled", False)
    assert changes[:2] == [1, 2]
    assert changes[-1] == 0
    assert jobs.visible() == []
    jobs.close()


def died(folder: Path) -> None:
    """A worker that is killed fails its job in a sentence, and the model opens after all."""
    desk = Desk()
    work = desk.work
    work.projects.new()
    work.models.open_path(sample_model())
    (job,) = work.jobs.visible()
    process = job.worker._process
    assert process is not None
    os.kill(process.pid, signal.SIGKILL)
    desk.wait(lambda: not work.loader.busy, "the end of the job")
    assert work.models.open_models == {}
    (notice,) = desk.said
    assert notice.level == "error"
    assert notice.code == "job.worker-died"
    desk.open_sample()
    work.close()


def left(folder: Path) -> None:
    """What another project asked for never reaches the one that has taken its place."""
    desk = Desk()
    work = desk.work
    work.projects.new()
    work.models.open_path(sample_model())
    assert work.loader.busy
    work.projects.new()
    assert not work.loader.busy
    ended: list[object] = []
    work.jobs.submit(
        LOAD_MODEL,
        ModelFile(sample_model(), work.projects.project.cache),
        title="",
        on_done=ended.append,
        on_failed=ended.append,
        is_quiet=True,
    )
    desk.wait(lambda: ended, "a later job of the same lane")
    assert work.projects.of(Model) == []
    assert work.models.open_models == {}
    assert desk.said == []
    work.close()


def registered(folder: Path) -> None:
    """A registration beside a file places the model, and pieces and copies have it too."""
    spread = np.diag([1e-6, 2e-6, 3e-6, 1e-6, 1e-4, 1e-4, 1e-4])
    placed = Registration(
        "r",
        "points",
        "points",
        Frame("local"),
        scale_error=1e-3,
        covariance=tuple(map(tuple, spread.tolist())),
        centre=(5.0, 5.0, 0.0),
    )
    cloud = PointCloud(np.random.default_rng(1).uniform(0.0, 10.0, (500, 3)))
    wall, other = folder / "wall.ply", folder / "other.ply"
    write_model(cloud, None, wall, registration=placed)
    other.write_bytes(wall.read_bytes())
    registration_path(other).write_text("{", "utf-8")

    desk = Desk()
    work = desk.work
    work.projects.new()
    work.models.open_path(wall)
    desk.wait(lambda: work.models.open_models, "the registered model")
    (model,) = work.projects.of(Model)
    assert model.registration is not None
    assert is_same_registration(model.registration, placed)

    work.elements.cut_out(model.id, np.arange(500) < 200)
    desk.wait(lambda: len(work.models.open_models) == 2, "the piece")
    piece = work.projects.of(Model)[1]
    assert piece.registration is model.registration
    work.models.copy(model.id)
    desk.wait(lambda: work.projects.of(Model)[0].path != model.path, "the copy")
    for each in work.projects.of(Model):
        path = work.projects.project.find_model(each)
        assert path is not None
        assert path != wall
        found = find_registration(path, each.content_hash)
        assert found.registration is not None
        assert is_same_registration(found.registration, placed)
    work.history.undo()
    work.history.undo()
    work.history.undo()
    assert work.projects.of(Model) == work.projects.of(Registration) == []

    # The same points: the file of another model of the same content, with a damaged registration.
    work.models.open_path(other)
    desk.wait(lambda: work.projects.of(Model), "the model without a registration")
    (model,) = work.projects.of(Model)
    assert model.registration is None
    assert any("other.registration.json" in notice.text for notice in desk.said)
    work.close()


STORIES = {story.__name__: story for story in (measured, draft, cancelled, died, left, registered)}

if __name__ == "__main__":
    for name in WITHOUT:
        sys.modules[name] = None  # type: ignore[assignment]
    STORIES[sys.argv[1]](Path(sys.argv[2]))
    assert all(sys.modules[name] is None for name in WITHOUT)
