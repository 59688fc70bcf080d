"""Reading of the cameras of a model from files of any supported program."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import refuse_other_kind
from vomstudio.core.files.regular import is_regular, open_regular
from vomstudio.core.findings import Finding
from vomstudio.io.photos.cameras_file import FILE_NAME, find_photos, read_cameras
from vomstudio.io.photos.own_cameras import centres, colmap, metashape, opensfm
from vomstudio.io.photos.own_cameras.frames import Candidate, select_frame
from vomstudio.io.photos.own_cameras.result import OwnCameras, cameras_of_views
from vomstudio.io.text.file_text import require_file
from vomstudio.io.text.xml_tree import is_xml, read_xml

_CAMERA_FILES = (
    FILE_NAME,
    "cameras.xml",
    *opensfm.NAMES,
    "odm_report/shots.geojson",
    "../odm_report/shots.geojson",
    "sparse/0",
    "sparse",
    "../sparse/0",
    "../sparse",
    ".",
)


def read_own_cameras(path: str | Path, bounds: FloatArray | None = None) -> OwnCameras:
    """Read the cameras in the frame of the model; the format is detected from the content.

    Supported formats are `cameras.json`, COLMAP (a folder, or `images` and `cameras` as text or
    binary data), Metashape XML, `reconstruction.json` and `shots.geojson` of OpenSfM and
    OpenDroneMap, and tables of centres.

    Parameters
    ----------
    path : str or Path
    bounds : (2, 3) float64 or None
        Lower-left and upper-right corners of the model, which distinguish the frames of a program.
        If None, the first frame is used.

    Raises
    ------
    InputError
        If a file is not valid; states file and line or field.
    """
    path = Path(path)
    folder = colmap.folder_of(path)
    if folder is not None:
        return colmap.read_colmap(folder)
    if path.is_dir():
        camera_file = find_own_cameras(path / "model", search_parents=False)
        if camera_file is None:
            raise InputError(Finding("cameras.none-in-folder"), file=path)
        return read_own_cameras(camera_file, bounds)
    require_file(path)
    if is_xml(path):
        root = read_xml(path)
        if metashape.is_metashape(root):
            return select_frame(path, metashape.read_metashape(path, root), bounds)
        refuse_other_kind(path, ("xml", "metashape-xml"))
        raise InputError(
            Finding("file.other-format", format="Agisoft XML"),
            file=path,
            line=root.sourceline,
            field=root.tag,
        )
    if _is_json(path):
        return _read_json_cameras(path, bounds)
    return centres.read_centres(path)


def find_own_cameras(model: str | Path, *, search_parents: bool = True) -> Path | None:
    """Return the camera file next to a model by its usual names, preferring this program's.

    If `search_parents` is set, parent folders are searched as well.
    """
    folder = Path(model).parent
    for name in _CAMERA_FILES:
        path = folder / name
        if not search_parents and name.startswith(".."):
            continue
        if path.is_file() and name != "." and not _has_lenses_only(path):
            return path
        if colmap.folder_of(path) is not None:
            return path
    return None


def _has_lenses_only(path: Path) -> bool:
    """Return whether a file contains only lenses, like the `cameras.json` of OpenDroneMap."""
    if not is_regular(path):
        return False
    with open_regular(path) as stream:
        head = stream.read(4096)
    return path.name == FILE_NAME and b"vomstudio" not in head


def _read_json_cameras(path: Path, bounds: FloatArray | None) -> OwnCameras:
    data = opensfm.load_json(path)
    candidates: list[Candidate]
    if opensfm.is_opensfm(data):
        candidates = opensfm.read_reconstruction(path, data)
    elif opensfm.is_shots(data):
        candidates = opensfm.read_shots(path, data)
    else:
        refuse_other_kind(path, ("json",))
        cameras = read_cameras(path)
        origin = np.array(cameras.origin, np.float64)
        views = [view.moved(1.0, np.eye(3), origin) for view in cameras.views]
        return cameras_of_views(path, views, find_photos(cameras, path))
    return select_frame(path, candidates, bounds)


def _is_json(path: Path) -> bool:
    if not is_regular(path):
        return False
    try:
        with open_regular(path) as stream:
            head = stream.read(64).removeprefix(b"\xef\xbb\xbf").lstrip()
    except (InputError, OSError):
        return False
    return head[:1] in (b"{", b"[")
