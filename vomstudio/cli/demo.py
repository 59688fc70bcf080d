"""`vomstudio demo`: complete workflow on the sample outcrop, with its true values."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.cli.common.arguments import Parser, Subparsers, add_command, progress_reporter
from vomstudio.cli.common.declared_options import add_options
from vomstudio.cli.common.output import Output
from vomstudio.cli.common.reporting import Reporter
from vomstudio.core.errors import TargetError, WorkerError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.products.sample.demo_options import DemoOptions

if TYPE_CHECKING:
    from vomstudio.core.arrays import FloatArray
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.products.sample.check import SampleResult
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.kinds.patch import Patch
    from vomstudio.project.records import Model
    from vomstudio.project.sample import SamplePicks

    Floats = FloatArray

DEFAULT_FOLDER = "vomstudio-demo"
MARK = ".vomstudio-demo"
"""Name of the file that marks a folder created by this command."""
PROJECT = "sample.vom"


def add_parser(subparsers: Subparsers) -> None:
    """Add the ``demo`` command."""
    parser = add_command(
        subparsers,
        "demo",
        run,
        help_=tr(
            "Measure the built-in sample outcrop and compare the results with the true values"
        ),
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        default=DEFAULT_FOLDER,
        help=tr(
            "output folder (default: {folder})",
            folder=DEFAULT_FOLDER,
        ),
    )
    add_options(parser, DemoOptions)


def run(args: argparse.Namespace, out: Output) -> None:
    """Run ``vomstudio demo``.

    Parameters
    ----------
    args : Namespace
        Parsed arguments.
    out : Output
        Object that receives the results, warnings and progress.

    Raises
    ------
    TargetError, WorkerError
    """
    from vomstudio.core.files.atomic import write_bytes

    folder = Path(args.output)
    _prepare_folder(folder)
    progress = progress_reporter(args)
    step_reporter = _StepReporter(progress, 4 if args.without_photos else 5)
    files: list[Path] = []
    notes: list[Finding] = []
    warnings: list[Finding] = []
    with step_reporter.step("measure", tr("Measuring the sample")):
        from vomstudio.products.sample.check import check_sample
        from vomstudio.products.sample.report import coverage_finding, format_html, format_text
        from vomstudio.project.sample import read_picks, read_truth

        picks = read_picks()
        result = check_sample(picks, read_truth())
    with step_reporter.step("project", tr("Writing the project")):
        files += _create_project(folder, picks)
    with step_reporter.step("net", tr("Drawing the stereonet")):
        files += _draw_stereonets(folder, picks, result)
    images = {"net.svg": tr("Poles of bedding, fault and joints, with the fold axis")}
    with step_reporter.step("orthophoto", tr("Drawing the orthophoto")):
        files += _write_orthophoto(folder, progress)
    images["ortho_sheet.png"] = tr("Orthophoto along the fold axis")
    checks = result.checks
    photos: dict[str, Any] | None = None
    if not args.without_photos:
        with step_reporter.step("photos", tr("Reconstructing the sample photos")):
            photos = _reconstruct_photos(folder, picks, progress)
        files += photos.pop("files")
        notes.append(photos.pop("text"))
        warnings += photos.pop("warnings")
        notes += warnings
    text = format_text(checks, notes)
    page = format_html(checks, notes, images, sum(step_reporter.seconds.values()))
    for name, content in (("summary.txt", text + "\n"), ("summary.html", page)):
        write_bytes(folder / name, content.encode(), force=True)
        files.append(folder / name)
    out.result(
        {
            "checks": [check.to_dict() for check in checks],
            "photos": photos,
            "files": [str(file) for file in files],
            "seconds": step_reporter.seconds,
            "summary": coverage_finding(checks).message,
            "warnings": warnings,
        }
    )
    out.text(text)
    out.text(
        tr(
            "Written to {folder}. Open {project} in the window.",
            folder=folder,
            project=folder / PROJECT,
        )
    )


def _reconstruct_photos(folder: Path, picks: SamplePicks, progress: Progress) -> dict[str, Any]:
    """Reconstruct a model from the sample photos, and compare it with the sample outcrop.

    Raises WorkerError if the photos do not result in a dense cloud.
    """
    import numpy as np

    from vomstudio.io.models.opening import read_model
    from vomstudio.io.models.reconstruction_file import result_registration
    from vomstudio.io.photos.cameras_file import read_cameras
    from vomstudio.products.sample.photo_check import check_photos, photo_findings
    from vomstudio.project.sample import (
        read_true_cameras,
        read_truth,
        sample_control,
        sample_marks,
        sample_model,
        sample_photos,
    )
    from vomstudio.studio.jobs.reconstruction_tasks import RECONSTRUCT, ReconstructionRequest
    from vomstudio.studio.jobs.run_job import run_job

    request = ReconstructionRequest(
        sample_photos(),
        (folder / "photos").resolve(),
        "preview",
        crs="EPSG:32633",
        control=sample_control(),
        marks=sample_marks(),
    )
    reconstruction = run_job(RECONSTRUCT, request, progress)
    if reconstruction.dense_gsd_m is None:
        raise WorkerError(Finding("sample.damaged"))
    progress.stage(tr("Comparing the model with the outcrop"))
    outcrop, cloud = read_model(sample_model()).data, read_model(Path(reconstruction.dense)).data
    result = reconstruction.to_dict()
    checks = check_photos(
        read_cameras(reconstruction.poses),
        read_true_cameras(),
        np.asarray(cloud.points),  # type: ignore[union-attr]
        outcrop,  # type: ignore[arg-type]
        picks,
        read_truth(),
        reconstruction.dense_gsd_m,
        result_registration(result, "").rotation_covariance(),
    )
    keys = ("registered", "reprojection_error_px", "dense_points", "faces", "frame", "seconds")
    return {
        "photos": result["photos"],
        **{key: result[key] for key in keys},
        "checks": [check.to_dict() for check in checks],
        "files": [Path(result[key]) for key in ("mesh", "dense", "sparse", "cameras", "report")],
        "text": " ".join(map(str, photo_findings(checks))),
        "warnings": reconstruction.warnings,
    }


class _StepReporter:
    """Reporter of the numbered steps of the demo, which records their durations in seconds."""

    def __init__(self, progress: Reporter, count: int) -> None:
        self.seconds: dict[str, float] = {}
        self._progress, self._count = progress, count

    @contextlib.contextmanager
    def step(self, name: str, title: str) -> Iterator[None]:
        self._progress.part(len(self.seconds) + 1, self._count)
        self._progress.stage(title)
        start_time_s = time.perf_counter()
        yield
        self.seconds[name] = round(time.perf_counter() - start_time_s, 3)


def _prepare_folder(folder: Path) -> None:
    """Create the folder, or remove the project of a previous demo. Raises TargetError."""
    from vomstudio.core.files.atomic import write_bytes
    from vomstudio.core.files.containment import make_folder, require_inside
    from vomstudio.core.files.lock import ProjectLock

    try:
        make_folder(folder)
        for name in (MARK, PROJECT):
            require_inside(folder / name, folder)
        if any(folder.iterdir()) and not (folder / MARK).is_file():
            raise TargetError(Finding("folder.not-empty"), file=folder)
        write_bytes(folder / MARK, b"made by vomstudio demo\n", force=True)
        project = folder / PROJECT
        if project.exists():
            if (project / "journal.sqlite").is_file():
                ProjectLock(project / "lock").release()
            shutil.rmtree(project)
    except OSError as error:
        raise TargetError(Finding("folder.not-created", reason=error.strerror), file=folder) from (
            error
        )


def _create_project(folder: Path, picks: SamplePicks) -> list[Path]:
    """Create a project in the same way as in the window, with its table and GIS layers."""
    from vomstudio.core.identifiers import new_id
    from vomstudio.geometry.frames import Frame
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models.model_copy import copy_model
    from vomstudio.io.models.opening import read_model
    from vomstudio.project.edits import add_model
    from vomstudio.project.exports.export import export_records
    from vomstudio.project.folder import ProjectFolder
    from vomstudio.project.records import Model
    from vomstudio.project.sample import sample_model

    project = ProjectFolder.create(folder / PROJECT)
    try:
        path = copy_model(sample_model(), project.folder / "models")
        loaded_model = read_model(path)
        frame = Frame("crs", loaded_model.crs, loaded_model.unit_m or 1.0)
        model = Model(
            new_id("model"),
            "sample",
            project.model_path(path),
            "mesh",
            loaded_model.content_hash,
            frame,
        )
        project.session.apply(add_model(project.session.records, model))
        assert isinstance(loaded_model.data, Mesh)
        _add_picks(project, model, loaded_model.data, picks)
        project.session.save()
        records = dict(project.session.records)
        table, layers = folder / "planes.csv", folder / "layers.gpkg"
        export_records(records, "csv", table, force=True)
        export_records(records, "gpkg", layers, writes_map=False, force=True)
    finally:
        project.close()
    return [table, layers, project.folder]


def _add_picks(project: ProjectFolder, model: Model, mesh: Mesh, picks: SamplePicks) -> None:
    """Add the picks as the tools would: beds and fault as traces, and joints as patches.

    Joints were picked over their whole faces.
    """
    from vomstudio.core.identifiers import new_id
    from vomstudio.geometry.streaming.surfaces import create_surface
    from vomstudio.project.edit import change
    from vomstudio.project.kinds.trace import Trace
    from vomstudio.project.records import SURROUNDINGS_RULE, Feature

    surface = create_surface(mesh)
    surface.build()
    new_features: dict[str, Feature] = {}
    for i, (name, feature_type) in enumerate(zip(picks.names, picks.kinds, strict=True)):
        points = picks.of(i)
        spacing = surface.local_resolution(points)
        if feature_type == "joint":
            patch = _create_patch(model, mesh, points, spacing)
            new_features[patch.id] = replace(
                patch, name=name, type_id=feature_type, set_name=picks.sets[i]
            )
            continue
        face_normal = surface.outcrop_normal(points)
        trace = Trace(
            new_id("trace"),
            name,
            feature_type,
            model.id,
            model.content_hash,
            tuple((float(x), float(y), float(z)) for x, y, z in points),
            spacing,
            None
            if face_normal is None
            else (float(face_normal[0]), float(face_normal[1]), float(face_normal[2])),
            set_name=picks.sets[i],
            notes=f"horizon {picks.horizons[i]}" if picks.horizons[i] else "",
            rule=SURROUNDINGS_RULE,
            axis="auto",
        )
        new_features[trace.id] = trace
    edit = change(
        project.session.records, f"Add the {len(new_features)} picks of the sample", new_features
    )
    project.session.apply(edit)


def _create_patch(model: Model, mesh: Mesh, points: Floats, spacing: float | None) -> Patch:
    """Create a patch from the faces at the picked points, with the plane of the points."""
    from scipy.spatial import cKDTree

    from vomstudio.core.identifiers import new_id
    from vomstudio.geometry.patches import ids_to_runs, moments, outline
    from vomstudio.geometry.planes import fit_plane
    from vomstudio.project.kinds.patch import Patch
    from vomstudio.project.records import SURROUNDINGS_RULE

    fit, patch_moments = fit_plane(points), moments(points)
    _, faces = cKDTree(mesh.vertices[mesh.faces].mean(axis=1)).query(points)
    return Patch(
        new_id("patch"),
        "",
        "",
        model.id,
        model.content_hash,
        "face",
        ids_to_runs(faces),
        patch_moments.n,
        patch_moments.mean,
        patch_moments.scatter,
        fit.n_effective or patch_moments.n_effective,
        outline(points, fit.normal),
        resolution=spacing,
        rule=SURROUNDINGS_RULE,
    )


def _draw_stereonets(folder: Path, picks: SamplePicks, result: SampleResult) -> list[Path]:
    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.products.net.contents import NetContents, make_sets
    from vomstudio.products.net.figure import write_stereonet

    groups = {}
    labels = [s if k == "joint" else k for k, s in zip(picks.kinds, picks.sets, strict=True)]
    for label in dict.fromkeys(labels):
        rows = [i for i, other_label in enumerate(labels) if other_label == label]
        plane_fits = result.fits
        groups[label] = ("plane", plane_fits.dip_direction_deg[rows], plane_fits.dip_deg[rows])
    net = NetContents(sets=make_sets(groups), fold=result.beta, circles=False)
    files = [folder / f"net.{format_}" for format_ in ("svg", "png")]
    for file in files:
        with atomic_write(file, True) as temporary:
            write_stereonet(temporary, net, format=file.suffix[1:])
    return files


def _write_orthophoto(folder: Path, progress: Reporter) -> list[Path]:
    """Write an orthophoto along the fold axis with the command `ortho`; return its files."""
    from vomstudio.cli import ortho
    from vomstudio.project.sample import sample_model

    parser = Parser(prog="vomstudio")
    ortho.add_parser(parser.add_subparsers(parser_class=Parser))
    image, sheet = folder / "ortho.tif", folder / "ortho_sheet.png"
    arguments = ["ortho", str(sample_model()), "--fold", str(folder / "planes.csv")]
    arguments += ["--gsd", "0.02", "--draw", str(folder / PROJECT), "-o", str(image)]
    arguments += ["--sheet", str(sheet), "--force"]
    output = Output(writes_json=True)
    args = parser.parse_args(arguments)
    args.reporter = progress
    args.run(args, output)
    return [image, folder / "ortho.json", folder / "ortho_depth.tif", sheet]
