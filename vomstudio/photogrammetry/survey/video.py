"""Extraction of sharp video frames for a reconstruction, and assessment (textbook 3.2.4)."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import ByteArray
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import check_in_project
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.names import decode_name, utf8_name
from vomstudio.core.files.regular import folder_finding, open_regular_file, read_json
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.results import HIDDEN_IN_JSON, Result
from vomstudio.core.words import to_translate, tr
from vomstudio.photogrammetry.survey.photo_quality import blur
from vomstudio.photogrammetry.survey.survey_options import DEFAULT_FPS

VIDEO_EXTENSIONS = (
    ".mp4",
    ".mov",
    ".avi",
    ".mkv",
    ".m4v",
    ".mts",
    ".m2ts",
    ".mpg",
    ".mpeg",
    ".webm",
    ".wmv",
    ".3gp",
)
"""Extensions of videos of phones, cameras and drones, for file dialogs."""
_RECORD_FILE = "frames.json"
# Bytes at offsets of the header: AVI; MP4, MOV and 3GP; MKV and WebM; WMV; MPEG program and
# elementary streams; MPEG transport streams with packets of 188 bytes, and of 192 by cameras.
_SIGNATURES = (
    ((0, b"RIFF"), (8, b"AVI")),
    ((4, b"ftyp"),),
    ((4, b"moov"),),
    ((4, b"mdat"),),
    ((4, b"wide"),),
    ((4, b"free"),),
    ((4, b"skip"),),
    ((4, b"pnot"),),
    ((0, b"\x1a\x45\xdf\xa3"),),
    ((0, b"\x30\x26\xb2\x75\x8e\x66\xcf\x11"),),
    ((0, b"\0\0\1\xba"),),
    ((0, b"\0\0\1\xb3"),),
    ((0, b"G"), (188, b"G"), (376, b"G")),
    ((4, b"G"), (196, b"G"), (388, b"G")),
)
# Number of frames per interval that are compared for sharpness.
_CANDIDATES_PER_INTERVAL = 5
_BLUR_PX, _MAX_BLUR_RATIO, _MAX_BLUR_PX = 2.5, 1.8, 4.0
# Limits of the shift between frames, as a share of the long side: 96 % overlap is "nearly 100 %".
_MIN_SHIFT = 0.04
_MAX_SHIFT = 0.4
_TRACKING_SIZE_PX = 480
_MIN_FRAMES = 8
NO_DETAIL = to_translate("without any detail")
BLURRED = to_translate("blurred")
UNCHANGED = to_translate("nearly identical to the previous frame")
"""Reasons for skipped frames: keys of `FrameReport.skipped` and of the command's JSON."""


@dataclass(frozen=True)
class VideoFrame:
    """Extracted frame: name of its file, number in the video, seconds from its start."""

    name: str
    number: int
    seconds: float
    blur_px: float | None


@dataclass(frozen=True)
class FrameReport(Result):
    """Frames taken from a video, and its suitability.

    Parameters
    ----------
    folder : Path
    width, height : int
        Size of the frames in pixels.
    video_fps : float
    seconds : float
        Duration.
    frames : list of VideoFrame
    skipped : dict
        Number of intervals without a frame, by reason.
    gaps_s : list of float
        Times at which the picture moved so far that adjacent frames may not overlap enough.
    warnings : list of Finding
    reasons : list of Finding
        Reasons why the video is not suitable.
    good_enough : bool
    verdict : str
    """

    folder: Path = field(metadata=HIDDEN_IN_JSON)
    width: int
    height: int
    video_fps: float
    seconds: float
    frames: list[VideoFrame] = field(default_factory=list)
    skipped: dict[str, int] = field(default_factory=dict)
    gaps_s: list[float] = field(default_factory=list)
    warnings: list[Finding] = field(default_factory=list)
    reasons: list[Finding] = field(default_factory=list)
    good_enough: bool = True
    verdict: str = ""

    def to_dict(self) -> dict[str, Any]:
        frames = [str(self.folder / frame.name) for frame in self.frames]
        return super().to_dict() | {"frames": frames}


