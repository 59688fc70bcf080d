"""Integration into a Linux desktop: menu entry, icon, and file type of project folders.

The module follows the Desktop Entry, Icon Theme and Shared MIME-info specifications of
freedesktop.org and writes to the user's data folder.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from vomstudio.core.errors import TargetError
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.files.regular import read_small_text
from vomstudio.core.findings import Finding
from vomstudio.core.paths import program_command, resource

NAME = "vomstudio"
PROJECT_TYPE = "application/x-vomstudio-project"

_MIME_TYPES_XML = f"""<?xml version="1.0" encoding="UTF-8"?>
<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">
  <mime-type type="{PROJECT_TYPE}">
    <comment>VOM Studio project</comment>
    <sub-class-of type="inode/directory"/>
    <icon name="{NAME}"/>
    <glob pattern="*.vom"/>
  </mime-type>
</mime-info>
"""


def install() -> list[Path]:
    """Write the menu entry, icon and file type for the user, replacing previous ones.

    Returns
    -------
    list of Path
        Paths of the written files.

    Raises
    ------
    TargetError
        If the system is not Linux, or a file cannot be written.
    """
    if not sys.platform.startswith("linux"):
        raise TargetError(Finding("desktop.not-linux"))
    contents = {
        _data_folder() / path: text for path, text in desktop_files(program_command()).items()
    }
    for path, text in contents.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TargetError(
                Finding("output.unwritable", reason=error.strerror), file=path.parent
            ) from error
        with atomic_write(path, force=True) as temporary_path:
            temporary_path.write_text(text, encoding="utf-8")
    _refresh_indexes()
    return list(contents)


def uninstall() -> list[Path]:
    """Remove the files written by `install`.

    Returns
    -------
    list of Path
        Paths of the removed files; empty if none were installed.

    Raises
    ------
    TargetError
        If a file cannot be removed.
    """
    removed_paths = []
    for path in _installed_paths():
        try:
            path.unlink()
        except (FileNotFoundError, NotADirectoryError):
            continue
        except OSError as error:
            raise TargetError(
                Finding("file.not-removed", reason=error.strerror), file=path
            ) from error
        removed_paths.append(path)
    if removed_paths:
        _refresh_indexes()
    return removed_paths


def _data_folder() -> Path:
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")


def _installed_paths() -> list[Path]:
    return [_data_folder() / path for path in desktop_files(program_command())]


def _refresh_indexes() -> None:
    """Update the indexes of desktops that use them; other desktops read the files directly."""
    data = _data_folder()
    for command in (
        ["update-desktop-database", str(data / "applications")],
        ["update-mime-database", str(data / "mime")],
    ):
        if shutil.which(command[0]):
            subprocess.run(command, capture_output=True, check=False, timeout=60)


def desktop_files(command: Sequence[str]) -> dict[Path, str]:
    """Return the files of the menu entry, the icon and the type of project folders.

    Parameters
    ----------
    command
        Program and arguments that the entry starts. The path of the program is absolute because
        the PATH of the desktop is unknown.

    Returns
    -------
    dict
        Text of each file by path relative to a shared data folder such as ``~/.local/share``.
    """
    return {
        Path("applications", f"{NAME}.desktop"): _desktop_entry(command),
        Path("icons", "hicolor", "scalable", "apps", f"{NAME}.svg"): read_small_text(
            resource("icon", f"{NAME}.svg")
        ),
        Path("mime", "packages", f"{NAME}.xml"): _MIME_TYPES_XML,
    }


def _desktop_entry(command: Sequence[str]) -> str:
    program, *arguments = command
    return "\n".join(
        [
            "[Desktop Entry]",
            "Type=Application",
            "Name=VOM Studio",
            "GenericName=Virtual outcrop models",
            "Comment=Measure geology on virtual outcrop models",
            f"Exec={' '.join([_quote(program), *arguments])} %F",
            f"Icon={NAME}",
            "Terminal=false",
            "Categories=Science;Geology;Geoscience;",
            f"MimeType={PROJECT_TYPE};model/obj;model/gltf-binary;application/x-ply;model/stl;",
            f"StartupWMClass={NAME}",
            "",
        ]
    )


def _quote(word: str) -> str:
    """Quote an argument of the `Exec` key.

    In double quotes, special characters are escaped by a backslash and % is doubled. Then all
    backslashes are doubled because the result is the value of a key.
    """
    escaped_text = "".join(f"\\{c}" if c in '"`$\\' else c for c in word).replace("%", "%%")
    return '"' + escaped_text.replace("\\", "\\\\") + '"'
