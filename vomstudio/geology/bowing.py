"""Whether a model is bowed like a dome, by the residuals of points or cameras across it.

A block of photos with a wrong lens bends: its middle stands out of, or lies behind, its edges, by
c r^2 at a distance r from the middle (James & Robson 2014, Earth Surface Processes and Landforms
39, 1413-1420). Dips then change by 2 c r from the middle outwards, which looks like an open fold.

The residuals along the model's normal are regressed on 1, u, v and u^2 + v^2, u and v being places
in its mean plane. The first three are what a registration absorbs (shift and tilt), so that points
that placed the model and points that only judge it can be taken together: both differ from the
truth by the same shift and tilt. Whether c differs from nothing is told by Student's t.

Cameras bend with the model: one at a place r from the middle is turned by 2 c r, outwards or
inwards. Verticals of photos (rolls and pitches of a gimbal, the accelerometer of a phone) show
that without any point, as turns that grow with the distance from the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.serial_errors import correlation_of, whitened

FEWEST = 6
"""Points: four unknowns, and two to judge them by."""

LEVEL = 0.05
_THIN = 0.05
# A stray point far behind the outcrop is not its edge.
_EDGE = 0.999
# Relief, beside the extent, from which on points tell depths.
_RELIEF = 0.02


@dataclass(frozen=True)
class Bowing:
    """n : points, or photos; curvature_per_m : c, along the normal that points up: negative of a
    dome, positive of a dish; error95_per_m : of that; reach_m : from the middle to the edge of the
    model; significant : c differs from nothing, wrongly so said of one model in twenty that is not
    bowed; normal : unit vector, of the mean plane
    """

    n: int
    curvature_per_m: float
    error95_per_m: float
    reach_m: float
    significant: bool
    normal: tuple[float, float, float]

    @property
    def side_deg(self) -> float:
        """By how much dips at the edge differ from those in the middle."""
        return float(np.degrees(2.0 * abs(self.curvature_per_m) * self.reach_m))

    @property
    def side_error95_deg(self) -> float:
        return float(np.degrees(2.0 * self.error95_per_m * self.reach_m))

    @property
    def across_deg(self) -> float:
        """By how much dips at one edge differ from those at the opposite one."""
        return 2.0 * self.side_deg

    @property
    def rise_m(self) -> float:
        """How far the edge is off the plane that touches the middle."""
        return abs(self.curvature_per_m) * self.reach_m**2

    @property
    def edges_toward(self) -> FloatArray:
        """(3,) unit vector, along which the edges are off the plane that touches the middle."""
        return np.array(self.normal) * (1.0 if self.curvature_per_m > 0.0 else -1.0)


@dataclass(frozen=True)
class LensBend:
    """How the errors of lenses may deform a model, 95 %.

    curvature95_per_m : c of the bowing; reach_m : from the middle to the edge of the model;
    stretch95 : of depths (along the model's normal) beside lengths along the model, relative
    """

    curvature95_per_m: float
    reach_m: float
    stretch95: float

    @property
    def side_deg(self) -> float:
        """By how much dips at the edge may differ from those in the middle."""
        return float(np.degrees(2.0 * self.curvature95_per_m * self.reach_m))

    @property
    def across_deg(self) -> float:
        """By how much dips at one edge may differ from those at the opposite one."""
        return 2.0 * self.side_deg

    @property
    def stretch_deg(self) -> float:
        """By how much it may turn planes that are inclined to the model by 45 degrees, the most of
        all."""
        return float(np.degrees(self.stretch95 / 2.0))


def bowing_deg(lens_across95_deg: float | None, seen: Bowing | None) -> float | None:
    """By how much dips may differ from edge to edge because the model is bowed: by what residuals
    show, or else by what the errors of the lenses can do (95 %) and the residuals allow; None where
    nothing tells of it."""
    if seen is not None and seen.significant:
        return seen.across_deg
    if lens_across95_deg is None:
        return None
    if seen is None:
        return lens_across95_deg
    return min(lens_across95_deg, 2.0 * (seen.side_deg + seen.side_error95_deg))


@dataclass(frozen=True, eq=False)
class ShapeChange:
    """turn : (3,) radians, of the model as a whole; growth : relative, along the model; shift :
    (3,) of its middle; curvature_per_m : c; stretch : relative, of depths beside lengths along the
    model, 0 where it has no relief
    """

    turn: FloatArray
    growth: float
    shift: FloatArray
    curvature_per_m: float
    stretch: float


def shape_change(places: FloatArray, moves: FloatArray) -> ShapeChange:
    """What small moves (n, 3) of the points (n, 3) of a model are as a whole, by least squares.

    Raises numpy.linalg.LinAlgError for what is not finite.
    """
    middle, axes, reach = model_shape(places)
    u, v, w = ((places - middle) @ axes.T).T / reach
    along = moves @ axes.T
    columns = [np.ones(len(u)), u, v]
    relief = float(w.std()) > _RELIEF
    if relief:
        columns.append(w)
    flat = np.linalg.lstsq(np.stack(columns, axis=1), along[:, :2], rcond=None)[0]
    bent = np.stack([*columns, u**2 + v**2], axis=1)
    out = np.linalg.lstsq(bent, along[:, 2], rcond=None)[0]
    growth = float(flat[1, 0] + flat[2, 1]) / 2.0 / reach
    turns = np.array([out[2], -out[1], (flat[1, 1] - flat[2, 0]) / 2.0]) / reach
    stretch = float(out[3]) / reach - growth if relief else 0.0
    shift = np.array([*flat[0], out[0]]) @ axes
    return ShapeChange(turns @ axes, growth, shift, float(out[-1]) / reach**2, stretch)


def bowing_of(
    places: FloatArray,
    residuals: FloatArray,
    sigma: FloatArray | None = None,
    extent: FloatArray | None = None,
    normal: FloatArray | None = None,
) -> Bowing | None:
    """The bowing that residuals show; None where too few points, or points on a line, or all at one
    distance from the middle, tell nothing of it.

    places, residuals : (n, 3), World, fitted less given, in the order in which they were taken:
        errors that follow each other, as those of a receiver that drifts, are not taken for a bend
    sigma : (n, 3) stated errors of the coordinates, by which they are weighted; None for none
    extent : (m, 3) points all over the model, whose mean plane, middle and edge count; None to take
        those of the places
    normal : (3,) of the model's mean plane, where its points are not at hand
    """
    n = len(places)
    if n < FEWEST:
        return None
    middle, axes, reach = _shape(places, extent)
    if normal is not None:
        across = np.cross(axes[0], normal)
        across /= np.linalg.norm(across) or 1.0
        axes = np.array([np.cross(across, normal), across, normal])
    flat, normal = (places - middle) @ axes[:2].T, axes[2]
    size = float(np.sqrt((flat**2).sum(axis=1).mean()))
    if not size > 0.0 or np.linalg.svd(flat - flat.mean(axis=0), compute_uv=False)[-1] < (
        _THIN * size * np.sqrt(n)
    ):
        return None
    u, v = (flat / size).T
    columns = np.stack([np.ones(n), u, v, u**2 + v**2], axis=1)
    weight = np.ones(n)
    if sigma is not None and np.isfinite(sigma).all() and (sigma > 0).all():
        weight = 1.0 / np.sqrt((sigma**2) @ normal**2)
        weight = weight / weight.mean()
    drift = _drift(columns, residuals @ axes.T)
    rows = whitened(columns * weight[:, None], drift)
    # How much of the last column the others leave: all at one distance say nothing.
    rest = rows[:, 3] - rows[:, :3] @ np.linalg.lstsq(rows[:, :3], rows[:, 3], rcond=None)[0]
    if float(rest @ rest) < _THIN**2 * float(rows[:, 3] @ rows[:, 3]):
        return None
    out = whitened((residuals @ normal) * weight, drift)
    # Fitted less given is the model's bend itself.
    bend, error = _last_of(rows, out, rest)
    return _bowing(n, bend / size**2, error / size**2, reach, normal)


def _drift(columns: FloatArray, residuals: FloatArray) -> float:
    """The correlation of neighbours among what the columns (n, k) leave of residuals (n, 3)."""
    left = residuals - columns @ np.linalg.lstsq(columns, residuals, rcond=None)[0]
    sizes = np.sqrt((left**2).mean(axis=0))
    if not (sizes > 0.0).all():
        return 0.0
    k = columns.shape[1]
    moves = np.zeros((len(columns), 3, 3 * k))
    for axis in range(3):
        moves[:, axis, axis * k : (axis + 1) * k] = columns
    return correlation_of(moves, left / sizes)


def bowing_of_turns(
    places: FloatArray, turns: FloatArray, cameras: FloatArray, extent: FloatArray | None = None
) -> Bowing | None:
    """The bowing that the verticals of photos show; None where too few photos, or photos all at one
    place along the model, tell nothing of it.

    places : (n, 3) of the cameras, World
    turns : (n, 3) by which each photo is turned in the model against what it says itself, radians,
        World; of these the parts about east and north count, which a vertical tells
    cameras : (n, 3, 3) rotations from the cameras to World: a mount that is out of line turns with
        them, and all around a rock would look like bowing
    extent : (m, 3) points all over the model, as in `bowing_of`
    """
    n = len(places)
    if n < FEWEST:
        return None
    middle, axes, reach = _shape(places, extent)
    u, v = ((places - middle) @ axes[:2].T).T
    # The surface w = c (u^2 + v^2) has the normal w - 2 c (u, v): a turn by w x that.
    along = np.outer(u, np.cross(axes[2], axes[0])) + np.outer(v, np.cross(axes[2], axes[1]))
    by_bend = -2.0 * along[:, :2]
    size = float(np.sqrt((by_bend**2).mean()))
    if not size > 0.0:
        return None
    each = np.zeros((n, 2, 6))
    # What a registration absorbs is the same in all.
    each[:, 0, 0] = each[:, 1, 1] = 1.0
    each[:, :, 2:5] = cameras[:, :2, :]
    each[:, :, 5] = by_bend / size
    rows = each.reshape(-1, 6)
    rest = rows[:, 5] - rows[:, :5] @ np.linalg.lstsq(rows[:, :5], rows[:, 5], rcond=1e-6)[0]
    if float(rest @ rest) < _THIN**2 * float(rows[:, 5] @ rows[:, 5]):
        return None
    bend, error = _last_of(rows, turns[:, :2].ravel(), rest)
    return _bowing(n, bend / size, error / size, reach, axes[2])


def model_shape(points: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Of points (m, 3) all over a model: its middle (3,), axes (3, 3) in rows, the last one the
    normal that points up and all of them right-handed, and its reach: the distance from the middle,
    along its mean plane, to its edge, beyond which one point in a thousand lies."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    if axes[2, 2] < 0.0:
        axes[2] = -axes[2]
    axes[1] = np.cross(axes[2], axes[0])
    away = np.linalg.norm((points - middle) @ axes[:2].T, axis=1)
    return middle, axes, float(np.quantile(away, _EDGE, method="higher"))


def _bowing(n: int, curvature: float, error: float, reach: float, normal: FloatArray) -> Bowing:
    x, y, z = (float(v) for v in normal)
    return Bowing(n, curvature, error, reach, abs(curvature) > error, (x, y, z))


def _shape(places: FloatArray, extent: FloatArray | None) -> tuple[FloatArray, FloatArray, float]:
    """`model_shape` of the model, or, where that is not known, of the places."""
    return model_shape(places if extent is None or len(extent) < FEWEST else extent)


def _last_of(rows: FloatArray, out: FloatArray, rest: FloatArray) -> tuple[float, float]:
    """The last unknown of a regression, and its 95 % error by what is left over. rest : what the
    other columns leave of the last one"""
    from scipy.special import stdtrit

    # Photos that all look one way cannot tell a mount from the registration.
    found, _, rank, _ = np.linalg.lstsq(rows, out, rcond=1e-6)
    left = out - rows @ found
    free = len(rows) - int(rank)
    variance = float(left @ left) / free / float(rest @ rest)
    error = float(stdtrit(free, 1.0 - LEVEL / 2.0)) * float(np.sqrt(variance))
    return float(found[-1]), error
