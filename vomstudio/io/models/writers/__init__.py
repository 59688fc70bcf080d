"""Model writers, one module per format; see `vomstudio.io.models.writer`."""

MODULES_BY_SUFFIX = {
    ".dxf": "dxf",
    ".glb": "glb",
    ".las": "las",
    ".laz": "las",
    ".obj": "obj",
    ".ply": "ply",
    ".shp": "shp",
    ".xyz": "xyz",
    ".csv": "xyz",
    ".txt": "xyz",
    ".asc": "xyz",
}
"""Module that writes files with this extension, so that a command imports only one of them. A
format that is not listed is found as well, but later."""
