"""Frames of videos that are panned over a known picture."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.messages import refused, with_code
from tests.photogrammetry.surface.wall_maker import texture
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, TargetError, UsageError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.photogrammetry.survey.survey_options import VideoFrameOptions
from vomstudio.photogrammetry.survey.video import UNCHANGED, take_frames

FPS = 20


def film(path: Path, offsets, blurs=None, size=(1000, 560)) -> Path:
    """A camera that moves along the wall; its place in pixels and its blur for every frame."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), FPS, size)
    assert writer.isOpened()
    for i, x in enumerate(offsets):
        frame = cv2.getRectSubPix(texture(), size, (float(x) + size[0] / 2, 400.0))
        if blurs is not None and blurs[i]:
            frame = cv2.GaussianBlur(frame, (0, 0), blurs[i])
        writer.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


@pytest.mark.full
def test_smooth_pan_gives_frames_at_the_requested_rate(tmp_path: Path) -> None:
    video = film(tmp_path / "pan.avi", np.arange(100) * 12.0)
    report = take_frames(video, tmp_path / "out", fps=2)
    assert len(report.frames) == 10
    assert report.skipped == {}
    assert report.good_enough
    assert (report.width, report.height, report.video_fps) == (1000, 560, FPS)
    files = sorted(p.name for p in (tmp_path / "out").glob("*.jpg"))
    assert files == [frame.name for frame in report.frames]
    gaps = np.diff([frame.seconds for frame in report.frames])
    assert gaps.mean() == pytest.approx(0.5, abs=0.05)
    assert len(json.loads((tmp_path / "out" / "frames.json").read_text())["frames"]) == 10


def test_sharpest_frame_of_each_interval_is_selected(tmp_path: Path) -> None:
    blurs = [3.0] * 60
    for sharp in (4, 24, 48):
        blurs[sharp] = 0
    # One frame in four is looked at.
    video = film(tmp_path / "a.avi", np.arange(60) * 12.0, blurs)
    report = take_frames(video, tmp_path / "out", fps=1)
    assert [frame.number for frame in report.frames] == [4, 24, 48]


@pytest.mark.full
def test_static_and_blurred_frames_are_skipped_with_their_reason(tmp_path: Path) -> None:
    offsets = [*np.arange(60) * 12.0, *[720.0] * 40, *(720 + np.arange(60) * 12.0)]
    blurs = [0.0] * 120 + [6.0] * 40
    report = take_frames(film(tmp_path / "a.avi", offsets, blurs), tmp_path / "out", fps=2)
    assert report.skipped[UNCHANGED] in (3, 4)
    assert report.skipped["blurred"] == 4
    assert len(report.frames) in (8, 9)


@pytest.mark.full
def test_unusable_video_is_reported_with_the_reason(tmp_path: Path) -> None:
    blurs = [0.0] * 40 + [7.0] * 100
    report = take_frames(
        film(tmp_path / "a.avi", np.arange(140) * 10.0, blurs), tmp_path / "out", fps=2
    )
    assert not report.good_enough
    (finding,) = with_code(report.reasons, "video.blurred")
    assert finding.severity == "error"


@pytest.mark.full
def test_invalid_video_is_rejected_and_leaves_no_files(tmp_path: Path) -> None:
    for name, content, code in (
        ("a.mp4", b"", "file.empty"),
        ("b.mp4", b"not a video" * 99, "video.not-a-video"),
    ):
        (tmp_path / name).write_bytes(content)
        with refused(code, file=tmp_path / name):
            take_frames(tmp_path / name, tmp_path / "out")
    with refused("file.missing", file=tmp_path / "c.mp4"):
        take_frames(tmp_path / "c.mp4", tmp_path / "out")
    with refused("file.is-folder", file=tmp_path):
        take_frames(tmp_path, tmp_path / "out")
    video = film(tmp_path / "grey.avi", np.arange(20), [40.0] * 20)
    with refused("video.no-frames"):
        take_frames(video, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert not list(tmp_path.glob(".vom*"))


def test_truncated_video_gives_its_readable_frames(tmp_path: Path) -> None:
    video = film(tmp_path / "a.avi", np.arange(60) * 12.0)
    data = video.read_bytes()
    video.write_bytes(data[: int(len(data) * 0.6)])
    report = take_frames(video, tmp_path / "out", fps=2)
    assert 2 <= len(report.frames) <= 5


def test_folder_with_other_files_needs_force_and_earlier_output_is_replaced(tmp_path: Path) -> None:
    video = film(tmp_path / "a.avi", np.arange(40) * 12.0)
    target = tmp_path / "out"
    target.mkdir()
    (target / "mine.txt").write_text("mine")
    with refused("folder.not-empty", TargetError):
        take_frames(video, target)
    assert len(take_frames(video, target, force=True).frames) == 4
    assert (target / "mine.txt").read_text() == "mine"
    (target / "mine.txt").unlink()
    assert len(take_frames(video, target, fps=1).frames) == 2
    assert len(list(target.glob("*.jpg"))) == 2
    with refused("output.no-folder", TargetError):
        take_frames(video, tmp_path / "no" / "out")
    with refused("folder.is-file", TargetError):
        take_frames(video, video)


def test_cancelled_extraction_leaves_no_files(tmp_path: Path) -> None:
    video = film(tmp_path / "a.avi", np.arange(40) * 12.0)
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        take_frames(video, tmp_path / "out", progress=SilentProgress(token))
    assert [p.name for p in tmp_path.iterdir()] == ["a.avi"]


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), 60.0])
def test_impossible_rates_are_refused(fps: float) -> None:
    with refused("option.out-of-range", UsageError, field="--fps"):
        VideoFrameOptions(fps=fps)


def test_playlists_and_numbered_names_open_no_other_files(tmp_path: Path) -> None:
    real = film(tmp_path / "real.avi", np.arange(60) * 10.0)
    assert take_frames(real, tmp_path / "real", fps=2).frames
    still = cv2.imencode(".jpg", np.random.default_rng(1).integers(0, 255, (90, 120, 3)))[1]
    for number in (1, 2, 3):
        (tmp_path / f"s_{number:02}.jpg").write_bytes(still.tobytes())
    for name, content in {
        "a.m3u8": "#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\nreal.avi\n#EXT-X-ENDLIST\n",
        "b.mp4": "ffconcat version 1.0\nfile real.avi\n",
        "s_%02d.jpg": "x",
    }.items():
        (tmp_path / name).write_text(content)
        with refused("video.not-a-video") as refusal:
            take_frames(tmp_path / name, tmp_path / "out")
        assert refusal.value.file == str(tmp_path / name)
    with refused("video.not-a-video"):
        take_frames(tmp_path / "s_01.jpg", tmp_path / "out")


@pytest.mark.parametrize(
    "ending", first_in_default_tier(["avi", "mp4", "mov", "mkv", "webm", "mpg", "ts"], 2)
)
def test_all_listed_video_formats_are_read(tmp_path: Path, ending: str) -> None:
    """Written by FFmpeg, where the installed one can."""
    codec = {"avi": "MJPG", "webm": "VP80", "mpg": "PIM1", "ts": "mp4v"}.get(ending, "mp4v")
    path = tmp_path / f"a.{ending}"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), 20, (480, 360))
    if not writer.isOpened():
        pytest.skip(f"no encoder for {ending}")
    for x in range(0, 800, 10):
        frame = cv2.getRectSubPix(texture(), (480, 360), (x + 300.0, 400.0))
        writer.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    writer.release()
    if path.stat().st_size < 400:
        pytest.skip(f"no encoder for {ending}")
    assert take_frames(path, tmp_path / "out", fps=2).frames
