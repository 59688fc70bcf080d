"""Edge detection by a user's network, in a worker process as the file is not trusted."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from vomstudio.core.progress import CancelToken, Progress
from vomstudio.extraction.proposals.edge_pictures import EdgeDetector
from vomstudio.studio.jobs.proposal_tasks import FIND_EDGES, EdgesRequest
from vomstudio.studio.jobs.run_job import run_job


@contextmanager
def open_edge_finder(
    network: str | None, progress: Progress, cancel: CancelToken | None = None
) -> Iterator[tuple[EdgeDetector, Path] | None]:
    """Yield the edge finder of a network and a temporary folder for pictures.

    Parameters
    ----------
    network : str, optional
        File of the network. If None, None is yielded.
    progress : Progress
        Receives the steps of the search.
    cancel : CancelToken, optional
        Stops the search.
    """
    if network is None:
        yield None
        return
    file = Path(network).resolve()

    def find(pictures: Sequence[Path], folder: Path) -> Sequence[Path]:
        order = EdgesRequest(file, tuple(path.resolve() for path in pictures), folder)
        return run_job(FIND_EDGES, order, progress, cancel).pictures

    with tempfile.TemporaryDirectory(prefix="vomstudio-edges-") as name:
        yield find, Path(name)
