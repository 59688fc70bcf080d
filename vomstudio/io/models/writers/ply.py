"""Writer of binary PLY files with coordinates as doubles."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.models.writers._common import (
    ImagePlan,
    copy_images,
    field_names,
    model_positions,
    plan_images,
    prj_sidecar,
    step_rows,
)

TYPES = {
    "i1": "char",
    "u1": "uchar",
    "i2": "short",
    "u2": "ushort",
    "i4": "int",
    "u4": "uint",
    "f4": "float",
    "f8": "double",
}
RESERVED_NAMES = (
    ("x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha", "r", "g", "b", "a")
    + ("s", "t", "u", "v", "texture_u", "texture_v", "texture_s", "texture_t")
    + ("diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha")
)


def write(request: WriteRequest) -> list[Finding]:
    """Write a model as PLY.

    Vertices have double coordinates, and colours, normals and fields of their own types; textured
    faces have `texcoord` and `texnumber`, with the images next to the file; the CRS is written to
    NAME.prj.
    """
    findings: list[Finding] = []
    data = request.data
    mesh = data if isinstance(data, Mesh) else None
    images = plan_images(mesh, request) if mesh else ImagePlan([], [])
    if mesh is not None and any(material.texture is None for material in mesh.materials):
        untextured_names = [
            material.name or "untextured" for material in mesh.materials if material.texture is None
        ]
        findings.append(Finding("model.materials-not-written", materials=untextured_names))
    sidecars = prj_sidecar(request, findings)
    columns = _columns(request, findings)
    paths = [
        request.path,
        *(target for _, target in images.copies),
        *(path for path, _ in sidecars),
    ]
    with atomic_group(paths, request.force, request.inputs) as temporaries:
        copy_images(images, temporaries[1 : 1 + len(images.copies)])
        for (_, text), temporary in zip(
            sidecars, temporaries[1 + len(images.copies) :], strict=True
        ):
            temporary.write_text(text, encoding="utf-8")
        with open(temporaries[0], "wb") as file:
            file.write(_header(request, columns, mesh, images))
            n = len(model_positions(data))
            record = np.dtype([(name, values.dtype.newbyteorder("<")) for name, values in columns])
            for rows in step_rows(n, request, tr("Writing vertices")):
                block = np.empty(rows.stop - rows.start, record)
                for name, values in columns:
                    block[name] = values[rows]
                file.write(block.tobytes())
            if mesh is not None:
                _write_faces(file, request, mesh, images)
    return findings


def _columns(request: WriteRequest, findings: list[Finding]) -> list[tuple[str, AnyArray]]:
    data = request.data
    points = model_positions(data)
    columns: list[tuple[str, AnyArray]] = [(name, points[:, k]) for k, name in enumerate("xyz")]
    normals = None if isinstance(data, Mesh) else data.normals
    if normals is not None:
        columns += [(name, normals[:, k]) for k, name in enumerate(("nx", "ny", "nz"))]
    if data.colors is not None:
        columns += [(name, data.colors[:, k]) for k, name in enumerate(("red", "green", "blue"))]
    for name, label in field_names(data.fields, RESERVED_NAMES, findings).items():
        columns.append((label, _convert_to_storable(data.fields[name], name, findings)))
    return columns


def _convert_to_storable(values: AnyArray, name: str, findings: list[Finding]) -> AnyArray:
    """Convert values to a type that PLY supports."""
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    if values.dtype.str[1:] in TYPES:
        return values
    doubles = values.astype(np.float64)
    if values.dtype.kind in "iu" and not (doubles.astype(values.dtype) == values).all():
        findings.append(Finding("model.field-rounded", field=name, precision=tr("53 bits")))
    return doubles


def _header(
    request: WriteRequest, columns: list[tuple[str, AnyArray]], mesh: Mesh | None, images: ImagePlan
) -> bytes:
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment VOM Studio; {request.axes.description}",
    ]
    if request.crs is not None and len(request.crs) < 20:
        lines.append(f"comment CRS {request.crs}")
    lines += [f"comment TextureFile {name}" for name in _image_files(images)]
    lines.append(f"element vertex {len(model_positions(request.data))}")
    lines += [f"property {TYPES[values.dtype.str[1:]]} {name}" for name, values in columns]
    if mesh is not None:
        lines.append(f"element face {len(mesh.faces)}")
        lines.append("property list uchar int vertex_indices")
        if mesh.uv is not None:
            lines.append("property list uchar float texcoord")
        if _image_files(images):
            lines.append("property int texnumber")
    return ("\n".join([*lines, "end_header"]) + "\n").encode()


def _image_files(images: ImagePlan) -> list[str]:
    return list(dict.fromkeys(name for name in images.names if name is not None))


def _write_faces(file, request, mesh, images) -> None:  # type: ignore[no-untyped-def]
    kinds: list[Any] = [("n", "u1"), ("corners", "<i4", 3)]
    if mesh.uv is not None:
        kinds += [("n_uv", "u1"), ("uv", "<f4", 6)]
    files = _image_files(images)
    if files:
        kinds.append(("image", "<i4"))
    texture_numbers = [-1 if name is None else files.index(name) for name in images.names]
    face_texture_numbers = np.repeat(
        np.array(texture_numbers, np.int32), np.diff(mesh.material_offsets)
    )
    for rows in step_rows(len(mesh.faces), request, tr("Writing faces")):
        block = np.zeros(rows.stop - rows.start, np.dtype(kinds))
        faces = mesh.faces[rows]
        block["n"], block["corners"] = 3, faces
        is_textured = np.ones(len(faces), bool)
        if mesh.uv is not None:
            uv = mesh.uv[faces].reshape(-1, 6)
            is_textured = np.isfinite(uv).all(axis=1)
            block["n_uv"], block["uv"] = 6, uv
        if files:
            block["image"] = face_texture_numbers[rows]
        if is_textured.all():
            file.write(block.tobytes())
            continue
        # Write an empty list for a face without texture coordinates because (0, 0) would be a valid
        # position.
        from numpy.lib import recfunctions as rfn

        block["n_uv"][~is_textured] = 0
        untextured_records = rfn.repack_fields(
            block[[name for name in block.dtype.names or () if name != "uv"]]
        )
        edges = (np.flatnonzero(np.diff(is_textured)) + 1).tolist()
        for start, stop in itertools.pairwise([0, *edges, len(block)]):
            file.write((block if is_textured[start] else untextured_records)[start:stop].tobytes())


WRITER = Writer(to_translate("PLY"), (".ply",), write)
