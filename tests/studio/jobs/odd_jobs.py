"""Jobs that go wrong in every way, and a worker that knows them."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.progress import Progress
from vomstudio.studio.jobs import tasks, worker
from vomstudio.studio.jobs.job import Job, Lane, Nothing


@dataclass(frozen=True)
class Word:
    word: str


@dataclass(frozen=True)
class To:
    to: int


@dataclass(frozen=True)
class Value:
    value: float


def _chatter(asked: Word, progress: Progress) -> Word:
    print("a library speaks on stdout")
    os.write(1, b"and a native one too\n")
    return asked


def _count(asked: To, progress: Progress) -> Nothing:
    progress.stage("counting", asked.to)
    for i in range(asked.to):
        progress.step(i)
        time.sleep(0.005)
    return Nothing()


def _deaf(asked: Nothing, progress: Progress) -> Nothing:
    progress.stage("deaf")
    time.sleep(60)
    return Nothing()


def _deafest(asked: Nothing, progress: Progress) -> Nothing:
    # Python's lock is held all the while: no thread of the child hears anything.
    import ctypes

    progress.stage("deafest")
    ctypes.PyDLL(None).sleep(60)
    return Nothing()


def _die(asked: Nothing, progress: Progress) -> Nothing:
    progress.stage("dying")
    os.abort()


def _nan(asked: Nothing, progress: Progress) -> Value:
    return Value(float("nan"))


def _fault(asked: Nothing, progress: Progress) -> Nothing:
    raise RuntimeError("our own fault")


def _no_memory(asked: Nothing, progress: Progress) -> Nothing:
    raise MemoryError


def _hungry(asked: Nothing, progress: Progress) -> Nothing:
    import numpy as np

    # Reserved and never touched: the limit is on what is asked for.
    kept = []
    while True:
        kept.append(np.empty(1 << 30, np.uint8))


def _killed(asked: Nothing, progress: Progress) -> Nothing:
    progress.stage("dying")
    os.kill(os.getpid(), signal.SIGKILL)
    return Nothing()


@dataclass(frozen=True)
class Into:
    out: Path


def _full(asked: Into, progress: Progress) -> Nothing:
    # As COLMAP ends a process whose matches find no room.
    progress.stage("dying")
    said = "database.cc:13] SQLite error: database or disk is full\n*** Aborted at 17\n    @ 0x7f"
    os.write(2, f"terminate called after throwing an error\n  what():  {said}\n".encode())
    os.abort()


def _given_up(asked: Nothing, progress: Progress) -> Nothing:
    # As OpenMP ends a process that gets no thread.
    progress.stage("dying")
    os.write(2, b"libgomp: Thread creation failed: Resource temporarily unavailable\n")
    os._exit(1)


def _other_answer(asked: Nothing, progress: Progress) -> Nothing:
    return Word("no number")  # type: ignore[return-value]


class OurMistake(ValueError):
    """An error that nobody expects."""


def _mistake(*_: object) -> Nothing:
    raise OurMistake("at 432100.25")


def _aside(asked: Nothing, progress: Progress) -> Nothing:
    thread = threading.Thread(target=_mistake, name="aside")
    thread.start()
    thread.join()
    return Nothing()


def _segfault(asked: Nothing, progress: Progress) -> Nothing:
    import ctypes

    ctypes.string_at(0)
    return Nothing()


def _idle(asked: Nothing, progress: Progress) -> Nothing:
    return Nothing()


CHATTER = Job("chatter", Lane.MODELS, Word, Word, _chatter)
COUNT = Job("count", Lane.MODELS, To, Nothing, _count)
DEAF = Job("deaf", Lane.MODELS, Nothing, Nothing, _deaf)
DEAFEST = Job("deafest", Lane.MODELS, Nothing, Nothing, _deafest)
DIE = Job("die", Lane.MODELS, Nothing, Nothing, _die)
NAN = Job("nan", Lane.MODELS, Nothing, Value, _nan)
FAULT = Job("fault", Lane.MODELS, Nothing, Nothing, _fault)
NO_MEMORY = Job("no_memory", Lane.MODELS, Nothing, Nothing, _no_memory)
_LESS = "Take less."
HUNGRY = Job("hungry", Lane.RECONSTRUCTION, Nothing, Nothing, _hungry, _LESS)
KILLED = Job("killed", Lane.RECONSTRUCTION, Nothing, Nothing, _killed, _LESS)
FULL = Job("full", Lane.RECONSTRUCTION, Into, Nothing, _full, _LESS)
GIVEN_UP = Job("given_up", Lane.RECONSTRUCTION, Nothing, Nothing, _given_up, _LESS)
OTHER_ANSWER = Job("other_answer", Lane.MODELS, Nothing, Value, _other_answer)  # type: ignore[arg-type]
MISTAKE = Job("mistake", Lane.INSPECTION, Nothing, Nothing, _mistake)
ASIDE = Job("aside", Lane.INSPECTION, Nothing, Nothing, _aside)
SEGFAULT = Job("segfault", Lane.INSPECTION, Nothing, Nothing, _segfault)
ABORT = Job("abort", Lane.INSPECTION, Nothing, Nothing, _die)
IDLE = Job("idle", Lane.INSPECTION, Nothing, Nothing, _idle)
LEVITATE = Job("levitate", Lane.MODELS, Nothing, Nothing, _deaf)
"""No worker knows it."""

KNOWN = (
    CHATTER,
    COUNT,
    DEAF,
    DEAFEST,
    DIE,
    NAN,
    FAULT,
    NO_MEMORY,
    OTHER_ANSWER,
    HUNGRY,
    KILLED,
    FULL,
    GIVEN_UP,
    MISTAKE,
    ASIDE,
    SEGFAULT,
    ABORT,
    IDLE,
)

if __name__ == "__main__":
    tasks.TASKS.update({job.name: job for job in KNOWN})
    sys.exit(worker.main())
