"""Background threads that deliver their results to the thread of their owner."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from functools import partial
from threading import Lock, Thread, current_thread
from typing import Any, Generic, TypeVar

from vomstudio.core.errors import Cancelled, VomError
from vomstudio.core.failures import exception_hooks
from vomstudio.core.failures.error_collector import error_location
from vomstudio.core.findings import Finding
from vomstudio.core.threads import lower_priority, start_thread
from vomstudio.studio.owner_thread import Call, Post

Result = TypeVar("Result")
Value = TypeVar("Value")

DEFAULT_THREADS = 16
"""Exceeds the number of processors because functions also wait for files."""


class Request(Generic[Result]):
    """Request that is passed to the function running in a thread.

    Attributes
    ----------
    is_stale : bool
        Whether a newer request has replaced this one, or the owner has cancelled it.
    """

    def __init__(
        self,
        key: Hashable,
        work: Callable[[Request[Result]], Result],
        on_result: Callable[[Result], object],
        on_error: Callable[[VomError], object] | None,
        expected_types: tuple[type[Exception], ...],
        post: Post,
    ) -> None:
        self.is_stale = False
        self.key, self.work = key, work
        self.on_result, self.on_error, self.expected = on_result, on_error, expected_types
        self._post = post

    def check(self) -> None:
        """Raise `Cancelled` if the request is stale."""
        if self.is_stale:
            raise Cancelled()

    def emit(self, result: Result) -> None:
        """Deliver a preliminary result. Raises `Cancelled` if the request is stale."""
        self.check()
        self.deliver(partial(self.on_result, result))

    def deliver(self, call: Call) -> None:
        """Make a call in the owner's thread, unless the request has become stale."""
        self._post(lambda: None if self.is_stale else call())


