"""Selection and matching of the pairs of photos that may show the same rock.

Pairs are matched in blocks that take a few seconds each. Every finished pair is stored in the
database, so that an interrupted run can be resumed.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.photogrammetry.align.features import Features, sizes
from vomstudio.photogrammetry.align.match_database import (
    Pair,
    count_compared,
    image_name,
    is_compared,
    open_existing_database,
    open_for_reading,
)
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.base.colmap import colmap, run_cancellable

MatchingRule = Literal["auto", "exhaustive", "spatial", "preselected", "sequential"]

_MAX_EXHAUSTIVE_PHOTOS = 60
_N_NEIGHBOURS = 30
_SEQUENCE_LENGTH = 10
_BLOCK_SIZE = 12
# If the spread of the GPS positions is smaller, they do not show which photos are neighbours.
_MIN_SPREAD_M = 10.0
_N_PRESELECTION_FEATURES = 400


@dataclass(frozen=True)
class PairChoice:
    """Selected pairs (i, j) of photos (rows) with i < j, and the rule that selected them."""

    pairs: tuple[Pair, ...]
    rule: Finding


def choose_pairs(
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    rule: MatchingRule = "auto",
    progress: Progress | None = None,
) -> PairChoice:
    """Select the pairs of photos to compare.

    With the rule "auto", all pairs of up to 60 photos are compared. If there are more photos and
    nearly all have GPS, each photo is compared with its 30 nearest neighbours, and a photo without
    GPS with all others. Otherwise, each photo is compared with the 30 photos whose 400 largest
    features are most similar (Wu 2013, 3DV, "preemptive matching"). In the last two cases, the next
    three photos in the order of their names are added. With the rule "sequential", each video frame
    is compared with the next 10 frames and, to close loops, with those 20, 40, 80 and so on frames
    later.
    """
    n = len(photos)
    n_all_pairs = n * (n - 1) // 2
    if rule == "auto":
        if n <= _MAX_EXHAUSTIVE_PHOTOS:
            rule = "exhaustive"
        else:
            rule = "spatial" if _has_useful_gps(photos) else "preselected"
    if rule == "exhaustive":
        return PairChoice(
            tuple((i, j) for i in range(n) for j in range(i + 1, n)),
            Finding("alignment.matched-all", count=n_all_pairs),
        )
    if rule == "sequential":
        steps = [*range(1, _SEQUENCE_LENGTH + 1)]
        while steps[-1] * 2 < n:
            steps.append(steps[-1] * 2)
        pairs = {(i, i + s) for s in steps for i in range(n - s)}
        finding = Finding(
            "alignment.matched-in-sequence",
            neighbours=_SEQUENCE_LENGTH,
            pairs=len(pairs),
            total=n_all_pairs,
        )
        return PairChoice(tuple(sorted(pairs)), finding)
    pairs = {(i, i + s) for s in (1, 2, 3) for i in range(n - s)}
    if rule == "spatial":
        pairs |= _nearest_pairs(photos)
        finding = Finding(
            "alignment.matched-by-gps",
            neighbours=_N_NEIGHBOURS,
            pairs=len(pairs),
            total=n_all_pairs,
        )
    else:
        pairs |= _most_similar_pairs(features, progress or SilentProgress())
        finding = Finding(
            "alignment.matched-by-likeness",
            neighbours=_N_NEIGHBOURS,
            pairs=len(pairs),
            total=n_all_pairs,
        )
    return PairChoice(tuple(sorted(pairs)), finding)


def _positions(photos: Sequence[PhotoLike]) -> FloatArray:
    """Return positions (n, 3) relative to their median, in metres; NaN if no GPS.

    They are only accurate enough for distances between neighbours.
    """
    rows = [
        (p.longitude_deg, p.latitude_deg, p.altitude_m or 0.0)
        if p.longitude_deg is not None and p.latitude_deg is not None
        else (np.nan,) * 3
        for p in photos
    ]
    positions = np.array(rows, np.float64).reshape(-1, 3)
    if np.isnan(positions).all():
        return positions
    metres = 111_320.0
    east = metres * np.cos(np.radians(np.nanmean(positions[:, 1])))
    return np.asarray((positions - np.nanmedian(positions, axis=0)) * [east, metres, 1.0])


def _has_useful_gps(photos: Sequence[PhotoLike]) -> bool:
    positions = _positions(photos)
    is_known = ~np.isnan(positions[:, 0])
    if is_known.mean() < 0.9:
        return False
    accuracy = [p.gps_accuracy_m for p in photos if p.gps_accuracy_m is not None]
    noise = float(np.median(accuracy)) if accuracy else 3.0
    spread = float(np.ptp(positions[is_known, :2], axis=0).max())
    return spread > max(_MIN_SPREAD_M, 5 * noise)


def _nearest_pairs(photos: Sequence[PhotoLike]) -> set[Pair]:
    from scipy.spatial import cKDTree

    positions = _positions(photos)
    known_indices = np.flatnonzero(~np.isnan(positions[:, 0]))
    count = min(_N_NEIGHBOURS + 1, len(known_indices))
    _, rows = cKDTree(positions[known_indices]).query(positions[known_indices], k=count)
    pairs = {
        (int(min(i, j)), int(max(i, j)))
        for i, neighbours in zip(
            known_indices, known_indices[rows.reshape(len(known_indices), -1)], strict=True
        )
        for j in neighbours
        if i != j
    }
    # Photos without a position are compared with all photos.
    for i in np.flatnonzero(np.isnan(positions[:, 0])):
        pairs |= {(min(int(i), j), max(int(i), j)) for j in range(len(photos)) if j != i}
    return pairs


def _most_similar_pairs(features: Sequence[Features], progress: Progress) -> set[Pair]:
    n = len(features)
    largest_descriptors: list[Float32Array] = []
    for f in features:
        largest_rows = np.argsort(-sizes(f.keypoints), kind="stable")[:_N_PRESELECTION_FEATURES]
        d = f.descriptors[largest_rows].astype(np.float32)
        largest_descriptors.append(d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-6))
    score = np.zeros((n, n), np.int32)
    n_all_pairs = n * (n - 1) // 2
    progress.stage(tr("Finding similar photos"), n_all_pairs)
    for i in range(n):
        progress.step(n_all_pairs - (n - i) * (n - i - 1) // 2)
        for j in range(i + 1, n):
            score[i, j] = score[j, i] = _count_mutual_matches(
                largest_descriptors[i], largest_descriptors[j]
            )
    pairs: set[Pair] = set()
    for i in range(n):
        ranked_rows = np.argsort(-score[i], kind="stable")
        pairs |= {
            (min(i, int(j)), max(i, int(j)))
            for j in ranked_rows[:_N_NEIGHBOURS]
            if score[i, j] > 3 and j != i
        }
    return pairs


def _count_mutual_matches(a: Float32Array, b: Float32Array) -> int:
    """Count the mutual nearest neighbours that pass the ratio test."""
    if len(a) < 2 or len(b) < 2:
        return 0
    cosine = a @ b.T
    best_columns = cosine.argmax(axis=1)
    best_cosines = cosine.max(axis=1)
    other_cosines = cosine.copy()
    other_cosines[np.arange(len(a)), best_columns] = -1
    # Lowe's ratio test with a threshold of 0.8, applied to angles.
    is_distinct = np.arccos(np.clip(best_cosines, -1, 1)) < 0.8 * np.arccos(
        np.clip(other_cosines.max(axis=1), -1, 1)
    )
    return int((is_distinct & (cosine.argmax(axis=0)[best_columns] == np.arange(len(a)))).sum())


def match_pairs(
    path: Path,
    pairs: Sequence[Pair],
    progress: Progress,
    *,
    threads: int = -1,
    seed: int = 0,
) -> None:
    """Match and verify the pairs that are not yet in the database.

    Raises
    ------
    Cancelled
        Possibly in the middle of a block.
    """
    pycolmap = colmap()
    with open_for_reading(path) as database:
        remaining_pairs = [pair for pair in pairs if not is_compared(database, pair)]
    progress.stage(tr("Matching photos"), len(pairs))
    finished_count = len(pairs) - len(remaining_pairs)
    progress.step(finished_count)
    matching = pycolmap.FeatureMatchingOptions()
    matching.num_threads = threads
    matching.use_gpu = False
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = seed
    pairing = pycolmap.ImportedPairingOptions()
    pairing.block_size = _BLOCK_SIZE
    # A single matcher reuses the search trees of the photos from block to block.
    with (
        tempfile.TemporaryDirectory(prefix="vom-pairs-") as folder,
        open_existing_database(path) as database_view,
    ):
        initial_count = count_compared(database_view)

        def count_finished() -> int:
            try:
                return finished_count + count_compared(database_view) - initial_count
            except RuntimeError:
                # COLMAP is merging its log into the database.
                return finished_count

        pairing.match_list_path = Path(folder, "pairs.txt")
        pairing.match_list_path.write_text(
            "".join(f"{image_name(i)} {image_name(j)}\n" for i, j in remaining_pairs),
            encoding="utf-8",
        )
        if remaining_pairs:
            run_cancellable(
                lambda token: pycolmap.match_image_pairs(
                    path,
                    matching_options=matching,
                    pairing_options=pairing,
                    verification_options=verification,
                    device=pycolmap.Device.cpu,
                    cancellation_token=token,
                ),
                progress,
                count_finished,
            )
    progress.step(len(pairs))
