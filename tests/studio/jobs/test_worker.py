"""The worker process and its supervisor: what is said, stopped, and survived."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from tests.studio.jobs.odd_jobs import (
    CHATTER,
    COUNT,
    DEAF,
    DIE,
    FAULT,
    FULL,
    GIVEN_UP,
    HUNGRY,
    KILLED,
    LEVITATE,
    NAN,
    NO_MEMORY,
    OTHER_ANSWER,
    Into,
    To,
    Word,
)
from vomstudio.core.errors import InputError, UsageError, WorkerError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.paths import resource
from vomstudio.studio.jobs.events import Done, Failed, Stage, Step, from_line, to_line
from vomstudio.studio.jobs.job import NoArguments
from vomstudio.studio.jobs.model_tasks import LOAD_MODEL, ModelFile
from vomstudio.studio.jobs.supervisor import WorkerSupervisor


class Listener:
    """Keeps events; `end` waits for the job's last one."""

    def __init__(self) -> None:
        self.events: list = []
        self.changed = threading.Condition()

    def __call__(self, event) -> None:
        with self.changed:
            self.events.append(event)
            self.changed.notify_all()

    def until(self, found, seconds: float = 20.0):
        with self.changed:
            assert self.changed.wait_for(lambda: any(map(found, self.events)), seconds)
            return next(e for e in self.events if found(e))

    def end(self, seconds: float = 20.0):
        return self.until(lambda e: isinstance(e, Done | Failed), seconds)


@pytest.fixture
def worker(monkeypatch):
    """A supervisor whose child also knows the odd jobs."""
    real = subprocess.Popen

    def start(words, **more):
        assert words[1:] == ["-P", "-m", "vomstudio", "--worker"]
        return real([sys.executable, "-P", "-m", "tests.studio.jobs.odd_jobs"], **more)

    monkeypatch.setattr("vomstudio.studio.jobs.supervisor.subprocess.Popen", start)
    made = WorkerSupervisor()
    yield made
    made.close()


def test_events_survive_serialisation():
    for event in (
        Stage(1, "reading", 10),
        Stage(2, "…", None),
        Step(1, 3),
        Done(1, {"a": [1.5]}),
        Failed(1, {"code": "input", "message": "no"}, 2),
    ):
        assert from_line(to_line(event)) == event


def test_failed_job_reports_file_line_and_field_of_its_error():
    cause = Finding("number.invalid", text="1o")
    error = InputError(cause, file="control.csv", line=3, field="x")
    event = from_line(to_line(Failed(1, error.to_dict(), error.exit_code)))
    assert event.message == str(error)
    assert to_finding(event.to_error()) == to_finding(error)
    argument = UsageError(cause, field="--x")
    assert Failed(1, argument.to_dict(), argument.exit_code).message == argument.message


@pytest.mark.parametrize(
    "line",
    [
        "",
        "nonsense",
        "5",
        "[]",
        "{}",
        '{"event": "Stage"}',
        '{"event": "Other", "job": 1}',
        '{"event": "Step", "job": 1, "done": 1, "more": 2}',
    ],
)
def test_line_that_is_not_an_event_is_rejected(line):
    with pytest.raises(ValueError, match=r"."):
        from_line(line)


def test_a_library_that_prints_does_not_break_the_protocol(worker):
    heard = Listener()
    worker.submit(CHATTER, Word("hello"), heard)
    assert heard.end() == Done(1, Word("hello"))


def test_progress_comes_in_order_and_before_the_result(worker):
    heard = Listener()
    worker.submit(COUNT, To(5), heard)
    heard.end()
    assert heard.events == [
        Stage(1, "counting", 5),
        *(Step(1, i) for i in range(5)),
        Done(1, NoArguments()),
    ]


def test_cancelled_job_ends_and_the_worker_process_continues(worker):
    heard = Listener()
    job = worker.submit(COUNT, To(5000), heard)
    heard.until(lambda e: isinstance(e, Step))
    process = worker._process
    worker.cancel(job)
    worker.cancel(job)
    end = heard.end()
    assert end.cancelled
    after = Listener()
    worker.submit(COUNT, To(1), after)
    assert isinstance(after.end(), Done)
    assert worker._process is process


def test_a_waiting_job_can_be_cancelled(worker):
    first, second = Listener(), Listener()
    worker.submit(COUNT, To(100), first)
    job = worker.submit(COUNT, To(100), second)
    worker.cancel(job)
    assert isinstance(first.end(), Done)
    assert second.end().cancelled
    assert len(second.events) == 1


def test_cancelling_a_waiting_job_does_not_end_the_running_job(worker, monkeypatch):
    monkeypatch.setattr("vomstudio.studio.jobs.supervisor.CANCEL_GRACE_S", 0.1)
    first, second = Listener(), Listener()
    worker.submit(COUNT, To(200), first)
    first.until(lambda e: isinstance(e, Step))
    job = worker.submit(COUNT, To(200), second)
    worker.cancel(job)
    assert isinstance(first.end(), Done)
    assert second.end().cancelled


