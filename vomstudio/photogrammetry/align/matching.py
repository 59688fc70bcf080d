"""Which photos see the same rock: COLMAP's database, and the matching of pairs of photos.

Pairs are matched in blocks of a few seconds, and every finished pair stays in the database, so that
a stopped run goes on where it was.
"""

from __future__ import annotations

import json
import sqlite3
import tempfile
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.photogrammetry.align.features import Features, sizes
from vomstudio.photogrammetry.base.colmap import cancellable, colmap
from vomstudio.progress import Progress, Silent
from vomstudio.words import tr, tr_n

Pair = tuple[int, int]
MatchingRule = Literal["auto", "exhaustive", "spatial", "preselected", "sequential"]

_EXHAUSTIVE_UP_TO = 60
_NEIGHBOURS = 30
_IN_SEQUENCE = 10
_BLOCK = 12
_DEFAULT_FOCAL = 1.2
# Of the positions from GPS: under this spread they say nothing about who is whose neighbour.
_SMALLEST_SPREAD_M = 10.0
_FOR_PRESELECTION = 400


class PhotoLike(Protocol):
    """What the alignment wants to know of a photo (see `io.photos.Photo`)."""

    @property
    def path(self) -> Path: ...
    @property
    def name(self) -> str: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def camera_key(self) -> tuple[object, ...]: ...
    @property
    def focal_px(self) -> float | None: ...
    @property
    def latitude_deg(self) -> float | None: ...
    @property
    def longitude_deg(self) -> float | None: ...
    @property
    def altitude_m(self) -> float | None: ...
    @property
    def altitude_reference(self) -> str | None: ...
    @property
    def gps_accuracy_m(self) -> float | None: ...
    @property
    def taken(self) -> datetime | None: ...
    @property
    def mask(self) -> Path | None: ...


@dataclass(frozen=True)
class PairChoice:
    """pairs : (i, j) with i < j, rows of the photos
    rule : a sentence for the report
    """

    pairs: tuple[Pair, ...]
    rule: str


def choose_pairs(
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    rule: MatchingRule = "auto",
    progress: Progress | None = None,
) -> PairChoice:
    """Which photos are compared.

    Up to 60 photos all with all. More of them, with GPS: each with its 30 nearest; without: each
    with the 30 whose 400 largest features resemble its own most (Wu 2013, 3DV, "preemptive
    matching"). Both add the next ones in the order of the names. Video: the next 10 frames, and
    those 20, 40, 80 ... later, by which a path that comes back is closed.
    """
    n = len(photos)
    every = n * (n - 1) // 2
    if rule == "auto":
        if n <= _EXHAUSTIVE_UP_TO:
            rule = "exhaustive"
        else:
            rule = "spatial" if _gps_helps(photos) else "preselected"
    if rule == "exhaustive":
        return PairChoice(
            tuple((i, j) for i in range(n) for j in range(i + 1, n)),
            tr_n(
                "All photos were matched with each other ({count} pair).",
                "All photos were matched with each other ({count} pairs).",
                every,
            ),
        )
    if rule == "sequential":
        steps = [*range(1, _IN_SEQUENCE + 1)]
        while steps[-1] * 2 < n:
            steps.append(steps[-1] * 2)
        pairs = {(i, i + s) for s in steps for i in range(n - s)}
        said = tr(
            "Each frame was matched with the next {neighbours} and with some later ones ({count} "
            "of {total} pairs).",
            neighbours=_IN_SEQUENCE,
            count=len(pairs),
            total=every,
        )
        return PairChoice(tuple(sorted(pairs)), said)
    pairs = {(i, i + s) for s in (1, 2, 3) for i in range(n - s)}
    if rule == "spatial":
        pairs |= _nearest(photos)
        said = tr(
            "Each photo was matched with its {neighbours} nearest by GPS and with the next ones by "
            "name ({count} of {total} pairs).",
            neighbours=_NEIGHBOURS,
            count=len(pairs),
            total=every,
        )
    else:
        pairs |= _most_similar(features, progress or Silent())
        said = tr(
            "Each photo was matched with the {neighbours} most similar and with the next ones by "
            "name ({count} of {total} pairs).",
            neighbours=_NEIGHBOURS,
            count=len(pairs),
            total=every,
        )
    return PairChoice(tuple(sorted(pairs)), said)


