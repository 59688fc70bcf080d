"""Install packages into the environment of this interpreter, with progress and clear failures.

    python _install.py packages LOG LOCK...   those entries of the lock files that are missing
    python _install.py project LOG FOLDER     the project itself, in place

Used by _setup.sh; needs nothing but pip, whose complete output goes to LOG. A terminal shows one
updating line, a file or pipe a line now and then. A failure is one sentence with its remedy, exit
code 1. Started again, it continues: packages are installed in small groups, and complete ones are
not installed again.
"""

from __future__ import annotations

import contextlib
import csv
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import distributions
from pathlib import Path

GROUP_SIZE = 5
"""Packages per call of pip: an interruption costs at most these."""
LINE_INTERVAL_S = 10.0
"""Time between two lines of progress if no terminal shows them."""
SITE_PACKAGES = Path(sysconfig.get_path("purelib"))

FULL_DISK = r"No space left on device|Disk quota exceeded|not enough space on the disk"
REMEDIES = (
    (
        FULL_DISK,
        "The disk is full ({free}). Free some space, then run this again; it continues.",
    ),
    (
        r"DO NOT MATCH THE HASHES",
        "The downloaded file of {package} has a wrong checksum. Run this again; if it fails again,"
        " check the proxy or package mirror.",
    ),
    (
        r"SSLError|CERTIFICATE_VERIFY_FAILED",
        "Cannot download {package}: the certificate of the package index is not valid. Check clock"
        " and proxy, or name your certificates in PIP_CERT, then run this again.",
    ),
    (
        r"NewConnectionError|ConnectTimeout|Read ?[Tt]imed? ?out|NameResolutionError"
        r"|Temporary failure in name resolution|Connection (refused|reset|broken|aborted)"
        r"|Network is unreachable|ProxyError|Max retries exceeded|IncompleteRead",
        "Cannot download {package}: no connection to the package index. Check network and proxy,"
        " then run this again; it continues.",
    ),
    (
        r"Permission denied|Read-only file system|Operation not permitted",
        "Cannot write to {folder}. Make it writable or copy the project elsewhere, then run this"
        " again.",
    ),
    (
        r"No matching distribution found|Could not find a version",
        "No file of {package} fits Python {python} on this system. Name another Python (3.11 to"
        " 3.14): VOMSTUDIO_PYTHON=/path/to/python",
    ),
)
"""What pip prints and what to report, in order of precedence."""


class InstallationError(Exception):
    """One sentence for the user."""


@dataclass(frozen=True)
class Pin:
    """A package of a lock file: its canonical name, its version and the text of its entry."""

    name: str
    version: str
    text: str


def canonical(name: str) -> str:
    """Return the name of a package as package indexes compare it (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


def entries(lock: str) -> Iterator[Pin]:
    """Yield the entries of a lock file that are meant for this interpreter and system."""
    from pip._vendor.packaging.markers import Marker

    for text in lock.replace("\\\n", "\\\r").split("\n"):
        match = re.match(r"([\w.-]+)==([^\s;\\]+)\s*(?:;([^\\\r]*))?", text)
        if match is None:
            continue
        name, version, marker = match.groups()
        if marker is None or Marker(marker.strip()).evaluate():
            yield Pin(canonical(name), version, text.replace("\r", "\n"))


def pins_of(locks: Iterable[Path]) -> list[Pin]:
    """Return the entries of all lock files.

    setuptools is first: packages without a wheel are built with this version of it.
    """
    pins = {pin.name: pin for lock in locks for pin in entries(lock.read_text("utf-8"))}
    return sorted(pins.values(), key=lambda pin: pin.name != "setuptools")


# --- state of the environment ---------------------------------------------------------------------


def installed_versions() -> dict[str, str]:
    """Return the versions of the installed packages.

    The remains of an interrupted installation are removed: pip writes the list of a package's files
    last and can neither replace nor remove a package without it.
    """
    for remains in SITE_PACKAGES.glob("~*"):
        shutil.rmtree(remains, ignore_errors=True)
    for metadata in SITE_PACKAGES.glob("*.dist-info"):
        if not is_complete(metadata):
            shutil.rmtree(metadata)
    found = distributions(path=[str(SITE_PACKAGES)])
    return {canonical(package.metadata["Name"]): package.version for package in found}


def is_complete(metadata: Path) -> bool:
    """Return whether all files of an installed package exist in their full size."""
    try:
        rows = list(csv.reader((metadata / "RECORD").read_text("utf-8").splitlines()))
        # Python writes and removes bytecode as it likes.
        files = [(SITE_PACKAGES / row[0], row[2]) for row in rows if not row[0].endswith(".pyc")]
        sizes = [(path.stat().st_size, size) for path, size in files]
    except (OSError, IndexError):
        return False
    return bool(rows) and all(size in ("", str(actual)) for actual, size in sizes)


def abandoned(pins: Sequence[Pin], stamps: Iterable[Path]) -> set[str]:
    """Return the packages that an earlier installation locked and these pins do not contain.

    Two packages may contain the same module (open3d and open3d-cpu), so the former must go.
    """
    former = {pin.name for stamp in stamps for pin in entries(stamp.read_text("utf-8"))}
    return former - {pin.name for pin in pins}


# --- progress -------------------------------------------------------------------------------------


class ProgressLine:
    """A line that is replaced on a terminal; elsewhere at most one line per interval."""

    def __init__(self) -> None:
        self._is_terminal = sys.stderr.isatty()
        self._next_s = 0.0

    def show(self, text: str) -> None:
        """Replace the line."""
        if self._is_terminal:
            width = shutil.get_terminal_size().columns - 1
            print(f"\r\033[K{text[:width]}", end="", file=sys.stderr, flush=True)
        elif time.monotonic() >= self._next_s:
            self._next_s = time.monotonic() + LINE_INTERVAL_S
            print(text, file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Remove the line from a terminal."""
        if self._is_terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