def test_job_that_ignores_cancelling_is_ended_with_its_process(worker, monkeypatch):
    monkeypatch.setattr("vomstudio.studio.jobs.supervisor.CANCEL_GRACE_S", 0.2)
    heard = Listener()
    job = worker.submit(DEAF, NoArguments(), heard)
    heard.until(lambda e: isinstance(e, Stage))
    begun = time.monotonic()
    worker.cancel(job)
    assert heard.end().cancelled
    assert time.monotonic() - begun < 5.0
    after = Listener()
    worker.submit(COUNT, To(1), after)
    assert isinstance(after.end(), Done)


@pytest.mark.expects_log
def test_jobs_of_a_dead_worker_fail_and_the_worker_is_replaced(worker):
    first, second = Listener(), Listener()
    worker.submit(DIE, NoArguments(), first)
    worker.submit(COUNT, To(1), second)
    for heard in (first, second):
        end = heard.end()
        assert isinstance(end, Failed)
        assert end.exit_code == 1
        assert "Try again" in end.message
    after = Listener()
    worker.submit(COUNT, To(1), after)
    assert isinstance(after.end(), Done)


@pytest.mark.expects_log
@pytest.mark.parametrize("pause_s", [0.0, 0.001, 0.01, 0.1])
def test_job_submitted_right_after_a_worker_death_is_answered(worker, pause_s):
    """The supervisor may notice the death by the next command, before the reader does."""
    heard, after = Listener(), Listener()
    worker.submit(DEAF, NoArguments(), heard)
    heard.until(lambda e: isinstance(e, Stage))
    os.kill(worker._process.pid, signal.SIGKILL)
    time.sleep(pause_s)
    try:
        worker.submit(COUNT, To(1), after)
    except WorkerError:
        after = None
    assert isinstance(heard.end(), Failed)
    if after is not None:
        assert after.end() is not None


@pytest.mark.parametrize(
    ("task", "words"),
    [
        (NAN, "The field 'value' (nan) cannot be sent"),
        (FAULT, "our own fault"),
        (NO_MEMORY, "not enough memory"),
        (OTHER_ANSWER, "Value has no field 'word'"),
    ],
)
def test_failing_task_is_reported_and_the_worker_continues(worker, task, words):
    heard, after = Listener(), Listener()
    worker.submit(task, NoArguments(), heard)
    assert words in heard.end().message
    worker.submit(COUNT, To(1), after)
    assert isinstance(after.end(), Done)


@pytest.mark.skipif(sys.platform != "linux", reason="no other system can hold a process to it")
def test_job_out_of_memory_is_reported_and_the_worker_continues(worker):
    heard, after = Listener(), Listener()
    worker.submit(HUNGRY, NoArguments(), heard)
    end = heard.end()
    assert isinstance(end, Failed)
    assert (end.error["code"], end.error["remedy"]) == ("job.out-of-memory", "Take less.")
    worker.submit(COUNT, To(1), after)
    assert isinstance(after.end(), Done)


@pytest.mark.expects_log
@pytest.mark.parametrize(
    ("task", "words"),
    [
        (
            KILLED,
            "killed by the system, probably for lack of memory). Finished results are kept. Take",
        ),
        (GIVEN_UP, "There is not enough memory for this task. Take less."),
        (DIE, "(exit code -6). Finished results are kept. Try again."),
    ],
)
def test_killed_worker_is_reported_with_a_remedy(worker, task, words):
    heard = Listener()
    worker.submit(task, NoArguments(), heard)
    end = heard.end()
    assert isinstance(end, Failed)
    assert words in end.message


@pytest.mark.expects_log
def test_worker_ended_by_a_library_on_a_full_disk_reports_a_disk_error(worker, tmp_path, capfd):
    heard = Listener()
    worker.submit(FULL, Into(tmp_path), heard)
    end = heard.end()
    assert isinstance(end, Failed)
    assert end.exit_code == 2
    assert end.error["file"] == str(tmp_path)
    assert end.error["code"] == "disk.failed"
    assert capfd.readouterr().err == ""


@pytest.mark.full
def test_unknown_task_fails_with_its_name(worker):
    heard = Listener()
    worker.submit(LEVITATE, NoArguments(), heard)
    end = heard.end()
    assert isinstance(end, Failed)
    assert "levitate" in end.message
    assert "KeyError" not in end.message


def test_closed_supervisor_accepts_no_jobs_and_starts_no_process(worker):
    worker.close()
    with pytest.raises(WorkerError):
        worker.submit(COUNT, To(1), Listener())
    assert worker._process is None


