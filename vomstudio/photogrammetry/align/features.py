"""Feature detection in a photo with COLMAP's implementation of SIFT (Lowe 2004, IJCV 60)."""

from __future__ import annotations

import hashlib
import json
import math
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, IndexArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.files.untrusted.pictures import (
    MASK_BYTES,
    PHOTO_FORMATS,
    convert_to_8_bits,
    open_picture,
)
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.base.colmap import colmap

if TYPE_CHECKING:
    from PIL import Image

_VERSION = 2
# COLMAP applies its own limit of 8192 keypoint positions to complete pyramid levels, which results
# in 10 to 15 thousand features. This limit does not depend on the level.
MAX_FEATURES = 16_000
# A position has several features if its gradients have several dominant directions.
_FEATURES_PER_POSITION = 1.17
# Photos up to this size are enlarged twofold first, so that features are detected in their finest
# details. The pyramid then needs less than 1 GB of memory.
_MAX_DOUBLED_SIZE_PX = 2000
# Rec. 709 weights, which COLMAP uses to convert to grey.
_LUMA_WEIGHTS = (0.2126, 0.7152, 0.0722)


@dataclass(frozen=True)
class FeatureOptions:
    """Options of feature detection.

    max_size : maximum long side in pixels; larger photos are reduced to it
    max_features : maximum number of features; the largest ones are used
    """

    max_size: int = 2000
    max_features: int = MAX_FEATURES


@dataclass(frozen=True)
class ExtractionTask:
    """Feature detection in one photo.

    photo, mask : encoded files; the white parts of the mask are used
    name : used only in messages
    """

    photo: bytes
    mask: bytes | None = None
    options: FeatureOptions = FeatureOptions()
    name: str = ""

    @property
    def key(self) -> str:
        """Key of the content and the settings, used as the name of the result file."""
        digest = hashlib.sha256(self.photo)
        digest.update(b"mask" if self.mask is None else hashlib.sha256(self.mask).digest())
        digest.update(json.dumps([_VERSION, asdict(self.options)], sort_keys=True).encode())
        return digest.hexdigest()[:32]


@dataclass(frozen=True, eq=False)
class Features:
    """Features of a photo.

    Attributes
    ----------
    keypoints : (n, 6) float32 array
        x and y in pixels of the photo file, and the affine shape, as in COLMAP.
    descriptors : (n, 128) uint8 array
    colors : (n, 3) uint8 array
    width, height : int
        Size of the photo as stored in its file.
    problem : Finding or None
        Reason why the photo has no features.
    """

    keypoints: Float32Array
    descriptors: ByteArray
    colors: ByteArray
    width: int
    height: int
    problem: Finding | None = None

    @classmethod
    def empty(cls, width: int, height: int, problem: Finding) -> Features:
        """Return a result without features, with the reason."""
        return cls(
            np.zeros((0, 6), np.float32),
            np.zeros((0, 128), np.uint8),
            np.zeros((0, 3), np.uint8),
            width,
            height,
            problem,
        )

    def save(self, path: Path) -> None:
        """Write the features to a file atomically."""
        with atomic_write(path, force=True) as temporary, temporary.open("wb") as file:
            np.savez(
                file,
                keypoints=self.keypoints,
                descriptors=self.descriptors,
                colors=self.colors,
                size=np.array([self.width, self.height]),
                problem=np.array(
                    "" if self.problem is None else json.dumps(self.problem.to_dict())
                ),
            )

    @classmethod
    def load(cls, path: Path) -> Features | None:
        """Load the features from a file, or return None if it is missing or incomplete."""
        try:
            with open_arrays(path) as arrays:
                width, height = (int(v) for v in arrays["size"])
                problem = str(arrays["problem"])
                return cls(
                    arrays["keypoints"],
                    arrays["descriptors"],
                    arrays["colors"],
                    width,
                    height,
                    Finding.from_dict(json.loads(problem)) if problem else None,
                )
        except (OSError, ValueError, KeyError, EOFError):
            return None


def extract_features(task: ExtractionTask) -> Features:
    """Detect the features of a photo.

    If the photo is unreadable, the result has a `problem`; no error is raised.
    """
    width = height = 0
    try:
        with open_picture(task.photo, PHOTO_FORMATS) as image:
            width, height = image.size
            pixels = _decode_pixels(image, task.options.max_size)
        usable_mask = None if task.mask is None else _decode_mask(task.mask, width, height)
    except InputError as error:
        problem = Finding(
            "alignment.photo-unreadable", reason=error.message, reason_code=error.code
        )
        return Features.empty(width, height, problem)
    except (OSError, ValueError, SyntaxError, EOFError, TypeError, KeyError, IndexError) as error:
        return Features.empty(width, height, Finding("alignment.photo-unreadable", reason=error))
    except MemoryError:
        return Features.empty(width, height, Finding("alignment.photo-too-large"))
    keypoints, descriptors = sift(grey(pixels), task.options)
    rows, columns = pixels.shape[:2]
    pixel_xy = keypoints[:, :2].astype(np.intp)
    colors = pixels[pixel_xy[:, 1].clip(0, rows - 1), pixel_xy[:, 0].clip(0, columns - 1)]
    scale = np.array([width / columns, height / rows], np.float32)
    keypoints = keypoints * np.concatenate([scale, np.repeat(scale.mean(), 4)]).astype(np.float32)
    if usable_mask is not None:
        pixel_xy = keypoints[:, :2].astype(np.intp)
        is_unmasked = usable_mask[
            pixel_xy[:, 1].clip(0, height - 1), pixel_xy[:, 0].clip(0, width - 1)
        ]
        keypoints, descriptors, colors = (
            keypoints[is_unmasked],
            descriptors[is_unmasked],
            colors[is_unmasked],
        )
    finding = None
    if not len(keypoints):
        finding = Finding("alignment.photo-without-features")
        if usable_mask is not None and not usable_mask.any():
            finding = Finding("alignment.photo-masked")
    return Features(keypoints, descriptors, colors, width, height, finding)


