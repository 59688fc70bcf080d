"""Registration of the largest part of an alignment, and findings about it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.progress import Progress
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.georeferencing import control, georeference
from vomstudio.photogrammetry.georeferencing.lens_errors import compute_lens_bend
from vomstudio.photogrammetry.georeferencing.local_frame import rotate_upright
from vomstudio.photogrammetry.pipeline import report_data
from vomstudio.registration.marks.mark_errors import mark_scatter_findings

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo
    from vomstudio.photogrammetry.align.alignment import Alignment
    from vomstudio.photogrammetry.pipeline.photo_input import ControlTables


def place_scene(
    alignment: Alignment,
    photos: Sequence[Photo],
    settings: PipelineSettings,
    tables: ControlTables,
    progress: Progress,
) -> tuple[SparseScene, dict[str, Any]]:
    """Register the largest part by control points if given, otherwise by camera GPS.

    A part that cannot be registered gets a local frame, and its registration contains the reason as
    `refused`. An error at this stage would discard the long computation of the alignment.

    Returns
    -------
    tuple
        The scene, and its registration as plain values.

    Raises
    ------
    Cancelled
    """
    part, threads = alignment.parts[0], settings.threads or -1
    cameras = alignment.cameras
    try:
        if settings.control is not None:
            scene, control_report = control.place_by_control(
                part,
                tables.points,
                tables.marks,
                tables.crs,
                cameras=cameras,
                threads=threads,
                progress=progress,
            )
            return scene, report_data.control_registration(control_report)
        scene, report = georeference.place_by_gps(
            part, photos, settings.crs, cameras=cameras, threads=threads, progress=progress
        )
        return scene, report_data.gps_registration(report)
    except GeometryError as error:
        scene = rotate_upright(part, photos)
        bend = report_data.lens_bowing(compute_lens_bend(scene, cameras))
        return scene, {"refused": to_finding(error).to_dict(), "lens_bowing": bend}


def registration_findings(
    settings: PipelineSettings, registration: Mapping[str, Any]
) -> Iterator[Finding]:
    """Yield findings about scattered marks, and about control or a CRS that was not used."""
    if refusal := registration.get("refused"):
        reason = {
            "value": None,
            "reason": refusal["message"],
            "reason_code": refusal["code"],
        }
        if settings.control is not None:
            yield Finding("control-unused", photos=(), **reason)
        elif settings.crs is not None:
            yield Finding("gps-unused", photos=(), **reason)
    if (scatter_px := registration.get("mark_scatter_px")) is not None:
        yield from mark_scatter_findings(scatter_px)
