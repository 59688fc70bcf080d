"""Jobs on two models: fitting one to the other, and comparing them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.registration.results import ModelPlacement
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.model_tasks import ExportedModel
from vomstudio.studio.jobs.placed_model import PlacedModel, load_in_world, read_in_file_frame

if TYPE_CHECKING:
    from vomstudio.core.arrays import BoolArray, FloatArray
    from vomstudio.core.findings import Finding
    from vomstudio.io.control.observation_tables import Pairs

    Array = FloatArray

Point = tuple[float, float, float]

MEMORY_ADVICE = to_translate("Use a smaller part of the model, or close other programs.")


@dataclass(frozen=True)
class HomologousPoint:
    """Point identified on a model (file frame) and on its reference (World frame)."""

    label: str
    model: Point
    reference_point: Point


@dataclass(frozen=True)
class StableArea:
    """Stable part of the reference, defined by points, a model, a box or polygons.

    Parameters
    ----------
    near_m : float, optional
        Maximum distance from any of the `places`.
    places : tuple of Point
        Points in the World frame.
    model : PlacedModel, optional
        Model of the stable part; the reference is stable within a few point spacings of it.
    box : (low, high), optional
        Minimum and maximum corners of the box in the World frame.
    polygons : Path, optional
        File with polygons in plan view.
    """

    near_m: float | None = None
    places: tuple[Point, ...] = ()
    model: PlacedModel | None = None
    box: tuple[Point, Point] | None = None
    polygons: Path | None = None


@dataclass(frozen=True)
class FitRequest:
    """Request to fit a model to a reference.

    Parameters
    ----------
    scale : bool
        Whether the scale is estimated.
    pairs : tuple of HomologousPoint
        At least three pairs, or fewer if the model is already close to the reference.
    stable : StableArea or None
        Stable part of the reference. If None, the whole reference is stable.
    """

    model: PlacedModel
    reference: PlacedModel
    scale: bool
    pairs: tuple[HomologousPoint, ...]
    stable: StableArea | None


@dataclass(frozen=True)
class FittedModel:
    """Placement of a model by pairs and surfaces; other fields as in `ModelFit`."""

    placed: ModelPlacement
    places: int
    overlap: float
    rms_m: float
    blocks: int
    block_m: float


def _fit(request: FitRequest, progress: Progress) -> FittedModel:
    from vomstudio.core.errors import GeometryError
    from vomstudio.core.findings import Finding
    from vomstudio.registration.by_model.fit_inputs import (
        bounding_box,
        matrix_to_similarity,
        points_and_spacing,
        replace_scale,
    )
    from vomstudio.registration.by_model.reference import fit_to_reference
    from vomstudio.registration.evidence import Evidence, register
    from vomstudio.registration.overlap import require_overlap
    from vomstudio.registration.placing import prepend_warnings

    registration = request.model.registration
    points, spacing = points_and_spacing(
        read_in_file_frame(request.model, progress).data, request.model.path
    )
    target_points, target_spacing = points_and_spacing(
        load_in_world(request.reference, progress), request.reference.path
    )
    initial_similarity = matrix_to_similarity(request.model.to_world)
    evidence = Evidence(pairs=_to_pairs(request.pairs) if request.pairs else None)
    if evidence.pairs is None or evidence.has_too_few_points:
        # One or two points support the fit, but give no initial placement.
        start = initial_similarity
        names = (request.model.name, request.reference.name)
        require_overlap(bounding_box(start(points)), bounding_box(target_points), names)
    else:
        start = matrix_to_similarity(register(evidence).matrix)
        if not request.scale:
            start = replace_scale(start, initial_similarity.scale, points.mean(axis=0))
    flags, stability_findings = _find_stable_points(target_points, request, progress)
    reference_fit = fit_to_reference(
        points,
        target_points,
        start,
        spacing=(spacing * start.scale, target_spacing),
        include_scale=request.scale,
        stable=flags,
        scale_error=None if registration is None else registration.scale_error,
        progress=progress,
    )
    evidence.reference = reference_fit.observation
    placed = prepend_warnings(register(evidence), (*stability_findings, *reference_fit.warnings))
    if not placed.known.all:
        raise GeometryError(Finding("registration.undetermined", parameters=reference_fit.free))
    return FittedModel(
        placed,
        reference_fit.places,
        reference_fit.overlap,
        reference_fit.rms_m,
        reference_fit.blocks,
        reference_fit.block_m,
    )


def _to_pairs(points: tuple[HomologousPoint, ...]) -> Pairs:
    import numpy as np

    from vomstudio.io.control.observation_tables import Pairs

    n = len(points)
    return Pairs(
        tuple(point.label for point in points),
        np.array([point.model for point in points], np.float64),
        np.array([point.reference_point for point in points], np.float64),
        np.full((n, 3), np.nan),
        np.zeros(n, bool),
    )


def _find_stable_points(
    target_points: Array, request: FitRequest, progress: Progress
) -> tuple[BoolArray | None, tuple[Finding, ...]]:
    """Return which reference points (n, 3) are stable (None for all), and messages."""
    import numpy as np

    from vomstudio.registration.by_model import stable

    part = request.stable
    messages: tuple[Finding, ...] = ()
    if part is None:
        return None, messages

    flags = np.ones(len(target_points), bool)
    if part.near_m is not None:
        flags &= stable.find_near_positions(target_points, np.array(part.places), part.near_m)
    if part.box is not None:
        low, high = np.array(part.box)
        flags &= ((target_points >= low) & (target_points <= high)).all(axis=1)
    if part.polygons is not None:
        is_inside, messages = stable.find_inside_polygons(
            target_points, part.polygons, request.reference.crs, progress
        )
        flags &= is_inside
    if part.model is not None:
        from vomstudio.registration.by_model.fit_inputs import points_and_spacing

        mask = load_in_world(part.model, progress)
        flags &= stable.find_near_cloud(target_points, *points_and_spacing(mask, part.model.path))[
            0
        ]
    return flags, messages


FIT_TO_REFERENCE = Job(
    "fit_to_reference", Lane.PRODUCTS, FitRequest, FittedModel, _fit, MEMORY_ADVICE
)


@dataclass(frozen=True)
class ComparisonRequest:
    """Request to compare two models of a project; `out` is the output file for distances."""

    model: PlacedModel
    benchmark: PlacedModel
    options: CompareOptions
    out: Path


@dataclass(frozen=True)
class ComparedModels:
    """Figures as printed by `compare`; `out` contains the fields of all points by name."""

    figures: dict[str, Any]
    out: Path


def _compare_models(request: ComparisonRequest, progress: Progress) -> ComparedModels:
    import numpy as np

    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.registration.distances.comparison import compare
    from vomstudio.registration.overlap import crs_findings

    names = (request.model.name, request.benchmark.name)
    warnings = crs_findings(request.model.crs, request.benchmark.crs, names)
    comparison = compare(
        load_in_world(request.model, progress),
        load_in_world(request.benchmark, progress),
        radius_m=request.options.m3c2_m,
        registration_error_m=request.options.registration_error_m,
        progress=progress,
    )
    request.out.parent.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = comparison.as_fields()
    with atomic_write(request.out, True) as temporary, temporary.open("wb") as file:
        np.savez(file, **arrays)
    findings = [item.to_dict() for item in (*warnings, *comparison.warnings)]
    return ComparedModels(comparison.to_dict() | {"warnings": findings}, request.out)


COMPARE_MODELS = Job(
    "compare_models",
    Lane.PRODUCTS,
    ComparisonRequest,
    ComparedModels,
    _compare_models,
    MEMORY_ADVICE,
)


@dataclass(frozen=True)
class ComparisonExport:
    """Request to write the model in World, with the arrays in `fields`, to `out`."""

    model: PlacedModel
    benchmark: Path
    fields: Path
    out: Path


def _export_comparison(request: ComparisonExport, progress: Progress) -> ExportedModel:
    from vomstudio.core.files.arrays import open_arrays
    from vomstudio.geometry.registration_frames import change_file_frame
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import choose_writer, write_model

    choose_writer(request.out)
    data = load_in_world(request.model, progress)
    with open_arrays(request.fields) as arrays:
        data = replace(data, fields={**data.fields, **arrays})
    inputs = [request.model.path, request.benchmark]
    inputs += [path for item in list(inputs) for path in companions(item)]
    registration = request.model.registration
    if registration is not None:
        registration = change_file_frame(registration, request.model.to_world)
    warnings = write_model(
        data,
        request.model.crs,
        request.out,
        force=True,
        inputs=inputs,
        progress=progress,
        registration=registration,
    )
    return ExportedModel(tuple(warnings))


EXPORT_COMPARISON = Job(
    "export_comparison", Lane.PRODUCTS, ComparisonExport, ExportedModel, _export_comparison
)

JOBS = (FIT_TO_REFERENCE, COMPARE_MODELS, EXPORT_COMPARISON)
