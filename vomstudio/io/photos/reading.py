"""Reading of the camera, lens, time and position of all photos in a folder.

No photo is decoded: a thousand photos of 100 megapixels are listed from their headers. A truncated
JPEG is recognised by its missing end. Unusable files are reported with the reason.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.files.untrusted.picture_headers import HeaderError, jpeg_scan_start
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import tr
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.photos.apple_maker_note import gravity_in_photo
from vomstudio.io.photos.camera_table import camera_label, find_camera
from vomstudio.io.photos.exif import Exif, read_exif
from vomstudio.io.photos.mask_files import MASK_SUFFIXES, MAX_SHAPE_DIFFERENCE, MaskFinder, is_mask
from vomstudio.io.photos.metadata_checks import (
    altitude_findings,
    drop_unmeasured_angles,
    signed_altitude,
)
from vomstudio.io.photos.photo import Photo, PhotoTags
from vomstudio.io.photos.pixels import open_photo
from vomstudio.io.photos.user_comment import comment_angles
from vomstudio.io.photos.xmp import Angles, DroneTags, read_drone_tags

PHOTO_ENDINGS = (*MASK_SUFFIXES, ".heic", ".heif")
_UNSUPPORTED_CODES = {
    ".avif": "photo.avif",
    **dict.fromkeys(
        (".cr2", ".cr3", ".nef", ".arw", ".dng", ".orf", ".rw2", ".raf", ".pef", ".srw"),
        "photo.raw",
    ),
    **dict.fromkeys(
        (".mp4", ".mov", ".avi", ".mkv", ".mts"),
        "photo.video",
    ),
    **dict.fromkeys(
        (".webp", ".bmp", ".gif", ".jp2"),
        "photo.other-format",
    ),
}
"""Codes of the findings about files that are not read, by file extension."""
MAX_DEPTH = 3
_FILM_WIDTH_MM = 36.0


@dataclass(frozen=True, repr=False)
class PhotoFolder(PrintableResult):
    """Photos in a folder.

    Attributes
    ----------
    photos : list of Photo
        Usable photos, sorted by name (numbers by value).
    skipped : list of tuple of str and Finding
        Name of each image that is not used, and the reason.
    duplicates : list of tuple of str
        Names of each duplicate and its original; duplicates are also in `skipped`.
    """

    folder: Path
    photos: list[Photo]
    skipped: list[tuple[str, Finding]] = field(default_factory=list)
    warnings: list[Finding] = field(default_factory=list)
    duplicates: list[tuple[str, str]] = field(default_factory=list)

    def replace_masks(self, masks: Mapping[str, Path] | None) -> PhotoFolder:
        """Return the photos with the given masks by photo name instead of those in the folder.

        If None, the masks in the folder are kept.
        """
        if masks is None:
            return self
        return replace(
            self, photos=[replace(photo, mask=masks.get(photo.name)) for photo in self.photos]
        )

    def to_dict(self) -> dict[str, Any]:
        """Return a summary of the folder."""
        return {
            "folder": str(self.folder),
            "photos": len(self.photos),
            "with_gps": sum(photo.latitude_deg is not None for photo in self.photos),
            "with_masks": sum(photo.mask is not None for photo in self.photos),
            "cameras": tuple(str(group[0].camera) for group in self.cameras().values()),
            "skipped": tuple(name for name, _ in self.skipped),
            "warnings": tuple(self.warnings),
        }

    def cameras(self) -> dict[tuple[object, ...], list[Photo]]:
        """Return the photos grouped by camera, lens and setting."""
        groups: dict[tuple[object, ...], list[Photo]] = defaultdict(list)
        for photo in self.photos:
            groups[photo.camera_key].append(photo)
        return dict(groups)


class NoPhotosError(InputError):
    """Error for an existing folder that contains no usable photos."""


def read_photos(folder: str | Path, progress: Progress | None = None) -> PhotoFolder:
    """Read all photos in a folder and its subfolders, down to three levels.

    Masks are NAME_mask.png, NAME.jpg.mask.png or NAME.mask.png next to the photo, or files with the
    name of the photo (or any of these names) in a folder `masks` next to the photo or next to its
    folder.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be read.
    NoPhotosError
        If the folder contains no usable photos.
    """
    root = Path(folder)
    progress = progress or SilentProgress()
    files = _list_files(root)
    masks = {path for path in files if is_mask(path, root)}
    candidates = [
        path for path in files if path.suffix.lower() in PHOTO_ENDINGS and path not in masks
    ]
    result = PhotoFolder(root, [])
    pictures = candidates
    candidates = _drop_duplicates(_drop_unprintable_names(pictures, root, result), root, result)
    progress.stage(tr("Reading photos"), len(candidates))
    mask_finder = MaskFinder(root, masks)
    problems: dict[Finding, list[str]] = defaultdict(list)
    for count, path in enumerate(candidates):
        progress.step(count)
        name = path.relative_to(root).as_posix()
        try:
            photo, findings = _read(path, name)
        except InputError as error:
            result.skipped.append((name, cause_finding(error)))
            continue
        mask, mask_finding = mask_finder.find_mask(photo)
        if mask_finding:
            findings.append(mask_finding)
        for finding in findings:
            problems[finding].append(name)
        result.photos.append(_add_mask(photo, mask))
    progress.step(len(candidates))
    for path in files:
        code = _UNSUPPORTED_CODES.get(path.suffix.lower())
        if code and not _has_matching_photo(path, pictures):
            name = _to_printable(path.relative_to(root).as_posix())
            result.skipped.append((name, Finding(code)))
    for path in mask_finder.unused_masks():
        result.skipped.append((path.relative_to(root).as_posix(), Finding("mask.without-photo")))
    result.warnings.extend(
        Finding(problem.code, problem.severity, **problem.values, file=_names(names), photos=names)
        for problem, names in problems.items()
    )
    result.photos.sort(key=lambda photo: _natural_sort_key(photo.name))
    photos, findings = drop_unmeasured_angles(result.photos)
    result.photos[:] = photos
    result.warnings.extend([*altitude_findings(photos), *findings])
    if not result.photos:
        raise NoPhotosError(_no_photos_finding(result.skipped, files), file=root)
    return result


def photo_names(folder: str | Path) -> list[str]:
    """Return the names of the files in a folder that `read_photos` would read.

    They are not opened, so they may include duplicates and unusable photos. Raises InputError if
    the folder does not exist.
    """
    root = Path(folder)
    return [
        path.relative_to(root).as_posix()
        for path in _list_files(root)
        if path.suffix.lower() in PHOTO_ENDINGS and not is_mask(path, root)
    ]


def read_photo(path: str | Path) -> Photo:
    """Read a single photo without a mask. Raises InputError."""
    path = Path(path)
    try:
        return _read(path, path.name)[0]
    except InputError as error:
        raise InputError(error, file=path) from error


# ------------------------------------------------------------------------------------------------
def _list_files(root: Path) -> list[Path]:
    """Return the files down to the maximum depth, sorted. Raises InputError."""
    try:
        if not root.is_dir():
            raise InputError(
                Finding("folder.not-a-folder") if root.exists() else Finding("folder.missing"),
                file=root,
            )
        os.listdir(root)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(Finding("folder.unreadable", reason=reason), file=root) from error
    files: list[Path] = []
    for folder, folders, names in os.walk(root):
        depth = len(Path(folder).relative_to(root).parts)
        folders[:] = sorted(
            subfolder
            for subfolder in folders
            if depth < MAX_DEPTH and not _is_excluded_folder(Path(folder, subfolder))
        )
        files += (Path(folder, name) for name in names if not name.startswith("."))
    return sorted(
        (file for file in files if file.is_file() or _is_broken_link(file)), key=_sort_key
    )


def _sort_key(path: Path) -> list[tuple[int, int, str]]:
    return _natural_sort_key(str(path))


def _is_broken_link(path: Path) -> bool:
    return path.is_symlink() and not path.exists()


def _to_printable(name: str) -> str:
    """Return a printable form of a file name, regardless of its bytes."""
    return name.encode("utf-8", "replace").decode()


def _is_excluded_folder(folder: Path) -> bool:
    """Return whether a folder is hidden, or belongs to a program, a project or a model."""
    if (folder / "request.json").is_file() and (folder / "work").is_dir():
        return True
    if folder.name.startswith((".", "@", "__")) or folder.suffix == ".vom":
        return True
    try:
        return any(entry.suffix.lower() in (".mtl", ".glb") for entry in folder.iterdir())
    except OSError:
        return True


def _natural_sort_key(text: str) -> list[tuple[int, int, str]]:
    """Return a key that sorts IMG_2 before IMG_10."""
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part)
        for part in re.split(r"(\d+)", text.casefold())
        if part
    ]


def _drop_unprintable_names(paths: Sequence[Path], root: Path, result: PhotoFolder) -> list[Path]:
    """Drop files whose name is not valid text, because no table or report could name them."""
    printable_photos = []
    for path in paths:
        name = path.relative_to(root).as_posix()
        if _to_printable(name) == name:
            printable_photos.append(path)
        else:
            result.skipped.append((_to_printable(name), Finding("file.name-encoding")))
    return printable_photos


def _drop_duplicates(paths: Sequence[Path], root: Path, result: PhotoFolder) -> list[Path]:
    """Drop files with the same content as an earlier one, reading only files of equal size."""
    files_by_size: dict[int, list[Path]] = defaultdict(list)
    for path in paths:
        try:
            files_by_size[path.stat().st_size].append(path)
        except OSError:
            files_by_size[-1].append(path)
    originals: dict[Path, Path] = {}
    for size, candidates in files_by_size.items():
        if size <= 0 or len(candidates) < 2:
            continue
        first_paths: dict[bytes, Path] = {}
        for path in candidates:
            try:
                with open_regular_file(path) as file:
                    key = hashlib.file_digest(file, "sha256").digest()
            except (InputError, OSError):
                continue
            if path is not first_paths.setdefault(key, path):
                originals[path] = first_paths[key]
    for path, original_path in originals.items():
        name, original = (
            path.relative_to(root).as_posix(),
            original_path.relative_to(root).as_posix(),
        )
        result.duplicates.append((name, original))
        result.skipped.append((name, Finding("photo.duplicate", original=original)))
    return [path for path in paths if path not in originals]


def _read(path: Path, name: str) -> tuple[Photo, list[Finding]]:
    """Return the photo and the findings about its header. Raises InputError."""
    if _is_broken_link(path):
        raise InputError(Finding("file.missing"))
    try:
        if path.stat().st_size == 0:
            raise InputError(Finding("file.empty"))
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror)) from error
    if not os.access(path, os.R_OK):
        raise InputError(Finding("file.no-permission"))
    with open_photo(path) as image:
        _require_photo(image.mode, dict(getattr(image, "tag_v2", None) or {}))
        width, height = image.size
        tags = read_exif(image)
        drone_tags = read_drone_tags(_packet(image))
        is_jpeg = image.format in ("JPEG", "MPO")
    if drone_tags.is_panorama:
        raise InputError(Finding("photo.panorama"))
    if is_jpeg and not has_jpeg_end(path):
        raise InputError(Finding("photo.truncated"))
    focal, source, sensor, findings = _focal(tags, drone_tags, width, height)
    accuracy = drone_tags.accuracy_m if drone_tags.accuracy_m is not None else tags.gps_accuracy_m
    reference = tags.altitude_reference
    altitude = signed_altitude(tags.altitude_m, drone_tags.absolute_altitude_m)
    has_contradiction = altitude != tags.altitude_m
    if has_contradiction and altitude is not None and reference != "ellipsoid":
        reference = "below sea level" if altitude < 0 else "sea level"
    if drone_tags.is_ellipsoidal and tags.altitude_m is not None:
        reference = "ellipsoid"
    (yaw, pitch, roll), has_zero_angles, has_comment_angles = _angles(tags, drone_tags)
    value_by_tag = {tag.name: getattr(tags, tag.name) for tag in fields(PhotoTags)} | {
        "altitude_m": altitude,
        "altitude_reference": reference,
        "gps_accuracy_m": accuracy if tags.latitude_deg is not None else None,
    }
    photo = Photo(
        **value_by_tag,
        path=path,
        name=name,
        width=width,
        height=height,
        camera=camera_label(tags.make, tags.model),
        sensor_width_mm=sensor,
        focal_px=focal,
        focal_source=source,
        exif_altitude_m=tags.altitude_m if has_contradiction else None,
        relative_altitude_m=drone_tags.relative_altitude_m,
        yaw_deg=yaw,
        pitch_deg=pitch,
        roll_deg=roll,
        has_zero_angles=has_zero_angles,
        has_comment_angles=has_comment_angles,
        down=_gravity_direction(tags, width, height),
    )
    return photo, [*tags.problems, *findings]


def _angles(tags: Exif, drone_tags: DroneTags) -> tuple[Angles, bool, bool]:
    """Return yaw, pitch and roll, whether all are 0, and whether they are from a comment.

    Tags of the manufacturer take precedence over EXIF `UserComment`.
    """
    comment = comment_angles(tags.comment)
    if drone_tags.yaw_deg is not None and not (drone_tags.has_zero_angles and comment):
        angles = (drone_tags.yaw_deg, drone_tags.pitch_deg, drone_tags.roll_deg)
        return angles, drone_tags.has_zero_angles, False
    if comment is None:
        return (None, None, None), False, False
    yaw, pitch, roll = comment
    return (wrap360(yaw), pitch, roll), not (yaw or pitch or roll), True


def _gravity_direction(tags: Exif, width: int, height: int) -> tuple[float, float, float] | None:
    # The front camera faces the opposite direction.
    if tags.acceleration is None or "front" in (tags.lens or "").casefold():
        return None
    return gravity_in_photo(tags.acceleration, tags.orientation, width, height)


def _packet(image: object) -> bytes | str | None:
    info = getattr(image, "info", {})
    packet = info.get("xmp") or info.get("XML:com.adobe.xmp")
    if packet is None and (tags := getattr(image, "tag_v2", None)) is not None:
        packet = tags.get(700)
    return packet if isinstance(packet, bytes | str) else None


def _require_photo(mode: str, tags: dict[int, object]) -> None:
    """Raise InputError, stating only the reason, for images that are not from a camera."""
    if mode == "F" or (mode == "I" and 33550 in tags):
        raise InputError(Finding("photo.raster"))
    if 33550 in tags or 34264 in tags:
        raise InputError(Finding("photo.raster"))
    if mode in ("CMYK", "YCCK", "LAB"):
        raise InputError(Finding("photo.colors", mode=mode))


def has_jpeg_end(path: Path) -> bool:
    """Return whether the end marker follows the compressed image.

    The marker does not occur inside the image (ITU T.81, B.1.1.5), and data that cameras append
    (previews, sound) do not matter.
    """
    with open_regular_file(path) as file:
        try:
            scan_start = jpeg_scan_start(file)
        except HeaderError:
            return False
        if scan_start is None:
            return False
        end = file.seek(0, os.SEEK_END)
        block = 1 << 16
        while end > scan_start:
            start = max(scan_start, end - block)
            file.seek(start)
            # One additional byte, for a marker across two blocks.
            if b"\xff\xd9" in file.read(end - start + 1):
                return True
            end = start
    return False


def _focal(
    tags: Exif, drone_tags: DroneTags, width: int, height: int
) -> tuple[float | None, str | None, float | None, list[Finding]]:
    """Return focal length in pixels, its source, sensor width in mm, and findings.

    The first three are None if unknown. The 35 mm equivalent is based on the width (36 mm along the
    long side); based on the diagonal, it would be 4 % less for a 4:3 sensor. The used part of the
    sensor follows from the number of pixels as taken.
    """
    findings: list[Finding] = []
    long_side, short_side = max(width, height), min(width, height)
    original_long_side, note = float(long_side), ""
    if tags.pixels is not None:
        original_size = max(tags.pixels), min(tags.pixels)
        has_other_shape = (
            abs(original_size[0] * short_side / (original_size[1] * long_side) - 1.0)
            > MAX_SHAPE_DIFFERENCE
        )
        if long_side > 1.02 * original_size[0]:
            findings.append(
                Finding(
                    "photo.enlarged",
                    size=f"{width} x {height}",
                    original=f"{original_size[0]} x {original_size[1]}",
                )
            )
        elif has_other_shape and original_size[1] >= short_side:
            # Cropped and not resized, so the pixels are those of the sensor.
            original_long_side, note = (
                float(original_size[0]),
                f", cut from {original_size[0]} x {original_size[1]}",
            )
            findings.append(
                Finding(
                    "photo.cropped",
                    size=f"{width} x {height}",
                    original=f"{original_size[0]} x {original_size[1]}",
                )
            )
    visible_share = long_side / original_long_side
    if tags.focal_35mm is not None and 2.0 <= tags.focal_35mm <= 5000.0:
        focal = tags.focal_35mm / _FILM_WIDTH_MM * original_long_side
        sensor = None
        if tags.focal_mm is not None:
            sensor = tags.focal_mm / tags.focal_35mm * _FILM_WIDTH_MM * visible_share
        return focal, f"35 mm equivalent, by width{note}", sensor, findings
    if tags.focal_mm is not None:
        model = find_camera(camera_label(tags.make, tags.model)) or find_camera(tags.model)
        if model is not None:
            focal = tags.focal_mm / model.width_mm * original_long_side
            return focal, f"sensor table{note}", model.width_mm * visible_share, findings
        if tags.focal_plane_px_per_mm is not None and tags.pixels is not None:
            # The resolution is that of the photo as taken; later resizing scales it.
            sensor = max(tags.pixels) / tags.focal_plane_px_per_mm
            if 1.0 <= sensor <= 100.0:
                focal = tags.focal_mm / sensor * original_long_side
                return focal, f"focal plane resolution{note}", sensor * visible_share, findings
            findings.append(Finding("photo.sensor-unused", width_mm=sensor))
    if drone_tags.focal_px is not None and 0.2 < drone_tags.focal_px / long_side < 20:
        return drone_tags.focal_px, "calibration by the maker", None, findings
    return None, None, None, findings


def _add_mask(photo: Photo, mask: Path | None) -> Photo:
    return photo if mask is None else replace(photo, mask=mask)


def _has_matching_photo(path: Path, photos: Sequence[Path]) -> bool:
    """Return whether a photo with the same name is next to a file, such as a raw file."""
    return any(photo.parent == path.parent and photo.stem == path.stem for photo in photos)


def _names(names: Sequence[str]) -> str:
    if len(names) <= 2:
        return ", ".join(names)
    return tr("{name} and {count} more", name=names[0], count=len(names) - 1)


def _no_photos_finding(
    skipped_pairs: Sequence[tuple[str, Finding]], files: Sequence[Path]
) -> Finding:
    if skipped_pairs:
        name, reason = skipped_pairs[0]
        return Finding("photo.none-usable", count=len(skipped_pairs), photo=name, reason=reason)
    if files:
        return Finding("photo.only-other-files", count=len(files))
    return Finding("photo.none")
