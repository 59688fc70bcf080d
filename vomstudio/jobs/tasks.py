"""What a worker can be asked to do: JSON values and a Progress in, JSON values out."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vomstudio.jobs import inspection_tasks, survey_tasks
from vomstudio.progress import Progress

Task = Callable[[Mapping[str, Any], Progress], dict[str, Any]]


def warm(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Import what reading a model needs, so that the first model opens at once."""
    import laspy  # noqa: F401
    import lazrs  # noqa: F401
    import pyproj  # noqa: F401
    import scipy.spatial  # noqa: F401

    from vomstudio.io.models.formats.obj import warm_up

    warm_up()
    return {}


def compile_kernels(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Import every module of compiled kernels: those that were never used on this machine are
    compiled now, for seconds each, and not when somebody waits for them."""
    import importlib
    import os
    import pkgutil

    import vomstudio

    if hasattr(os, "nice"):
        os.nice(10)
    for module in pkgutil.walk_packages(vomstudio.__path__, "vomstudio."):
        if module.name.endswith("_kernels"):
            progress.step(0)
            importlib.import_module(module.name)
    return {}


def load_model(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Read the model `path` into a cache folder under `cache`, from where the window maps it."""
    from vomstudio.io.gis.crs import sidecar_crs
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.opening import resolution

    path = Path(args["path"])
    folder = model_cache.folder_of(path, Path(args["cache"]))
    loaded = model_cache.load(path, folder, progress)
    spacing = loaded.resolution
    if spacing is None:
        spacing = resolution(loaded.data)
    return {
        "folder": str(folder),
        "kind": loaded.kind,
        # A .prj that came after the cache was written counts too.
        "crs": loaded.crs or sidecar_crs(path)[0],
        "content_hash": loaded.content_hash,
        "warnings": list(loaded.warnings),
        "resolution": spacing if spacing == spacing else None,
    }


def preview_model(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write points spread over the cloud `path` as arrays to `out`; points: how many, 0 where the
    file has no quick look."""
    import numpy as np

    from vomstudio.io.models.preview import preview

    cloud = preview(args["path"])
    if cloud is None:
        return {"points": 0}
    arrays: dict[str, Any] = {"points": cloud.points}
    if cloud.colors is not None:
        arrays["colors"] = cloud.colors
    for name, values in cloud.fields.items():
        if "intensity" in name.lower():
            arrays["intensity"] = values
    np.savez(args["out"], **arrays)
    return {"points": len(cloud.points)}


def copy_model(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Copy the model `path` with all that belongs to it below `folder`; cameras: the file of its
    photos' cameras, None for the one beside it; photos: whether they are copied too."""
    from vomstudio.io.models.model_copy import copy_model as copy

    cameras = None if args.get("cameras") is None else Path(args["cameras"])
    made = copy(
        Path(args["path"]),
        Path(args["folder"]),
        progress,
        cameras=cameras,
        photos=args.get("photos", False),
    )
    return {"path": str(made)}


def write_layers(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write the GIS layers of the project in `folder` to `project.gpkg`."""
    from vomstudio.io.project.export import export_project

    folder = Path(args["folder"])
    export_project(folder, "gpkg", folder / "project.gpkg", force=True)
    return {}


def orthophoto(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write an orthophoto of the model `path`, kept at hand under `cache`, to `out`.

    view: trend_deg, plunge_deg, sense, reason; to_world: 4 x 4 rows; crs, gsd, region (centre,
    width, height) and sheet may be None.
    """
    from vomstudio.io.models import model_cache
    from vomstudio.products.ortho import orthophoto as product
    from vomstudio.products.ortho import planning
    from vomstudio.products.ortho.views import View

    path = Path(args["path"])
    loaded = model_cache.load(path, model_cache.folder_of(path, Path(args["cache"])), progress)
    region = args["region"]
    plan = planning.plan(
        loaded.data,
        View(**args["view"]),
        to_world=args["to_world"],
        gsd=args["gsd"],
        region=None if region is None else planning.Region(tuple(region[0]), region[1], region[2]),
    )
    made = product.write_orthophoto(
        loaded.data,
        plan,
        args["out"],
        crs=args["crs"],
        model=str(path),
        content_hash=loaded.content_hash,
        sheet=args["sheet"],
        force=True,
        progress=progress,
    )
    return {
        "image": str(made.image),
        "sheet": None if made.sheet is None else str(made.sheet),
        "width": plan.grid.width,
        "height": plan.grid.height,
        "gsd_m": plan.grid.gsd,
        "unit": "m" if plan.view.metric else "units",
        "coverage": made.coverage,
        "warnings": list(made.warnings),
    }


def export_model(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write the model `path`, kept at hand under `cache`, to `out` in World: turned and scaled by
    to_world (4 x 4 rows), in `crs` (None where there is none)."""
    from dataclasses import replace

    import numpy as np

    from vomstudio.geometry import transform
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import choose_writer, write_model

    path, out = Path(args["path"]), Path(args["out"])
    choose_writer(out)
    loaded = model_cache.load(path, model_cache.folder_of(path, Path(args["cache"])), progress)
    rows = transform.matrix(args["to_world"])
    data = loaded.data
    if not np.array_equal(rows, np.eye(4)):
        if isinstance(data, Mesh):
            data = replace(data, vertices=transform.apply(rows, data.vertices))
        else:
            normals = data.normals
            if normals is not None:
                normals = transform.rotate(rows, normals).astype(np.float32)
            data = replace(
                data, points=transform.apply(rows, data.points), normals=normals, arrangement=None
            )
    inputs = [path, *companions(path)]
    warnings = write_model(data, args["crs"], out, force=True, inputs=inputs, progress=progress)
    return {"warnings": warnings}


def list_photos(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """What the photos in the folder `photos` say of themselves; thumbnails go below `cache`."""
    from vomstudio.io.photos.pixels import thumbnail
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.survey.camera_positions import metres_from_gps

    found = read_photos(args["photos"], progress)
    thumbnails = Path(args["cache"]) / "thumbnails"
    thumbnails.mkdir(parents=True, exist_ok=True)
    places = metres_from_gps(found.photos)
    progress.stage("Thumbnails", len(found.photos))
    rows = []
    for number, photo in enumerate(found.photos):
        progress.step(number)
        looks = None
        if photo.yaw_deg is not None and (photo.pitch_deg is None or photo.pitch_deg > -80):
            yaw = math.radians(photo.yaw_deg)
            looks = (math.sin(yaw), math.cos(yaw))
        east, north = (float(value) for value in places[number, :2])
        rows.append(
            {
                "name": photo.name,
                "path": str(photo.path),
                "width": photo.width,
                "height": photo.height,
                "camera": photo.camera or "unknown",
                "focal": _focal(photo),
                "taken": "" if photo.taken is None else photo.taken.isoformat(" ", "seconds"),
                "has_gps": photo.latitude_deg is not None,
                "mask": None if photo.mask is None else str(photo.mask),
                "thumbnail": _keep_thumbnail(photo, thumbnails, thumbnail),
                "place": [east, north] if math.isfinite(east) else None,
                "looks": looks,
            }
        )
    left_out = [f"{name} is not used: it {reason}" for name, reason in found.skipped]
    return {"rows": rows, "left_out": [*left_out, *found.warnings]}


def _focal(photo: Any) -> str:
    if photo.focal_mm is None:
        return "unknown" if photo.focal_px is None else f"{photo.focal_px:.0f} px"
    return f"{photo.focal_mm:g} mm"


def _keep_thumbnail(photo: Any, folder: Path, thumbnail: Callable[..., Any]) -> str | None:
    """The file of a small picture that is kept between sessions; None where there is none."""
    from PIL import Image

    status = photo.path.stat()
    name = f"{photo.path.resolve()} {status.st_size} {status.st_mtime_ns}"
    out = folder / f"{hashlib.sha256(name.encode()).hexdigest()[:24]}.jpg"
    if not out.exists():
        try:
            Image.fromarray(thumbnail(photo, 144)).convert("RGB").save(out, quality=85)
        except (OSError, ValueError):
            return None
    return str(out)


def check_photos(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """The survey check of the folder `photos`, as `vomstudio check` prints it."""
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.survey.check import check_photos as check

    return check(read_photos(args["photos"]), progress=progress).as_dict()


def reconstruct(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Make a model of the photos in the folder `photos` below `out`; see `Settings` for the rest.

    scheduler: the address of a Dask cluster, or None for this machine's processors.
    """
    from vomstudio.jobs.executors import make_executor
    from vomstudio.photogrammetry.base.settings import Settings
    from vomstudio.photogrammetry.pipeline import outputs, reconstruction
    from vomstudio.products.report.reconstruction import write_report

    def path(name: str) -> Path | None:
        return None if args.get(name) is None else Path(args[name])

    settings = Settings(
        quality=args["quality"],
        crs=args.get("crs"),
        control=path("control"),
        marks=path("marks"),
        threads=args.get("threads"),
        seed=args.get("seed", 0),
    )
    out = Path(args["out"])
    executor = make_executor(settings.threads, args.get("scheduler"))
    try:
        result = reconstruction.reconstruct(Path(args["photos"]), out, settings, executor, progress)
    finally:
        executor.close()
    with outputs.disk_watched(out):
        write_report(outputs.Outputs(out).report, result)
    return result


TASKS: dict[str, Task] = {
    "list_photos": list_photos,
    "check_photos": check_photos,
    "reconstruct": reconstruct,
    "warm": warm,
    "compile_kernels": compile_kernels,
    "load_model": load_model,
    "preview_model": preview_model,
    "copy_model": copy_model,
    "write_layers": write_layers,
    "orthophoto": orthophoto,
    "export_model": export_model,
    **inspection_tasks.TASKS,
    **survey_tasks.TASKS,
}