def _positions(photos: Sequence[PhotoLike]) -> npt.NDArray[np.float64]:
    """(n, 3) metres about the first position, good for distances only; NaN without GPS."""
    rows = [
        (p.longitude_deg, p.latitude_deg, p.altitude_m or 0.0)
        if p.longitude_deg is not None and p.latitude_deg is not None
        else (np.nan,) * 3
        for p in photos
    ]
    places = np.array(rows, np.float64).reshape(-1, 3)
    if np.isnan(places).all():
        return places
    metres = 111_320.0
    east = metres * np.cos(np.radians(np.nanmean(places[:, 1])))
    return np.asarray((places - np.nanmedian(places, axis=0)) * [east, metres, 1.0])


def _gps_helps(photos: Sequence[PhotoLike]) -> bool:
    places = _positions(photos)
    known = ~np.isnan(places[:, 0])
    if known.mean() < 0.9:
        return False
    accuracy = [p.gps_accuracy_m for p in photos if p.gps_accuracy_m is not None]
    noise = float(np.median(accuracy)) if accuracy else 3.0
    spread = float(np.ptp(places[known, :2], axis=0).max())
    return spread > max(_SMALLEST_SPREAD_M, 5 * noise)


def _nearest(photos: Sequence[PhotoLike]) -> set[Pair]:
    from scipy.spatial import cKDTree

    places = _positions(photos)
    known = np.flatnonzero(~np.isnan(places[:, 0]))
    count = min(_NEIGHBOURS + 1, len(known))
    _, rows = cKDTree(places[known]).query(places[known], k=count)
    pairs = {
        (int(min(i, j)), int(max(i, j)))
        for i, near in zip(known, known[rows.reshape(len(known), -1)], strict=True)
        for j in near
        if i != j
    }
    # Photos without a position are compared with all.
    for i in np.flatnonzero(np.isnan(places[:, 0])):
        pairs |= {(min(int(i), j), max(int(i), j)) for j in range(len(photos)) if j != i}
    return pairs