def sift(image: ByteArray, options: FeatureOptions) -> tuple[Float32Array, ByteArray]:
    """Detect keypoints (n, 6) and descriptors (n, 128) of a greyscale picture (h, w).

    The keypoints are in pixels of the picture.
    """
    pycolmap = colmap()
    settings = pycolmap.FeatureExtractionOptions()
    settings.max_image_size = max(image.shape)
    settings.num_threads = 1
    settings.use_gpu = False
    settings.sift.max_num_features = math.ceil(options.max_features / _FEATURES_PER_POSITION)
    settings.sift.first_octave = -1 if max(image.shape) <= _MAX_DOUBLED_SIZE_PX else 0
    # COLMAP's extractor for a single picture holds the GIL; this one does not.
    with tempfile.TemporaryDirectory(prefix="vom-features-") as folder:
        pictures = Path(folder, "pictures")
        pictures.mkdir()
        height, width = image.shape
        header = f"P5 {width} {height} 255\n".encode()
        (pictures / "one.pgm").write_bytes(header + np.ascontiguousarray(image).tobytes())
        database = Path(folder, "one.db")
        pycolmap.extract_features(
            database, pictures, extraction_options=settings, device=pycolmap.Device.cpu
        )
        connection = pycolmap.Database.open(database)
        try:
            keypoints = np.array(connection.read_keypoints(1), np.float32).reshape(-1, 6)
            descriptors = np.array(connection.read_descriptors(1).data, np.uint8).reshape(-1, 128)
        finally:
            connection.close()
    largest_rows = _largest_keypoints(keypoints, options.max_features)
    return keypoints[largest_rows], descriptors[largest_rows]


def sizes(keypoints: Float32Array) -> Float32Array:
    """Return the areas (n,) of the affine shapes of keypoints (n, 6)."""
    k = keypoints
    return np.abs(k[:, 2] * k[:, 5] - k[:, 3] * k[:, 4])


def _largest_keypoints(keypoints: Float32Array, count: int) -> IndexArray:
    """Return the rows of the `count` largest keypoints, in their original order."""
    if len(keypoints) <= count:
        return np.arange(len(keypoints))
    return np.sort(np.argsort(-sizes(keypoints), kind="stable")[:count])


def extraction_memory(width: int, height: int, options: FeatureOptions) -> int:
    """Estimate the peak memory of feature detection in one photo, in bytes."""
    scale = min(1.0, options.max_size / max(width, height, 1))
    pixels = width * height * scale * scale
    enlargement = 4 if max(width, height) * scale <= _MAX_DOUBLED_SIZE_PX else 1
    # The float pyramid, the differences and gradients of the finest octave, and the other octaves,
    # plus the decoded photo, which the JPEG decoder already reduces.
    return int(pixels * enlargement * 4 * 20 + min(width * height, 4 * pixels) * 4) + 50_000_000


def grey(pixels: ByteArray) -> ByteArray:
    """Convert colour pixels (h, w, 3) to greyscale (h, w)."""
    import cv2

    return np.asarray(
        cv2.transform(pixels, np.array([_LUMA_WEIGHTS], np.float32)), np.uint8
    ).reshape(pixels.shape[:2])


def _decode_pixels(image: Image.Image, size: int) -> ByteArray:
    """Return the pixels (h, w, 3) as stored, reduced to a maximum long side of `size`."""
    import cv2

    width, height = image.size
    scale = min(1.0, size / max(width, height))
    target_size = (max(1, round(width * scale)), max(1, round(height * scale)))
    if scale < 1:
        image.draft("RGB", target_size)
    image = convert_to_8_bits(image)
    pixels = np.asarray(image if image.mode == "RGB" else image.convert("RGB"))
    if (pixels.shape[1], pixels.shape[0]) != target_size:
        pixels = cv2.resize(pixels, target_size, interpolation=cv2.INTER_AREA)
    return np.asarray(pixels, np.uint8)


def _decode_mask(data: bytes, width: int, height: int) -> BoolArray:
    from PIL import Image

    with open_picture(data, PHOTO_FORMATS, min_pixel_bytes=MASK_BYTES) as image:
        band: Image.Image = image.getchannel("A") if image.mode in ("LA", "PA") else image
        if band.mode not in ("L", "1", "I", "I;16"):
            band = band.convert("L")
        if band.size != (width, height):
            band = band.resize((width, height), Image.Resampling.NEAREST)
        values = np.asarray(band)
    # Some programs write masks with 0 and 1, others with 0 and 255.
    return np.asarray(values > (0 if values.max(initial=0) <= 1 else 127))
