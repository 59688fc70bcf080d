"""Jobs with two models: one is fitted to the other, or held against it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate
from vomstudio.registration.distances.compare_options import CompareOptions
from vomstudio.registration.results import Placed
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.model_tasks import ExportedModel
from vomstudio.studio.jobs.placed_model import StandingModel, in_world, read_standing

if TYPE_CHECKING:
    from vomstudio.core.arrays import BoolArray, FloatArray
    from vomstudio.core.findings import Finding
    from vomstudio.io.control.observation_tables import Pairs

    Array = FloatArray

Point = tuple[float, float, float]

_PART = to_translate("Use a smaller part of the model, or close other programs.")


@dataclass(frozen=True)
class HomologousPoint:
    """model : in its own frame; there : the same point on the reference, World"""

    label: str
    model: Point
    there: Point


@dataclass(frozen=True)
class StablePart:
    """What of the reference has stayed where it was: within `near_m` of one of the `places`, inside
    of a box (low, high), or inside of the polygons of a layer, seen from above; or near a cloud or
    mesh, as the option --stable has it."""

    near_m: float | None = None
    places: tuple[Point, ...] = ()
    model: StandingModel | None = None
    box: tuple[Point, Point] | None = None
    polygons: Path | None = None


@dataclass(frozen=True)
class FitOrder:
    """scale : it is one of the unknowns; pairs : three or more, or fewer where the model stands
    near the reference already; stable : None for all of the reference"""

    model: StandingModel
    reference: StandingModel
    scale: bool
    pairs: tuple[HomologousPoint, ...]
    stable: StablePart | None


@dataclass(frozen=True)
class FittedModel:
    """placed : by pairs and surfaces together; the others as in `FittedToReference`"""

    placed: Placed
    places: int
    overlap: float
    rms_m: float
    blocks: int
    block_m: float


def _fit(asked: FitOrder, progress: Progress) -> FittedModel:
    from vomstudio.core.errors import GeometryError
    from vomstudio.core.findings import Finding
    from vomstudio.registration.by_model.reference import fit_to_reference
    from vomstudio.registration.by_model.starting import (
        box_of,
        points_and_spacing,
        replace_scale,
        similarity_of,
    )
    from vomstudio.registration.evidence import Evidence, register
    from vomstudio.registration.overlap import require_overlap
    from vomstudio.registration.placing import prepend_warnings

    registration = asked.model.registration
    points, spacing = points_and_spacing(
        read_standing(asked.model, progress).data, asked.model.path
    )
    there, its_spacing = points_and_spacing(
        in_world(asked.reference, progress), asked.reference.path
    )
    stands = similarity_of(asked.model.to_world)
    evidence = Evidence(pairs=_pairs(asked.pairs) if asked.pairs else None)
    if evidence.pairs is None or evidence.too_few_alone:
        # One point or two help the surfaces, but do not say where these begin.
        start = stands
        names = (asked.model.name, asked.reference.name)
        require_overlap(box_of(start(points)), box_of(there), names)
    else:
        start = similarity_of(register(evidence).matrix)
        if not asked.scale:
            start = replace_scale(start, stands.scale, points.mean(axis=0))
    flags, about_stable = _stable(there, asked, progress)
    fitted = fit_to_reference(
        points,
        there,
        start,
        spacing=(spacing * start.scale, its_spacing),
        scale=asked.scale,
        stable=flags,
        scale_error=None if registration is None else registration.scale_error,
        progress=progress,
    )
    evidence.reference = fitted.observation
    placed = prepend_warnings(register(evidence), (*about_stable, *fitted.warnings))
    if not placed.known.all:
        raise GeometryError(Finding("registration.undetermined", parameters=fitted.free))
    return FittedModel(
        placed, fitted.places, fitted.overlap, fitted.rms_m, fitted.blocks, fitted.block_m
    )


def _pairs(points: tuple[HomologousPoint, ...]) -> Pairs:
    import numpy as np

    from vomstudio.io.control.observation_tables import Pairs

    n = len(points)
    return Pairs(
        tuple(point.label for point in points),
        np.array([point.model for point in points], np.float64),
        np.array([point.there for point in points], np.float64),
        np.full((n, 3), np.nan),
        np.zeros(n, bool),
    )


def _stable(
    there: Array, order: FitOrder, progress: Progress
) -> tuple[BoolArray | None, tuple[Finding, ...]]:
    """Return which of the points (n, 3) of the reference count, None for all, and messages."""
    import numpy as np

    from vomstudio.registration.by_model import stable

    part = order.stable
    messages: tuple[Finding, ...] = ()
    if part is None:
        return None, messages

    flags = np.ones(len(there), bool)
    if part.near_m is not None:
        flags &= stable.near_places(there, np.array(part.places), part.near_m)
    if part.box is not None:
        low, high = np.array(part.box)
        flags &= ((there >= low) & (there <= high)).all(axis=1)
    if part.polygons is not None:
        inside, messages = stable.find_inside_polygons(
            there, part.polygons, order.reference.crs, progress
        )
        flags &= inside
    if part.model is not None:
        from vomstudio.registration.by_model.starting import points_and_spacing

        mask = in_world(part.model, progress)
        flags &= stable.near_cloud(there, *points_and_spacing(mask, part.model.path))[0]
    return flags, messages


FIT_TO_REFERENCE = Job("fit_to_reference", Lane.PRODUCTS, FitOrder, FittedModel, _fit, _PART)


@dataclass(frozen=True)
class CompareOrder:
    """Comparison of two models of a project. out : the file for the distances"""

    model: StandingModel
    benchmark: StandingModel
    options: CompareOptions
    out: Path


@dataclass(frozen=True)
class ComparedModels:
    """figures : as the command `compare` prints them; out : arrays of all points of the model, by
    the names of its fields"""

    figures: dict[str, Any]
    out: Path


def _compare(asked: CompareOrder, progress: Progress) -> ComparedModels:
    import numpy as np

    from vomstudio.core.files.atomic import atomic_write
    from vomstudio.registration.distances.comparison import compare
    from vomstudio.registration.overlap import crs_findings

    names = (asked.model.name, asked.benchmark.name)
    said = crs_findings(asked.model.crs, asked.benchmark.crs, names)
    found = compare(
        in_world(asked.model, progress),
        in_world(asked.benchmark, progress),
        radius_m=asked.options.m3c2_m,
        registration_error_m=asked.options.registration_error_m,
        progress=progress,
    )
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = found.as_fields()
    with atomic_write(asked.out, True) as temporary, temporary.open("wb") as file:
        np.savez(file, **arrays)
    figures = found.to_dict()
    return ComparedModels(
        figures | {"warnings": [str(each) for each in (*said, *found.warnings)]}, asked.out
    )


COMPARE_MODELS = Job("compare_models", Lane.PRODUCTS, CompareOrder, ComparedModels, _compare, _PART)


@dataclass(frozen=True)
class ComparisonExport:
    """The model with the arrays in `fields`, in World, goes to `out`."""

    model: StandingModel
    benchmark: Path
    fields: Path
    out: Path


def _export(asked: ComparisonExport, progress: Progress) -> ExportedModel:
    from vomstudio.core.files.arrays import open_arrays
    from vomstudio.geometry.registration_frames import change_file_frame
    from vomstudio.io.models.model_copy import companions
    from vomstudio.io.models.writing import choose_writer, write_model

    choose_writer(asked.out)
    data = in_world(asked.model, progress)
    with open_arrays(asked.fields) as arrays:
        data = replace(data, fields={**data.fields, **arrays})
    inputs = [asked.model.path, asked.benchmark]
    inputs += [path for each in list(inputs) for path in companions(each)]
    registration = asked.model.registration
    if registration is not None:
        registration = change_file_frame(registration, asked.model.to_world)
    said = write_model(
        data,
        asked.model.crs,
        asked.out,
        force=True,
        inputs=inputs,
        progress=progress,
        registration=registration,
    )
    return ExportedModel(tuple(said))


EXPORT_COMPARISON = Job(
    "export_comparison", Lane.PRODUCTS, ComparisonExport, ExportedModel, _export
)

JOBS = (FIT_TO_REFERENCE, COMPARE_MODELS, EXPORT_COMPARISON)
