"""Undistorted pinhole photos, which are the input of all stages after the alignment."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.files.untrusted.pictures import MASK_BYTES, decode_picture
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View

# Limits for the undistorted picture of a very wide lens: 63 degrees from the axis, and 1.5 times
# the size of the photo.
_MAX_ANGLE_TANGENT = 2.0
_MAX_GROWTH = 1.5
# OpenCV's remap stores pixel coordinates in 16 bits.
_MAX_SIDE_PX = 32_000
_ROWS_PER_BLOCK = 256
_JPEG_QUALITY = 97


@dataclass(frozen=True, eq=False)
class UndistortTask:
    """Input of `undistort`.

    Attributes
    ----------
    photo : bytes
        Content of a JPEG, HEIC, TIFF or PNG file.
    mask : bytes or None
        Content of an image file that is black for unused parts.
    view : View
        View of the photo as stored, with its lens.
    max_size : int or None
        Maximum long side of the result in pixels. If None, the resolution of the photo is kept.
    is_lossless : bool
        Whether to encode the result as PNG instead of JPEG.
    """

    photo: bytes
    mask: bytes | None
    view: View
    max_size: int | None = None
    is_lossless: bool = False


@dataclass(frozen=True, eq=False)
class UndistortedPhoto:
    """Undistorted photo.

    photo : contents of the image file
    mask : contents of the mask file (black: unused), or None if all pixels are used
    view : view with PINHOLE intrinsics of the new size
    """

    photo: bytes
    mask: bytes | None
    view: View

    @cached_property
    def valid_mask(self) -> BoolArray:
        """Mask (h, w) of usable pixels."""
        lens = self.view.intrinsics
        if self.mask is None:
            return np.ones((lens.height, lens.width), bool)
        return decode_mask(self.mask, lens.width, lens.height, self.view.name)

    def pixels(self) -> ByteArray:
        """Return the pixels (h, w, 3): red, green, blue."""
        return decode_photo(self.photo, self.view.name)

    def gray(self) -> ByteArray:
        """Return the greyscale picture (h, w)."""
        import cv2

        return np.asarray(cv2.cvtColor(self.pixels(), cv2.COLOR_RGB2GRAY))


def undistort(task: UndistortTask) -> UndistortedPhoto:
    """Remove the distortion of the lens from a photo.

    The focal length is that of the photo's centre (times the reduction), so that the centre remains
    sharp. The corners of a photo with barrel distortion are included, and pixels outside the photo
    are masked.

    Raises
    ------
    InputError
        If the photo or the mask cannot be read, if the photo differs in size from the view, or the
        mask in proportions.
    GeometryError
        If the calibration of the lens is invalid.
    """
    import cv2

    view, lens = task.view, task.view.intrinsics
    image = decode_photo(task.photo, view.name)
    if image.shape[:2] != (lens.height, lens.width):
        raise InputError(
            Finding(
                "photo.other-size",
                width=image.shape[1],
                height=image.shape[0],
                aligned_width=lens.width,
                aligned_height=lens.height,
            ),
            file=view.name,
        )
    mask = None
    if task.mask is not None:
        mask = decode_mask(task.mask, lens.width, lens.height, view.name)

    full_lens = _make_pinhole(lens) if lens.has_distortion else _drop_distortion(lens)
    limit = min(task.max_size or _MAX_SIDE_PX, _MAX_SIDE_PX)
    reduction = min(1.0, limit / max(full_lens.width, full_lens.height))
    width = max(1, round(full_lens.width * reduction))
    height = max(1, round(full_lens.height * reduction))
    pinhole_lens = full_lens.scaled(width, height)

    # Downsample by area first to prevent aliasing, then remap each pixel.
    reduced_size = (
        max(1, round(lens.width * reduction)),
        max(1, round(lens.height * reduction)),
    )
    if reduced_size != (lens.width, lens.height):
        image = np.asarray(cv2.resize(image, reduced_size, interpolation=cv2.INTER_AREA))
    full_mask: ByteArray | None = None
    if mask is not None:
        full_mask = mask.astype(np.uint8) * np.uint8(255)
        if reduced_size != (lens.width, lens.height):
            full_mask = np.asarray(
                cv2.resize(full_mask, reduced_size, interpolation=cv2.INTER_AREA)
            )
    if lens.has_distortion:
        x, y, is_on_photo = _compute_remapping(pinhole_lens, lens, reduced_size)
        # OpenCV's cubic weights shift the interpolated picture by up to 0.05 pixel.
        image = np.asarray(
            cv2.remap(image, x, y, cv2.INTER_LANCZOS4, borderMode=cv2.BORDER_REPLICATE)
        )
        image[~is_on_photo] = 0
        if full_mask is not None:
            full_mask = np.asarray(
                cv2.remap(full_mask, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            )
            is_on_photo &= full_mask >= 250
    elif full_mask is not None:
        is_on_photo = full_mask >= 250
    else:
        is_on_photo = np.ones((height, width), bool)

    return UndistortedPhoto(
        _encode_photo(image, task.is_lossless),
        None if is_on_photo.all() else _encode_mask(is_on_photo),
        View(view.name, pinhole_lens, view.rotation, view.translation),
    )


def peak_memory_bytes(width: int, height: int, max_size: int | None) -> int:
    """Return the peak memory of `undistort` for a photo of this size, in bytes."""
    scale = min(1.0, (max_size or _MAX_SIDE_PX) / max(width, height, 1))
    return int(width * height * (6 + 18 * scale * scale)) + 20_000_000


def decode_photo(photo: bytes, name: str) -> ByteArray:
    """Decode a photo to RGB (h, w, 3), ignoring its orientation tag.

    Raises InputError if the photo cannot be read.
    """
    import cv2

    image = decode_picture(photo, cv2.IMREAD_COLOR_RGB, name)
    if image is None:
        raise InputError(Finding("photo.unreadable"), file=name)
    return image


def decode_mask(mask: bytes, width: int, height: int, name: str) -> BoolArray:
    """Decode a mask to a Boolean array (h, w), True for used pixels.

    A mask of another size with the same proportions is resized. Raises InputError if the mask
    cannot be read or has other proportions.
    """
    import cv2

    message_name = tr("mask of {photo}", photo=name)
    image = decode_picture(mask, cv2.IMREAD_GRAYSCALE, message_name, min_pixel_bytes=MASK_BYTES)
    if image is None:
        raise InputError(Finding("mask.unreadable"), file=name)
    if image.shape != (height, width):
        if abs(image.shape[1] * height - image.shape[0] * width) > 2 * max(width, height):
            raise InputError(
                Finding(
                    "mask.other-size",
                    mask_width=image.shape[1],
                    mask_height=image.shape[0],
                    width=width,
                    height=height,
                ),
                file=name,
            )
        image = np.asarray(cv2.resize(image, (width, height), interpolation=cv2.INTER_NEAREST))
    return image > 127


def _drop_distortion(lens: Intrinsics) -> Intrinsics:
    return Intrinsics("PINHOLE", lens.width, lens.height, (*lens.focal, *lens.centre))


def _make_pinhole(lens: Intrinsics) -> Intrinsics:
    """Return the pinhole camera with the same focal length and field of view."""
    columns = np.linspace(0.0, lens.width, 65)
    rows = np.linspace(0.0, lens.height, 65)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    rays = lens.rays(pixels)[:, :2]
    rays = rays[np.isfinite(rays).all(axis=1)]
    if not len(rays):
        raise GeometryError(Finding("dense.calibration"))
    focal, centre = np.array(lens.focal), np.array(lens.centre)
    size = np.array([lens.width, lens.height], float)
    low = np.maximum(rays.min(axis=0), -_MAX_ANGLE_TANGENT) * focal
    high = np.minimum(rays.max(axis=0), _MAX_ANGLE_TANGENT) * focal
    midpoint = size / 2 - centre
    low = np.floor(np.maximum(low, midpoint - _MAX_GROWTH * size / 2))
    high = np.ceil(np.minimum(high, midpoint + _MAX_GROWTH * size / 2))
    width, height = (max(1, int(n)) for n in high - low)
    return Intrinsics("PINHOLE", width, height, (*focal.tolist(), *(-low).tolist()))


def _compute_remapping(
    pinhole_lens: Intrinsics, lens: Intrinsics, size: tuple[int, int]
) -> tuple[Float32Array, Float32Array, BoolArray]:
    """Return OpenCV's remap coordinates for undistorting a photo, and the mask.

    Both have one value for each pixel of the undistorted photo. The coordinates refer to the
    original photo resampled to `size`.
    """
    shape = (pinhole_lens.height, pinhole_lens.width)
    x, y = np.full(shape, -1.0, np.float32), np.full(shape, -1.0, np.float32)
    is_inside = np.zeros(shape, bool)
    columns = np.arange(pinhole_lens.width) + 0.5
    for top in range(0, pinhole_lens.height, _ROWS_PER_BLOCK):
        rows = np.arange(top, min(top + _ROWS_PER_BLOCK, pinhole_lens.height)) + 0.5
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        u, v = lens.project(pinhole_lens.rays(pixels)).T
        with np.errstate(invalid="ignore"):
            is_on_photo = (u >= 0) & (u <= lens.width) & (v >= 0) & (v <= lens.height)
        block = slice(top, top + len(rows))
        # OpenCV counts pixels from the centre of the first pixel.
        x[block] = np.where(is_on_photo, u * (size[0] / lens.width) - 0.5, -1.0).reshape(
            len(rows), -1
        )
        y[block] = np.where(is_on_photo, v * (size[1] / lens.height) - 0.5, -1.0).reshape(
            len(rows), -1
        )
        is_inside[block] = is_on_photo.reshape(len(rows), -1)
    return x, y, is_inside


def _encode_photo(image: ByteArray, is_lossless: bool) -> bytes:
    import cv2

    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    if is_lossless:
        return cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
    options = [
        cv2.IMWRITE_JPEG_QUALITY,
        _JPEG_QUALITY,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    ]
    return cv2.imencode(".jpg", bgr, options)[1].tobytes()


def _encode_mask(is_valid: BoolArray) -> bytes:
    import cv2

    return cv2.imencode(".png", is_valid.astype(np.uint8) * np.uint8(255))[1].tobytes()
