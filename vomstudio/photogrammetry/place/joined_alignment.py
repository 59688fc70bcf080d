"""The stage in which disconnected components of an alignment are joined by markers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace

import numpy as np

from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align import mapping
from vomstudio.photogrammetry.align.alignment import Alignment
from vomstudio.photogrammetry.base.checkpoints import Stage
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.component_joining import JoinReport, Junction, join_components
from vomstudio.progress import Progress
from vomstudio.words import tr


def join_alignment(
    alignment: Alignment,
    stage: Callable[[], Stage],
    control: Sequence[ControlPoint],
    marks: Sequence[Mark],
    threads: int | None,
    progress: Progress,
) -> tuple[Alignment, Stage | None, tuple[str, ...]]:
    """(the alignment with joined parts, the stage in which it was done, what was done in words).

    stage : makes the stage; it is asked only where there is something to join
    Raises Cancelled.
    """
    if not marks or len(alignment.parts) < 2:
        return alignment, None, ()
    work = stage()
    if not work.done:
        progress.stage(tr("Joining components"))
        parts, report = join_components(
            alignment.parts, marks, control, threads=threads or -1, progress=progress
        )
        for number, part in enumerate(parts):
            (work.folder / f"part{number}").mkdir(exist_ok=True)
            part.save(work.folder / f"part{number}")
        work.finish(parts=len(parts), said=list(_said(report)), report=asdict(report))
    facts = work.facts
    parts = tuple(SparseScene.load(work.folder / f"part{k}") for k in range(facts["parts"]))
    return _with_parts(alignment, parts), work, tuple(facts["said"])


def _with_parts(alignment: Alignment, parts: tuple[SparseScene, ...]) -> Alignment:
    lengths = np.linalg.norm(mapping.residuals(parts[0]), axis=1)
    return replace(
        alignment,
        parts=parts,
        reprojection_error_px=float(np.nanmean(lengths)) if len(lengths) else float("nan"),
        tie_points=int((parts[0].track_lengths >= 3).sum()),
    )


def _said(report: JoinReport) -> Iterator[str]:
    for junction in report.joined:
        yield _joined(junction)
        yield from map(str, junction.warnings)
    yield from report.not_joined


def _joined(junction: Junction) -> str:
    one, other = junction.photos
    if junction.rotation_error_deg is None or junction.rms_px is None:
        return tr(
            "Components of {one} and {other} photos were joined by their control points.",
            one=one,
            other=other,
        )
    return tr(
        "Components of {one} and {other} photos were joined by {count} markers with a residual of "
        "{rms:.1f} px (rms). The rotation between them is uncertain by {angle:.2f}°.",
        one=one,
        other=other,
        count=sum(marker.used for marker in junction.markers),
        rms=junction.rms_px,
        angle=max(junction.rotation_error_deg),
    )
