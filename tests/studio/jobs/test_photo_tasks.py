"""A check of photos is made once, and again when the photos or their masks are others."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs.photo_tasks import CHECK_PHOTOS, PhotosRequest

PHOTOS = Path(__file__).parents[2] / "specimens" / "photos"


def test_photo_check_is_repeated_only_if_the_photos_change(tmp_path: Path) -> None:
    folder, cache = tmp_path / "photos", tmp_path / "cache"
    folder.mkdir()
    for path in sorted(PHOTOS.glob("*.jpg"))[:2]:
        shutil.copy(path, folder)

    def check() -> SurveyReport:
        return CHECK_PHOTOS.function(PhotosRequest(folder, cache), SilentProgress())

    first = check()
    (stored,) = (cache / "checks").iterdir()
    assert check() == first
    # What is stored is what is shown: it is not made again.
    content = json.loads(stored.read_text())
    content["photos"][0]["blur"] = 77.0
    stored.write_text(json.dumps(content))
    assert check().photos[0].blur == 77.0
    stored.write_text("damaged")
    assert check() == first
    shutil.copy(sorted(PHOTOS.glob("*.jpg"))[2], folder)
    assert len(check().photos) == 3
    assert len(list((cache / "checks").iterdir())) == 2
