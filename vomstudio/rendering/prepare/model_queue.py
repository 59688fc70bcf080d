"""Queue of models that are prepared in threads and handed over in order of completion."""

from __future__ import annotations

import collections
import contextlib
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray, IntegerArray
from vomstudio.core.errors import VomError
from vomstudio.core.failures.error_collector import ERRORS
from vomstudio.core.findings import Finding
from vomstudio.core.threads import thread_pool
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.octree import StreamedCloud
from vomstudio.rendering.prepare.events import (
    Emit,
    Event,
    ModelBounds,
    Problem,
    Stopped,
    Submit,
)
from vomstudio.rendering.view.scalars import FieldStyle

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

NICENESS = 5


class ModelQueue:
    """Queue for the preparation of models in threads.

    Results returned by `next_event` belong to the calling thread; only the preparation runs in
    other threads.
    """

    def __init__(self, notify: Callable[[], None]) -> None:
        """Create a queue; `notify` is called in any thread when results are available."""
        self._notify = notify
        self._inbox: collections.deque[tuple[str, threading.Event, Event]] = collections.deque()
        self._stop_events: dict[str, threading.Event] = {}
        self._field_stop_events: dict[str, threading.Event] = {}
        self._pool: ThreadPoolExecutor | None = None
        self._streams: ThreadPoolExecutor | None = None

    def expect(self, model_id: str) -> threading.Event:
        """Register a model for preparation; setting the returned event cancels it."""
        self.clear_state(model_id)
        stop_event = self._stop_events[model_id] = threading.Event()
        return stop_event

    def clear_state(self, model_id: str) -> None:
        """Cancel the preparation of a model."""
        stop_event = self._stop_events.pop(model_id, None)
        if stop_event is not None:
            stop_event.set()
        self.forget_field(model_id)

    def forget_field(self, model_id: str) -> None:
        stop_event = self._field_stop_events.pop(model_id, None)
        if stop_event is not None:
            stop_event.set()

    def close(self) -> None:
        """Stop all workers and wait for them to end."""
        for stop_event in (*self._stop_events.values(), *self._field_stop_events.values()):
            stop_event.set()
        for pool in (self._pool, self._streams):
            if pool is not None:
                pool.shutdown(wait=True, cancel_futures=True)
        self._pool = self._streams = None
        self._stop_events.clear()
        self._inbox.clear()

    @property
    def is_waiting(self) -> bool:
        return bool(self._inbox)

    def next_event(self) -> tuple[str, Event] | None:
        """Return the next result with the id of its model, or None if the queue is empty."""
        while self._inbox:
            model_id, stop_event, event = self._inbox.popleft()
            if self._stop_events.get(model_id) is stop_event:
                return model_id, event
        return None

    def prepare(
        self,
        model_id: str,
        data: Mesh | PointCloud,
        *,
        texture_limit: int,
        max_whole_side: int | None,
        budget: int,
    ) -> None:
        """Prepare a registered model; see the module `preparation`."""
        from vomstudio.rendering.prepare import preparation

        stop_event = self._stop_events[model_id]
        emit = self._emitter(model_id, stop_event, stop_event)
        pool = self._workers()
        if self._streams is None:
            # Uses a separate thread, so that a long preparation does not delay it.
            self._streams = thread_pool(1, "clouds", niceness=NICENESS)
        submit = _submitter(self._streams, stop_event)

        def shape() -> None:
            with self._report_errors(emit, "display.not-prepared"):
                if isinstance(data, Mesh):
                    bounds = preparation.finite_bounds(data.vertices, stop_event)
                elif data.arrangement is not None or isinstance(data, StreamedCloud):
                    bounds = data.bounds
                else:
                    bounds = preparation.finite_bounds(data.points, stop_event)
                origin = np.round(bounds.mean(axis=0))
                emit(ModelBounds(data, bounds, origin))
                if isinstance(data, Mesh):
                    # Results before the registration of the model would be lost.
                    _submitter(pool, stop_event)(pictures)
                    preparation.prepare_mesh(data, origin, stop_event, emit)
                else:
                    # Starting a thread takes time, during which this thread would wait.
                    submit(lambda: None)
                    preparation.prepare_cloud(data, origin, stop_event, emit, submit, budget)

        def pictures() -> None:
            with self._report_errors(emit, "display.not-prepared"):
                if isinstance(data, Mesh):
                    preparation.prepare_textures(
                        data, texture_limit, stop_event, emit, max_whole_side
                    )

        pool.submit(shape)

    def color(
        self,
        model_id: str,
        data: Mesh | PointCloud,
        style: FieldStyle,
        to_world: FloatArray,
        proxies: Sequence[IntegerArray],
        parts: Sequence[IntegerArray],
    ) -> None:
        """Compute the colours of a field; see `preparation.prepare_field`."""
        from vomstudio.rendering.prepare import preparation

        # A computed field may be removed while it is being coloured.
        data = replace(data, fields=dict(data.fields))
        self.forget_field(model_id)
        stop_event = self._field_stop_events[model_id] = threading.Event()
        emit = self._emitter(model_id, self._stop_events[model_id], stop_event)

        def work() -> None:
            with self._report_errors(emit, "display.field-not-shown", field=style.name):
                preparation.prepare_field(data, style, to_world, proxies, parts, stop_event, emit)

        self._workers().submit(work)

    def _workers(self) -> ThreadPoolExecutor:
        if self._pool is None:
            self._pool = thread_pool(2, "viewport", niceness=NICENESS)
        return self._pool

    def _emitter(self, model_id: str, model: threading.Event, stop_event: threading.Event) -> Emit:
        """Return the function through which a worker emits the results of a model."""

        def emit(event: Event) -> None:
            if stop_event.is_set():
                raise Stopped
            self._inbox.append((model_id, model, event))
            self._notify()

        return emit

    @contextlib.contextmanager
    def _report_errors(self, emit: Emit, code: str, **values: str) -> Iterator[None]:
        """Log and report errors of a thread, which would be lost otherwise."""
        try:
            yield
        except Stopped:
            pass
        except Exception as error:  # noqa: BLE001 - as above
            if not isinstance(error, VomError):
                ERRORS.report(error, code)
            with contextlib.suppress(Stopped):
                emit(Problem(Finding(code, **values, reason=str(error))))


def _submitter(pool: ThreadPoolExecutor, stop_event: threading.Event) -> Submit:
    """Return a function that submits jobs to a thread pool.

    A pool that is being closed rejects jobs from its own threads. This is not an error if the
    model has been removed.
    """

    def submit(work: Callable[[], None]) -> None:
        try:
            pool.submit(work)
        except RuntimeError:
            if not stop_event.is_set():
                raise

    return submit
