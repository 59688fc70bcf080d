"""Search for sets and then for their planes, as in Discontinuity Set Extractor (DSE).

The method follows Riquelme, Abellan, Tomas & Jaboyedoff (2014, Computers & Geosciences 68, 38-52):

- The normal of each point is computed from its 30 nearest points, including the point itself, if
  the smallest eigenvalue is at most 20 % of their sum.
- The densest directions of the poles that are at least 10 degrees apart define the sets.
- Each point is assigned to the nearest set within 30 degrees.
- In each set, nearby points form clusters (DBSCAN; Ester, Kriegel, Sander & Xu 1996): four points
  within the mean distance of the fourth neighbour in the set plus two standard deviations, where
  each distance counts once. Clusters of at least 100 points (by default) are planes.

The following values are taken from the source of DSE 2.10 (github.com/adririquelme/DSE): the 30
neighbours and the 20 %, the defaults of its input fields; the share of the smallest eigenvalue; the
four points; and the two standard deviations. The 10 and 30 degrees are the values in its window.
DSE retains clusters of any size and leaves the minimum to the user.

There are two differences. DSE assigns the orientation of the set to all of its clusters unless
asked to fit each of them; here, each cluster is fitted. DSE searches for maxima on a stereonet,
from which the user selects the sets; here, the search is done on the sphere, where a steep set is a
single maximum, and sets have at least a twentieth of the highest density.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.extraction.elements import Elements, build_elements
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facets import FacetSegmentation, build_facets
from vomstudio.extraction.kernels import fit_local_planes
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geology.sets.proposals import SetProposal, sets_from_means
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import run_in_blocks

N_NEIGHBOURS = 30
MAX_VARIATION = 0.2
MIN_SET_ANGLE_DEG = 10.0
MIN_CORE_POINTS = 4
_RADIUS_DEVIATIONS = 2.0
MAX_SETS = 20
_MIN_RELATIVE_DENSITY = 0.05
# Not from DSE: width of the kernel for the density of poles, and number of search directions.
_KERNEL_WIDTH_DEG = 4.0
_N_DIRECTIONS = 6000
_N_REFINEMENTS = 5
_POINTS_PER_BLOCK = 50_000


@dataclass(frozen=True, eq=False)
class SetSequence:
    """Planes and their sets in the same order."""

    facets: FacetSegmentation
    sets: SetProposal


def find_sequence(
    data: Mesh | PointCloud,
    options: FacetOptions,
    *,
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    progress: Progress | None = None,
) -> SetSequence:
    """Find sets, and then their planes, among the points or vertices of a model.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    options : FacetOptions
        Options with the preset "dse"; the angle is the half-angle of the cone about the pole of a
        set.
    thresholds : Thresholds
    progress : Progress, optional

    Returns
    -------
    SetSequence

    Raises
    ------
    GeometryError
        If the model has no surface.
    Cancelled
        Through `progress`.
    """
    progress = progress or SilentProgress()
    points = data.vertices if isinstance(data, Mesh) else data.points
    cloud = PointCloud(np.asarray(points, np.float64), data.colors)
    elements = build_elements(cloud, options.used_angle_deg, progress)
    normals = _compute_normals(elements, progress)
    progress.stage(tr("Finding sets"), None)
    means = find_set_poles(normals)
    set_numbers = _assign_sets(normals, means, options.used_angle_deg)
    labels, sets = _find_clusters(elements, set_numbers, len(means), progress)
    facets, cluster_rows = build_facets(
        cloud, elements, labels, options, options.used_min_points, thresholds, progress
    )
    facet_normals = [facet.fit.normal for facet in facets.facets]
    return SetSequence(facets, sets_from_means(means, facet_normals, sets[cluster_rows]))


def _compute_normals(elements: Elements, progress: Progress) -> FloatArray:
    """Compute the normals (n, 3) of points; NaN if their neighbours are not coplanar."""
    from scipy.spatial import cKDTree

    positions = elements.places
    tree = cKDTree(positions, leafsize=16, compact_nodes=False, balanced_tree=False)
    n, k = len(positions), min(N_NEIGHBOURS, len(positions))
    normals, variation = np.empty((n, 3)), np.empty(n)
    progress.stage(tr("Computing normals"), n)

    def fit_block(block: slice) -> None:
        _, rows = tree.query(positions[block], k=k)
        neighbours = np.ascontiguousarray(rows.reshape(-1, k), np.int32)
        block_results = np.empty((len(neighbours), 3)), np.empty(len(neighbours))
        fit_local_planes(
            positions, to_kernel_array(positions[block], np.float64), neighbours, *block_results
        )
        normals[block], variation[block] = block_results

    run_in_blocks(fit_block, n, progress, _POINTS_PER_BLOCK)
    normals[~(variation <= MAX_VARIATION)] = np.nan
    return normals


def find_set_poles(normals: FloatArray) -> FloatArray:
    """Find the densest directions of axial data.

    Parameters
    ----------
    normals : (n, 3) ndarray
        Unit normals; NaN rows are ignored.

    Returns
    -------
    (k, 3) ndarray
        Poles in order of decreasing density.
    """
    from scipy.spatial import cKDTree

    finite_normals = normals[np.isfinite(normals).all(axis=1)]
    if not len(finite_normals):
        return np.zeros((0, 3))
    nodes = _half_sphere_directions(_N_DIRECTIONS)
    tree = cKDTree(np.concatenate([nodes, -nodes]))
    _, nearest_rows = tree.query(finite_normals)
    count = np.bincount(nearest_rows % len(nodes), minlength=len(nodes)).astype(np.float64)
    filled_rows = np.flatnonzero(count)
    kernel_concentration = 0.5 / np.radians(_KERNEL_WIDTH_DEG) ** 2
    density = np.zeros(len(nodes))
    for first in range(0, len(nodes), 1000):
        cosine = nodes[first : first + 1000] @ nodes[filled_rows].T
        density[first : first + 1000] = (
            np.exp(kernel_concentration * (cosine**2 - 1.0)) @ count[filled_rows]
        )
    poles: list[FloatArray] = []
    max_cosine = np.cos(np.radians(MIN_SET_ANGLE_DEG))
    is_free = np.ones(len(nodes), np.bool_)
    min_density = _MIN_RELATIVE_DENSITY * float(density.max())
    for i in np.argsort(-density, kind="stable"):
        if density[i] < min_density or len(poles) == MAX_SETS:
            break
        if not is_free[i]:
            continue
        is_near = np.abs(nodes @ nodes[i]) >= max_cosine
        is_free[is_near] = False
        # A node on the slope of a denser maximum is not a maximum.
        is_in_kernel = np.abs(nodes @ nodes[i]) >= np.cos(np.radians(_KERNEL_WIDTH_DEG))
        if density[i] >= density[is_in_kernel].max():
            mean = _refine_direction(finite_normals, nodes[i])
            if all(abs(float(mean @ pole)) < max_cosine for pole in poles):
                poles.append(mean)
    return np.array(poles).reshape(-1, 3)


def _half_sphere_directions(count: int) -> FloatArray:
    """Distribute directions evenly over the upper half of the sphere (Fibonacci spiral)."""
    i = np.arange(count) + 0.5
    z = 1.0 - i / count
    azimuth = np.pi * (1.0 + np.sqrt(5.0)) * i
    horizontal_radii = np.sqrt(1.0 - z * z)
    return np.stack(
        [horizontal_radii * np.cos(azimuth), horizontal_radii * np.sin(azimuth), z], axis=1
    )


def _refine_direction(axes: FloatArray, start: FloatArray) -> FloatArray:
    """Refine a coarse direction by averaging the axes within half the minimum set separation."""
    mean = start
    for _ in range(_N_REFINEMENTS):
        near_axes = axes[np.abs(axes @ mean) >= np.cos(np.radians(0.5 * MIN_SET_ANGLE_DEG))]
        if not len(near_axes):
            break
        mean = np.linalg.eigh(near_axes.T @ near_axes)[1][:, 2]
    return mean if mean[2] >= 0 else -mean


def _assign_sets(normals: FloatArray, means: FloatArray, cone_deg: float) -> IntArray:
    """Return the set (n,) of each point; -1 if it belongs to none."""
    if not len(means):
        return np.full(len(normals), -1, np.int64)
    cosine = np.abs(np.nan_to_num(normals) @ means.T)
    nearest_sets = np.argmax(cosine, axis=1)
    is_inside = cosine[np.arange(len(nearest_sets)), nearest_sets] >= np.cos(np.radians(cone_deg))
    return np.where(is_inside, nearest_sets, -1)


def _find_clusters(
    elements: Elements, set_numbers: IntArray, count: int, progress: Progress
) -> tuple[Int32Array, IntArray]:
    """Return the cluster (n,) of each point (-1 for none), and the set of each cluster."""
    assigned_rows = np.flatnonzero(set_numbers >= 0)
    labels = np.full(len(set_numbers), -1, np.int32)
    sets: list[int] = []
    if len(assigned_rows) <= MIN_CORE_POINTS:
        return labels, np.zeros(0, np.int64)
    from scipy.spatial import cKDTree

    progress.stage(tr("Separating planes"), count)
    for number in range(count):
        progress.step(number)
        rows = np.flatnonzero(set_numbers == number)
        if len(rows) <= MIN_CORE_POINTS:
            continue
        tree = cKDTree(elements.places[rows], compact_nodes=False, balanced_tree=False)
        fourth_distances = np.unique(
            tree.query(elements.places[rows], k=MIN_CORE_POINTS + 1)[0][:, -1]
        )
        spread = fourth_distances.std(ddof=1) if len(fourth_distances) > 1 else 0.0
        radius = float(fourth_distances.mean() + _RADIUS_DEVIATIONS * spread)
        clusters = dbscan(elements.places[rows], radius, MIN_CORE_POINTS)
        is_clustered = clusters >= 0
        labels[rows[is_clustered]] = clusters[is_clustered] + len(sets)
        sets += [number] * int(clusters.max(initial=-1) + 1)
    progress.step(count)
    return labels, np.array(sets, np.int64)


def dbscan(positions: FloatArray, radius: float, min_points: int) -> IntArray:
    """Cluster points by density (Ester et al. 1996).

    A point that has `min_points` points within the radius, including itself, is a core point. Core
    points within the radius of each other form a cluster; other points within the radius join the
    nearest core point.

    Parameters
    ----------
    positions : (n, 3) array
        Coordinates in metres.
    radius : float
        Radius in metres.
    min_points : int

    Returns
    -------
    (n,) int array
        Cluster of each point; -1 for noise.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    n = len(positions)
    label = np.full(n, -1, np.int64)
    if n < min_points:
        return label
    tree = cKDTree(positions)
    is_core = tree.query(positions, k=min_points)[0][:, -1] <= radius
    core_rows = np.flatnonzero(is_core)
    if not len(core_rows):
        return label
    core_tree = cKDTree(positions[core_rows])
    pairs = core_tree.query_pairs(radius, output_type="ndarray")
    links = coo_matrix(
        (np.ones(len(pairs), np.bool_), tuple(pairs.T)), (len(core_rows), len(core_rows))
    )
    label[core_rows] = connected_components(links.tocsr(), directed=False)[1]
    border = np.flatnonzero(~is_core)
    if len(border):
        distance, nearest_cores = core_tree.query(positions[border])
        is_near = distance <= radius
        label[border[is_near]] = label[core_rows[nearest_cores[is_near]]]
    return label