def _most_similar(features: Sequence[Features], progress: Progress) -> set[Pair]:
    n = len(features)
    largest: list[npt.NDArray[np.float32]] = []
    for f in features:
        chosen = np.argsort(-sizes(f.keypoints), kind="stable")[:_FOR_PRESELECTION]
        d = f.descriptors[chosen].astype(np.float32)
        largest.append(d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-6))
    score = np.zeros((n, n), np.int32)
    every = n * (n - 1) // 2
    progress.stage(tr("Finding similar photos"), every)
    for i in range(n):
        progress.step(every - (n - i) * (n - i - 1) // 2)
        for j in range(i + 1, n):
            score[i, j] = score[j, i] = _mutual_matches(largest[i], largest[j])
    pairs: set[Pair] = set()
    for i in range(n):
        best = np.argsort(-score[i], kind="stable")
        pairs |= {
            (min(i, int(j)), max(i, int(j)))
            for j in best[:_NEIGHBOURS]
            if score[i, j] > 3 and j != i
        }
    return pairs


def _mutual_matches(a: npt.NDArray[np.float32], b: npt.NDArray[np.float32]) -> int:
    """Number of distinct mutual nearest neighbours."""
    if len(a) < 2 or len(b) < 2:
        return 0
    cosine = a @ b.T
    best = cosine.argmax(axis=1)
    first = cosine.max(axis=1)
    rest = cosine.copy()
    rest[np.arange(len(a)), best] = -1
    # Lowe's ratio of 0.8, of angles.
    clear = np.arccos(np.clip(first, -1, 1)) < 0.8 * np.arccos(np.clip(rest.max(axis=1), -1, 1))
    return int((clear & (cosine.argmax(axis=0)[best] == np.arange(len(a)))).sum())


# ------------------------------------------------------------------------------------------------
def open_database(
    path: Path,
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    keys: Sequence[str],
    lenses: Sequence[int] | None = None,
) -> None:
    """Make the database of these photos, or keep one that is of exactly these and sound.

    Photo number i becomes image i + 1; photos with the same `camera_key`, size and number of the
    lens share a camera.
    """
    lenses = lenses or [0] * len(photos)
    stated = json.dumps(
        [
            [p.name, p.width, p.height, repr(p.camera_key), p.focal_px, k, lens]
            for p, k, lens in zip(photos, keys, lenses, strict=True)
        ]
    )
    note = path.with_suffix(".json")
    try:
        if note.read_text(encoding="utf-8") == stated and _is_sound(path):
            return
    except OSError:
        pass
    note.unlink(missing_ok=True)
    for tail in ("", "-wal", "-shm", "-journal"):
        path.with_name(path.name + tail).unlink(missing_ok=True)
    pycolmap = colmap()
    cameras: dict[tuple[object, ...], int] = {}
    database = pycolmap.Database.open(path)
    try:
        of_photo = [
            (p.camera_key, p.width, p.height, lens) for p, lens in zip(photos, lenses, strict=True)
        ]
        for photo, key in zip(photos, of_photo, strict=True):
            if key not in cameras:
                cameras[key] = len(cameras) + 1
                camera = _camera(photo, cameras[key])
                database.write_camera(camera, use_camera_id=True)
                rig = pycolmap.Rig(rig_id=cameras[key])
                rig.add_ref_sensor(camera.sensor_id)
                database.write_rig(rig, use_rig_id=True)
        for row, found in enumerate(features):
            camera_id = cameras[of_photo[row]]
            image = pycolmap.Image(name=image_name(row), camera_id=camera_id, image_id=row + 1)
            database.write_image(image, use_image_id=True)
            frame = pycolmap.Frame(frame_id=row + 1, rig_id=camera_id)
            frame.add_data_id(image.data_id)
            database.write_frame(frame, use_frame_id=True)
            database.write_keypoints(row + 1, found.keypoints)
            descriptors = pycolmap.FeatureDescriptors(
                pycolmap.FeatureExtractorType.SIFT, found.descriptors
            )
            database.write_descriptors(row + 1, descriptors)
    finally:
        database.close()
    note.write_text(stated, encoding="utf-8")


def image_name(row: int) -> str:
    """In the database: COLMAP's lists of pairs take no name with a space."""
    return f"{row + 1:06d}"


def starting_focal(photo: PhotoLike) -> float:
    """Pixels; of a lens of ordinary width where the photo does not say."""
    return photo.focal_px or _DEFAULT_FOCAL * max(photo.width, photo.height)


def _camera(photo: PhotoLike, number: int) -> Any:
    camera = colmap().Camera(
        model="SIMPLE_RADIAL",
        width=photo.width,
        height=photo.height,
        params=[starting_focal(photo), photo.width / 2, photo.height / 2, 0.0],
    )
    camera.camera_id = number
    camera.has_prior_focal_length = photo.focal_px is not None
    return camera


def _is_sound(path: Path) -> bool:
    try:
        with closing(_connection(path)) as connection:
            return bool(connection.execute("PRAGMA quick_check").fetchone() == ("ok",))
    except sqlite3.Error:
        return False


def _connection(path: Path) -> sqlite3.Connection:
    if not path.exists():
        raise sqlite3.OperationalError("no such file")
    return sqlite3.connect(path, timeout=10)


def finished_pairs(path: Path) -> set[Pair]:
    """Rows of photos that have been compared, with whatever result."""
    pycolmap = colmap()
    with closing(_connection(path)) as connection:
        rows = connection.execute("SELECT pair_id FROM two_view_geometries").fetchall()
    pairs = (pycolmap.pair_id_to_image_pair(row[0]) for row in rows)
    return {(min(a, b) - 1, max(a, b) - 1) for a, b in pairs}


def match_pairs(
    path: Path,
    pairs: Sequence[Pair],
    progress: Progress,
    *,
    threads: int = -1,
    seed: int = 0,
) -> None:
    """Match and verify what is not yet in the database. Raises Cancelled within a block."""
    pycolmap = colmap()
    done = finished_pairs(path)
    left = [pair for pair in pairs if pair not in done]
    progress.stage(tr("Matching photos"), len(pairs))
    finished = len(pairs) - len(left)
    progress.step(finished)
    matching = pycolmap.FeatureMatchingOptions()
    matching.num_threads = threads
    matching.use_gpu = False
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = seed
    pairing = pycolmap.ImportedPairingOptions()
    pairing.block_size = _BLOCK
    # One call for all: it keeps the search trees of the photos from block to block.
    with (
        tempfile.TemporaryDirectory(prefix="vom-pairs-") as folder,
        closing(_connection(path)) as watching,
    ):
        pairing.match_list_path = Path(folder, "pairs.txt")
        pairing.match_list_path.write_text(
            "".join(f"{image_name(i)} {image_name(j)}\n" for i, j in left), encoding="utf-8"
        )
        if left:
            cancellable(
                lambda token: pycolmap.match_image_pairs(
                    path,
                    matching_options=matching,
                    pairing_options=pairing,
                    verification_options=verification,
                    device=pycolmap.Device.cpu,
                    cancellation_token=token,
                ),
                progress,
                lambda: max(finished, _count(watching, len(done), finished)),
            )
    progress.step(len(pairs))


def _count(watching: sqlite3.Connection, other: int, finished: int) -> int:
    """Pairs of this run in the database; it may be read while COLMAP writes (write-ahead log)."""
    try:
        row = watching.execute("SELECT count(*) FROM two_view_geometries").fetchone()
    except sqlite3.OperationalError:
        return finished
    return finished + int(row[0]) - other


def pair_counts(path: Path) -> dict[Pair, int]:
    """Verified matches of every pair of photos (rows) that has any."""
    pycolmap = colmap()
    with closing(_connection(path)) as connection:
        rows = connection.execute(
            "SELECT pair_id, rows FROM two_view_geometries WHERE rows > 0 ORDER BY pair_id"
        ).fetchall()
    counts: dict[Pair, int] = {}
    for pair_id, count in rows:
        a, b = pycolmap.pair_id_to_image_pair(pair_id)
        counts[(min(a, b) - 1, max(a, b) - 1)] = int(count)
    return counts


# ------------------------------------------------------------------------------------------------
def match_counts(path: Path) -> dict[Pair, tuple[int, int]]:
    """(matches, verified matches) of every pair of photos (rows) that was compared. Raises
    InputError without a sound database."""
    pycolmap = colmap()
    counts: dict[Pair, tuple[int, int]] = {}
    for pair_id, tried, kept in _rows_of_query(
        path,
        "SELECT g.pair_id, m.rows, g.rows FROM two_view_geometries g "
        "LEFT JOIN matches m ON m.pair_id = g.pair_id",
    ):
        a, b = pycolmap.pair_id_to_image_pair(pair_id)
        counts[(min(a, b) - 1, max(a, b) - 1)] = (max(int(tried or 0), int(kept)), int(kept))
    return counts


def feature_counts(path: Path) -> dict[int, int]:
    """Features of every photo (row). Raises InputError without a sound database."""
    rows = _rows_of_query(path, "SELECT image_id, rows FROM keypoints")
    return {int(image) - 1: int(count) for image, count in rows}


def _rows_of_query(path: Path, question: str) -> list[tuple[Any, ...]]:
    try:
        with closing(_connection(path)) as connection:
            return connection.execute(question).fetchall()
    except sqlite3.Error as error:
        raise InputError(
            tr("The matches cannot be read ({error}). Align the photos again.", error=error),
            file=path,
        ) from error


Rows = npt.NDArray[np.int64]


def matches_of_pair(
    path: Path, a: int, b: int
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], Rows, Rows]:
    """Features (n, 2) and (n, 2) in pixels of two photos (rows), and rows of both (m, 2): of all
    matches, and of the verified ones. Raises InputError without a database."""
    if not path.exists():
        raise InputError(tr("There are no matches. Align the photos first."), file=path)
    database = colmap().Database.open(path)
    try:
        tried = database.read_matches(a + 1, b + 1)
        kept = database.read_two_view_geometry(a + 1, b + 1).inlier_matches
        left, right = (database.read_keypoints(i + 1)[:, :2] for i in (a, b))
    finally:
        database.close()
    # Cut loose from COLMAP's memory.
    first, second = (np.array(points, np.float32).reshape(-1, 2) for points in (left, right))
    every, agreeing = (np.array(rows, np.int64).reshape(-1, 2) for rows in (tried, kept))
    return first, second, every, agreeing
