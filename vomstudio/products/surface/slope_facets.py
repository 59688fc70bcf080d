"""Facets as slopes: read from their table and their labels on a model, and written with what the
kinematic analysis says of each."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import Float32Array, IntegerArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.spreadsheet_cells import escape_formula
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.geology.fractures.facet_slopes import MODES, FacetFace, FacetSlopes
from vomstudio.geology.notation import plain_azimuth
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.products.surface.patch import FACET

_FIELDS = {mode: f"{mode}_percent" for mode in MODES}


def faces_of(table: OrientationTable, data: Mesh | PointCloud | None = None) -> list[FacetFace]:
    """The planes of a table that `facets` wrote. What overhangs is told by a column `overhangs`, or
    by data, the model with the labels in World. Raises InputError where the labels are not those of
    the table."""
    areas = _areas(table)
    over = _told(table) if data is None else overhanging(data, labels_of(data))
    found = [
        FacetFace(
            table.ids[i],
            Plane(float(table.dip_direction_deg[i]), float(table.dip_deg[i])),
            areas[i],
            over.get(table.ids[i]),
        )
        for i in np.flatnonzero(table.is_plane).tolist()
    ]
    if data is not None and over and not {f.id for f in found} & over.keys():
        raise InputError(Finding("facet.other-labels", table=table.path), field="--labelled-model")
    return found


def labels_of(data: Mesh | PointCloud) -> IntegerArray:
    """(points,) of a model that `facets --labels` wrote. Raises InputError where it has none."""
    if FACET not in data.fields:
        raise InputError(Finding("facet.no-field"), field="--labelled-model")
    return np.asarray(data.fields[FACET]).astype(np.int64)


def overhanging(
    data: Mesh | PointCloud, labels: IntegerArray, up: Sequence[float] = (0.0, 0.0, 1.0)
) -> dict[str, bool]:
    """By facet, whether its outside points down: by the winding of a mesh's faces, by the normals
    of a cloud, which says nothing without them. up : (3,) in the frame of the data"""
    if isinstance(data, Mesh):
        corners = np.asarray(data.faces, np.int64)
        of = labels[corners]
        # A face counts for its facet where all its corners lie in it.
        own = (of == of[:, :1]).all(axis=1) & (of[:, 0] >= 0)
        a, b, c = (np.asarray(data.vertices, np.float64)[corners[own, k]] for k in range(3))
        height, number = np.cross(b - a, c - a) @ np.asarray(up), of[own, 0]
    elif data.normals is not None:
        own = labels >= 0
        height, number = np.asarray(data.normals, np.float64)[own] @ np.asarray(up), labels[own]
    else:
        return {}
    named, which = np.unique(number, return_inverse=True)
    sums = np.bincount(which, height, minlength=len(named))
    return {str(int(n)): bool(s < 0.0) for n, s in zip(named, sums, strict=True)}


def painted(found: FacetSlopes, labels: IntegerArray) -> dict[str, Float32Array]:
    """Fields of the model's points, percent, NaN where no facet is: `planar_percent` and so on."""
    fields = {}
    for mode, name in _FIELDS.items():
        by_label = {f.id: share for f, share in zip(found.facets, found.shares(mode), strict=True)}
        named, which = np.unique(labels, return_inverse=True)
        values = np.array([by_label.get(str(int(n)), np.nan) for n in named])
        fields[name] = (100.0 * values[which]).astype(np.float32)
    return fields


def write_facet_slopes(path: str | Path, found: FacetSlopes, *, force: bool = False) -> None:
    """CSV, a row for each facet. Raises TargetError."""
    file = io.StringIO()
    file.write(f"# VOM Studio {__version__}, kinematic analysis of each facet as a slope\n")
    file.write(
        f"# {found.n} planes, friction {found.friction_deg:g} deg, lateral limit "
        f"{found.lateral_deg:g} deg ({found.limits}); shares from 0 to 1\n"
    )
    out = csv.writer(file, lineterminator="\n")
    parts = ("critical", "of", "share")
    columns = [f"{mode}_{part}" for mode in MODES for part in parts]
    out.writerow(["id", "dip_direction_deg", "dip_deg", "overhangs", "area_m2", *columns])
    for facet in found.facets:
        cells = [escape_formula(facet.id), f"{plain_azimuth(facet.face.dip_direction_deg)}"]
        cells += [
            f"{facet.face.dip_deg:.4f}",
            "" if facet.overhangs is None else str(facet.overhangs),
        ]
        cells.append("" if facet.area_m2 is None else f"{facet.area_m2:.6g}")
        for mode in MODES:
            share = getattr(facet, mode)
            cells += [str(share.critical), str(share.of)]
            cells.append("" if share.share is None else f"{share.share:.6f}")
        out.writerow(cells)
    write_bytes(path, file.getvalue().encode("utf-8"), force=force)


def write_faces(path: str | Path, faces: Sequence[FacetFace]) -> None:
    """The table that `faces_of` reads, in place of what is there. Raises TargetError."""
    file = io.StringIO()
    out = csv.writer(file, lineterminator="\n")
    out.writerow(["id", "dip_direction_deg", "dip_deg", "area_m2", "overhangs"])
    for face in faces:
        plane = face.plane
        area = "" if face.area_m2 is None else repr(face.area_m2)
        over = "" if face.overhangs is None else str(face.overhangs)
        words = [repr(plane.dip_direction_deg), repr(plane.dip_deg), area, over]
        out.writerow([escape_formula(face.id), *words])
    write_bytes(path, file.getvalue().encode("utf-8"), force=True)


def _told(table: OrientationTable) -> dict[str, bool]:
    """By facet, where a column says so."""
    try:
        cells = table.column("overhangs")
    except UsageError:
        return {}
    known = {"true": True, "false": False}
    return {
        id_: known[cell.casefold()]
        for id_, cell in zip(table.ids, cells, strict=True)
        if cell.casefold() in known
    }


def _areas(table: OrientationTable) -> list[float | None]:
    """m2, None where the table does not tell."""
    try:
        cells = table.column("area_m2")
    except UsageError:
        return [None] * len(table)
    found: list[float | None] = []
    for cell in cells:
        try:
            found.append(float(cell))
        except ValueError:
            found.append(None)
    return found
