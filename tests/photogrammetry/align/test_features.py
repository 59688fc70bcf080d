"""Features of one photo: COLMAP's own, at the right place, and none where there is a mask."""

from __future__ import annotations

import io
import pickle
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree

from tests.tiers import first_in_default_tier
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.align.features import (
    ExtractionTask,
    FeatureOptions,
    Features,
    extract_features,
    extraction_memory,
    grey,
)
from vomstudio.photogrammetry.base.colmap import colmap


def rock(width: int = 400, height: int = 300, seed: int = 0) -> np.ndarray:
    """(h, w, 3) noise with detail of all sizes."""
    import cv2

    rng = np.random.default_rng(seed)
    total = np.zeros((height, width), np.float32)
    for size in (4, 8, 16, 32, 64):
        small = rng.normal(0, 1, (height // size + 2, width // size + 2)).astype(np.float32)
        total += cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)
    total = 255 * (total - total.min()) / np.ptp(total)
    return np.repeat(total.astype(np.uint8)[..., None], 3, axis=2)


def encoded(pixels: np.ndarray, kind: str = "PNG", **options: object) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, kind, **options)  # type: ignore[arg-type]
    return buffer.getvalue()


def test_features_match_those_of_colmap(tmp_path: Path) -> None:
    pycolmap = colmap()
    pixels = rock()
    (tmp_path / "rock.png").write_bytes(encoded(pixels))
    pycolmap.extract_features(
        tmp_path / "db", tmp_path, image_names=["rock.png"], device=pycolmap.Device.cpu
    )
    database = pycolmap.Database.open(tmp_path / "db")
    keypoints = database.read_keypoints(1)
    descriptors = database.read_descriptors(1).data
    database.close()
    found = extract_features(ExtractionTask((tmp_path / "rock.png").read_bytes()))
    assert len(found.keypoints) == len(keypoints) > 200
    assert np.array_equal(found.keypoints, keypoints)
    assert np.array_equal(found.descriptors, descriptors)


@pytest.mark.full
def test_keypoints_of_a_downscaled_photo_are_in_original_pixels() -> None:
    pixels = rock(800, 600)
    large = extract_features(ExtractionTask(encoded(pixels)))
    small = extract_features(ExtractionTask(encoded(pixels), options=FeatureOptions(max_size=400)))
    assert (small.width, small.height) == (800, 600)
    # Coarse features of the large photo are found in the small one, without a shift.
    distance, nearest = cKDTree(large.keypoints[:, :2]).query(small.keypoints[:, :2])
    near = distance < 2
    assert near.sum() > 100
    shift = small.keypoints[near, :2] - large.keypoints[nearest[near], :2]
    assert np.abs(np.median(shift, axis=0)).max() < 0.1
    assert small.keypoints[:, 0].max() > 700


def test_an_orientation_tag_does_not_turn_the_pixels() -> None:
    pixels = rock()
    exif = Image.Exif()
    exif[0x0112] = 6
    plain = extract_features(ExtractionTask(encoded(pixels, "JPEG", quality=95)))
    tagged = extract_features(ExtractionTask(encoded(pixels, "JPEG", quality=95, exif=exif)))
    assert (tagged.width, tagged.height) == (400, 300)
    assert np.array_equal(plain.keypoints, tagged.keypoints)


def test_a_mask_hides_features() -> None:
    pixels = rock()
    mask = np.zeros((300, 400), np.uint8)
    mask[:, :200] = 255
    free = extract_features(ExtractionTask(encoded(pixels)))
    found = extract_features(ExtractionTask(encoded(pixels), encoded(mask)))
    assert found.keypoints[:, 0].max() < 200
    assert len(found.keypoints) == (free.keypoints[:, 0] < 200).sum()
    hidden = extract_features(ExtractionTask(encoded(pixels), encoded(mask * 0)))
    assert hidden.problem == Finding("alignment.photo-masked")


def test_features_have_the_colour_of_their_position() -> None:
    pixels = rock()
    pixels[:, 200:, 2] = 0
    found = extract_features(ExtractionTask(encoded(pixels)))
    left = found.keypoints[:, 0] < 180
    assert (found.colors[~left & (found.keypoints[:, 0] > 220), 2] == 0).all()
    assert (found.colors[left, 2] > 0).mean() > 0.9


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "alignment.photo-unreadable"),
        (b"no picture", "alignment.photo-unreadable"),
        (encoded(rock(), "JPEG")[:5000], "alignment.photo-unreadable"),
        (encoded(np.zeros((200, 300, 3), np.uint8)), "alignment.photo-without-features"),
        (encoded(np.zeros((1, 1, 3), np.uint8)), "alignment.photo-without-features"),
    ],
)
def test_unusable_photo_returns_a_finding_instead_of_raising(data: bytes, code: str) -> None:
    found = extract_features(ExtractionTask(data))
    assert found.problem is not None
    assert found.problem.code == code
    assert len(found.keypoints) == 0


def test_unusable_photo_finding_contains_the_code_of_its_file_error() -> None:
    content = encoded(rock())
    head = b"IHDR" + struct.pack(">II", 100_000, 100_000) + content[24:29]
    vast = content[:12] + head + struct.pack(">I", zlib.crc32(head)) + content[33:]
    problem = extract_features(ExtractionTask(vast)).problem
    assert problem is not None
    assert problem.values["reason_code"] == "file.picture-too-large"


@pytest.mark.parametrize("mode", first_in_default_tier(["L", "RGBA", "I;16", "P", "CMYK"], 2))
def test_pictures_of_every_mode_are_read(mode: str) -> None:
    picture = Image.fromarray(rock()).convert("L")
    if mode == "I;16":
        picture = Image.fromarray(np.asarray(picture).astype(np.uint16) * 257)
    else:
        picture = picture.convert(mode)
    buffer = io.BytesIO()
    picture.save(buffer, "TIFF")
    assert len(extract_features(ExtractionTask(buffer.getvalue())).keypoints) > 200


def test_key_depends_on_photo_mask_and_settings() -> None:
    tasks = [
        ExtractionTask(b"a"),
        ExtractionTask(b"b"),
        ExtractionTask(b"a", b"mask"),
        ExtractionTask(b"a", options=FeatureOptions(max_size=100)),
    ]
    assert len({task.key for task in tasks}) == 4
    assert ExtractionTask(b"a", name="other").key == tasks[0].key


def test_features_survive_saving_and_pickling(tmp_path: Path) -> None:
    found = extract_features(ExtractionTask(encoded(rock())))
    found.save(tmp_path / "f.npz")
    for again in (Features.load(tmp_path / "f.npz"), pickle.loads(pickle.dumps(found))):
        assert again is not None
        assert np.array_equal(again.descriptors, found.descriptors)
        assert (again.width, again.problem) == (400, None)
    (tmp_path / "f.npz").write_bytes((tmp_path / "f.npz").read_bytes()[:999])
    assert Features.load(tmp_path / "f.npz") is None
    assert Features.load(tmp_path / "none.npz") is None


def test_memory_depends_on_the_searched_size_and_not_on_the_photo() -> None:
    small = extraction_memory(4000, 3000, FeatureOptions(max_size=1600))
    assert 300e6 < small < 1.5e9
    assert extraction_memory(16000, 12000, FeatureOptions(max_size=1600)) < 1.2 * small


def test_grey_of_a_grey_photo_is_unchanged() -> None:
    pixels = rock()
    assert np.array_equal(grey(pixels), pixels[..., 0])
