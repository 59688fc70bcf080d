"""Edges found by a network of the user's, in a worker: its file is a stranger's."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.errors import UsageError
from vomstudio.extraction.proposals.edge_pictures import ONNX, Find
from vomstudio.jobs.proposal_tasks import FIND_EDGES, EdgesOrder
from vomstudio.jobs.run_job import run_job
from vomstudio.progress import CancelToken, Progress


@contextmanager
def edges_by(
    network: str | Path, progress: Progress, cancel: CancelToken | None = None
) -> Iterator[tuple[Find, Path]]:
    """What finds edges in pictures, and a folder for these that goes with the block."""
    file = Path(network).resolve()

    def find(pictures: Sequence[Path], folder: Path) -> Sequence[Path]:
        order = EdgesOrder(file, tuple(path.resolve() for path in pictures), folder)
        return run_job(FIND_EDGES, order, progress, cancel).pictures

    with tempfile.TemporaryDirectory(prefix="vomstudio-edges-") as name:
        yield find, Path(name)


@contextmanager
def asked_of(
    cost: str,
    network: str | Path | None,
    progress: Progress,
    cancel: CancelToken | None = None,
) -> Iterator[tuple[Find, Path] | None]:
    """As `edges_by`, and None where no network is asked for. Raises UsageError for a cost that
    needs one, and for one with another cost."""
    if network is not None and cost != ONNX:
        raise UsageError(Finding("edges.network-unused"), field="onnx_model")
    if network is None:
        if cost == ONNX:
            raise UsageError(Finding("edges.no-network"), field="onnx_model")
        yield None
        return
    with edges_by(network, progress, cancel) as edges:
        yield edges
