"""Facets: pieces of an outcrop's face that lie in one plane, found automatically.

Region growing after Wang et al. (2017, Computers & Geosciences 103, 100) and its likes, on the
faces of a mesh or the neighbours in a cloud; thresholds of angle and distance, of which the second
is tied to the local resolution. Each facet is fitted and judged as a patch that was brushed by
hand, see geometry/patches.py and geometry/moment_planes.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, GenericArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.extraction.borders.polygons import polygon_of_faces, polygon_of_points, wkt
from vomstudio.extraction.cells.planes import begun_on_cells
from vomstudio.extraction.elements import Begun, Elements, elements_of, middle_of
from vomstudio.extraction.exposure import (
    LEVEL_DEG,
    NEAR_PLANAR_SHARE,
    Exposure,
    exposure_of,
    fills_volume,
    is_grass,
)
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.growing import bending, grown, reach_of
from vomstudio.extraction.kernels import grouped
from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.geology.quality import Verdict, feature_extent_m, judge
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.heights.bends import measure_bend
from vomstudio.geometry.heights.levels import bend_findings, level_findings, level_gap
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.nearby.cell_grid import CellGrid
from vomstudio.geometry.nearby.point_grid import run_in_blocks
from vomstudio.geometry.nearby.shared_corners import snap_corners
from vomstudio.geometry.patches import Moments, face_areas, face_points, moments
from vomstudio.geometry.planes import PlaneFit

# Facets of a mesh with few large faces are told by their area.
_SHARE_OF_MESH = 0.01
# Ours: pieces of a bend are turned by less than the angles that may be within some of them.
_WAVY, _WAVY_TURN = 0.4, 3.0
# Ours, of standard deviations: a strip of even width is 3.5 of its own wide.
_SLICE = 2.0
# Ours; below this share of the spacing layers are no matter.
_TOLD = 0.05
# Ours: of the area, and by as much as areas of a dozen points each make it wider by chance.
_THIN_PART, _CHANCE, _MANY = 0.9, 1.2, 5_000
# In which facets are fitted, several at once.
_PARTS = 64


@dataclass(frozen=True, eq=False)
class Facet:
    """One facet. fit, verdict : of its plane in World; moments : of its points, World; area : m2;
    resolution : m, around it; border : polygon with holes in the plane, as WKT in World; rows : of
    the faces or points; level_gap : m between the levels in which its points lie, None for one;
    bent : it goes over into others beside it, as a piece of a wavy or curved face; bend_deg : from
    edge to edge, None where it does not bend as a whole"""

    fit: PlaneFit
    moments: Moments
    verdict: Verdict
    area: float
    resolution: float
    border: str | None
    rows: IntArray
    level_gap: float | None = None
    bent: bool = False
    bend_deg: float | None = None


@dataclass(frozen=True, eq=False)
class Facets:
    """facets : the largest first; labels : (points,) int32 facet of each point or vertex of the
    model, -1 for none; of : what facets are made of; reach : m, the distance that was allowed
    (median); covers : (points,) int32 of each point, a place in `exposure.COVERS`, -1 for none"""

    facets: list[Facet]
    labels: Int32Array
    of: str
    reach: float
    min_points: int
    exposure: Exposure
    covers: Int32Array
    warnings: tuple[Finding, ...]


def find_facets(
    data: Mesh | PointCloud,
    options: FacetOptions | None = None,
    *,
    thresholds: Thresholds = DEFAULTS,
    progress: Progress | None = None,
) -> Facets:
    """The facets of a model in World, m.

    thresholds : of the profile by which their planes are judged
    Raises GeometryError where the model has no surface, Cancelled through `progress`.
    """
    options = options or FacetOptions()
    progress = progress or Silent()
    if isinstance(data, Mesh) and len(data.faces):
        data = _with_shared_corners(data)

    def begin(local: FloatArray, noisy: bool) -> tuple[CellGrid, Begun]:
        return begun_on_cells(
            local,
            options.used_angle_deg,
            options.max_distance_m,
            options.used_min_points,
            options.min_area_m2 or 0.0,
            progress,
            noisy,
        )

    elements = elements_of(data, options.used_angle_deg, progress, begin)
    reach = reach_of(elements, options.max_distance_m)
    usual = middle_of(reach)
    mesh = data if isinstance(data, Mesh) and elements.of == "face" else None
    fewest = options.used_min_points
    # A mesh has about two faces for each vertex, and many fewer on a piece that is a few faces.
    least_count = fewest if mesh is None else max(fewest // 2, 1)
    least_area = np.inf
    if mesh is not None and options.min_points is None:
        least_area = _SHARE_OF_MESH * float(elements.areas.sum())
    elif mesh is not None:
        least_count = 1
    labels = grown(
        elements,
        angle_deg=options.used_angle_deg,
        reach=reach,
        least_count=least_count,
        least_area=least_area,
        usual=usual,
        progress=progress,
        begun=elements.begun,
    )
    colors = _colors(data, elements)
    labels = _without_most(labels, fills_volume(elements, skin=True))
    if colors is not None:
        elements, labels = _without_grass(elements, labels, colors)
    found, labels = _facets(
        data, elements, labels, options, fewest, least_area, thresholds, progress
    )
    progress.stage(tr("Describing the facets"))
    bent = bending(elements, labels, _WAVY_TURN * options.used_angle_deg)
    found = [_bent(facet) if one else facet for facet, one in zip(found, bent, strict=True)]
    return _told(data, elements, found, labels, usual, fewest, thresholds, colors)


def _with_shared_corners(mesh: Mesh) -> Mesh:
    vertices = np.asarray(mesh.vertices, np.float64)
    faces = np.asarray(mesh.faces, np.int64)
    there = np.asarray(np.isfinite(vertices).all(axis=1))
    own = snap_corners(vertices, faces[there[faces].all(axis=1)])
    return mesh if own is vertices else replace(mesh, vertices=own)


def _without_most(labels: Int32Array, none: BoolArray) -> Int32Array:
    """Without facets most of whose elements are (n,) none of the rock: slices of what fills a
    volume, and lawns."""
    filling = np.flatnonzero(none & (labels >= 0))
    if not len(filling):
        return labels
    count = np.bincount(labels + 1)[1:]
    out = np.append(2 * np.bincount(labels[filling], minlength=len(count)) > count, False)
    return np.where(out[labels], np.int32(-1), labels) if out.any() else labels


def _without_grass(
    elements: Elements, labels: Int32Array, colors: FloatArray
) -> tuple[Elements, Int32Array]:
    """Remove facets that are mostly grass, and add a warning to the elements."""
    rock = _without_most(labels, is_grass(colors))
    lost = (rock < 0) & (labels >= 0)
    if not lost.any():
        return elements, rock
    warning = Finding(
        "facets.vegetation",
        share_percent=max(
            100.0 * float(elements.areas[lost].sum() / np.nansum(elements.areas)), 1.0
        ),
    )
    return replace(elements, warnings=(*elements.warnings, warning)), rock


def facets_of_labels(
    cloud: PointCloud,
    elements: Elements,
    labels: Int32Array,
    options: FacetOptions,
    fewest: int,
    thresholds: Thresholds,
    progress: Progress,
) -> tuple[Facets, IntArray]:
    """Facets of pieces that are known already, and of each the label that it had: labels (n,) of
    the elements, -1 for none."""
    found, fresh = _facets(cloud, elements, labels, options, fewest, np.inf, thresholds, progress)
    kept = np.flatnonzero(fresh >= 0)
    was = np.zeros(len(found), np.int64)
    was[fresh[kept]] = labels[kept]
    # There is no distance by which they were grown: that of the points counts.
    reach = float(np.median(elements.spacing))
    colors = _colors(cloud, elements)
    return _told(cloud, elements, found, fresh, reach, fewest, thresholds, colors), was


def _told(
    data: Mesh | PointCloud,
    elements: Elements,
    found: list[Facet],
    labels: Int32Array,
    reach: float,
    fewest: int,
    thresholds: Thresholds,
    colors: FloatArray | None,
) -> Facets:
    large = np.array([_is_believed(facet, thresholds) for facet in found] + [False])
    level = np.array([(facet.fit.dip_deg or 0.0) < LEVEL_DEG for facet in found] + [False])
    exposure = exposure_of(elements, labels, large[labels], level[labels], colors)
    return Facets(
        found,
        _of_points(data, elements, labels),
        elements.of,
        reach,
        fewest,
        exposure,
        _of_points(data, elements, exposure.covers),
        (*elements.warnings, *_facet_warnings(elements, found, exposure)),
    )


def _facets(
    data: Mesh | PointCloud,
    elements: Elements,
    labels: Int32Array,
    options: FacetOptions,
    fewest: int,
    least_area: float,
    thresholds: Thresholds,
    progress: Progress,
) -> tuple[list[Facet], Int32Array]:
    """The facets that are large enough, numbered anew, and the elements' labels of them."""
    count = max(int(labels.max(initial=-1)) + 1, 0)
    progress.stage(tr("Fitting planes"), count)
    cuts, order = np.zeros(count + 1, np.int64), np.empty(len(labels), np.int64)
    grouped(for_kernels(labels, np.int32), cuts, order)
    made: list[tuple[Facet, IntArray]] = []
    flattest = options.min_coplanarity
    flattest = thresholds.least_coplanarity if flattest is None else flattest
    pieces: list[IntArray] = [order[cuts[i] : cuts[i + 1]] for i in range(count)]
    fitted: list[Facet | None] = [None] * count
    # Each thread has its share of the large ones, which come first.
    spread = np.argsort(np.arange(count) % _PARTS, kind="stable")

    def work(block: slice) -> None:
        for i in spread[block]:
            fitted[i] = _facet(data, elements, pieces[i], thresholds)

    run_in_blocks(work, count, progress, max(1, count // _PARTS))
    for own, facet in zip(pieces, fitted, strict=True):
        if facet is None or facet.area < (options.min_area_m2 or 0.0):
            continue
        if facet.fit.n < fewest and facet.area < least_area:
            continue
        if _is_slice(facet.fit):
            continue
        if facet.fit.coplanarity is not None and facet.fit.coplanarity < flattest:
            continue
        made.append((facet, own))
    made.sort(key=lambda pair: -pair[0].area)
    fresh = np.full(len(labels), -1, np.int32)
    for number, (_, own) in enumerate(made):
        fresh[own] = number
    return [facet for facet, _ in made], fresh


def _facet(
    data: Mesh | PointCloud, elements: Elements, own: IntArray, thresholds: Thresholds
) -> Facet | None:
    rows = elements.rows[own]
    weights: FloatArray | None
    if elements.of == "face":
        assert isinstance(data, Mesh)
        points, weights = face_points(data, rows)
    else:
        points, weights = elements.places[own] + elements.origin, None
    known = moments(points, weights, distinct=elements.of == "point")
    try:
        fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
    except GeometryError:
        return None
    spacing = float(np.sqrt(np.median(elements.areas[own])))
    if elements.of == "face":
        assert isinstance(data, Mesh)
        area = float(face_areas(data, rows).sum())
        spacing = float(np.sqrt(2.0 * np.median(elements.areas[own])))
        corners = np.asarray(data.vertices[data.faces[rows]], np.float64)
        polygon, axes = polygon_of_faces(corners, fit.centroid, fit.normal)
    else:
        wide = max(spacing, _wide_spacing(elements.areas[own]))
        polygon, axes = polygon_of_points(points, wide, fit.centroid, fit.normal)
        area = float(polygon.area)
    resolution = max(spacing, fit.rms or 0.0)
    thick = (fit.rms or 0.0) > _TOLD * spacing
    gap = level_gap(points, fit.normal) if thick else None
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=None,
        kind="patch",
        thresholds=thresholds,
        surface_findings=level_findings(gap),
        bend_deg=(bend := measure_bend(points, fit.normal)),
    )
    border = wkt(polygon, axes, fit.centroid, 0.25 * spacing)
    return Facet(fit, known, verdict, area, resolution, border, rows, gap, bend_deg=bend)


def _wide_spacing(areas: FloatArray) -> float:
    """Of points that stand for areas (n,): where they are thin they are few, but not the area."""
    if len(areas) > _MANY:
        areas = areas[:: len(areas) // _MANY]
    lined = np.sort(areas)
    upto = np.cumsum(lined)
    return float(np.sqrt(lined[np.searchsorted(upto, _THIN_PART * upto[-1])])) / _CHANCE


def _bent(facet: Facet) -> Facet:
    """Said to be a piece of a wavy or curved face."""
    verdict = facet.verdict
    return replace(
        facet,
        bent=True,
        verdict=replace(
            verdict,
            quality="doubtful" if verdict.quality == "good" else verdict.quality,
            reasons=(*verdict.reasons, *bend_findings(True)),
        ),
    )


def _is_slice(fit: PlaneFit) -> bool:
    """The extent across is no more than a few times the scatter, as of a slice of points that fill
    a volume: its plane may as well be one at right angles."""
    _, across, scatter = fit.eigenvalues
    return bool(across < _SLICE**2 * scatter)


def _is_believed(facet: Facet, thresholds: Thresholds) -> bool:
    """It is so large beside the resolution that its error can be believed."""
    extent = feature_extent_m(facet.fit, "patch") or 0.0
    return extent >= thresholds.least_extent_over_resolution * facet.resolution


def _colors(data: Mesh | PointCloud, elements: Elements) -> FloatArray | None:
    if elements.of == "face":
        assert isinstance(data, Mesh)
        colours: GenericArray | None = data.colors
        if colours is None and (textures := TextureColours(data)).any:
            colours = textures.of_vertices
        if colours is None:
            return None
        corners = np.asarray(colours[data.faces[elements.rows]], np.float64)
        return np.asarray(corners.mean(axis=1))
    if data.colors is None:
        return None
    return np.asarray(data.colors[elements.rows], np.float64)


def _of_points(data: Mesh | PointCloud, elements: Elements, labels: Int32Array) -> Int32Array:
    """Facet of each point of the model. A vertex of a mesh has that of the facet with the largest
    part of the faces around it."""
    if elements.of == "point":
        there = elements.row_of >= 0
        result = np.full(len(elements.row_of), -1, np.int32)
        result[there] = labels[elements.row_of[there]]
        return result
    assert isinstance(data, Mesh)
    count = max(int(labels.max(initial=-1)), -1) + 2
    inside = np.flatnonzero(labels >= 0)
    corner = np.asarray(data.faces[elements.rows[inside]], np.int64)
    key = (corner * count + labels[inside, None]).ravel()
    named, which = np.unique(key, return_inverse=True)
    area = np.bincount(which, np.repeat(elements.areas[inside], 3))
    by = np.argsort(area, kind="stable")
    result = np.full(len(data.vertices), -1, np.int32)
    result[named[by] // count] = (named[by] % count).astype(np.int32)
    return result


def _facet_warnings(elements: Elements, facets: list[Facet], exposure: Exposure) -> list[Finding]:
    if not facets and elements.of == "point" and not elements.around:
        return [Finding("facets.volume")]
    if not facets:
        return [Finding("facets.none")]
    warnings = []
    share = exposure.near_planar_share
    if share is not None and share < NEAR_PLANAR_SHARE:
        warnings.append(
            Finding(
                "facets.little-planar",
                share_percent=100.0 * share,
                recommended_percent=100.0 * NEAR_PLANAR_SHARE,
            )
        )
    warnings += _level_ground_warnings(exposure)
    whole = sum(facet.area for facet in facets)
    if sum(facet.area for facet in facets if facet.bent) > _WAVY * whole:
        warnings.append(Finding("facets.wavy"))
    return warnings


def _level_ground_warnings(exposure: Exposure) -> list[Finding]:
    """Report how much of the planar share may be level ground, if it is large."""
    level, share = exposure.level_share or 0.0, exposure.near_planar_share or 0.0
    if level < NEAR_PLANAR_SHARE:
        return []
    rest = (share - level) / (1.0 - level) if level < 1.0 else 0.0
    return [
        Finding(
            "facets.ground",
            share_percent=100.0 * level,
            limit_deg=LEVEL_DEG,
            rest_percent=100.0 * max(rest, 0.0),
        )
    ]
