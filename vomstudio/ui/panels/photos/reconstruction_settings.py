"""Reconstruction settings in the window."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.errors import UsageError
from vomstudio.core.files.regular import is_regular_file, read_json
from vomstudio.io.control.control_files import find_control
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions

if TYPE_CHECKING:
    from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest


@dataclass(frozen=True)
class ReconstructionSettings:
    """Settings of a reconstruction.

    Attributes
    ----------
    options : ReconstructOptions
        Options of the operation. Without control points, the GPS positions of the cameras or a
        local frame are used.
    has_sidecar_control : bool
        Whether the control files were found beside the photos rather than selected by the user.
    """

    options: ReconstructOptions = field(default_factory=ReconstructOptions)
    has_sidecar_control: bool = False

    @property
    def control(self) -> Path | None:
        """File of the control points, or None if no control points are used."""
        return None if self.options.gcp is None else Path(self.options.gcp)

    @property
    def marks(self) -> Path | None:
        """File of the marks, or None for those in or beside the control file."""
        return None if self.options.marks is None else Path(self.options.marks)

    def replace_control(
        self, control: Path | None, marks: Path | None, *, is_sidecar: bool
    ) -> ReconstructionSettings:
        """Return a copy with these control files.

        Parameters
        ----------
        control, marks : Path or None
            Without `control`, the copy has no ground control.
        is_sidecar : bool
            Whether the files were found beside the photos.

        Returns
        -------
        ReconstructionSettings
        """
        options = replace(
            self.options,
            gcp=None if control is None else str(control),
            marks=None if control is None or marks is None else str(marks),
        )
        return ReconstructionSettings(options, is_sidecar and control is not None)

    def adapt_to_photos(self, folder: Path) -> ReconstructionSettings:
        """Return a copy with the ground control found beside these photos.

        The copy has no CRS and no region, because both belong to the previous photos.
        """
        settings = replace(self, options=replace(self.options, crs=None, region=None))
        control, marks = find_control(folder) or (None, None)
        return settings.replace_control(control, marks, is_sidecar=True)

    def drop_control(self) -> ReconstructionSettings:
        """Return a copy without ground control."""
        return self.replace_control(None, None, is_sidecar=False)

    def build_request(self, photos: Path, out: Path) -> ReconstructionRequest:
        """Return the request for a worker."""
        from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest

        return ReconstructionRequest.of(photos, out, self.options, self.control, self.marks)


def read_request(request: Path) -> tuple[Path, ReconstructionSettings] | None:
    """Return the photo folder and settings of a stored request, or None if unreadable."""
    try:
        values = read_json(request)
        region = values.get("region")
        options = ReconstructOptions(
            quality=values["quality"],
            crs=values.get("crs"),
            threads=values.get("threads"),
            seed=values.get("seed") or 0,
            device=values.get("device", "auto"),
            region=region and ",".join(f"{coordinate:.12g}" for coordinate in region),
            keep_background=values.get("keep_background") is True,
        )
        control, marks = (values.get(name) and Path(values[name]) for name in ("control", "marks"))
        settings = ReconstructionSettings(options).replace_control(
            control if control and is_regular_file(control) else None,
            marks or None,
            is_sidecar=False,
        )
        return Path(values["photos"]), settings
    except (OSError, ValueError, KeyError, TypeError, AttributeError, UsageError):
        return None
