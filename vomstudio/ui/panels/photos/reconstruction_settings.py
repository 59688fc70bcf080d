"""Settings of a reconstruction, as the window asks for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.files.regular import is_regular, read_json
from vomstudio.core.words import to_translate
from vomstudio.io.control.control_files import find_control

if TYPE_CHECKING:
    from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest

QUALITIES = (
    (to_translate("Preview"), "preview", to_translate("takes minutes, to test the photos")),
    (to_translate("Low"), "low", to_translate("depth maps of 1000 pixels")),
    (to_translate("Medium"), "medium", to_translate("depth maps of 1600 pixels")),
    (to_translate("High"), "high", to_translate("depth maps of 3200 pixels, takes hours")),
)
"""Title, name and what it means; the first and last are to be translated where they are shown.
Depth maps are measured along their long side."""


@dataclass(frozen=True)
class ReconstructionSettings:
    """control, marks : of ground control; None for the cameras' GPS, or a local frame; marks alone
        None where they are in the file of the control, or in `marks.csv` beside it
    found : these files were not named, they lay beside the photos
    crs : "EPSG:n"; None for what the control or the GPS says
    threads : None for all processors; scheduler : address of a Dask cluster
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
        """The same with the ground control that lies beside these photos, and no CRS."""
        control, marks = find_control(folder) or (None, None)
        return replace(
            self, control=control, marks=marks, has_sidecar_control=control is not None, crs=None
        )

    def drop_control(self) -> ReconstructionSettings:
        """The same without ground control."""
        return replace(self, control=None, marks=None, has_sidecar_control=False)

    def build_request(self, photos: Path, out: Path) -> ReconstructionRequest:
        """The order for a worker: photos, folder of the results, and these settings."""
        from vomstudio.studio.jobs.reconstruction_tasks import ReconstructionRequest

        return ReconstructionRequest(
            photos,
            out,
            self.quality,
            self.crs,
            self.control,
            self.marks,
            self.threads,
            self.seed,
            self.scheduler,
        )


def read_request(request: Path) -> tuple[Path, ReconstructionSettings] | None:
    """Photos and settings that a reconstruction noted down; None where they cannot be read."""
    from vomstudio.photogrammetry.base.settings import QUALITIES

    try:
        values = read_json(request)
        quality, threads, seed = values["quality"], values.get("threads"), values.get("seed", 0)
        files = [values.get(name) and Path(values[name]) for name in ("control", "marks")]
        if quality not in QUALITIES or not all(isinstance(n, int | None) for n in (threads, seed)):
            return None
        control, marks = files if files[0] and is_regular(files[0]) else (None, None)
        settings = ReconstructionSettings(
            quality, control or None, marks or None, False, values.get("crs"), threads, seed or 0
        )
        return Path(values["photos"]), settings
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
