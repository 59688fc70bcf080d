"""The largest part of an alignment in World where control or GPS allow it, else upright."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vomstudio.errors import GeometryError
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.base.settings import Settings
from vomstudio.photogrammetry.pipeline import report_data
from vomstudio.photogrammetry.place import control, georeference
from vomstudio.photogrammetry.place.lens_errors import bend_of_lenses
from vomstudio.photogrammetry.place.local_frame import upright
from vomstudio.progress import Progress

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo
    from vomstudio.photogrammetry.align.alignment import Alignment


def place_scene(
    alignment: Alignment, photos: Sequence[Photo], settings: Settings, progress: Progress
) -> tuple[SparseScene, dict[str, Any]]:
    """The scene and what its registration says, as plain values. Raises GeometryError where control
    or a CRS that were asked for cannot place it; InputError, UsageError, Cancelled."""
    part, threads = alignment.parts[0], settings.threads or -1
    cameras = alignment.cameras
    try:
        if settings.control is not None:
            scene, fitted = control.place_by_control_files(
                part,
                settings.control,
                settings.marks,
                settings.crs,
                progress,
                cameras=cameras,
                threads=threads,
            )
            return scene, report_data.control_registration(fitted)
        scene, report = georeference.place_by_gps(
            part, photos, settings.crs, cameras=cameras, threads=threads, progress=progress
        )
        return scene, report_data.gps_registration(report)
    except GeometryError as error:
        if settings.control is not None or settings.crs is not None:
            raise
        scene = upright(part, photos)
        bend = report_data.lens_bowing(bend_of_lenses(scene, cameras))
        return scene, {"refused": error.message, "lens_bowing": bend}
