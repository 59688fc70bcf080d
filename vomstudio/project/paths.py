"""Names in a project folder, importable without the project's libraries."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.files.regular import is_regular_file

PROJECT_SUFFIX = ".vom"
JOURNAL_NAME = "journal.sqlite"


def is_project(path: Path) -> bool:
    """Return whether a path is a project folder or a file in one."""
    return is_regular_file(path / JOURNAL_NAME) or (
        is_regular_file(path) and path.parent.suffix == PROJECT_SUFFIX
    )
