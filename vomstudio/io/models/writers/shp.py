"""Writer of point shapefiles with z coordinates."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import TargetError
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.shapefile import DbfColumn, column, is_too_large, short_names, write_points
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.models.writers._common import (
    model_positions,
    prj_sidecar,
    report_unwritten_faces,
    step_rows,
)


def write(request: WriteRequest) -> list[Finding]:
    """Write POINTZ with colours (red, green, blue), normals and fields as attributes.

    The CRS is written to NAME.prj. Raises TargetError if there are more points than the format
    supports.
    """
    findings: list[Finding] = []
    data = request.data
    report_unwritten_faces(data, findings)
    points = model_positions(data)
    columns = _columns(request, findings)
    if is_too_large(len(points), columns):
        raise TargetError(
            Finding("model.exceeds-format", count=len(points), format="SHP", alternatives="LAZ"),
            file=request.path,
        )
    sidecars = prj_sidecar(request, findings, uses_esri_wkt=True)
    part_paths = [request.path.with_suffix(suffix) for suffix in (".shx", ".dbf", ".cpg")]
    paths = [request.path, *part_paths, *(path for path, _ in sidecars)]
    with atomic_group(paths, request.force, request.inputs) as (shp, shx, dbf, cpg, *sidecar_files):
        cpg.write_text("UTF-8", encoding="ascii")
        for (_, text), temporary in zip(sidecars, sidecar_files, strict=True):
            temporary.write_text(text, encoding="utf-8")
        blocks = step_rows(len(points), request, tr("Writing points"))
        write_points(shp, shx, dbf, points, columns, blocks)
    return findings


def _columns(request: WriteRequest, findings: list[Finding]) -> list[DbfColumn]:
    data = request.data
    values: dict[str, AnyArray] = {}
    if data.colors is not None:
        values |= {name: data.colors[:, k] for k, name in enumerate(("red", "green", "blue"))}
    if not isinstance(data, Mesh) and data.normals is not None:
        values |= {f"normal_{axis}": data.normals[:, k] for k, axis in enumerate("xyz")}
    # A field with one of these names remains a field.
    fields = {(f"{name} field" if name in values else name): v for name, v in data.fields.items()}
    names = short_names([*values, *fields])
    for name in fields:
        if names[name] != name:
            findings.append(Finding("model.field-renamed", field=name, new=names[name]))
    values |= fields
    if not values:
        # The format requires at least one attribute.
        return [column("id", np.arange(1, len(model_positions(data)) + 1))]
    return [column(names[name], array) for name, array in values.items()]


WRITER = Writer(to_translate("shapefile of points"), (".shp",), write)
