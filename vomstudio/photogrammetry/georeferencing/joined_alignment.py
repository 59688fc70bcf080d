"""Stage that joins disconnected components of an alignment by markers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace

import numpy as np

from vomstudio.core.findings import Finding, to_json_list
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align import mapping
from vomstudio.photogrammetry.align.alignment import Alignment
from vomstudio.photogrammetry.base.checkpoints import StageFolder
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.component_joining import (
    JoinReport,
    Junction,
    join_components,
)


def join_alignment(
    alignment: Alignment,
    stage: Callable[[], StageFolder],
    control: Sequence[ControlPoint],
    marks: Sequence[Mark],
    threads: int | None,
    progress: Progress,
) -> tuple[Alignment, StageFolder | None, tuple[Finding, ...]]:
    """Join the components of an alignment.

    Returns the alignment with joined parts, the folder of the joining stage (None if there are no
    marks or only one part), and findings. Raises Cancelled.

    stage : creates the folder of the stage; called only if there are parts to join
    """
    if not marks or len(alignment.parts) < 2:
        return alignment, None, ()
    stage_folder = stage()
    if not stage_folder.is_done:
        progress.stage(tr("Joining components"))
        parts, report = join_components(
            alignment.parts, marks, control, threads=threads or -1, progress=progress
        )
        for number, part in enumerate(parts):
            (stage_folder.folder / f"part{number}").mkdir(exist_ok=True)
            part.save(stage_folder.folder / f"part{number}")
        stage_folder.finish(
            parts=len(parts), findings=to_json_list(_report_findings(report)), report=asdict(report)
        )
    facts = stage_folder.facts
    parts = tuple(SparseScene.load(stage_folder.folder / f"part{k}") for k in range(facts["parts"]))
    return (
        _replace_parts(alignment, parts),
        stage_folder,
        tuple(map(Finding.from_dict, facts["findings"])),
    )


def _replace_parts(alignment: Alignment, parts: tuple[SparseScene, ...]) -> Alignment:
    lengths = np.linalg.norm(mapping.residuals(parts[0]), axis=1)
    return replace(
        alignment,
        parts=parts,
        reprojection_error_px=float(np.nanmean(lengths)) if len(lengths) else float("nan"),
        tie_point_count=int((parts[0].track_lengths >= 3).sum()),
    )


def _report_findings(report: JoinReport) -> Iterator[Finding]:
    for junction in report.joined:
        yield _junction_finding(junction)
        yield from junction.warnings
    yield from report.not_joined


def _junction_finding(junction: Junction) -> Finding:
    first_count, second_count = junction.photos
    if junction.rotation_error_deg is None or junction.rms_px is None:
        return Finding("join.by-control", one=first_count, other=second_count)
    return Finding(
        "join.by-markers",
        one=first_count,
        other=second_count,
        markers=sum(marker.used for marker in junction.markers),
        rms_px=junction.rms_px,
        rotation_deg=max(junction.rotation_error_deg),
    )
