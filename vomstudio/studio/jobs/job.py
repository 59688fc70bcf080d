"""Definition of a worker's job: name, request, result and function."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.studio.jobs import serialisation

Request = TypeVar("Request")
Result = TypeVar("Result")


class Lane(enum.Enum):
    """Queue of jobs that run one after another in one process.

    Lanes run in parallel, so that reading a model never has to wait for a reconstruction.
    """

    MODELS = "models"
    FILES = "files"
    PRODUCTS = "products"
    PHOTOS = "photos"
    RECONSTRUCTION = "reconstruction"
    INSPECTION = "inspection"
    KERNELS = "kernels"


@dataclass(frozen=True)
class NoArguments:
    """Request without parameters, or result without values."""


@dataclass(frozen=True)
class Job(Generic[Request, Result]):
    """Job of a worker.

    `request` and `result` are dataclasses that can be converted to JSON; see `serialisation`.

    Parameters
    ----------
    memory_hint : str
        Advice for the case of insufficient memory, a sentence for `tr`; "" for no advice.
    """

    name: str
    lane: Lane
    request: type[Request]
    result: type[Result]
    function: Callable[[Request, Progress], Result]
    memory_hint: str = ""

    def run_plain(self, args: Any, progress: Progress) -> Any:
        """Run the job in the worker process, with plain values as input and output.

        Raises
        ------
        WorkerError
            If the values cannot be converted. All errors of the job itself are raised as well.
        """
        return serialisation.encode(
            self.function(serialisation.decode(self.request, args), progress)
        )

    def memory_advice(self) -> str:
        """Return advice for the case of insufficient memory."""
        if self.memory_hint:
            return tr(self.memory_hint)
        return tr("Close other programs and try again.")
