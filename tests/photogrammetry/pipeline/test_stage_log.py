"""The log of a reconstruction keeps the codes of what its photos and stages report."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.pipeline.stage_log import StageLog


def test_findings_keep_their_code_and_are_logged_once_as_sentences(tmp_path: Path) -> None:
    log = StageLog(tmp_path / "log.txt", SilentProgress())
    finding = Finding("photo.altitude-sign", photos=2, photo="a.jpg", exif_m=-5.0, xmp_m=5.0)
    for message in (finding, "a sentence", finding):
        log.note(message)
    assert log.notes == [finding, "a sentence"]
    lines = (tmp_path / "log.txt").read_text("utf-8").splitlines()
    assert [line.split("  ", 1)[1] for line in lines] == [finding.message, "a sentence"]
