"""Jobs that make products of a project: orthophotos, elevation models."""

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

_COARSER = to_translate("Choose larger pixels or a smaller part, or close other programs.")


@dataclass(frozen=True)
class OrthophotoOrder:
    """Of the model `path`, kept at hand under `cache`. crs, gsd, region and sheet may be None.
    draw : folder of the project whose features are drawn, None for none; parts : which of
    `interpretation.PARTS`; domain : the only one that is not grey, of the project in a folder"""

    path: Path
    cache: Path
    view: view_directions.View
    to_world: Matrix
    crs: str | None
    gsd: float | None
    region: planning.Region | None
    out: Path
    sheet: Path | None
    draw: Path | None = None
    parts: tuple[str, ...] = interpretation.PARTS
    domain: tuple[Path, str] | None = None


@dataclass(frozen=True)
class WrittenOrthophoto:
    """unit : of gsd_m, "m", or "units" where the scale is not known; coverage : share, 0 to 1;
    drawing : files of the features"""

    image: Path
    sheet: Path | None
    width: int
    height: int
    gsd_m: float
    unit: str
    coverage: float
    drawing: tuple[Path, ...]
    warnings: tuple[Finding, ...]


def _orthophoto(asked: OrthophotoOrder, progress: Progress) -> WrittenOrthophoto:
    from vomstudio.io.models import model_cache

    features, only, items = None, None, tuple[interpretation.Item, ...]()
    if asked.domain is not None:
        items = interpretation.read_items(asked.domain[0])
        only = domain_mask.territory(items, asked.domain[1])
    if asked.draw is not None:
        shown = interpretation.read_items(asked.draw) if only is None else only.features(items)
        features = interpretation.items_shown(shown, asked.parts)
    folder = model_cache.folder_of(asked.path, asked.cache)
    loaded = model_cache.load(asked.path, folder, progress)
    plan = planning.plan(
        loaded.data, asked.view, to_world=asked.to_world, gsd=asked.gsd, region=asked.region
    )
    made = orthophoto.write_orthophoto(
        loaded.data,
        plan,
        asked.out,
        crs=asked.crs,
        model=str(asked.path),
        content_hash=loaded.content_hash,
        sheet=asked.sheet,
        force=True,
        progress=progress,
        features=features,
        legend=interpretation.LEGEND in asked.parts,
        only=None if only is None else only.seen_in(items, plan),
    )
    return WrittenOrthophoto(
        image=Path(made.image),
        sheet=None if made.sheet is None else Path(made.sheet),
        width=plan.grid.width,
        height=plan.grid.height,
        gsd_m=plan.grid.gsd,
        unit="m" if plan.view.metric else "units",
        coverage=made.coverage,
        drawing=tuple(made.drawing.values()),
        warnings=tuple(made.warnings),
    )


ORTHOPHOTO = Job(
    "orthophoto", Lane.PRODUCTS, OrthophotoOrder, WrittenOrthophoto, _orthophoto, _COARSER
)


@dataclass(frozen=True)
class ElevationOrder:
    """Elevation model of the model `path`, whose cache is in the folder `cache`. crs : of World"""

    path: Path
    cache: Path
    to_world: Matrix
    crs: str | None
    metric: bool
    north_known: bool
    options: DemOptions
    files: DemFiles
    out: Path


def _elevation(asked: ElevationOrder, progress: Progress) -> WrittenElevation:
    import numpy as np

    from vomstudio.geometry.model_transform import moved
    from vomstudio.io.models import model_cache
    from vomstudio.products.elevation import writing
    from vomstudio.products.elevation.heights import draw_heights
    from vomstudio.products.elevation.planning import plan_heights, reference_plane

    folder = model_cache.folder_of(asked.path, asked.cache)
    loaded = model_cache.load(asked.path, folder, progress)
    data = moved(loaded.data, asked.to_world)
    options = asked.options
    plan = plan_heights(
        data,
        reference_plane(options.plane),
        to_world=np.eye(4),
        gsd=options.gsd_m,
        metric=asked.metric,
    )
    heights, limit = draw_heights(data, plan, options.limit_m, progress)
    progress.stage(tr("Writing the elevation model"))
    return writing.write_elevation(
        heights,
        plan,
        writing.figures_of(heights, plan, limit, asked.crs),
        asked.out,
        files=asked.files,
        world=asked.crs,
        north_known=asked.north_known,
        model=str(asked.path),
        content_hash=loaded.content_hash,
        warnings=(*loaded.warnings, *plan.notes),
        force=True,
    )


ELEVATION = Job("elevation", Lane.PRODUCTS, ElevationOrder, WrittenElevation, _elevation, _COARSER)

JOBS = (ORTHOPHOTO, ELEVATION)
