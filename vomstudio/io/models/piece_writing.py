"""A piece of a model, written as a model of its own that says where it comes from."""

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
from vomstudio.geometry.units import UNPLACED, WORLD
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.models.writing import write_model


def write_piece(
    loaded: LoadedModel,
    bits: ByteArray,
    source: Path,
    content_hash: str,
    crs: str | None,
    folder: Path,
    name: str,
    progress: Progress,
    registration: Registration | None = None,
) -> tuple[Path, list[Finding]]:
    """Write the chosen faces or points of a model into a new folder below `folder`; its path, and
    sentences on what the format cannot hold.

    bits : packed, one for each face or point; source, content_hash : the file they were chosen on
    registration : of the source, whose coordinates the piece keeps

    PLY holds doubles, colours, fields and textures; where a material has a plain colour the piece
    is an OBJ, which holds that. NAME.piece.json beside it names the source, its hash and how many
    of its faces or points these are. All appear at once or not at all. Raises InputError where the
    source has changed, TargetError or Cancelled.
    """
    if loaded.content_hash != content_hash:
        raise InputError(Finding("model.file-changed"), file=source)
    data = loaded.data
    count = len(data.faces) if isinstance(data, Mesh) else len(data.points)
    mask = np.unpackbits(bits, count=count).view(np.bool_)
    piece = piece_of(data, mask)
    plain = isinstance(piece, Mesh) and any(m.texture is None for m in piece.materials)
    stem = re.sub(r'[\\/:*?"<>|\x00-\x1f]+', "_", name).strip(" .") or "piece"
    check_in_project(folder / stem)
    target = folder / stem
    number = 1
    while target.exists():
        number += 1
        target = folder / f"{stem}-{number}"
    part = target.with_name(target.name + ".part")
    facts: dict[str, Any] = {
        "piece_of": source.name,
        "content_hash": content_hash,
        "element": "face" if isinstance(data, Mesh) else "point",
        "count": int(np.count_nonzero(mask)),
        "of": count,
        "made_by": f"VOM Studio {__version__}",
    }
    try:
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True)
        file = part / f"{stem}{'.obj' if plain else '.ply'}"
        messages = write_model(
            piece,
            crs,
            file,
            progress=progress,
            axes=UNPLACED if crs is None else WORLD,
            registration=registration,
        )
        words = json.dumps(facts, indent=1, ensure_ascii=False) + "\n"
        (part / f"{stem}.piece.json").write_text(words, "utf-8")
        part.rename(target)
    except OSError as error:
        raise TargetError(
            Finding("output.unwritable", reason=error.strerror), file=target
        ) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return target / file.name, messages


def piece_of(data: Mesh | PointCloud, mask: BoolArray) -> Mesh | PointCloud:
    """The faces of a mesh with the vertices and materials that they use, or the points of a cloud,
    with all their values, in the file's frame. mask : (n,) which. Raises GeometryError where that
    is none, or the mask is of another model."""
    count = len(data.faces) if isinstance(data, Mesh) else len(data.points)
    if len(mask) != count:
        raise GeometryError(Finding("model.other-selection", selected=len(mask), count=count))
    if not mask.any():
        raise GeometryError(Finding("model.empty-selection"))
    return _faces_of(data, mask) if isinstance(data, Mesh) else data.of_rows(mask)


def _faces_of(mesh: Mesh, mask: BoolArray) -> Mesh:
    chosen = np.flatnonzero(mask)
    faces = np.asarray(mesh.faces)[chosen]
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[faces.ravel()] = True
    rows = np.flatnonzero(used)
    number = np.empty(len(used), np.int32)
    number[rows] = np.arange(len(rows), dtype=np.int32)
    offsets = np.searchsorted(chosen, np.asarray(mesh.material_offsets, np.int64))
    worn = np.flatnonzero(np.diff(offsets) > 0) if mesh.materials else np.zeros(0, np.int64)
    return Mesh(
        np.asarray(mesh.vertices)[rows],
        number[faces],
        tuple(mesh.materials[i] for i in worn),
        # Materials without a face left are dropped; the runs of the others follow one another.
        np.append(offsets[worn], offsets[worn[-1] + 1]) if len(worn) else np.zeros(1, np.int64),
        None if mesh.uv is None else np.asarray(mesh.uv)[rows],
        None if mesh.colors is None else np.asarray(mesh.colors)[rows],
        {name: np.asarray(values)[rows] for name, values in mesh.fields.items()},
    )
