"""Camera files of any supported program: search beside a model, and reading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import refuse_other_kind
from vomstudio.core.files.regular import is_regular_file, open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.photos.cameras_file import FILE_NAME, find_photos, read_cameras
from vomstudio.io.photos.own_cameras import (
    alicevision,
    bundler,
    centres,
    colmap,
    metashape,
    micmac,
    nerfstudio,
    openmvg,
    opensfm,
    reality_capture,
)
from vomstudio.io.photos.own_cameras.frames import Candidate, select_frame
from vomstudio.io.photos.own_cameras.json_fields import load_json
from vomstudio.io.photos.own_cameras.result import ModelCameras, cameras_from_views
from vomstudio.io.text.file_text import require_file
from vomstudio.io.text.xml_tree import is_xml, read_xml

JSON_FORMATS: tuple[tuple[Callable[[Any], bool], Callable[[Path, Any], list[Candidate]]], ...] = (
    (opensfm.is_opensfm, opensfm.read_reconstruction),
    (opensfm.is_shot_collection, opensfm.read_shots),
    (openmvg.is_openmvg, openmvg.read_openmvg),
    (alicevision.is_alicevision, alicevision.read_alicevision),
    (nerfstudio.is_nerfstudio, nerfstudio.read_nerfstudio),
)
"""JSON formats: function that detects the format from the content, and its reader."""
EXTENSIONS = (".json", ".sfm", ".geojson", ".xml", ".csv", ".txt", ".bin", ".out")
_CAMERA_FILES = (
    FILE_NAME,
    "cameras.xml",
    *opensfm.FILE_NAMES,
    "odm_report/shots.geojson",
    "../odm_report/shots.geojson",
    *alicevision.FILE_NAMES,
    *openmvg.FILE_NAMES,
    *nerfstudio.FILE_NAMES,
    "../transforms.json",
    *bundler.FILE_NAMES,
    "sparse/0",
    "sparse",
    "../sparse/0",
    "../sparse",
    ".",
)


def read_camera_file(path: str | Path, bounds: FloatArray | None = None) -> ModelCameras:
    """Read the cameras in the frame of the model; the format is detected from the content.

    Supported formats are `cameras.json`, COLMAP (a folder, or `images` and `cameras` as text or
    binary data), Metashape XML, `reconstruction.json` and `shots.geojson` of OpenSfM and
    OpenDroneMap, `sfm_data.json` of OpenMVG, `cameras.sfm` of AliceVision and Meshroom,
    `transforms.json` of nerfstudio, `bundle.out` of Bundler, a folder of orientations of MicMac,
    the tables of RealityCapture, and tables of centres.

    Parameters
    ----------
    path : str or Path
    bounds : (2, 3) float64 or None
        Lower-left and upper-right corners of the model, which distinguish the frames of a program.
        If None, the first frame is used.

    Raises
    ------
    InputError
        If a file is not valid. The error states the file and the line or field.
    """
    path = Path(path)
    folder = colmap.find_folder(path)
    if folder is not None:
        model = colmap.read_colmap(folder)
        candidate = Candidate(
            tr("the frame of the file"), list(model.views.values()), model.warnings
        )
        return select_frame(model.path, [candidate], bounds)
    folder = micmac.find_folder(path)
    if folder is not None:
        return select_frame(path, micmac.read_micmac(folder), bounds)
    if path.is_dir():
        camera_file = find_camera_file(path / "model", include_parents=False)
        if camera_file is None:
            raise InputError(Finding("cameras.none-in-folder"), file=path)
        return read_camera_file(camera_file, bounds)
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
    head = _read_head(path)
    if head.lstrip()[:1] in (b"{", b"["):
        return _read_json_cameras(path, bounds)
    if bundler.is_bundler(head):
        return select_frame(path, bundler.read_bundler(path), bounds)
    table = centres.open_table(path)
    if reality_capture.is_reality_capture(table):
        return select_frame(path, reality_capture.read_reality_capture(path, table), bounds)
    return centres.read_centres(path, table)


def find_camera_file(model: str | Path, *, include_parents: bool = True) -> Path | None:
    """Find the camera file of a model by the usual file names.

    Files of VOM Studio take precedence. If `include_parents` is set, parent folders are searched as
    well. Returns None if there is no such file.
    """
    folder = Path(model).parent
    for name in _CAMERA_FILES:
        path = folder / name
        if not include_parents and name.startswith(".."):
            continue
        if path.is_file() and name != "." and not _has_lenses_only(path):
            return path
        if colmap.find_folder(path) is not None:
            return path
    orientations = [path for path in folder.glob("Ori-*") if micmac.find_folder(path) is not None]
    return orientations[0] if len(orientations) == 1 else None


def _has_lenses_only(path: Path) -> bool:
    """Return whether a file contains only lenses, like the `cameras.json` of OpenDroneMap."""
    return is_regular_file(path) and path.name == FILE_NAME and not is_camera_file(path)


def is_camera_file(path: Path) -> bool:
    """Return whether a file is a `cameras.json` of this program, from its first bytes.

    Parameters
    ----------
    path : Path

    Returns
    -------
    bool
    """
    if not is_regular_file(path):
        return False
    with open_regular_file(path) as stream:
        return b"vomstudio" in stream.read(4096)


def _read_json_cameras(path: Path, bounds: FloatArray | None) -> ModelCameras:
    data = load_json(path)
    for has_format, read_candidates in JSON_FORMATS:
        if has_format(data):
            return select_frame(path, read_candidates(path, data), bounds)
    refuse_other_kind(path, ("json",))
    cameras = read_cameras(path)
    origin = np.array(cameras.origin, np.float64)
    views = [view.moved(1.0, np.eye(3), origin) for view in cameras.views]
    result = cameras_from_views(path, views, find_photos(cameras, path))
    return replace(result, weak_names=cameras.weak_names)


def _read_head(path: Path) -> bytes:
    """Return the first bytes of a file without a byte order mark; empty for a pipe."""
    if not is_regular_file(path):
        return b""
    try:
        with open_regular_file(path) as stream:
            return stream.read(64).removeprefix(b"\xef\xbb\xbf")
    except (InputError, OSError):
        return b""
