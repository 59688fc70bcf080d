"""Reader in a separate process, for libraries that cannot be interrupted.

GDAL holds the GIL while it reads, so no thread of this process could report progress or stop the
reading. The memory of the reader process is limited according to the size of the file; the process
can be ended at any time and ends together with its parent.
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

_POLL_PERIOD_S = 0.1


def run_reader(module: str, request: Mapping[str, Any], progress: Progress, path: Path) -> bytes:
    """Run a reader module on a request in a separate process.

    Parameters
    ----------
    module : str
        Module whose ``__main__`` block calls `serve`.
    request : mapping
        Request as plain data.
    progress : Progress
        Receiver of progress; its `step` may stop the reading by raising an exception.
    path : Path
        File that is read, for error messages.

    Returns
    -------
    bytes
        Response of the reader.

    Raises
    ------
    InputError
        With the code ``file.memory-exceeded`` if the process did not end normally.
    """
    from concurrent.futures import wait

    line = lifeline.Lifeline()
    try:
        process = subprocess.Popen(
            # -P: do not import a json.py that lies next to the file.
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
        line.close_child_end()
        text = json.dumps(request).encode("ascii")
        answer = run_in_thread(process.communicate, text, name="reader process")
        try:
            progress.stage(tr("Reading {file}", file=path.name))
            poll_count = 0
            while not wait([answer], _POLL_PERIOD_S).done:
                poll_count += 1
                progress.step(poll_count)
        finally:
            if process.poll() is None:
                process.kill()
            wait([answer])
    finally:
        line.close()
    if process.returncode != 0 or answer.exception() is not None:
        raise InputError(Finding("file.memory-exceeded"), file=path)
    return answer.result()[0]


def serve(handle_request: Callable[[dict[str, Any]], bytes]) -> int:
    """Read a request from stdin, write the response to stdout and return the exit status."""
    out = os.fdopen(os.dup(1), "wb")
    # Messages of libraries go to stderr.
    os.dup2(2, 1)
    lifeline.end_with_parent()
    memory_limit.enable_limits()
    request = json.load(sys.stdin)
    content = handle_request(request)
    with out:
        out.write(content)
    return 0
