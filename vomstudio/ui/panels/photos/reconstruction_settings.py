"""Reconstruction settings in the window."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.files.regular import is_regular, read_json
from vomstudio.io.control.control_files import find_control

if TYPE_CHECKING:
    from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest


@dataclass(frozen=True)
class ReconstructionSettings:
    """Settings of a reconstruction.

    Attributes
    ----------
    control, marks : Path or None
        Files of ground control. Without `control`, the GPS positions of the cameras or a local
        frame are used. Without `marks`, the marks are read from the control file or from
        `marks.csv` beside it.
    has_sidecar_control : bool
        Whether the control files were found beside the photos rather than selected by the user.
    crs : str or None
        "EPSG:n", or None for the CRS of the control points or the GPS.
    threads : int or None
        Number of threads, or None for one per processor.
    scheduler : str or None
        Address of a Dask cluster, or None if no cluster is used.
    """

    quality: str = "medium"
    control: Path | None = None
    marks: Path | None = None
    has_sidecar_control: bool = False
    crs: str | None = None
    threads: int | None = None
    seed: int = 0
    scheduler: str | None = None

    def adapt_to_photos(self, folder: Path) -> ReconstructionSettings:
        """Return a copy with the ground control found beside these photos, and without CRS."""
        control, marks = find_control(folder) or (None, None)
        return replace(
            self, control=control, marks=marks, has_sidecar_control=control is not None, crs=None
        )

    def drop_control(self) -> ReconstructionSettings:
        """Return a copy without ground control."""
        return replace(self, control=None, marks=None, has_sidecar_control=False)

    def build_request(self, photos: Path, out: Path) -> ReconstructionRequest:
        """Return the request for a worker."""
        from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest

        values = {item.name: getattr(self, item.name) for item in fields(self)}
        del values["has_sidecar_control"]
        return ReconstructionRequest(photos=photos, out=out, **values)


def read_request(request: Path) -> tuple[Path, ReconstructionSettings] | None:
    """Return the photo folder and settings of a stored request, or None if unreadable."""
    from vomstudio.photogrammetry.base.settings import QUALITIES

    try:
        values = read_json(request)
        quality, threads, seed = values["quality"], values.get("threads"), values.get("seed", 0)
        files = [values.get(name) and Path(values[name]) for name in ("control", "marks")]
        if quality not in QUALITIES or not all(isinstance(n, int | None) for n in (threads, seed)):
            return None
        control, marks = files if files[0] and is_regular(files[0]) else (None, None)
        settings = ReconstructionSettings(
            quality=quality,
            control=control or None,
            marks=marks or None,
            has_sidecar_control=False,
            crs=values.get("crs"),
            threads=threads,
            seed=seed or 0,
        )
        return Path(values["photos"]), settings
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
