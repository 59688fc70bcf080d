"""What a worker is asked before a reconstruction: a video's frames, and what will be needed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vomstudio.progress import Progress


def take_frames(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write the frames of the file `video` that are worth using into the folder `out`, `fps` of a
    second; force: among other files."""
    from vomstudio.survey.video import take_frames as take

    return take(
        args["video"], args["out"], fps=args["fps"], force=args["force"], progress=progress
    ).as_dict()


def foresee(args: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """What a reconstruction of the folder `photos` with these settings will need and use; sizes:
    width and height of the photos, which whoever asks has read already.

    memory: see `MemoryNeed`, None without photos. control: see `ControlCheck`, None without control
    points; where a file cannot be read its `problem` says so.
    """
    from vomstudio.errors import VomError
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.base.settings import Settings
    from vomstudio.photogrammetry.pipeline.memory_needs import memory_need

    settings = Settings(quality=args["quality"], threads=args["threads"])
    sizes = [(int(width), int(height)) for width, height in args["sizes"]]
    memory = memory_need(settings, sizes).as_dict() if sizes else None
    control = None
    if args["control"] is not None:
        photos = read_photos(args["photos"], progress).photos
        try:
            control = _control(Path(args["control"]), args["marks"], args["crs"], photos)
        except VomError as error:
            control = {"points": [], "summary": "", "warnings": [], "crs": args["crs"],
                       "crs_reason": "", "problem": str(error)}  # fmt: skip
    return {"memory": memory, "control": control}


def _control(path: Path, marks: str | None, crs: str | None, photos: Any) -> dict[str, Any]:
    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_beside,
        read_control,
        read_marks,
    )
    from vomstudio.photogrammetry.place.control_check import check_control

    points = read_control(path)
    placed = agreed_crs(path, crs)
    reason = "as chosen" if crs is not None else f"stated in {path.name}"
    seen = read_marks(marks_beside(path) if marks is None else marks)
    return check_control(points, seen, photos, placed, reason).as_dict()


TASKS = {"take_frames": take_frames, "foresee": foresee}
