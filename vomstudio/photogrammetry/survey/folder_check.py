"""Check of a folder of photos, as printed by `vomstudio check`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import OPTIONAL_IN_JSON
from vomstudio.io.photos.reading import PhotoFolder, read_photos
from vomstudio.photogrammetry.survey.check import check_photos
from vomstudio.photogrammetry.survey.check_results import SurveyReport


@dataclass(frozen=True, kw_only=True, repr=False)
class FolderCheck(PrintableResult, SurveyReport):
    """Check of the photos of a folder before the alignment.

    Parameters
    ----------
    folder : str
        Folder as given by the user.
    skipped : tuple of (str, Finding)
        Names of unused pictures, and the reasons.
    warnings : tuple of Finding
    aligned : SurveyReport or None
        Check of the model made from the photos, if one was given.
    """

    folder: str
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Finding, ...]
    aligned: SurveyReport | None = field(default=None, metadata=OPTIONAL_IN_JSON)

    def to_dict(self) -> dict[str, Any]:
        """Return the object that ``--json`` prints, with the reasons as texts."""
        skipped_files = [
            {"name": name, "reason": reason.message, "reason_code": reason.code}
            for name, reason in self.skipped
        ]
        return super().to_dict() | {"skipped": skipped_files}


def check_folder(
    folder: str | Path, distance_m: float | None = None, progress: Progress | None = None
) -> tuple[FolderCheck, PhotoFolder]:
    """Check a folder, and return the check with the photos.

    Raises InputError if the folder cannot be used.

    distance_m : distance from the camera to the rock, if known
    """
    photo_folder = read_photos(folder, progress)
    report = check_photos(photo_folder, distance_m=distance_m, progress=progress)
    folder_check = FolderCheck(
        **vars(report),
        folder=str(Path(folder)),
        skipped=tuple(photo_folder.skipped),
        warnings=tuple(photo_folder.warnings),
    )
    return folder_check, photo_folder
