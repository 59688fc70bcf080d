"""Data of the reconstruction report: rows of photos, registration, calibration and a drawing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.findings import Finding, plain
from vomstudio.core.version import __version__
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.photogrammetry.align.scene_check import photo_pixel_sizes
from vomstudio.photogrammetry.base.scene import SparseScene

if TYPE_CHECKING:
    from vomstudio.geology.bowing import Bowing, LensBend
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.photos.photo import Photo
    from vomstudio.photogrammetry.align.priors import Calibration
    from vomstudio.photogrammetry.georeferencing.control import ControlReport
    from vomstudio.photogrammetry.georeferencing.georeference import GpsReport
    from vomstudio.photogrammetry.georeferencing.placement import Placement

_DRAWN = 4000


def tie_points(scene: SparseScene) -> PointCloud:
    """In World, with their mean reprojection error and the number of photos that see them."""
    return PointCloud(
        scene.points + scene.origin,
        scene.colors,
        fields={
            "error_px": scene.errors_px.astype(np.float32),
            "views": scene.track_lengths.astype(np.uint16),
        },
    )


def photo_rows(
    photos: Sequence[Photo], scene: SparseScene, registration: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """For each photo: its tie points, their median reprojection error and ground sampling
    distance (`gsd_m`, or `gsd` in the unit of a scene without scale), and by how much it misses
    its GPS position."""
    numbers = {view.name: number for number, view in enumerate(scene.views)}
    residuals = {row["name"]: row["error_m"] for row in registration.get("residuals", [])}
    rows = []
    for photo in photos:
        row: dict[str, Any] = {
            "name": photo.name,
            "width": photo.width,
            "height": photo.height,
            "camera": photo.camera,
            "placed": photo.name in numbers,
            "tie_points": 0,
            "error_px": None,
            "gsd_m": None,
            "gsd": None,
            "residual_m": residuals.get(photo.name),
        }
        if photo.name in numbers:
            row |= _of_view(scene, numbers[photo.name])
        rows.append(row)
    return rows


def dense_gsd(rows: Sequence[Mapping[str, Any]], dense_px: int) -> dict[str, float | None]:
    """Median size on the rock of a pixel of the depth maps, whose long side has `dense_px`: in
    metres, and in the unit of a scene without scale."""
    return {f"dense_{name}": _dense(rows, name, dense_px) for name in ("gsd_m", "gsd")}


def _dense(rows: Sequence[Mapping[str, Any]], name: str, dense_px: int) -> float | None:
    sizes = [
        row[name] * max(1.0, max(row["width"], row["height"]) / dense_px)
        for row in rows
        if row[name] is not None
    ]
    return float(np.median(sizes)) if sizes else None


def _of_view(scene: SparseScene, number: int) -> dict[str, Any]:
    view = scene.views[number]
    mine = scene.track_views == number
    seen = scene.track_points[mine]
    if not len(seen):
        return {}
    points = scene.points[seen]
    misses = np.linalg.norm(view.project(points) - scene.track_pixels[mine], axis=1)
    depth = float(np.median(view.depths(points)))
    return {
        "tie_points": len(seen),
        "error_px": float(np.nanmedian(misses)),
        "gsd_m" if scene.scaled else "gsd": depth / float(np.mean(view.intrinsics.focal)),
    }


def gps_registration(report: GpsReport) -> dict[str, Any]:
    """What a registration by camera positions says, as plain values."""
    residuals = [
        {
            "name": name,
            "dx": float(miss[0]),
            "dy": float(miss[1]),
            "dz": float(miss[2]),
            "error_m": float(np.linalg.norm(miss)),
            "used": bool(used),
            "surveyed": at.tolist(),
        }
        for name, miss, used, at in zip(
            report.names, report.residuals_m, report.used, report.positions, strict=True
        )
    ]
    return {
        **_placement(report),
        "method": "camera positions (GPS)",
        "crs": report.crs,
        "heights": report.heights,
        "positions": len(report.names),
        "used": int(report.used.sum()),
        "rms_m": report.rms_m,
        "residuals": residuals,
    }


def control_registration(report: ControlReport) -> dict[str, Any]:
    """Return a registration by ground control as plain values."""
    return {
        **_placement(report),
        "method": "ground control points",
        "crs": report.crs or "local, in metres",
        "rms_control_m": report.control_rms_m,
        "rms_check_m": report.check_rms_m,
        "mark_scatter_px": report.mark_scatter_px,
        "points": [asdict(point) for point in report.points],
    }


def _placement(report: Placement) -> dict[str, Any]:
    about_east, about_north, about_up = report.rotation_error_deg
    # Those of bowing concern the finished model.
    bowing = report.bowing_findings
    return {
        "sigma_m": report.sigma_m,
        "sigma_height_m": report.sigma_height_m,
        "scale_error": report.scale_error,
        "adjusted_together_with_the_cameras": report.adjusted,
        "decisions": plain(report.decisions),
        "rotation_error_deg": {
            "about_up": about_up,
            "about_east": about_east,
            "about_north": about_north,
        },
        "lenses": [asdict(lens) | {"reason": lens.reason.to_dict()} for lens in report.lenses],
        "covariance": report.covariance.tolist(),
        "centre": list(report.centre),
        "bowing": _bowing(report.bowing),
        "lens_bowing": lens_bowing(report.lens_bend),
        "warnings": plain([each for each in report.warnings if each not in bowing]),
    }


def _bowing(bowing: Bowing | None) -> dict[str, Any] | None:
    """Return the bowing by the residuals as plain values, with its effect on dips."""
    if bowing is None:
        return None
    facts = asdict(bowing)
    # The normal of the model is reported separately.
    del facts["normal"]
    return {
        **facts,
        "edge_from_middle_deg": bowing.side_deg,
        "edge_from_middle_error95_deg": bowing.side_error95_deg,
        "edge_to_edge_deg": bowing.across_deg,
    }


def lens_bowing(found: LensBend | None) -> dict[str, Any] | None:
    """By the 95 % errors of the lenses, with degrees of dip."""
    if found is None:
        return None
    return {
        **asdict(found),
        "edge_from_middle95_deg": found.side_deg,
        "edge_to_edge95_deg": found.across_deg,
        "stretch95_deg": found.stretch_deg,
    }


def at_the_edge(
    registration: Mapping[str, Any],
    scene: SparseScene,
    mesh: Mesh,
    note: Callable[[Finding], object],
) -> dict[str, Any]:
    """What a registration says, with the bowing at the edge of the finished model: tie points, from
    which it was found, do not reach as far. note : called with each finding"""
    from vomstudio.geology.bowing import LensBend, model_shape
    from vomstudio.io.models.reconstruction_file import result_registration
    from vomstudio.project.registration_errors import bowing_of_registration
    from vomstudio.registration.warnings import bowing_findings, lens_findings

    _, axes, reach = model_shape(mesh.vertices)
    shape = {"reach_m" if scene.scaled else "reach": reach, "normal": axes[2].tolist()}
    facts: dict[str, Any] = {**registration, "shape": shape}
    bowing, bend = bowing_of_registration(result_registration({"registration": facts}, "")), None
    if lens := registration.get("lens_bowing"):
        bend = LensBend(lens["curvature95_per_m"], reach, lens["stretch95"])
    findings = [*bowing_findings(bowing), *lens_findings(bend, bowing)]
    facts |= {"bowing": _bowing(bowing), "lens_bowing": lens_bowing(bend)}
    for finding in findings:
        note(finding)
    return facts | {"warnings": [*registration.get("warnings", ()), *plain(findings)]}


def as_placed(
    cameras: Sequence[Calibration], scene: SparseScene, registration: Mapping[str, Any]
) -> list[Calibration]:
    """The cameras as the adjustment to the ground has left them, where there was one."""
    found = []
    for camera in cameras:
        photos = set(camera.photos)
        for view in scene.views:
            if view.name in photos and view.intrinsics.model == camera.model:
                camera = replace(camera, values=tuple(view.intrinsics.params))
                break
        for lens in registration.get("lenses", []):
            if photos & set(lens["photos"]):
                reason = Finding.from_dict(lens["reason"])
                camera = replace(camera, reasons=(*camera.reasons, reason))
                if lens["freed"]:
                    sigma = (lens["sigma_px"], *camera.sigma[1:])
                    camera = replace(camera, focal="freed", sigma=sigma)
        found.append(camera)
    return found


def calibration(cameras: Sequence[Calibration], photos: Sequence[Photo]) -> list[dict[str, Any]]:
    """Each camera's parameters with their errors, and what was held."""
    by_name = {photo.name: photo for photo in photos}
    rows = []
    for camera in cameras:
        first = by_name[camera.photos[0]]
        # What the ground freed has an error, but no correlations with what the photos freed.
        alone = np.isfinite(camera.sigma) & np.isnan(np.diag(camera.correlation))
        free = [i for i, value in enumerate(camera.sigma) if value != 0 and not alone[i]]
        rows.append(
            {
                "camera": first.camera,
                "model": camera.model,
                "width": first.width,
                "height": first.height,
                "photos": len(camera.photos),
                "names": list(camera.names),
                "params": list(camera.values),
                "sigma": [value if value == value else None for value in camera.sigma],
                "free": [camera.names[i] for i in free],
                "correlation": [[camera.correlation[i][j] for j in free] for i in free],
                "focal": camera.focal,
                "focal_exif_px": camera.exif_px,
                "rule": " ".join(reason.message for reason in camera.reasons),
                "reason_codes": [reason.code for reason in camera.reasons],
            }
        )
    return rows