def take_frames(
    video: str | Path,
    folder: str | Path,
    *,
    fps: float = DEFAULT_FPS,
    force: bool = False,
    progress: Progress | None = None,
) -> FrameReport:
    """Write the sharpest frame of every 1 / fps seconds as JPEG into `folder`.

    Frames that are blurred or nearly the same as the last one are skipped. The folder is written
    atomically; a folder from an earlier call is replaced, any other non-empty folder only with
    `force`.

    Raises
    ------
    InputError
        If the file is not a video, or has no usable frames.
    TargetError
        If the folder cannot be written, or is not empty and `force` is not set.
    UsageError, Cancelled
    """
    progress = progress or SilentProgress()
    target = _check_target(Path(folder), force)
    with _Video(Path(video)) as source:
        parent = target.parent
        try:
            temporary_folder = Path(tempfile.mkdtemp(prefix=".vom-frames-", dir=parent))
        except OSError as error:
            raise TargetError(
                Finding("output.unwritable", reason=failure_reason(parent, error)),
                file=folder,
            ) from error
        try:
            report = _add_verdict(
                _select_frames(source, target, temporary_folder, fps, progress), fps
            )
            if not report.frames:
                reasons = ", ".join(
                    tr("{reason}: {count}", reason=tr(reason), count=count)
                    for reason, count in report.skipped.items()
                )
                raise InputError(
                    Finding("video.no-frames", reasons=reasons),
                    file=source.path,
                )
            _move_to_target(temporary_folder, target, report)
        except OSError as error:
            raise TargetError(
                Finding("output.unwritable", reason=failure_reason(parent, error)),
                file=folder,
            ) from error
        finally:
            shutil.rmtree(temporary_folder, ignore_errors=True)
    return report


def _is_video(path: Path) -> bool:
    """Return whether a file starts like a file with one of `VIDEO_EXTENSIONS`.

    The decoder detects formats by content, and would open other files for a playlist or a numbered
    name.
    """
    with open_regular_file(path) as file:
        header = file.read(400)
    return any(
        all(header[position : position + len(magic)] == magic for position, magic in signature)
        for signature in _SIGNATURES
    )


class _Video:
    def __init__(self, path: Path) -> None:
        # Suppress messages of the decoder.
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
        import cv2

        if path.is_dir():
            raise InputError(folder_finding(path), file=path)
        if not path.is_file():
            raise InputError(Finding("file.missing"), file=path)
        if path.stat().st_size == 0:
            raise InputError(Finding("file.empty"), file=path)
        self.path = path
        if not _is_video(path):
            raise InputError(Finding("video.not-a-video"), file=path)
        with utf8_name(path) as safe_path:
            self._capture = cv2.VideoCapture(str(safe_path))
        is_read, first_frame = self._capture.read() if self._capture.isOpened() else (False, None)
        if not is_read or first_frame is None:
            self._capture.release()
            raise InputError(Finding("video.not-a-video"), file=path)
        self._first_frame = np.asarray(first_frame)
        self.height, self.width = self._first_frame.shape[:2]
        fps = float(self._capture.get(cv2.CAP_PROP_FPS))
        self.fps = fps if 0.1 <= fps <= 1000.0 else 25.0
        count = float(self._capture.get(cv2.CAP_PROP_FRAME_COUNT))
        self.count = int(count) if 0 < count < 1e8 else None

    def __enter__(self) -> _Video:
        return self

    def __exit__(self, *exc: object) -> None:
        self._capture.release()

    def frames(self, interval: int) -> Iterator[tuple[int, ByteArray]]:
        """Return every `interval`-th frame with its number; the others are not converted."""
        yield 0, np.asarray(self._first_frame, np.uint8)
        number = 1
        while self._capture.grab():
            if number % interval == 0:
                is_read, frame = self._capture.retrieve()
                if is_read and frame is not None:
                    yield number, np.asarray(frame, np.uint8)
            number += 1
        self.count = number


