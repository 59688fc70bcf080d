"""Jobs on an open model, whose results are read in a worker thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.signals import Signal
from vomstudio.project.edit import Edit
from vomstudio.project.records import Model
from vomstudio.studio.background import Background
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.placed_model import PlacedModel
from vomstudio.studio.models import find_placed_model
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs, RunningJob

Result = TypeVar("Result")


class ModelWork:
    """Base class for jobs on an open model. A new job replaces the running one.

    Parameters
    ----------
    projects : Projects
    jobs : Jobs
    background : Background
        Background that runs the functions reading the results.

    Attributes
    ----------
    running : RunningJob or None
        Current job, or None.
    findings : tuple of Finding
        Reasons why the job failed or was stopped, or warnings about its result.
    changed : Signal
        Emitted when `running` or `findings` changes.
    """

    def __init__(self, projects: Projects, jobs: Jobs, background: Background) -> None:
        self.changed: Signal[()] = Signal()
        self._projects, self._jobs, self._background = projects, jobs, background
        self.running: RunningJob | None = None
        self.findings: tuple[Finding, ...] = ()

    def stop(self) -> None:
        """Stop the current job and report that it was stopped."""
        if self._cancel():
            self._report(Finding("job.stopped"))

    def _cancel(self) -> bool:
        """Cancel the current job, and return whether one was running."""
        self._background.cancel_all()
        job, self.running = self.running, None
        if job is not None:
            self._jobs.cancel(job)
        return job is not None

    def _model(self, model_id: str) -> tuple[PlacedModel, Model] | None:
        """Return a model as input for jobs, with its record.

        If the file is missing, a message is set and None is returned.
        """
        placed_model, record = find_placed_model(self._projects, model_id), None
        if placed_model is not None:
            record = self._projects.records.get(model_id)
        if placed_model is None or not isinstance(record, Model):
            self._report(Finding("model.file-missing", model=self._projects.get_name(model_id)))
            return None
        return placed_model, record

    def _submit(
        self,
        job: Any,
        order: Any,
        title: str,
        finished_callback: Callable[[Any], None],
        *,
        is_quiet: bool = False,
    ) -> None:
        def handle_result(result: Any) -> None:
            if self.running is running_job:
                finished_callback(result)

        def handle_failure(event: Failed) -> None:
            if self.running is running_job:
                self.running = None
                was_stopped = event.cancelled
                self._report(
                    Finding("job.stopped") if was_stopped else to_finding(event.to_error())
                )

        running_job = self._jobs.submit(
            job,
            order,
            title=title,
            on_done=handle_result,
            on_failed=handle_failure,
            is_quiet=is_quiet,
        )
        self.running, self.findings = running_job, ()
        self.changed.emit()

    def _read_in_background(
        self, work: Callable[[], Result], show: Callable[[Result], None]
    ) -> None:
        """Run `work` in a worker thread, then end the job and pass the result to `show`."""

        def end(result: Result) -> None:
            self.running = None
            show(result)

        def fail(_: VomError) -> None:
            self.running = None
            self._report(Finding("cache.unreadable"))

        self._background.run(work, end, fail, expected=(OSError, ValueError, KeyError))

    def _report(self, *findings: Finding) -> None:
        self.findings = findings
        self.changed.emit()


class ModelProposals(Protocol):
    """Protocol of proposals on a model, with its placement at the time of the search."""

    @property
    def model_id(self) -> str: ...

    @property
    def to_world(self) -> object: ...


ProposalsT = TypeVar("ProposalsT", bound=ModelProposals)


class ProposalQueue(ModelWork, Generic[ProposalsT]):
    """Job that proposes features, which change the project only when accepted.

    Attributes
    ----------
    proposals : ProposalsT or None
        Current proposals; None before the first job and after `drop`.
    """

    def __init__(self, projects: Projects, jobs: Jobs, background: Background) -> None:
        super().__init__(projects, jobs, background)
        self.proposals: ProposalsT | None = None

    def drop(self, *reasons: Finding) -> None:
        """Discard all proposals and report the reasons."""
        self._cancel()
        self._forget()
        self.proposals = None
        self._report(*reasons)

    def _forget(self) -> None:
        """Clear the decisions about the proposals."""
        raise NotImplementedError

    def follow_edit(self, edit: Edit) -> None:
        """Discard the proposals if an edit removed or moved the model, or else update them."""
        proposals = self.proposals
        if proposals is None:
            return
        model = self._projects.records.get(proposals.model_id)
        if not isinstance(model, Model):
            self.drop()
        elif model.to_world != proposals.to_world:
            self.drop(Finding("model.placed-anew"))
        else:
            self._update_open(edit)

    def _update_open(self, edit: Edit) -> None:
        """Reopen accepted proposals whose features an edit removed; close restored ones."""
        raise NotImplementedError
