"""Surveys without pixels: what would be found in their photos, and how far cameras are off.

A feature is a point of the face that a camera sees, known again within 50 degrees of view.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.photogrammetry.align.surveys import Survey
from tests.photogrammetry.made_photos import Made, MadePhoto
from vomstudio.core.errors import VomError
from vomstudio.photogrammetry.align.features import Features
from vomstudio.registration.similarity import fit_similarity

SECTOR_DEG, NOISE_PX, SEEN = 50.0, 0.4, 0.7


def made(survey: Survey, folder: Path, per_photo: int = 3000) -> Made:
    """What would be found in the photos."""
    rng = np.random.default_rng(1)
    face, folder = survey.face, folder / "photos"
    folder.mkdir(parents=True, exist_ok=True)
    points, normals = _shown(survey, per_photo, rng)
    start = rng.random(len(points)) * SECTOR_DEG
    looks = rng.integers(0, 90, (len(points), 128))
    photos, features = [], []
    for row, view in enumerate(survey.views):
        rays = points - view.centre
        reach = np.linalg.norm(rays, axis=1)
        rays /= reach[:, None]
        pixels = view.project(points) + rng.normal(0, NOISE_PX, (len(points), 2))
        seen = view.contains(np.nan_to_num(pixels, nan=-1.0)) & (view.depths(points) > 0)
        seen &= (rays * normals).sum(1) < -0.3
        seen &= face.hits(view.centre, rays)[0] > 0.98 * reach
        seen &= rng.random(len(points)) < SEEN
        rows = np.flatnonzero(seen)
        # A point looks another from elsewhere; straight down there is no such direction.
        azimuth = np.degrees(np.arctan2(rays[rows, 0], rays[rows, 1])) % 360
        azimuth[np.abs(normals[rows, 2]) > 0.7] = 0
        sector = ((azimuth + start[rows]) // SECTOR_DEG).astype(int)
        found = np.empty((len(rows), 128), np.int64)
        for number in np.unique(sector):
            mine = sector == number
            order = np.random.default_rng(number).permutation(128)
            found[mine] = looks[rows[mine]][:, order]
        found += rng.integers(-2, 3, found.shape)
        keypoints = np.zeros((len(rows), 6), np.float32)
        keypoints[:, :2] = pixels[rows]
        keypoints[:, [2, 5]] = 2.0
        path = folder / view.name
        path.write_bytes(view.name.encode())
        lens, said = view.intrinsics, survey.said[row]
        focal = None if said is None else round(said) / 36 * max(lens.width, lens.height)
        photos.append(MadePhoto(path, view.name, lens.width, lens.height, ("camera", focal), focal))
        grey = np.full((len(rows), 3), 150, np.uint8)
        descriptors = np.clip(found, 0, 255).astype(np.uint8)
        features.append(Features(keypoints, descriptors, grey, lens.width, lens.height))
    return Made(photos, features, list(survey.views), points)


def _shown(survey: Survey, per_photo: int, rng: np.random.Generator) -> tuple[Any, Any]:
    """Points of the face, so many that a photo shows about `per_photo`."""
    points, _ = survey.face.scattered(20_000, rng)
    shown = [
        view.contains(np.nan_to_num(view.project(points), nan=-1.0)).mean() for view in survey.views
    ]
    return survey.face.scattered(int(per_photo / max(np.median(shown), 0.01)), rng)


def pixel_on_rock(survey: Survey) -> float:
    points, _ = survey.face.scattered(3000, np.random.default_rng(0))
    sizes = []
    for view in survey.views:
        inside = view.contains(np.nan_to_num(view.project(points), nan=-1.0))
        sizes.append(np.median(view.depths(points)[inside]) / view.intrinsics.focal[0])
    return float(np.median(sizes))


def centre_error(names: list[str], centres: np.ndarray, survey: Survey) -> tuple[float, float]:
    """(median error, extent of the true centres), metres; NaN where they are too few."""
    true = {view.name: view.centre for view in survey.views}
    wanted = np.array([true[name] for name in names])
    try:
        fit = fit_similarity(centres, wanted)
    except VomError:
        return float("nan"), 1.0
    error = float(np.median(np.linalg.norm(fit(centres) - wanted, axis=1)))
    return error, 2 * float(np.linalg.norm(wanted - wanted.mean(0), axis=1).max())
