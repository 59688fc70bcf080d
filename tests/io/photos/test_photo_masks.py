"""Masks that are drawn: found again by the reader, and careful with those of others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from tests.io.photos.photo_maker import write_photo
from tests.messages import by_code, refused
from vomstudio.core.errors import TargetError
from vomstudio.geometry.pixel_areas import MaskChange, PixelArea, draw_area
from vomstudio.io.photos.drawn_masks import load_mask, mask_path, store_mask, write_mask
from vomstudio.io.photos.pixels import read_mask
from vomstudio.io.photos.reading import read_photos

WIDE, HIGH = 160, 120


def drawn(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).random((HIGH, WIDE)) > 0.4


def test_written_mask_is_found_by_the_photo_reader(tmp_path: Path) -> None:
    photo = write_photo(tmp_path / "left" / "one.JPG")
    used = drawn()
    assert write_mask(mask_path(photo), used) is None
    (found,) = read_photos(tmp_path).photos
    assert found.mask == tmp_path / "left" / "one_mask.png"
    assert (read_mask(found) == used).all()
    assert (load_mask(found.mask, WIDE, HIGH) == used).all()
    with Image.open(found.mask) as image:
        assert (image.mode, image.format) == ("L", "PNG")


def test_photos_differing_only_in_extension_have_separate_masks(tmp_path: Path) -> None:
    photos = [write_photo(tmp_path / name, seed=i) for i, name in enumerate(("a.jpg", "a.png"))]
    for seed, photo in enumerate(photos):
        write_mask(mask_path(photo, photos), drawn(seed))
    found = read_photos(tmp_path).photos
    assert len(found) == 2
    for seed, photo in enumerate(found):
        assert (read_mask(photo) == drawn(seed)).all()


def test_mask_for_one_extension_takes_precedence_over_shared_mask(tmp_path: Path) -> None:
    photos = [write_photo(tmp_path / name, seed=i) for i, name in enumerate(("a.jpg", "a.tif"))]
    both = tmp_path / "a_mask.png"
    Image.fromarray(np.zeros((HIGH, WIDE), np.uint8)).save(both)
    own = mask_path(photos[0], photos)
    write_mask(own, drawn())
    assert [photo.mask for photo in read_photos(tmp_path).photos] == [own, both]


def test_a_damaged_mask_is_left_out_with_the_code_of_its_error(tmp_path: Path) -> None:
    write_photo(tmp_path / "a.jpg")
    (tmp_path / "a_mask.png").write_bytes(b"no picture")
    folder = read_photos(tmp_path)
    assert folder.photos[0].mask is None
    values = by_code(folder.warnings)["mask.unusable"]
    assert (values["mask"], values["reason_code"]) == ("a_mask.png", "picture.unknown-kind")


def test_drawn_mask_takes_precedence_over_mask_with_extension(tmp_path: Path) -> None:
    photo = write_photo(tmp_path / "a.jpg")
    Image.fromarray(np.zeros((HIGH, WIDE), np.uint8)).save(tmp_path / "a.jpg.mask.png")
    write_mask(mask_path(photo), drawn())
    assert read_photos(tmp_path).photos[0].mask == tmp_path / "a_mask.png"


def test_drawn_mask_takes_precedence_over_existing_mask_and_keeps_it(tmp_path) -> None:
    photo = write_photo(tmp_path / "one.jpg")
    other = tmp_path / "masks" / "one.png"
    other.parent.mkdir()
    Image.fromarray(np.zeros((HIGH, WIDE), np.uint8)).save(other)
    before = other.read_bytes()
    assert read_photos(tmp_path).photos[0].mask == other
    # Nothing is masked: that must be said, or the other one would count.
    path, kept = store_mask(mask_path(photo), np.ones((HIGH, WIDE), bool), other)
    assert path == tmp_path / "one_mask.png"
    assert kept is None
    found = read_photos(tmp_path)
    assert found.photos[0].mask == path
    assert not found.skipped, "the other one is a mask of this photo all the same"
    assert other.read_bytes() == before


def test_existing_foreign_mask_is_backed_up_once(tmp_path: Path) -> None:
    place = tmp_path / "one_mask.png"
    Image.fromarray(np.zeros((HIGH, WIDE), np.uint8)).save(place)
    before = place.read_bytes()
    kept = write_mask(place, drawn())
    assert kept == tmp_path / "one_mask.png.bak"
    assert kept.read_bytes() == before
    assert write_mask(place, drawn(1)) is None, "the one that is there is our own"
    assert kept.read_bytes() == before


def test_mask_hiding_nothing_is_not_stored(tmp_path: Path) -> None:
    place = tmp_path / "one_mask.png"
    assert store_mask(place, drawn(), None) == (place, None)
    assert store_mask(place, np.ones((HIGH, WIDE), bool), None) == (None, None)
    assert not place.exists()
    Image.fromarray(np.zeros((HIGH, WIDE), np.uint8)).save(place)
    path, kept = store_mask(place, np.ones((HIGH, WIDE), bool), place)
    assert path is None
    assert kept is not None
    assert kept.exists()


def test_missing_folder_is_reported(tmp_path: Path) -> None:
    with refused("output.no-folder", TargetError):
        write_mask(tmp_path / "gone" / "one_mask.png", drawn())


def test_mask_change_can_be_undone() -> None:
    used = drawn()
    before = used.copy()
    inside = drawn(3)[:50, :70]
    change = draw_area(used, PixelArea(20, 30, inside), is_masking=True)
    assert isinstance(change, MaskChange)
    assert not used[30:80, 20:90][inside].any()
    assert (used[30:80, 20:90] == (before[30:80, 20:90] & ~inside)).all()
    after = used.copy()
    change.toggle(used)
    assert (used == before).all()
    change.toggle(used)
    assert (used == after).all()
    assert draw_area(used, PixelArea(20, 30, inside), is_masking=True) is None, (
        "it is hidden already"
    )
