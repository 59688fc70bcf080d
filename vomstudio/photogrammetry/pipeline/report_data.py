"""Data of the reconstruction report: photos, registration, calibration and a drawing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.core.arrays import GenericArray
from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.version import __version__
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.photogrammetry.align.scene_check import photo_pixel_sizes
from vomstudio.photogrammetry.base.background import RockExtent
from vomstudio.photogrammetry.base.scene import SparseScene

if TYPE_CHECKING:
    from vomstudio.geology.bowing import Bowing, LensDeformation
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.photos.photo import Photo
    from vomstudio.photogrammetry.align.priors import Calibration
    from vomstudio.photogrammetry.georeferencing.control import ControlReport
    from vomstudio.photogrammetry.georeferencing.georeference import GpsReport
    from vomstudio.photogrammetry.georeferencing.placement import Placement
    from vomstudio.photogrammetry.georeferencing.pose_errors import PoseErrors

_MAX_DRAWN_POINTS = 4000


def tie_points(scene: SparseScene, rock: RockExtent | None = None) -> PointCloud:
    """Return the tie points in the World frame, with mean errors and numbers of photos.

    If some are behind the rock, the field `background` is 1 for these.
    """
    fields: dict[str, GenericArray] = {
        "error_px": scene.errors_px.astype(np.float32),
        "views": scene.track_lengths.astype(np.uint16),
    }
    if rock is not None and rock.has_background:
        fields["background"] = (~rock.is_rock).astype(np.uint8)
    return PointCloud(scene.points + scene.origin, scene.colors, fields=fields)


def photo_rows(
    photos: Sequence[Photo],
    scene: SparseScene,
    registration: Mapping[str, Any],
    rock: RockExtent | None = None,
) -> list[dict[str, Any]]:
    """Return the report figures of each photo.

    These are the number of tie points, their median reprojection error, the ground sampling
    distance on the rock (`gsd_m`, or `gsd` in the unit of a scene without scale), and the residual
    of the GPS position.
    """
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
            row |= _view_figures(scene, numbers[photo.name], rock)
        rows.append(row)
    return rows


def add_pose_errors(
    rows: Sequence[dict[str, Any]], scene: SparseScene, errors: PoseErrors | None
) -> None:
    """Add the 95 % errors of position and rotation to the rows of the photos, in place.

    These are `position_error95_m` or, without scale, `position_error95` in the unit of the scene,
    and `rotation_error95_deg`. `is_weak` marks weakly connected photos.

    Parameters
    ----------
    rows : sequence of dict
        Rows of `photo_rows`.
    scene : SparseScene
    errors : PoseErrors or None
    """
    pose_errors = {} if errors is None else errors.errors_by_name(scene)
    weak_names = frozenset() if errors is None else errors.weak_names(scene)
    for row in rows:
        position, rotation_deg = pose_errors.get(row["name"], (None, None))
        row["position_error95_m"] = position if scene.scaled else None
        row["position_error95"] = None if scene.scaled else position
        row["rotation_error95_deg"] = rotation_deg
        row["is_weak"] = row["name"] in weak_names


def dense_gsd(rows: Sequence[Mapping[str, Any]], dense_px: int) -> dict[str, float | None]:
    """Return the median pixel size of depth maps on the rock.

    It is `dense_gsd_m`, in metres, or `dense_gsd`, in the unit of a scene without scale; the other
    value is None.

    dense_px : long side of the depth maps
    """
    return {f"dense_{name}": _dense_resolution(rows, name, dense_px) for name in ("gsd_m", "gsd")}


def _dense_resolution(rows: Sequence[Mapping[str, Any]], name: str, dense_px: int) -> float | None:
    sizes = [
        row[name] * max(1.0, max(row["width"], row["height"]) / dense_px)
        for row in rows
        if row[name] is not None
    ]
    return float(np.median(sizes)) if sizes else None


def _view_figures(scene: SparseScene, number: int, rock: RockExtent | None) -> dict[str, Any]:
    view = scene.views[number]
    is_in_view = scene.track_views == number
    point_rows = scene.track_points[is_in_view]
    if not len(point_rows):
        return {}
    points = scene.points[point_rows]
    misses = np.linalg.norm(view.project(points) - scene.track_pixels[is_in_view], axis=1)
    depths = view.depths(points)
    if rock is not None and rock.is_rock[point_rows].any():
        depths = depths[rock.is_rock[point_rows]]
    depth = float(np.median(depths))
    return {
        "tie_points": len(point_rows),
        "error_px": float(np.nanmedian(misses)),
        "gsd_m" if scene.scaled else "gsd": depth / float(np.mean(view.intrinsics.focal)),
    }


def gps_registration(report: GpsReport) -> dict[str, Any]:
    """Return a registration by camera positions as plain values."""
    residuals = [
        {
            "name": name,
            "dx": float(misclosure[0]),
            "dy": float(misclosure[1]),
            "dz": float(misclosure[2]),
            "error_m": float(np.linalg.norm(misclosure)),
            "used": bool(is_used),
            "surveyed": position.tolist(),
        }
        for name, misclosure, is_used, position in zip(
            report.names, report.residuals_m, report.used, report.positions, strict=True
        )
    ]
    return {
        **_placement_values(report),
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
        **_placement_values(report),
        "method": "ground control points",
        "crs": report.crs or "local, in metres",
        "rms_control_m": report.control_rms_m,
        "rms_check_m": report.check_rms_m,
        "mark_scatter_px": report.mark_scatter_px,
        "points": [asdict(point) for point in report.points],
    }


def _placement_values(report: Placement) -> dict[str, Any]:
    east_deg, north_deg, up_deg = report.rotation_error_deg
    # The findings about bowing refer to the finished model.
    bowing = report.bowing_findings
    return {
        "sigma_m": report.sigma_m,
        "sigma_height_m": report.sigma_height_m,
        "scale_error": report.scale_error,
        "adjusted_together_with_the_cameras": report.adjusted,
        "decisions": to_json_list(report.decisions),
        "rotation_error_deg": {
            "about_up": up_deg,
            "about_east": east_deg,
            "about_north": north_deg,
        },
        "lenses": [asdict(lens) | {"reason": lens.reason.to_dict()} for lens in report.lenses],
        "covariance": report.covariance.tolist(),
        "centre": list(report.centre),
        "bowing": _bowing(report.bowing),
        "lens_bowing": lens_bowing(report.lens_bend),
        "warnings": to_json_list([item for item in report.warnings if item not in bowing]),
    }


def _bowing(bowing: Bowing | None) -> dict[str, Any] | None:
    """Return the bowing estimated from residuals as plain values, with its effect on dips.

    Returns None if `bowing` is None.
    """
    if bowing is None:
        return None
    figures = asdict(bowing)
    # The normal of the model is reported separately.
    del figures["normal"]
    return {
        **figures,
        "edge_from_middle_deg": bowing.side_deg,
        "edge_from_middle_error95_deg": bowing.side_error95_deg,
        "edge_to_edge_deg": bowing.across_deg,
    }


def lens_bowing(bend: LensDeformation | None) -> dict[str, Any] | None:
    """Return the bowing due to the 95 % lens errors, with its effect on dips in degrees.

    Returns None if `bend` is None.
    """
    if bend is None:
        return None
    return {
        **asdict(bend),
        "edge_from_middle95_deg": bend.side_deg,
        "edge_to_edge95_deg": bend.across_deg,
        "stretch95_deg": bend.stretch_deg,
    }


def add_edge_bowing(
    registration: Mapping[str, Any],
    scene: SparseScene,
    mesh: Mesh,
    add_finding: Callable[[Finding], object],
) -> dict[str, Any]:
    """Return a registration with the bowing at the edge of the finished model.

    The tie points from which it was estimated do not extend to the edge.

    add_finding : called with each finding
    """
    from vomstudio.geology.bowing import LensDeformation, model_shape
    from vomstudio.io.models.reconstruction_file import result_registration
    from vomstudio.project.registration_errors import registration_bowing
    from vomstudio.registration.warnings import bowing_findings, lens_findings

    _, axes, extent = model_shape(mesh.vertices)
    shape = {"reach_m" if scene.scaled else "reach": extent, "normal": axes[2].tolist()}
    figures: dict[str, Any] = {**registration, "shape": shape}
    bowing, lens_bend = (
        registration_bowing(result_registration({"registration": figures}, "")),
        None,
    )
    if lens := registration.get("lens_bowing"):
        lens_bend = LensDeformation(lens["curvature95_per_m"], extent, lens["stretch95"])
    findings = [*bowing_findings(bowing), *lens_findings(lens_bend, bowing)]
    figures |= {"bowing": _bowing(bowing), "lens_bowing": lens_bowing(lens_bend)}
    for finding in findings:
        add_finding(finding)
    return figures | {"warnings": [*registration.get("warnings", ()), *to_json_list(findings)]}


def cameras_after_placement(
    cameras: Sequence[Calibration], scene: SparseScene, registration: Mapping[str, Any]
) -> list[Calibration]:
    """Return the cameras after the adjustment to ground control, if there was one."""
    adjusted_cameras = []
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
        adjusted_cameras.append(camera)
    return adjusted_cameras


def calibration(cameras: Sequence[Calibration], photos: Sequence[Photo]) -> list[dict[str, Any]]:
    """Return the free parameters of each camera with their errors, and the fixed parameters."""
    photo_by_name = {photo.name: photo for photo in photos}
    rows = []
    for camera in cameras:
        first_photo = photo_by_name[camera.photos[0]]
        # Parameters freed by ground control have an error, but no correlations with others.
        is_uncorrelated = np.isfinite(camera.sigma) & np.isnan(np.diag(camera.correlation))
        free_indices = [
            i for i, value in enumerate(camera.sigma) if value != 0 and not is_uncorrelated[i]
        ]
        rows.append(
            {
                "camera": first_photo.camera,
                "model": camera.model,
                "width": first_photo.width,
                "height": first_photo.height,
                "photos": len(camera.photos),
                "names": list(camera.names),
                "params": list(camera.values),
                "sigma": [value if value == value else None for value in camera.sigma],
                "free": [camera.names[i] for i in free_indices],
                "correlation": [
                    [camera.correlation[i][j] for j in free_indices] for i in free_indices
                ],
                "focal": camera.focal,
                "focal_exif_px": camera.exif_px,
                "rule": " ".join(reason.message for reason in camera.reasons),
                "reason_codes": [reason.code for reason in camera.reasons],
            }
        )
    return rows


def model(cloud: PointCloud, mesh: Mesh, texture: Mapping[str, Any]) -> dict[str, Any]:
    """Return the figures of cloud, mesh and texture."""
    return {
        "points": len(cloud.points),
        "faces": len(mesh.faces),
        "texture_pages": ", ".join(f"{w} x {h}" for w, h in texture["pages"]),
        "texel": texture["texel_m"],
        "texel_ratio": texture["texel_ratio"],
        "share_of_the_surface_that_no_photo_sees": texture["unseen_share"],
    }


def rotation95_deg(registration: Mapping[str, Any]) -> float:
    """Return the 95 % rotation error of the registration about its weakest axis, in degrees.

    It is 0 for a model without registration, whose directions are arbitrary.
    """
    errors = registration.get("rotation_error_deg")
    if not errors:
        return 0.0
    # The tilt of a normal has two components, each with at most this standard error.
    return min(90.0, math.sqrt(-2.0 * math.log(0.05)) * max(map(float, errors.values())))


def model_plane_sizes(
    cloud: PointCloud, mesh: Mesh, registration: Mapping[str, Any]
) -> PlaneSizes | None:
    """Return the expected accuracy of planes on the finished model.

    The resolution is the largest of the point spacing, the noise, and the edge length of the mesh.
    Returns None if it is unknown.
    """
    from vomstudio.io.models.opening import resolution

    resolutions = [value for value in (resolution(cloud), resolution(mesh)) if math.isfinite(value)]
    if not resolutions:
        return None
    return PlaneSizes.from_resolution(
        max(resolutions), registration_deg=rotation95_deg(registration)
    )


def sizes(scene: SparseScene, texture: Mapping[str, Any]) -> dict[str, Any]:
    """Return median sizes on the rock in the model's unit, and the share that no photo shows."""
    return {
        "unit": "m" if scene.scaled else "unknown",
        "unseen_share": float(texture["unseen_share"]),
        "texel": float(texture["texel_m"]),
        "texel_ratio": float(texture["texel_ratio"]),
        "photo_pixel": float(np.nanmedian(photo_pixel_sizes(scene))),
    }


def drawing(scene: SparseScene, rock: RockExtent) -> dict[str, Any]:
    """Return some tie points and the cameras relative to the origin, and view directions."""
    step = max(1, len(scene.points) // _MAX_DRAWN_POINTS)
    is_rock = rock.is_rock[::step]
    return {
        "points": np.round(scene.points[::step][is_rock], 3).tolist(),
        "background": np.round(scene.points[::step][~is_rock], 3).tolist(),
        "at": np.round(scene.centres, 3).tolist(),
        "looks": [np.round(view.direction, 4).tolist() for view in scene.views],
    }


def versions(*packages: str) -> dict[str, str]:
    """Return the versions of this program and of packages that affect results."""
    import importlib

    numbers = {"vomstudio": __version__}
    for name in packages:
        numbers[name] = str(importlib.import_module(name).__version__)
    return numbers
