"""Shapefiles of points with z."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import TargetError
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.shapefile import Column, column, is_too_large, short_names, write_points
from vomstudio.io.models.writer import Outgoing, Writer
from vomstudio.io.models.writers._common import (
    bare_points,
    positions_of,
    prj_beside,
    step_rows,
)


def write(out: Outgoing) -> list[Finding]:
    """POINTZ with colours (red, green, blue), normals and fields as attributes; the CRS in
    NAME.prj. Raises TargetError for more points than the format holds."""
    messages: list[Finding] = []
    data = out.data
    bare_points(data, messages)
    points = positions_of(data)
    columns = _columns(out, messages)
    if is_too_large(len(points), columns):
        raise TargetError(
            Finding("model.exceeds-format", count=len(points), format="SHP", alternatives="LAZ"),
            file=out.path,
        )
    beside = prj_beside(out, messages, esri=True)
    parts = [out.path.with_suffix(ending) for ending in (".shx", ".dbf", ".cpg")]
    paths = [out.path, *parts, *(path for path, _ in beside)]
    with atomic_group(paths, out.force, out.inputs) as (shp, shx, dbf, cpg, *rest):
        cpg.write_text("UTF-8", encoding="ascii")
        for (_, text), temporary in zip(beside, rest, strict=True):
            temporary.write_text(text, encoding="utf-8")
        blocks = step_rows(len(points), out, tr("Writing points"))
        write_points(shp, shx, dbf, points, columns, blocks)
    return messages


def _columns(out: Outgoing, messages: list[Finding]) -> list[Column]:
    data = out.data
    values: dict[str, AnyArray] = {}
    if data.colors is not None:
        values |= {name: data.colors[:, k] for k, name in enumerate(("red", "green", "blue"))}
    if not isinstance(data, Mesh) and data.normals is not None:
        values |= {f"normal_{axis}": data.normals[:, k] for k, axis in enumerate("xyz")}
    # A field of one of these names stays a field.
    own = {(f"{name} field" if name in values else name): v for name, v in data.fields.items()}
    names = short_names([*values, *own])
    for name in own:
        if names[name] != name:
            messages.append(Finding("model.field-renamed", field=name, new=names[name]))
    values |= own
    if not values:
        # The format wants at least one attribute.
        return [column("id", np.arange(1, len(positions_of(data)) + 1))]
    return [column(names[name], array) for name, array in values.items()]


WRITER = Writer(to_translate("shapefile of points"), (".shp",), write)
