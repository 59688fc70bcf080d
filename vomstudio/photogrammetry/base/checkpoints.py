"""Checkpoints: folders of finished stages, named by all that their content depends on.

A stage works in `NAME-KEY.part` and takes the name `NAME-KEY` once it is whole and on the disk.
Files inside appear whole or not at all, so that a run which was stopped, killed, or lost its power
goes on behind the last photo that was finished.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.base.memory import peak_bytes

_STAMP = "stage.json"
_KEY_LENGTH = 16


def key_of(*parts: object) -> str:
    """The same for the same JSON values, whenever and wherever."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:_KEY_LENGTH]


class Stage:
    """One stage's folder. `seconds` and `peak_bytes` count the work of earlier runs too."""

    def __init__(self, root: Path, name: str, key: str) -> None:
        self.name, self.key = name, key
        self._final = root / f"{name}-{key}"
        self._part = root / f"{name}-{key}.part"
        self._begun = time.monotonic()
        if not self.done:
            try:
                self._part.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise _not_written(self._part, error) from error
        facts = self.facts
        self._before = float(facts.get("seconds", 0.0))
        self._peak_before = int(facts.get("peak_bytes", 0))

    @property
    def done(self) -> bool:
        """Whether the stage is finished."""
        return self._final.is_dir()

    @property
    def folder(self) -> Path:
        """Where its files are: under the final name once it is done."""
        return self._final if self.done else self._part

    @property
    def facts(self) -> dict[str, Any]:
        """What `finish` was told."""
        return _read(self.folder / _STAMP)

    @property
    def seconds(self) -> float:
        """Time spent on the stage in all runs."""
        return self._before if self.done else self._before + time.monotonic() - self._begun

    @property
    def peak_bytes(self) -> int:
        """The most that a process has held at once which worked on this stage or a later one."""
        return max(self._peak_before, peak_bytes())

    def pause(self) -> None:
        """Note the time spent, for when the work goes on."""
        if not self.done and self._part.is_dir():
            spent = {"seconds": self.seconds, "peak_bytes": self.peak_bytes}
            write_whole(self._part / _STAMP, lambda p: _write(p, spent))

    def finish(self, **facts: Any) -> None:
        """Everything is there: put it on the disk, then give the folder its name."""
        seconds = self.seconds
        facts = {"seconds": seconds, "peak_bytes": self.peak_bytes, **facts}
        write_whole(self._part / _STAMP, lambda p: _write(p, facts))
        try:
            for path in self._part.rglob("*"):
                if path.is_file():
                    _sync_to_disk(path)
            os.replace(self._part, self._final)
            _sync_to_disk(self._final.parent)
        except OSError as error:
            raise _not_written(self._final, error) from error
        self._before = seconds


class Checkpoints:
    """All stages below one folder."""

    def __init__(self, root: Path) -> None:
        """Raises TargetError where the folder cannot be made."""
        self.root = root
        try:
            root.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TargetError(
                Finding("folder.not-created", reason=error.strerror),
                file=root,
            ) from error
        self.stages: list[Stage] = []

    def stage(self, name: str, *parts: object) -> Stage:
        """The stage `name` of these inputs and settings; stages that read its results pass on its
        key."""
        stage = Stage(self.root, name, key_of(name, *parts))
        self.stages.append(stage)
        return stage

    def tidy(self) -> None:
        """Remove halves of files, which a run that was killed has left. Nobody else may be at work
        here."""
        for path in list(self.root.rglob(".*.part")):
            path.unlink(missing_ok=True)

    def size(self) -> int:
        """Bytes of all that is kept."""
        return sum(path.stat().st_size for path in self.root.rglob("*") if path.is_file())

    def sweep(self) -> None:
        """Remove the folders of other inputs and settings than this run's."""
        kept = {stage.folder.name for stage in self.stages}
        for path in self.root.iterdir():
            if path.is_dir() and path.name not in kept:
                shutil.rmtree(path, ignore_errors=True)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file under another name, put it on the disk, then name it `path`.

    Raises TargetError where the disk is full or cannot be written.
    """
    temporary = path.with_name(f".{path.name}.part")
    try:
        write(temporary)
        _sync_to_disk(temporary)
        os.replace(temporary, path)
    except OSError as error:
        raise _not_written(path, error) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _not_written(path: Path, error: OSError) -> TargetError:
    return TargetError(
        Finding("reconstruct.not-written", reason=failure_reason(path.parent, error)),
        file=path,
    )


def file_name(photo: str) -> str:
    """A flat file name for a photo's results, which differs for different photos."""
    plain = re.sub(r"[^A-Za-z0-9._-]", "_", Path(photo).stem)[:40]
    return f"{plain}-{hashlib.sha256(photo.encode()).hexdigest()[:8]}"


def _read(path: Path) -> dict[str, Any]:
    try:
        found = read_json(path)
    except (OSError, ValueError):
        return {}
    if not isinstance(found, dict):
        raise InputError(Finding("reconstruct.damaged", reason="stage.json"), file=path.parent)
    return found


def _write(path: Path, facts: dict[str, Any]) -> None:
    path.write_text(json.dumps(facts, indent=1, default=_plain), encoding="utf-8")


def _plain(value: object) -> object:
    return value.to_dict() if isinstance(value, Finding) else str(value)


def _sync_to_disk(path: Path) -> None:
    """To the disk itself: a rename that outlives a power cut must not name an empty file."""
    if path.is_dir() and os.name == "nt":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError:
        # Some network folders cannot; a power cut may then cost a stage.
        pass
    finally:
        os.close(descriptor)
