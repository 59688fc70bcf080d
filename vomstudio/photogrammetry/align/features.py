"""Features of a photo: SIFT (Lowe 2004, IJCV 60), by COLMAP."""

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
    PHOTOS,
    convert_to_8_bits,
    open_picture,
)
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.base.colmap import colmap

if TYPE_CHECKING:
    from PIL import Image

_VERSION = 2
# COLMAP stops at the first whole level of the pyramid beyond 8192 places, which leaves 10 to 15
# thousand features, as the level falls; so many are never fewer, and do not hang on where it falls.
MOST_FEATURES = 16_000
# A place has more than one feature where its gradients have more than one direction.
_FEATURES_PER_PLACE = 1.17
# Up to this size a photo is doubled first: its finest details still carry features, and the memory
# of the doubled pyramid stays under 1 GB.
_DOUBLED_UP_TO = 2000
# Weights of Rec. 709, which COLMAP uses for grey.
_LUMA = (0.2126, 0.7152, 0.0722)


@dataclass(frozen=True)
class FeatureOptions:
    """max_size : longer photos are reduced to it for the search, pixels
    max_features : the largest are kept
    """

    max_size: int = 2000
    max_features: int = MOST_FEATURES


@dataclass(frozen=True)
class ExtractTask:
    """photo, mask : the encoded files; white parts of the mask are used
    name : for sentences only
    """

    photo: bytes
    mask: bytes | None = None
    options: FeatureOptions = FeatureOptions()
    name: str = ""

    @property
    def key(self) -> str:
        """Names the result: content and settings."""
        digest = hashlib.sha256(self.photo)
        digest.update(b"mask" if self.mask is None else hashlib.sha256(self.mask).digest())
        digest.update(json.dumps([_VERSION, asdict(self.options)], sort_keys=True).encode())
        return digest.hexdigest()[:32]


@dataclass(frozen=True, eq=False)
class Features:
    """keypoints : (n, 6) float32, x and y in pixels of the stored photo and the affine shape, as
        COLMAP keeps them
    descriptors : (n, 128) uint8
    colors : (n, 3) uint8 of the photo there
    width, height : of the stored photo
    problem : why there are none, None if there are any
    """

    keypoints: Float32Array
    descriptors: ByteArray
    colors: ByteArray
    width: int
    height: int
    problem: Finding | None = None

    @classmethod
    def none(cls, width: int, height: int, problem: Finding) -> Features:
        """No features, with a sentence why."""
        return cls(
            np.zeros((0, 6), np.float32),
            np.zeros((0, 128), np.uint8),
            np.zeros((0, 3), np.uint8),
            width,
            height,
            problem,
        )

    def save(self, path: Path) -> None:
        """Whole or not at all."""
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
        """None where there is no whole file."""
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


def extract(task: ExtractTask) -> Features:
    """The features of one photo. A photo that cannot be read is no error but a `problem`, so that
    it does not stop the others."""
    width = height = 0
    try:
        with open_picture(task.photo, PHOTOS) as image:
            width, height = image.size
            pixels = _pixels(image, task.options.max_size)
        use = None if task.mask is None else _mask(task.mask, width, height)
    except InputError as error:
        problem = Finding(
            "alignment.photo-unreadable", reason=error.message, reason_code=error.code
        )
        return Features.none(width, height, problem)
    except (OSError, ValueError, SyntaxError, EOFError, TypeError, KeyError, IndexError) as error:
        return Features.none(width, height, Finding("alignment.photo-unreadable", reason=error))
    except MemoryError:
        return Features.none(width, height, Finding("alignment.photo-too-large"))
    keypoints, descriptors = sift(grey(pixels), task.options)
    rows, columns = pixels.shape[:2]
    place = keypoints[:, :2].astype(np.intp)
    colors = pixels[place[:, 1].clip(0, rows - 1), place[:, 0].clip(0, columns - 1)]
    scale = np.array([width / columns, height / rows], np.float32)
    keypoints = keypoints * np.concatenate([scale, np.repeat(scale.mean(), 4)]).astype(np.float32)
    if use is not None:
        place = keypoints[:, :2].astype(np.intp)
        keep = use[place[:, 1].clip(0, height - 1), place[:, 0].clip(0, width - 1)]
        keypoints, descriptors, colors = keypoints[keep], descriptors[keep], colors[keep]
    missing = None
    if not len(keypoints):
        missing = Finding("alignment.photo-without-features")
        if use is not None and not use.any():
            missing = Finding("alignment.photo-masked")
    return Features(keypoints, descriptors, colors, width, height, missing)


