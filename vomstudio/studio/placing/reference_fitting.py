"""Fit of a model to a reference in another file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.results import FLATTENED_IN_JSON, HIDDEN_IN_JSON, Result
from vomstudio.core.words import tr
from vomstudio.geometry.registrations import Registration
from vomstudio.io.models.frames import establish_frame
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.photos.cameras_file import has_known_scale
from vomstudio.registration.by_model.fit_inputs import (
    bounding_box,
    matrix_to_similarity,
    points_and_spacing,
    replace_scale,
)
from vomstudio.registration.by_model.reference import ModelFit, fit_to_reference
from vomstudio.registration.by_model.stable import (
    POLYGON_SUFFIXES,
    find_inside_polygons,
    find_near_cloud,
)
from vomstudio.registration.overlap import crs_findings, require_overlap
from vomstudio.registration.results import ModelPlacement
from vomstudio.registration.surface_points import points_of
from vomstudio.studio.world_models import WorldModel, read_in_world


@dataclass(frozen=True, eq=False)
class ReferenceFit(Result):
    """Fit of a model to a reference.

    `name` is the name of the reference, `fitted` the result of the fit, and `crs` the CRS of the
    World frame. `stable_m` is the distance from a mask cloud within which the reference is
    stable, or None if no mask cloud was used. `scale_fitted` states whether the scale was fitted,
    and `reference` is the registration of the reference, or None if it has no registration.
    """

    name: str = field(metadata=HIDDEN_IN_JSON)
    fitted: ModelFit = field(metadata=FLATTENED_IN_JSON)
    crs: str | None = field(metadata=HIDDEN_IN_JSON)
    stable_m: float | None
    scale_fitted: bool
    warnings: tuple[Finding, ...] = field(metadata=HIDDEN_IN_JSON)
    reference: Registration | None = field(default=None, metadata=HIDDEN_IN_JSON)


@dataclass(frozen=True)
class InitialPlacement:
    """Placement of a model before the fit.

    `to_world` (4, 4) is the matrix from the file frame to the World frame, `crs` the CRS of the
    World frame, and `is_metric` whether its unit is known. `scale_error` is the relative scale
    error (one sigma) of the registration, or None if unknown.
    """

    to_world: Any
    crs: str | None
    is_metric: bool
    scale_error: float | None = None


def _stated_placement(loaded_model: LoadedModel) -> InitialPlacement:
    established = establish_frame(loaded_model)
    frame, registration = established.frame, established.registration
    if registration is not None:
        return InitialPlacement(
            established.to_world(), frame.crs, frame.has_metres, registration.scale_error
        )
    has_known_unit = loaded_model.unit_m is not None or frame.crs is not None
    return InitialPlacement(
        frame.to_world(), frame.crs, has_known_unit or has_known_scale(loaded_model.path) is True
    )


def fit_model(
    loaded_model: LoadedModel,
    reference: str | Path,
    *,
    previous_placement: ModelPlacement | None,
    crs: str | None,
    stable_text: str | Path | None = None,
    initial: InitialPlacement | None = None,
    progress: Progress,
) -> ReferenceFit:
    """Fit a model to a reference in another file.

    Parameters
    ----------
    loaded_model : LoadedModel
    reference : str or Path
    previous_placement : ModelPlacement or None
        Initial placement by other observations. If None, the fit starts with the frames of the
        files.
    crs : str or None
        CRS of the World frame. If None, the CRS of the reference is used.
    stable_text : str or Path, optional
        Mask of the stable part of the reference.
    initial : InitialPlacement, optional
        Placement of the model, by default as stated by its file.
    progress : Progress

    Raises
    ------
    UsageError, InputError, GeometryError, Cancelled
    """
    target = read_in_world(reference, progress)
    names = (loaded_model.path.name, Path(reference).name)
    findings = list(target.warnings)
    if crs is not None:
        findings += crs_findings(crs, target.crs, ("--crs", names[1]))
    initial = initial or _stated_placement(loaded_model)
    similarity = matrix_to_similarity(initial.to_world)
    scale = not initial.is_metric
    points, spacing = points_and_spacing(loaded_model.data, loaded_model.path)
    if previous_placement is None:
        findings += crs_findings(initial.crs, target.crs, names)
        start = similarity
        require_overlap(
            bounding_box(similarity(points)), bounding_box(points_of(target.data)), names
        )
    else:
        start = matrix_to_similarity(previous_placement.matrix)
        if not scale:
            start = replace_scale(start, similarity.scale, points.mean(axis=0))
    target_points, target_spacing = points_and_spacing(target.data, target.loaded.path)
    flags, stable_m = None, None
    if stable_text is not None:
        flags, stable_m, mask_findings = _find_stable_points(
            target_points, target, Path(stable_text), progress
        )
        findings += mask_findings
    reference_fit = fit_to_reference(
        points,
        target_points,
        start,
        spacing=(spacing * start.scale, target_spacing),
        include_scale=scale,
        stable=flags,
        scale_error=initial.scale_error,
        progress=progress,
    )
    return ReferenceFit(
        names[1],
        reference_fit,
        crs if crs is not None else target.crs,
        stable_m,
        scale,
        (*findings, *reference_fit.warnings),
        target.registration,
    )


def _find_stable_points(
    points: FloatArray, target: WorldModel, path: Path, progress: Progress
) -> tuple[BoolArray, float | None, list[Finding]]:
    names = (tr("The mask"), tr("the reference"))
    findings: list[Finding]
    if path.suffix.lower() in POLYGON_SUFFIXES:
        max_distance = None
        flags, layer_findings = find_inside_polygons(points, path, target.crs, progress)
        findings = list(layer_findings)
    else:
        mask = read_in_world(path, progress)
        findings = list(crs_findings(mask.crs, target.crs, names))
        positions, spacing = points_and_spacing(mask.data, mask.loaded.path)
        flags, max_distance = find_near_cloud(points, positions, spacing)
    if not flags.any():
        raise InputError(
            Finding("reference.mask-elsewhere"),
            file=path,
            field="--stable",
        )
    return flags, max_distance, findings