def _select_frames(
    source: _Video, target: Path, temporary_folder: Path, fps: float, progress: Progress
) -> FrameReport:
    import cv2

    report = FrameReport(target, source.width, source.height, source.fps, 0.0)
    window = max(1, round(source.fps / fps))
    stated_count = source.count
    progress.stage(tr("Selecting frames"), stated_count)
    last_frame: ByteArray | None = None
    sigmas: list[float] = []
    stem = decode_name(source.path.stem)
    for done_count, group in _candidate_groups(source, window):
        progress.step(min(done_count, stated_count) if stated_count else done_count)
        number, frame = max(group, key=lambda item: _sharpness(item[1]))
        sigma = blur(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY).astype(np.uint8))
        # Use the sharpest frames so far, since most of a video may be blurred.
        sharp_sigma = float(np.quantile(sigmas, 0.1)) if len(sigmas) >= 5 else 0.0
        if sigma is None:
            _count_skipped(report, NO_DETAIL)
            continue
        sigmas.append(sigma)
        if sigma > min(max(_BLUR_PX, _MAX_BLUR_RATIO * sharp_sigma), _MAX_BLUR_PX):
            _count_skipped(report, BLURRED)
            continue
        reduced_frame = _reduce_size(frame)
        if last_frame is not None:
            shift = _shift(last_frame, reduced_frame)
            if shift is not None and shift < _MIN_SHIFT:
                _count_skipped(report, UNCHANGED)
                continue
            if shift is None or shift > _MAX_SHIFT:
                report.gaps_s.append(round(number / source.fps, 2))
        name = f"{stem}_{number:06d}.jpg"
        done_count, content = cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, 96])
        if not done_count:
            raise OSError(28, tr("the disk may be full"))
        # OpenCV would crash on a name that is not UTF-8.
        (temporary_folder / name).write_bytes(content.tobytes())
        report.frames.append(VideoFrame(name, number, number / source.fps, sigma))
        last_frame = reduced_frame
    if stated_count and source.count is not None and source.count < 0.95 * stated_count:
        report.warnings.append(Finding("video.cut-short", frames=source.count, total=stated_count))
    return replace(report, seconds=(source.count or 0) / source.fps)


