"""A reconstruction as it is asked for: words checked, tables found."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.errors import InputError, UsageError
from vomstudio.files.inside import check_in_project
from vomstudio.io.control.control_files import find_control, marks_beside
from vomstudio.io.control.points import MARKS
from vomstudio.io.gis.crs import typed_crs
from vomstudio.io.photos.reading import photo_names
from vomstudio.jobs.reconstruction_tasks import ReconstructionOrder

QUALITIES = ("preview", "low", "medium", "high")
DEVICES = ("auto", "cpu", "cuda")
NO_CONTROL = "none"
_MOST_THREADS = 4096
_MOST_SEED = 2**31 - 1


def order_reconstruction(
    photos: str | Path,
    output: str | Path,
    *,
    quality: str = "medium",
    control: str | Path | None = None,
    marks: str | Path | None = None,
    crs: str | None = None,
    scheduler: str | None = None,
    threads: int | None = None,
    seed: int = 0,
    device: str = "auto",
    region: Sequence[float] | None = None,
) -> tuple[ReconstructionOrder, list[Finding]]:
    """Return the order, and findings about tables beside the photos that are not used.

    control : table of control points, "none" to do without; None for `control.csv` in or beside the
    folder of the photos, where enough of its points are marked. marks : None for those beside it.
    region : x0, y0, z0, x1, y1, z1 in the frame of the model, of which alone a model is made
    Raises InputError, UsageError.
    """
    from vomstudio.photogrammetry.base.region import Region

    folder, out = Path(photos), Path(output)
    if not folder.is_dir():
        raise InputError(Finding("folder.not-of-photos"), file=folder)
    if quality not in QUALITIES:
        raise UsageError(
            Finding("option.not-a-choice", value=quality, choices=list(QUALITIES)),
            field="--quality",
        )
    if device not in DEVICES:
        raise UsageError(
            Finding("option.not-a-choice", value=device, choices=list(DEVICES)), field="--device"
        )
    if threads is not None and not 1 <= threads <= _MOST_THREADS:
        raise UsageError(
            Finding("option.out-of-range", value=threads, minimum=1, maximum=_MOST_THREADS),
            field="--threads",
        )
    if not 0 <= seed <= _MOST_SEED:
        raise UsageError(
            Finding("option.out-of-range", value=seed, minimum=0, maximum=_MOST_SEED),
            field="--seed",
        )
    check_in_project(out)
    if out.resolve() == folder.resolve():
        raise UsageError(
            Finding("folder.of-photos"),
            field="--output",
        )
    box = None if region is None else tuple(float(v) for v in region)
    Region.of(box)
    name = None if crs is None else _crs(crs)
    points, seen, said = _tables(folder, control, marks)
    order = ReconstructionOrder(
        folder.resolve(), out.resolve(), quality, name, points, seen, threads, seed, scheduler,
        device=device, region=box,
    )  # fmt: skip
    return order, said


def _crs(text: str) -> str:
    crs, metres = typed_crs(text)
    if metres != 1.0:
        raise UsageError(
            Finding("frame.not-in-metres", crs=crs),
            field="--crs",
        )
    return crs


def _tables(
    photos: Path, gcp: str | Path | None, given_marks: str | Path | None
) -> tuple[Path | None, Path | None, list[Finding]]:
    """Tables of control points and of marks, and what there is to say about them."""
    from vomstudio.photogrammetry.place.mark_prediction import usable_tables

    named = None if given_marks is None else Path(given_marks).resolve()
    photos = photos.resolve()
    with_photos = photos / MARKS
    if gcp is None or str(gcp).casefold() == NO_CONTROL:
        found, marks = find_control(photos) or (
            None,
            with_photos if with_photos.is_file() else None,
        )
        marks = named or marks
        _require_file(marks, "--marks")
        if gcp is not None:
            return None, marks, []
        names = [] if found is None else photo_names(photos)
        control, marks, why_not = usable_tables(found, marks, names)
        reasons = [
            Finding(
                "reconstruct.tables-unused", file=found, reason=each.message, reason_code=each.code
            )
            for each in why_not
        ]
        return control, marks, reasons
    control = Path(gcp).resolve()
    marks = named
    _require_file(control, "--gcp")
    if marks is None and with_photos.is_file() and not marks_beside(control).is_file():
        marks = with_photos
    if marks is None and not (marks := marks_beside(control)).is_file():
        raise InputError(
            Finding("control.marks-missing"),
            file=marks,
            field="--marks",
        )
    _require_file(marks, "--marks")
    return control, marks, []


def _require_file(path: Path | None, field: str) -> None:
    if path is not None and not path.is_file():
        raise InputError(Finding("file.missing"), file=path, field=field)
