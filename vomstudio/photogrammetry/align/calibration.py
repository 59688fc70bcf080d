"""Calibration of each camera from the photos, following the rules in `priors`."""

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
    free_parameter_indices,
)
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.align.priors import Calibration, Freedom
from vomstudio.photogrammetry.base.colmap import colmap


def calibrate(
    reconstruction: Any,
    photos: Sequence[PhotoLike],
    threads: int,
    is_exif_trusted: bool,
    progress: Progress,
) -> tuple[Any, list[Calibration]]:
    """Adjust the free parameters of each camera, and fix those that are poorly determined.

    The focal lengths and k1 are adjusted first, then k2 and the principal points are tested. Fixed
    EXIF focal lengths that the photos contradict are freed. Returns the adjusted reconstruction,
    which may be a new object, and its cameras. Raises Cancelled.
    """
    images = sorted(reconstruction.reg_image_ids())
    photos_by_camera: dict[int, list[int]] = {}
    for image in images:
        photos_by_camera.setdefault(reconstruction.image(image).camera_id, []).append(image - 1)
    convergence = priors.convergence_deg(priors.part_axes(reconstruction))
    freedoms: dict[int, Freedom] = {}
    reasons: dict[int, tuple[Finding, ...]] = {}
    for number, rows in photos_by_camera.items():
        is_known = photos[rows[0]].focal_px is not None
        freedoms[number], reason = priors.select_free_parameters(
            is_known, len(rows), convergence, is_exif_trusted
        )
        reasons[number] = (reason,)
    covariances = adjust(reconstruction, freedoms, threads=threads, progress=progress)
    factors = _error_factors(reconstruction, photos_by_camera)
    is_focal_fixed = False
    for number, rows in photos_by_camera.items():
        if not freedoms[number].focal:
            continue
        relative_focal_sigma = _focal_sigma(reconstruction, number, covariances) * factors[number]
        lens = photos[rows[0]]
        replacement = priors.fixed_focal(
            lens.focal_px, max(lens.width, lens.height), relative_focal_sigma, is_exif_trusted
        )
        if replacement is not None:
            freedoms[number] = replace(freedoms[number], focal=False)
            value, reason = replacement
            reasons[number] = (reason,)
            priors.set_focal(reconstruction, number, value)
            is_focal_fixed = True
    if is_focal_fixed:
        covariances = adjust(reconstruction, freedoms, threads=threads, progress=progress)
    initial_reasons = dict(reasons)

    def free_more_parameters() -> None:
        nonlocal reconstruction, freedoms, covariances
        reasons.update(initial_reasons)
        result = _free_lens_parameters(
            reconstruction, photos_by_camera, freedoms, reasons, convergence, threads, progress
        )
        if result is not None:
            reconstruction, freedoms, covariances = result

    free_more_parameters()
    exif_camera_ids = [
        number
        for number, rows in photos_by_camera.items()
        if photos[rows[0]].focal_px is not None and not freedoms[number].focal
    ]
    freed_result = _free_contradicted_focals(
        reconstruction,
        photos_by_camera,
        freedoms,
        exif_camera_ids,
        initial_reasons,
        threads,
        progress,
    )
    if freed_result is not None:
        reconstruction, freedoms, covariances = freed_result
        free_more_parameters()
    factors = _error_factors(reconstruction, photos_by_camera)
    return reconstruction, [
        _describe_calibration(
            reconstruction.camera(number),
            freedoms[number],
            covariances.get(number),
            factors[number],
            [photos[row] for row in rows],
            reasons[number],
            convergence,
        )
        for number, rows in sorted(photos_by_camera.items())
    ]


