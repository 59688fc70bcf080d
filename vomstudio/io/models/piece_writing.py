"""Writing of a piece of a model as a separate model that states its source."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray
from vomstudio.core.errors import GeometryError, InputError, TargetError
from vomstudio.core.files.containment import check_in_project
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.version import __version__
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import UNPLACED_AXES, WORLD_AXES
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.writing import write_model


def write_piece(
    loaded_model: LoadedModel,
    packed_mask: ByteArray,
    source: Path,
    content_hash: str,
    crs: str | None,
    folder: Path,
    name: str,
    progress: Progress,
    registration: Registration | None = None,
) -> tuple[Path, list[Finding]]:
    """Write selected faces or points of a model to a new folder below `folder`.

    The format is PLY, which stores doubles, colours, fields and textures; if a material has no
    texture, it is OBJ, which stores plain colours. NAME.piece.json next to it states the source,
    its hash and the number of its faces or points. Either all files or none are written.

    Parameters
    ----------
    loaded_model : LoadedModel
    packed_mask : array of uint8
        Packed mask with one bit per face or point.
    source, content_hash : Path, str
        Source model in which they were selected, and its hash.
    crs : str or None
        CRS of the model file.
    folder : Path
    name : str
        Name of the piece.
    progress : Progress
    registration : Registration or None
        Registration of the source, whose coordinates the piece keeps.

    Returns
    -------
    tuple of Path and list of Finding
        Path of the piece, and findings about what the format cannot store.

    Raises
    ------
    InputError
        If the source has changed.
    GeometryError
        If the selection is empty.
    TargetError, Cancelled
        As for `write_model`.
    """
    if loaded_model.content_hash != content_hash:
        raise InputError(Finding("model.file-changed"), file=source)
    data = loaded_model.data
    count = len(data.faces) if isinstance(data, Mesh) else len(data.points)
    mask = np.unpackbits(packed_mask, count=count).view(np.bool_)
    piece = extract_piece(data, mask)
    needs_obj = isinstance(piece, Mesh) and any(
        material.texture is None for material in piece.materials
    )
    stem = re.sub(r'[\\/:*?"<>|\x00-\x1f]+', "_", name).strip(" .") or "piece"
    check_in_project(folder / stem)
    target = folder / stem
    suffix = 1
    while target.exists():
        suffix += 1
        target = folder / f"{stem}-{suffix}"
    partial_folder = target.with_name(target.name + ".part")
    metadata: dict[str, Any] = {
        "piece_of": source.name,
        "content_hash": content_hash,
        "element": "face" if isinstance(data, Mesh) else "point",
        "count": int(np.count_nonzero(mask)),
        "of": count,
        "made_by": f"VOM Studio {__version__}",
    }
    try:
        shutil.rmtree(partial_folder, ignore_errors=True)
        partial_folder.mkdir(parents=True)
        file = partial_folder / f"{stem}{'.obj' if needs_obj else '.ply'}"
        findings = write_model(
            piece,
            crs,
            file,
            progress=progress,
            axes=UNPLACED_AXES if crs is None else WORLD_AXES,
            registration=registration,
        )
        text = json.dumps(metadata, indent=1, ensure_ascii=False) + "\n"
        (partial_folder / f"{stem}.piece.json").write_text(text, "utf-8")
        partial_folder.rename(target)
    except OSError as error:
        raise TargetError(
            Finding("output.unwritable", reason=error.strerror), file=target
        ) from error
    finally:
        shutil.rmtree(partial_folder, ignore_errors=True)
    return target / file.name, findings


def extract_piece(data: Mesh | PointCloud, mask: BoolArray) -> Mesh | PointCloud:
    """Return the selected faces of a mesh with vertices and materials, or points of a cloud.

    `mask` (n,) selects them; all values and the file frame are kept. Raises GeometryError if the
    selection is empty or the mask belongs to another model.
    """
    count = len(data.faces) if isinstance(data, Mesh) else len(data.points)
    if len(mask) != count:
        raise GeometryError(Finding("model.other-selection", selected=len(mask), count=count))
    if not mask.any():
        raise GeometryError(Finding("model.empty-selection"))
    return _extract_faces(data, mask) if isinstance(data, Mesh) else data.select_rows(mask)


def _extract_faces(mesh: Mesh, mask: BoolArray) -> Mesh:
    selected_rows = np.flatnonzero(mask)
    faces = np.asarray(mesh.faces)[selected_rows]
    is_used = np.zeros(len(mesh.vertices), np.bool_)
    is_used[faces.ravel()] = True
    rows = np.flatnonzero(is_used)
    new_index = np.empty(len(is_used), np.int32)
    new_index[rows] = np.arange(len(rows), dtype=np.int32)
    offsets = np.searchsorted(selected_rows, np.asarray(mesh.material_offsets, np.int64))
    used_materials = (
        np.flatnonzero(np.diff(offsets) > 0) if mesh.materials else np.zeros(0, np.int64)
    )
    return Mesh(
        np.asarray(mesh.vertices)[rows],
        new_index[faces],
        tuple(mesh.materials[i] for i in used_materials),
        # Materials without remaining faces are dropped; the ranges of the others are contiguous.
        np.append(offsets[used_materials], offsets[used_materials[-1] + 1])
        if len(used_materials)
        else np.zeros(1, np.int64),
        None if mesh.uv is None else np.asarray(mesh.uv)[rows],
        None if mesh.colors is None else np.asarray(mesh.colors)[rows],
        {name: np.asarray(values)[rows] for name, values in mesh.fields.items()},
    )
