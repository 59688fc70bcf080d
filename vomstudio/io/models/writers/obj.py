"""Writer of Wavefront OBJ files with an MTL file and copies of the textures."""

from __future__ import annotations

import itertools
from pathlib import Path

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
    model_positions,
    plan_images,
    prj_sidecar,
    shorten_numbers,
    step_rows,
    write_lines,
)


def write(request: WriteRequest) -> list[Finding]:
    """Write a mesh or cloud as OBJ.

    Coordinates are the shortest decimals that restore the same float64; vertex colours are `v x y z
    r g b` in 0..1; the CRS is written to NAME.prj.
    """
    findings: list[Finding] = []
    data = request.data
    if data.fields:
        findings.append(Finding("model.fields-not-written", fields=tuple(data.fields)))
    mesh = data if isinstance(data, Mesh) else None
    if mesh is None and data.normals is not None:  # type: ignore[union-attr]
        findings.append(Finding("model.normals-not-written"))
    images = plan_images(mesh, request) if mesh else ImagePlan([], [])
    sidecars = prj_sidecar(request, findings)
    library = request.path.with_suffix(".mtl") if mesh and mesh.materials else None
    paths = [
        request.path,
        *(target for _, target in images.copies),
        *(path for path, _ in sidecars),
    ]
    if library is not None:
        paths.append(library)
    with atomic_group(paths, request.force, request.inputs) as temporaries:
        copy_images(images, temporaries[1 : 1 + len(images.copies)])
        for (_, text), temporary in zip(
            sidecars, temporaries[1 + len(images.copies) :], strict=False
        ):
            temporary.write_text(text, encoding="utf-8")
        names = _material_names(mesh) if mesh else []
        if library is not None and mesh is not None:
            _write_library(temporaries[-1], mesh, names, images)
        _write_model(temporaries[0], request, names, None if library is None else library.name)
    return findings


def _material_names(mesh: Mesh) -> list[str]:
    """Return unique names that contain no line breaks."""
    result: list[str] = []
    for i, material in enumerate(mesh.materials):
        name = " ".join(material.name.split()) or "untextured"
        result.append(name if name not in result else f"{name}_{i}")
    return result


def _write_library(path: Path, mesh: Mesh, names: list[str], images: ImagePlan) -> None:
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        for name, material, image in zip(names, mesh.materials, images.names, strict=True):
            file.write(f"newmtl {name}\n")
            if material.diffuse is not None:
                file.write(
                    "Kd " + " ".join(f"{component:.6g}" for component in material.diffuse) + "\n"
                )
            elif image is not None:
                file.write("Kd 1 1 1\n")
            if image is not None:
                file.write(f"map_Kd {image}\n")


def _write_model(path: Path, request: WriteRequest, names: list[str], library: str | None) -> None:
    data = request.data
    points = model_positions(data)
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        file.write(f"# VOM Studio; {request.axes.description}\n")
        if request.crs is not None:
            file.write(f"# CRS {' '.join(request.crs.split())}\n")
        if library is not None:
            file.write(f"mtllib {library}\n")
        for rows in step_rows(len(points), request, tr("Writing vertices")):
            columns = [points[rows, k].tolist() for k in range(3)]
            template = "v %r %r %r"
            if data.colors is not None:
                columns += [np.round(data.colors[rows, k] / 255.0, 5).tolist() for k in range(3)]
                template += " %r %r %r"
            write_lines(file, columns, template)
        if not isinstance(data, Mesh):
            return
        has_uv = None
        if data.uv is not None:
            is_finite_uv: AnyArray = np.asarray(np.isfinite(data.uv).all(axis=1))
            has_uv = is_finite_uv[data.faces].all(axis=1)
            for rows in step_rows(len(points), request, tr("Writing texture coordinates")):
                uv = np.where(is_finite_uv[rows, None], data.uv[rows], np.float32(0))
                write_lines(
                    file, [shorten_numbers(uv[:, 0]), shorten_numbers(uv[:, 1])], "vt %r %r"
                )
        starts = data.material_offsets if names else np.array([0, len(data.faces)])
        for i, (start, stop) in enumerate(itertools.pairwise(starts)):
            if names:
                file.write(f"usemtl {names[i]}\n")
            _write_faces(file, request, data, int(start), int(stop), has_uv)


def _write_faces(file, request, mesh, start, stop, has_uv) -> None:  # type: ignore[no-untyped-def]
    for block in step_rows(stop - start, request, tr("Writing faces")):
        faces = mesh.faces[start + block.start : start + block.stop].astype(np.int64) + 1
        is_textured = np.zeros(len(faces), bool) if has_uv is None else has_uv[start:stop][block]
        untextured_faces = faces[~is_textured]
        write_lines(file, [untextured_faces[:, k].tolist() for k in range(3)], "f %d %d %d")
        faces = faces[is_textured]
        columns = [faces[:, k // 2].tolist() for k in range(6)]
        write_lines(file, columns, "f %d/%d %d/%d %d/%d")


WRITER = Writer(to_translate("Wavefront OBJ"), (".obj",), write)
