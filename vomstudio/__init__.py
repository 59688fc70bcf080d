"""VOM Studio: virtual outcrop models of geological structures.

`import vomstudio as vs` is the Python interface: see docs/api.md, or `help(vs.fit_plane)`. Its
parts are imported when they are first used, so the import itself is fast.
"""

import importlib

from vomstudio.core.version import __version__

# Text only: nothing below the application imports this module, and it imports nothing of them.
_API_MODULES = {
    "read": "models",
    "Mesh": "models",
    "PointCloud": "models",
    "read_photos": "surveys",
    "check": "surveys",
    "plan": "surveys",
    "fit_plane": "planes",
    "fit_planes": "planes",
    "fit_parallel": "planes",
    "fit_curved": "curved_beds",
    "plane_band": "plane_bands",
    "plane_of_crossing": "plane_bands",
    "PlaneFit": "planes",
    "LineFit": "planes",
    "read_orientations": "tables",
    "stats": "sets",
    "fold": "sets",
    "slip": "sets",
    "repeats": "sets",
    "sets": "set_proposals",
    "slope": "sets",
    "displacement": "measures",
    "threepoint": "measures",
    "log": "measures",
    "fractures": "fracture_maps",
    "stereonet": "nets",
    "rose": "nets",
    "orthophoto": "orthophotos",
    "Orthophoto": "orthophotos",
    "dem": "elevations",
    "ElevationModel": "elevations",
    "section": "sections",
    "extend": "extensions",
    "surface": "surfaces",
    "measurable": "measurables",
    "Section": "sections",
    "register": "registrations",
    "compare": "comparisons",
    "agreement": "model_agreement",
    "facets": "extractions",
    "follow": "extractions",
    "propose_traces": "proposals",
    "reconstruct": "reconstructions",
    "export_cameras": "camera_exports",
    "Project": "projects",
    "ProjectModel": "projects",
    "sample": "samples",
}
_CORE_MODULES = {"CancelToken": "vomstudio.core.progress"}

__all__ = [*sorted([*_API_MODULES, *_CORE_MODULES, "errors"]), "__version__"]


def __getattr__(name: str) -> object:
    if name == "errors":
        value: object = importlib.import_module("vomstudio.core.errors")
    elif name in _API_MODULES:
        value = getattr(importlib.import_module(f"vomstudio.api.{_API_MODULES[name]}"), name)
    elif name in _CORE_MODULES:
        value = getattr(importlib.import_module(_CORE_MODULES[name]), name)
    else:
        raise AttributeError(f"module 'vomstudio' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
