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
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.failures import lifeline
from vomstudio.core.files import memory_limit
from vomstudio.core.findings import Finding
from vomstudio.core.paths import import_folders
from vomstudio.core.progress import Progress
from vomstudio.core.threads import run_in_thread
from vomstudio.core.words import tr

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
    from concurrent.futures import wait

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
        text = json.dumps(question).encode("ascii")
        answer = run_in_thread(process.communicate, text, name="reader process")
        try:
            progress.stage(tr("Reading {file}", file=path.name))
            looks = 0
            while not wait([answer], _LOOK_S).done:
                looks += 1
                progress.step(looks)
        finally:
            if process.poll() is None:
                process.kill()
            wait([answer])
    finally:
        line.close()
    if process.returncode != 0 or answer.exception() is not None:
        raise InputError(Finding("file.memory-exceeded"), file=path)
    return answer.result()[0]


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
