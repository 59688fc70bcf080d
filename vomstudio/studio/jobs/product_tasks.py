"""Jobs that create products of a project, such as orthophotos and elevation models."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import to_translate, tr
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.elevation.results import WrittenElevation
from vomstudio.products.ortho import (
    domain_mask,
    interpretation,
    orthophoto,
    planning,
    view_directions,
)
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.model_tasks import Matrix

MEMORY_ADVICE = to_translate("Choose larger pixels or a smaller part, or close other programs.")


@dataclass(frozen=True)
class OrthophotoRequest:
    """Request for an orthophoto of a model.

    Parameters
    ----------
    path, cache : Path
        Model file, and the folder below which the model is cached.
    crs, gsd, region, sheet
        See `write_orthophoto`. If None, the defaults are used.
    draw : Path, optional
        Folder of the project whose features are drawn.
    parts : tuple of str
        Parts of the interpretation that are drawn, a subset of `interpretation.PARTS`.
    domain : (Path, str), optional
        Project, and the domain that is not greyed out.
    """

    path: Path
    cache: Path
    view: view_directions.ViewDirection
    to_world: Matrix
    crs: str | None
    gsd: float | None
    region: planning.ViewRegion | None
    out: Path
    sheet: Path | None
    draw: Path | None = None
    parts: tuple[str, ...] = interpretation.PARTS
    domain: tuple[Path, str] | None = None


@dataclass(frozen=True)
class OrthophotoOutput:
    """Orthophoto that was written.

    Parameters
    ----------
    unit : {"m", "units"}
        Unit of `gsd_m`; "units" if the scale is unknown.
    coverage : float
        Share of pixels that show the model, 0 to 1.
    drawing : tuple of Path
        Files of the drawn features.
    """

    image: Path
    sheet: Path | None
    width: int
    height: int
    gsd_m: float
    unit: str
    coverage: float
    drawing: tuple[Path, ...]
    warnings: tuple[Finding, ...]


def _orthophoto(request: OrthophotoRequest, progress: Progress) -> OrthophotoOutput:
    from vomstudio.io.models import model_cache

    features, domain_territory, items = None, None, tuple[interpretation.Item, ...]()
    if request.domain is not None:
        items = interpretation.read_items(request.domain[0])
        domain_territory = domain_mask.domain_extent(items, request.domain[1])
    if request.draw is not None:
        shown_items = (
            interpretation.read_items(request.draw)
            if domain_territory is None
            else domain_territory.features(items)
        )
        features = interpretation.select_items(shown_items, request.parts)
    folder = model_cache.cache_folder(request.path, request.cache)
    loaded_model = model_cache.load(request.path, folder, progress)
    plan = planning.plan(
        loaded_model.data,
        request.view,
        to_world=request.to_world,
        gsd=request.gsd,
        region=request.region,
    )
    result = orthophoto.write_orthophoto(
        loaded_model.data,
        plan,
        request.out,
        crs=request.crs,
        model=str(request.path),
        content_hash=loaded_model.content_hash,
        sheet=request.sheet,
        force=True,
        progress=progress,
        features=features,
        legend=interpretation.LEGEND in request.parts,
        domain_extent=None
        if domain_territory is None
        else domain_territory.add_view_findings(items, plan),
    )
    return OrthophotoOutput(
        image=Path(result.image),
        sheet=None if result.sheet is None else Path(result.sheet),
        width=plan.grid.width,
        height=plan.grid.height,
        gsd_m=plan.grid.gsd,
        unit="m" if plan.view.is_metric else "units",
        coverage=result.coverage,
        drawing=tuple(result.drawing.values()),
        warnings=tuple(result.warnings),
    )


ORTHOPHOTO = Job(
    "orthophoto", Lane.PRODUCTS, OrthophotoRequest, OrthophotoOutput, _orthophoto, MEMORY_ADVICE
)


@dataclass(frozen=True)
class ElevationRequest:
    """Request for an elevation model of `path`, cached below `cache`; `crs` may be None."""

    path: Path
    cache: Path
    to_world: Matrix
    crs: str | None
    is_metric: bool
    is_north_known: bool
    options: DemOptions
    files: DemFiles
    out: Path


def _elevation(request: ElevationRequest, progress: Progress) -> WrittenElevation:
    import numpy as np

    from vomstudio.geometry.model_transform import transform_model
    from vomstudio.io.models import model_cache
    from vomstudio.products.elevation import writing
    from vomstudio.products.elevation.heights import compute_heights
    from vomstudio.products.elevation.planning import parse_reference_plane, plan_heights

    folder = model_cache.cache_folder(request.path, request.cache)
    loaded_model = model_cache.load(request.path, folder, progress)
    data = transform_model(loaded_model.data, request.to_world)
    options = request.options
    plan = plan_heights(
        data,
        parse_reference_plane(options.plane),
        to_world=np.eye(4),
        gsd=options.gsd_m,
        is_metric=request.is_metric,
    )
    heights, limit = compute_heights(data, plan, options.limit_m, progress)
    progress.stage(tr("Writing the elevation model"))
    return writing.write_elevation(
        heights,
        plan,
        writing.elevation_figures(heights, plan, limit, request.crs),
        request.out,
        files=request.files,
        world=request.crs,
        is_north_known=request.is_north_known,
        model=str(request.path),
        content_hash=loaded_model.content_hash,
        warnings=(*loaded_model.warnings, *plan.notes),
        force=True,
    )


ELEVATION = Job(
    "elevation", Lane.PRODUCTS, ElevationRequest, WrittenElevation, _elevation, MEMORY_ADVICE
)

JOBS = (ORTHOPHOTO, ELEVATION)
