"""The check of a folder of photos: what `vomstudio check` prints."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding, Message
from vomstudio.geometry.plane_sizes import PlaneError
from vomstudio.io.photos.reading import PhotoFolder, read_photos
from vomstudio.progress import Progress
from vomstudio.reprs import Shown
from vomstudio.survey.check import check_photos
from vomstudio.survey.check_results import PhotoFigures, SurveyReport


@dataclass(frozen=True, repr=False)
class FolderCheck(Shown):
    """What the photos of a folder are worth.

    folder : as it was given; report : before the alignment; aligned : after it, where an alignment
    was given; skipped : name of unused pictures and the finding why; warnings : findings
    """

    folder: str
    report: SurveyReport
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Message, ...]
    aligned: SurveyReport | None = None

    @property
    def photos(self) -> tuple[PhotoFigures, ...]:
        """Of each photo: pixel on the rock, blur, views, overlap."""
        return self.report.photos

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was found, the gravest first."""
        return self.report.findings

    @property
    def stage(self) -> str:
        """ "before" the alignment."""
        return self.report.stage

    @property
    def plane_error(self) -> tuple[PlaneError, ...]:
        """Expected 95 % error of planes against their size; empty where no pixel size is known."""
        return self.report.plane_error

    @property
    def verdict(self) -> str:
        """One or two sentences."""
        return self.report.verdict

    @property
    def gsd_m(self) -> float | None:
        """Metres per pixel on the rock, the median; None where the distance is not known."""
        return self.report.gsd_m

    @property
    def smallest_plane_m(self) -> float | None:
        """The smallest plane worth measuring, m."""
        return self.report.smallest_plane_m

    @property
    def next_time(self) -> tuple[str, ...]:
        """What to do differently, the gravest first."""
        return self.report.next_time

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        result: dict[str, Any] = {
            "folder": self.folder,
            **self.report.as_dict(),
            "skipped": [
                {"name": name, "reason": reason.message, "reason_code": reason.code}
                for name, reason in self.skipped
            ],
            "warnings": list(self.warnings),
        }
        if self.aligned is not None:
            result["aligned"] = self.aligned.as_dict()
        return result


def check_folder(
    folder: str | Path, distance_m: float | None = None, progress: Progress | None = None
) -> tuple[FolderCheck, PhotoFolder]:
    """The check, and the photos that were looked at. distance_m : from camera to rock, where it is
    known. Raises InputError, UsageError."""
    found = read_photos(folder, progress)
    report = check_photos(found, distance_m=distance_m, progress=progress)
    checked = FolderCheck(str(Path(folder)), report, tuple(found.skipped), tuple(found.warnings))
    return checked, found
