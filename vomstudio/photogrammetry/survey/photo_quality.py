"""Measurement of the pixel quality of photos, comparable within a set.

Blur is measured as the width of edges and not as the amount of detail, so that a wall of fine
gravel and a smooth slab have the same value with the same lens. The method follows Zhuo & Sim 2011
(Pattern Recognition 44, 1852). If an edge with Gaussian blur sigma is blurred again by a known
sigma0, the gradient at its centre decreases by the factor R = sqrt(sigma^2 + sigma0^2) / sigma,
hence sigma = sigma0 / sqrt(R^2 - 1). Blur is measured across and along the picture, and the larger
value is used, because motion blurs only one direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


_TILE_PX = 384
_MAX_TILES = 16
_REBLUR_SIGMA_PX = 1.5
# Above this sigma, the second blurring changes too little, so measure at half the size.
_MAX_BLUR_SIGMA_PX = 2.0
_EDGE_QUANTILE = 0.5
_STRONG_QUANTILE = 0.99
_SMOOTHING_SIGMA_PX = 0.8


@dataclass(frozen=True)
class PhotoQuality:
    """Quality of a photo.

    Attributes
    ----------
    blur_px : float or None
        Sigma of the strongest edges in pixels of the full photo. About 0.5 to 1 is sharp. None if
        the photo has too few edges.
    brightness : float
        Mean linear light, 0 to 1.
    saturated_share : float
        Share of saturated pixels.
    resampling_strength : float
        Strength of an interpolation period relative to the rest of the spectrum.
    error : str or None
        Reason why the photo cannot be decoded.
    """

    blur_px: float | None = None
    brightness: float | None = None
    saturated_share: float | None = None
    resampling_strength: float | None = None
    error: str | None = None


def measure_quality(photo: Photo) -> PhotoQuality:
    """Decode and measure a photo; if it is damaged, `error` states why."""
    from vomstudio.core.errors import InputError
    from vomstudio.io.photos.pixels import grey, read_mask

    try:
        pixels = grey(photo)
        mask = read_mask(photo)
    except InputError as error:
        return PhotoQuality(error=error.message)
    used_pixels = pixels[::8, ::8] if mask is None else pixels[::8, ::8][mask[::8, ::8]]
    if used_pixels.size == 0:
        used_pixels = pixels[::8, ::8]
    linear_picture = linear_light(used_pixels)
    return PhotoQuality(
        blur_px=blur(pixels, mask),
        brightness=float(linear_picture.mean()),
        saturated_share=float((used_pixels >= 254).mean()),
        resampling_strength=measure_resampling(pixels),
    )


def linear_light(values: ByteArray) -> Float32Array:
    """Convert sRGB values to linear light, 0 to 1 (IEC 61966-2-1)."""
    v = np.asarray(values, np.float32) / 255.0
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4).astype(np.float32)


def blur(pixels: ByteArray, mask: BoolArray | None = None) -> float | None:
    """Return the median sigma of strong edges in pixels, or None if there are too few.

    The larger of the values across and along the picture is returned.

    pixels : (h, w) greyscale values
    mask : (h, w), True for used pixels
    """
    tiles = [tile.astype(np.float32) for tile in _select_tiles(pixels, mask)]
    for level in range(4):
        horizontal_sigma, vertical_sigma = (_edge_sigma(tiles, axis) for axis in (1, 0))
        known_sigmas = [s for s in (horizontal_sigma, vertical_sigma) if s is not None]
        if not known_sigmas:
            return None
        if max(known_sigmas) <= _MAX_BLUR_SIGMA_PX or level == 3:
            return float(max(known_sigmas) * 2**level)
        # Averaging two pixels adds some blur, which is negligible compared with the measured blur.
        tiles = [_halve_size(tile) for tile in tiles]
    return None


def _halve_size(tile: Float32Array) -> Float32Array:
    import cv2

    half_tile = cv2.resize(tile, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return np.asarray(half_tile, np.float32)


def _select_tiles(pixels: ByteArray, mask: BoolArray | None) -> list[ByteArray]:
    """Return full-resolution tiles spread over the photo, those with most contrast first."""
    height, width = pixels.shape
    size = min(_TILE_PX, height, width)
    rows = np.unique(np.linspace(0, height - size, 6).astype(int))
    columns = np.unique(np.linspace(0, width - size, 6).astype(int))
    candidates: list[tuple[float, int, ByteArray]] = []
    for y in rows:
        for x in columns:
            if mask is not None and mask[y : y + size : 8, x : x + size : 8].mean() < 0.9:
                continue
            tile = pixels[y : y + size, x : x + size]
            candidates.append((-float(tile[::4, ::4].std()), len(candidates), tile))
    return [tile for _, _, tile in sorted(candidates, key=lambda f: f[:2])[:_MAX_TILES]]


def _edge_sigma(tiles: list[Float32Array], axis: int) -> float | None:
    import cv2

    ratios = []
    for tile in tiles:
        # Reduce noise; the effect of the smoothing is subtracted below.
        tile = np.asarray(cv2.GaussianBlur(tile, (0, 0), _SMOOTHING_SIGMA_PX), np.float32)
        blurred_tile = cv2.GaussianBlur(tile, (0, 0), _REBLUR_SIGMA_PX)
        # Use central differences, since a wider operator would add its own width.
        kernel = np.array([[-0.5, 0.0, 0.5]], np.float32)
        kernel = kernel if axis == 1 else kernel.T
        gradient = np.abs(cv2.filter2D(tile, cv2.CV_32F, kernel))
        blurred_gradient = np.abs(cv2.filter2D(blurred_tile, cv2.CV_32F, kernel))
        cross_gradient = np.abs(cv2.filter2D(tile, cv2.CV_32F, kernel.T))
        is_inner = np.zeros(tile.shape, bool)
        is_inner[4:-4, 4:-4] = True
        is_peak = (
            is_inner
            & (gradient >= np.roll(gradient, 1, axis))
            & (gradient >= np.roll(gradient, -1, axis))
            & (gradient > 2 * cross_gradient)
        )
        values = gradient[is_peak]
        if len(values) < 20:
            continue
        is_strong = is_peak & (gradient >= max(float(np.quantile(values, _STRONG_QUANTILE)), 2.0))
        ratios.append(gradient[is_strong] / np.maximum(blurred_gradient[is_strong], 1e-6))
    ratio = np.concatenate(ratios) if ratios else np.empty(0)
    # A gradient that increases when blurred is noise or a corner.
    ratio = ratio[ratio > 1.005]
    if len(ratio) < 30:
        return None
    # Variance of the smoothing, plus the variance of a box two pixels wide for the differences.
    smoothing_variance = _SMOOTHING_SIGMA_PX**2 + 1.0 / 3.0
    variance = _REBLUR_SIGMA_PX**2 / (ratio**2 - 1.0) - smoothing_variance
    return float(np.sqrt(max(float(np.quantile(variance, _EDGE_QUANTILE)), 0.04)))


def measure_resampling(pixels: ByteArray) -> float:
    """Return how strongly second differences are periodic along rows and columns.

    Such a period is a trace of resampling (Gallagher 2005, "Detection of linear and cubic
    interpolation in JPEG compressed images"). The result is the ratio of the peak to the median of
    the spectrum for the weaker of both directions, or 0 if their periods differ. Multiples of 1/16
    are due to JPEG blocks and ignored.
    """
    height, width = pixels.shape
    size = 2048
    y, x = max(0, (height - size) // 2), max(0, (width - size) // 2)
    crop = pixels[y : y + size, x : x + size].astype(np.float32)
    if min(crop.shape) < 256:
        return 0.0
    peaks = []
    for lines in (crop, crop.T):
        second_difference = np.abs(2 * lines[:, 1:-1] - lines[:, :-2] - lines[:, 2:]).mean(0)
        trace = np.log(second_difference + 1e-3)
        trace = trace - np.convolve(trace, np.ones(15) / 15, "same")
        spectrum = np.abs(np.fft.rfft(trace[8:-8] * np.hanning(len(trace) - 16)))
        frequency = np.fft.rfftfreq(len(trace) - 16)
        is_allowed = frequency > 0.1
        is_allowed &= np.abs(frequency * 16 - np.round(frequency * 16)) > 16 * 0.004
        index = int(np.argmax(np.where(is_allowed, spectrum, 0.0)))
        peaks.append(
            (frequency[index], float(spectrum[index] / max(float(np.median(spectrum)), 1e-9)))
        )
    (f1, p1), (f2, p2) = peaks
    return min(p1, p2) if abs(f1 - f2) < 0.0015 else 0.0
