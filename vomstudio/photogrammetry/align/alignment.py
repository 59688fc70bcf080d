"""Resumable alignment of photos: poses and intrinsics from the photos alone.

The features are stored in `KEY.npz`, one file per photo, named by its content and the settings. The
work folder contains `database.db` (COLMAP's database of all compared pairs). When the alignment has
finished, it also contains `alignment.json` and a folder for the scene of each connected component:
`part0`, `part1` and so on, largest first, each with COLMAP's binary model.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.files.disk_errors import damage_reason
from vomstudio.core.files.regular import read_json, read_whole_file
from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.progress import Executor, Progress
from vomstudio.core.words import tr
from vomstudio.photogrammetry.align import lens_separation, mapping, match_database, matching
from vomstudio.photogrammetry.align.calibration import calibrate
from vomstudio.photogrammetry.align.features import (
    MAX_FEATURES,
    ExtractionTask,
    FeatureOptions,
    Features,
    extract_features,
    extraction_memory,
)
from vomstudio.photogrammetry.align.matching import MatchingRule
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.colmap import colmap
from vomstudio.photogrammetry.base.scene import SparseScene

_HEADER_FILE = "alignment.json"
_VERSION = 1
_MIN_MATCHES = 15


@dataclass(frozen=True)
class AlignmentOptions:
    """Options of the alignment.

    Attributes
    ----------
    max_size : int
        Maximum long side of the photos for feature detection, in pixels.
    matching : str
        See `matching.choose_pairs`.
    mapper : str
        See `mapping.map_photos`.
    threads : int or None
        Number of threads; None uses all cores. With 1, the same seed gives bit-identical results.
    """

    max_size: int = 2000
    max_features: int = MAX_FEATURES
    matching: MatchingRule = "auto"
    mapper: str = "auto"
    threads: int | None = None
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Alignment:
    """Result of `align`.

    Attributes
    ----------
    parts : tuple of SparseScene
        Connected components, each in its own frame, the one with the most photos first.
    unregistered_photos : tuple of (str, Finding)
        Photos that are not in any part, and the reason for each.
    reprojection_error_px : float
        Mean reprojection error over the observations of the first part.
    cameras : tuple of Calibration
        Calibrated cameras of all parts.
    tie_point_count : int
        Number of points of the first part that are seen in at least three photos.
    notes : tuple of Finding
        Decisions made during the alignment, and their reasons.
    """

    parts: tuple[SparseScene, ...]
    unregistered_photos: tuple[tuple[str, Finding], ...]
    reprojection_error_px: float
    cameras: tuple[Calibration, ...]
    tie_point_count: int
    notes: tuple[Finding, ...] = field(default=())

    @property
    def registered_photo_count(self) -> int:
        """Number of photos in the first part."""
        return len(self.parts[0].views)

    def save(self, folder: Path) -> None:
        """Write `alignment.json` and the scenes into an existing folder."""
        for number, part in enumerate(self.parts):
            (folder / f"part{number}").mkdir(exist_ok=True)
            part.save(folder / f"part{number}")
        header = {
            "version": _VERSION,
            "parts": len(self.parts),
            "unregistered": [(name, reason.to_dict()) for name, reason in self.unregistered_photos],
            "reprojection_error_px": self.reprojection_error_px,
            "tie_points": self.tie_point_count,
            "cameras": [asdict(c) | {"reasons": to_json_list(c.reasons)} for c in self.cameras],
            "notes": to_json_list(self.notes),
        }
        temporary_path = folder / (_HEADER_FILE + ".part")
        temporary_path.write_text(json.dumps(header, indent=1), encoding="utf-8")
        temporary_path.replace(folder / _HEADER_FILE)

    @classmethod
    def load(cls, folder: Path) -> Alignment:
        """Load an alignment.

        Raises InputError if the folder is incomplete or comes from a newer version of the program.
        """
        try:
            header = read_json(folder / _HEADER_FILE)
            if header["version"] > _VERSION:
                raise InputError(
                    Finding("alignment.newer-version"),
                    file=folder / _HEADER_FILE,
                )
            return cls(
                tuple(SparseScene.load(folder / f"part{i}") for i in range(header["parts"])),
                tuple((str(n), Finding.from_dict(r)) for n, r in header["unregistered"]),
                float(header["reprojection_error_px"]),
                tuple(_parse_calibration(c) for c in header["cameras"]),
                int(header["tie_points"]),
                tuple(map(Finding.from_dict, header["notes"])),
            )
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(
                Finding("alignment.damaged", reason=damage_reason(error)),
                file=folder,
            ) from error


def _parse_calibration(row: dict[str, Any]) -> Calibration:
    lists = ("names", "values", "sigma", "photos")
    tables = {key: tuple(row[key]) for key in lists}
    correlation = tuple(tuple(line) for line in row["correlation"])
    reasons = tuple(map(Finding.from_dict, row["reasons"]))
    return Calibration(**{**row, **tables, "correlation": correlation, "reasons": reasons})


def align(
    photos: Sequence[PhotoLike],
    work_folder: Path,
    options: AlignmentOptions,
    executor: Executor,
    progress: Progress,
    *,
    features_folder: Path | None = None,
    earlier_databases: Iterable[Path] = (),
) -> Alignment:
    """Compute poses and intrinsics, resuming a previous run in the same folder.

    Parameters
    ----------
    photos : sequence of PhotoLike
    work_folder : Path
    options : AlignmentOptions
    executor : Executor
    progress : Progress
    features_folder : Path, optional
        Folder of the features, which several alignments may share; by default `features` in the
        work folder.
    earlier_databases : iterable of Path, optional
        Databases of other alignments, whose compared pairs are reused.

    Raises
    ------
    InputError
        If no two photos can be aligned.
    Cancelled
    """
    if len(photos) < 2:
        raise InputError(Finding("one-photo", photos=(), value=len(photos)))
    work_folder.mkdir(parents=True, exist_ok=True)
    threads = options.threads or -1
    features, keys = find_features(
        photos, features_folder or work_folder / "features", options, executor, progress
    )
    database = work_folder / "database.db"
    matching_key = f"pycolmap {colmap().__version__}, seed {options.seed}"
    match_database.open_database(database, photos, features, keys, matching_key=matching_key)
    match_database.copy_known_pairs(database, earlier_databases)
    choice = matching.choose_pairs(photos, features, options.matching, progress)
    # Skip photos without features.
    has_keypoints = [len(f.keypoints) > 0 for f in features]
    pairs = [(i, j) for i, j in choice.pairs if has_keypoints[i] and has_keypoints[j]]
    matching.match_pairs(database, pairs, progress, threads=threads, seed=options.seed)
    counts = match_database.pair_counts(database)
    best_counts = _best_matches(len(photos), counts)
    if max(best_counts, default=0) < _MIN_MATCHES:
        raise InputError(_no_overlap_finding(photos, features, best_counts))
    settings = mapping.MappingOptions(options.mapper, threads, options.seed)  # type: ignore[arg-type]
    mapping_result = mapping.map_photos(database, photos, work_folder, settings, progress)
    mapping_result = (
        lens_separation.separate_lenses(
            database,
            photos,
            features,
            work_folder,
            settings,
            mapping_result.reconstructions,
            progress,
        )
        or mapping_result
    )
    reconstructions = list(mapping_result.reconstructions)
    if not reconstructions:
        raise InputError(Finding("alignment.no-base"))
    progress.stage(tr("Bundle adjustment"), len(reconstructions))
    parts: list[SparseScene] = []
    cameras: list[Calibration] = []
    shared_images = mapping.shared_images(reconstructions)
    for number, reconstruction in enumerate(reconstructions):
        progress.step(number)
        reconstruction, part_cameras = calibrate(
            reconstruction, photos, threads, mapping_result.is_exif_trusted, progress
        )
        # Not before the adjustment, because the shared photos help to connect this part.
        mapping.remove_images(reconstruction, shared_images[number])
        reconstructions[number] = reconstruction
        parts.append(mapping.to_scene(reconstruction, photos, features))
        cameras += _limit_to_photos(part_cameras, {view.name for view in parts[-1].views})
    for number, reconstruction in enumerate(reconstructions):
        model = work_folder / f"part{number}" / "colmap"
        shutil.rmtree(model, ignore_errors=True)
        model.mkdir(parents=True)
        reconstruction.write_binary(model)
    notes: list[Finding] = [
        choice.rule,
        *mapping_result.notes,
        *_result_notes(parts, cameras),
        *_sharing_notes(photos, set().union(*shared_images)),
    ]
    lengths = np.linalg.norm(mapping.residuals(parts[0]), axis=1)
    alignment = Alignment(
        tuple(parts),
        tuple(_unregistered_photos(photos, features, best_counts, parts)),
        float(np.nanmean(lengths)) if len(lengths) else float("nan"),
        tuple(cameras),
        int((parts[0].track_lengths >= 3).sum()),
        tuple(notes),
    )
    alignment.save(work_folder)
    return alignment


# ------------------------------------------------------------------------------------------------
def find_features(
    photos: Sequence[PhotoLike],
    folder: Path,
    options: AlignmentOptions,
    executor: Executor,
    progress: Progress,
) -> tuple[list[Features], list[str]]:
    """Return the features and the key of every photo.

    Features stored in the folder are reused; the others are detected and stored there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    settings = FeatureOptions(options.max_size, options.max_features)
    features: list[Features | None] = [None] * len(photos)
    keys = [""] * len(photos)
    order: list[int] = []
    progress.stage(tr("Detecting features"), len(photos))

    def missing_tasks() -> Iterator[ExtractionTask]:
        for row, photo in enumerate(photos):
            try:
                data = read_whole_file(photo.path)
                mask = None if photo.mask is None else read_whole_file(photo.mask)
            except (OSError, InputError) as error:
                why = error.message if isinstance(error, InputError) else error.strerror
                reason = Finding("alignment.photo-unreadable", reason=why)
                features[row] = Features.empty(photo.width, photo.height, reason)
                keys[row] = f"unreadable {row}"
                continue
            task = ExtractionTask(data, mask, settings)
            keys[row] = task.key
            features[row] = Features.load(folder / f"{task.key}.npz")
            if features[row] is None:
                order.append(row)
                yield task

    counting_progress = _PhotoProgress(progress, lambda: sum(f is not None for f in features))
    needed_memory = max(extraction_memory(p.width, p.height, settings) for p in photos)
    for number, result in executor.map(
        extract_features, missing_tasks(), counting_progress, needed_memory
    ):
        row = order[number]
        result.save(folder / f"{keys[row]}.npz")
        features[row] = result
        counting_progress.step(0)
    progress.step(len(photos))
    return [f for f in features if f is not None], keys