# --- pip ------------------------------------------------------------------------------------------


def run_pip(words: Sequence[str], log: Path, on_line: Callable[[str], None]) -> str | None:
    """Run pip and append its output to the log. Return the output if pip fails, else None."""
    command = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input", *words]
    output = []
    with (
        log.open("a", encoding="utf-8") as stream,
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
        ) as process,
    ):
        assert process.stdout is not None
        for line in process.stdout:
            output.append(line)
            on_line(line)
            # A full disk must not hide what pip reports about it.
            with contextlib.suppress(OSError):
                stream.write(line)
                stream.flush()
    return "".join(output) if process.returncode else None


def explain(output: str, package: str) -> str:
    """Return one sentence for a failure of pip: what happened and what to do."""
    values = {
        "package": package,
        "folder": SITE_PACKAGES,
        "free": _free_space(),
        "python": ".".join(map(str, sys.version_info[:2])),
    }
    for pattern, sentence in REMEDIES:
        if re.search(pattern, output):
            return sentence.format(**values)
    errors = re.findall(r"^\s*(?:ERROR: |error: |\w*Error: )(.+)", output, re.MULTILINE)
    reason = errors[-1].strip().rstrip(".") if errors else "pip failed"
    return f"Cannot install {package}: {reason}. Run this again; it continues."


def _free_space() -> str:
    """Return the free space of the disks that pip writes to."""
    folders = {}
    for folder in (SITE_PACKAGES, Path(tempfile.gettempdir())):
        folders.setdefault(folder.stat().st_dev, folder)
    return ", ".join(
        f"{shutil.disk_usage(folder).free / 1e6:.0f} MB left in {folder}"
        for folder in folders.values()
    )


def install_packages(log: Path, locks: Sequence[Path]) -> None:
    """Install what is missing of the lock files. Raises InstallationError."""
    pins = pins_of(locks)
    installed = installed_versions()
    stamps = list(Path(sys.prefix).glob("installed-from-*"))
    if len(stamps) > 1:
        # The tests' packages stay when the program is installed again.
        locks = [*locks, *Path(__file__).parent.glob("requirements*.lock")]
    former = abandoned(pins_of(locks), stamps) & set(installed)
    if former:
        _run(["uninstall", "--yes", *sorted(former)], log, lambda: "packages", lambda _: None)
    missing = [pin for pin in pins if installed.get(pin.name) != pin.version]
    done = len(pins) - len(missing)
    line = ProgressLine()
    try:
        for start in range(0, len(missing), GROUP_SIZE):
            group = missing[start : start + GROUP_SIZE]
            _install_group(group, log, line, done + start, len(pins))
    finally:
        line.clear()


def _install_group(
    group: Sequence[Pin], log: Path, line: ProgressLine, done: int, count: int
) -> None:
    requirements = Path(sys.prefix) / "group.txt"
    # pip reports the line of an entry, whatever the file is called that it installs.
    rows = [index for index, pin in enumerate(group) for _ in pin.text.splitlines()]
    requirements.write_text("".join(f"{pin.text}\n" for pin in group), "utf-8")
    package = group[0].name

    def on_line(text: str) -> None:
        nonlocal package
        match = re.search(r"\(from -r .*\(line (\d+)\)\)", text)
        if match is not None:
            index = rows[int(match[1]) - 1]
            package = group[index].name
            line.show(f"Installing package {done + index + 1} of {count}: {package}")

    words = ["--require-hashes", "--no-deps", "--no-build-isolation", "--use-pep517"]
    _run(
        ["install", "--progress-bar", "off", *words, "--requirement", str(requirements)],
        log,
        lambda: package,
        on_line,
    )
    requirements.unlink()


def install_project(log: Path, folder: Path) -> None:
    """Install the project in place. Raises InstallationError."""
    words = ["--no-deps", "--no-build-isolation", "--editable", str(folder)]
    _run(["install", *words], log, lambda: "VOM Studio", lambda _: None)


def _run(
    words: Sequence[str], log: Path, package: Callable[[], str], on_line: Callable[[str], None]
) -> None:
    output = run_pip(words, log, on_line)
    if output is not None:
        raise InstallationError(explain(output, package()))


def main() -> int:
    """Run one of the two commands and report its failure."""
    command, log, *paths = sys.argv[1:]
    try:
        if command == "packages":
            install_packages(Path(log), [Path(path) for path in paths])
        else:
            install_project(Path(log), Path(paths[0]))
    except InstallationError as error:
        print(error, file=sys.stderr)
        print(f"The complete output of pip: {log}", file=sys.stderr)
        return 1
    except OSError as error:
        print(explain(f"OSError: {error}", "the packages"), file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        # The script that started this receives the same signal and reports it.
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
