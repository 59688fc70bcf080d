"""Model formats, one module per format with a `READER`; `_*` modules are shared helpers."""

MODULES_BY_SUFFIX = {
    ".dxf": "dxf",
    ".glb": "gltf",
    ".gltf": "gltf",
    ".las": "las",
    ".laz": "las",
    ".obj": "obj",
    ".ply": "ply",
    ".shp": "shp",
    ".stl": "stl",
}
"""Module to try first for a file with this extension, so that a small command does not need to
import all of them. A format that is not listed is found as well, but later."""
