"""Assignment of mask files to photos."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.pictures import MASK_BYTES
from vomstudio.core.findings import Finding
from vomstudio.io.photos.pixels import open_photo

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo

MASK_SUFFIXES = (".jpg", ".jpeg", ".tif", ".tiff", ".png")
# A photo may be cropped by one or two rows and still have the same shape.
MAX_SHAPE_DIFFERENCE = 0.01
_MASK_STEM = re.compile(r"(?:[_.]mask)$", re.IGNORECASE)
_FOLDER_NAMES = {"mask", "masks"}


def is_mask(path: Path, root: Path) -> bool:
    """Return whether a picture is a mask according to its name or folder."""
    if path.suffix.lower() not in MASK_SUFFIXES:
        return False
    parent_names = path.relative_to(root).parts[:-1]
    return bool(_MASK_STEM.search(path.stem)) or any(
        name.casefold() in _FOLDER_NAMES for name in parent_names
    )


class MaskFinder:
    """Finder of the masks of photos by file name."""

    def __init__(self, root: Path, masks: Iterable[Path]) -> None:
        self._masks_by_name = {self._key(path): path for path in masks}
        self._stem_counts: dict[Path, Counter[str]] = {}
        self._neighbour_masks: dict[Path, dict[tuple[Path, str], Path]] = {}
        self._root = root
        self._used_masks: set[Path] = set()

    @staticmethod
    def _key(path: Path) -> tuple[Path, str]:
        return path.parent, path.name.casefold()

    def find_mask(self, photo: Photo) -> tuple[Path | None, Finding | None]:
        """Return the mask of a photo, and a finding if the mask is scaled or not used.

        Either may be None. If there are several masks, the first one is used, which is the one
        drawn with this program.
        """
        path = photo.path
        mask_paths = (
            self._masks_by_name.get(key) or self._neighbour_folder_mask(key)
            for key in self._candidate_keys(path)
        )
        candidates = list(
            dict.fromkeys(
                mask_path for mask_path in mask_paths if mask_path is not None and mask_path != path
            )
        )
        self._used_masks.update(candidates)
        return self._check_size(candidates[0], photo) if candidates else (None, None)

    def _candidate_keys(self, path: Path) -> Iterable[tuple[Path, str]]:
        stem, name = path.stem.casefold(), path.name.casefold()
        mask_names = [f"{stem}_mask", f"{name}.mask", f"{name}_mask", f"{stem}.mask"]
        if self._has_twin(path):
            mask_names[:2] = mask_names[1::-1]
        for suffix in (".png", ".jpg", ".jpeg", ".tif", ".tiff"):
            for base in mask_names:
                yield path.parent, base + suffix
            for folder in (path.parent / "masks", path.parent / "mask"):
                for base in (*mask_names, name, stem):
                    yield folder, base + suffix
            for folder in (path.parent.parent / "masks", path.parent.parent / "mask"):
                for base in (*mask_names, name, stem):
                    yield folder, base + suffix

    def _has_twin(self, path: Path) -> bool:
        """Return whether another photo in its folder differs only in its suffix.

        In this case, `drawn_masks.mask_path` assigns a separate mask to each of them.
        """
        folder = path.parent
        if folder not in self._stem_counts:
            try:
                names = [path for path in folder.iterdir() if path.suffix.lower() in MASK_SUFFIXES]
            except OSError:
                names = []
            self._stem_counts[folder] = Counter(name.stem.casefold() for name in names)
        return self._stem_counts[folder][path.stem.casefold()] > 1

    def _neighbour_folder_mask(self, key: tuple[Path, str]) -> Path | None:
        """Return a mask in a folder `mask` or `masks` next to the photo folder, or None."""
        folder = key[0]
        if folder.parent != self._root.parent or folder.name not in _FOLDER_NAMES:
            return None
        if folder not in self._neighbour_masks:
            try:
                self._neighbour_masks[folder] = {
                    self._key(path): path for path in folder.iterdir() if path.is_file()
                }
            except OSError:
                self._neighbour_masks[folder] = {}
        return self._neighbour_masks[folder].get(key)

    def _check_size(self, mask: Path, photo: Photo) -> tuple[Path | None, Finding | None]:
        try:
            with open_photo(mask, min_pixel_bytes=MASK_BYTES) as image:
                size = image.size
        except InputError as error:
            return None, Finding(
                "mask.unusable", mask=mask.name, reason=error.message, reason_code=error.code
            )
        if size == (photo.width, photo.height):
            return mask, None
        sizes = {
            "mask_size": f"{size[0]} x {size[1]}",
            "photo_size": f"{photo.width} x {photo.height}",
        }
        if abs(size[0] * photo.height / (size[1] * photo.width) - 1) <= MAX_SHAPE_DIFFERENCE:
            return mask, Finding("mask.scaled", **sizes)
        return None, Finding("mask.other-shape", **sizes)

    def unused_masks(self) -> list[Path]:
        return [path for path in self._masks_by_name.values() if path not in self._used_masks]