def model(cloud: PointCloud, mesh: Mesh, texture: Mapping[str, Any]) -> dict[str, Any]:
    """Cloud, mesh and texture in numbers."""
    return {
        "points": len(cloud.points),
        "faces": len(mesh.faces),
        "texture_pages": ", ".join(f"{w} x {h}" for w, h in texture["pages"]),
        "texel": texture["texel_m"],
        "share_of_the_surface_that_no_photo_sees": texture["unseen_share"],
    }


def rotation95_deg(registration: Mapping[str, Any]) -> float:
    """95 % half-angle by which the registration can turn a plane's normal, about its worst axis;
    0 where the model was not registered, and directions on it mean nothing outside of it."""
    errors = registration.get("rotation_error_deg")
    if not errors:
        return 0.0
    # The tilt of a normal has two components, each with at most this standard error.
    return min(90.0, math.sqrt(-2.0 * math.log(0.05)) * max(map(float, errors.values())))


def planes_of_model(
    cloud: PointCloud, mesh: Mesh, registration: Mapping[str, Any]
) -> PlaneSizes | None:
    """How well planes are known on the finished model: its resolution is the largest of its
    points' spacing, their noise, and the edges of its mesh."""
    from vomstudio.io.models.opening import resolution

    known = [value for value in (resolution(cloud), resolution(mesh)) if math.isfinite(value)]
    if not known:
        return None
    return PlaneSizes.of_model(max(known), registration_deg=rotation95_deg(registration))


def sizes(scene: SparseScene, texture: Mapping[str, Any]) -> dict[str, Any]:
    """Sizes on the rock, medians, in the unit of the model, and the share that no photo sees."""
    return {
        "unit": "m" if scene.scaled else "unknown",
        "unseen_share": float(texture["unseen_share"]),
        "texel": float(texture["texel_m"]),
        "photo_pixel": float(np.nanmedian(photo_pixel_sizes(scene))),
    }


def drawing(scene: SparseScene) -> dict[str, Any]:
    """Some tie points, the cameras and their directions, less the origin."""
    step = max(1, len(scene.points) // _DRAWN)
    return {
        "points": np.round(scene.points[::step], 3).tolist(),
        "at": np.round(scene.centres, 3).tolist(),
        "looks": [np.round(view.direction, 4).tolist() for view in scene.views],
    }


def versions(*packages: str) -> dict[str, str]:
    """Of this program and of what its results rest on."""
    import importlib

    found = {"vomstudio": __version__}
    for name in packages:
        found[name] = str(importlib.import_module(name).__version__)
    return found
