"""One module a format, found by its `READER`; names that begin with _ are parts of others."""

USUAL = {
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
"""The module that is asked first about a file with this ending, so that a small command need not
import them all. A format that is not listed is found as well, only later."""