def _candidate_groups(
    source: _Video, window: int
) -> Iterator[tuple[int, list[tuple[int, ByteArray]]]]:
    """Yield the number of processed frames and the candidate frames of each interval."""
    stride = max(1, window // _CANDIDATES_PER_INTERVAL)
    group: list[tuple[int, ByteArray]] = []
    end = window
    for number, frame in source.frames(stride):
        if number >= end and group:
            yield number, group
            group = []
        while number >= end:
            end += window
        group.append((number, frame))
    if group:
        yield group[-1][0] + 1, group


def _sharpness(frame: ByteArray) -> float:
    """Return the variance of the Laplacian, which ranks frames of one scene by sharpness.

    Pech-Pacheco et al. 2000.
    """
    import cv2

    grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    return float(cv2.Laplacian(grey[::2, ::2], cv2.CV_32F).var())


def _reduce_size(frame: ByteArray) -> ByteArray:
    import cv2

    scale = _TRACKING_SIZE_PX / max(frame.shape[:2])
    reduced_frame = cv2.resize(frame, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(reduced_frame, cv2.COLOR_BGR2GRAY), np.uint8)


def _shift(previous_frame: ByteArray, frame: ByteArray) -> float | None:
    """Return the median shift of corners relative to the long side; None if not tracked."""
    import cv2

    corners = cv2.goodFeaturesToTrack(previous_frame, 300, 0.01, 7)
    if corners is None or len(corners) < 20:
        return None
    moved_corners, status, _ = cv2.calcOpticalFlowPyrLK(
        previous_frame, frame, corners, np.empty_like(corners), winSize=(21, 21), maxLevel=4
    )
    tracked_back_corners, back_status, _ = cv2.calcOpticalFlowPyrLK(
        frame, previous_frame, moved_corners, np.empty_like(corners), winSize=(21, 21), maxLevel=4
    )
    is_consistent = np.linalg.norm((tracked_back_corners - corners).reshape(-1, 2), axis=1) < 1.0
    is_tracked = (status.ravel() == 1) & (back_status.ravel() == 1) & is_consistent
    if is_tracked.sum() < max(12, 0.15 * len(corners)):
        return None
    steps = np.linalg.norm((moved_corners - corners).reshape(-1, 2)[is_tracked], axis=1)
    return float(np.median(steps)) / float(max(previous_frame.shape))


def _count_skipped(report: FrameReport, reason: str) -> None:
    report.skipped[reason] = report.skipped.get(reason, 0) + 1


def _add_verdict(report: FrameReport, fps: float) -> FrameReport:
    """Add the verdict on whether the video is suitable for a reconstruction."""
    frame_count = len(report.frames)
    interval_count = frame_count + sum(report.skipped.values())
    blurred_share = report.skipped.get(BLURRED, 0) / max(interval_count, 1)
    unchanged_count = report.skipped.get(UNCHANGED, 0)
    reasons = report.reasons
    size = max(report.width, report.height)
    if frame_count < _MIN_FRAMES:
        reasons.append(Finding("video.few-frames", count=frame_count, least=_MIN_FRAMES))
    if blurred_share > 0.5:
        reasons.append(Finding("video.blurred", "error", share_percent=100 * blurred_share))
    if frame_count and len(report.gaps_s) > 0.3 * frame_count:
        reasons.append(Finding("video.too-fast", moments=len(report.gaps_s)))
    if size < 1000:
        reasons.append(Finding("video.small", "error", width=report.width, height=report.height))
    elif size < 1900:
        report.warnings.append(Finding("video.small", width=report.width, height=report.height))
    if 0 < blurred_share <= 0.5 and blurred_share > 0.2:
        report.warnings.append(Finding("video.blurred", share_percent=100 * blurred_share))
    if unchanged_count > 0.3 * max(interval_count, 1):
        report.warnings.append(Finding("video.still"))
    if fps > 4.0 or fps < 1.0:
        report.warnings.append(Finding("video.unusual-rate", fps=fps))
    return replace(report, good_enough=not reasons, verdict=video_verdict(report).message)


def video_verdict(report: FrameReport) -> Finding:
    """Return the verdict on whether a video is suitable for a reconstruction."""
    if not report.reasons:
        return Finding("video.usable", count=len(report.frames))
    sentences = " ".join(reason.message for reason in report.reasons)
    return Finding("video.not-good-enough", reasons=sentences)


# ------------------------------------------------------------------------------------------------
def _check_target(folder: Path, force: bool) -> Path:
    if not folder.name:
        raise TargetError(Finding("folder.unnamed"), file=folder)
    target = folder.absolute()
    check_in_project(target)
    if not target.parent.is_dir():
        raise TargetError(
            Finding("output.no-folder", folder=target.parent),
            file=folder,
        )
    if target.exists() and not target.is_dir():
        raise TargetError(Finding("folder.is-file"), file=folder)
    if target.is_dir() and any(target.iterdir()) and not force and not is_extraction_folder(target):
        raise TargetError(
            Finding("folder.not-empty"),
            file=folder,
        )
    return target


def is_extraction_folder(folder: Path) -> bool:
    """Return whether a folder contains only the results of an earlier extraction."""
    try:
        record = read_json(folder / _RECORD_FILE)
        names = {frame["name"] for frame in record["frames"]} | {_RECORD_FILE}
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return {path.name for path in folder.iterdir()} <= names


def _move_to_target(temporary_folder: Path, target: Path, report: FrameReport) -> None:
    record = {
        "verdict": report.verdict,
        "frames": [
            {"name": f.name, "number": f.number, "seconds": f.seconds, "blur_px": f.blur_px}
            for f in report.frames
        ],
    }
    (temporary_folder / _RECORD_FILE).write_text(json.dumps(record, indent=1), encoding="utf-8")
    if target.is_dir() and is_extraction_folder(target):
        shutil.rmtree(target)
    if not target.is_dir():
        temporary_folder.chmod(0o777 & ~_current_umask())
        temporary_folder.rename(target)
        return
    for path in sorted(temporary_folder.iterdir()):
        os.replace(path, target / path.name)


def _current_umask() -> int:
    current_mask = os.umask(0o022)
    os.umask(current_mask)
    return current_mask
