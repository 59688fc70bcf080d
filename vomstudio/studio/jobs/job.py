"""A job of a worker: its name, request, result, and the function that does it."""

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
    """Jobs of one lane follow one another in one process; lanes run beside each other, so that
    reading a model never waits for a reconstruction."""

    MODELS = "models"
    FILES = "files"
    PRODUCTS = "products"
    PHOTOS = "photos"
    RECONSTRUCTION = "reconstruction"
    INSPECTION = "inspection"


@dataclass(frozen=True)
class Nothing:
    """Of a job that is asked nothing, or that answers by being done."""


@dataclass(frozen=True)
class Job(Generic[Request, Result]):
    """`request` and `result` are dataclasses of what fits into JSON, see `serialisation`.

    smaller : what to change where memory is short, a sentence for `tr`; "" where nothing can be
    """

    name: str
    lane: Lane
    request: type[Request]
    result: type[Result]
    do: Callable[[Request, Progress], Result]
    smaller: str = ""

    def carry_out(self, args: Any, progress: Progress) -> Any:
        """In the worker: plain values in, plain values out. Raises WorkerError where they do not
        fit, and what the work raises."""
        return serialisation.encode(self.do(serialisation.decode(self.request, args), progress))

    def if_memory_is_short(self) -> str:
        """What to do about it, in a sentence."""
        if self.smaller:
            return tr(self.smaller)
        return tr("Close other programs and try again.")
