"""A pipe in the place of every file that is named, into which nobody writes: none is waited for."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.fuzz.kinds import GO_ON, READERS, seeds
from tests.fuzz.readers import LONGEST_S, lay
from vomstudio.core.errors import InputError, VomError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes have names on POSIX only")


class _Reading(threading.Thread):
    """Reads a file; does not keep the tests from ending where it waits for ever."""

    def __init__(self, read: Callable[[Path], object], path: Path) -> None:
        super().__init__(daemon=True)
        self._read, self._path = read, path
        self.said = "nothing"

    def run(self) -> None:
        try:
            self._read(self._path)
            self.said = "read"
        except VomError as error:
            self.said = str(error)
        except Exception as error:  # noqa: BLE001 - that is what is looked for
            self.said = f"ERROR {error!r}"


def test_no_reader_waits_for_a_pipe(tmp_path: Path) -> None:
    readings = []
    for number, (kind, files) in enumerate(seeds().items()):
        main, read = READERS[kind]
        sound = tmp_path / f"s{number}.vom"
        lay(files, sound)
        # What is imported for a kind, and compiled, is there by then.
        with contextlib.suppress(VomError):
            read(sound / main)
        for at, name in enumerate(files):
            place = tmp_path / f"p{number}-{at}.vom"
            lay(files, place)
            (place / name).unlink()
            os.mkfifo(place / name)
            readings.append((kind, name, _Reading(read, place / main)))
    for _, _, reading in readings:
        reading.start()
    # Texts wait three seconds for somebody who writes; all of them at a time.
    end = time.monotonic() + LONGEST_S + 0.2 * len(readings)
    wrong = []
    for kind, name, reading in readings:
        reading.join(max(end - time.monotonic(), 0.0))
        refused = ".vom" in reading.said and not reading.said.startswith("ERROR")
        # What lies beside a file may be left out.
        beside = name != READERS[kind][0] or kind in GO_ON
        if reading.is_alive() or not (refused or (beside and reading.said == "read")):
            wrong.append(f"{kind}: pipe as {name}: {reading.said}")
    assert wrong == []


def _exported(pipe: Path) -> object:
    """A mesh whose texture has become a pipe since it was read."""
    from vomstudio.io.models.writers._common import image_bytes

    return image_bytes(pipe)


def _taken_over(pipe: Path) -> object:
    """The mask of a photo that is kept in a project."""
    from vomstudio.project.imports.sidecar_import import read_sidecars

    found = read_sidecars(pipe.parent, None, None, {"p.jpg": pipe}, ["p.jpg"])
    raise InputError(found.problems[0])


def _aligned(pipe: Path) -> object:
    """A photo that has become one since it was found: it has no features and says why."""
    from vomstudio.core.progress import SilentProgress
    from vomstudio.photogrammetry.align.alignment import AlignmentOptions, find_features
    from vomstudio.studio.jobs.executors import Threads

    photo = SimpleNamespace(path=pipe, mask=None, width=32, height=24, name="p.jpg")
    found, _ = find_features([photo], pipe.parent, AlignmentOptions(), Threads(1), SilentProgress())
    assert len(found[0].keypoints) == 0
    raise InputError(str(found[0].problem), file=pipe)


def _set_aside(pipe: Path) -> object:
    from vomstudio.core.files.backup import back_up

    return back_up(pipe)


def _hashed(pipe: Path) -> object:
    from vomstudio.io.models.opening import file_hash

    return file_hash(pipe)


def _held(pipe: Path) -> object:
    """A journal in whose place somebody has put a pipe."""
    from vomstudio.project.journal.file_watch import contains_rows
    from vomstudio.project.journal.rows import Head

    assert not contains_rows(pipe, Head(1, 1, ""))
    raise InputError("not held", file=pipe)


@pytest.mark.parametrize(
    "read", [_exported, _taken_over, _aligned, _set_aside, _hashed, _held], ids=lambda f: f.__name__
)
def test_file_replaced_by_pipe_is_refused(tmp_path: Path, read: Callable[[Path], object]) -> None:
    os.mkfifo(tmp_path / "pipe.png")
    reading = _Reading(read, tmp_path / "pipe.png")
    reading.start()
    # What is imported takes its time.
    reading.join(6 * LONGEST_S)
    assert not reading.is_alive()
    assert "pipe.png" in reading.said
    assert not reading.said.startswith("ERROR")


def test_preview_does_not_block_on_pipe(tmp_path: Path) -> None:
    from vomstudio.io.models.preview import preview

    os.mkfifo(tmp_path / "a.las")
    reading = _Reading(lambda path: preview(path), tmp_path / "a.las")
    reading.start()
    reading.join(6 * LONGEST_S)
    assert reading.said == "read"
