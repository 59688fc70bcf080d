"""Facets as slopes: input from tables and labels, and output of kinematic analyses."""

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
from vomstudio.geology.notation import format_plain_azimuth
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.text.orientation_reading import OrientationTable
from vomstudio.products.surface.patch import FACET_FIELD

_FIELD_NAMES = {mode: f"{mode}_percent" for mode in MODES}


def read_facet_slopes(
    table: OrientationTable, data: Mesh | PointCloud | None = None
) -> list[FacetFace]:
    """Read the facets of a table written by `facets`.

    Parameters
    ----------
    table : OrientationTable
        Orientation table; its column `overhangs` is used if `data` is not given.
    data : Mesh or PointCloud, optional
        Model with labels in the World frame, from which overhangs are determined.

    Returns
    -------
    list of FacetFace

    Raises
    ------
    InputError
        If the model has no labels, or if they do not match the table.
    """
    areas = _areas(table)
    overhangs = (
        _read_overhangs(table) if data is None else find_overhangs(data, read_facet_labels(data))
    )
    faces = [
        FacetFace(
            table.ids[i],
            Plane(float(table.dip_direction_deg[i]), float(table.dip_deg[i])),
            areas[i],
            overhangs.get(table.ids[i]),
        )
        for i in np.flatnonzero(table.is_plane).tolist()
    ]
    if data is not None and overhangs and not {face.id for face in faces} & overhangs.keys():
        raise InputError(Finding("facet.other-labels", table=table.path), field="--labelled-model")
    return faces


def read_facet_labels(data: Mesh | PointCloud) -> IntegerArray:
    """Return the labels (points,) of a model written by `facets --labels`.

    Raises
    ------
    InputError
        If the model has no labels.
    """
    if FACET_FIELD not in data.fields:
        raise InputError(Finding("facet.no-field"), field="--labelled-model")
    return np.asarray(data.fields[FACET_FIELD]).astype(np.int64)


def find_overhangs(
    data: Mesh | PointCloud, labels: IntegerArray, up: Sequence[float] = (0.0, 0.0, 1.0)
) -> dict[str, bool]:
    """Determine which facets overhang, from the winding of faces or the cloud normals.

    Parameters
    ----------
    data : Mesh or PointCloud
    labels : (points,) int array
    up : (3,) sequence
        Up direction in the frame of the data.

    Returns
    -------
    dict of str to bool
        Whether each facet overhangs; empty if a cloud has no normals.
    """
    if isinstance(data, Mesh):
        corners = np.asarray(data.faces, np.int64)
        corner_labels = labels[corners]
        # A face belongs to a facet if all its corners do.
        is_used = (corner_labels == corner_labels[:, :1]).all(axis=1) & (corner_labels[:, 0] >= 0)
        a, b, c = (np.asarray(data.vertices, np.float64)[corners[is_used, k]] for k in range(3))
        height, number = np.cross(b - a, c - a) @ np.asarray(up), corner_labels[is_used, 0]
    elif data.normals is not None:
        is_used = labels >= 0
        height, number = (
            np.asarray(data.normals, np.float64)[is_used] @ np.asarray(up),
            labels[is_used],
        )
    else:
        return {}
    facet_ids, facet_rows = np.unique(number, return_inverse=True)
    sums = np.bincount(facet_rows, height, minlength=len(facet_ids))
    return {
        str(int(facet_id)): bool(sum_ < 0.0) for facet_id, sum_ in zip(facet_ids, sums, strict=True)
    }


def slope_fields(slopes: FacetSlopes, labels: IntegerArray) -> dict[str, Float32Array]:
    """Return point fields of the model, such as `planar_percent`; NaN outside facets."""
    fields = {}
    for mode, name in _FIELD_NAMES.items():
        shares_by_id = {
            facet.id: share for facet, share in zip(slopes.facets, slopes.shares(mode), strict=True)
        }
        unique_labels, label_indices = np.unique(labels, return_inverse=True)
        values = np.array(
            [shares_by_id.get(str(int(unique_label)), np.nan) for unique_label in unique_labels]
        )
        fields[name] = (100.0 * values[label_indices]).astype(np.float32)
    return fields


def write_facet_slopes(path: str | Path, slopes: FacetSlopes, *, force: bool = False) -> None:
    """Write the slopes to a CSV file with one row per facet.

    Raises
    ------
    TargetError
    """
    file = io.StringIO()
    file.write(f"# VOM Studio {__version__}, kinematic analysis of each facet as a slope\n")
    file.write(
        f"# {slopes.n} planes, friction {slopes.friction_deg:g} deg, lateral limit "
        f"{slopes.lateral_deg:g} deg ({slopes.limits}); shares from 0 to 1\n"
    )
    out = csv.writer(file, lineterminator="\n")
    parts = ("critical", "of", "share")
    columns = [f"{mode}_{part}" for mode in MODES for part in parts]
    out.writerow(["id", "dip_direction_deg", "dip_deg", "overhangs", "area_m2", *columns])
    for facet in slopes.facets:
        cells = [escape_formula(facet.id), f"{format_plain_azimuth(facet.face.dip_direction_deg)}"]
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
    """Write a table for `read_facet_slopes`, replacing an existing file.

    Raises
    ------
    TargetError
    """
    file = io.StringIO()
    out = csv.writer(file, lineterminator="\n")
    out.writerow(["id", "dip_direction_deg", "dip_deg", "area_m2", "overhangs"])
    for face in faces:
        plane = face.plane
        area = "" if face.area_m2 is None else repr(face.area_m2)
        overhang_text = "" if face.overhangs is None else str(face.overhangs)
        texts = [repr(plane.dip_direction_deg), repr(plane.dip_deg), area, overhang_text]
        out.writerow([escape_formula(face.id), *texts])
    write_bytes(path, file.getvalue().encode("utf-8"), force=True)


def _read_overhangs(table: OrientationTable) -> dict[str, bool]:
    """Return the column `overhangs` of a table, by facet."""
    try:
        cells = table.column("overhangs")
    except UsageError:
        return {}
    values = {"true": True, "false": False}
    return {
        id_: values[cell.casefold()]
        for id_, cell in zip(table.ids, cells, strict=True)
        if cell.casefold() in values
    }


def _areas(table: OrientationTable) -> list[float | None]:
    """Return the areas in m², with None for cells that are missing or not numbers."""
    try:
        cells = table.column("area_m2")
    except UsageError:
        return [None] * len(table)
    areas: list[float | None] = []
    for cell in cells:
        try:
            areas.append(float(cell))
        except ValueError:
            areas.append(None)
    return areas
