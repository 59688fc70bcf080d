"""The bundle as one file that runs: a shell script, then a squashfs file system."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

# The script is padded to it. Kernels mount at multiples of 512, some only of 4096.
OFFSET = 8192
_HEADER = Path(__file__).with_name("image_header.sh")


def header(*, name: str, version: str, python: str, digest: str) -> bytes:
    """Return the script at the start of an image, padded to `OFFSET`.

    Parameters
    ----------
    name
        Name of the image's file.
    version
        Version of the program.
    python
        Name of the interpreter in the bundle.
    digest
        Identifies the file system: images of other content are not mixed up in the user's cache.
    """
    text = _HEADER.read_text(encoding="utf-8")
    values = {"NAME": name, "VERSION": version, "PYTHON": python, "DIGEST": digest}
    for key, value in {**values, "OFFSET": str(OFFSET)}.items():
        text = text.replace(f"@{key}@", value)
    # The shell stops reading here.
    script = text.encode() + b"exit 1\n"
    assert len(script) <= OFFSET
    return script.ljust(OFFSET, b"\n")


def write_image(tree: Path, target: Path, *, version: str, python: str, work: Path) -> None:
    """Write an image that runs.

    Parameters
    ----------
    tree
        Folder of the bundle.
    target
        The new file.
    version, python
        As for `header`.
    work
        Folder for temporary files.
    """
    plain = work / "bundle.squashfs"
    subprocess.run(
        [
            "mksquashfs",
            str(tree),
            str(plain),
            "-noappend",
            "-all-root",
            "-no-progress",
            "-quiet",
            "-comp",
            "zstd",
            "-Xcompression-level",
            "12",
            "-b",
            "256K",
            "-processors",
            "1",
        ],
        check=True,
    )
    with plain.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()[:16]
    part = work / target.name
    with plain.open("rb") as source, part.open("wb") as file:
        file.write(header(name=target.name, version=version, python=python, digest=digest))
        shutil.copyfileobj(source, file, 1 << 20)
    plain.unlink()
    part.chmod(0o755)
    shutil.move(part, target)
