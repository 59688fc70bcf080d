"""Sets first, then their planes: the sequence of the Discontinuity Set Extractor, DSE.

Of Riquelme, Abellan, Tomas & Jaboyedoff (2014, Computers & Geosciences 68, 38-52): a normal for
each point by its 30 nearest, itself among them, where the least eigenvalue is at most 20 % of their
sum; the places where the poles are densest, at least 10 degrees apart, are the sets; each point is
of the nearest within 30 degrees; in each set the points that lie close (DBSCAN; Ester, Kriegel,
Sander & Xu 1996: four points within the mean distance of the fourth neighbour in the set and two
standard deviations of it, each distance counted once) are clusters, of which those of 100 points or
more are planes.

Read in DSE's source, version 2.10 (github.com/adririquelme/DSE): the 30 neighbours and 20 % to
which its boxes return, the share of the least eigenvalue, the four points and two standard
deviations. The 10 and 30 degrees are those of its window, which is no text; it keeps clusters of
any size and leaves their least one to its user. It gives all clusters of a set the set's
orientation unless it is told to fit each; here each is fitted. DSE looks for the densest places on
a stereographic net and leaves it to its user which are sets; here they are looked for on the
sphere, where a steep set is one place, and are sets from a twentieth of the densest on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.extraction.elements import Elements, elements_of
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facets import Facets, facets_of_labels
from vomstudio.extraction.kernels import local_planes
from vomstudio.geology.profiles import DEFAULTS, Thresholds
from vomstudio.geology.sets.proposals import SetProposal, sets_from_means
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.nearby.point_grid import run_in_blocks

NEIGHBOURS = 30
COPLANAR = 0.2
APART_DEG = 10.0
CORE_POINTS = 4
_BEYOND_MEAN = 2.0
MOST_SETS = 20
_LEAST_DENSE = 0.05
# Ours: the width of the kernel by which poles are counted, and the places at which they are.
_KERNEL_DEG = 4.0
_NODES = 6000
_REFINED = 5
_BLOCK = 50_000


@dataclass(frozen=True, eq=False)
class Sequence:
    """facets : the planes; sets : of these, in their order"""

    facets: Facets
    sets: SetProposal


def find_sequence(
    data: Mesh | PointCloud,
    options: FacetOptions,
    *,
    thresholds: Thresholds = DEFAULTS,
    progress: Progress | None = None,
) -> Sequence:
    """Sets and planes of the points or vertices of a model in World, m.

    options : with the preset "dse"; the angle is the half-angle of the cone about a set's pole
    Raises GeometryError where the model has no surface, Cancelled through `progress`.
    """
    progress = progress or Silent()
    points = data.vertices if isinstance(data, Mesh) else data.points
    cloud = PointCloud(np.asarray(points, np.float64), data.colors)
    elements = elements_of(cloud, options.used_angle_deg, progress)
    normals = _normals(elements, progress)
    progress.stage(tr("Finding sets"), None)
    means = set_poles(normals)
    set_of = _assigned(normals, means, options.used_angle_deg)
    labels, sets = _clusters(elements, set_of, len(means), progress)
    facets, was = facets_of_labels(
        cloud, elements, labels, options, options.used_min_points, thresholds, progress
    )
    normals_of = [facet.fit.normal for facet in facets.facets]
    return Sequence(facets, sets_from_means(means, normals_of, sets[was]))


def _normals(elements: Elements, progress: Progress) -> FloatArray:
    """(n, 3) of the points, NaN where their neighbours are not coplanar."""
    from scipy.spatial import cKDTree

    places = elements.places
    tree = cKDTree(places, leafsize=16, compact_nodes=False, balanced_tree=False)
    n, k = len(places), min(NEIGHBOURS, len(places))
    normals, variation = np.empty((n, 3)), np.empty(n)
    progress.stage(tr("Computing normals"), n)

    def work(block: slice) -> None:
        _, rows = tree.query(places[block], k=k)
        own = np.ascontiguousarray(rows.reshape(-1, k), np.int32)
        found = np.empty((len(own), 3)), np.empty(len(own))
        local_planes(places, for_kernels(places[block], np.float64), own, *found)
        normals[block], variation[block] = found

    run_in_blocks(work, n, progress, _BLOCK)
    normals[~(variation <= COPLANAR)] = np.nan
    return normals


def set_poles(normals: FloatArray) -> FloatArray:
    """(k, 3) where axes (n, 3) are densest, the densest first; NaN rows count for nothing."""
    from scipy.spatial import cKDTree

    known = normals[np.isfinite(normals).all(axis=1)]
    if not len(known):
        return np.zeros((0, 3))
    nodes = _half_sphere(_NODES)
    both = cKDTree(np.concatenate([nodes, -nodes]))
    _, nearest = both.query(known)
    count = np.bincount(nearest % len(nodes), minlength=len(nodes)).astype(np.float64)
    filled = np.flatnonzero(count)
    steep = 0.5 / np.radians(_KERNEL_DEG) ** 2
    density = np.zeros(len(nodes))
    for first in range(0, len(nodes), 1000):
        cosine = nodes[first : first + 1000] @ nodes[filled].T
        density[first : first + 1000] = np.exp(steep * (cosine**2 - 1.0)) @ count[filled]
    found: list[FloatArray] = []
    apart = np.cos(np.radians(APART_DEG))
    free = np.ones(len(nodes), np.bool_)
    least = _LEAST_DENSE * float(density.max())
    for i in np.argsort(-density, kind="stable"):
        if density[i] < least or len(found) == MOST_SETS:
            break
        if not free[i]:
            continue
        near = np.abs(nodes @ nodes[i]) >= apart
        free[near] = False
        # A slope of the density is no place of its own.
        around = np.abs(nodes @ nodes[i]) >= np.cos(np.radians(_KERNEL_DEG))
        if density[i] >= density[around].max():
            mean = _refined(known, nodes[i])
            if all(abs(float(mean @ other)) < apart for other in found):
                found.append(mean)
    return np.array(found).reshape(-1, 3)


def _half_sphere(count: int) -> FloatArray:
    """Evenly spread places on the upper half of the sphere (a spiral of Fibonacci)."""
    i = np.arange(count) + 0.5
    z = 1.0 - i / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * i
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _refined(axes: FloatArray, start: FloatArray) -> FloatArray:
    """The mean of the axes within half of what sets are apart, from a place on a coarse grid."""
    mean = start
    for _ in range(_REFINED):
        near = axes[np.abs(axes @ mean) >= np.cos(np.radians(0.5 * APART_DEG))]
        if not len(near):
            break
        mean = np.linalg.eigh(near.T @ near)[1][:, 2]
    return mean if mean[2] >= 0 else -mean


def _assigned(normals: FloatArray, means: FloatArray, cone_deg: float) -> IntArray:
    """(n,) the set of each point, -1 for none."""
    if not len(means):
        return np.full(len(normals), -1, np.int64)
    cosine = np.abs(np.nan_to_num(normals) @ means.T)
    best = np.argmax(cosine, axis=1)
    inside = cosine[np.arange(len(best)), best] >= np.cos(np.radians(cone_deg))
    return np.where(inside, best, -1)


def _clusters(
    elements: Elements, set_of: IntArray, count: int, progress: Progress
) -> tuple[Int32Array, IntArray]:
    """(n,) cluster of each point, -1 for none, and (clusters,) the set of each."""
    inside = np.flatnonzero(set_of >= 0)
    labels = np.full(len(set_of), -1, np.int32)
    sets: list[int] = []
    if len(inside) <= CORE_POINTS:
        return labels, np.zeros(0, np.int64)
    from scipy.spatial import cKDTree

    progress.stage(tr("Separating planes"), count)
    for number in range(count):
        progress.step(number)
        rows = np.flatnonzero(set_of == number)
        if len(rows) <= CORE_POINTS:
            continue
        own = cKDTree(elements.places[rows], compact_nodes=False, balanced_tree=False)
        fourth = np.unique(own.query(elements.places[rows], k=CORE_POINTS + 1)[0][:, -1])
        spread = fourth.std(ddof=1) if len(fourth) > 1 else 0.0
        reach = float(fourth.mean() + _BEYOND_MEAN * spread)
        part = dbscan(elements.places[rows], reach, CORE_POINTS)
        found = part >= 0
        labels[rows[found]] = part[found] + len(sets)
        sets += [number] * int(part.max(initial=-1) + 1)
    progress.step(count)
    return labels, np.array(sets, np.int64)


def dbscan(places: FloatArray, reach: float, core_points: int) -> IntArray:
    """(n,) cluster of each place (n, 3), -1 for noise (Ester et al. 1996). A place with as many
    within `reach`, itself counted, is a core; cores within reach of each other are one cluster, and
    what is in reach of a core is of the cluster of the nearest one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    n = len(places)
    label = np.full(n, -1, np.int64)
    if n < core_points:
        return label
    tree = cKDTree(places)
    core = tree.query(places, k=core_points)[0][:, -1] <= reach
    cores = np.flatnonzero(core)
    if not len(cores):
        return label
    between = cKDTree(places[cores])
    pairs = between.query_pairs(reach, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs), np.bool_), tuple(pairs.T)), (len(cores), len(cores)))
    label[cores] = connected_components(links.tocsr(), directed=False)[1]
    border = np.flatnonzero(~core)
    if len(border):
        distance, nearest = between.query(places[border])
        near = distance <= reach
        label[border[near]] = label[cores[nearest[near]]]
    return label