def _free_contradicted_focals(
    base: Any,
    photos_by_camera: dict[int, list[int]],
    freedoms: dict[int, Freedom],
    numbers: Sequence[int],
    reasons: dict[int, tuple[Finding, ...]],
    threads: int,
    progress: Progress,
) -> tuple[Any, dict[int, Freedom], dict[int, FloatArray]] | None:
    """Free the fixed EXIF focal lengths that the photos clearly contradict.

    Returns the reconstruction, the freedoms and the covariances, or None if no focal length is
    freed. Updates `reasons` and leaves `base` unchanged.
    """
    if not numbers:
        return None
    progress.step(0)
    trial_freedoms = {n: replace(f, focal=f.focal or n in numbers) for n, f in freedoms.items()}
    trial = _copy_with_k2(base, trial_freedoms)
    covariances = adjust(trial, trial_freedoms, threads=threads, progress=progress)
    factors = _error_factors(trial, photos_by_camera)
    contradictions = {}
    for number in numbers:
        exif, focal = (float(r.camera(number).params[0]) for r in (base, trial))
        sigma = _focal_sigma(trial, number, covariances) * factors[number]
        if priors.is_far_from_exif(focal / exif, sigma):
            contradictions[number] = 100 * (exif / focal - 1)
    if not contradictions:
        return None
    if len(contradictions) < len(numbers):
        trial_freedoms = {
            n: replace(f, focal=f.focal or n in contradictions) for n, f in freedoms.items()
        }
        trial = _copy_with_k2(base, trial_freedoms)
        covariances = adjust(trial, trial_freedoms, threads=threads, progress=progress)
    error_before = cross_validation_error(base, freedoms, threads=threads, progress=progress)
    error_after = cross_validation_error(trial, trial_freedoms, threads=threads, progress=progress)
    if not error_after < priors.MAX_VALIDATION_RATIO * error_before:
        return None
    for number, contradiction in contradictions.items():
        reason = Finding(
            "lens.exif-contradicted",
            off_percent=contradiction,
            before_px=error_before,
            after_px=error_after,
        )
        reasons[number] = (reason,)
    return trial, trial_freedoms, covariances


def _free_lens_parameters(
    base: Any,
    photos_by_camera: dict[int, list[int]],
    freedoms: dict[int, Freedom],
    reasons: dict[int, tuple[Finding, ...]],
    convergence: float,
    threads: int,
    progress: Progress,
) -> tuple[Any, dict[int, Freedom], dict[int, FloatArray]] | None:
    """Free k2 and the principal point of each camera if the photos determine them.

    They must also not increase the cross-validation error. Returns the reconstruction, the freedoms
    and the covariances, or None if no parameter is freed. Updates `reasons` and leaves `base`
    unchanged.
    """
    trial_freedoms = {
        number: priors.free_lens_parameters(freedoms[number], len(rows), convergence)
        for number, rows in photos_by_camera.items()
    }
    checks: dict[int, dict[str, Finding]] = {number: {} for number in trial_freedoms}
    while trial_freedoms != freedoms:
        progress.step(0)
        trial = _copy_with_k2(base, trial_freedoms)
        covariances = adjust(trial, trial_freedoms, threads=threads, progress=progress)
        factors = _error_factors(trial, photos_by_camera)
        determined_freedoms = {
            number: _fix_undetermined(
                trial.camera(number),
                freedom,
                covariances.get(number),
                factors[number],
                checks[number],
            )
            for number, freedom in trial_freedoms.items()
        }
        if determined_freedoms == trial_freedoms:
            break
        trial_freedoms = determined_freedoms
    verdict: Finding | None = None
    if trial_freedoms != freedoms:
        error_before = cross_validation_error(base, freedoms, threads=threads, progress=progress)
        extended_model = _copy_with_k2(base, trial_freedoms)
        error_after = cross_validation_error(
            extended_model, trial_freedoms, threads=threads, progress=progress
        )
        if not error_after <= error_before:
            verdict = Finding(
                "lens.held-by-validation", after_px=error_after, before_px=error_before
            )
            trial_freedoms = freedoms
    for number, results in checks.items():
        reasons[number] += (verdict,) if verdict else tuple(results.values())
    if trial_freedoms == freedoms:
        return None
    return trial, trial_freedoms, covariances


