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
from vomstudio.studio.jobs.job import Job, Lane, NoArguments


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


def _count(asked: To, progress: Progress) -> NoArguments:
    progress.stage("counting", asked.to)
    for i in range(asked.to):
        progress.step(i)
        time.sleep(0.005)
    return NoArguments()


def _deaf(asked: NoArguments, progress: Progress) -> NoArguments:
    progress.stage("deaf")
    time.sleep(60)
    return NoArguments()


def _deafest(asked: NoArguments, progress: Progress) -> NoArguments:
    # Python's lock is held all the while: no thread of the child hears anything.
    import ctypes

    progress.stage("deafest")
    ctypes.PyDLL(None).sleep(60)
    return NoArguments()


def _die(asked: NoArguments, progress: Progress) -> NoArguments:
    progress.stage("dying")
    os.abort()


def _nan(asked: NoArguments, progress: Progress) -> Value:
    return Value(float("nan"))


def _fault(asked: NoArguments, progress: Progress) -> NoArguments:
    raise RuntimeError("our own fault")


def _no_memory(asked: NoArguments, progress: Progress) -> NoArguments:
    raise MemoryError


def _hungry(asked: NoArguments, progress: Progress) -> NoArguments:
    import numpy as np

    # Reserved and never touched: the limit is on what is asked for.
    kept = []
    while True:
        kept.append(np.empty(1 << 30, np.uint8))


def _killed(asked: NoArguments, progress: Progress) -> NoArguments:
    progress.stage("dying")
    os.kill(os.getpid(), signal.SIGKILL)
    return NoArguments()


@dataclass(frozen=True)
class Into:
    out: Path


def _full(asked: Into, progress: Progress) -> NoArguments:
    # As COLMAP ends a process whose matches find no room.
    progress.stage("dying")
    said = "database.cc:13] SQLite error: database or disk is full\n*** Aborted at 17\n    @ 0x7f"
    os.write(2, f"terminate called after throwing an error\n  what():  {said}\n".encode())
    os.abort()


def _given_up(asked: NoArguments, progress: Progress) -> NoArguments:
    # As OpenMP ends a process that gets no thread.
    progress.stage("dying")
    os.write(2, b"libgomp: Thread creation failed: Resource temporarily unavailable\n")
    os._exit(1)


def _other_answer(asked: NoArguments, progress: Progress) -> NoArguments:
    return Word("no number")  # type: ignore[return-value]


class OurMistake(ValueError):
    """An error that nobody expects."""


def _mistake(*_: object) -> NoArguments:
    raise OurMistake("at 432100.25")


def _aside(asked: NoArguments, progress: Progress) -> NoArguments:
    thread = threading.Thread(target=_mistake, name="aside")
    thread.start()
    thread.join()
    return NoArguments()


def _segfault(asked: NoArguments, progress: Progress) -> NoArguments:
    import ctypes

    ctypes.string_at(0)
    return NoArguments()


def _idle(asked: NoArguments, progress: Progress) -> NoArguments:
    return NoArguments()


CHATTER = Job("chatter", Lane.MODELS, Word, Word, _chatter)
COUNT = Job("count", Lane.MODELS, To, NoArguments, _count)
DEAF = Job("deaf", Lane.MODELS, NoArguments, NoArguments, _deaf)
DEAFEST = Job("deafest", Lane.MODELS, NoArguments, NoArguments, _deafest)
DIE = Job("die", Lane.MODELS, NoArguments, NoArguments, _die)
NAN = Job("nan", Lane.MODELS, NoArguments, Value, _nan)
FAULT = Job("fault", Lane.MODELS, NoArguments, NoArguments, _fault)
NO_MEMORY = Job("no_memory", Lane.MODELS, NoArguments, NoArguments, _no_memory)
_LESS = "Take less."
HUNGRY = Job("hungry", Lane.RECONSTRUCTION, NoArguments, NoArguments, _hungry, _LESS)
KILLED = Job("killed", Lane.RECONSTRUCTION, NoArguments, NoArguments, _killed, _LESS)
FULL = Job("full", Lane.RECONSTRUCTION, Into, NoArguments, _full, _LESS)
GIVEN_UP = Job("given_up", Lane.RECONSTRUCTION, NoArguments, NoArguments, _given_up, _LESS)
OTHER_ANSWER = Job("other_answer", Lane.MODELS, NoArguments, Value, _other_answer)  # type: ignore[arg-type]
MISTAKE = Job("mistake", Lane.INSPECTION, NoArguments, NoArguments, _mistake)
ASIDE = Job("aside", Lane.INSPECTION, NoArguments, NoArguments, _aside)
SEGFAULT = Job("segfault", Lane.INSPECTION, NoArguments, NoArguments, _segfault)
ABORT = Job("abort", Lane.INSPECTION, NoArguments, NoArguments, _die)
IDLE = Job("idle", Lane.INSPECTION, NoArguments, NoArguments, _idle)
LEVITATE = Job("levitate", Lane.MODELS, NoArguments, NoArguments, _deaf)
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
