"""Calibration of each camera from the photos, by the rules of `priors`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.photogrammetry.align import priors
from vomstudio.photogrammetry.align.adjustment import (
    adjust,
    cross_validation_error,
    free_parameters,
)
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.align.priors import Calibration, Freedom
from vomstudio.photogrammetry.base.colmap import colmap


def calibrate(
    reconstruction: Any,
    photos: Sequence[PhotoLike],
    threads: int,
    trusted: bool,
    progress: Progress,
) -> tuple[Any, list[Calibration]]:
    """Decide what is free of each camera, adjust, and take back what turns out undetermined; then
    the same with the rest of the lens.

    Returns the adjusted reconstruction, maybe another one, and its cameras. Raises Cancelled.
    """
    images = sorted(reconstruction.reg_image_ids())
    by_camera: dict[int, list[int]] = {}
    for image in images:
        by_camera.setdefault(reconstruction.image(image).camera_id, []).append(image - 1)
    convergence = priors.convergence_deg(priors.part_axes(reconstruction))
    freedoms: dict[int, Freedom] = {}
    reasons: dict[int, tuple[Finding, ...]] = {}
    for number, rows in by_camera.items():
        known = photos[rows[0]].focal_px is not None
        freedoms[number], reason = priors.decide(known, len(rows), convergence, trusted)
        reasons[number] = (reason,)
    covariances = adjust(reconstruction, freedoms, threads=threads, progress=progress)
    factors = _factors(reconstruction, by_camera)
    back = False
    for number, rows in by_camera.items():
        if not freedoms[number].focal:
            continue
        relative = _focal_sigma(reconstruction, number, covariances) * factors[number]
        lens = photos[rows[0]]
        held = priors.held_instead(lens.focal_px, max(lens.width, lens.height), relative, trusted)
        if held is not None:
            freedoms[number] = replace(freedoms[number], focal=False)
            value, reason = held
            reasons[number] = (reason,)
            priors.set_focal(reconstruction, number, value)
            back = True
    if back:
        covariances = adjust(reconstruction, freedoms, threads=threads, progress=progress)
    given = dict(reasons)

    def widen() -> None:
        nonlocal reconstruction, freedoms, covariances
        reasons.update(given)
        wider = _widened(
            reconstruction, by_camera, freedoms, reasons, convergence, threads, progress
        )
        if wider is not None:
            reconstruction, freedoms, covariances = wider

    widen()
    held_to_exif = [
        number
        for number, rows in by_camera.items()
        if photos[rows[0]].focal_px is not None and not freedoms[number].focal
    ]
    against = _contradicted(
        reconstruction, by_camera, freedoms, held_to_exif, given, threads, progress
    )
    if against is not None:
        reconstruction, freedoms, covariances = against
        widen()
    factors = _factors(reconstruction, by_camera)
    return reconstruction, [
        _describe(
            reconstruction.camera(number),
            freedoms[number],
            covariances.get(number),
            factors[number],
            [photos[row] for row in rows],
            reasons[number],
            convergence,
        )
        for number, rows in sorted(by_camera.items())
    ]


def _contradicted(
    base: Any,
    by_camera: dict[int, list[int]],
    freedoms: dict[int, Freedom],
    numbers: Sequence[int],
    reasons: dict[int, tuple[Finding, ...]],
    threads: int,
    progress: Progress,
) -> tuple[Any, dict[int, Freedom], dict[int, FloatArray]] | None:
    """(reconstruction, freedoms, covariances) without the focal lengths from EXIF of the cameras
    `numbers`, where the photos speak clearly against them; else None. Updates `reasons`; `base`
    stays."""
    if not numbers:
        return None
    progress.step(0)
    tried = {n: replace(f, focal=f.focal or n in numbers) for n, f in freedoms.items()}
    trial = _with_lenses(base, tried)
    covariances = adjust(trial, tried, threads=threads, progress=progress)
    factors = _factors(trial, by_camera)
    wrong = {}
    for number in numbers:
        exif, focal = (float(r.camera(number).params[0]) for r in (base, trial))
        sigma = _focal_sigma(trial, number, covariances) * factors[number]
        if priors.far_from_exif(focal / exif, sigma):
            wrong[number] = 100 * (exif / focal - 1)
    if not wrong:
        return None
    if len(wrong) < len(numbers):
        tried = {n: replace(f, focal=f.focal or n in wrong) for n, f in freedoms.items()}
        trial = _with_lenses(base, tried)
        covariances = adjust(trial, tried, threads=threads, progress=progress)
    before = cross_validation_error(base, freedoms, threads=threads, progress=progress)
    after = cross_validation_error(trial, tried, threads=threads, progress=progress)
    if not after < priors.CONTRADICTED * before:
        return None
    for number, off in wrong.items():
        reason = Finding(
            "lens.exif-contradicted", off_percent=off, before_px=before, after_px=after
        )
        reasons[number] = (reason,)
    return trial, tried, covariances


def _widened(
    base: Any,
    by_camera: dict[int, list[int]],
    freedoms: dict[int, Freedom],
    reasons: dict[int, tuple[Finding, ...]],
    convergence: float,
    threads: int,
    progress: Progress,
) -> tuple[Any, dict[int, Freedom], dict[int, FloatArray]] | None:
    """(reconstruction, freedoms, covariances) with what proves good of k2 and the principal points
    of the cameras, None where nothing does. Updates `reasons`; `base` stays."""
    tried = {
        number: priors.with_lens_parameters(freedoms[number], len(rows), convergence)
        for number, rows in by_camera.items()
    }
    checks: dict[int, dict[str, Finding]] = {number: {} for number in tried}
    while tried != freedoms:
        progress.step(0)
        trial = _with_lenses(base, tried)
        covariances = adjust(trial, tried, threads=threads, progress=progress)
        factors = _factors(trial, by_camera)
        kept = {
            number: _kept(
                trial.camera(number),
                freedom,
                covariances.get(number),
                factors[number],
                checks[number],
            )
            for number, freedom in tried.items()
        }
        if kept == tried:
            break
        tried = kept
    verdict: Finding | None = None
    if tried != freedoms:
        before = cross_validation_error(base, freedoms, threads=threads, progress=progress)
        wider = _with_lenses(base, tried)
        after = cross_validation_error(wider, tried, threads=threads, progress=progress)
        if not after <= before:
            verdict = Finding("lens.held-by-validation", after_px=after, before_px=before)
            tried = freedoms
    for number, results in checks.items():
        reasons[number] += (verdict,) if verdict else tuple(results.values())
    if tried == freedoms:
        return None
    return trial, tried, covariances


def _with_lenses(base: Any, freedoms: Mapping[int, Freedom]) -> Any:
    """A copy, with a place for k2 where that is free."""
    pycolmap = colmap()
    wider = pycolmap.Reconstruction(base)
    for number, freedom in freedoms.items():
        camera = wider.camera(number)
        if freedom.second and str(camera.model_name) == "SIMPLE_RADIAL":
            params = [*camera.params, 0.0]
            camera.model = pycolmap.CameraModelId.RADIAL
            camera.params = params
    return wider


def _kept(
    camera: Any,
    freedom: Freedom,
    covariance: FloatArray | None,
    factor: float,
    checks: dict[str, Finding],
) -> Freedom:
    """What of k2 and the principal point stands its trial; adds the reasons to `checks`."""
    if not (freedom.second or freedom.centre):
        return freedom
    if covariance is None:
        checks["lens"] = Finding("lens.undetermined")
        return replace(freedom, second=False, centre=False)
    places = free_parameters(camera, freedom)
    names = priors.parameter_names(str(camera.model_name))
    of = {names[place]: row for row, place in enumerate(places)}
    values = dict(zip(names, camera.params, strict=True))
    scaled = covariance * factor**2
    corner = float(np.hypot(camera.width, camera.height)) / 2
    if freedom.second:
        sigma = float(np.sqrt(scaled[of["k2"], of["k2"]]))
        second, checks["k2"] = priors.judge_second(values["f"], corner, values["k2"], sigma)
        freedom = replace(freedom, second=second)
    if freedom.centre:
        rows = [of["cx"], of["cy"]]
        shift = np.array([values["cx"] - camera.width / 2, values["cy"] - camera.height / 2])
        centre, checks["centre"] = priors.judge_centre(
            values["f"], corner, shift, scaled[np.ix_(rows, rows)]
        )
        freedom = replace(freedom, centre=centre)
    return freedom


def _focal_sigma(reconstruction: Any, number: int, covariances: dict[int, FloatArray]) -> float:
    """Relative, formal, for residuals of unit variance; infinite where it could not be had."""
    if number not in covariances:
        return float("inf")
    # The focal length is the first parameter of every model.
    camera = reconstruction.camera(number)
    return float(np.sqrt(covariances[number][0, 0]) / camera.params[0])


def _factors(reconstruction: Any, by_camera: dict[int, list[int]]) -> dict[int, float]:
    """What formal errors of each camera are multiplied by: the scatter of the residuals, and that
    neighbouring points err together."""
    reconstruction.update_point_3d_errors()
    observations = reconstruction.compute_num_observations()
    photos = reconstruction.num_reg_images()
    redundancy = 2 * observations - 3 * reconstruction.num_points3D() - 6 * photos
    # Mean error to root mean square per coordinate, of a Gaussian in the plane.
    rms = reconstruction.compute_mean_reprojection_error() / np.sqrt(np.pi / 2)
    scatter = rms * np.sqrt(2 * observations / max(redundancy, 1))
    factors = {}
    for number, rows in by_camera.items():
        own = sum(reconstruction.image(row + 1).num_points3D for row in rows)
        factors[number] = float(scatter * priors.correlated_factor(own, len(rows)))
    return factors


def _describe(
    camera: Any,
    freedom: Freedom,
    covariance: FloatArray | None,
    factor: float,
    photos: list[PhotoLike],
    reasons: tuple[Finding, ...],
    convergence: float,
) -> Calibration:
    count = len(camera.params)
    sigma = np.zeros(count)
    correlation = np.full((count, count), np.nan)
    free = free_parameters(camera, freedom)
    if covariance is not None and len(covariance) == len(free):
        formal = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        sigma[free] = formal * factor
        correlation[np.ix_(free, free)] = covariance / np.outer(formal, formal)
    elif free:
        sigma[free] = np.nan
    model = str(camera.model_name)
    return Calibration(
        model,
        priors.parameter_names(model),
        tuple(float(p) for p in camera.params),
        tuple(sigma.tolist()),
        tuple(tuple(row) for row in correlation.tolist()),
        tuple(p.name for p in photos),
        "freed" if freedom.focal else "held",
        reasons,
        photos[0].focal_px,
        convergence,
    )
