"""Writer of DXF drawings that contain points, or a mesh as 3DFACE entities."""

from __future__ import annotations

import numpy as np

from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.axis_units import stated_axes
from vomstudio.io.gis.dxf import DxfWriter, color_number, color_numbers, layer_names
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.models.writers._common import (
    model_positions,
    prj_sidecar,
    step_rows,
    textures_not_written_finding,
)


def write(request: WriteRequest) -> list[Finding]:
    """Write a model as a DXF drawing.

    Points have the nearest of the 255 colours of the format. Faces are on one layer per material.
    Coordinates are exact; the CRS is written to NAME.prj.
    """
    findings: list[Finding] = []
    data = request.data
    mesh = data if isinstance(data, Mesh) and len(data.faces) else None
    if data.fields:
        findings.append(Finding("model.fields-not-written", fields=tuple(data.fields)))
    if not isinstance(data, Mesh) and data.normals is not None:
        findings.append(Finding("model.normals-not-written"))
    if mesh is not None:
        images = [
            material.texture.name for material in mesh.materials if material.texture is not None
        ]
        if images:
            findings.append(textures_not_written_finding(images))
        if mesh.colors is not None:
            findings.append(Finding("model.colors-not-written"))
    elif data.colors is not None:
        findings.append(Finding("model.colors-reduced"))
    sidecars = prj_sidecar(request, findings)
    materials = [] if mesh is None else [material.name or "mesh" for material in mesh.materials]
    names = layer_names(materials or ["mesh" if mesh is not None else "points"])
    layer_colors = dict.fromkeys(names.values(), 7)
    for material in () if mesh is None else mesh.materials:
        if material.diffuse is not None:
            r, g, b = (round(255 * min(max(component, 0.0), 1.0)) for component in material.diffuse)
            layer_colors[names[material.name or "mesh"]] = color_number(f"#{r:02x}{g:02x}{b:02x}")
    points = model_positions(data)
    paths = [request.path, *(path for path, _ in sidecars)]
    with atomic_group(paths, request.force, request.inputs) as temporaries:
        for (_, text), temporary in zip(sidecars, temporaries[1:], strict=True):
            temporary.write_text(text, encoding="utf-8")
        with open(temporaries[0], "w", encoding="ascii", newline="\n") as file:
            crs = "" if request.crs is None or len(request.crs) > 19 else f" of {request.crs}"
            unit_m = stated_axes(request.crs).unit_m
            unit = request.axes.unit if unit_m in (None, 1.0) else f"units of {unit_m!r} m"
            drawing = DxfWriter(
                file,
                layer_colors,
                data.bounds,
                f"VOM Studio, coordinates{crs}, {unit}",
                is_metric=request.axes.metric and unit_m in (None, 1.0),
            )
            if mesh is None:
                for rows in step_rows(len(points), request, tr("Writing points")):
                    colors = None if data.colors is None else color_numbers(data.colors[rows])
                    drawing.points(points[rows], next(iter(names.values())), colors)
            else:
                material_indices = np.zeros(len(mesh.faces), np.int64)
                if mesh.materials:
                    sizes = np.diff(mesh.material_offsets)
                    material_indices = np.repeat(np.arange(len(mesh.materials)), sizes)
                for rows in step_rows(len(mesh.faces), request, tr("Writing faces")):
                    corners = points[mesh.faces[rows]]
                    for number in np.unique(material_indices[rows]).tolist():
                        layer = names[materials[number]] if materials else names["mesh"]
                        drawing.faces(corners[material_indices[rows] == number], layer)
            drawing.close()
    return findings


WRITER = Writer(to_translate("DXF drawing"), (".dxf",), write)
