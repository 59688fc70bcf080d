"""Threads and pools come from one module."""

from __future__ import annotations

import pytest

from tests.architecture.counts import ROOT, creates_threads, sources


def test_one_module_creates_threads_and_pools() -> None:
    modules = [
        path.relative_to(ROOT).as_posix()
        for path in sources("vomstudio")
        if creates_threads(path.read_text(encoding="utf-8"))
    ]
    assert modules == ["vomstudio/core/threads.py"]


@pytest.mark.parametrize(
    "source",
    [
        "import threading as t; t.Thread(target=print).start()",
        "from threading import Timer; Timer(1.0, print)",
        "with ThreadPoolExecutor(2) as pool: pass",
        "import threading\nclass Reader(threading.Thread): pass",
        "class Task(QRunnable): pass",
        "QThreadPool.globalInstance().start(task)",
        "import _thread; _thread.start_new_thread(print, ())",
    ],
)
def test_every_form_of_thread_creation_is_detected(source: str) -> None:
    assert creates_threads(source)


@pytest.mark.parametrize(
    "source", ["lock = threading.Lock()", "x: threading.Thread | None = None", "QTimer(self)"]
)
def test_other_threading_names_are_not_detected(source: str) -> None:
    assert not creates_threads(source)
