"""What a worker can be asked to do. A task takes JSON values and a Progress, returns JSON values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vomstudio.progress import Progress

Task = Callable[[Mapping[str, Any], Progress], dict[str, Any]]


def warm(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Import what reading a model needs, so that the first model opens at once."""
    from vomstudio.io import models
    from vomstudio.io.formats import obj

    del models
    obj.warm_up()
    return {}


def load_model(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Read the model `path` into a cache folder under `cache`, from where the window maps it."""
    from vomstudio.io import model_cache
    from vomstudio.io.models import content_hash, read_model, resolution

    path, cache = Path(args["path"]), Path(args["cache"])
    key = content_hash(path)
    folder = cache / f"model-{key[:16]}"
    loaded = model_cache.open_if_sound(folder, path)
    if loaded is None:
        loaded = read_model(path, progress)
        progress.stage("Keeping the model at hand")
        model_cache.save(loaded, folder)
    return {
        "folder": str(folder),
        "kind": loaded.kind,
        "crs": loaded.crs,
        "content_hash": loaded.content_hash,
        "warnings": list(loaded.warnings),
        "resolution": resolution(loaded.data),
    }


def write_layers(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write the GIS layers of the project in `folder` to `project.gpkg`."""
    from vomstudio.io.export import export_project

    folder = Path(args["folder"])
    export_project(folder, "gpkg", folder / "project.gpkg", force=True)
    return {}


TASKS: dict[str, Task] = {
    "warm": warm,
    "load_model": load_model,
    "write_layers": write_layers,
}