def test_released_worker_ends_without_error_and_the_next_job_starts_another(worker):
    internal_errors: list = []
    worker._on_internal_error = internal_errors.append
    busy = Listener()
    worker.submit(COUNT, To(3), busy)
    process = worker._process
    worker.release()
    assert worker._process is process, "a job was running"
    busy.end()
    worker.release()
    assert process.wait(20.0) == 0
    again = Listener()
    worker.submit(COUNT, To(2), again)
    assert isinstance(again.end(), Done)
    assert worker._process is not process
    assert not internal_errors


def test_closing_ends_the_process_and_emits_no_more_events(worker):
    heard = Listener()
    worker.submit(DEAF, NoArguments(), heard)
    heard.until(lambda e: isinstance(e, Stage))
    process = worker._process
    begun = time.monotonic()
    worker.close()
    assert process.poll() is not None
    assert time.monotonic() - begun < 3.0
    assert len(heard.events) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere such a child ends a little later")
def test_worker_in_native_code_ends_when_its_supervisor_is_killed():
    supervisor = (
        "import subprocess, sys, time\n"
        "real = subprocess.Popen\n"
        "def start(words, **more): return real("
        "[sys.executable, '-m', 'tests.studio.jobs.odd_jobs'], **more)\n"
        "subprocess.Popen = start\n"
        "from tests.studio.jobs.odd_jobs import DEAFEST\n"
        "from vomstudio.studio.jobs.job import NoArguments\n"
        "from vomstudio.studio.jobs.supervisor import WorkerSupervisor\n"
        "worker = WorkerSupervisor()\n"
        "say = lambda event: print(worker._process.pid, flush=True)\n"
        "worker.submit(DEAFEST, NoArguments(), say)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", supervisor],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    ) as process:
        child_id = int(process.stdout.readline())
        time.sleep(0.3)
        process.kill()
    import psutil

    end = time.monotonic() + 10
    while psutil.pid_exists(child_id) and psutil.Process(child_id).status() != "zombie":
        assert time.monotonic() < end, "the child lives on"
        time.sleep(0.05)


# --- the child by itself ---------------------------------------------------------------------
def child(**more) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "vomstudio", "--worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **more,
    )


@pytest.mark.parametrize("named", ["", "."])
def test_worker_does_not_import_from_the_current_folder(tmp_path, monkeypatch, worker, named):
    """A json.py beside the photos is not Python's, however the program was started."""
    (tmp_path / "json.py").write_text("raise SystemExit('imported from the folder of the photos')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(named and str(tmp_path))
    heard = Listener()
    worker.submit(CHATTER, Word("hello"), heard)
    assert heard.end() == Done(1, Word("hello"))


def test_end_of_file_ends_an_idle_worker():
    with child() as process:
        process.stdin.close()
        assert process.wait(10) == 0


def test_end_of_file_ends_a_busy_worker(tmp_path):
    big = tmp_path / "big.obj"
    line = b"v 1.5 2.5 3.5\n" * 10_000
    with big.open("wb") as stream:
        for _ in range(150):
            stream.write(line)
    with child() as process:
        args = {"path": str(big), "cache": str(tmp_path / "cache")}
        process.stdin.write(json.dumps({"job": 1, "task": "load_model", "args": args}) + "\n")
        process.stdin.flush()
        time.sleep(1.0)
        process.stdin.close()
        assert process.wait(10) == 0


def test_invalid_command_line_does_not_stop_the_worker():
    with child() as process:
        process.stdin.write("nonsense\n[1]\n{}\n" + json.dumps({"job": 3, "task": "?", "args": {}}))
        process.stdin.write("\n")
        process.stdin.flush()
        event = from_line(process.stdout.readline())
        assert isinstance(event, Failed)
        assert event.job == 3
        process.stdin.close()
        assert process.wait(10) == 0


@pytest.mark.full
def test_loaded_model_is_passed_through_the_cache(tmp_path):
    from vomstudio.io.models import model_cache

    worker, heard = WorkerSupervisor(), Listener()
    try:
        worker.submit(LOAD_MODEL, ModelFile(resource("outcrop", "outcrop.obj"), tmp_path), heard)
        end = heard.end(60.0)
    finally:
        worker.close()
    assert isinstance(end, Done)
    assert end.result.kind == "mesh"
    assert any(isinstance(e, Stage) for e in heard.events)
    data = model_cache.open_cache_folder(end.result.folder).data
    assert len(data.faces) > 0


def test_missing_file_is_reported_with_its_name(tmp_path):
    worker, heard = WorkerSupervisor(), Listener()
    try:
        worker.submit(LOAD_MODEL, ModelFile(tmp_path / "gone.obj", tmp_path), heard)
        end = heard.end(60.0)
    finally:
        worker.close()
    assert isinstance(end, Failed)
    assert end.exit_code == 2
    assert "gone.obj" in end.message
