"""Strike and dip symbols as strokes in pixels, independent of Qt and VTK.

A symbol is drawn in its plane, but its size does not depend on the zoom. The strike and dip
directions of the plane are projected at the position of the symbol, and the strokes have fixed
lengths along them. A direction that is viewed end-on keeps a minimum length, so that no symbol
vanishes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import Symbol, SymbolKind

HALF_STRIKE_LENGTH = 18.0
"""Half the length of a strike line, pixels."""
TICK_LENGTH = 12.0
MIN_DISC_PIXELS = 10.0
"""Diameter in pixels below which a disc is drawn as a dot of this size."""
MIN_TICK_SHARE = 0.55
"""Minimum length of a tick for any attitude of the plane, as a share of its full length."""
MIN_LENGTH_SHARE = 0.3
END_ON_SINE = 0.02
HOOK_LENGTH = 5.5


def _arc(centre: float, radius: float, start_deg: float, end_deg: float, steps: int) -> FloatArray:
    angle = np.radians(np.linspace(start_deg, end_deg, steps + 1))
    points = np.stack([centre + radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    return np.stack([points[:-1], points[1:]], axis=1)


_STRIKE_LINE = np.array([[[-HALF_STRIKE_LENGTH, 0.0], [HALF_STRIKE_LENGTH, 0.0]]])
_DIP_TICK = np.array([[[0.0, 0.0], [0.0, TICK_LENGTH]]])
_SHAPES: dict[SymbolKind, FloatArray] = {
    "plane": np.concatenate([_STRIKE_LINE, _DIP_TICK]),
    # The hook starts on the opposite side of the strike line and curves into the tick.
    "overturned": np.concatenate(
        [_STRIKE_LINE, _DIP_TICK, _arc(-HOOK_LENGTH, HOOK_LENGTH, -180.0, 0.0, 8)]
    ),
    "vertical": np.concatenate(
        [_STRIKE_LINE, [[[0.0, -0.7 * TICK_LENGTH], [0.0, 0.7 * TICK_LENGTH]]]]
    ),
    "horizontal": np.concatenate(
        [
            [[[-10.0, 0.0], [10.0, 0.0]], [[0.0, -10.0], [0.0, 10.0]]],
            _arc(0.0, 10.0, 0.0, 360.0, 20),
        ]
    ),
    "line": np.array(
        [
            [[-HALF_STRIKE_LENGTH, 0.0], [HALF_STRIKE_LENGTH, 0.0]],
            [[HALF_STRIKE_LENGTH, 0.0], [HALF_STRIKE_LENGTH - 9.0, 4.5]],
            [[HALF_STRIKE_LENGTH, 0.0], [HALF_STRIKE_LENGTH - 9.0, -4.5]],
        ]
    ),
}
# Position of the number along and across the strike, and the gap beyond it on the screen, in
# pixels.
_NUMBER: dict[SymbolKind, tuple[float, float]] = {
    "plane": (0.0, TICK_LENGTH),
    "overturned": (0.0, TICK_LENGTH),
    "line": (HALF_STRIKE_LENGTH, 0.0),
}
_NUMBER_GAP = 12.0


@dataclass(frozen=True, eq=False)
class ScreenSymbols:
    """Projection of n symbols onto the screen.

    Parameters
    ----------
    pixels : (n, 2) float64
        Positions of the symbols.
    depth, metres : (n,) float64
        Depth in metres, and metres per pixel at this depth.
    long_axis, cross_axis : (n, 2) float64
        Projections of one pixel along the strike and down the dip onto the screen.
    """

    kinds: tuple[SymbolKind, ...]
    pixels: FloatArray
    depth: FloatArray
    metres: FloatArray
    long_axis: FloatArray
    cross_axis: FloatArray

    def strokes(self, rows: Sequence[int]) -> tuple[FloatArray, IntArray]:
        """Return the end points (s, 2, 2) of the strokes of some symbols, and their rows (s,)."""
        parts, owners = [], []
        selected_rows = np.asarray(rows, dtype=np.int64)
        kinds = np.array([self.kinds[i] for i in selected_rows])
        for kind, shape in _SHAPES.items():
            rows_of_kind = selected_rows[kinds == kind] if len(selected_rows) else selected_rows
            if not len(rows_of_kind):
                continue
            axes = np.stack([self.long_axis[rows_of_kind], self.cross_axis[rows_of_kind]], axis=1)
            strokes = shape[None] @ axes[:, None] + self.pixels[rows_of_kind, None, None]
            parts.append(strokes.reshape(-1, 2, 2))
            owners.append(np.repeat(rows_of_kind, len(shape)))
        if not parts:
            return np.zeros((0, 2, 2)), np.zeros(0, np.int64)
        return np.concatenate(parts), np.concatenate(owners)

    def numbers(self) -> FloatArray:
        """Return the centres (n, 2) of the numbers, NaN for symbols without a number."""
        result = np.full((len(self.kinds), 2), np.nan)
        for kind, (u, v) in _NUMBER.items():
            rows_of_kind = [i for i, k in enumerate(self.kinds) if k == kind]
            if rows_of_kind:
                distances = u * self.long_axis[rows_of_kind] + v * self.cross_axis[rows_of_kind]
                length = np.maximum(np.hypot(*distances.T), 1e-9)[:, None]
                result[rows_of_kind] = self.pixels[rows_of_kind] + distances * (
                    1.0 + _NUMBER_GAP / length
                )
        return result


class SymbolSet:
    """Set of symbols that is prepared for fast projection while the camera moves."""

    def __init__(self, symbols: Sequence[Symbol]) -> None:
        self.kinds = tuple(s.kind for s in symbols)
        self.places = _stack([s.place for s in symbols])
        self._long_axes = _stack([s.long_axis for s in symbols])
        self._cross_axes = _stack([s.cross_axis for s in symbols])
        self._lines = np.array([k == "line" for k in self.kinds], np.bool_)

    def signs(
        self, camera: Camera, size: tuple[float, float], positions: FloatArray | None = None
    ) -> ScreenSymbols:
        """Project the symbols to an image of a given size.

        Parameters
        ----------
        camera : Camera
        size : tuple of float
            Width and height of the image.
        positions : (n, 3) float64, optional
            World positions that replace the positions of the symbols.
        """
        positions = self.places if positions is None else positions
        pixels, depth = camera.project(positions, size)
        offsets = positions - camera.position
        depths = np.maximum(offsets @ camera.direction, 1e-9)
        max_distance = np.full(len(depths), camera.distance) if camera.orthographic else depths
        metres = 2.0 * camera.tangent / max(size[1], 1.0) * max_distance
        slant = np.zeros((len(depths), 2))
        if not camera.orthographic:
            slant = (offsets @ camera.frame[:2].T) / depths[:, None]

        def project_vectors(vectors: FloatArray) -> FloatArray:
            """Return the projections (n, 2) of one-pixel steps along unit vectors (n, 3)."""
            flat_vectors = (
                vectors @ camera.frame[:2].T - slant * (vectors @ camera.direction)[:, None]
            )
            return flat_vectors * [1.0, -1.0]

        strike_vectors = _clamp_length(
            project_vectors(self._long_axes), MIN_LENGTH_SHARE, np.array([1.0, 0.0])
        )
        cross_directions = np.stack([-strike_vectors[:, 1], strike_vectors[:, 0]], axis=1)
        cross_directions /= np.hypot(*cross_directions.T)[:, None]
        # The head of an arrow is flat on the screen.
        cross_ticks = _clamp_length(
            project_vectors(self._cross_axes), MIN_TICK_SHARE, cross_directions
        )
        cross_ticks = np.where(self._lines[:, None], cross_directions, cross_ticks)
        return ScreenSymbols(self.kinds, pixels, depth, metres, strike_vectors, cross_ticks)


def _stack(vectors: Sequence[FloatArray]) -> FloatArray:
    # This is ten times faster than NumPy with a list of arrays.
    return np.concatenate([np.zeros(0), *vectors]).reshape(-1, 3)


def _clamp_length(
    vectors: FloatArray, min_length: float, fallback_directions: FloatArray
) -> FloatArray:
    """Extend vectors (n, 2) to a minimum length, along `fallback_directions` if end-on."""
    lengths = np.hypot(*vectors.T)[:, None]
    enlarged_vectors = np.where(
        lengths < END_ON_SINE,
        min_length * fallback_directions,
        vectors * (min_length / np.maximum(lengths, 1e-12)),
    )
    return np.asarray(np.where(lengths < min_length, enlarged_vectors, vectors))


def plane_symbol(
    dip_direction_deg: float,
    dip_deg: float,
    position: FloatArray,
    extent: float,
    *,
    is_overturned: bool = False,
) -> Symbol:
    """Return the symbol of a plane.

    A dip that rounds to 0 or 90 degrees has no number unless the plane is overturned.
    """
    a, d = np.radians(dip_direction_deg), np.radians(dip_deg)
    strike = np.array([-np.cos(a), np.sin(a), 0.0])
    down = np.array([np.sin(a) * np.cos(d), np.cos(a) * np.cos(d), -np.sin(d)])
    dip = round(dip_deg)
    kind: SymbolKind = "overturned" if is_overturned else "plane"
    if not is_overturned and dip in (0, 90):
        kind = "horizontal" if dip == 0 else "vertical"
    text = "" if kind in ("horizontal", "vertical") else str(dip)
    return Symbol(kind, np.asarray(position, float), strike, down, text, extent)


def line_symbol(trend_deg: float, plunge_deg: float, position: FloatArray, extent: float) -> Symbol:
    """Return the symbol of a line at a World position."""
    t, p = np.radians(trend_deg), np.radians(plunge_deg)
    direction = np.array([np.sin(t) * np.cos(p), np.cos(t) * np.cos(p), -np.sin(p)])
    return Symbol(
        "line", np.asarray(position, float), direction, np.zeros(3), str(round(plunge_deg)), extent
    )


def disc_symbol(position: FloatArray, extent: float) -> Symbol:
    """Return a dot that replaces a disc too small to show its attitude."""
    return Symbol("disc", np.asarray(position, float), np.zeros(3), np.zeros(3), "", extent)
