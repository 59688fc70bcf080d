"""Where the stages of a reconstruction have left their results."""

from __future__ import annotations

import re
from pathlib import Path

WORK = "work"


def stage_folder(out: Path, name: str) -> Path | None:
    """The newest whole folder of a stage of the reconstruction in `out`; None where it is not
    finished. A run sweeps those of other settings away at its end only."""
    whole = re.compile(rf"{re.escape(name)}-[0-9a-f]+")
    found = []
    try:
        for path in (out / WORK).iterdir():
            if whole.fullmatch(path.name) and path.is_dir():
                found.append((path.stat().st_mtime_ns, path))
    except OSError:
        return None
    return max(found)[1] if found else None


def is_aligned(out: Path) -> bool:
    """Whether the photos of the reconstruction in `out` have been aligned and placed."""
    return stage_folder(out, "frame") is not None