class Background:
    """Background threads of one owner, whose code runs in a single thread.

    All methods must be called from the owner's thread. Results and errors are delivered to that
    thread, except those of stale requests. A new request replaces earlier ones with the same
    key; if one of them is running, the new one starts after it has ended. Threads end when all
    requests are done.

    Parameters
    ----------
    post : Post
        Makes calls in the owner's thread.
    name : str
        Name of the threads in error reports.
    threads : int
        Maximum number of threads.
    niceness : int
        Niceness of the threads; see `core.threads.lower_priority`.
    is_daemon : bool
        Whether the process may exit before the threads have ended.
    """

    def __init__(
        self,
        post: Post,
        name: str,
        *,
        threads: int = DEFAULT_THREADS,
        niceness: int = 0,
        is_daemon: bool = True,
    ) -> None:
        self._post, self._name, self._max_threads = post, name, threads
        self._niceness, self._daemon = niceness, is_daemon
        self._lock = Lock()
        self._queue: list[Request[Any]] = []
        self._newest_requests: dict[Hashable, Request[Any]] = {}
        self._running_keys: set[Hashable] = set()
        self._threads: set[Thread] = set()
        self._is_stopped = False

    @property
    def is_stopped(self) -> bool:
        """Whether the background has been stopped; it then runs and delivers nothing."""
        return self._is_stopped

    def is_waiting(self, key: Hashable) -> bool:
        """Return whether a result with this key is pending."""
        return key in self._newest_requests

    @property
    def is_busy(self) -> bool:
        """Whether any result is pending."""
        return bool(self._newest_requests)

    def run(
        self,
        work: Callable[[], Result],
        on_result: Callable[[Result], object],
        on_error: Callable[[VomError], object] | None = None,
        *,
        key: Hashable = None,
        expected: tuple[type[Exception], ...] = (),
    ) -> None:
        """Run a function in a thread and deliver what it returns or raises.

        Parameters
        ----------
        work : callable
            Called in a thread.
        on_result, on_error : callable
            Called in the owner's thread.
        key : hashable
            The request replaces an earlier request with the same key. If None, no request is
            replaced.
        expected : tuple of exception types
            Exceptions that are expected in addition to `VomError`. All others are reported as
            uncaught and delivered as a `VomError`. Without `on_error`, every error is reported.
        """
        self.run_request(lambda _: work(), on_result, on_error, key=key, expected_types=expected)

    def run_request(
        self,
        work: Callable[[Request[Result]], Result],
        on_result: Callable[[Result], object],
        on_error: Callable[[VomError], object] | None = None,
        *,
        key: Hashable = None,
        expected_types: tuple[type[Exception], ...] = (),
        is_first: bool = False,
    ) -> None:
        """Run a function that can stop early or emit partial results through its request.

        Parameters
        ----------
        work : callable
            Called in a thread with its `Request`.
        on_result, on_error : callable
            See `run`.
        key : Hashable, optional
            See `run`.
        expected_types : tuple of type, optional
            See `run`.
        is_first : bool
            Whether to run the function before all pending requests.
        """
        key = object() if key is None else key
        self.cancel(key)
        if self.is_stopped:
            return
        request = Request(key, work, on_result, on_error, expected_types, self._post)
        with self._lock:
            self._newest_requests[key] = request
            self._queue.insert(0 if is_first else len(self._queue), request)
            if key not in self._running_keys and len(self._threads) < self._max_threads:
                self._threads.add(start_thread(self._work, name=self._name, daemon=self._daemon))

    def cancel(self, key: Hashable) -> None:
        """Cancel the pending request with a key, if any."""
        with self._lock:
            if (request := self._newest_requests.pop(key, None)) is not None:
                request.is_stale = True
                if request in self._queue:
                    self._queue.remove(request)

    def cancel_all(self) -> None:
        """Cancel all requests."""
        for key in list(self._newest_requests):
            self.cancel(key)

    def stop(self, wait_s: float = 0.0) -> None:
        """Cancel all requests and reject new ones.

        Parameters
        ----------
        wait_s : float
            Maximum time to wait for running functions, seconds.
        """
        self._is_stopped = True
        self.cancel_all()
        with self._lock:
            threads = list(self._threads)
        deadline_s = time.monotonic() + wait_s
        for thread in threads:
            thread.join(max(0.0, deadline_s - time.monotonic()))

    def guard(self, call: Callable[[Value], object]) -> Callable[[Value], None]:
        """Wrap a callback so that it does nothing after `stop`, for jobs that end later."""

        def guarded_call(value: Value) -> None:
            if not self.is_stopped:
                call(value)

        return guarded_call

    # --- in the threads ----------------------------------------------------------------------
    def _work(self) -> None:
        if self._niceness:
            lower_priority(self._niceness)
        request = self._next_request(None)
        while request is not None:
            self._process_request(request)
            request = self._next_request(request)

    def _next_request(self, last_request: Request[Any] | None) -> Request[Any] | None:
        with self._lock:
            if last_request is not None:
                self._running_keys.discard(last_request.key)
            for request in self._queue:
                if request.key not in self._running_keys:
                    self._queue.remove(request)
                    self._running_keys.add(request.key)
                    return request
            self._threads.discard(current_thread())
            return None

    def _process_request(self, request: Request[Any]) -> None:
        try:
            result = request.work(request)
        except Cancelled:
            call: Call | None = None
        except Exception as error:  # noqa: BLE001 - delivered, and reported if it is a defect
            call = self._failure(request, error)
        else:
            call = partial(request.on_result, result)
        request.deliver(partial(self._finish, request.key, call))

    def _failure(self, request: Request[Any], error: Exception) -> Call | None:
        is_expected = isinstance(error, (VomError, *request.expected))
        if request.on_error is None or not is_expected:
            exception_hooks.report_as_uncaught(error)
        if request.on_error is None:
            return None
        if not isinstance(error, VomError):
            error = VomError(
                Finding("file.unreadable", reason=str(error))
                if is_expected
                else Finding("program.internal-error", error=error_location(error))
            )
        return partial(request.on_error, error)

    def _finish(self, key: Hashable, call: Call | None) -> None:
        self._newest_requests.pop(key, None)
        if call is not None:
            call()
