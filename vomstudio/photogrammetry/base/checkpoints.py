"""Checkpoints: folders of finished stages, whose names identify all of their inputs.

A stage works in the folder `NAME-KEY.part`, which is renamed to `NAME-KEY` when it is complete and
written to the disk. The files inside are written atomically, so that a run that was stopped, killed
or interrupted by a power failure resumes after the last finished photo.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.io.models.reconstruction_file import CURRENT_FILE
from vomstudio.photogrammetry.base.memory import peak_bytes
from vomstudio.photogrammetry.base.stage_folders import FEATURES

_STAMP_FILE = "stage.json"
_KEY_LENGTH = 16


def make_key(*parts: object) -> str:
    """Return a key of JSON values that is the same on all machines."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:_KEY_LENGTH]


class StageFolder:
    """Folder of one stage. `seconds` and `peak_bytes` include previous runs."""

    def __init__(self, root: Path, name: str, key: str) -> None:
        self.name, self.key = name, key
        self._final_folder = root / f"{name}-{key}"
        self._partial_folder = root / f"{name}-{key}.part"
        self._start_time = time.monotonic()
        try:
            if self.is_done:
                # The newest folder of a stage is the one in use; see `stage_folder`.
                os.utime(self._final_folder)
            else:
                self._partial_folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _write_error(self._partial_folder, error) from error
        facts = self.facts
        self._previous_seconds = float(facts.get("seconds", 0.0))
        self._previous_peak_bytes = int(facts.get("peak_bytes", 0))

    @property
    def is_done(self) -> bool:
        """Whether the stage is finished."""
        return self._final_folder.is_dir()

    @property
    def folder(self) -> Path:
        """Folder of the files, which has its final name once the stage is finished."""
        return self._final_folder if self.is_done else self._partial_folder

    @property
    def facts(self) -> dict[str, Any]:
        """Facts passed to `finish`, and "seconds" and "peak_bytes"; empty for a new stage."""
        return _read(self.folder / _STAMP_FILE)

    @property
    def seconds(self) -> float:
        """Total time spent on the stage in all runs, in seconds."""
        return (
            self._previous_seconds
            if self.is_done
            else self._previous_seconds + time.monotonic() - self._start_time
        )

    @property
    def peak_bytes(self) -> int:
        """Recorded peak memory or that of this process, whichever is larger, in bytes."""
        return max(self._previous_peak_bytes, peak_bytes())

    def pause(self) -> None:
        """Store the time spent so far, so that a later run can add to it."""
        if not self.is_done and self._partial_folder.is_dir():
            usage = {"seconds": self.seconds, "peak_bytes": self.peak_bytes}
            write_atomically(self._partial_folder / _STAMP_FILE, lambda p: _write(p, usage))

    def finish(self, **facts: Any) -> None:
        """Complete the stage: write all files to the disk, then rename the folder.

        Raises TargetError if the disk is full or not writable.
        """
        seconds = self.seconds
        facts = {"seconds": seconds, "peak_bytes": self.peak_bytes, **facts}
        write_atomically(self._partial_folder / _STAMP_FILE, lambda p: _write(p, facts))
        try:
            for path in self._partial_folder.rglob("*"):
                if path.is_file():
                    _sync_to_disk(path)
            os.replace(self._partial_folder, self._final_folder)
            _sync_to_disk(self._final_folder.parent)
        except OSError as error:
            raise _write_error(self._final_folder, error) from error
        self._previous_seconds = seconds


class Checkpoints:
    """Stages of a reconstruction, all stored below one folder."""

    def __init__(self, root: Path) -> None:
        """Create the folder if it does not exist.

        Raises
        ------
        TargetError
            If the folder cannot be created.
        """
        self.root = root
        try:
            root.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TargetError(
                Finding("folder.not-created", reason=error.strerror),
                file=root,
            ) from error
        self.stages: list[StageFolder] = []

    def stage(self, name: str, *parts: object) -> StageFolder:
        """Return the stage for these inputs and settings.

        Later stages include its key in their own keys.
        """
        stage = StageFolder(self.root, name, make_key(name, *parts))
        self.stages.append(stage)
        return stage

    def remove_partial_files(self) -> None:
        """Remove the partial files of a killed run. No other run may be using the folder."""
        for path in list(self.root.rglob(".*.part")):
            path.unlink(missing_ok=True)

    def size(self) -> int:
        """Return the total size of all files, in bytes."""
        return sum(path.stat().st_size for path in self.root.rglob("*") if path.is_file())

    def other_folders(self, stage: StageFolder) -> list[Path]:
        """Return the folders of the same stage with other inputs or settings, newest first."""
        paths = [
            path
            for path in self.root.glob(f"{stage.name}-*")
            if path.is_dir() and path.name.partition(".")[0] != f"{stage.name}-{stage.key}"
        ]
        return sorted(paths, key=lambda path: path.stat().st_mtime_ns, reverse=True)

    def record_current(self) -> None:
        """Write the names of the folders in use to `CURRENT_FILE`.

        Other folders are kept, so that earlier photos and settings cost nothing, until the project
        is compacted.
        """
        names = sorted({FEATURES, *(stage.folder.name for stage in self.stages)})
        write_atomically(self.root / CURRENT_FILE, lambda path: _write(path, {"folders": names}))


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file atomically.

    `write` fills a temporary file, which is then renamed to `path`. Raises TargetError if the disk
    is full or not writable.
    """
    temporary_path = path.with_name(f".{path.name}.part")
    try:
        write(temporary_path)
        _sync_to_disk(temporary_path)
        os.replace(temporary_path, path)
    except OSError as error:
        raise _write_error(path, error) from error
    finally:
        with contextlib.suppress(OSError):
            temporary_path.unlink(missing_ok=True)


def _write_error(path: Path, error: OSError) -> TargetError:
    return TargetError(
        Finding("reconstruct.not-written", reason=failure_reason(path.parent, error)),
        file=path,
    )


def file_name(photo: str) -> str:
    """Return a file name without folders for a photo's results, unique to the photo."""
    safe_stem = re.sub(r"[^A-Za-z0-9._-]", "_", Path(photo).stem)[:40]
    return f"{safe_stem}-{hashlib.sha256(photo.encode()).hexdigest()[:8]}"


def _read(path: Path) -> dict[str, Any]:
    try:
        content = read_json(path)
    except (OSError, ValueError):
        return {}
    if not isinstance(content, dict):
        raise InputError(Finding("reconstruct.damaged", reason="stage.json"), file=path.parent)
    return content


def _write(path: Path, facts: dict[str, Any]) -> None:
    path.write_text(json.dumps(facts, indent=1, default=_to_plain_value), encoding="utf-8")


def _to_plain_value(value: object) -> object:
    return value.to_dict() if isinstance(value, Finding) else str(value)


def _sync_to_disk(path: Path) -> None:
    """Flush to the disk, so that a rename after a power failure never leaves an empty file."""
    if path.is_dir() and os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError:
        # Some network folders do not support this; a power failure may then destroy a stage.
        pass
    finally:
        os.close(descriptor)