class _PhotoProgress:
    """Progress that counts finished photos instead of executor tasks."""

    def __init__(self, progress: Progress, count: Any) -> None:
        self._progress, self._count = progress, count

    def stage(self, name: str, total: int | None = None) -> None:
        self._progress.stage(name, total)

    def step(self, done_count: int) -> None:
        self._progress.step(self._count())


def _best_matches(count: int, counts: dict[tuple[int, int], int]) -> list[int]:
    best_counts = [0] * count
    for (i, j), matches in counts.items():
        best_counts[i], best_counts[j] = max(best_counts[i], matches), max(best_counts[j], matches)
    return best_counts


def _result_notes(
    parts: Sequence[SparseScene], cameras: Sequence[Calibration]
) -> Iterator[Finding]:
    """Report the calibration and, if there are several components, their sizes."""
    for camera in cameras:
        yield _camera_note(camera)
        yield from camera.reasons
    if len(parts) > 1:
        yield Finding(
            "parts",
            "info",
            value=len(parts),
            sizes=[len(p.views) for p in parts],
            photos=[v.name for p in parts[1:] for v in p.views],
        )


def _sharing_notes(
    photos: Sequence[PhotoLike], shared_indices: Collection[int]
) -> Iterator[Finding]:
    """Report the photos that several components have in common."""
    if shared_indices:
        yield Finding(
            "alignment.shared-photos",
            count=len(shared_indices),
            photos=[photos[image - 1].name for image in sorted(shared_indices)],
        )


