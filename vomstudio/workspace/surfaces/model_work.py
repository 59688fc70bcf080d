"""Work on an open model: a job, whose result is then read in a thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar

from vomstudio.core.findings import Finding, Message, finding_of
from vomstudio.document.edit import Edit
from vomstudio.document.records import Model
from vomstudio.errors import VomError
from vomstudio.jobs.events import Failed
from vomstudio.jobs.standing_model import StandingModel
from vomstudio.signals import Signal
from vomstudio.studio.background import Background
from vomstudio.workspace.models import standing_model
from vomstudio.workspace.projects import Projects
from vomstudio.workspace.running_jobs import Jobs, RunningJob

Result = TypeVar("Result")


class ModelWork:
    """One job at a time; a new one replaces it.

    running : the job; said : why there is no result, or a remark on it; changed : emitted
    when either is new
    """

    def __init__(self, projects: Projects, jobs: Jobs, background: Background) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._jobs, self._background = projects, jobs, background
        self.running: RunningJob | None = None
        self.said: Message = ""

    def stop(self) -> None:
        """Stop the job."""
        if self._cancel():
            self._say(Finding("job.stopped"))

    def _cancel(self) -> bool:
        """Return whether there was a job to stop."""
        self._background.cancel_all()
        job, self.running = self.running, None
        if job is not None:
            self._jobs.cancel(job)
        return job is not None

    def _model(self, model_id: str) -> tuple[StandingModel, Model] | None:
        """Return a model as jobs need it, and its record; None if its file is missing."""
        standing, record = standing_model(self._projects, model_id), None
        if standing is not None:
            record = self._projects.records.get(model_id)
        if standing is None or not isinstance(record, Model):
            self._say(Finding("model.file-missing", model=self._projects.name_of(model_id)))
            return None
        return standing, record

    def _submit(
        self,
        job: Any,
        order: Any,
        title: str,
        then: Callable[[Any], None],
        *,
        quiet: bool = False,
    ) -> None:
        def done(result: Any) -> None:
            if self.running is begun:
                then(result)

        def failed(event: Failed) -> None:
            if self.running is begun:
                self.running = None
                stopped = event.cancelled
                self._say(Finding("job.stopped") if stopped else finding_of(event.to_error()))

        begun = self._jobs.submit(
            job, order, title=title, on_done=done, on_failed=failed, quiet=quiet
        )
        self.running, self.said = begun, ""
        self.changed.emit()

    def _read(self, work: Callable[[], Result], show: Callable[[Result], None]) -> None:
        """Read or compute many megabytes in a thread, and end the job with that."""

        def end(result: Result) -> None:
            self.running = None
            show(result)

        def refuse(_: VomError) -> None:
            self.running = None
            self._say(Finding("cache.unreadable"))

        self._background.run(work, end, refuse, expected=(OSError, ValueError, KeyError))

    def _say(self, said: Message) -> None:
        self.said = said
        self.changed.emit()


class ProposalsOnModel(Protocol):
    """What was proposed on a model, as it was then."""

    @property
    def model_id(self) -> str: ...

    @property
    def to_world(self) -> object: ...


Found = TypeVar("Found", bound=ProposalsOnModel)


class ProposalQueue(ModelWork, Generic[Found]):
    """Proposals on a model; the project changes only if some are accepted.

    found : the proposals; None if there are none
    """

    def __init__(self, projects: Projects, jobs: Jobs, background: Background) -> None:
        super().__init__(projects, jobs, background)
        self.found: Found | None = None

    def drop(self, why: Message = "") -> None:
        """Forget what was proposed. why : shown instead"""
        self._cancel()
        self._forget()
        self.found = None
        self._say(why)

    def _forget(self) -> None:
        """Forget what was decided upon the proposals."""
        raise NotImplementedError

    def edited(self, edit: Edit) -> None:
        """Drop the proposals if the model is gone or was placed anew."""
        found = self.found
        if found is None:
            return
        now = self._projects.records.get(found.model_id)
        if not isinstance(now, Model):
            self.drop()
        elif now.to_world != found.to_world:
            self.drop(Finding("model.placed-anew"))
        else:
            self._follow(edit)

    def _follow(self, edit: Edit) -> None:
        """Open again what was accepted and is undone, and the other way round."""
        raise NotImplementedError
