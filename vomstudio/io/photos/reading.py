"""A folder of photos: what each one says about camera, lens, time and place.

Nothing is decoded: a thousand photos of 100 megapixels are listed from their headers. A JPEG that
was cut off is recognised by its missing end. Whatever is not a usable photo is named with a reason.
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
from vomstudio.core.files.regular import open_regular
from vomstudio.core.files.untrusted.picture_headers import HeaderError, jpeg_scan_start
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import tr
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.photos.apple_maker_note import down_in_photo
from vomstudio.io.photos.camera_table import camera_label, find_camera
from vomstudio.io.photos.exif import Exif, read_exif
from vomstudio.io.photos.mask_files import PICTURES, SAME_SHAPE, MaskFinder, is_mask
from vomstudio.io.photos.metadata_checks import (
    altitude_findings,
    signed_altitude,
    without_unmeasured_angles,
)
from vomstudio.io.photos.photo import Photo, PhotoTags
from vomstudio.io.photos.pixels import opened
from vomstudio.io.photos.user_comment import comment_angles
from vomstudio.io.photos.xmp import Angles, DroneTags, read_drone_tags

PHOTO_ENDINGS = PICTURES
_OTHERS = {
    **dict.fromkeys(
        (".heic", ".heif", ".avif"),
        "photo.heif",
    ),
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
"""Codes of the findings about files that are not read, by extension."""
_DEEPEST = 3
_FILM_WIDTH_MM = 36.0


@dataclass(frozen=True, repr=False)
class PhotoFolder(PrintableResult):
    """photos : usable, in the order of their names (numbers by value)
    skipped : (name, finding) of pictures that are not used
    duplicates : (name, the same file as); these are in `skipped` too
    """

    folder: Path
    photos: list[Photo]
    skipped: list[tuple[str, Finding]] = field(default_factory=list)
    warnings: list[Finding] = field(default_factory=list)
    duplicates: list[tuple[str, str]] = field(default_factory=list)

    def with_masks(self, masks: Mapping[str, Path] | None) -> PhotoFolder:
        """The same photos with these masks, by the name of the photo, in place of those that lie
        beside them; None keeps those."""
        if masks is None:
            return self
        return replace(self, photos=[replace(p, mask=masks.get(p.name)) for p in self.photos])

    def to_dict(self) -> dict[str, Any]:
        """In short, for people."""
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
        """Photos by camera, lens and setting."""
        groups: dict[tuple[object, ...], list[Photo]] = defaultdict(list)
        for photo in self.photos:
            groups[photo.camera_key].append(photo)
        return dict(groups)


class NoPhotos(InputError):
    """The folder is there, but no photo of it can be used."""


def read_photos(folder: str | Path, progress: Progress | None = None) -> PhotoFolder:
    """All photos in a folder and in folders inside it, down to three levels.

    Masks are found as NAME_mask.png, NAME.jpg.mask.png or NAME.mask.png beside the photo, or under
    the photo's name (or any of these) in a folder `masks` beside the photo or beside its folder.
    Raises InputError where there is no such folder, NoPhotos where there is nothing to use.
    """
    root = Path(folder)
    progress = progress or Silent()
    files = _listed(root)
    masks = {path for path in files if is_mask(path, root)}
    candidates = [
        path for path in files if path.suffix.lower() in PHOTO_ENDINGS and path not in masks
    ]
    result = PhotoFolder(root, [])
    pictures = candidates
    candidates = _without_twins(_with_text_names(pictures, root, result), root, result)
    progress.stage(tr("Reading photos"), len(candidates))
    found_masks = MaskFinder(root, masks)
    problems: dict[Finding, list[str]] = defaultdict(list)
    for done, path in enumerate(candidates):
        progress.step(done)
        name = path.relative_to(root).as_posix()
        try:
            photo, findings = _read(path, name)
        except InputError as error:
            result.skipped.append((name, cause_of(error)))
            continue
        mask, refused = found_masks.of(photo)
        if refused:
            findings.append(refused)
        for finding in findings:
            problems[finding].append(name)
        result.photos.append(_with_mask(photo, mask))
    progress.step(len(candidates))
    for path in files:
        code = _OTHERS.get(path.suffix.lower())
        if code and not _has_photo_beside(path, pictures):
            name = _printable(path.relative_to(root).as_posix())
            result.skipped.append((name, Finding(code)))
    for path in found_masks.left():
        result.skipped.append((path.relative_to(root).as_posix(), Finding("mask.without-photo")))
    result.warnings.extend(
        Finding(each.code, each.severity, **each.values, file=_names(names), photos=names)
        for each, names in problems.items()
    )
    result.photos.sort(key=lambda photo: _natural(photo.name))
    photos, findings = without_unmeasured_angles(result.photos)
    result.photos[:] = photos
    result.warnings.extend([*altitude_findings(photos), *findings])
    if not result.photos:
        raise NoPhotos(_nothing(result.skipped, files), file=root)
    return result


def photo_names(folder: str | Path) -> list[str]:
    """Names of the pictures in a folder as `read_photos` gives them, without opening any. Raises
    InputError where there is no such folder."""
    root = Path(folder)
    return [
        path.relative_to(root).as_posix()
        for path in _listed(root)
        if path.suffix.lower() in PHOTO_ENDINGS and not is_mask(path, root)
    ]


def read_photo(path: str | Path) -> Photo:
    """One photo by itself, without mask. Raises InputError."""
    path = Path(path)
    try:
        return _read(path, path.name)[0]
    except InputError as error:
        raise InputError(error, file=path) from error


# ------------------------------------------------------------------------------------------------
def _listed(root: Path) -> list[Path]:
    """Files down to the deepest level, sorted. Raises InputError."""
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
    found: list[Path] = []
    for here, folders, names in os.walk(root):
        depth = len(Path(here).relative_to(root).parts)
        folders[:] = sorted(
            f for f in folders if depth < _DEEPEST and not _is_other_folder(Path(here, f))
        )
        found += (Path(here, name) for name in names if not name.startswith("."))
    return sorted((p for p in found if p.is_file() or _leads_nowhere(p)), key=_by_name)


def _by_name(path: Path) -> list[tuple[int, int, str]]:
    return _natural(str(path))


def _leads_nowhere(path: Path) -> bool:
    return path.is_symlink() and not path.exists()


def _printable(name: str) -> str:
    """A file name that can be printed, whatever its bytes."""
    return name.encode("utf-8", "replace").decode()


def _is_other_folder(folder: Path) -> bool:
    """Hidden, kept by another program for itself, a project, a reconstruction, or a model with its
    textures."""
    if (folder / "request.json").is_file() and (folder / "work").is_dir():
        return True
    if folder.name.startswith((".", "@", "__")) or folder.suffix == ".vom":
        return True
    try:
        return any(entry.suffix.lower() in (".mtl", ".glb") for entry in folder.iterdir())
    except OSError:
        return True


def _natural(text: str) -> list[tuple[int, int, str]]:
    """Sorts IMG_2 before IMG_10."""
    return [
        (0, int(part), "") if part.isdecimal() else (1, 0, part)
        for part in re.split(r"(\d+)", text.casefold())
        if part
    ]


def _with_text_names(paths: Sequence[Path], root: Path, result: PhotoFolder) -> list[Path]:
    """Leave out files whose name is no text: no table or report could name them."""
    kept = []
    for path in paths:
        name = path.relative_to(root).as_posix()
        if _printable(name) == name:
            kept.append(path)
        else:
            result.skipped.append((_printable(name), Finding("file.name-encoding")))
    return kept


def _without_twins(paths: Sequence[Path], root: Path, result: PhotoFolder) -> list[Path]:
    """Leave out files with the same content as an earlier one; only files of the same length are
    read for it."""
    by_size: dict[int, list[Path]] = defaultdict(list)
    for path in paths:
        try:
            by_size[path.stat().st_size].append(path)
        except OSError:
            by_size[-1].append(path)
    twins: dict[Path, Path] = {}
    for size, same in by_size.items():
        if size <= 0 or len(same) < 2:
            continue
        first: dict[bytes, Path] = {}
        for path in same:
            try:
                with open_regular(path) as file:
                    key = hashlib.file_digest(file, "sha256").digest()
            except (InputError, OSError):
                continue
            if path is not first.setdefault(key, path):
                twins[path] = first[key]
    for path, other in twins.items():
        name, of = path.relative_to(root).as_posix(), other.relative_to(root).as_posix()
        result.duplicates.append((name, of))
        result.skipped.append((name, Finding("photo.duplicate", original=of)))
    return [path for path in paths if path not in twins]


def _read(path: Path, name: str) -> tuple[Photo, list[Finding]]:
    """Return the photo and findings about its header. Raises InputError."""
    if _leads_nowhere(path):
        raise InputError(Finding("file.missing"))
    try:
        if path.stat().st_size == 0:
            raise InputError(Finding("file.empty"))
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror)) from error
    if not os.access(path, os.R_OK):
        raise InputError(Finding("file.no-permission"))
    with opened(path) as image:
        _require_photo(image.mode, dict(getattr(image, "tag_v2", None) or {}))
        width, height = image.size
        tags = read_exif(image)
        drone = read_drone_tags(_packet(image))
        is_jpeg = image.format in ("JPEG", "MPO")
    if drone.panorama:
        raise InputError(Finding("photo.panorama"))
    if is_jpeg and not has_jpeg_end(path):
        raise InputError(Finding("photo.truncated"))
    focal, source, sensor, findings = _focal(tags, drone, width, height)
    accuracy = drone.accuracy_m if drone.accuracy_m is not None else tags.gps_accuracy_m
    reference = tags.altitude_reference
    altitude = signed_altitude(tags.altitude_m, drone.absolute_altitude_m)
    contradicts = altitude != tags.altitude_m
    if contradicts and altitude is not None and reference != "ellipsoid":
        reference = "below sea level" if altitude < 0 else "sea level"
    if drone.ellipsoidal and tags.altitude_m is not None:
        reference = "ellipsoid"
    (yaw, pitch, roll), is_zero, is_comment = _angles(tags, drone)
    shared = {each.name: getattr(tags, each.name) for each in fields(PhotoTags)} | {
        "altitude_m": altitude,
        "altitude_reference": reference,
        "gps_accuracy_m": accuracy if tags.latitude_deg is not None else None,
    }
    photo = Photo(
        **shared,
        path=path,
        name=name,
        width=width,
        height=height,
        camera=camera_label(tags.make, tags.model),
        sensor_width_mm=sensor,
        focal_px=focal,
        focal_source=source,
        exif_altitude_m=tags.altitude_m if contradicts else None,
        relative_altitude_m=drone.relative_altitude_m,
        yaw_deg=yaw,
        pitch_deg=pitch,
        roll_deg=roll,
        has_zero_angles=is_zero,
        has_comment_angles=is_comment,
        down=_down(tags, width, height),
    )
    return photo, [*tags.problems, *findings]


def _angles(tags: Exif, drone: DroneTags) -> tuple[Angles, bool, bool]:
    """Return yaw, pitch and roll, whether they are 0 as written, and whether they are from EXIF
    `UserComment`: tags of the maker come first."""
    found = comment_angles(tags.comment)
    if drone.yaw_deg is not None and not (drone.has_zero_angles and found):
        angles = (drone.yaw_deg, drone.pitch_deg, drone.roll_deg)
        return angles, drone.has_zero_angles, False
    if found is None:
        return (None, None, None), False, False
    yaw, pitch, roll = found
    return (wrap360(yaw), pitch, roll), not (yaw or pitch or roll), True


def _down(tags: Exif, width: int, height: int) -> tuple[float, float, float] | None:
    # The camera at the front looks the other way.
    if tags.acceleration is None or "front" in (tags.lens or "").casefold():
        return None
    return down_in_photo(tags.acceleration, tags.orientation, width, height)


def _packet(image: object) -> bytes | str | None:
    info = getattr(image, "info", {})
    found = info.get("xmp") or info.get("XML:com.adobe.xmp")
    if found is None and (tags := getattr(image, "tag_v2", None)) is not None:
        found = tags.get(700)
    return found if isinstance(found, bytes | str) else None


def _require_photo(mode: str, tags: dict[int, object]) -> None:
    """Raises InputError, with the reason alone, for pictures that no camera took."""
    if mode == "F" or (mode == "I" and 33550 in tags):
        raise InputError(Finding("photo.raster"))
    if 33550 in tags or 34264 in tags:
        raise InputError(Finding("photo.raster"))
    if mode in ("CMYK", "YCCK", "LAB"):
        raise InputError(Finding("photo.colors", mode=mode))


def has_jpeg_end(path: Path) -> bool:
    """Whether the end marker follows the compressed picture: it occurs nowhere inside of it
    (ITU T.81, B.1.1.5), and what cameras append (previews, sound) does not matter."""
    with open_regular(path) as file:
        try:
            scan = jpeg_scan_start(file)
        except HeaderError:
            return False
        if scan is None:
            return False
        end = file.seek(0, os.SEEK_END)
        block = 1 << 16
        while end > scan:
            start = max(scan, end - block)
            file.seek(start)
            # One byte more, for a marker on the border of two blocks.
            if b"\xff\xd9" in file.read(end - start + 1):
                return True
            end = start
    return False


def _focal(
    tags: Exif, drone: DroneTags, width: int, height: int
) -> tuple[float | None, str | None, float | None, list[Finding]]:
    """Focal length in pixels, the rule that gave it, width of the sensor in mm, and complaints.

    The 35 mm equivalent is taken by width (36 mm along the long side); by diagonal it would be 4 %
    less on a 4:3 sensor. What a photo shows of the sensor is known by the pixels it had when taken.
    """
    findings: list[Finding] = []
    long_side, short_side = max(width, height), min(width, height)
    as_taken, note = float(long_side), ""
    if tags.pixels is not None:
        was = max(tags.pixels), min(tags.pixels)
        reshaped = abs(was[0] * short_side / (was[1] * long_side) - 1.0) > SAME_SHAPE
        if long_side > 1.02 * was[0]:
            findings.append(
                Finding(
                    "photo.enlarged", size=f"{width} x {height}", original=f"{was[0]} x {was[1]}"
                )
            )
        elif reshaped and was[1] >= short_side:
            # Cut out, not resized: the pixels are the sensor's.
            as_taken, note = float(was[0]), f", cut from {was[0]} x {was[1]}"
            findings.append(
                Finding(
                    "photo.cropped", size=f"{width} x {height}", original=f"{was[0]} x {was[1]}"
                )
            )
    shown = long_side / as_taken
    if tags.focal_35mm is not None and 2.0 <= tags.focal_35mm <= 5000.0:
        focal = tags.focal_35mm / _FILM_WIDTH_MM * as_taken
        sensor = None
        if tags.focal_mm is not None:
            sensor = tags.focal_mm / tags.focal_35mm * _FILM_WIDTH_MM * shown
        return focal, f"35 mm equivalent, by width{note}", sensor, findings
    if tags.focal_mm is not None:
        model = find_camera(camera_label(tags.make, tags.model)) or find_camera(tags.model)
        if model is not None:
            focal = tags.focal_mm / model.width_mm * as_taken
            return focal, f"sensor table{note}", model.width_mm * shown, findings
        if tags.focal_plane_px_per_mm is not None and tags.pixels is not None:
            # The resolution is that of the picture as taken; later resizing scales with it.
            sensor = max(tags.pixels) / tags.focal_plane_px_per_mm
            if 1.0 <= sensor <= 100.0:
                focal = tags.focal_mm / sensor * as_taken
                return focal, f"focal plane resolution{note}", sensor * shown, findings
            findings.append(Finding("photo.sensor-unused", width_mm=sensor))
    if drone.focal_px is not None and 0.2 < drone.focal_px / long_side < 20:
        return drone.focal_px, "calibration by the maker", None, findings
    return None, None, None, findings


def _with_mask(photo: Photo, mask: Path | None) -> Photo:
    return photo if mask is None else replace(photo, mask=mask)


def _has_photo_beside(path: Path, photos: Sequence[Path]) -> bool:
    """Raw data beside the JPEG that the camera made of it is nothing to complain about."""
    return any(p.parent == path.parent and p.stem == path.stem for p in photos)


def _names(names: Sequence[str]) -> str:
    if len(names) <= 2:
        return ", ".join(names)
    return tr("{name} and {count} more", name=names[0], count=len(names) - 1)


def _nothing(skipped: Sequence[tuple[str, Finding]], files: Sequence[Path]) -> Finding:
    if skipped:
        name, reason = skipped[0]
        return Finding("photo.none-usable", count=len(skipped), photo=name, reason=reason)
    if files:
        return Finding("photo.only-other-files", count=len(files))
    return Finding("photo.none")