def _copy_with_k2(base: Any, freedoms: Mapping[int, Freedom]) -> Any:
    """Copy a reconstruction and add k2 to the cameras for which it is free."""
    pycolmap = colmap()
    extended_model = pycolmap.Reconstruction(base)
    for number, freedom in freedoms.items():
        camera = extended_model.camera(number)
        if freedom.second_radial and str(camera.model_name) == "SIMPLE_RADIAL":
            params = [*camera.params, 0.0]
            camera.model = pycolmap.CameraModelId.RADIAL
            camera.params = params
    return extended_model


def _fix_undetermined(
    camera: Any,
    freedom: Freedom,
    covariance: FloatArray | None,
    factor: float,
    checks: dict[str, Finding],
) -> Freedom:
    """Fix k2 and the principal point again if they fail their tests.

    The results of the tests are added to `checks`.
    """
    if not (freedom.second_radial or freedom.centre):
        return freedom
    if covariance is None:
        checks["lens"] = Finding("lens.undetermined")
        return replace(freedom, second_radial=False, centre=False)
    indices = free_parameter_indices(camera, freedom)
    names = priors.parameter_names(str(camera.model_name))
    row_by_name = {names[parameter_row]: row for row, parameter_row in enumerate(indices)}
    values = dict(zip(names, camera.params, strict=True))
    scaled_covariance = covariance * factor**2
    corner = float(np.hypot(camera.width, camera.height)) / 2
    if freedom.second_radial:
        sigma = float(np.sqrt(scaled_covariance[row_by_name["k2"], row_by_name["k2"]]))
        is_k2_free, checks["k2"] = priors.judge_k2(values["f"], corner, values["k2"], sigma)
        freedom = replace(freedom, second_radial=is_k2_free)
    if freedom.centre:
        rows = [row_by_name["cx"], row_by_name["cy"]]
        shift = np.array([values["cx"] - camera.width / 2, values["cy"] - camera.height / 2])
        centre, checks["centre"] = priors.judge_centre(
            values["f"], corner, shift, scaled_covariance[np.ix_(rows, rows)]
        )
        freedom = replace(freedom, centre=centre)
    return freedom


def _focal_sigma(reconstruction: Any, number: int, covariances: dict[int, FloatArray]) -> float:
    """Return the relative formal error of a focal length, or infinity if not available."""
    if number not in covariances:
        return float("inf")
    # The focal length is the first parameter of every camera model.
    camera = reconstruction.camera(number)
    return float(np.sqrt(covariances[number][0, 0]) / camera.params[0])


def _error_factors(reconstruction: Any, photos_by_camera: dict[int, list[int]]) -> dict[int, float]:
    """Return the factor by which the formal errors of each camera are multiplied.

    The factors account for the scatter of the residuals and the correlation of neighbouring points.
    """
    reconstruction.update_point_3d_errors()
    observations = reconstruction.compute_num_observations()
    photos = reconstruction.num_reg_images()
    redundancy = 2 * observations - 3 * reconstruction.num_points3D() - 6 * photos
    # Converts a mean error to the RMS per coordinate, assuming a two-dimensional Gaussian.
    rms = reconstruction.compute_mean_reprojection_error() / np.sqrt(np.pi / 2)
    scatter = rms * np.sqrt(2 * observations / max(redundancy, 1))
    factors = {}
    for number, rows in photos_by_camera.items():
        point_count = sum(reconstruction.image(row + 1).num_points3D for row in rows)
        factors[number] = float(scatter * priors.correlation_factor(point_count, len(rows)))
    return factors


def _describe_calibration(
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
    parameter_indices = free_parameter_indices(camera, freedom)
    if covariance is not None and len(covariance) == len(parameter_indices):
        formal_errors = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        sigma[parameter_indices] = formal_errors * factor
        correlation[np.ix_(parameter_indices, parameter_indices)] = covariance / np.outer(
            formal_errors, formal_errors
        )
    elif parameter_indices:
        sigma[parameter_indices] = np.nan
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
