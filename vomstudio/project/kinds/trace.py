"""Digitised line along which a surface intersects the outcrop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate
from vomstudio.core.words import to_translate as _
from vomstudio.geology.doubtful_stretches import fit_remaining_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geology.quality import judge
from vomstudio.geometry.lines import path_lengths
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.plane_figures import Method
from vomstudio.geometry.planes import Axis, FittedPlane, fit_planes
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.bed_descriptions import bed_lines, notes_with_beds
from vomstudio.project.figures import Subject
from vomstudio.project.kind import (
    Attribute,
    GisLayer,
    Kind,
    Lookup,
    NetAppearance,
    Sketch,
    centre,
    get_line,
)
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    ToWorld,
    fit_fields,
    note_earlier_rule,
    world_lines,
)
from vomstudio.project.records import (
    SURROUNDINGS_RULE,
    LoggedFeature,
    RepeatableFeature,
    SurfaceFeature,
    TypedFeature,
)

METHODS = (
    ("pca", to_translate("moment of inertia (PCA)")),
    ("regression", to_translate("planar regression")),
)


MAX_LENGTH_TO_EXTENT = 4.0
"""Our own choice; a trace that runs once around an outcrop has a ratio of pi."""


@dataclass(frozen=True)
class Trace(LoggedFeature, SurfaceFeature, RepeatableFeature, TypedFeature):
    """Trace of a plane on the outcrop.

    Attributes
    ----------
    vertices : tuple of Point
        Vertices in order, in the file frame of the model.
    resolution : float or None
        Effective resolution of the model's vertices or points around the pick, in file units; None
        if unknown.
    outcrop_normal : Point or None
        Unit normal of the outcrop face around the trace in the file frame; None if unknown.
    rule : int
        Version of the rule with which `resolution` and `outcrop_normal` were measured.
    axis : str
        Axis along which the residuals of a regression are measured.
    doubtful : tuple of tuple of int
        First and last vertex of each stretch that may belong to another contact, as detected when
        the trace was followed.
    """

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    vertices: tuple[Point, ...]
    resolution: float | None = None
    outcrop_normal: Point | None = None
    set_name: str = ""
    overturned: bool = False
    notes: str = ""
    method: Literal["pca", "regression"] = "pca"
    rule: int = 0
    axis: Axis = "z"
    repeat_of: str | None = None
    interpreter: str | None = None
    beds: tuple[tuple[str, str, str], ...] = ()
    domain: str = ""
    doubtful: tuple[tuple[int, int], ...] = ()


def measure(context: MeasurementContext, traces: Sequence[Trace]) -> list[Measurement]:
    """Fit and judge traces in the World frame, all in one batch."""
    models = [context.model(trace.model_id) for trace in traces]
    points = world_lines(traces, models)
    # Most traces are on the same model and share its record.
    to_world = {
        id(m): ToWorld.from_model(m) for m in {id(model): model for model in models}.values()
    }
    fits = _fits(traces, points)
    planes = iter(Plane.from_normals([fit.normal for fit, _ in fits if fit is not None]))
    frames = [to_world[id(model)] for model in models]
    faces = _faces(traces, frames)
    tilts = _tilts_deg([fit for fit, _ in fits], frames)
    result = []
    lengths = path_lengths(points)
    inputs = zip(traces, frames, faces, points, fits, tilts, lengths, strict=True)
    for trace, frame, face, trace_points, (fit, problem), tilt, length in inputs:
        resolution = None if trace.resolution is None else trace.resolution * frame.scale
        remaining_plane = (
            fit_remaining_plane(trace_points, trace.doubtful)
            if trace.doubtful and fit is not None
            else None
        )
        stretch = (
            None
            if remaining_plane is None or fit is None
            else remaining_plane.error95_deg(fit, resolution, face)
        )
        verdict = (
            None
            if fit is None
            else note_earlier_rule(
                judge(
                    fit,
                    resolution_m=resolution,
                    outcrop_normal=face,
                    thresholds=context.thresholds,
                    registration_deg=tilt,
                    surface_findings=() if remaining_plane is None else remaining_plane.findings(),
                    stretch_error_deg=stretch,
                ),
                trace.rule,
                is_measured=resolution is not None or face is not None,
            )
        )
        if (
            verdict is not None
            and fit is not None
            and length > MAX_LENGTH_TO_EXTENT * (fit.extent or 0.0)
        ):
            verdict = replace(verdict, notes=(*verdict.notes, Finding("plane.to-and-fro")))
        result.append(
            Measurement(
                trace_points,
                resolution,
                face,
                fit,
                verdict,
                problem,
                **fit_fields(fit, None if fit is None else next(planes)),
                metric=frame.metric,
                kind="trace",
                uses_current_rule=trace.rule >= SURROUNDINGS_RULE,
                registration_error_deg=tilt,
                stretch_error_deg=stretch,
            )
        )
    return result


def _faces(traces: Sequence[Trace], frames: Sequence[ToWorld]) -> list[FloatArray | None]:
    """Return the World normal (3,) of the outcrop face of each trace; None if unknown."""
    faces: list[FloatArray | None] = [None] * len(traces)
    rows_by_frame: dict[int, list[int]] = {}
    for i, (trace, frame) in enumerate(zip(traces, frames, strict=True)):
        if trace.outcrop_normal is not None:
            rows_by_frame.setdefault(id(frame), []).append(i)
    for rows in rows_by_frame.values():
        normals = np.array([traces[i].outcrop_normal for i in rows], np.float64)
        # Multiply single rows: the product of many rows is rounded differently from that of a
        # single row.
        world_normals = (normals[:, None] @ frames[rows[0]].turn)[:, 0]
        for i, face in zip(rows, world_normals, strict=True):
            faces[i] = face
    return faces


def _tilts_deg(fits: Sequence[FittedPlane | None], frames: Sequence[ToWorld]) -> list[float | None]:
    """Return the 95 % tilt (degrees) of each plane by its registration; None if unknown."""
    tilts: list[float | None] = [None] * len(fits)
    rows_by_frame: dict[int, list[int]] = {}
    for i, (fit, frame) in enumerate(zip(fits, frames, strict=True)):
        if fit is not None and frame.rotation is not None:
            rows_by_frame.setdefault(id(frame), []).append(i)
    for rows in rows_by_frame.values():
        normals = np.array([fit.normal for i in rows if (fit := fits[i]) is not None])
        for i, tilt in zip(rows, frames[rows[0]].tilts_deg(normals), strict=True):
            tilts[i] = tilt
    return tilts


def _fits(
    traces: Sequence[Trace], points: Sequence[FloatArray]
) -> list[tuple[FittedPlane | None, Finding | None]]:
    """Return the plane of each trace, or the reason why it has none."""
    fits: list[tuple[FittedPlane | None, Finding | None]] = [(None, None)] * len(traces)
    rows_by_method: dict[tuple[Method, Axis], list[int]] = {}
    for i, trace in enumerate(traces):
        axis = trace.axis if trace.method == "regression" else "auto"
        rows_by_method.setdefault((trace.method, axis), []).append(i)
    for (method, axis), rows in rows_by_method.items():
        batch = fit_planes(
            np.concatenate([points[i] for i in rows]),
            np.concatenate([[0], np.cumsum([len(points[i]) for i in rows])]),
            method=method,
            axis=axis,
        )
        for i, fit, problem in zip(rows, batch.rows(), batch.error, strict=True):
            fits[i] = (None, problem) if problem else (fit, None)
    return fits


def sketch(subject: Subject, measurements: Lookup) -> Sketch | None:
    """Return the line, with the label at the vertex nearest to its centroid.

    Returns None if it has no points.
    """
    points = subject.measured.points
    if not len(points):
        return None
    distances = np.linalg.norm(points - centre(subject.measured), axis=1)
    anchor = np.asarray(points[int(np.argmin(distances))], float)
    return Sketch(points, anchor, sign=anchor)


N_VERTICES = replace(of.N_POINTS, value=lambda subject: len(subject.feature.vertices))

NOTES = replace(of.NOTES, value=notes_with_beds)

KIND = Kind(
    name="trace",
    order=10,
    record=Trace,
    title=_("Trace"),
    icon="vector-polyline",
    measure=measure,
    figures=(
        *of.NAME_FIGURES,
        *of.PLANE,
        of.OVERTURNED,
        *of.PLACE,
        *of.FIT_FIGURES,
        *of.VERDICT,
        *of.MODEL_FIGURES,
        of.NOTES,
    ),
    attributes=(
        kind.NAME,
        kind.TYPE,
        kind.SET,
        kind.DOMAIN,
        kind.OVERTURNED,
        Attribute("method", _("Fit"), "choice", METHODS),
        kind.NOTES,
    ),
    sketch=sketch,
    remarks=lambda subject: bed_lines(subject.feature, subject.records),
    orientations=("plane",),
    evidence="picked",
    plane=kind.always_true,
    tool="trace",
    net=NetAppearance(),
    layer=GisLayer(
        "traces",
        "line",
        get_line,
        (
            *of.NAME_FIGURES,
            N_VERTICES,
            of.DIP_DIRECTION,
            of.DIP,
            of.TOTAL_ERROR,
            of.MAX_CONFIDENCE,
            of.QUALITY,
            NOTES,
        ),
        main=True,
    ),
)
