"""Automatic detection of facets, the planar parts of an outcrop face, and its warnings.

Facets are found by region growing after Wang et al. (2017, Computers & Geosciences 103, 100) and
similar methods, over neighbouring faces of a mesh or points of a cloud. The thresholds are an angle
and a distance that depends on the local resolution. Each facet is fitted and judged like a patch
that is brushed by hand (geometry/patches.py and geometry/moment_planes.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, GenericArray, Int32Array, IntArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.extraction.borders.polygons import enclose_faces, enclose_points, to_wkt
from vomstudio.extraction.cells.planes import find_cell_planes
from vomstudio.extraction.elements import CellPlanes, Elements, approximate_median, build_elements
from vomstudio.extraction.exposure import (
    MAX_LEVEL_DIP_DEG,
    MIN_NEAR_PLANAR_SHARE,
    Exposure,
    find_volume_elements,
    is_grass,
    measure_exposure,
)
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.growing import element_tolerances, find_bent_facets, grow_facets
from vomstudio.extraction.kernels import sort_by_label
from vomstudio.extraction.texture_colours import TextureColours
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geology.quality import Verdict, feature_extent_m, judge
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.heights.bends import measure_bend
from vomstudio.geometry.heights.levels import bend_findings, level_findings, level_gap
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.nearby.cell_grid import CellGrid
from vomstudio.geometry.nearby.point_grid import run_in_blocks
from vomstudio.geometry.nearby.shared_corners import snap_corners
from vomstudio.geometry.patches import Moments, face_areas, face_points, moments
from vomstudio.geometry.planes import FittedPlane

# Minimum size of a facet on a mesh with few large faces, as a share of the area.
_MIN_AREA_SHARE = 0.01
# Not from the paper: share of wavy facets above which a warning is reported, and maximum rotation
# between the pieces of a bend, in multiples of the threshold angle.
_MAX_WAVY_SHARE, _MAX_BEND_ANGLE_FACTOR = 0.4, 3.0
# Not from the paper: minimum width in standard deviations; a strip of constant width has 3.5.
_MIN_WIDTH_DEVIATIONS = 2.0
# Not from the paper: minimum scatter, relative to the spacing, at which levels are tested.
_MIN_LEVEL_SCATTER = 0.05
# Not from the paper: share of the area and spacing correction for sparsely covered parts (the areas
# of a dozen points each make them this much wider by chance), and size of the sample.
_SPARSE_AREA_SHARE, _SPACING_BIAS, _MAX_SAMPLE = 0.9, 1.2, 5_000
# Number of blocks of facets that are fitted in parallel.
_N_FIT_BLOCKS = 64


@dataclass(frozen=True, eq=False)
class Facet:
    """Planar part of the surface.

    Parameters
    ----------
    fit, verdict
        Fitted plane in the World frame, and verdict on it.
    moments : Moments
        Moments of its points in the World frame.
    area : float
        Area in m².
    resolution : float
        Local resolution of the model, m.
    border : str or None
        Polygon with holes in the plane of the facet, as WKT in the World frame; None if empty.
    rows : (k,) int array
        Faces or points of the model that belong to the facet.
    level_gap : float or None
        Distance between two levels of its points, m; None if there is only one level.
    is_bent : bool
        Whether the facet continues into its neighbours as part of a wavy or curved face.
    bend_deg : float or None
        Bend from edge to edge, degrees; None if the facet does not bend as a whole.
    """

    fit: FittedPlane
    moments: Moments
    verdict: Verdict
    area: float
    resolution: float
    border: str | None
    rows: IntArray
    level_gap: float | None = None
    is_bent: bool = False
    bend_deg: float | None = None


@dataclass(frozen=True, eq=False)
class FacetSegmentation:
    """Facets of a model in order of decreasing size.

    Parameters
    ----------
    facets : list of Facet
    labels : (points,) int32 array
        Facet of each point or vertex of the model; -1 if it belongs to none.
    kind : str
        Kind of the surface elements.
    max_distance : float
        Median of the maximum distances from the plane, m; if the labels were given, the median
        spacing of the elements.
    min_points : int
    exposure : Exposure
    cover_classes : (points,) int32 array
        As in `exposure.Exposure`, for each point; -1 if unknown.
    warnings : tuple of Finding
    """

    facets: list[Facet]
    labels: Int32Array
    kind: str
    max_distance: float
    min_points: int
    exposure: Exposure
    cover_classes: Int32Array
    warnings: tuple[Finding, ...]


def find_facets(
    data: Mesh | PointCloud,
    options: FacetOptions | None = None,
    *,
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    progress: Progress | None = None,
) -> FacetSegmentation:
    """Find the facets of a model.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    options : FacetOptions, optional
    thresholds : Thresholds
        Thresholds by which the planes are judged.
    progress : Progress, optional

    Returns
    -------
    FacetSegmentation

    Raises
    ------
    GeometryError
        If the model has no surface.
    Cancelled
        Through `progress`.
    """
    options = options or FacetOptions()
    progress = progress or SilentProgress()
    if isinstance(data, Mesh) and len(data.faces):
        data = _snap_corners(data)

    def find_planes(local_points: FloatArray, is_noisy: bool) -> tuple[CellGrid, CellPlanes]:
        return find_cell_planes(
            local_points,
            options.used_angle_deg,
            options.max_distance_m,
            options.used_min_points,
            options.min_area_m2 or 0.0,
            progress,
            is_noisy,
        )

    elements = build_elements(data, options.used_angle_deg, progress, find_planes)
    max_distance = element_tolerances(elements, options.max_distance_m)
    typical_reach = approximate_median(max_distance)
    mesh = data if isinstance(data, Mesh) and elements.kind == "face" else None
    min_points = options.used_min_points
    # A mesh has about two faces per vertex, but far fewer if it is a piece of a few faces.
    min_count = min_points if mesh is None else max(min_points // 2, 1)
    min_area = np.inf
    if mesh is not None and options.min_points is None:
        min_area = _MIN_AREA_SHARE * float(elements.areas.sum())
    elif mesh is not None:
        min_count = 1
    labels = grow_facets(
        elements,
        angle_deg=options.used_angle_deg,
        max_distances=max_distance,
        min_count=min_count,
        min_area=min_area,
        typical_tolerance=typical_reach,
        progress=progress,
        known_labels=elements.initial_labels,
    )
    colors = _element_colors(data, elements)
    labels = _remove_excluded_facets(labels, find_volume_elements(elements, includes_surface=True))
    if colors is not None:
        elements, labels = _remove_grass_facets(elements, labels, colors)
    facets, labels = _fit_facets(
        data, elements, labels, options, min_points, min_area, thresholds, progress
    )
    progress.stage(tr("Describing the facets"))
    bend_flags = find_bent_facets(elements, labels, _MAX_BEND_ANGLE_FACTOR * options.used_angle_deg)
    facets = [
        _mark_as_bent(facet) if is_bent else facet
        for facet, is_bent in zip(facets, bend_flags, strict=True)
    ]
    return _assemble_segmentation(
        data, elements, facets, labels, typical_reach, min_points, thresholds, colors
    )


def _snap_corners(mesh: Mesh) -> Mesh:
    vertices = np.asarray(mesh.vertices, np.float64)
    faces = np.asarray(mesh.faces, np.int64)
    is_finite = np.asarray(np.isfinite(vertices).all(axis=1))
    snapped_vertices = snap_corners(vertices, faces[is_finite[faces].all(axis=1)])
    return mesh if snapped_vertices is vertices else replace(mesh, vertices=snapped_vertices)


def _remove_excluded_facets(labels: Int32Array, is_excluded: BoolArray) -> Int32Array:
    """Remove facets that mainly consist of excluded elements (n,)."""
    rows = np.flatnonzero(is_excluded & (labels >= 0))
    if not len(rows):
        return labels
    count = np.bincount(labels + 1)[1:]
    is_removed = np.append(2 * np.bincount(labels[rows], minlength=len(count)) > count, False)
    return np.where(is_removed[labels], np.int32(-1), labels) if is_removed.any() else labels


def _remove_grass_facets(
    elements: Elements, labels: Int32Array, colors: FloatArray
) -> tuple[Elements, Int32Array]:
    """Remove facets that mainly consist of grass, and add a warning to the elements."""
    rock_labels = _remove_excluded_facets(labels, is_grass(colors))
    is_removed = (rock_labels < 0) & (labels >= 0)
    if not is_removed.any():
        return elements, rock_labels
    warning = Finding(
        "facets.vegetation",
        share_percent=max(
            100.0 * float(elements.areas[is_removed].sum() / np.nansum(elements.areas)), 1.0
        ),
    )
    return replace(elements, warnings=(*elements.warnings, warning)), rock_labels


def build_facets(
    cloud: PointCloud,
    elements: Elements,
    labels: Int32Array,
    options: FacetOptions,
    min_points: int,
    thresholds: Thresholds,
    progress: Progress,
) -> tuple[FacetSegmentation, IntArray]:
    """Build facets from given labels of the elements.

    Parameters
    ----------
    cloud : PointCloud
    elements : Elements
    labels : (n,) int32 array
        Label of each element; -1 for none.
    options : FacetOptions
    min_points : int
        Minimum number of points in a facet.
    thresholds : Thresholds
    progress : Progress

    Returns
    -------
    facets : FacetSegmentation
    original_labels : (facets,) int array
        Original label of each facet.
    """
    facets, new_labels = _fit_facets(
        cloud, elements, labels, options, min_points, np.inf, thresholds, progress
    )
    rows = np.flatnonzero(new_labels >= 0)
    original_labels = np.zeros(len(facets), np.int64)
    original_labels[new_labels[rows]] = labels[rows]
    # The median spacing is reported because no growing distance is used here.
    max_distance = float(np.median(elements.spacing))
    colors = _element_colors(cloud, elements)
    return _assemble_segmentation(
        cloud, elements, facets, new_labels, max_distance, min_points, thresholds, colors
    ), original_labels


def _assemble_segmentation(
    data: Mesh | PointCloud,
    elements: Elements,
    facets: list[Facet],
    labels: Int32Array,
    max_distance: float,
    min_points: int,
    thresholds: Thresholds,
    colors: FloatArray | None,
) -> FacetSegmentation:
    is_large = np.array([_has_reliable_error(facet, thresholds) for facet in facets] + [False])
    is_level = np.array(
        [(facet.fit.dip_deg or 0.0) < MAX_LEVEL_DIP_DEG for facet in facets] + [False]
    )
    exposure = measure_exposure(elements, labels, is_large[labels], is_level[labels], colors)
    return FacetSegmentation(
        facets,
        _label_points(data, elements, labels),
        elements.kind,
        max_distance,
        min_points,
        exposure,
        _label_points(data, elements, exposure.cover_classes),
        (*elements.warnings, *_facet_warnings(elements, facets, exposure)),
    )


def _fit_facets(
    data: Mesh | PointCloud,
    elements: Elements,
    labels: Int32Array,
    options: FacetOptions,
    min_points: int,
    min_area: float,
    thresholds: Thresholds,
    progress: Progress,
) -> tuple[list[Facet], Int32Array]:
    """Fit facets and renumber those that are large and planar enough.

    Return the remaining facets and the new labels.
    """
    count = max(int(labels.max(initial=-1)) + 1, 0)
    progress.stage(tr("Fitting planes"), count)
    starts, order = np.zeros(count + 1, np.int64), np.empty(len(labels), np.int64)
    sort_by_label(to_kernel_array(labels, np.int32), starts, order)
    accepted_facets: list[tuple[Facet, IntArray]] = []
    min_coplanarity = options.min_coplanarity
    min_coplanarity = thresholds.least_coplanarity if min_coplanarity is None else min_coplanarity
    pieces: list[IntArray] = [order[starts[i] : starts[i + 1]] for i in range(count)]
    fitted_facets: list[Facet | None] = [None] * count
    # Distribute the large facets, which are at the start, evenly over the threads.
    balanced_order = np.argsort(np.arange(count) % _N_FIT_BLOCKS, kind="stable")

    def fit_block(block: slice) -> None:
        for i in balanced_order[block]:
            fitted_facets[i] = _fit_facet(data, elements, pieces[i], thresholds)

    run_in_blocks(fit_block, count, progress, max(1, count // _N_FIT_BLOCKS))
    for rows, facet in zip(pieces, fitted_facets, strict=True):
        if facet is None or facet.area < (options.min_area_m2 or 0.0):
            continue
        if facet.fit.n < min_points and facet.area < min_area:
            continue
        if _is_slice(facet.fit):
            continue
        if facet.fit.coplanarity is not None and facet.fit.coplanarity < min_coplanarity:
            continue
        accepted_facets.append((facet, rows))
    accepted_facets.sort(key=lambda pair: -pair[0].area)
    new_labels = np.full(len(labels), -1, np.int32)
    for number, (_, rows) in enumerate(accepted_facets):
        new_labels[rows] = number
    return [facet for facet, _ in accepted_facets], new_labels


def _fit_facet(
    data: Mesh | PointCloud, elements: Elements, element_rows: IntArray, thresholds: Thresholds
) -> Facet | None:
    rows = elements.rows[element_rows]
    weights: FloatArray | None
    if elements.kind == "face":
        assert isinstance(data, Mesh)
        points, weights = face_points(data, rows)
    else:
        points, weights = elements.places[element_rows] + elements.origin, None
    facet_moments = moments(points, weights, are_distinct=elements.kind == "point")
    try:
        fit = fit_moments(
            facet_moments.n, facet_moments.mean, facet_moments.scatter, facet_moments.n_effective
        )
    except GeometryError:
        return None
    spacing = float(np.sqrt(np.median(elements.areas[element_rows])))
    if elements.kind == "face":
        assert isinstance(data, Mesh)
        area = float(face_areas(data, rows).sum())
        spacing = float(np.sqrt(2.0 * np.median(elements.areas[element_rows])))
        corners = np.asarray(data.vertices[data.faces[rows]], np.float64)
        polygon, axes = enclose_faces(corners, fit.centroid, fit.normal)
    else:
        sparse_spacing = max(spacing, _sparse_spacing(elements.areas[element_rows]))
        polygon, axes = enclose_points(points, sparse_spacing, fit.centroid, fit.normal)
        area = float(polygon.area)
    resolution = max(spacing, fit.rms or 0.0)
    has_scatter = (fit.rms or 0.0) > _MIN_LEVEL_SCATTER * spacing
    gap = level_gap(points, fit.normal) if has_scatter else None
    verdict = judge(
        fit,
        resolution_m=resolution,
        outcrop_normal=None,
        kind="patch",
        thresholds=thresholds,
        surface_findings=level_findings(gap),
        bend_deg=(bend_deg := measure_bend(points, fit.normal)),
    )
    border = to_wkt(polygon, axes, fit.centroid, 0.25 * spacing)
    return Facet(
        fit, facet_moments, verdict, area, resolution, border, rows, gap, bend_deg=bend_deg
    )


def _sparse_spacing(areas: FloatArray) -> float:
    """Return the spacing in the sparse parts of a facet from the area (n,) of each point."""
    if len(areas) > _MAX_SAMPLE:
        areas = areas[:: len(areas) // _MAX_SAMPLE]
    sorted_areas = np.sort(areas)
    cumulative_areas = np.cumsum(sorted_areas)
    return (
        float(
            np.sqrt(
                sorted_areas[
                    np.searchsorted(cumulative_areas, _SPARSE_AREA_SHARE * cumulative_areas[-1])
                ]
            )
        )
        / _SPACING_BIAS
    )


def _mark_as_bent(facet: Facet) -> Facet:
    """Mark a facet as part of a wavy or curved face."""
    verdict = facet.verdict
    return replace(
        facet,
        is_bent=True,
        verdict=replace(
            verdict,
            quality="doubtful" if verdict.quality == "good" else verdict.quality,
            reasons=(*verdict.reasons, *bend_findings(True)),
        ),
    )


def _is_slice(fit: FittedPlane) -> bool:
    """Return whether a facet is a slice of points that fill a volume.

    The width of such a slice is a few times its scatter, so its plane could equally well be
    perpendicular to it.
    """
    _, middle_eigenvalue, scatter = fit.eigenvalues
    return bool(middle_eigenvalue < _MIN_WIDTH_DEVIATIONS**2 * scatter)


def _has_reliable_error(facet: Facet, thresholds: Thresholds) -> bool:
    """Return whether a facet is large enough for a reliable error, given the resolution."""
    extent = feature_extent_m(facet.fit, "patch") or 0.0
    return extent >= thresholds.least_extent_over_resolution * facet.resolution


def _element_colors(data: Mesh | PointCloud, elements: Elements) -> FloatArray | None:
    if elements.kind == "face":
        assert isinstance(data, Mesh)
        colours: GenericArray | None = data.colors
        if colours is None and (textures := TextureColours(data)).has_textures:
            colours = textures.vertex_colours
        if colours is None:
            return None
        corners = np.asarray(colours[data.faces[elements.rows]], np.float64)
        return np.asarray(corners.mean(axis=1))
    if data.colors is None:
        return None
    return np.asarray(data.colors[elements.rows], np.float64)


def _label_points(data: Mesh | PointCloud, elements: Elements, labels: Int32Array) -> Int32Array:
    """Transfer the labels of elements to the points of the model.

    A vertex of a mesh receives the label that has the largest area among its faces.
    """
    if elements.kind == "point":
        has_element = elements.inverse_rows >= 0
        result = np.full(len(elements.inverse_rows), -1, np.int32)
        result[has_element] = labels[elements.inverse_rows[has_element]]
        return result
    assert isinstance(data, Mesh)
    count = max(int(labels.max(initial=-1)), -1) + 2
    labelled_rows = np.flatnonzero(labels >= 0)
    corners = np.asarray(data.faces[elements.rows[labelled_rows]], np.int64)
    key = (corners * count + labels[labelled_rows, None]).ravel()
    pairs, pair_rows = np.unique(key, return_inverse=True)
    area = np.bincount(pair_rows, np.repeat(elements.areas[labelled_rows], 3))
    order = np.argsort(area, kind="stable")
    result = np.full(len(data.vertices), -1, np.int32)
    result[pairs[order] // count] = (pairs[order] % count).astype(np.int32)
    return result


def _facet_warnings(elements: Elements, facets: list[Facet], exposure: Exposure) -> list[Finding]:
    if not facets and elements.kind == "point" and not elements.around:
        return [Finding("facets.volume")]
    if not facets:
        return [Finding("facets.none")]
    warnings = []
    near_planar_share = exposure.near_planar_share
    if near_planar_share is not None and near_planar_share < MIN_NEAR_PLANAR_SHARE:
        warnings.append(
            Finding(
                "facets.little-planar",
                share_percent=100.0 * near_planar_share,
                recommended_percent=100.0 * MIN_NEAR_PLANAR_SHARE,
            )
        )
    warnings += _level_ground_warnings(exposure)
    total_area = sum(facet.area for facet in facets)
    if sum(facet.area for facet in facets if facet.is_bent) > _MAX_WAVY_SHARE * total_area:
        warnings.append(Finding("facets.wavy"))
    return warnings


def _level_ground_warnings(exposure: Exposure) -> list[Finding]:
    """Warn about a large share of planar rock that may be level ground."""
    level_share, near_planar_share = exposure.level_share or 0.0, exposure.near_planar_share or 0.0
    if level_share < MIN_NEAR_PLANAR_SHARE:
        return []
    remaining_share = (
        (near_planar_share - level_share) / (1.0 - level_share) if level_share < 1.0 else 0.0
    )
    return [
        Finding(
            "facets.ground",
            share_percent=100.0 * level_share,
            limit_deg=MAX_LEVEL_DIP_DEG,
            rest_percent=100.0 * max(remaining_share, 0.0),
        )
    ]