def _limit_to_photos(
    cameras: Sequence[Calibration], names: Collection[str]
) -> Iterator[Calibration]:
    """Limit calibrations to the named photos, and omit calibrations of other photos only."""
    for camera in cameras:
        if used_photos := tuple(name for name in camera.photos if name in names):
            yield replace(camera, photos=used_photos)


def _camera_note(camera: Calibration) -> Finding:
    focal, sigma = camera.values[0], camera.sigma[0]
    if camera.focal != "freed":
        value = tr("{focal:.0f} px", focal=focal)
    elif camera.exif_px:
        value = tr(
            "{focal:.0f} ± {sigma:.0f} px, {change:+.1f} % relative to EXIF",
            focal=focal,
            sigma=sigma,
            change=100 * (focal / camera.exif_px - 1),
        )
    else:
        value = tr("{focal:.0f} ± {sigma:.0f} px", focal=focal, sigma=sigma)
    return Finding("lens.focal-length", count=len(camera.photos), value=value)


def _no_overlap_finding(
    photos: Sequence[PhotoLike], features: Sequence[Features], best_counts: Sequence[int]
) -> Finding:
    problems = [
        f"{p.name}: {f.problem}" for p, f in zip(photos, features, strict=True) if f.problem
    ]
    if len(problems) >= len(photos) - 1:
        return Finding("alignment.too-few-photos", reasons=" ".join(problems[:3]))
    return Finding(
        "unmatched",
        "error",
        photos=[photo.name for photo in photos],
        value=0,
        matches=max(best_counts, default=0),
        least=_MIN_MATCHES,
    )


def _unregistered_photos(
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    best_counts: Sequence[int],
    parts: Sequence[SparseScene],
) -> Iterator[tuple[str, Finding]]:
    placed_names = {view.name for part in parts for view in part.views}
    for photo, photo_features, matches in zip(photos, features, best_counts, strict=True):
        if photo.name in placed_names:
            continue
        if photo_features.problem:
            reason = photo_features.problem
        elif matches < _MIN_MATCHES:
            reason = Finding(
                "alignment.photo-unmatched", matches=matches, features=len(photo_features.keypoints)
            )
        else:
            reason = Finding("alignment.photo-not-placed", matches=matches)
        yield photo.name, reason
