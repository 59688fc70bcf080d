"""One module a format, found by its `READER`; names that begin with _ are parts of others."""

USUAL = {
    ".glb": "gltf", ".gltf": "gltf", ".las": "las", ".laz": "las", ".obj": "obj", ".ply": "ply",
    ".stl": "stl",
}  # fmt: skip
"""The module that is asked first about a file with this ending, so that a small command need not
import them all. A format that is not listed is found as well, only later."""
