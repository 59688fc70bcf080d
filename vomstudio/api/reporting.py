"""Progress display and cancellation of long-running tasks."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from vomstudio.api.checking import wrong_type_error
from vomstudio.core.progress import CancelToken, Progress, SilentProgress

ProgressArgument = Callable[[str, int, int | None], Any] | Progress | None
"""Callable with (stage, completed steps, total steps or None), or object with `stage`, `step`."""


class _CallbackProgress:
    """Progress that calls a function given by the caller."""

    def __init__(self, callback: Callable[[str, int, int | None], Any]) -> None:
        self._call = callback
        self._stage, self._total = "", None

    def stage(self, name: str, total: int | None = None) -> None:
        self._stage, self._total = name, total  # type: ignore[assignment]
        self._call(name, 0, total)

    def step(self, done_count: int) -> None:
        self._call(self._stage, done_count, self._total)


class _CancellableProgress:
    """Progress that raises Cancelled once a token is set."""

    def __init__(self, progress: Progress, token: CancelToken) -> None:
        self._progress, self._token = progress, token

    def stage(self, name: str, total: int | None = None) -> None:
        self._token.check()
        self._progress.stage(name, total)

    def step(self, done_count: int) -> None:
        self._token.check()
        self._progress.step(done_count)


def _accepts_three_arguments(callback: Callable[..., Any]) -> bool:
    try:
        inspect.signature(callback).bind("", 0, None)
    except TypeError:
        return False
    except ValueError:  # Builtins have no signature.
        pass
    return True


def to_progress(progress: ProgressArgument, cancel: CancelToken | None = None) -> Progress:
    """Convert the `progress` argument to a Progress.

    Parameters
    ----------
    progress : callable or Progress, optional
    cancel : CancelToken, optional

    Returns
    -------
    Progress

    Raises
    ------
    InputError
        If an argument has another type.
    """
    if cancel is not None and not isinstance(cancel, CancelToken):
        raise wrong_type_error(cancel, "vs.CancelToken", "cancel")
    reporter: Progress
    if progress is None:
        reporter = SilentProgress()
    elif hasattr(progress, "stage") and hasattr(progress, "step"):
        reporter = progress
    elif callable(progress) and _accepts_three_arguments(progress):
        reporter = _CallbackProgress(progress)
    else:
        raise wrong_type_error(progress, "function(stage, done, total)", "progress")
    return reporter if cancel is None else _CancellableProgress(reporter, cancel)
