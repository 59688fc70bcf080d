"""Part of the outcrop face selected as one surface, such as a joint or an exposed bed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import cause_finding
from vomstudio.core.words import to_translate as _
from vomstudio.geology.quality import judge
from vomstudio.geometry import transform
from vomstudio.geometry.heights.levels import bend_findings, level_findings
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.project import catalogue as of
from vomstudio.project import kind
from vomstudio.project.figures import Subject
from vomstudio.project.kind import GisLayer, Kind, Lookup, NetAppearance, Sketch, centre
from vomstudio.project.measurement import (
    Measurement,
    MeasurementContext,
    ToWorld,
    fit_fields,
    is_metric,
    length_in_metres,
    matrix_to_world,
    note_earlier_rule,
)
from vomstudio.project.records import (
    PaintedFeature,
    RepeatableFeature,
    SurfaceFeature,
    TypedFeature,
)


@dataclass(frozen=True)
class Patch(PaintedFeature, SurfaceFeature, RepeatableFeature, TypedFeature):
    """Patch of the outcrop face.

    Attributes
    ----------
    element, runs, n, mean, outline
        See `PaintedFeature`.
    scatter, n_effective
        Together with `n` and `mean`, the moments of the points in the file frame
        (geometry/patches.py), from which the plane can be computed without the model.
    area : float or None
        Area of the faces in file units squared, or None for points.
    rule : int
        Version of the rule with which the resolution was measured.
    level_gap : float or None
        Distance between the levels that contain the points (geometry/heights/levels.py), in file
        units; None if there is a single level.
    bent : bool
        Whether the patch was proposed as a part of a wavy or curved face.

    Notes
    -----
    The other fields are described in Trace.
    """

    id: str
    name: str
    type_id: str
    model_id: str
    model_hash: str
    element: Literal["face", "point"]
    runs: tuple[tuple[int, int], ...]
    n: int
    mean: Point
    scatter: tuple[Point, Point, Point]
    n_effective: float
    outline: tuple[Point, ...] = ()
    area: float | None = None
    resolution: float | None = None
    set_name: str = ""
    overturned: bool = False
    notes: str = ""
    rule: int = 0
    repeat_of: str | None = None
    interpreter: str | None = None
    level_gap: float | None = None
    bent: bool = False
    domain: str = ""
    bend_deg: float | None = None


def measure(context: MeasurementContext, patches: Sequence[Patch]) -> list[Measurement]:
    """Measure the planes of patches from their moments."""
    return [_measure(context, patch) for patch in patches]


def _measure(context: MeasurementContext, patch: Patch) -> Measurement:
    model = context.model(patch.model_id)
    rows = matrix_to_world(model)
    scale = transform.scale_factor(rows)
    linear_rows = rows[:3, :3]
    midpoint = transform.apply(rows, [patch.mean])
    resolution = length_in_metres(patch.resolution, rows)
    fields: dict[str, Any] = {
        "area_m2": None if patch.area is None else patch.area * scale**2,
        "metric": is_metric(model),
        "kind": "patch",
        "verdict_kind": "patch",
        "bend_deg": patch.bend_deg,
    }
    try:
        fit = fit_moments(
            patch.n,
            midpoint[0],
            linear_rows @ np.asarray(patch.scatter) @ linear_rows.T,
            patch.n_effective,
        )
    except GeometryError as error:
        return Measurement(midpoint, resolution, None, None, None, cause_finding(error), **fields)
    tilt = fields["registration_error_deg"] = ToWorld.from_model(model).tilt_deg(fit.normal)
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=None,
        kind="patch",
        thresholds=context.thresholds,
        registration_deg=tilt,
        surface_findings=(
            *level_findings(length_in_metres(patch.level_gap, rows)),
            *bend_findings(patch.bent),
        ),
        bend_deg=patch.bend_deg,
    )
    verdict = note_earlier_rule(verdict, patch.rule, is_measured=resolution is not None)
    return Measurement(midpoint, resolution, None, fit, verdict, None, **fit_fields(fit), **fields)


def _to_world(points: Sequence[Point], subject: Subject) -> FloatArray:
    return transform.apply(matrix_to_world(subject.model), points)


def outline(subject: Subject) -> FloatArray | None:
    """Return the outline (n, 3) of the patch in the World frame, or None if it has none."""
    patch: Patch = subject.feature
    return _to_world(patch.outline, subject) if len(patch.outline) > 2 else None


def sketch(subject: Subject, measurements: Lookup) -> Sketch:
    """Return the outline of the patch, or its centre if it has no outline."""
    patch: Patch = subject.feature
    midpoint = centre(subject.measured)
    line = subject.measured.points
    if len(patch.outline) > 2:
        line = _to_world((*patch.outline, patch.outline[0]), subject)
    return Sketch(line, midpoint, sign=midpoint, faces=patch)


def places(subject: Subject) -> FloatArray:
    """Return the centre and the outline of the patch."""
    patch: Patch = subject.feature
    points = subject.measured.points
    if not patch.outline:
        return points
    return np.concatenate([points, _to_world(patch.outline, subject)])


N_ELEMENTS = replace(of.N_POINTS, value=lambda subject: subject.feature.n)

KIND = Kind(
    name="patch",
    order=30,
    record=Patch,
    title=_("Patch"),
    icon="texture-box",
    measure=measure,
    figures=(
        *of.NAME_FIGURES,
        *of.PLANE,
        of.OVERTURNED,
        *of.PLACE,
        *of.FIT_FIGURES,
        of.AREA,
        *of.VERDICT,
        *of.MODEL_FIGURES,
        of.NOTES,
    ),
    attributes=(kind.NAME, kind.TYPE, kind.SET, kind.DOMAIN, kind.OVERTURNED, kind.NOTES),
    sketch=sketch,
    orientations=("plane",),
    evidence="picked",
    plane=kind.always_true,
    tool="plane",
    net=NetAppearance(),
    layer=GisLayer(
        "patches",
        "ring",
        outline,
        (
            *of.NAME_FIGURES,
            N_ELEMENTS,
            of.DIP_DIRECTION,
            of.DIP,
            of.TOTAL_ERROR,
            of.MAX_CONFIDENCE,
            of.QUALITY,
            of.NOTES,
        ),
    ),
    places=places,
)
