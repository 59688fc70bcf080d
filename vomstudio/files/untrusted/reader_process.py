"""A reader in a process of its own, for libraries that cannot be interrupted.

GDAL reads as long as it takes, and Python stands still meanwhile: no thread of this process could
report progress or end the reading. The process is held to the memory that the file can be worth,
can be ended at any time, and ends with this one.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.errors import InputError
from vomstudio.failures import lifeline
from vomstudio.files import memory_limit
from vomstudio.paths import import_folders
from vomstudio.progress import Progress
from vomstudio.words import tr

_LOOK_S = 0.1


def ask(module: str, question: Mapping[str, Any], progress: Progress, path: Path) -> bytes:
    """Have a module answer a question in a process of its own.

    Parameters
    ----------
    module : str
        Its ``__main__`` calls `serve`.
    question : mapping
        Plain data.
    progress : Progress
        Its `step` may end the reading by an exception.
    path : Path
        The file that is read, for messages.

    Returns
    -------
    bytes
        The answer.

    Raises
    ------
    InputError
        With ``file.memory-exceeded`` if the process came to no end of its own.
    """
    line = lifeline.Lifeline()
    try:
        process = subprocess.Popen(
            # -P: a json.py beside the file is not Python's.
            [sys.executable, "-P", "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={
                **os.environ,
                **line.environment(),
                "PYTHONPATH": os.pathsep.join(import_folders()),
            },
            pass_fds=line.descriptors,
        )
        line.started()
        answers: list[bytes] = []
        is_over = threading.Event()
        text = json.dumps(question).encode("ascii")

        def talk() -> None:
            try:
                answers.append(process.communicate(text)[0])
            finally:
                is_over.set()

        threading.Thread(target=talk, name="reader process", daemon=True).start()
        try:
            progress.stage(tr("Reading {file}", file=path.name))
            looks = 0
            # Not `Thread.join`: once interrupted, it takes the thread for ended (Python 3.11).
            while not is_over.wait(_LOOK_S):
                looks += 1
                progress.step(looks)
        finally:
            if process.poll() is None:
                process.kill()
            is_over.wait()
    finally:
        line.close()
    if process.returncode != 0 or not answers:
        raise InputError(Finding("file.memory-exceeded"), file=path)
    return answers[0]


def serve(answer: Callable[[dict[str, Any]], bytes]) -> int:
    """Read a question from stdin, write the answer to stdout; the exit status."""
    out = os.fdopen(os.dup(1), "wb")
    # Libraries print to the other one.
    os.dup2(2, 1)
    lifeline.end_with_parent()
    memory_limit.take_charge()
    question = json.load(sys.stdin)
    answered = answer(question)
    with out:
        out.write(answered)
    return 0