def sift(image: ByteArray, options: FeatureOptions) -> tuple[Float32Array, ByteArray]:
    """Keypoints (n, 6) and descriptors (n, 128) of a grey picture (h, w), in its own pixels."""
    pycolmap = colmap()
    settings = pycolmap.FeatureExtractionOptions()
    settings.max_image_size = max(image.shape)
    settings.num_threads = 1
    settings.use_gpu = False
    settings.sift.max_num_features = math.ceil(options.max_features / _FEATURES_PER_PLACE)
    settings.sift.first_octave = -1 if max(image.shape) <= _DOUBLED_UP_TO else 0
    # Its extractor of one picture holds Python's lock all the while, this one does not.
    with tempfile.TemporaryDirectory(prefix="vom-features-") as folder:
        pictures = Path(folder, "pictures")
        pictures.mkdir()
        height, width = image.shape
        head = f"P5 {width} {height} 255\n".encode()
        (pictures / "one.pgm").write_bytes(head + np.ascontiguousarray(image).tobytes())
        database = Path(folder, "one.db")
        pycolmap.extract_features(
            database, pictures, extraction_options=settings, device=pycolmap.Device.cpu
        )
        opened = pycolmap.Database.open(database)
        try:
            keypoints = np.array(opened.read_keypoints(1), np.float32).reshape(-1, 6)
            descriptors = np.array(opened.read_descriptors(1).data, np.uint8).reshape(-1, 128)
        finally:
            opened.close()
    kept = _largest(keypoints, options.max_features)
    return keypoints[kept], descriptors[kept]


def sizes(keypoints: Float32Array) -> Float32Array:
    """(n,) areas of the affine shapes of keypoints (n, 6)."""
    k = keypoints
    return np.abs(k[:, 2] * k[:, 5] - k[:, 3] * k[:, 4])


def _largest(keypoints: Float32Array, count: int) -> IndexArray:
    """Rows of the largest `count`, in their order."""
    if len(keypoints) <= count:
        return np.arange(len(keypoints))
    return np.sort(np.argsort(-sizes(keypoints), kind="stable")[:count])


def extraction_memory(width: int, height: int, options: FeatureOptions) -> int:
    """Bytes that the search in one photo takes at its peak."""
    scale = min(1.0, options.max_size / max(width, height, 1))
    pixels = width * height * scale * scale
    doubled = 4 if max(width, height) * scale <= _DOUBLED_UP_TO else 1
    # Float pyramid, differences and gradients of the finest octave, and the rest of the octaves;
    # beside them the decoded photo, which JPEG reduces while decoding.
    return int(pixels * doubled * 4 * 20 + min(width * height, 4 * pixels) * 4) + 50_000_000


def grey(pixels: ByteArray) -> ByteArray:
    """(h, w) of (h, w, 3)."""
    import cv2

    return np.asarray(cv2.transform(pixels, np.array([_LUMA], np.float32)), np.uint8).reshape(
        pixels.shape[:2]
    )


def _pixels(image: Image.Image, size: int) -> ByteArray:
    """(h, w, 3) as stored, its long side at most `size`."""
    import cv2

    width, height = image.size
    scale = min(1.0, size / max(width, height))
    wanted = (max(1, round(width * scale)), max(1, round(height * scale)))
    if scale < 1:
        image.draft("RGB", wanted)
    image = convert_to_8_bits(image)
    pixels = np.asarray(image if image.mode == "RGB" else image.convert("RGB"))
    if (pixels.shape[1], pixels.shape[0]) != wanted:
        pixels = cv2.resize(pixels, wanted, interpolation=cv2.INTER_AREA)
    return np.asarray(pixels, np.uint8)


def _mask(data: bytes, width: int, height: int) -> BoolArray:
    from PIL import Image

    with open_picture(data, PHOTOS, min_pixel_bytes=MASK_BYTES) as image:
        band: Image.Image = image.getchannel("A") if image.mode in ("LA", "PA") else image
        if band.mode not in ("L", "1", "I", "I;16"):
            band = band.convert("L")
        if band.size != (width, height):
            band = band.resize((width, height), Image.Resampling.NEAREST)
        values = np.asarray(band)
    # Some write 0 and 1, others 0 and 255.
    return np.asarray(values > (0 if values.max(initial=0) <= 1 else 127))
